/* SPDX-License-Identifier: MIT
 *
 * Numbers side by side in the lanes of a vector register, whatever registers the machine has. */
#ifndef MRTS_LANE_TYPES_H
#define MRTS_LANE_TYPES_H

#include "../numbers.h"

/* Samples at a time. */
#define MRTS_LANES 4
typedef double mrts_lanes __attribute__((vector_size(8 * MRTS_LANES), aligned(8)));
typedef long long mrts_lane_mask __attribute__((vector_size(8 * MRTS_LANES), aligned(8)));
#pragma GCC diagnostic ignored "-Wpsabi" /* between functions of ours only, of the same target */

#define MRTS_EVERY_LANE ((mrts_lane_mask){0} - 1)

static inline mrts_lanes mrts_each(double value) { return (mrts_lanes){0} + value; }

static inline mrts_lanes mrts_choose(mrts_lane_mask mask, mrts_lanes a, mrts_lanes b) {
    return (mrts_lanes)((mask & (mrts_lane_mask)a) | (~mask & (mrts_lane_mask)b));
}

static inline int mrts_any(mrts_lane_mask mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }

static inline mrts_lanes mrts_larger_lanes(mrts_lanes a, mrts_lanes b) { return mrts_choose(a > b, a, b); }

static inline double mrts_largest_lane(mrts_lanes a) {
    return mrts_larger(mrts_larger(a[0], a[1]), mrts_larger(a[2], a[3]));
}
static inline double mrts_lane_sum(mrts_lanes a) { return (a[0] + a[1]) + (a[2] + a[3]); }

/* Numbers of an array that stand one after the other. */
static inline mrts_lanes *mrts_lanes_at(const double *a, long long i) { return (mrts_lanes *)(void *)(a + i); }

static inline mrts_lanes mrts_sizes(mrts_lanes a) {
    return (mrts_lanes)((mrts_lane_mask)a & ~(mrts_lane_mask)(-(mrts_lanes){0}));
}

static inline mrts_lanes mrts_roots(mrts_lanes a) {
    return (mrts_lanes){MRTS_SQRT(a[0]), MRTS_SQRT(a[1]), MRTS_SQRT(a[2]), MRTS_SQRT(a[3])};
}

/* One number of each sample, of those of all samples one after the other, `size` each. */
static inline mrts_lanes mrts_term(const double *all, const long long *at, int size, int place) {
    all += place;
    return (mrts_lanes){all[at[0] * size], all[at[1] * size], all[at[2] * size], all[at[3] * size]};
}

static inline void mrts_take_lane(int count, const mrts_lanes *from, int lane, double *to) {
    const double *numbers = (const double *)(const void *)from + lane;
    MRTS_UNROLL
    for (int i = 0; i < count; ++i) to[i] = numbers[i * MRTS_LANES];
}

#define MRTS_IN_LANES
#include "../number_type.inc"
#include "../answers.inc"
#undef MRTS_IN_LANES

#endif

/* SPDX-License-Identifier: MIT
 *
 * Numbers side by side in the lanes of a vector register, whatever registers the machine has.
 */
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

#ifdef __AVX2__
static inline mrts_lane_mask mrts_at_most(mrts_lanes a, mrts_lanes b) { return a <= b; }
static inline mrts_lane_mask mrts_above(mrts_lanes a, mrts_lanes b) { return a > b; }
#else
/* In registers half as wide: gcc compares numbers one by one where there are no registers of all lanes. */
typedef double mrts_half __attribute__((vector_size(16), aligned(8)));
typedef long long mrts_half_mask __attribute__((vector_size(16), aligned(8)));
typedef union {
    mrts_lanes lanes;
    mrts_lane_mask mask;
    mrts_half half[2];
    mrts_half_mask half_mask[2];
} mrts_halves;
#define MRTS_COMPARED(name, relation)                                              \
    static inline mrts_lane_mask name(mrts_lanes a, mrts_lanes b) {                \
        const mrts_halves left = {a}, right = {b};                                 \
        mrts_halves found;                                                         \
        found.half_mask[0] = (mrts_half_mask)(left.half[0] relation right.half[0]); \
        found.half_mask[1] = (mrts_half_mask)(left.half[1] relation right.half[1]); \
        return found.mask;                                                         \
    }
MRTS_COMPARED(mrts_at_most, <=)
MRTS_COMPARED(mrts_above, >)
#undef MRTS_COMPARED
#endif

static inline mrts_lanes mrts_choose(mrts_lane_mask mask, mrts_lanes a, mrts_lanes b) {
    return (mrts_lanes)((mask & (mrts_lane_mask)a) | (~mask & (mrts_lane_mask)b));
}

static inline int mrts_any(mrts_lane_mask mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }

static inline mrts_lanes mrts_larger_lanes(mrts_lanes a, mrts_lanes b) { return mrts_choose(mrts_above(a, b), a, b); }

static inline mrts_lanes mrts_sizes(mrts_lanes a) {
    return (mrts_lanes)((mrts_lane_mask)a & ~(mrts_lane_mask)(-(mrts_lanes){0}));
}

static inline mrts_lanes mrts_roots(mrts_lanes a) {
    return (mrts_lanes){MRTS_SQRT(a[0]), MRTS_SQRT(a[1]), MRTS_SQRT(a[2]), MRTS_SQRT(a[3])};
}

/* One lane of some numbers. */
static inline void mrts_take_lane(int count, const mrts_lanes *from, int lane, double *to) {
    const double *numbers = (const double *)(const void *)from + lane;
    for (int i = 0; i < count; ++i) to[i] = numbers[i * MRTS_LANES];
}

#define MRTS_IN_LANES
#include "../number_type.inc"
#include "../answers.inc"
#undef MRTS_IN_LANES

#endif

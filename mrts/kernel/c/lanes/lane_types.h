/* SPDX-License-Identifier: MIT
 *
 * Numbers side by side in the lanes of a vector register, whatever registers the machine has.
 */
#ifndef MRTS_LANE_TYPES_H
#define MRTS_LANE_TYPES_H

#include "../numbers.h"

/* Samples at a time; without the vectors of GNU C one after the other. */
#if defined(__GNUC__) && !defined(MRTS_NO_LANES)
#define MRTS_LANES 4
typedef double mrts_lanes __attribute__((vector_size(8 * MRTS_LANES), aligned(8)));
typedef long long mrts_lane_mask __attribute__((vector_size(8 * MRTS_LANES), aligned(8)));
#pragma GCC diagnostic ignored "-Wpsabi" /* between functions of ours only, of the same target */

/* Wider registers than every x86-64 has, for machines that have them. */
#if defined(__x86_64__) && !defined(MRTS_NARROW)
#define MRTS_WIDE __attribute__((target("avx2")))
#endif

/* A comparison in registers half as wide: gcc compares numbers one by one where there are no registers of all lanes. */
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
MRTS_COMPARED(mrts_at_most_halves, <=)
MRTS_COMPARED(mrts_above_halves, >)
#undef MRTS_COMPARED

#else
#define MRTS_LANES 1
#endif

#endif

/* SPDX-License-Identifier: MIT
 *
 * Work on lanes, for the registers that every machine of a kind has and for wider ones.
 */
#include "lanes.h"
#include "../basis/kept_basis.h"

#if MRTS_LANES > 1
#define MRTS_V mrts_lanes
#define MRTS_V_OF(value) ((mrts_lanes){0} + (double)(value))
#define MRTS_MASK mrts_lane_mask
#define MRTS_ALL ((mrts_lane_mask){0} - 1)
#define MRTS_CHOOSE(mask, a, b) \
    ((mrts_lanes)(((mask) & (mrts_lane_mask)(a)) | (~(mask) & (mrts_lane_mask)(b))))
#define MRTS_TAKE_PIVOT(k, c, row, side, B) (void)0
#define MRTS_IS_NONE(value) 0

#define MRTS_STATIC static inline
#define MRTS_OF(name) name##_lanes
#define MRTS_LANE_FORM mrts_form_of_lanes
#include "../basis/kept_basis.inc"
#include "lane_samples.inc"

#ifdef MRTS_WIDE
#undef MRTS_STATIC
#undef MRTS_OF
#undef MRTS_LANE_FORM
#define MRTS_STATIC MRTS_WIDE static inline
#define MRTS_OF(name) name##_wide
#define MRTS_LANE_FORM mrts_form_of_wide_lanes
#include "../basis/kept_basis.inc"
#include "lane_samples.inc"
#endif

MRTS_LOCAL mrts_lane_functions mrts_lane_functions_here(void) {
    const mrts_lane_functions anywhere = {mrts_lane_rows_of_lanes, mrts_lane_end_lanes};
#ifdef MRTS_WIDE
    const mrts_lane_functions wide = {mrts_lane_rows_of_wide, mrts_lane_end_wide};
    if (__builtin_cpu_supports("avx2")) return wide;
#endif
    return anywhere;
}

#undef MRTS_STATIC
#undef MRTS_V
#undef MRTS_V_OF
#undef MRTS_MASK
#undef MRTS_ALL
#undef MRTS_CHOOSE
#undef MRTS_OF
#undef MRTS_TAKE_PIVOT
#undef MRTS_IS_NONE
#endif

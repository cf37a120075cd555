/* SPDX-License-Identifier: MIT
 *
 * Projections of several samples, for the registers that every machine of a kind has and for wider ones.
 */
#include "lane_corners.h"

#if MRTS_LANES > 1
#include "../lanes/lane_numbers.inc"
#define MRTS_STATIC static inline
#define MRTS_OF(name) name##_lanes
#include "lane_corners.inc"
#ifdef MRTS_WIDE
#undef MRTS_STATIC
#undef MRTS_OF
#include "../lanes/wide_numbers.inc"
#define MRTS_STATIC MRTS_WIDE static inline
#define MRTS_OF(name) name##_wide
#include "lane_corners.inc"
#endif
#undef MRTS_STATIC
#undef MRTS_OF
#include "../lanes/no_lane_numbers.inc"

MRTS_LOCAL mrts_corner_functions mrts_corner_functions_here(void) {
    const mrts_corner_functions anywhere = {mrts_take_polytopes_lanes, mrts_known_outline_lanes};
#ifdef MRTS_WIDE
    const mrts_corner_functions wide = {mrts_take_polytopes_wide, mrts_known_outline_wide};
    if (__builtin_cpu_supports("avx2")) return wide;
#endif
    return anywhere;
}

MRTS_LOCAL mrts_lane_polytopes mrts_lane_polytopes_in(const mrts_polytopes *of, double *work, int *iwork) {
    const int k = of->k, rows = of->rows;
    mrts_lane_polytopes in;
    in.of = of;
    in.A = (mrts_lanes *)(void *)work;
    in.per = in.A + rows * k;
    in.lower = in.per + rows;
    in.upper = in.lower + rows + k;
    in.least = in.upper + rows + k;
    in.most = in.least + rows + k;
    in.corner = in.most + rows + k;
    in.B = in.corner + MRTS_CORNERS * MRTS_LANE_CORNER(k);
    in.z = in.B + k * k;
    in.right = in.z + k;
    in.limit = in.right + k;
    in.share = in.limit + k;
    in.row = (const mrts_lanes **)(void *)(in.share + 2 * k);
    in.alone = iwork;
    in.several = in.alone + rows;
    in.several_count = 0;
    in.fixing = in.several + rows + 3;
    in.open = in.fixing + k;
    in.joint = in.open + k;
    in.fit = (mrts_lane_mask){0};
    return in;
}
#endif

/* SPDX-License-Identifier: MIT
 *
 * Work on lanes, for the registers that every machine of a kind has and for wider ones.
 */
#include "lanes.h"
#include "../basis/kept_basis.h"
#include "../trajectory.h"

#if MRTS_LANES > 1
#define MRTS_PER_QUARTER 6.36619772367581382433e-01  /* 2 / pi */
#define MRTS_QUARTER 1.57079632673412561417e+00      /* the first 33 bits of pi / 2 */
#define MRTS_QUARTER_REST 6.07710050650619224932e-11 /* and the rest */
#define MRTS_ROUNDER 6755399441055744.0              /* 1.5 * 2^52: what is added to it is rounded to a whole number */
#define MRTS_MOST_ANGLE 1e5                          /* a multiple of 33 bits is exact [rad] */

#include "lane_numbers.inc"
#define MRTS_TAKE_PIVOT(k, c, row, side, B) (void)(side)
#define MRTS_IS_NONE(value) 0
#define MRTS_AT_ONCE MRTS_LANES
#define MRTS_SET(value, lane, number) ((value)[lane] = (number))
#define MRTS_GET(value, lane) ((value)[lane])
#define MRTS_SINES(count, angle, both) MRTS_OF(mrts_sines)(count, angle, both)
#define MRTS_RUN_KINEMATICS(places, arg, sines, res) (MRTS_KINEMATICS_IN_LANES(arg, sines, res), 0)
#define MRTS_RUN_BIAS(places, arg, sines, res) (MRTS_BIAS_IN_LANES(arg, sines, res), 0)

#define MRTS_STATIC static inline
#define MRTS_OF(name) name##_lanes
#define MRTS_FORM_IN_LANES mrts_form_of_lanes
#define MRTS_KINEMATICS_IN_LANES mrts_kinematics_of_lanes
#define MRTS_BIAS_IN_LANES mrts_bias_of_lanes
#include "../basis/kept_basis.inc"
#include "lane_angles.inc"
#include "lane_samples.inc"
#include "../dense/lane_widening.inc"
#include "lane_torques.inc"
#include "../dense/places.inc"
#include "../tracking/closure.inc"

#ifdef MRTS_WIDE
#undef MRTS_STATIC
#undef MRTS_OF
#undef MRTS_FORM_IN_LANES
#undef MRTS_KINEMATICS_IN_LANES
#undef MRTS_BIAS_IN_LANES
#include "wide_numbers.inc"
#define MRTS_STATIC MRTS_WIDE static inline
#define MRTS_OF(name) name##_wide
#define MRTS_FORM_IN_LANES mrts_form_of_wide_lanes
#define MRTS_KINEMATICS_IN_LANES mrts_kinematics_of_wide_lanes
#define MRTS_BIAS_IN_LANES mrts_bias_of_wide_lanes
#include "../basis/kept_basis.inc"
#include "lane_angles.inc"
#include "lane_samples.inc"
#include "../dense/lane_widening.inc"
#include "lane_torques.inc"
#include "../dense/places.inc"
#include "../tracking/closure.inc"
#endif

MRTS_LOCAL mrts_lane_functions mrts_lane_functions_here(void) {
    const mrts_lane_functions anywhere = {
        mrts_lane_form_lanes,   mrts_lane_rows_of_lanes, mrts_lane_end_lanes, mrts_dense_form_lanes,    mrts_dense_bound_lanes,
        mrts_dense_passed_lanes, mrts_some_places_lanes, mrts_closures_lanes, mrts_lane_programs_lanes, mrts_lane_torques_lanes};
#ifdef MRTS_WIDE
    const mrts_lane_functions wide = {
        mrts_lane_form_wide,    mrts_lane_rows_of_wide, mrts_lane_end_wide, mrts_dense_form_wide,    mrts_dense_bound_wide,
        mrts_dense_passed_wide, mrts_some_places_wide,  mrts_closures_wide, mrts_lane_programs_wide, mrts_lane_torques_wide};
    if (__builtin_cpu_supports("avx2")) return wide;
#endif
    return anywhere;
}

#include "no_lane_numbers.inc"
#undef MRTS_STATIC
#undef MRTS_OF
#undef MRTS_TAKE_PIVOT
#undef MRTS_IS_NONE
#undef MRTS_AT_ONCE
#undef MRTS_SET
#undef MRTS_GET
#undef MRTS_SINES
#undef MRTS_RUN_KINEMATICS
#undef MRTS_RUN_BIAS
#endif

/* SPDX-License-Identifier: MIT
 *
 * A retimed motion between the samples of its path, several places at a time where there are lanes.
 */
#include "places.h"
#include "../lanes/lanes.h"

#if MRTS_LANES == 1
/* A generated function at one place. */
static int mrts_run_at(MRTS_GENERATED((*run)), const mrts_places *places, int inputs, const double *const *arg, int outputs,
                       double *const *res) {
    for (int i = 0; i < inputs; ++i) places->arg[i] = arg[i];
    for (int i = 0; i < outputs; ++i) places->res[i] = res[i];
    return run(places->arg, places->res, places->iw, places->w, 0);
}

#define MRTS_STATIC static
#define MRTS_V double
#define MRTS_V_OF(value) ((double)(value))
#define MRTS_AT_ONCE 1
#define MRTS_SET(value, lane, number) ((value) = (number))
#define MRTS_GET(value, lane) (value)
#define MRTS_SINES(count, angle, both) (void)(both) /* generated functions take their own */
#define MRTS_OF(name) name
#define MRTS_RUN_KINEMATICS(places, arg, sines, res) mrts_run_at(MRTS_KINEMATICS, places, 2, arg, 3, res)
#define MRTS_RUN_BIAS(places, arg, sines, res) mrts_run_at(MRTS_BIAS_ACCELERATION, places, 3, arg, 1, res)
#include "places.inc"
#undef MRTS_STATIC
#undef MRTS_V
#undef MRTS_V_OF
#undef MRTS_AT_ONCE
#undef MRTS_SET
#undef MRTS_GET
#undef MRTS_SINES
#undef MRTS_OF
#undef MRTS_RUN_KINEMATICS
#undef MRTS_RUN_BIAS
#endif

/* Places first .. first + count - 1 of all segments in a row, see mrts_places: the time from the first place of all, joints
 * and object. Returns 1 if a generated function failed. */
MRTS_EXPORT int mrts_path_places(long long first, long long count, const mrts_joint_path *path, const double *x,
                                 const double *u, const double *geometry, const int *components, double *time, double *q,
                                 double *dq, double *ddq, double *position, double *rotation, double *twist,
                                 double *acceleration, const double **arg, double **res, long long *iw, double *w) {
    const mrts_places to = {path, x, u, geometry, components, time, q, dq, ddq, position, rotation, twist, acceleration, arg, res, iw, w};
    long long places[MRTS_LANES];
#if MRTS_LANES > 1
    const mrts_lane_functions functions = mrts_lane_functions_here();
    mrts_lanes numbers[MRTS_GEOMETRY_NUMBERS];
    for (int i = 0; i < MRTS_GEOMETRY_NUMBERS; ++i) numbers[i] = (mrts_lanes){0} + geometry[i];
#endif
    for (long long n = 0; n < count; n += MRTS_LANES) { /* beyond the last the last is repeated */
        for (int lane = 0; lane < MRTS_LANES; ++lane) places[lane] = first + (n + lane < count ? n + lane : count - 1);
#if MRTS_LANES > 1
        if (functions.places(&to, numbers, places)) return 1;
#else
        if (mrts_some_places(&to, geometry, places)) return 1;
#endif
    }
    return 0;
}

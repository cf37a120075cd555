/* SPDX-License-Identifier: MIT
 *
 * How far given joints are from holding an object that moves as given, over all samples of a motion.
 */
#include "closure.h"
#include "../lanes/forms.h"

/* The largest of samples 0 .. count - 1, (MRTS_ROBOTS, MRTS_CLOSURE_SIZES), infinity where one is no number; `in` are the
 * inputs of the wrench form, `components` those of a twist that a wrench of the cell has. Returns 1 where there are no
 * lanes: nothing is found then. */
MRTS_EXPORT int mrts_closure(long long count, const double *const *in, const long long *stride, const double *position,
                             const double *geometry, const int *components, double *most) {
#if MRTS_LANES > 1
    enum { NUMBERS = MRTS_ROBOTS * MRTS_CLOSURE_SIZES };
    const mrts_lane_functions functions = mrts_lane_functions_here();
    mrts_lane_inputs inputs;
    mrts_lanes object[3], found[NUMBERS];
    mrts_lane_mask finite = (mrts_lane_mask){0} - 1;
    for (int i = 0; i < NUMBERS; ++i) found[i] = (mrts_lanes){0};
    for (long long n = 0; n < count; n += MRTS_LANES) {
        mrts_take_inputs(in, stride, n, count, n == 0, &inputs);
        for (int lane = 0; lane < MRTS_LANES; ++lane) {
            for (int i = 0; i < 3; ++i) object[i][lane] = position[3 * inputs.at[lane] + i];
        }
        functions.closures(geometry, components, inputs.arg, object, found, &finite);
    }
    for (int i = 0; i < NUMBERS; ++i) {
        most[i] = 0;
        for (int lane = 0; lane < MRTS_LANES; ++lane) {
            if (!finite[lane]) most[i] = INFINITY;
            if (found[i][lane] > most[i]) most[i] = found[i][lane];
        }
    }
    return 0;
#else
    (void)count;
    (void)in;
    (void)stride;
    (void)position;
    (void)geometry;
    (void)components;
    (void)most;
    return 1;
#endif
}

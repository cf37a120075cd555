/* SPDX-License-Identifier: MIT
 *
 * The wrench forms of samples in a row: several evaluated at a time where there are lanes, with the bits of one alone.
 */
#ifndef MRTS_FORMS_H
#define MRTS_FORMS_H

#include "lanes.h"

/* Inputs of some samples in lanes: those that are the same for all stand there once. */
typedef struct {
    mrts_lanes numbers[MRTS_INPUT_NUMBERS];
    const mrts_lanes *arg[MRTS_INPUTS];
    long long at[MRTS_LANES];
} mrts_lane_inputs;

/* Takes the inputs of samples from `first` on, those that are the same for all only if `all`; beyond the last the last is
 * repeated. */
MRTS_LOCAL void mrts_take_inputs(const double *const *in, const long long *stride, long long first, long long count,
                                 int all, mrts_lane_inputs *lanes);

/* One lane of some numbers. */
MRTS_LOCAL void mrts_take_lane(int count, const mrts_lanes *from, int lane, double *to);

/* The forms of the samples of a call. */
typedef struct {
    const double *const *in;
    const long long *stride;
    long long count; /* of samples */
    mrts_lane_inputs inputs;
    mrts_lanes torque_map[MRTS_UNKNOWNS * MRTS_JOINTS], torque_offset[MRTS_JOINTS];
    mrts_lanes wrench_map[MRTS_UNKNOWNS * MRTS_WRENCHES], wrench_offset[MRTS_WRENCHES];
} mrts_forms;

/* Those of samples 0 .. count - 1. */
MRTS_LOCAL void mrts_begin_forms(const double *const *in, const long long *stride, long long count, mrts_forms *forms);

/* Inputs of samples at rest with their velocities as accelerations: the form's column of c^2 is then what the rate u of a
 * speed that varies adds, as no term is quadratic in velocities. */
typedef struct {
    const double *in[MRTS_INPUTS];
    long long stride[MRTS_INPUTS];
} mrts_rate_inputs;

MRTS_LOCAL void mrts_inputs_by_rate(const double *const *in, const long long *stride, mrts_rate_inputs *rate);

/* The next form, that of a sample, which are asked for one after the other from 0 on; arg, (MRTS_INPUTS), then has the
 * sample's inputs. */
MRTS_LOCAL void mrts_next_form(mrts_forms *forms, long long sample, mrts_form *form, const double **arg);

#endif

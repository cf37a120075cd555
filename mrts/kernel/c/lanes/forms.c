/* SPDX-License-Identifier: MIT
 *
 * Forms of several samples at a time.
 */
#include "forms.h"
#include "../trajectory.h"

MRTS_LOCAL void mrts_take_inputs(const double *const *in, const long long *stride, long long first, long long count,
                                 int all, mrts_lane_inputs *lanes) {
    static const int sizes[MRTS_INPUTS] = MRTS_INPUT_SIZES;
    mrts_lanes *next = lanes->numbers;
    for (int lane = 0; lane < MRTS_LANES; ++lane) lanes->at[lane] = first + lane < count ? first + lane : count - 1;
    for (int i = 0; i < MRTS_INPUTS; next += sizes[i++]) {
        const double *own[MRTS_LANES];
        lanes->arg[i] = next;
        if (!all && !stride[i]) continue;
        for (int lane = 0; lane < MRTS_LANES; ++lane) own[lane] = in[i] + lanes->at[lane] * stride[i];
        for (int number = 0; number < sizes[i]; ++number) {
            next[number] = (mrts_lanes){own[0][number], own[1][number], own[2][number], own[3][number]};
        }
    }
}

MRTS_LOCAL void mrts_take_lane(int count, const mrts_lanes *from, int lane, double *to) {
    const double *numbers = (const double *)(const void *)from + lane;
    for (int i = 0; i < count; ++i) to[i] = numbers[i * MRTS_LANES];
}

MRTS_LOCAL void mrts_begin_forms(const double *const *in, const long long *stride, long long count, mrts_forms *forms) {
    forms->in = in;
    forms->stride = stride;
    forms->count = count;
    if (count > 0) mrts_take_inputs(in, stride, 0, count, 1, &forms->inputs);
}

MRTS_LOCAL void mrts_inputs_by_rate(const double *const *in, const long long *stride, mrts_rate_inputs *rate) {
    static const double still[MRTS_JOINTS > 6 ? MRTS_JOINTS : 6] = {0};
    for (int i = 0; i < MRTS_INPUTS; ++i) {
        const int of = i == MRTS_DDQ ? MRTS_DQ : i == MRTS_ACCELERATION ? MRTS_TWIST : i, stands = i == MRTS_DQ || i == MRTS_TWIST;
        rate->in[i] = stands ? still : in[of];
        rate->stride[i] = stands ? 0 : stride[of];
    }
}

MRTS_LOCAL void mrts_next_form(mrts_forms *forms, long long sample, mrts_form *form, const double **arg) {
    for (int i = 0; i < MRTS_INPUTS; ++i) arg[i] = forms->in[i] + sample * forms->stride[i];
    const int lane = (int)(sample % MRTS_LANES);
    if (lane == 0) {
        mrts_lanes *const found[4] = {forms->torque_map, forms->torque_offset, forms->wrench_map, forms->wrench_offset};
        mrts_take_inputs(forms->in, forms->stride, sample, forms->count, 0, &forms->inputs);
        mrts_lane_form(forms->inputs.arg, found);
    }
    mrts_take_lane(MRTS_UNKNOWNS * MRTS_JOINTS, forms->torque_map, lane, form->torque_map);
    mrts_take_lane(MRTS_JOINTS, forms->torque_offset, lane, form->torque_offset);
    mrts_take_lane(MRTS_UNKNOWNS * MRTS_WRENCHES, forms->wrench_map, lane, form->wrench_map);
    mrts_take_lane(MRTS_WRENCHES, forms->wrench_offset, lane, form->wrench_offset);
}

/* SPDX-License-Identifier: MIT
 *
 * The quadratic program of the torques of one sample.
 */
#include "least_torques.h"

MRTS_LOCAL int mrts_least_torques(int k, int joints, int wrenches, const mrts_limits *limits, const mrts_weights *weights,
                                  mrts_real c2, mrts_real widening, mrts_form *form, mrts_rows *rows, int *active,
                                  int *count, mrts_real *torque, mrts_real *wrench, mrts_real *work, mrts_real *qp_work,
                                  int *iwork) {
    const int f = k - 1;
    mrts_real *H = work, *g = H + f * f, *x = g + f, *u = x + f, *column = u + f, *weighted = column + f, largest = 0;
    mrts_fix_speed(k, limits, c2, widening, rows);
    mrts_scale_columns(f, rows, column);
    mrts_free_unknowns(f, rows);
    for (int i = 0; i < joints; ++i) torque[i] = form->torque_map[f * joints + i] * c2 + form->torque_offset[i];
    for (int i = 0; i < wrenches; ++i) wrench[i] = form->wrench_map[f * wrenches + i] * c2 + form->wrench_offset[i];
    for (int j = 0; j < f; ++j) {
        mrts_real *map = form->torque_map + j * joints;
        for (int i = 0; i < joints; ++i) map[i] *= column[j];
        for (int i = 0; i < joints; ++i) {
            weighted[i] = weights->apart ? weights->entries[i * weights->apart] * map[i]
                                         : mrts_dot(joints, weights->entries + i * joints, map);
        }
        g[j] = mrts_dot(joints, weighted, torque);
        for (int l = 0; l <= j; ++l) {
            H[j * f + l] = H[l * f + j] = mrts_dot(joints, weighted, form->torque_map + l * joints);
            largest = mrts_larger(MRTS_ABS(H[j * f + l]), largest);
        }
        x[j] = 0;
    }
    for (int i = 0; largest > 0 && i < f * f; ++i) H[i] /= largest;
    for (int j = 0; largest > 0 && j < f; ++j) g[j] /= largest;
    const int status = mrts_qp(f, rows->count, H, rows->A, rows->lower, rows->upper, g, x, active, u, count, qp_work, iwork);
    for (int j = 0; j < f; ++j) {
        for (int i = 0; i < joints; ++i) torque[i] += x[j] * form->torque_map[j * joints + i];
        for (int i = 0; i < wrenches; ++i) wrench[i] += x[j] * column[j] * form->wrench_map[j * wrenches + i];
    }
    return status;
}

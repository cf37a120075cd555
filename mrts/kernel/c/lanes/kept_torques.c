/* SPDX-License-Identifier: MIT
 *
 * A dual active set method that starts where it ends: the minimiser on the active rows, refined twice.
 */
#include "kept_torques.h"

/* What active rows and the gradient lack at x and u, and the errors of both as mrts_qp_error measures them. */
static mrts_lane_mask mrts_lane_qp_lacks(const mrts_lane_program *program, const int *active, int count, const mrts_lanes *u,
                                         mrts_lanes *gradient, mrts_lanes *missing) {
    enum { F = MRTS_UNKNOWNS - 1 };
    const mrts_rows_lanes *rows = program->rows;
    mrts_lanes size = mrts_each(0), largest = size;
    mrts_lane_mask fits = MRTS_EVERY_LANE;
    for (int i = 0; i < F; ++i) {
        mrts_lanes sum = program->g[i];
        for (int l = 0; l < F; ++l) sum += program->H[i * F + l] * program->x[l];
        gradient[i] = -sum;
        size = mrts_larger_lanes(mrts_sizes(program->g[i]), size);
    }
    for (int j = 0; j < count; ++j) largest = mrts_larger_lanes(u[j], largest);
    for (int j = 0; j < count; ++j) {
        const int row = mrts_abs(active[j]) - 1;
        const mrts_lanes *a = rows->A + row * F, lower = rows->lower[row], upper = rows->upper[row];
        const mrts_lanes limit = active[j] < 0 ? lower : -upper, its = active[j] < 0 ? u[j] : -u[j];
        mrts_lanes value = mrts_each(0);
        for (int i = 0; i < F; ++i) {
            const mrts_lanes part = its * a[i];
            value += a[i] * program->x[i];
            gradient[i] += part;
            size = mrts_larger_lanes(mrts_sizes(part), size);
        }
        missing[j] = active[j] < 0 ? limit - value : limit + value;
        fits &= mrts_at_most(mrts_sizes(missing[j]), MRTS_FEASIBLE * (1 + mrts_sizes(limit)));
        fits &= mrts_at_most(-u[j], MRTS_FEASIBLE * largest) | mrts_at_most(upper, lower);
    }
    for (int i = 0; i < F; ++i) fits &= mrts_at_most(mrts_sizes(gradient[i]), MRTS_FEASIBLE * size);
    return fits;
}

/* Whether all rows keep their limits at x. */
static mrts_lane_mask mrts_lane_qp_feasible(const mrts_lane_program *program) {
    enum { F = MRTS_UNKNOWNS - 1 };
    const mrts_rows_lanes *rows = program->rows;
    mrts_lane_mask kept = MRTS_EVERY_LANE;
    for (int i = 0; i < rows->count; ++i) {
        const mrts_lanes *a = rows->A + i * F, lower = rows->lower[i], upper = rows->upper[i];
        mrts_lanes value = mrts_each(0);
        MRTS_UNROLL
        for (int j = 0; j < F; ++j) value += a[j] * program->x[j];
        kept &= mrts_at_most(value - upper, MRTS_FEASIBLE * (1 + mrts_sizes(upper)));
        kept &= mrts_at_most(lower - value, MRTS_FEASIBLE * (1 + mrts_sizes(lower)));
    }
    return kept;
}

MRTS_LOCAL mrts_lane_mask mrts_kept_torques(mrts_lane_program *program, const int *active, int count) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    mrts_lanes W[K * K], S[K * K], factor[K * K], u[K], gradient[K], missing[K];
    for (int j = 0; j < count; ++j) { /* L w = a of each active row, and their products */
        const mrts_lanes *a = program->rows->A + (mrts_abs(active[j]) - 1) * F;
        for (int i = 0; i < F; ++i) W[j * F + i] = active[j] < 0 ? a[i] : -a[i];
        mrts_lane_forward(F, program->L, W + j * F);
        for (int l = 0; l <= j; ++l) {
            S[j * count + l] = mrts_each(0);
            for (int i = 0; i < F; ++i) S[j * count + l] += W[j * F + i] * W[l * F + i];
        }
        u[j] = mrts_each(0);
    }
    mrts_lane_cholesky(count, S, factor);
    for (int i = 0; i < F; ++i) program->x[i] = mrts_each(0);
    for (int pass = 0; pass < 3; ++pass) { /* the minimiser on the rows, and two refinements of it */
        mrts_lane_qp_lacks(program, active, count, u, gradient, missing);
        mrts_lane_forward(F, program->L, gradient);
        for (int j = 0; j < count; ++j) {
            for (int i = 0; i < F; ++i) missing[j] -= W[j * F + i] * gradient[i];
        }
        mrts_lane_forward(count, factor, missing);
        mrts_lane_backward(count, factor, missing);
        for (int j = 0; j < count; ++j) {
            u[j] += missing[j];
            for (int i = 0; i < F; ++i) gradient[i] += missing[j] * W[j * F + i];
        }
        mrts_lane_backward(F, program->L, gradient);
        for (int i = 0; i < F; ++i) program->x[i] += gradient[i];
    }
    return mrts_lane_qp_lacks(program, active, count, u, gradient, missing) & mrts_lane_qp_feasible(program);
}

/* SPDX-License-Identifier: MIT
 *
 * The least torques of several samples: those of the active rows of the sample before, verified.
 */
#include "lanes.h"

/* Puts c^2 into the rows and scales the wrenches, as mrts_fix_speed and mrts_scale_columns do. */
static void mrts_lane_fix_speed(const mrts_limits *limits, mrts_lanes c2, mrts_lane_program *program) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    mrts_lane_rows *rows = &program->rows;
    for (int j = 0; j < F; ++j) {
        const mrts_lane_mask has = mrts_above(rows->size[j], mrts_each(MRTS_NO_EFFECT));
        rows->size[j] = mrts_choose(has, 1 / rows->size[j], mrts_each(0));
        rows->column[j] = mrts_choose(has, rows->size[j], mrts_each(1));
        for (int i = 0; i < M; ++i) program->torque[j * M + i] *= rows->column[j];
        for (int i = 0; i < N; ++i) program->wrench[j * N + i] *= rows->column[j];
    }
    for (int i = 0; i < rows->of->count; ++i) {
        const int row = rows->of->which[i];
        const mrts_lanes given = rows->A[i * K + F] * c2;
        const double gap = limits->lower[row] < limits->upper[row] ? program->widening : 0;
        if (limits->lower[row] > -MRTS_INFINITY) rows->lower[i] -= given + gap;
        if (limits->upper[row] < MRTS_INFINITY) rows->upper[i] += gap - given;
        for (int j = 0; j < F; ++j) rows->A[i * F + j] = rows->A[i * K + j] * rows->size[j]; /* to a place before its own */
    }
    for (int i = 0; i < M; ++i) program->torque[F * M + i] = program->torque[F * M + i] * c2 + program->torque[K * M + i];
    for (int i = 0; i < N; ++i) program->wrench[F * N + i] = program->wrench[F * N + i] * c2 + program->wrench[K * N + i];
}

MRTS_LOCAL void mrts_lane_programs(const mrts_lanes *const *arg, const mrts_limits *limits, const mrts_terms *terms,
                                             const long long *at, const mrts_lanes *c2, mrts_lane_program *program) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    mrts_lanes *torque = program->torque, *wrench = program->wrench, weighted[M], largest = mrts_each(0);
    mrts_lanes *const res[] = {torque, torque + K * M, wrench, wrench + K * N};
    int is_diagonal = 1;
    mrts_lane_form(arg, res);
    mrts_lane_motors(terms, at, torque + F * M, torque + K * M);
    mrts_lane_build(torque, wrench, limits, terms, at, &program->rows);
    mrts_lane_fix_speed(limits, *c2, program);
    for (int i = 0; i < M * M; ++i) is_diagonal &= i % (M + 1) == 0 || program->weights[i] == 0;
    for (int j = 0; j < F; ++j) {
        for (int i = 0; i < M; ++i) {
            weighted[i] = program->weights[i * (M + 1)] * torque[j * M + i];
            if (is_diagonal) continue;
            weighted[i] = mrts_each(0);
            for (int l = 0; l < M; ++l) weighted[i] += program->weights[i * M + l] * torque[j * M + l];
        }
        for (int l = 0; l <= j; ++l) {
            mrts_lanes sum = mrts_each(0);
            for (int i = 0; i < M; ++i) sum += weighted[i] * torque[l * M + i];
            program->H[j * F + l] = program->H[l * F + j] = sum;
            largest = mrts_larger_lanes(mrts_sizes(sum), largest);
        }
        program->g[j] = mrts_each(0);
        for (int i = 0; i < M; ++i) program->g[j] += weighted[i] * torque[F * M + i];
    }
    for (int i = 0; i < F * F; ++i) program->H[i] /= largest;
    for (int j = 0; j < F; ++j) program->g[j] /= largest;
    mrts_lane_cholesky(F, program->H, program->L);
}

/* What active rows and the gradient lack at x and u, and the errors of both as mrts_qp_error measures them. */
static mrts_lane_mask mrts_lane_qp_lacks(const mrts_lane_program *program, const int *active, int count,
                                                       const mrts_lanes *u, mrts_lanes *gradient, mrts_lanes *missing) {
    enum { F = MRTS_UNKNOWNS - 1 };
    const mrts_lane_rows *rows = &program->rows;
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
    const mrts_lane_rows *rows = &program->rows;
    mrts_lane_mask kept = MRTS_EVERY_LANE;
    for (int i = 0; i < rows->of->count; ++i) {
        const mrts_lanes *a = rows->A + i * F, lower = rows->lower[i], upper = rows->upper[i];
        mrts_lanes value = mrts_each(0);
        MRTS_UNROLL
        for (int j = 0; j < F; ++j) value += a[j] * program->x[j];
        kept &= mrts_at_most(value - upper, MRTS_FEASIBLE * (1 + mrts_sizes(upper)));
        kept &= mrts_at_most(lower - value, MRTS_FEASIBLE * (1 + mrts_sizes(lower)));
    }
    return kept;
}

MRTS_LOCAL void mrts_lane_torques(mrts_lane_program *program, const int *active, int count, mrts_lane_mask *kept) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    mrts_lanes W[K * K], S[K * K], factor[K * K], u[K], gradient[K], missing[K];
    for (int j = 0; j < count; ++j) { /* L w = a of each active row, and their products */
        const mrts_lanes *a = program->rows.A + (mrts_abs(active[j]) - 1) * F;
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
    for (int i = 0; i < M; ++i) {
        program->least_torque[i] = program->torque[F * M + i];
        for (int j = 0; j < F; ++j) program->least_torque[i] += program->x[j] * program->torque[j * M + i];
    }
    for (int i = 0; i < N; ++i) {
        program->its_wrench[i] = program->wrench[F * N + i];
        for (int j = 0; j < F; ++j) program->its_wrench[i] += program->x[j] * program->wrench[j * N + i];
    }
    *kept = mrts_lane_qp_lacks(program, active, count, u, gradient, missing) & mrts_lane_qp_feasible(program);
}

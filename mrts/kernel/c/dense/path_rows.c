/* SPDX-License-Identifier: MIT
 *
 * The rows along a path whose speed varies: over the free wrenches, the rate r'' and the square r'^2.
 */
#include "../lanes/lanes.h"
#include "../trajectory.h"

/* What the unknowns of a path are: the free wrenches, then the rate, then the square. */
#define MRTS_PATH_UNKNOWNS (MRTS_UNKNOWNS + 1)

/* Puts the column of the rate into maps by columns, those of the square before it: the column of the square of a motion
 * whose accelerations are these velocities and which has none, as no term is quadratic in velocities then. */
static void mrts_with_rate(int size, const double *by_rate, double *map) {
    enum { F = MRTS_UNKNOWNS - 1 };
    for (int i = 0; i < size; ++i) {
        map[(F + 1) * size + i] = map[F * size + i];
        map[F * size + i] = by_rate[F * size + i];
    }
}

/* A map by columns to one by rows. */
static void mrts_by_rows(int rows, const double *map, double *out) {
    for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < MRTS_PATH_UNKNOWNS; ++j) out[i * MRTS_PATH_UNKNOWNS + j] = map[j * rows + i];
    }
}

MRTS_EXPORT void mrts_path_rows_work(int rows, long long *reals, long long *ints) {
    *reals = MRTS_ROWS_WORK(MRTS_PATH_UNKNOWNS, rows);
    *ints = MRTS_ROWS_IWORK(rows);
}

/* Of samples 0 .. count - 1 the maps of torques and wrenches, by rows, their offsets, and the rows of the limits, each of
 * which has one and of which 100 % are a `unit`; torque_rate is what motors add to the column of the rate. What is returned
 * as in mrts_ranges. */
MRTS_EXPORT int mrts_path_rows(long long count, const double *const *in, const long long *stride,
                               const mrts_limits *limits, const mrts_terms *terms, const double *torque_rate,
                               const double *unit, double *torque_map, double *torque_offset, double *wrench_map,
                               double *wrench_offset, double *A, double *lower, double *upper, double *work, int *iwork) {
    enum { V = MRTS_PATH_UNKNOWNS, F = MRTS_UNKNOWNS - 1, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    double memory[MRTS_FORM_WORK(MRTS_PATH_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES)];
    double rates[MRTS_FORM_WORK(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES)];
    double turned[MRTS_TURNED_WORK(MRTS_PATH_UNKNOWNS, MRTS_WRENCHES)];
    mrts_form form = mrts_form_in(V, M, N, memory), by_rate = mrts_form_in(MRTS_UNKNOWNS, M, N, rates);
    const double *arg[MRTS_INPUTS];
    mrts_rate_inputs rate;
    mrts_forms forms, rate_forms;
    mrts_rows rows;
    if (!mrts_rows_over(V, limits, work, iwork, &rows) || rows.count < limits->rows) return 1;
    for (int i = 0; i < rows.count; ++i) rows.unit[i] = unit[i];
    mrts_inputs_by_rate(in, stride, &rate);
    mrts_begin_forms(in, stride, count, &forms);
    mrts_begin_forms(rate.in, rate.stride, count, &rate_forms);
    for (long long n = 0; n < count; ++n) {
        const mrts_terms here = mrts_terms_of_sample(terms, n, limits->rows);
        mrts_next_form(&rate_forms, n, &by_rate, arg);
        mrts_next_form(&forms, n, &form, arg);
        mrts_with_rate(M, by_rate.torque_map, form.torque_map);
        mrts_with_rate(N, by_rate.wrench_map, form.wrench_map);
        mrts_add_motors(V, M, &here, &form);
        for (int i = 0; i < M; ++i) form.torque_map[F * M + i] += torque_rate[n * M + i];
        mrts_turn_wrenches(V, MRTS_ROBOTS, MRTS_SIZE, limits, arg[MRTS_ROTATION], 1, 3, turned, &form);
        mrts_build_rows(V, M, N, &form, limits, &here, &rows);
        mrts_by_rows(M, form.torque_map, torque_map + n * M * V);
        mrts_by_rows(N, form.wrench_map, wrench_map + n * N * V);
        for (int i = 0; i < M; ++i) torque_offset[n * M + i] = form.torque_offset[i];
        for (int i = 0; i < N; ++i) wrench_offset[n * N + i] = form.wrench_offset[i];
        for (int i = 0; i < rows.count * V; ++i) A[n * rows.count * V + i] = rows.A[i];
        for (int i = 0; i < rows.count; ++i) {
            lower[n * rows.count + i] = rows.lower[i] > -MRTS_INFINITY ? rows.lower[i] : -INFINITY;
            upper[n * rows.count + i] = rows.upper[i] < MRTS_INFINITY ? rows.upper[i] : INFINITY;
        }
    }
    return 0;
}

/* SPDX-License-Identifier: MIT
 *
 * Wrenches that keep all limits of several samples: those known from the sample before, moved in
 * each so that the rows that bound them there still do.
 */
#include "../lanes/lanes.h"
#include "../trajectory.h"

MRTS_LOCAL void mrts_dense_form(const mrts_lanes *const *arg, mrts_dense_lanes *at) {
    enum { K = MRTS_UNKNOWNS, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    mrts_lanes *const res[] = {at->torque, at->torque + K * M, at->wrench, at->wrench + K * N};
    mrts_lane_form(arg, res);
    mrts_lane_motors(at->terms, at->samples, at->torque + (K - 1) * M, at->torque + K * M);
    for (int i = 0; at->limits->base && i < 9 * MRTS_ROBOTS; ++i) { /* as in mrts_turn_wrenches */
        const mrts_lanes *column = arg[MRTS_ROTATION] + 3 * at->limits->axes[i % 9 / 3];
        const double *base = at->limits->base + i / 9 * 9 + i % 3;
        at->turn[i] = column[0] * base[0] + column[1] * base[3] + column[2] * base[6];
    }
}

/* What a column of the limits is where torques and wrenches have these values. */
static mrts_lanes mrts_dense_column(const mrts_dense_lanes *at, int column, const mrts_lanes *torque,
                                                  const mrts_lanes *wrench) {
    if (column < MRTS_JOINTS) return torque[column];
    if (column < MRTS_JOINTS + MRTS_WRENCHES) return wrench[column - MRTS_JOINTS];
    const int place = column - MRTS_JOINTS - MRTS_WRENCHES, axis = place % MRTS_SIZE % 3;
    const mrts_lanes *turn = at->turn + 9 * (place / MRTS_SIZE) + 3 * axis, *given = wrench + place - axis;
    return turn[0] * given[0] + turn[1] * given[1] + turn[2] * given[2];
}

/* A row of the limits where torques and wrenches have these values, in its unit. */
static mrts_lanes mrts_dense_row(const mrts_dense_lanes *at, int row, double per_unit, const mrts_lanes *torque,
                                               const mrts_lanes *wrench) {
    const mrts_limits *limits = at->limits;
    mrts_lanes sum = mrts_each(0);
    for (int entry = limits->start[row]; entry < limits->start[row + 1]; ++entry) {
        sum += limits->value[entry] * per_unit * mrts_dense_column(at, limits->column[entry], torque, wrench);
    }
    return sum;
}

/* Torques and wrenches of given free ones. */
static void mrts_dense_held(const mrts_dense_lanes *at, const mrts_lanes *free, mrts_lanes *torque,
                                          mrts_lanes *wrench) {
    enum { K = MRTS_UNKNOWNS, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    for (int i = 0; i < M; ++i) torque[i] = at->torque[K * M + i] + at->c2 * at->torque[(K - 1) * M + i];
    for (int i = 0; i < N; ++i) wrench[i] = at->wrench[K * N + i] + at->c2 * at->wrench[(K - 1) * N + i];
    for (int j = 0; j < K - 1; ++j) {
        for (int i = 0; i < M; ++i) torque[i] += free[j] * at->torque[j * M + i];
        for (int i = 0; i < N; ++i) wrench[i] += free[j] * at->wrench[j * N + i];
    }
}

/* A row's value with all that is added to it. */
static mrts_lanes mrts_dense_value(const mrts_dense_lanes *at, int row, double per_unit,
                                                 const mrts_lanes *torque, const mrts_lanes *wrench) {
    const mrts_terms *terms = at->terms;
    const int rows = at->limits->rows;
    mrts_lanes value = mrts_dense_row(at, row, per_unit, torque, wrench);
    if (terms->square) value += mrts_term(terms->square, at->samples, rows, row) * (at->c2 * per_unit);
    if (terms->offset) value += mrts_term(terms->offset, at->samples, rows, row) * per_unit;
    return value;
}

MRTS_LOCAL void mrts_dense_passed(const mrts_dense_lanes *at, const mrts_lanes *free, mrts_lanes *most,
                                            mrts_lane_mask *finite) {
    const mrts_limits *limits = at->limits;
    mrts_lanes torque[MRTS_JOINTS], wrench[MRTS_WRENCHES];
    mrts_dense_held(at, free, torque, wrench);
    *most = mrts_each(0);
    *finite = MRTS_EVERY_LANE;
    for (int i = 0; i < at->of->count; ++i) {
        const int row = at->of->which[i];
        const double low = limits->lower[row], high = limits->upper[row], per_unit = 1 / at->of->unit[i];
        const mrts_lanes value = mrts_dense_value(at, row, per_unit, torque, wrench);
        const mrts_lanes above = value - high * per_unit, below = low * per_unit - value;
        mrts_lanes over = mrts_larger_lanes(above, below);
        if (at->terms->margin) over += mrts_term(at->terms->margin, at->samples, limits->rows, row) * per_unit;
        *finite &= mrts_sizes(value) < MRTS_INFINITY;
        *most = mrts_larger_lanes(*most, over);
    }
}

/* Solves G y = b, G symmetric and positive definite, by its factors L D L', which G then holds; `again` takes them. What is
 * not definite gives no numbers, or none of worth. */
static void mrts_dense_solve(int m, mrts_lanes *G, mrts_lanes *b, int again) {
    for (int j = 0; j < m && !again; ++j) {
        for (int i = j + 1; i < m; ++i) {
            const mrts_lanes factor = G[i * m + j] / G[j * m + j];
            for (int l = j + 1; l <= i; ++l) G[i * m + l] -= factor * G[l * m + j];
        }
        for (int i = j + 1; i < m; ++i) G[i * m + j] /= G[j * m + j];
    }
    for (int i = 0; i < m; ++i) {
        for (int l = 0; l < i; ++l) b[i] -= G[i * m + l] * b[l];
    }
    for (int i = m - 1; i >= 0; --i) {
        b[i] /= G[i * m + i];
        for (int l = i + 1; l < m; ++l) b[i] -= G[l * m + i] * b[l];
    }
}

MRTS_LOCAL void mrts_dense_bound(const mrts_dense_lanes *at, const mrts_wrenches_before *known, mrts_lanes *free) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    const int m = known->count;
    mrts_lanes A[K * K], G[K * K], y[K], limit[K];
    for (int j = 0; j < m; ++j) {
        const int upper = known->active[j] > 0, i = mrts_abs(known->active[j]) - 1, row = at->of->which[i];
        const double per_unit = 1 / at->of->unit[i];
        for (int l = 0; l < F; ++l) {
            A[j * F + l] = mrts_dense_row(at, row, per_unit, at->torque + l * M, at->wrench + l * N);
        }
        limit[j] = mrts_each((upper ? at->limits->upper[row] : at->limits->lower[row]) * per_unit);
        if (at->terms->margin) {
            const mrts_lanes margin = mrts_term(at->terms->margin, at->samples, at->limits->rows, row);
            limit[j] -= margin * (upper ? per_unit : -per_unit);
        }
        for (int other = 0; other <= j; ++other) {
            mrts_lanes sum = mrts_each(0);
            for (int l = 0; l < F; ++l) sum += A[j * F + l] * (known->scale[l] * known->scale[l]) * A[other * F + l];
            G[j * m + other] = sum;
        }
    }
    mrts_lanes torque[M], wrench[N], step[K];
    mrts_dense_held(at, free, torque, wrench);
    for (int j = 0; j < m; ++j) {
        const int i = mrts_abs(known->active[j]) - 1;
        limit[j] -= mrts_dense_value(at, at->of->which[i], 1 / at->of->unit[i], torque, wrench);
        y[j] = limit[j];
    }
    for (int l = 0; l < F; ++l) step[l] = mrts_each(0);
    for (int pass = 0; pass < 2 && m > 0; ++pass) {
        for (int j = 0; j < m && pass > 0; ++j) {
            y[j] = limit[j];
            for (int l = 0; l < F; ++l) y[j] -= A[j * F + l] * step[l];
        }
        mrts_dense_solve(m, G, y, pass);
        for (int l = 0; l < F; ++l) {
            for (int j = 0; j < m; ++j) step[l] += A[j * F + l] * (known->scale[l] * known->scale[l]) * y[j];
        }
    }
    for (int l = 0; l < F; ++l) free[l] += step[l];
}

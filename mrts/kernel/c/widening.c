/* SPDX-License-Identifier: MIT
 *
 * By how much the limits of a sample must move outward before they admit a given c^2. Where they need not, wrenches that
 * keep them all show it: those of the sample before, moved so that the rows that bound them there still do. Where these do
 * not, the nearest that do are looked for, and where there are none a linear program finds the least widening. */
#include "lanes/lanes.h"
#include "quadratic_programs.h"

/* What is known of the wrenches when a sample is looked at. */
typedef struct {
    double wrench[MRTS_UNKNOWNS]; /* those of the sample before that are free */
    double scale[MRTS_UNKNOWNS];  /* what a step of each is measured by */
    int active[MRTS_UNKNOWNS];    /* rows that bounded them, coded as the basis of a linear program */
    int count;                    /* of those; -1 where nothing is known */
} mrts_wrenches_before;

/* By how much free wrenches pass the limits of some samples, at most; 0 where they do not. Takes from `finite` the samples of
 * which that is no number. */
static mrts_lanes mrts_passed(const mrts_rows_lanes *rows, const mrts_lanes *free, mrts_lane_mask *finite) {
    enum { F = MRTS_UNKNOWNS - 1 };
    mrts_lanes most = mrts_each(0);
    for (int i = 0; i < rows->count; ++i) {
        const mrts_lanes less = mrts_less_lanes(F, mrts_each(0), rows->A + i * F, 1, free);
        const mrts_lanes value = mrts_larger_lanes(-less - rows->upper[i], rows->lower[i] + less);
        *finite &= mrts_sizes(value) < MRTS_INFINITY;
        most = mrts_larger_lanes(most, value);
    }
    return most;
}

/* Moves free wrenches as little as it takes to put the rows that bounded them before at their limits. */
static void mrts_bound_again(const mrts_rows_lanes *rows, const mrts_wrenches_before *known, mrts_lanes *free) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    const int m = known->count;
    mrts_lanes G[K * K], D[K * K], y[K]; /* D: their coefficients by the squares of the scales */
    for (int j = 0; j < m; ++j) {
        const mrts_lanes *a = rows->A + (mrts_abs(known->active[j]) - 1) * F;
        for (int l = 0; l < F; ++l) D[j * F + l] = a[l] * (known->scale[l] * known->scale[l]);
        for (int other = 0; other <= j; ++other) {
            const mrts_lanes *b = rows->A + (mrts_abs(known->active[other]) - 1) * F;
            G[j * m + other] = -mrts_less_lanes(F, mrts_each(0), D + j * F, 1, b);
        }
    }
    mrts_cholesky_lanes(m, G, G);
    for (int pass = 0; pass < 2; ++pass) {
        for (int j = 0; j < m; ++j) {
            const int row = mrts_abs(known->active[j]) - 1;
            y[j] = mrts_less_lanes(F, known->active[j] > 0 ? rows->upper[row] : rows->lower[row], rows->A + row * F, 1, free);
        }
        mrts_lane_forward(m, G, y);
        mrts_lane_backward(m, G, y);
        for (int j = 0; j < m; ++j) {
            MRTS_UNROLL
            for (int l = 0; l < F; ++l) free[l] += D[j * F + l] * y[j];
        }
    }
}

/* Least s >= 0 such that some x keeps all limits moved outward by s: min s, lower - s <= A x <= upper + s. Both are put
 * into x, Shape (k), s last; returns a status of mrts_lp. */
static int mrts_elastic(int k, const mrts_rows *rows, int *basis, double *x, double *work, int *iwork) {
    const int most = 2 * rows->count;
    double *A = work, *lower = A + most * k, *upper = lower + most + k, y[MRTS_UNKNOWNS], g[MRTS_UNKNOWNS];
    int count = 0, entering;
    for (int i = 0; i < rows->count; ++i) {
        for (int side = 0; side < 2; ++side) {
            if (side ? rows->upper[i] >= MRTS_INFINITY : rows->lower[i] <= -MRTS_INFINITY) continue;
            for (int j = 0; j < k - 1; ++j) A[count * k + j] = rows->A[i * (k - 1) + j];
            A[count * k + k - 1] = side ? -1 : 1;
            lower[count] = side ? -MRTS_INFINITY : rows->lower[i];
            upper[count++] = side ? rows->upper[i] : MRTS_INFINITY;
        }
    }
    for (int j = 0; j < k; ++j) {
        lower[count + j] = j < k - 1 ? -MRTS_INFINITY : 0;
        upper[count + j] = MRTS_INFINITY;
        g[j] = j < k - 1 ? 0 : 1;
    }
    const int status = mrts_lp_again(k, count, A, lower, upper, g, basis, x, y, &entering, upper + most + k, iwork);
    if (status != MRTS_OPTIMAL) basis[0] = 0;
    return status;
}

/* The widening of one sample, whose rows stand over the free wrenches, by programs; its status. `work` is of both. */
static int mrts_widening_of_sample(mrts_rows *rows, mrts_wrenches_before *known, int *basis, double *share, double *work,
                                   int *iwork) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    double x[K], H[K * K] = {0}, g[K], u[K]; /* of the point of scaled rows nearest to the wrenches before */
    *share = 0;
    mrts_scale_columns(F, rows, known->scale);
    for (int j = 0; j < F; ++j) {
        H[j * F + j] = 1;
        g[j] = known->count < 0 ? 0 : -known->wrench[j] / known->scale[j];
    }
    int status = mrts_qp(F, rows->count, H, rows->A, rows->lower, rows->upper, g, x, known->active, u, &known->count, work, iwork);
    if (status != MRTS_OPTIMAL) {
        status = mrts_elastic(K, rows, basis, x, work + MRTS_QP_WORK(F), iwork);
        *share = x[F];
        known->count = status == MRTS_OPTIMAL ? 0 : -1;
    }
    for (int j = 0; j < F; ++j) known->wrench[j] = x[j] * known->scale[j];
    return status;
}

/* Of samples 0 .. count - 1 the least widening of all limits that admits c2, one a sample, in shares of each, of which 100 %
 * are a `unit`; `terms` and what is returned as in mrts_ranges. A sample that is not MRTS_OPTIMAL has no answer. */
MRTS_EXPORT int mrts_widenings(long long count, const double *const *in, const long long *stride, const mrts_limits *limits,
                               const mrts_terms *terms, const double *c2, const double *unit, double *share,
                               unsigned char *status, double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    const int sides = 2 * limits->rows;
    double *own_work = work + MRTS_ROWS_WORK(K, limits->rows);
    double *lanes_work = own_work + MRTS_QP_WORK(F) + sides * K + 2 * (sides + K) + MRTS_LP_WORK(K);
    int basis[K] = {0}, tried = 0; /* whether what is known of the wrenches has been tried on the samples at hand */
    mrts_wrenches_before known = {.count = -1};
    mrts_lanes free[K], most = mrts_each(0);
    mrts_lane_mask finite = {0};
    mrts_samples samples;
    mrts_rows rows;
    if (!mrts_rows_over(K, limits, work, iwork, &rows)) return 1;
    for (int i = 0; i < rows.count; ++i) rows.unit[i] = unit[rows.which[i]];
    mrts_samples_in(limits, terms, &rows, lanes_work, &samples);
    for (long long n = 0; n < count; ++n) {
        const int lane = (int)(n % MRTS_LANES);
        if (lane == 0) {
            mrts_take_samples(in, stride, n, count, n == 0, &samples);
            mrts_fix_speed_lanes(K, limits, mrts_term(c2, samples.inputs.at, 1, 0), 0, &samples.rows);
            tried = 0;
        }
        if (!tried && (F == 0 || known.count >= 0)) {
            for (int j = 0; j < F; ++j) free[j] = mrts_each(known.wrench[j]);
            if (F > 0) mrts_bound_again(&samples.rows, &known, free);
            finite = samples.finite;
            most = mrts_passed(&samples.rows, free, &finite);
            tried = 1;
        }
        if (tried && finite[lane] && (F == 0 || most[lane] <= MRTS_FEASIBLE)) {
            status[n] = MRTS_OPTIMAL;
            share[n] = F > 0 ? 0 : most[lane];
            mrts_take_lane(F, free, lane, known.wrench);
            continue;
        }
        tried = 0;
        status[n] = MRTS_STOPPED;
        if (F == 0 || !samples.finite[lane]) {
            known.count = -1;
            continue;
        }
        mrts_rows_of_lane(F, &samples, lane, &rows);
        status[n] = (unsigned char)mrts_widening_of_sample(&rows, &known, basis, share + n, own_work, iwork + rows.count);
    }
    return 0;
}

/* SPDX-License-Identifier: MIT
 *
 * By how much the limits of a sample must move outward before they admit a given c^2. Where they need not, the wrenches of
 * the sample before often keep them as they are, or the wrenches nearest to those do; else a linear program says it.
 */
#include "../quadratic_programs.h"
#include "../trajectory.h"

/* Sizes of the elastic program: each limit by itself, one more unknown. */
#define MRTS_ELASTIC(rows) (2 * (rows))

MRTS_EXPORT void mrts_widenings_work(int rows, long long *reals, long long *ints) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    const int sides = MRTS_ELASTIC(rows), elastic = sides * K + 2 * (sides + K) + MRTS_LP_WORK(K);
    const int sides_ints = MRTS_LP_IWORK(K, sides), nearest_ints = MRTS_QP_IWORK(F, rows);
    *reals = MRTS_ROWS_WORK(K, rows) + MRTS_QP_WORK(F) + elastic;
    *ints = MRTS_ROWS_IWORK(rows) + (sides_ints > nearest_ints ? sides_ints : nearest_ints);
}

/* By how much rows over k unknowns are passed at x, at most 0 if none is. */
static double mrts_passed(int k, const mrts_rows *rows, const double *x) {
    double most = 0;
    for (int i = 0; i < rows->count; ++i) {
        const double value = mrts_dot(k, rows->A + i * k, x);
        const double above = value - rows->upper[i], below = rows->lower[i] - value, over = above > below ? above : below;
        if (!(over <= most)) most = over;
    }
    return most;
}

/* Whether no row is passed by more than rounding of its limit. */
static int mrts_keeps_rows(int k, const mrts_rows *rows, const double *x) {
    for (int i = 0; i < rows->count; ++i) {
        const double value = mrts_dot(k, rows->A + i * k, x);
        const double above = value - rows->upper[i], below = rows->lower[i] - value;
        const double limit = above > below ? rows->upper[i] : rows->lower[i];
        if (!((above > below ? above : below) <= MRTS_FEASIBLE * (1 + MRTS_ABS(limit)))) return 0;
    }
    return 1;
}

/* The point of the rows nearest to x, which it replaces; 0 where there is none, or none was found. */
static int mrts_nearest_kept(int k, const mrts_rows *rows, double *x, double *work, int *iwork) {
    double H[MRTS_UNKNOWNS * MRTS_UNKNOWNS], g[MRTS_UNKNOWNS], found[MRTS_UNKNOWNS], u[MRTS_UNKNOWNS];
    int active[MRTS_UNKNOWNS], count;
    for (int i = 0; i < k * k; ++i) H[i] = 0;
    for (int j = 0; j < k; ++j) {
        H[j * k + j] = 1;
        g[j] = -x[j];
    }
    if (mrts_qp(k, rows->count, H, rows->A, rows->lower, rows->upper, g, found, active, u, &count, work, iwork) !=
        MRTS_OPTIMAL) {
        return 0;
    }
    for (int j = 0; j < k; ++j) x[j] = found[j];
    return 1;
}

/* Least s >= 0 such that some x keeps all limits moved outward by s: min s, lower - s <= A x <= upper + s. Both are put
 * into x, Shape (k), s last; returns a status of mrts_lp. */
static int mrts_elastic(int k, const mrts_rows *rows, int *basis, double *x, double *work, int *iwork) {
    const int most = MRTS_ELASTIC(rows->count);
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
    int status = mrts_lp(k, count, A, lower, upper, g, basis, x, y, &entering, upper + most + k, iwork);
    if (status != MRTS_OPTIMAL && basis[0] != 0) {
        basis[0] = 0;
        status = mrts_lp(k, count, A, lower, upper, g, basis, x, y, &entering, upper + most + k, iwork);
    }
    if (status != MRTS_OPTIMAL) basis[0] = 0;
    return status;
}

/* Of samples 0 .. count - 1 the least widening of all limits that admits c2, one a sample, in shares of each, of which 100 %
 * are a `unit`; `terms` and what is returned as in mrts_ranges. A sample that is not MRTS_OPTIMAL has no answer. */
MRTS_EXPORT int mrts_widenings(long long count, const double *const *in, const long long *stride,
                               const mrts_limits *limits, const mrts_terms *terms, const double *c2, const double *unit,
                               double *share, unsigned char *status, const double **arg, double **res, long long *iw, double *w,
                               double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    double *qp_work = work + MRTS_ROWS_WORK(K, limits->rows), *elastic_work = qp_work + MRTS_QP_WORK(F);
    int *own_iwork = iwork + MRTS_ROWS_IWORK(limits->rows), basis[K];
    double wrench[K] = {0}, x[K], column[K];
    double memory[MRTS_FORM_WORK(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES)];
    double turned[MRTS_TURNED_WORK(MRTS_UNKNOWNS, MRTS_WRENCHES)];
    mrts_form form = mrts_form_in(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES, memory);
    mrts_rows rows;
    if (!mrts_rows_over(K, limits, work, iwork, &rows)) return 1;
    for (int i = 0; i < rows.count; ++i) rows.unit[i] = unit[rows.which[i]];
    for (long long n = 0; n < count; ++n) {
        if (n % MRTS_CHUNK == 0) { /* so that chunks do not depend on each other */
            for (int j = 0; j < F; ++j) wrench[j] = 0;
            basis[0] = 0;
        }
        const int built = mrts_rows_of_sample(in, stride, n, &form, turned, limits, terms, &rows, arg, res, iw, w);
        if (built < 0) return 1;
        status[n] = MRTS_STOPPED;
        if (!built) continue;
        mrts_fix_speed(K, limits, c2[n], 0, &rows);
        share[n] = F > 0 ? 0 : mrts_passed(F, &rows, wrench);
        status[n] = MRTS_OPTIMAL;
        if (F == 0 || mrts_keeps_rows(F, &rows, wrench)) continue;
        mrts_scale_columns(F, &rows, column);
        mrts_free_unknowns(F, &rows);
        for (int j = 0; j < F; ++j) x[j] = wrench[j] / column[j];
        if (!mrts_nearest_kept(F, &rows, x, qp_work, own_iwork)) {
            status[n] = (unsigned char)mrts_elastic(K, &rows, basis, x, elastic_work, own_iwork);
            share[n] = x[F];
        }
        for (int j = 0; j < F && status[n] == MRTS_OPTIMAL; ++j) wrench[j] = x[j] * column[j];
    }
    return 0;
}

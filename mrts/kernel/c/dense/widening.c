/* SPDX-License-Identifier: MIT
 *
 * By how much the limits of a sample must move outward before they admit a given c^2. Where they need not, wrenches that
 * keep them all show it: those of the sample before, moved so that the rows that bound them there still do. Where these do
 * not, the nearest that do are looked for, and where there are none a linear program finds the least widening.
 */
#include "../quadratic_programs.h"
#include "../tracking/null_space.h"
#include "../trajectory.h"

/* Sides of so many rows: each limit by itself. */
#define MRTS_SIDES(rows) (2 * (rows))

MRTS_EXPORT void mrts_widenings_work(int rows, long long *reals, long long *ints) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    const int sides = MRTS_SIDES(rows), sides_ints = MRTS_LP_IWORK(K, sides), nearest_ints = MRTS_QP_IWORK(F, rows);
    *reals = MRTS_ROWS_WORK(K, rows) + MRTS_QP_WORK(F) + sides * K + 2 * (sides + K) + MRTS_LP_WORK(K);
    *ints = MRTS_ROWS_IWORK(rows) + (sides_ints > nearest_ints ? sides_ints : nearest_ints);
}

/* What is known of the wrenches when a sample is looked at. */
typedef struct {
    double wrench[MRTS_UNKNOWNS]; /* those of the sample before that are free */
    double scale[MRTS_UNKNOWNS];  /* what a step of each is measured by */
    int active[MRTS_UNKNOWNS];    /* rows that bounded them, coded as the basis of a linear program */
    int count;                    /* of those; -1 where nothing is known */
} mrts_wrenches_before;

/* By how much free wrenches pass the limits of rows at most, 0 where they pass none; no number where a row has none. */
static double mrts_passed(int k, const mrts_rows *rows, const double *x) {
    double most = 0;
    for (int i = 0; i < rows->count; ++i) {
        const double value = mrts_dot(k, rows->A + i * k, x);
        const double over = mrts_larger(value - rows->upper[i], rows->lower[i] - value);
        if (!(over <= most)) most = over;
        if (most != most) break;
    }
    return most;
}

/* Moves wrenches by the least step, in units of their scales, that puts them on the rows that bounded those before; 0 where
 * these rows depend on each other. */
static int mrts_onto_active(int k, const mrts_rows *rows, const mrts_wrenches_before *known, double *x) {
    const int m = known->count;
    double G[MRTS_UNKNOWNS * MRTS_UNKNOWNS], y[MRTS_UNKNOWNS];
    for (int pass = 0; pass < 2 && m > 0; ++pass) { /* the second takes what rounding leaves */
        for (int j = 0; j < m; ++j) {
            const int i = mrts_abs(known->active[j]) - 1;
            const double *a = rows->A + i * k;
            y[j] = (known->active[j] > 0 ? rows->upper[i] : rows->lower[i]) - mrts_dot(k, a, x);
            for (int other = 0; other < m; ++other) {
                const double *b = rows->A + (mrts_abs(known->active[other]) - 1) * k;
                double sum = 0;
                for (int l = 0; l < k; ++l) sum += a[l] * (known->scale[l] * known->scale[l]) * b[l];
                G[j * m + other] = sum;
            }
        }
        if (!mrts_eliminate(m, G, y)) return 0;
        for (int j = 0; j < m; ++j) {
            const double *a = rows->A + (mrts_abs(known->active[j]) - 1) * k;
            for (int l = 0; l < k; ++l) x[l] += a[l] * (known->scale[l] * known->scale[l]) * y[j];
        }
    }
    return 1;
}

/* The point of scaled rows nearest to x, which it replaces, and the rows that bound it; 0 where there is none, or none was
 * found. */
static int mrts_nearest_kept(int k, const mrts_rows *rows, double *x, int *active, int *count, double *work,
                             int *iwork) {
    double H[MRTS_UNKNOWNS * MRTS_UNKNOWNS], g[MRTS_UNKNOWNS], found[MRTS_UNKNOWNS], u[MRTS_UNKNOWNS];
    for (int i = 0; i < k * k; ++i) H[i] = 0;
    for (int j = 0; j < k; ++j) {
        H[j * k + j] = 1;
        g[j] = -x[j];
    }
    if (mrts_qp(k, rows->count, H, rows->A, rows->lower, rows->upper, g, found, active, u, count, work, iwork) !=
        MRTS_OPTIMAL) {
        return 0;
    }
    for (int j = 0; j < k; ++j) x[j] = found[j];
    return 1;
}

/* Least s >= 0 such that some x keeps all limits moved outward by s: min s, lower - s <= A x <= upper + s. Both are put
 * into x, Shape (k), s last; returns a status of mrts_lp. */
static int mrts_elastic(int k, const mrts_rows *rows, int *basis, double *x, double *work, int *iwork) {
    const int most = MRTS_SIDES(rows->count);
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

/* What the samples of a call are looked at with. */
typedef struct {
    mrts_rows rows;
    mrts_wrenches_before known;
    int basis[MRTS_UNKNOWNS];
    double *qp_work, *elastic_work;
    int *own_iwork;
} mrts_dense_path;

/* The widening of one sample, whose rows are built over the free wrenches; its status. */
static int mrts_widening_of_sample(mrts_dense_path *path, double *share) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    mrts_wrenches_before *known = &path->known;
    double x[K];
    int status = MRTS_OPTIMAL;
    for (int j = 0; j < F; ++j) x[j] = known->wrench[j];
    if (F == 0 || (known->count >= 0 && mrts_onto_active(F, &path->rows, known, x))) {
        *share = mrts_passed(F, &path->rows, x);
        if (F == 0) return *share < MRTS_INFINITY ? MRTS_OPTIMAL : MRTS_STOPPED;
        if (*share <= MRTS_FEASIBLE) {
            *share = 0;
            for (int j = 0; j < F; ++j) known->wrench[j] = x[j];
            return MRTS_OPTIMAL;
        }
    }
    *share = 0;
    mrts_scale_columns(F, &path->rows, known->scale);
    mrts_free_unknowns(F, &path->rows);
    for (int j = 0; j < F; ++j) x[j] = known->wrench[j] / known->scale[j];
    if (!mrts_nearest_kept(F, &path->rows, x, known->active, &known->count, path->qp_work, path->own_iwork)) {
        status = mrts_elastic(K, &path->rows, path->basis, x, path->elastic_work, path->own_iwork);
        *share = x[F];
        known->count = status == MRTS_OPTIMAL ? 0 : -1;
    }
    for (int j = 0; j < F && status == MRTS_OPTIMAL; ++j) known->wrench[j] = x[j] * known->scale[j];
    return status;
}

/* Of samples 0 .. count - 1 the least widening of all limits that admits c2, one a sample, in shares of each, of which 100 %
 * are a `unit`; `terms` and what is returned as in mrts_ranges. A sample that is not MRTS_OPTIMAL has no answer. */
MRTS_EXPORT int mrts_widenings(long long count, const double *const *in, const long long *stride,
                               const mrts_limits *limits, const mrts_terms *terms, const double *c2, const double *unit,
                               double *share, unsigned char *status,
                               double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    double memory[MRTS_FORM_WORK(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES)];
    double turned[MRTS_TURNED_WORK(MRTS_UNKNOWNS, MRTS_WRENCHES)];
    mrts_form form = mrts_form_in(K, MRTS_JOINTS, MRTS_WRENCHES, memory);
    mrts_dense_path path = {.known = {.count = -1}};
    path.qp_work = work + MRTS_ROWS_WORK(K, limits->rows);
    path.elastic_work = path.qp_work + MRTS_QP_WORK(F);
    path.own_iwork = iwork + MRTS_ROWS_IWORK(limits->rows);
    if (!mrts_rows_over(K, limits, work, iwork, &path.rows)) return 1;
    for (int i = 0; i < path.rows.count; ++i) path.rows.unit[i] = unit[path.rows.which[i]];
    path.known.count = -1;
    path.basis[0] = 0;
    for (long long n = 0; n < count; ++n) {
        for (int j = 0; j < F && path.known.count < 0; ++j) path.known.wrench[j] = 0;
        if (!mrts_rows_of_sample(in, stride, n, &form, turned, limits, terms, &path.rows)) {
            path.known.count = -1;
            status[n] = MRTS_STOPPED;
            continue;
        }
        mrts_fix_speed(K, limits, c2[n], 0, &path.rows);
        status[n] = (unsigned char)mrts_widening_of_sample(&path, share + n);
    }
    return 0;
}

/* SPDX-License-Identifier: MIT
 *
 * By how much the limits of a sample must move outward before they admit a given c^2. Where they need not, wrenches that
 * keep them all show it: those of the sample before, moved so that the rows that bound them there still do. Where these do
 * not, the nearest that do are looked for, and where there are none a linear program finds the least widening.
 */
#include "../lanes/forms.h"
#include "../quadratic_programs.h"
#include "../trajectory.h"

/* Sides of so many rows: each limit by itself. */
#define MRTS_SIDES(rows) (2 * (rows))

MRTS_EXPORT void mrts_widenings_work(int rows, long long *reals, long long *ints) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    const int sides = MRTS_SIDES(rows), elastic = sides * K + 2 * (sides + K) + MRTS_LP_WORK(K);
    const int sides_ints = MRTS_LP_IWORK(K, sides), nearest_ints = MRTS_QP_IWORK(F, rows);
    *reals = 2 * MRTS_ROWS_WORK(K, rows) + MRTS_QP_WORK(F) + elastic;
    *ints = 2 * MRTS_ROWS_IWORK(rows) + (sides_ints > nearest_ints ? sides_ints : nearest_ints);
}

/* A sample: its form, the terms of its rows and where these are put. */
typedef struct {
    mrts_form form;
    mrts_terms terms;
    const mrts_limits *limits;
    const double *rotation;
    double c2;
    double *turned; /* memory for the wrenches in object axes */
} mrts_dense_sample;

/* The rows that `rows` names, over the free wrenches; returns 0 where a coefficient is not finite. */
static int mrts_free_rows(mrts_dense_sample *at, mrts_rows *rows) {
    enum { K = MRTS_UNKNOWNS };
    mrts_turn_wrenches(K, MRTS_ROBOTS, MRTS_SIZE, at->limits, at->rotation, 1, 3, at->turned, &at->form);
    if (!mrts_build_rows(K, MRTS_JOINTS, MRTS_WRENCHES, &at->form, at->limits, &at->terms, rows)) return 0;
    mrts_fix_speed(K, at->limits, at->c2, 0, rows);
    return 1;
}

/* By how much the rows that `rows` names are passed with given free wrenches, in shares of each limit, less what is rounding
 * of it where `rounding` is set; at most 0 if none is, and no number where a row has none. */
static double mrts_passed(const mrts_dense_sample *at, const double *free, int rounding, mrts_rows *rows) {
    enum { F = MRTS_UNKNOWNS - 1, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    double memory[MRTS_FORM_WORK(1, MRTS_JOINTS, MRTS_WRENCHES)], turned[MRTS_TURNED_WORK(1, MRTS_WRENCHES)], most = 0;
    mrts_form held = mrts_form_in(1, M, N, memory);
    for (int i = 0; i < M; ++i) held.torque_map[i] = at->form.torque_map[F * M + i];
    for (int i = 0; i < N; ++i) held.wrench_map[i] = at->form.wrench_map[F * N + i];
    for (int i = 0; i < M; ++i) held.torque_offset[i] = at->form.torque_offset[i];
    for (int i = 0; i < N; ++i) held.wrench_offset[i] = at->form.wrench_offset[i];
    for (int j = 0; j < F; ++j) {
        for (int i = 0; i < M; ++i) held.torque_offset[i] += free[j] * at->form.torque_map[j * M + i];
        for (int i = 0; i < N; ++i) held.wrench_offset[i] += free[j] * at->form.wrench_map[j * N + i];
    }
    mrts_turn_wrenches(1, MRTS_ROBOTS, MRTS_SIZE, at->limits, at->rotation, 1, 3, turned, &held);
    if (!mrts_build_rows(1, M, N, &held, at->limits, &at->terms, rows)) return NAN;
    for (int i = 0; i < rows->count; ++i) {
        const double value = rows->A[i] * at->c2, above = value - rows->upper[i], below = rows->lower[i] - value;
        const double over = above > below ? above : below, limit = above > below ? rows->upper[i] : rows->lower[i];
        if (!(over <= (rounding ? MRTS_FEASIBLE * (1 + MRTS_ABS(limit)) : 0)) && !(over <= most)) most = over;
    }
    return most;
}

/* Solves G y = b, G symmetric and positive definite, Shape (m, m); `again` takes the factor that G then holds. 0 if it is
 * not definite. */
static int mrts_definite_solve(int m, double *G, double *b, int again) {
    for (int j = 0; j < m && !again; ++j) {
        for (int i = j; i < m; ++i) {
            double sum = G[i * m + j];
            for (int l = 0; l < j; ++l) sum -= G[i * m + l] * G[j * m + l];
            if (i > j) {
                G[i * m + j] = sum / G[j * m + j];
            } else if (sum > 0) {
                G[j * m + j] = MRTS_SQRT(sum);
            } else {
                return 0;
            }
        }
    }
    for (int i = 0; i < m; ++i) b[i] = (b[i] - mrts_dot(i, G + i * m, b)) / G[i * m + i];
    for (int i = m - 1; i >= 0; --i) {
        for (int l = i + 1; l < m; ++l) b[i] -= G[l * m + i] * b[l];
        b[i] /= G[i * m + i];
    }
    return 1;
}

/* The wrenches nearest to those of the sample before whose rows bind again, in the unit of their scale. What they are worth
 * is seen when they are put in. */
static void mrts_bound_again(mrts_dense_sample *at, mrts_wrenches_before *known, const mrts_rows *all, mrts_rows *some) {
    enum { F = MRTS_UNKNOWNS - 1 };
    double G[MRTS_UNKNOWNS * MRTS_UNKNOWNS], y[MRTS_UNKNOWNS];
    const int m = known->count;
    some->count = m;
    for (int j = 0; j < m; ++j) {
        const int row = (known->active[j] < 0 ? -known->active[j] : known->active[j]) - 1;
        some->which[j] = all->which[row];
        some->unit[j] = all->unit[row];
    }
    if (m <= 0 || !mrts_free_rows(at, some)) return;
    for (int i = 0; i < m; ++i) {
        for (int j = 0; j <= i; ++j) {
            G[i * m + j] = 0;
            for (int l = 0; l < F; ++l) {
                G[i * m + j] += some->A[i * F + l] * known->scale[l] * known->scale[l] * some->A[j * F + l];
            }
        }
    }
    for (int pass = 0; pass < 2; ++pass) {
        for (int j = 0; j < m; ++j) {
            y[j] = (known->active[j] < 0 ? some->lower[j] : some->upper[j]) - mrts_dot(F, some->A + j * F, known->wrench);
        }
        if (!mrts_definite_solve(m, G, y, pass)) return;
        for (int j = 0; j < m; ++j) {
            for (int l = 0; l < F; ++l) {
                known->wrench[l] += some->A[j * F + l] * known->scale[l] * known->scale[l] * y[j];
            }
        }
    }
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

/* The samples of a call. */
typedef struct {
    mrts_dense_sample at;
    mrts_rows rows, some; /* all, and those that bound */
    mrts_wrenches_before known;
    int basis[MRTS_UNKNOWNS];
    double *qp_work, *elastic_work;
    int *own_iwork;
} mrts_dense_path;

/* The widening of one sample, whose form is there, from what is known of the one before; its status. */
static int mrts_widening_of_sample(mrts_dense_path *path, double *share) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    mrts_wrenches_before *known = &path->known;
    double x[K];
    int status = MRTS_OPTIMAL;
    if (F == 0) {
        *share = mrts_passed(&path->at, known->wrench, 0, &path->rows);
        return *share < MRTS_INFINITY ? MRTS_OPTIMAL : MRTS_STOPPED;
    }
    *share = 0;
    mrts_bound_again(&path->at, known, &path->rows, &path->some);
    if (known->count >= 0 && mrts_passed(&path->at, known->wrench, 1, &path->rows) == 0) return MRTS_OPTIMAL;
    if (!mrts_free_rows(&path->at, &path->rows)) {
        known->count = -1;
        return MRTS_STOPPED;
    }
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

/* Some samples of a call. */
typedef struct {
    mrts_lane_inputs inputs;
    mrts_dense_lanes at;
    mrts_lanes free[MRTS_UNKNOWNS], most;
    mrts_lane_mask finite;
    int tried; /* whether what is known of the wrenches has been tried on them */
} mrts_widening_lanes;

/* Takes the samples from `first` on. */
static void mrts_take_widening(const double *const *in, const long long *stride, long long first, long long count,
                               const double *c2, mrts_widening_lanes *lanes) {
    mrts_take_inputs(in, stride, first, count, first == 0, &lanes->inputs);
    for (int lane = 0; lane < MRTS_LANES; ++lane) lanes->at.c2[lane] = c2[lanes->inputs.at[lane]];
    mrts_dense_form(lanes->inputs.arg, &lanes->at);
    lanes->tried = 0;
}

/* Whether a sample's widening is that of wrenches known before, which it then has moved. */
static int mrts_widening_in_lanes(mrts_widening_lanes *lanes, int lane, mrts_wrenches_before *known, double *share) {
    enum { F = MRTS_UNKNOWNS - 1 };
    if (F > 0 && known->count < 0) return 0;
    if (!lanes->tried) {
        for (int j = 0; j < F; ++j) lanes->free[j] = (mrts_lanes){0} + known->wrench[j];
        if (F > 0) mrts_dense_bound(&lanes->at, known, lanes->free);
        mrts_dense_passed(&lanes->at, lanes->free, &lanes->most, &lanes->finite);
        lanes->tried = 1;
    }
    if (!lanes->finite[lane] || (F > 0 && !(lanes->most[lane] <= MRTS_FEASIBLE))) {
        lanes->tried = 0;
        return 0;
    }
    *share = F > 0 ? 0 : lanes->most[lane];
    for (int j = 0; j < F; ++j) known->wrench[j] = lanes->free[j][lane];
    return 1;
}

/* The form of one of them, with what motors give. */
static void mrts_form_of_lane(const mrts_dense_lanes *at, int lane, mrts_form *form) {
    enum { K = MRTS_UNKNOWNS, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    mrts_take_lane(K * M, at->torque, lane, form->torque_map);
    mrts_take_lane(M, at->torque + K * M, lane, form->torque_offset);
    mrts_take_lane(K * N, at->wrench, lane, form->wrench_map);
    mrts_take_lane(N, at->wrench + K * N, lane, form->wrench_offset);
}

/* Of samples 0 .. count - 1 the least widening of all limits that admits c2, one a sample, in shares of each, of which 100 %
 * are a `unit`; `terms` and what is returned as in mrts_ranges. A sample that is not MRTS_OPTIMAL has no answer. */
MRTS_EXPORT int mrts_widenings(long long count, const double *const *in, const long long *stride,
                               const mrts_limits *limits, const mrts_terms *terms, const double *c2, const double *unit,
                               double *share, unsigned char *status,
                               double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    double *few_work = work + MRTS_ROWS_WORK(K, limits->rows);
    int *few_iwork = iwork + MRTS_ROWS_IWORK(limits->rows);
    double memory[MRTS_FORM_WORK(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES)];
    double turned[MRTS_TURNED_WORK(MRTS_UNKNOWNS, MRTS_WRENCHES)];
    mrts_dense_path path = {.at = {.limits = limits, .turned = turned}, .known = {.count = -1}};
    path.qp_work = few_work + MRTS_ROWS_WORK(K, limits->rows);
    path.elastic_work = path.qp_work + MRTS_QP_WORK(F);
    path.own_iwork = few_iwork + MRTS_ROWS_IWORK(limits->rows);
    path.at.form = mrts_form_in(K, MRTS_JOINTS, MRTS_WRENCHES, memory);
    if (!mrts_rows_over(K, limits, work, iwork, &path.rows)) return 1;
    if (!mrts_rows_over(K, limits, few_work, few_iwork, &path.some)) return 1;
    for (int i = 0; i < path.rows.count; ++i) path.rows.unit[i] = unit[path.rows.which[i]];
    mrts_widening_lanes lanes;
    lanes.at.limits = limits;
    lanes.at.terms = terms;
    lanes.at.of = &path.rows;
    lanes.at.samples = lanes.inputs.at;
    for (long long n = 0; n < count; ++n) {
        if (n % MRTS_CHUNK == 0) { /* so that chunks do not depend on each other */
            path.known.count = -1;
            path.basis[0] = 0;
        }
        for (int j = 0; j < F && path.known.count < 0; ++j) path.known.wrench[j] = 0;
        const int lane = (int)(n % MRTS_LANES);
        if (lane == 0) mrts_take_widening(in, stride, n, count, c2, &lanes);
        status[n] = MRTS_OPTIMAL;
        if (mrts_widening_in_lanes(&lanes, lane, &path.known, share + n)) continue;
        mrts_form_of_lane(&lanes.at, lane, &path.at.form);
        path.at.terms = mrts_terms_of_sample(terms, n, limits->rows);
        path.at.rotation = in[MRTS_ROTATION] + n * stride[MRTS_ROTATION];
        path.at.c2 = c2[n];
        status[n] = (unsigned char)mrts_widening_of_sample(&path, share + n);
    }
    return 0;
}

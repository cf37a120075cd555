/* SPDX-License-Identifier: MIT
 *
 * By how much the limits of a sample must move outward before they admit a given c^2. Where they need not, wrenches that
 * keep them all show it: those of the sample before, moved so that the rows that bound them there still do. Where these do
 * not, the nearest that do are looked for, and where there are none a linear program finds the least widening.
 */
#include "../lanes/lanes.h"
#include "../quadratic_programs.h"
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

/* Some samples of a dense check: their forms with what motors give, by columns, offsets last, see rows.h. */
typedef struct {
    const mrts_limits *limits;
    const mrts_terms *terms; /* of all samples of the call */
    const mrts_rows *of;     /* which rows, and their units */
    const long long *samples;
    mrts_lanes c2;
    mrts_lanes torque[(MRTS_UNKNOWNS + 1) * MRTS_JOINTS], wrench[(MRTS_UNKNOWNS + 1) * MRTS_WRENCHES];
    mrts_lanes turn[9 * MRTS_ROBOTS]; /* from base axes to those of the object, where limits want them */
} mrts_dense_lanes;

/* Evaluates the wrench form and adds what motors give. */
static void mrts_dense_form(const mrts_lanes *const *arg, mrts_dense_lanes *at) {
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

static void mrts_dense_passed(const mrts_dense_lanes *at, const mrts_lanes *free, mrts_lanes *most,
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

static void mrts_dense_bound(const mrts_dense_lanes *at, const mrts_wrenches_before *known, mrts_lanes *free) {
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
        if (pass == 0) mrts_lane_cholesky(m, G, G);
        mrts_lane_forward(m, G, y);
        mrts_lane_backward(m, G, y);
        for (int l = 0; l < F; ++l) {
            for (int j = 0; j < m; ++j) step[l] += A[j * F + l] * (known->scale[l] * known->scale[l]) * y[j];
        }
    }
    for (int l = 0; l < F; ++l) free[l] += step[l];
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

/* The widening of one sample, whose rows are built over the free wrenches, by programs; its status. */
static int mrts_widening_of_sample(mrts_dense_path *path, double *share) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    mrts_wrenches_before *known = &path->known;
    double x[K];
    int status = MRTS_OPTIMAL;
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
    double memory[MRTS_FORM_WORK(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES)];
    double turned[MRTS_TURNED_WORK(MRTS_UNKNOWNS, MRTS_WRENCHES)];
    mrts_form form = mrts_form_in(K, MRTS_JOINTS, MRTS_WRENCHES, memory);
    mrts_dense_path path = {.known = {.count = -1}};
    path.qp_work = work + MRTS_ROWS_WORK(K, limits->rows);
    path.elastic_work = path.qp_work + MRTS_QP_WORK(F);
    path.own_iwork = iwork + MRTS_ROWS_IWORK(limits->rows);
    if (!mrts_rows_over(K, limits, work, iwork, &path.rows)) return 1;
    for (int i = 0; i < path.rows.count; ++i) path.rows.unit[i] = unit[path.rows.which[i]];
    mrts_widening_lanes lanes;
    lanes.at.limits = limits;
    lanes.at.terms = terms;
    lanes.at.of = &path.rows;
    lanes.at.samples = lanes.inputs.at;
    path.known.count = -1;
    path.basis[0] = 0;
    for (long long n = 0; n < count; ++n) {
        for (int j = 0; j < F && path.known.count < 0; ++j) path.known.wrench[j] = 0;
        const int lane = (int)(n % MRTS_LANES);
        if (lane == 0) mrts_take_widening(in, stride, n, count, c2, &lanes);
        status[n] = MRTS_OPTIMAL;
        if (mrts_widening_in_lanes(&lanes, lane, &path.known, share + n)) continue;
        const mrts_terms here = mrts_terms_of_sample(terms, n, limits->rows);
        mrts_form_of_lane(&lanes.at, lane, &form);
        mrts_turn_wrenches(K, MRTS_ROBOTS, MRTS_SIZE, limits, in[MRTS_ROTATION] + n * stride[MRTS_ROTATION], 1, 3, turned,
                           &form);
        if (F == 0 || !mrts_build_rows(K, MRTS_JOINTS, MRTS_WRENCHES, &form, limits, &here, &path.rows)) {
            path.known.count = -1;
            status[n] = MRTS_STOPPED;
            continue;
        }
        mrts_fix_speed(K, limits, c2[n], 0, &path.rows);
        status[n] = (unsigned char)mrts_widening_of_sample(&path, share + n);
    }
    return 0;
}

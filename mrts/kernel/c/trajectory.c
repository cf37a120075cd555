/* SPDX-License-Identifier: MIT
 *
 * The range of c^2 and the torques along a whole trajectory: the generated wrench form evaluated at each sample, its
 * rows put together, and the programs solved, each started from the answer at the sample before: several samples at a time
 * where that still holds, one by one where it does not. */
#include "lanes/lanes.h"
#include "quadratic_programs.h"
#include "speed_intervals.h"

/* Rounding of an answer at the bound of c^2, as a share. */
#define MRTS_AT_UNBOUNDED 1e-9

/* The wrench form at all samples, as mrts_map gives it, with the column of r'' where the speed varies. */
MRTS_EXPORT void mrts_forms(long long count, int varying, const double *const *in, const long long *stride, double *const *out) {
    enum { K = MRTS_UNKNOWNS, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    const int k = K + varying, sizes[] = {k * M, M, k * N, N};
    mrts_lanes torque[(K + 2) * M], wrench[(K + 2) * N], *const res[] = {torque, torque + k * M, wrench, wrench + k * N};
    mrts_lanes torque_moving[(K + 1) * M], wrench_moving[(K + 1) * N], none[MRTS_JOINTS + 6], sines[2 * M];
    mrts_lanes *const moving[] = {torque_moving, torque_moving + K * M, wrench_moving, wrench_moving + K * N};
    mrts_lane_inputs inputs;
    for (int i = 0; i < M + 6; ++i) none[i] = mrts_each(0);
    for (long long n = 0; n < count; n += MRTS_LANES) {
        mrts_take_inputs(in, stride, n, count, n == 0, &inputs);
        mrts_sines(M, inputs.arg[0], sines);
        if (varying) {
            MRTS_WRENCH_FORM_LANES(inputs.arg, sines, moving);
            inputs.arg[MRTS_DDQ] = inputs.arg[MRTS_DQ];
            inputs.arg[MRTS_ACCELERATION] = inputs.arg[MRTS_TWIST];
            inputs.arg[MRTS_DQ] = inputs.arg[MRTS_TWIST] = none;
        }
        MRTS_WRENCH_FORM_LANES(inputs.arg, sines, res);
        for (int i = 0; varying && i < M; ++i) torque[K * M + i] = torque_moving[(K - 1) * M + i];
        for (int i = 0; varying && i < N; ++i) wrench[K * N + i] = wrench_moving[(K - 1) * N + i];
        for (int lane = 0; lane < MRTS_LANES && n + lane < count; ++lane) {
            for (int i = 0; i < 4; ++i) mrts_take_lane(sizes[i], res[i], lane, out[i] + (n + lane) * sizes[i]);
        }
    }
}

/* The terms of sample n. */
static mrts_terms mrts_terms_at(const mrts_terms *all, long long n, int rows) {
    const mrts_real *const given[] = {all->torque_square, all->torque_offset, all->square, all->offset,
                                      all->margin,        all->torque_speed,  all->speed};
    const mrts_real *at[7];
    for (int i = 0; i < 7; ++i) at[i] = given[i] ? given[i] + n * (i < 2 || i == 5 ? MRTS_JOINTS : rows) : 0;
    return (mrts_terms){at[0], at[1], at[2], at[3], at[4], at[5], at[6]};
}

/* The rows over the k unknowns of `form`, those of all samples in the order of mrts_form, which take the motors in. All rows
 * stand there, with infinite limits where they have none, and their terms in the speed. What r'' adds, its torque_square and
 * square, goes to the last unknown but one. `unit` and `which` are those of rows.h, `work` one form in object axes and k. */
MRTS_EXPORT void mrts_form_rows(long long count, int k, double *const *form, const double *rotation, const mrts_limits *limits,
                                const mrts_terms *terms, const mrts_terms *rate, double *unit, int *which, double *A,
                                double *lower, double *upper, double *speed, double *work) {
    enum { M = MRTS_JOINTS, N = MRTS_WRENCHES };
    const int r = limits->rows;
    for (long long n = 0; n < count; ++n) {
        mrts_rows rows = {r, which, unit, A + n * r * k, lower + n * r, upper + n * r, work};
        mrts_form its = {form[0] + n * k * M, form[1] + n * M, form[2] + n * k * N, form[3] + n * N, 0, 0};
        const mrts_terms own = mrts_terms_at(terms, n, r), by_rate = mrts_terms_at(rate, n, r);
        mrts_add_motors(k, M, &own, &its);
        mrts_add_motors(k - 1, M, &by_rate, &its);
        mrts_turn_wrenches(k, MRTS_ROBOTS, MRTS_SIZE, limits, rotation + 9 * n, 3, 1, work + k, &its);
        mrts_build_rows(k, M, N, &its, limits, &own, &rows);
        if (speed) mrts_speed_column(M, limits, &own, &rows, speed + n * r);
        for (int i = 0; i < r; ++i) {
            if (by_rate.square) rows.A[i * k + k - 2] += by_rate.square[i] / unit[i];
            if (rows.lower[i] <= -MRTS_INFINITY) rows.lower[i] = -INFINITY;
            if (rows.upper[i] >= MRTS_INFINITY) rows.upper[i] = INFINITY;
        }
    }
}

/* Reals and ints of work of each function over samples, of so many rows of limits. */
MRTS_EXPORT void mrts_samples_work(int rows, long long *reals, long long *ints) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    const int sides = 2 * rows; /* each limit by itself */
    *reals = MRTS_ROWS_WORK(K, rows) + MRTS_SAMPLES_WORK(rows) + MRTS_QP_WORK(F) + MRTS_LP_WORK(K) + sides * K +
             2 * (sides + K) + rows + MRTS_CURVE_WORK(K, rows);
    *ints = MRTS_ROWS_IWORK(rows) + MRTS_QP_IWORK(F, rows) + MRTS_LP_IWORK(K, sides) + MRTS_CURVE_IWORK(K, rows);
}

/* A multiplier above this share of the largest binds. */
#define MRTS_BINDING 1e-7

/* The range of c^2 of a sample. */
typedef struct {
    double end[2]; /* least and largest c^2 */
    double gap;    /* a c^2 below the interval, as of mrts_interval */
    double effect; /* the largest on a row, of c^2 = 1 or of c = 1 squared */
    int status;
    float duals[]; /* what binds at the least c^2, then at the largest, so many columns each */
} mrts_range;

static inline mrts_range *mrts_next_range(mrts_range *found, int columns) {
    return (mrts_range *)(void *)((char *)(found + 1) + 2 * columns * (long long)sizeof(float));
}

/* Keeps the multipliers of k rows of a basis that bind at an end (see mrts_lp), positive at an upper limit, negative at a
 * lower one: those of the limits at their `place`, that of c^2 >= 0 in the last of the columns, if there are any. Rows
 * after `rows` are of the unknowns, those of the speed from `speed` on. */
static void mrts_keep_binding(int k, const mrts_rows *rows, int speed, const int *basis, const double *y, const int *place,
                              int columns, float *duals) {
    double largest = 0;
    for (int j = 0; j < k; ++j) largest = fmax(largest, fabs(y[j]));
    for (int j = 0; j < k && columns > 0; ++j) {
        const int row = mrts_abs(basis[j]) - 1, is_limit = row < rows->count;
        if (row < 0 || !(fabs(y[j]) > MRTS_BINDING * largest) || (!is_limit && (row < speed || basis[j] > 0))) continue;
        duals[is_limit ? place[rows->which[row]] : columns - 1] = (float)copysign(y[j], basis[j]);
    }
}

/* Keeps an end of a range, of the answer's unknown c^2 in units of `column`, and what binds there. */
static void mrts_keep_range(const mrts_rows *rows, const int *basis, int end, int status, double c2, double column,
                            const double *y, const int *place, int columns, mrts_range *found) {
    enum { K = MRTS_UNKNOWNS };
    found->status = status;
    found->end[end] = end && c2 >= MRTS_UNBOUNDED * (1 - MRTS_AT_UNBOUNDED) ? INFINITY : c2 * column;
    if (status != MRTS_OPTIMAL) return;
    mrts_keep_binding(K, rows, rows->count + K - 1, basis, y, place, columns, found->duals + end * columns);
}

/* Solves both programs of one sample from the bases of the one before; `column` is the scale of c^2. */
static void mrts_range_of_sample(const mrts_rows *rows, double column, int (*basis)[MRTS_UNKNOWNS], const int *place,
                                 int columns, mrts_range *found, double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS };
    double g[K] = {0}, x[K], y[K] = {0};
    int entering, status = MRTS_OPTIMAL;
    for (int end = 0; end < 2; ++end) {
        g[K - 1] = end ? -1 : 1;
        x[K - 1] = 0;
        if (status == MRTS_OPTIMAL) {
            status = mrts_lp_again(K, rows->count, rows->A, rows->lower, rows->upper, g, basis[end], x, y, &entering, work,
                                   iwork);
        }
        mrts_keep_range(rows, basis[end], end, status, x[K - 1], column, y, place, columns, found);
        if (status != MRTS_OPTIMAL) basis[end][0] = 0;
    }
}

/* The answers of some samples by the bases of the one before. */
typedef struct {
    mrts_lanes x[2][MRTS_UNKNOWNS], y[2][MRTS_UNKNOWNS];
    mrts_lane_mask kept; /* whether both are the answers */
} mrts_kept_ranges;

static void mrts_try_bases(const mrts_samples *samples, int (*basis)[MRTS_UNKNOWNS], mrts_kept_ranges *by) {
    enum { K = MRTS_UNKNOWNS };
    const mrts_rows_lanes *of = &samples->rows;
    mrts_lanes B[K * K], rest[K];
    by->kept = samples->finite;
    for (int end = 0; end < 2; ++end) {
        double g[K] = {0};
        if (basis[end][0] == 0) {
            by->kept = (mrts_lane_mask){0};
            return;
        }
        g[K - 1] = end ? -1 : 1;
        by->kept &= mrts_kept_basis_lanes(K, of->count, of->A, of->lower, of->upper, g, basis[end], by->x[end], by->y[end], B,
                                          rest);
    }
}

/* The ranges, up to `most`, of samples 0 .. count - 1; `terms` are those of all samples one after the other, `columns` and
 * `place` those of mrts_keep_binding. Returns 1 if a lower limit is above its upper one. */
MRTS_EXPORT int mrts_ranges(long long count, const double *const *in, const long long *stride, const mrts_limits *limits,
                            const mrts_terms *terms, const double *most, int columns, const int *place, mrts_range *found,
                            double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS };
    double *lp_work = work + MRTS_ROWS_WORK(K, limits->rows);
    int *lp_iwork = iwork + MRTS_ROWS_IWORK(limits->rows), basis[2][K] = {{0}};
    mrts_samples samples;
    mrts_kept_ranges by;
    mrts_rows rows;
    if (!mrts_rows_over(K, limits, work, iwork, &rows)) return 1;
    mrts_samples_in(limits, terms, &rows, lp_work + MRTS_LP_WORK(K), &samples);
    for (long long n = 0; n < count; ++n, found = mrts_next_range(found, columns)) {
        const int lane = (int)(n % MRTS_LANES);
        if (lane == 0) {
            mrts_take_samples(in, stride, n, count, n == 0, &samples);
            mrts_scale_columns_lanes(K, &samples.rows, samples.column);
            mrts_bound_speed_lanes(K, mrts_term(most, samples.inputs.at, 1, 0), samples.column, &samples.rows);
            mrts_try_bases(&samples, basis, &by);
        }
        const double column = samples.column[K - 1][lane];
        found->effect = samples.rows.size[K - 1][lane] > MRTS_NO_EFFECT ? 1 / column : 0;
        if (by.kept[lane]) {
            for (int end = 0; end < 2; ++end) {
                double y[K];
                mrts_take_lane(K, by.y[end], lane, y);
                const double c2 = by.x[end][K - 1][lane];
                mrts_keep_range(&rows, basis[end], end, MRTS_OPTIMAL, c2, column, y, place, columns, found);
            }
            continue;
        }
        if (samples.finite[lane]) {
            mrts_rows_of_lane(K, &samples, lane, &rows);
            mrts_range_of_sample(&rows, column, basis, place, columns, found, lp_work, lp_iwork);
        } else {
            found->status = MRTS_STOPPED;
            basis[0][0] = basis[1][0] = 0;
        }
        if (lane + 1 < MRTS_LANES) mrts_try_bases(&samples, basis, &by); /* for the samples beside this one */
    }
    return 0;
}

/* As mrts_ranges, where rows have terms in c beside those in c^2: the highest intervals. A tangent is no row. */
MRTS_EXPORT int mrts_speed_ranges(long long count, const double *const *in, const long long *stride,
                                  const mrts_limits *limits, const mrts_terms *terms, const double *most, int columns,
                                  const int *place, mrts_range *found, double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS, N = MRTS_UNKNOWNS + 1 };
    double *speed = work + MRTS_ROWS_WORK(K, limits->rows), *curve_work = speed + limits->rows, column[K], end_dual[2 * N];
    int basis[MRTS_CURVE_BASES * N], end_basis[2 * N];
    mrts_curve_ends ends = {0, basis, end_basis, end_dual};
    mrts_samples samples;
    mrts_curve curve;
    mrts_rows rows;
    if (!mrts_rows_over(K, limits, work, iwork, &rows)) return 1;
    mrts_samples_in(limits, terms, &rows, curve_work + MRTS_CURVE_WORK(K, limits->rows), &samples);
    for (int i = 0; i < MRTS_CURVE_BASES; ++i) basis[i * N] = 0;
    for (long long n = 0; n < count; ++n, found = mrts_next_range(found, columns)) {
        const int lane = (int)(n % MRTS_LANES);
        mrts_interval of;
        if (lane == 0) mrts_take_samples(in, stride, n, count, n == 0, &samples);
        found->status = MRTS_STOPPED;
        if (!samples.finite[lane]) continue;
        const mrts_terms here = mrts_terms_at(terms, n, limits->rows);
        mrts_rows_of_lane(K, &samples, lane, &rows);
        mrts_speed_column(MRTS_JOINTS, limits, &here, &rows, speed);
        mrts_scale_columns(K, &rows, column);
        const double unit =
            mrts_curve_over(K, &rows, column, speed, curve_work, iwork + MRTS_ROWS_IWORK(limits->rows), &curve);
        const double size = unit > 0 ? MRTS_SQRT(unit) : 1;
        found->effect = unit > 0 ? 1 / unit : 0;
        ends.speed /= size;
        found->status = mrts_highest_interval(&curve, MRTS_SQRT(most[n]) / size, &ends, &of);
        ends.speed *= size;
        if (found->status != MRTS_OPTIMAL) continue;
        found->end[0] = of.low * size * (of.low * size);
        found->end[1] = of.high < MRTS_INFINITY ? of.high * size * (of.high * size) : INFINITY;
        found->gap = of.gap * size * (of.gap * size);
        for (int end = 0; end < 2; ++end) {
            mrts_keep_binding(N, &rows, rows.count + N - 1, end_basis + end * N, end_dual + end * N, place, columns,
                              found->duals + end * columns);
        }
    }
    return 0;
}

/* The quadratic programs of the torques of several samples, over the scaled free wrenches. */
typedef struct {
    const mrts_rows_lanes *rows;
    mrts_lanes H[MRTS_UNKNOWNS * MRTS_UNKNOWNS], g[MRTS_UNKNOWNS];
    mrts_lanes L[MRTS_UNKNOWNS * MRTS_UNKNOWNS]; /* H = L L', on the diagonal the reciprocals */
    mrts_lanes x[MRTS_UNKNOWNS];                 /* the answer */
} mrts_lane_program;

/* Of which samples the active rows, coded as those of mrts_qp, are those of the minimiser, verified as there. */
static mrts_lane_mask mrts_kept_torques(mrts_lane_program *program, const int *active, int count) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    const mrts_rows_lanes *rows = program->rows;
    mrts_lanes W[K * K], S[K * K], factor[K * K], u[K], gradient[K], missing[K];
    for (int j = 0; j < count; ++j) { /* L w = a of each active row, and their products */
        const mrts_lanes *a = rows->A + (mrts_abs(active[j]) - 1) * F;
        for (int i = 0; i < F; ++i) W[j * F + i] = active[j] < 0 ? a[i] : -a[i];
        mrts_lane_forward(F, program->L, W + j * F);
        for (int l = 0; l <= j; ++l) S[j * count + l] = -mrts_less_lanes(F, mrts_each(0), W + j * F, 1, W + l * F);
        u[j] = mrts_each(0);
    }
    mrts_cholesky_lanes(count, S, factor);
    for (int i = 0; i < F; ++i) program->x[i] = mrts_each(0);
    for (int pass = 0; pass < 3; ++pass) { /* the minimiser on the rows, and two refinements of it */
        mrts_qp_residuals_lanes(F, rows->count, program->H, rows->A, rows->lower, rows->upper, program->g, active, count,
                                program->x, u, gradient, missing);
        for (int i = 0; i < F; ++i) gradient[i] = -gradient[i];
        mrts_lane_forward(F, program->L, gradient);
        for (int j = 0; j < count; ++j) missing[j] = mrts_less_lanes(F, missing[j], W + j * F, 1, gradient);
        mrts_lane_forward(count, factor, missing);
        mrts_lane_backward(count, factor, missing);
        for (int j = 0; j < count; ++j) {
            u[j] += missing[j];
            for (int i = 0; i < F; ++i) gradient[i] += missing[j] * W[j * F + i];
        }
        mrts_lane_backward(F, program->L, gradient);
        for (int i = 0; i < F; ++i) program->x[i] += gradient[i];
    }
    return mrts_kept_feasible_lanes(F, rows->count, rows->A, rows->lower, rows->upper, program->x) &
           mrts_qp_residuals_lanes(F, rows->count, program->H, rows->A, rows->lower, rows->upper, program->g, active, count,
                                   program->x, u, gradient, missing);
}

/* Torques and wrenches that minimise t'Wt at c2 (one value, or one a sample with c2_stride 1). Limits move outward by
 * `widening` of their unit where they are not equal; `terms` as in mrts_ranges. */
MRTS_EXPORT int mrts_torques(long long count, const double *const *in, const long long *stride, const mrts_limits *limits,
                             const mrts_terms *terms, const double *c2, int c2_stride, const double *weights,
                             double widening, double *torque, double *wrench, unsigned char *status, double *work,
                             int *iwork) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    double *qp_work = work + MRTS_ROWS_WORK(K, limits->rows), H[K * K], g[K], x[K] = {0}, u[K];
    int *qp_iwork = iwork + MRTS_ROWS_IWORK(limits->rows), active[K], active_count = -1; /* where nothing is known */
    mrts_weights W = {weights, M + 1};
    mrts_lanes found[K], t[M], F_all[N], weighted[M], speed;
    mrts_lane_mask kept;
    const mrts_lane_mask none = {0};
    mrts_samples samples;
    mrts_lane_program program = {.rows = &samples.rows};
    mrts_rows rows;
    if (!mrts_rows_over(K, limits, work, iwork, &rows)) return 1;
    mrts_samples_in(limits, terms, &rows, qp_work + MRTS_QP_WORK(F), &samples);
    for (int i = 0; i < M * M; ++i) {
        if (i % (M + 1) != 0 && weights[i] != 0) W.apart = 0;
    }
    for (long long first = 0; first < count; first += MRTS_LANES) {
        mrts_take_samples(in, stride, first, count, first == 0, &samples);
        for (int lane = 0; lane < MRTS_LANES; ++lane) speed[lane] = c2[samples.inputs.at[lane] * c2_stride];
        mrts_torque_program_lanes(K, M, N, limits, &W, speed, widening, &samples.form, &samples.rows, program.H, program.g,
                                  samples.column, weighted, t, F_all);
        mrts_cholesky_lanes(F, program.H, program.L);
        kept = active_count < 0 ? none : mrts_kept_torques(&program, active, active_count) & samples.finite;
        const int here = count - first < MRTS_LANES ? (int)(count - first) : MRTS_LANES;
        for (int lane = 0; lane < here; ++lane) {
            int its = MRTS_OPTIMAL;
            if (kept[lane]) {
                mrts_take_lane(F, program.x, lane, x);
            } else {
                mrts_rows_of_lane(F, &samples, lane, &rows);
                mrts_take_lane(F * F, program.H, lane, H);
                mrts_take_lane(F, program.g, lane, g);
                its = !samples.finite[lane] ? MRTS_STOPPED
                                            : mrts_qp(F, rows.count, H, rows.A, rows.lower, rows.upper, g, x, active, u,
                                                      &active_count, qp_work, qp_iwork);
                if (its != MRTS_OPTIMAL) active_count = -1;
                kept = active_count < 0 ? none : mrts_kept_torques(&program, active, active_count) & samples.finite;
            }
            status[first + lane] = (unsigned char)its;
            for (int j = 0; j < F; ++j) found[j][lane] = x[j];
        }
        mrts_add_free_lanes(K, M, N, &samples.form, samples.column, found, t, F_all);
        for (int lane = 0; lane < here; ++lane) {
            mrts_take_lane(M, t, lane, torque + (first + lane) * M);
            mrts_take_lane(N, F_all, lane, wrench + (first + lane) * N);
        }
    }
    return 0;
}

/* Most rows that are named at an end, or near to it. */
#define MRTS_MOST_NAMED (4 * MRTS_UNKNOWNS)

/* Where the range of c^2 over a variant's whole motion ends, the intersection of those of its samples, and why. */
typedef struct {
    int status;    /* MRTS_OPTIMAL, MRTS_INFEASIBLE at sample[0], or MRTS_STOPPED */
    int capped;    /* whether limits of the motion alone bound the largest c^2 */
    int sample[2]; /* of the least and the largest c^2, the first of those that differ by rounding only; -1: none sets it */
    int count[2];  /* of the rows that set each end there; of rows[0] those of the certificate of MRTS_INFEASIBLE */
    int rows[2][MRTS_MOST_NAMED]; /* 1 + row at an upper, -1 - row at a lower limit, in their order */
    double c2[2];
} mrts_variant_range;

/* As of mrts/program: limits are moved outward by this share of themselves, and a row is at its limit if no solution keeps
 * further away than this share. One with a multiplier above MRTS_SURE is so in any case. */
#define MRTS_WIDER 3e-9
#define MRTS_NEAR 1e-4
#define MRTS_SURE 1e-2

/* Adds a row, coded as of a program, to those of the limits that are named, in its place; 0 if there is no more room. */
static int mrts_name(const mrts_rows *rows, int code, int end, mrts_variant_range *range) {
    const int place = rows->which[mrts_abs(code) - 1], row = code < 0 ? -place - 1 : place + 1;
    int *named = range->rows[end], at = range->count[end];
    if (at == MRTS_MOST_NAMED) return 0;
    for (; at > 0 && mrts_abs(named[at - 1]) > mrts_abs(row); --at) named[at] = named[at - 1];
    named[at] = row;
    ++range->count[end];
    return 1;
}

/* The largest distance, at most 1, that wrenches within all limits can keep from some sides of rows at once, or more
 * than that where rounding leaves it open: what a program stops at is on the far side. `rows` has c^2 put in. */
static double mrts_keep_away(const mrts_rows *rows, int count, const int *sides, double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    double *A = work, *lower = A + (rows->count + MRTS_MOST_NAMED) * K, *upper = lower + rows->count + MRTS_MOST_NAMED + K;
    double g[K], x[K], y[K];
    int basis[K] = {0}, entering;
    const int total = rows->count + count;
    for (int i = 0; i < total; ++i) {
        const int code = i < rows->count ? i + 1 : sides[i - rows->count], row = mrts_abs(code) - 1;
        for (int j = 0; j < F; ++j) A[i * K + j] = code > 0 ? rows->A[row * F + j] : -rows->A[row * F + j];
        A[i * K + F] = i < rows->count ? 0 : 1;
        lower[i] = i < rows->count ? rows->lower[i] : -MRTS_INFINITY;
        upper[i] = code > 0 ? rows->upper[row] : -rows->lower[row];
    }
    for (int j = 0; j < K; ++j) {
        lower[total + j] = j < F ? -MRTS_INFINITY : 0;
        upper[total + j] = j < F ? MRTS_INFINITY : 1;
        g[j] = j < F ? 0 : -1;
    }
    mrts_lp(K, total, A, lower, upper, g, basis, x, y, &entering, upper + rows->count + MRTS_MOST_NAMED + K, iwork);
    return x[F];
}

/* Names the rows that are at their limit in every solution at an end, as mrts/program/sample_ranges.py does: those with a
 * multiplier that cannot be rounding, and of those near their limit in the solution found the ones that no other keeps
 * away from it. `sample` has the rows of one sample, not scaled, in its first lane. */
static int mrts_name_rows(const mrts_samples *sample, mrts_rows *rows, int end, double c2, const double *x,
                          const int *basis, const double *y, mrts_variant_range *range, double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1 };
    const mrts_limits *limits = sample->limits;
    int near[MRTS_MOST_NAMED], count = 0, sure[K], certain = 0;
    double largest = 0, column[K];
    for (int j = 0; j < K; ++j) largest = fmax(largest, fabs(y[j]));
    for (int j = 0; j < K; ++j) {
        const int row = mrts_abs(basis[j]) - 1;
        if (end && row >= rows->count && basis[j] > 0) range->capped = fabs(y[j]) > MRTS_BINDING * largest;
        if (row < rows->count && fabs(y[j]) > MRTS_SURE * largest) sure[certain++] = basis[j];
    }
    mrts_rows_of_lane(K, sample, 0, rows);
    mrts_fix_speed(K, limits, c2, MRTS_WIDER, rows);
    for (int i = 0; i < rows->count; ++i) {
        const double value = mrts_dot(F, rows->A + i * F, x);
        if (!(rows->upper[i] - rows->lower[i] > 2 * MRTS_NEAR)) continue;
        for (int code = i + 1; code >= -i - 1; code -= 2 * i + 2) {
            int is_sure = 0;
            if ((code > 0 ? rows->upper[i] - value : value - rows->lower[i]) > MRTS_NEAR) continue;
            for (int j = 0; j < certain; ++j) is_sure |= sure[j] == code;
            if (is_sure && !mrts_name(rows, code, end, range)) return 0;
            if (is_sure) continue;
            if (count == MRTS_MOST_NAMED) return 0;
            near[count++] = code;
        }
    }
    if (count == 0) return 1;
    mrts_scale_columns(F, rows, column);
    if (mrts_keep_away(rows, count, near, work, iwork) > MRTS_NEAR) return 1;
    for (int i = 0; i < count; ++i) {
        if (mrts_keep_away(rows, 1, near + i, work, iwork) > MRTS_NEAR) continue;
        if (!mrts_name(rows, near[i], end, range)) return 0;
    }
    return 1;
}

/* Share of an end by which another sample's may differ and still count as the same: twice that of samples that tie. */
#define MRTS_TIE 1e-7

/* A sample is at rest where c^2 moves no row by more than this share of what it does elsewhere. */
#define MRTS_REST 1e-12

/* Reals of memory of a sample of a variant: a rotation as generated functions want it, the largest c^2 that is asked for, and
 * its range. */
#define MRTS_SAMPLE_FOUND (10 + (long long)(sizeof(mrts_range) / sizeof(double)))

typedef struct {
    long long samples;
    const double *const *inputs; /* of the wrench form */
    double *most;                /* largest c^2 of each sample */
    mrts_range *found;           /* their ranges */
    mrts_samples here;
    mrts_rows rows;
    double *work;
    int *iwork;
} mrts_variant_motion;

static const long long mrts_apart[] = {MRTS_JOINTS, MRTS_JOINTS, MRTS_JOINTS, 9, 6, 6, 0, 0};

/* The least (end 0) or largest c^2 of sample n, as mrts_ranges finds it, started cold; the status of its program, with
 * wrenches x that go with it, and the rows and multipliers that determine it or prove that there is none. */
static int mrts_exact_end(mrts_variant_motion *in, long long n, int end, int *basis, double *c2, double *x, double *y,
                          int *entering) {
    enum { K = MRTS_UNKNOWNS };
    mrts_rows *rows = &in->rows;
    double g[K] = {0}, column[K];
    mrts_take_samples(in->inputs, mrts_apart, n, n + 1, 1, &in->here);
    if (!in->here.finite[0]) return MRTS_STOPPED;
    mrts_rows_of_lane(K, &in->here, 0, rows);
    mrts_scale_columns(K, rows, column);
    mrts_bound_speed(K, in->most[n], column, rows);
    g[K - 1] = end ? -1 : 1;
    basis[0] = 0;
    const int status = mrts_lp(K, rows->count, rows->A, rows->lower, rows->upper, g, basis, x, y, entering, in->work, in->iwork);
    *c2 = x[K - 1] * column[K - 1];
    for (int j = 0; j < K - 1; ++j) x[j] *= column[j];
    if (end && x[K - 1] >= MRTS_UNBOUNDED * (1 - MRTS_AT_UNBOUNDED)) *c2 = MRTS_INFINITY;
    return status;
}

/* An end of a range, c^2, and the first of the samples that set it: from cold starts, so that what is found is the same
 * whatever came before. */
static int mrts_settle(mrts_variant_motion *in, int end, double c2, mrts_variant_range *range) {
    enum { K = MRTS_UNKNOWNS };
    double x[K], y[K], its;
    int basis[K], entering;
    long long at = -1, first = -1;
    range->sample[end] = -1;
    range->count[end] = range->capped = 0;
    range->c2[end] = c2 < MRTS_INFINITY ? c2 : INFINITY;
    if (end ? c2 >= MRTS_INFINITY : c2 <= 0) return MRTS_OPTIMAL;
    for (long long n = 0; n < in->samples; ++n) {
        its = in->found[n].end[end];
        if (at < 0 && its == c2) at = n;
        if (first < 0 && (end ? its <= c2 + MRTS_TIE * c2 : its >= c2 - MRTS_TIE * c2)) first = n;
    }
    range->sample[end] = (int)first;
    int status = mrts_exact_end(in, at, end, basis, range->c2 + end, x, y, &entering);
    its = range->c2[end];
    if (status == MRTS_OPTIMAL && first != at) status = mrts_exact_end(in, first, end, basis, &its, x, y, &entering);
    if (status != MRTS_OPTIMAL) return status;
    return mrts_name_rows(&in->here, &in->rows, end, its, x, basis, y, range, in->work, in->iwork) ? MRTS_OPTIMAL : MRTS_STOPPED;
}

/* Names the rows of a sample's certificate, whose limits exclude each other: of the basis those with a multiplier, and the one
 * that was to enter. Bounds of c^2 are none. */
static int mrts_conflict(mrts_variant_motion *in, long long n, mrts_variant_range *range) {
    double x[MRTS_UNKNOWNS], y[MRTS_UNKNOWNS], c2, largest = 1;
    int basis[MRTS_UNKNOWNS], entering;
    const int status = mrts_exact_end(in, n, 0, basis, &c2, x, y, &entering);
    range->sample[0] = (int)n;
    range->count[0] = 0;
    if (status != MRTS_INFEASIBLE) return MRTS_STOPPED;
    for (int j = 0; j < MRTS_UNKNOWNS; ++j) largest = fmax(largest, fabs(y[j]));
    for (int j = -1; j < MRTS_UNKNOWNS; ++j) {
        const int row = mrts_abs(j < 0 ? entering : basis[j]), above = j < 0 ? entering > 0 : y[j] < 0;
        if (row > in->rows.count || (j >= 0 && !(fabs(y[j]) > MRTS_SEPARATED * largest))) continue;
        mrts_name(&in->rows, above ? row : -row, 0, range);
    }
    return status;
}

/* The range of one variant, of whose samples those are known. */
static int mrts_range_of_variant(mrts_variant_motion *in, mrts_variant_range *range) {
    double largest = 0, low = 0, high = MRTS_INFINITY;
    for (long long n = 0; n < in->samples; ++n) largest = fmax(largest, in->found[n].effect);
    if (!(largest < MRTS_INFINITY)) return MRTS_STOPPED;
    for (long long n = 0; n < in->samples; ++n) {
        mrts_range *found = in->found + n;
        const int at_rest = found->effect <= MRTS_REST * largest;
        if (found->status == MRTS_INFEASIBLE) return mrts_conflict(in, n, range);
        if (found->status != MRTS_OPTIMAL) return MRTS_STOPPED;
        if (at_rest && found->end[0] > 0) return MRTS_STOPPED;
        if (at_rest || !(found->end[1] < INFINITY)) found->end[1] = in->most[n];
        if (found->end[0] > low) low = found->end[0];
        if (found->end[1] < high) high = found->end[1];
    }
    const int status = mrts_settle(in, 0, low, range);
    return status == MRTS_OPTIMAL ? mrts_settle(in, 1, high, range) : status;
}

MRTS_EXPORT void mrts_variant_ranges_work(int rows, int samples, long long *reals, long long *ints) {
    const int most = 2 * rows + MRTS_MOST_NAMED;
    long long of_ranges, ints_of_ranges;
    mrts_samples_work(rows, &of_ranges, &ints_of_ranges);
    *reals = MRTS_ROWS_WORK(MRTS_UNKNOWNS, rows) + MRTS_ROWS_WORK(MRTS_UNKNOWNS, most) + MRTS_LP_WORK(MRTS_UNKNOWNS) +
             MRTS_SAMPLES_WORK(rows) + (long long)samples * MRTS_SAMPLE_FOUND + of_ranges;
    *ints = MRTS_ROWS_IWORK(rows) + MRTS_LP_IWORK(MRTS_UNKNOWNS, most) + ints_of_ranges;
}

/* The ranges of variants 0 .. count - 1 of the same number of samples, from arrays of all one after the other; a
 * stride, in reals from one variant to the next, is 0 where they share one. Which limits there are is the same for all:
 * `limits` has the rows, each variant its own lower and upper sides and values. Variants with `skipped` are passed
 * over. */
MRTS_EXPORT void mrts_variant_ranges(long long count, long long samples, const double *const *given,
                                     const long long *stride, const mrts_limits *limits, const unsigned char *skipped,
                                     mrts_variant_range *range, double *work, int *iwork) {
    enum { Q, DQ, DDQ, ROTATION, TWIST, ACCELERATION, LOAD, GEOMETRY, MOST, LOWER, UPPER, VALUES, GIVEN };
    const int most = 2 * limits->rows + MRTS_MOST_NAMED;
    static const mrts_terms none = {0};
    mrts_limits here = *limits;
    double base[9 * MRTS_ROBOTS];
    mrts_variant_motion in = {.samples = samples};
    in.work = work + MRTS_ROWS_WORK(MRTS_UNKNOWNS, limits->rows);
    in.iwork = iwork + MRTS_ROWS_IWORK(limits->rows);
    double *samples_work = in.work + MRTS_ROWS_WORK(MRTS_UNKNOWNS, most) + MRTS_LP_WORK(MRTS_UNKNOWNS);
    double *columns = samples_work + MRTS_SAMPLES_WORK(limits->rows), *ranges_work = columns + samples * MRTS_SAMPLE_FOUND;
    int *ranges_iwork = in.iwork + MRTS_LP_IWORK(MRTS_UNKNOWNS, most);
    in.most = columns + 9 * samples;
    in.found = (mrts_range *)(void *)(in.most + samples);
    for (long long v = 0; v < count; ++v) {
        const double *of[GIVEN];
        if (skipped[v]) continue;
        for (int i = 0; i < GIVEN; ++i) of[i] = given[i] + v * stride[i];
        const double *const inputs[] = {of[Q],     of[DQ],           of[DDQ],  columns,
                                        of[TWIST], of[ACCELERATION], of[LOAD], of[GEOMETRY]};
        here.lower = of[LOWER];
        here.upper = of[UPPER];
        here.value = of[VALUES];
        if (limits->base) here.base = base;
        for (int i = 0; limits->base && i < 9 * MRTS_ROBOTS; ++i) {
            base[i] = MRTS_ARM(of[GEOMETRY], i / 9)->base_rotation[3 * (i % 9 / 3) + limits->axes[i % 3]];
        }
        for (long long n = 0; n < samples; ++n) {
            for (int i = 0; i < 9; ++i) columns[9 * n + i] = of[ROTATION][9 * n + 3 * (i % 3) + i / 3];
            in.most[n] = of[MOST][n];
        }
        range[v].status = MRTS_STOPPED;
        if (!mrts_rows_over(MRTS_UNKNOWNS, &here, work, iwork, &in.rows)) continue;
        mrts_ranges(samples, inputs, mrts_apart, &here, &none, in.most, 0, 0, in.found, ranges_work, ranges_iwork);
        in.inputs = inputs;
        mrts_samples_in(&here, &none, &in.rows, samples_work, &in.here);
        range[v].status = mrts_range_of_variant(&in, range + v);
    }
}

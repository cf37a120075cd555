/* SPDX-License-Identifier: MIT
 *
 * The range of c^2 and the torques along a whole trajectory: the generated wrench form evaluated at each sample, its
 * rows put together, and the programs solved, each started from the answer at the sample before: several samples at a time
 * where that still holds, one by one where it does not.
 */
#include "lanes/kept_torques.h"
#include "quadratic_programs.h"
#include "speed_intervals.h"
#include "trajectory.h"

/* The wrench form at all samples, as mrts_map gives it, `size` numbers of each output. */
MRTS_EXPORT void mrts_forms(long long count, const double *const *in, const long long *stride, double *const *out,
                            const long long *size) {
    enum { K = MRTS_UNKNOWNS, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    mrts_lanes torque[(K + 1) * M], wrench[(K + 1) * N], *const res[] = {torque, torque + K * M, wrench, wrench + K * N};
    mrts_lanes sines[2 * M];
    mrts_lane_inputs inputs;
    for (long long n = 0; n < count; n += MRTS_LANES) {
        mrts_take_inputs(in, stride, n, count, n == 0, &inputs);
        mrts_sines(M, inputs.arg[0], sines);
        MRTS_WRENCH_FORM_LANES(inputs.arg, sines, res);
        for (int lane = 0; lane < MRTS_LANES && n + lane < count; ++lane) {
            for (int i = 0; i < 4; ++i) mrts_take_lane((int)size[i], res[i], lane, out[i] + (n + lane) * size[i]);
        }
    }
}

/* Reals and ints of work of mrts_ranges and mrts_torques for so many rows of limits. */
MRTS_EXPORT void mrts_ranges_work(int rows, long long *reals, long long *ints) {
    *reals = MRTS_ROWS_WORK(MRTS_UNKNOWNS, rows) + MRTS_LP_WORK(MRTS_UNKNOWNS) + MRTS_SAMPLES_WORK(rows);
    *ints = MRTS_ROWS_IWORK(rows) + MRTS_LP_IWORK(MRTS_UNKNOWNS, rows);
}

MRTS_EXPORT void mrts_torques_work(int rows, long long *reals, long long *ints) {
    *reals = MRTS_ROWS_WORK(MRTS_UNKNOWNS, rows) + MRTS_QP_WORK(MRTS_UNKNOWNS - 1) + MRTS_SAMPLES_WORK(rows);
    *ints = MRTS_ROWS_IWORK(rows) + MRTS_QP_IWORK(MRTS_UNKNOWNS - 1, rows);
}

/* What mrts_ranges returns of each sample. */
typedef struct {
    double *end[2]; /* least and largest c^2 */
    unsigned char *status[2];
    double *effect;
    short *basis[2];
    float *dual[2];
} mrts_found_ranges;

/* The rows of a basis as rows of the limits, 0 where there is none. */
static void mrts_codes(const mrts_limits *limits, const mrts_rows *rows, const int *basis, short *code) {
    for (int j = 0; j < MRTS_UNKNOWNS; ++j) code[j] = basis[0] == 0 ? 0 : mrts_row_of_limits(limits, rows, basis[j]);
}

/* Keeps an end of the range of a sample, of the answer's unknown c^2 in units of `column`, and its multipliers. */
static void mrts_keep_range(const mrts_found_ranges *found, long long n, int end, int status, double c2, double column,
                            const double *y) {
    found->status[end][n] = (unsigned char)status;
    found->end[end][n] = end && c2 >= MRTS_UNBOUNDED * (1 - MRTS_AT_UNBOUNDED) ? INFINITY : c2 * column;
    for (int j = 0; j < MRTS_UNKNOWNS; ++j) found->dual[end][n * MRTS_UNKNOWNS + j] = (float)y[j];
}

/* Solves both programs of one sample from the bases of the one before; `column` is the scale of c^2. */
static void mrts_range_of_sample(const mrts_limits *limits, const mrts_rows *rows, double column, long long n,
                                 int (*basis)[MRTS_UNKNOWNS], const mrts_found_ranges *found, double *work, int *iwork) {
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
        mrts_codes(limits, rows, basis[end], found->basis[end] + n * K);
        mrts_keep_range(found, n, end, status, x[K - 1], column, y);
        if (status != MRTS_OPTIMAL) basis[end][0] = 0;
    }
}

/* The answers of some samples by the bases of the one before. */
typedef struct {
    mrts_lanes x[2][MRTS_UNKNOWNS], y[2][MRTS_UNKNOWNS];
    short code[2][MRTS_UNKNOWNS];
    mrts_lane_mask kept; /* whether both are the answers */
} mrts_kept_ranges;

static void mrts_try_bases(const mrts_samples *samples, const mrts_rows *rows, int (*basis)[MRTS_UNKNOWNS],
                           mrts_kept_ranges *by) {
    enum { K = MRTS_UNKNOWNS };
    const mrts_rows_lanes *of = &samples->rows;
    mrts_lanes B[K * K], rest[K];
    by->kept = samples->finite;
    for (int end = 0; end < 2; ++end) {
        double g[K] = {0};
        int row[K], side[K];
        if (basis[end][0] == 0) {
            by->kept = (mrts_lane_mask){0};
            return;
        }
        g[K - 1] = end ? -1 : 1;
        for (int j = 0; j < K; ++j) {
            row[j] = mrts_abs(basis[end][j]) - 1;
            side[j] = basis[end][j];
        }
        by->kept &= mrts_kept_basis_lanes(K, of->count, of->A, of->lower, of->upper, g, row, side, by->x[end], by->y[end], B,
                                          rest);
        for (int j = 0; j < K; ++j) basis[end][j] = side[j]; /* in the order of their pivots */
        mrts_codes(samples->limits, rows, side, by->code[end]);
    }
}

/* Keeps the range of a sample whose ends the bases have answered. */
static void mrts_keep_lane(const mrts_kept_ranges *by, int lane, long long n, double column, const mrts_found_ranges *found) {
    enum { K = MRTS_UNKNOWNS };
    for (int end = 0; end < 2; ++end) {
        double y[K];
        mrts_take_lane(K, by->y[end], lane, y);
        for (int j = 0; j < K; ++j) found->basis[end][n * K + j] = by->code[end][j];
        mrts_keep_range(found, n, end, MRTS_OPTIMAL, by->x[end][K - 1][lane], column, y);
    }
}

/* Least and largest c^2 <= most of samples 0 .. count - 1. For each sample the status of both programs, the largest effect
 * of c^2 = 1 on a row, the rows that determine each end and their multipliers (see mrts_lp); the bounds of c^2 are row
 * rows + MRTS_UNKNOWNS - 1. `terms` are those of all samples one after the other. Returns 1 if
 * a lower limit is above its upper one. */
MRTS_EXPORT int mrts_ranges(long long count, const double *const *in, const long long *stride,
                            const mrts_limits *limits, const mrts_terms *terms, const double *most, double *low,
                            double *high, unsigned char *low_status, unsigned char *high_status, double *effect,
                            short *low_basis, short *high_basis, float *low_dual, float *high_dual, double *work,
                            int *iwork) {
    enum { K = MRTS_UNKNOWNS };
    const mrts_found_ranges found = {{low, high},           {low_status, high_status}, effect,
                                     {low_basis, high_basis}, {low_dual, high_dual}};
    double *lp_work = work + MRTS_ROWS_WORK(K, limits->rows);
    int *lp_iwork = iwork + MRTS_ROWS_IWORK(limits->rows), basis[2][K] = {{0}};
    mrts_samples samples;
    mrts_kept_ranges by;
    mrts_rows rows;
    if (!mrts_rows_over(K, limits, work, iwork, &rows)) return 1;
    mrts_samples_in(limits, terms, &rows, lp_work + MRTS_LP_WORK(K), &samples);
    for (long long n = 0; n < count; ++n) {
        const int lane = (int)(n % MRTS_LANES);
        if (lane == 0) {
            mrts_take_samples(in, stride, n, count, n == 0, &samples);
            mrts_scale_columns_lanes(K, &samples.rows, samples.column);
            mrts_bound_speed_lanes(K, mrts_term(most, samples.inputs.at, 1, 0), samples.column, &samples.rows);
            mrts_try_bases(&samples, &rows, basis, &by);
        }
        const double column = samples.column[K - 1][lane];
        effect[n] = samples.rows.size[K - 1][lane] > MRTS_NO_EFFECT ? 1 / column : 0;
        if (by.kept[lane]) {
            mrts_keep_lane(&by, lane, n, column, &found);
            continue;
        }
        if (samples.finite[lane]) {
            mrts_rows_of_lane(K, &samples, lane, &rows);
            mrts_range_of_sample(limits, &rows, column, n, basis, &found, lp_work, lp_iwork);
        } else {
            low_status[n] = high_status[n] = MRTS_STOPPED;
            basis[0][0] = basis[1][0] = 0;
        }
        if (lane + 1 < MRTS_LANES) mrts_try_bases(&samples, &rows, basis, &by); /* for the samples beside this one */
    }
    return 0;
}

/* A row of a curve's basis as one of the limits: 0 for a tangent, and one place for both unknowns of the speed. */
static short mrts_row_of_curve(const mrts_limits *limits, const mrts_rows *rows, int code) {
    const int row = mrts_abs(code) - 1, of_speed = rows->count + MRTS_UNKNOWNS;
    if (row == rows->count) return 0;
    if (row < rows->count) return mrts_row_of_limits(limits, rows, code);
    return mrts_row_of_limits(limits, rows, code < 0 ? -of_speed : of_speed);
}

MRTS_EXPORT void mrts_speed_ranges_work(int rows, long long *reals, long long *ints) {
    *reals = MRTS_ROWS_WORK(MRTS_UNKNOWNS, rows) + rows + MRTS_CURVE_WORK(MRTS_UNKNOWNS, rows) + MRTS_SAMPLES_WORK(rows);
    *ints = MRTS_ROWS_IWORK(rows) + MRTS_CURVE_IWORK(MRTS_UNKNOWNS, rows);
}

/* The highest interval of speeds c <= most of samples 0 .. count - 1 where rows have terms in c beside those in c^2: least and
 * largest c^2, and one in the gap below as of mrts_interval, a status of mrts_lp, and the largest effect on a row, of c^2 = 1
 * or of c = 1 squared. What determines the ends is K + 1 rows each, as in mrts_ranges; a tangent is 0. `terms` and what is
 * returned as there. */
MRTS_EXPORT int mrts_speed_ranges(long long count, const double *const *in, const long long *stride,
                                  const mrts_limits *limits, const mrts_terms *terms, const double *most, double *low,
                                  double *high, double *gap, unsigned char *status, double *effect, short *low_basis,
                                  short *high_basis, float *low_dual, float *high_dual, double *work, int *iwork) {
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
    for (long long n = 0; n < count; ++n) {
        const int lane = (int)(n % MRTS_LANES);
        mrts_interval found;
        if (lane == 0) mrts_take_samples(in, stride, n, count, n == 0, &samples);
        status[n] = MRTS_STOPPED;
        if (!samples.finite[lane]) continue;
        const mrts_terms here = mrts_terms_of_sample(terms, n, limits->rows);
        mrts_rows_of_lane(K, &samples, lane, &rows);
        mrts_speed_column(MRTS_JOINTS, limits, &here, &rows, speed);
        mrts_scale_columns(K, &rows, column);
        const double unit =
            mrts_curve_over(K, &rows, column, speed, curve_work, iwork + MRTS_ROWS_IWORK(limits->rows), &curve);
        const double size = unit > 0 ? MRTS_SQRT(unit) : 1;
        effect[n] = unit > 0 ? 1 / unit : 0;
        ends.speed /= size;
        status[n] = (unsigned char)mrts_highest_interval(&curve, MRTS_SQRT(most[n]) / size, &ends, &found);
        ends.speed *= size;
        if (status[n] != MRTS_OPTIMAL) continue;
        low[n] = found.low * size * (found.low * size);
        high[n] = found.high < MRTS_INFINITY ? found.high * size * (found.high * size) : INFINITY;
        gap[n] = found.gap * size * (found.gap * size);
        for (int j = 0; j < N; ++j) {
            low_basis[n * N + j] = mrts_row_of_curve(limits, &rows, end_basis[j]);
            high_basis[n * N + j] = mrts_row_of_curve(limits, &rows, end_basis[N + j]);
            low_dual[n * N + j] = low_basis[n * N + j] ? (float)end_dual[j] : 0;
            high_dual[n * N + j] = high_basis[n * N + j] ? (float)end_dual[N + j] : 0;
        }
    }
    return 0;
}

/* Torques and wrenches that minimise t'Wt at c2 (one value, or one a sample with c2_stride 1). Limits move outward by
 * `widening` of their unit where they are not equal; `terms` as in mrts_ranges. */
MRTS_EXPORT int mrts_torques(long long count, const double *const *in, const long long *stride,
                             const mrts_limits *limits, const mrts_terms *terms, const double *c2, int c2_stride,
                             const double *weights, double widening, double *torque, double *wrench,
                             unsigned char *status, double *work, int *iwork) {
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
        mrts_lane_cholesky(F, program.H, program.L);
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

/* SPDX-License-Identifier: MIT
 *
 * The range of c^2 and the torques along a whole trajectory: the generated wrench form evaluated at each sample, its
 * rows put together, and the programs solved, each started from the answer at the sample before.
 */
#include "lanes/lanes.h"
#include "basis/kept_basis.h"
#include "least_torques.h"
#include "speed_intervals.h"
#include "trajectory.h"

/* Builds the rows of a form that has what motors add; 1 if they are finite. */
static int mrts_rows_of_form(const double *rotation, const mrts_limits *limits, const mrts_terms *terms, double *turned,
                             mrts_form *form, mrts_rows *rows) {
    mrts_turn_wrenches(MRTS_UNKNOWNS, MRTS_ROBOTS, MRTS_SIZE, limits, rotation, 1, 3, turned, form);
    return mrts_build_rows(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES, form, limits, terms, rows);
}

/* Evaluates the wrench form of a sample alone; arg, (MRTS_INPUTS), then has its inputs. */
static void mrts_form_of_sample(const double *const *in, const long long *stride, long long sample, mrts_form *form,
                                const double **arg) {
    double *const res[] = {form->torque_map, form->torque_offset, form->wrench_map, form->wrench_offset};
    for (int i = 0; i < MRTS_INPUTS; ++i) arg[i] = in[i] + sample * stride[i];
    MRTS_WRENCH_FORM(arg, res);
}

/* Evaluates the wrench form of a sample and builds its rows; 1 if they are finite. */
static int mrts_rows_of_sample(const double *const *in, const long long *stride, long long sample, mrts_form *form,
                               double *turned, const mrts_limits *limits, const mrts_terms *all, mrts_rows *rows) {
    const double *arg[MRTS_INPUTS];
    const mrts_terms terms = mrts_terms_of_sample(all, sample, limits->rows);
    mrts_form_of_sample(in, stride, sample, form, arg);
    mrts_add_motors(MRTS_UNKNOWNS, MRTS_JOINTS, &terms, form);
    return mrts_rows_of_form(arg[MRTS_ROTATION], limits, &terms, turned, form, rows);
}

/* Reals and ints of work of mrts_ranges and mrts_torques for so many rows of limits. */
MRTS_EXPORT void mrts_ranges_work(int rows, long long *reals, long long *ints) {
    *reals = MRTS_ROWS_WORK(MRTS_UNKNOWNS, rows) + MRTS_LP_WORK(MRTS_UNKNOWNS) + MRTS_LANE_WORK(MRTS_UNKNOWNS, rows);
    *ints = MRTS_ROWS_IWORK(rows) + MRTS_LP_IWORK(MRTS_UNKNOWNS, rows);
}

MRTS_EXPORT void mrts_torques_work(int rows, long long *reals, long long *ints) {
    *reals = MRTS_ROWS_WORK(MRTS_UNKNOWNS, rows) + MRTS_QP_WORK(MRTS_UNKNOWNS - 1) + MRTS_LANE_WORK(MRTS_UNKNOWNS, rows);
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

/* Solves both programs of one sample, whose rows are built, from the bases of the one before. */
static void mrts_range_of_sample(const mrts_limits *limits, mrts_rows *rows, double most, long long n, int (*basis)[MRTS_UNKNOWNS],
                                 const mrts_found_ranges *found, double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS };
    double g[K] = {0}, x[K], y[K] = {0}, column[K];
    int entering, status = MRTS_OPTIMAL;
    mrts_scale_columns(K, rows, column);
    found->effect[n] = rows->size[K - 1] > MRTS_NO_EFFECT ? 1 / column[K - 1] : 0;
    mrts_free_unknowns(K, rows);
    mrts_bound_speed(K, most, column, rows);
    for (int end = 0; end < 2; ++end) {
        g[K - 1] = end ? -1 : 1;
        x[K - 1] = 0;
        if (status == MRTS_OPTIMAL) {
            status = mrts_lp_again(K, rows->count, rows->A, rows->lower, rows->upper, g, basis[end], x, y, &entering, work,
                                   iwork);
        }
        mrts_codes(limits, rows, basis[end], found->basis[end] + n * K);
        mrts_keep_range(found, n, end, status, x[K - 1], column[K - 1], y);
        if (status != MRTS_OPTIMAL) basis[end][0] = 0;
        if (status == MRTS_OPTIMAL) { /* for the order of its rows, which lanes take as it is */
            mrts_lp_again(K, rows->count, rows->A, rows->lower, rows->upper, g, basis[end], x, y, &entering, work, iwork);
        }
    }
}

#if MRTS_TORQUE_LANES
/* The samples of a call in lanes. */
typedef struct {
    mrts_lane_rows rows;
    mrts_lanes x[2][MRTS_UNKNOWNS], y[2][MRTS_UNKNOWNS];
    short code[2][MRTS_UNKNOWNS]; /* of the bases that were tried */
    mrts_lane_mask kept[2];
    mrts_lane_inputs inputs;
} mrts_samples_in_lanes;

/* Which samples the bases of the one before answer. */
static void mrts_try_bases(const mrts_limits *limits, int (*basis)[MRTS_UNKNOWNS], mrts_samples_in_lanes *lanes) {
    for (int end = 0; end < 2; ++end) {
        lanes->kept[end] = (mrts_lane_mask){0};
        if (basis[end][0] == 0) continue;
        mrts_codes(limits, lanes->rows.of, basis[end], lanes->code[end]);
        mrts_lane_end(&lanes->rows, end ? -1 : 1, basis[end], lanes->x[end], lanes->y[end], lanes->kept + end);
    }
}

/* Keeps the range of a sample whose ends the bases have answered. */
static void mrts_keep_lane(const mrts_samples_in_lanes *lanes, int lane, const mrts_found_ranges *found) {
    enum { K = MRTS_UNKNOWNS };
    const long long n = lanes->inputs.at[lane];
    const double column = lanes->rows.column[K - 1][lane];
    found->effect[n] = lanes->rows.size[K - 1][lane] > MRTS_NO_EFFECT ? 1 / column : 0;
    for (int end = 0; end < 2; ++end) {
        double y[K];
        for (int j = 0; j < K; ++j) {
            y[j] = lanes->y[end][j][lane];
            found->basis[end][n * K + j] = lanes->code[end][j];
        }
        mrts_keep_range(found, n, end, MRTS_OPTIMAL, lanes->x[end][K - 1][lane], column, y);
    }
}
#endif

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
    double memory[MRTS_FORM_WORK(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES)];
    double turned[MRTS_TURNED_WORK(MRTS_UNKNOWNS, MRTS_WRENCHES)];
    mrts_form form = mrts_form_in(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES, memory);
    mrts_rows rows;
    if (!mrts_rows_over(K, limits, work, iwork, &rows)) return 1;
#if MRTS_TORQUE_LANES
    mrts_samples_in_lanes lanes;
    lanes.rows.of = &rows;
    lanes.rows.A = (mrts_lanes *)(void *)(lp_work + MRTS_LP_WORK(K));
    lanes.rows.lower = lanes.rows.A + rows.count * K;
    lanes.rows.upper = lanes.rows.lower + rows.count + K;
    mrts_take_inputs(in, stride, 0, count, 1, &lanes.inputs);
#endif
    basis[0][0] = basis[1][0] = 0;
    for (long long n = 0; n < count; ++n) {
#if MRTS_TORQUE_LANES
        const int lane = (int)(n % MRTS_LANES), in_lanes = !limits->base;
        if (lane == 0 && in_lanes) {
            mrts_take_inputs(in, stride, n, count, 0, &lanes.inputs);
            mrts_lane_rows_of(lanes.inputs.arg, limits, terms, lanes.inputs.at, most, &lanes.rows);
            mrts_try_bases(limits, basis, &lanes);
        }
        if (in_lanes && lanes.kept[0][lane] && lanes.kept[1][lane]) {
            mrts_keep_lane(&lanes, lane, &found);
            continue;
        }
#endif
        if (mrts_rows_of_sample(in, stride, n, &form, turned, limits, terms, &rows)) {
            mrts_range_of_sample(limits, &rows, most[n], n, basis, &found, lp_work, lp_iwork);
        } else {
            low_status[n] = high_status[n] = MRTS_STOPPED;
            basis[0][0] = basis[1][0] = 0;
        }
#if MRTS_TORQUE_LANES
        if (in_lanes && lane + 1 < MRTS_LANES) mrts_try_bases(limits, basis, &lanes); /* for the samples beside this one */
#endif
    }
    return 0;
}

/* The same of a curve: 0 for a tangent, and one place for both unknowns of the speed. */
static short mrts_row_of_curve(const mrts_limits *limits, const mrts_rows *rows, int code) {
    const int row = (code < 0 ? -code : code) - 1, of_speed = rows->count + MRTS_UNKNOWNS;
    if (row == rows->count) return 0;
    if (row < rows->count) return mrts_row_of_limits(limits, rows, code);
    return mrts_row_of_limits(limits, rows, code < 0 ? -of_speed : of_speed);
}

MRTS_EXPORT void mrts_speed_ranges_work(int rows, long long *reals, long long *ints) {
    *reals = MRTS_ROWS_WORK(MRTS_UNKNOWNS, rows) + rows + MRTS_CURVE_WORK(MRTS_UNKNOWNS, rows);
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
    double *speed = work + MRTS_ROWS_WORK(K, limits->rows), column[K], end_dual[2 * N];
    double memory[MRTS_FORM_WORK(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES)];
    double turned[MRTS_TURNED_WORK(MRTS_UNKNOWNS, MRTS_WRENCHES)];
    int basis[MRTS_CURVE_BASES * N], end_basis[2 * N];
    mrts_form form = mrts_form_in(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES, memory);
    mrts_curve_ends ends = {0, basis, end_basis, end_dual};
    mrts_curve curve;
    mrts_rows rows;
    if (!mrts_rows_over(K, limits, work, iwork, &rows)) return 1;
    for (int i = 0; i < MRTS_CURVE_BASES; ++i) basis[i * N] = 0;
    for (long long n = 0; n < count; ++n) {
        mrts_interval found;
        const int built = mrts_rows_of_sample(in, stride, n, &form, turned, limits, terms, &rows);
        status[n] = MRTS_STOPPED;
        if (!built) continue;
        const mrts_terms here = mrts_terms_of_sample(terms, n, limits->rows);
        mrts_speed_column(MRTS_JOINTS, limits, &here, &rows, speed);
        mrts_scale_columns(K, &rows, column);
        const double unit = mrts_curve_over(K, &rows, column, speed, speed + limits->rows,
                                            iwork + MRTS_ROWS_IWORK(limits->rows), &curve);
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

/* What the torques of one sample are found with. */
typedef struct {
    const mrts_limits *limits;
    mrts_weights weights;
    double widening;
    mrts_form form;
    double *turned; /* memory for the wrenches in object axes */
    mrts_rows rows;
    int active[MRTS_UNKNOWNS], active_count; /* the rows that bind, those of the sample before; -1 where nothing is known */
    double *qp_work;
    int *qp_iwork;
} mrts_torque_search;

/* Torques and wrenches of one sample, whose form is there with what motors give; a status of mrts_qp. */
static int mrts_torques_of_sample(mrts_torque_search *of, const double *rotation, const mrts_terms *terms, double c2,
                                  double *torque, double *wrench) {
    double work[MRTS_LEAST_TORQUES_WORK(MRTS_UNKNOWNS, MRTS_JOINTS)];
    of->active_count = -1;
    if (!mrts_rows_of_form(rotation, of->limits, terms, of->turned, &of->form, &of->rows)) return MRTS_STOPPED;
    const int status = mrts_least_torques(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES, of->limits, &of->weights, c2, of->widening,
                                          &of->form, &of->rows, of->active, &of->active_count, torque, wrench, work,
                                          of->qp_work, of->qp_iwork);
    if (status != MRTS_OPTIMAL) of->active_count = -1;
    return status;
}

#if MRTS_TORQUE_LANES
/* The samples of a call in lanes. */
typedef struct {
    mrts_lane_program program;
    mrts_lane_inputs inputs;
    mrts_lane_mask kept;
} mrts_torque_lanes;

/* Takes the samples from `first` on. */
static void mrts_take_torques(const double *const *in, const long long *stride, long long first, long long count,
                              const mrts_limits *limits, const mrts_terms *terms, const double *c2, int c2_stride,
                              mrts_torque_lanes *lanes) {
    mrts_lanes speed;
    mrts_take_inputs(in, stride, first, count, first == 0, &lanes->inputs);
    for (int lane = 0; lane < MRTS_LANES; ++lane) speed[lane] = c2[lanes->inputs.at[lane] * c2_stride];
    mrts_lane_programs(lanes->inputs.arg, limits, terms, lanes->inputs.at, &speed, &lanes->program);
}

/* Looks which samples have the active rows of the one before. */
static void mrts_try_active(const mrts_torque_search *of, mrts_torque_lanes *lanes) {
    lanes->kept = (mrts_lane_mask){0};
    if (of->active_count >= 0) mrts_lane_torques(&lanes->program, of->active, of->active_count, &lanes->kept);
}
#endif

/* Torques and wrenches that minimise t'Wt at c2 (one value, or one a sample with c2_stride 1). Limits move outward by
 * `widening` of their unit where they are not equal; `terms` as in mrts_ranges. */
MRTS_EXPORT int mrts_torques(long long count, const double *const *in, const long long *stride,
                             const mrts_limits *limits, const mrts_terms *terms, const double *c2, int c2_stride,
                             const double *weights, double widening, double *torque, double *wrench,
                             unsigned char *status, double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    double memory[MRTS_FORM_WORK(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES)];
    double turned[MRTS_TURNED_WORK(MRTS_UNKNOWNS, MRTS_WRENCHES)];
    const double *arg[MRTS_INPUTS];
    mrts_forms forms;
    mrts_torque_search search = {.limits = limits, .weights = {weights, MRTS_JOINTS + 1}, .widening = widening, .turned = turned};
    search.form = mrts_form_in(K, M, N, memory);
    search.qp_work = work + MRTS_ROWS_WORK(K, limits->rows);
    search.qp_iwork = iwork + MRTS_ROWS_IWORK(limits->rows);
    if (!mrts_rows_over(K, limits, work, iwork, &search.rows)) return 1;
    for (int i = 0; i < M * M; ++i) {
        if (i % (M + 1) != 0 && weights[i] != 0) search.weights.apart = 0;
    }
#if MRTS_TORQUE_LANES
    mrts_torque_lanes lanes;
    lanes.program.weights = weights;
    lanes.program.widening = widening;
    lanes.program.rows.of = &search.rows;
    lanes.program.rows.A = (mrts_lanes *)(void *)(search.qp_work + MRTS_QP_WORK(F));
    lanes.program.rows.lower = lanes.program.rows.A + search.rows.count * K;
    lanes.program.rows.upper = lanes.program.rows.lower + search.rows.count + K;
#endif
    const int in_lanes = MRTS_TORQUE_LANES && F > 0 && !limits->base;
    if (!in_lanes) mrts_begin_forms(in, stride, count, &forms);
    search.active_count = -1;
    for (long long n = 0; n < count; ++n) {
        const mrts_terms here = mrts_terms_of_sample(terms, n, limits->rows);
#if MRTS_TORQUE_LANES
        const int lane = (int)(n % MRTS_LANES);
        if (lane == 0 && in_lanes) {
            mrts_take_torques(in, stride, n, count, limits, terms, c2, c2_stride, &lanes);
            mrts_try_active(&search, &lanes);
        }
        if (in_lanes && lanes.kept[lane]) {
            mrts_take_lane(M, lanes.program.least_torque, lane, torque + n * M);
            mrts_take_lane(N, lanes.program.its_wrench, lane, wrench + n * N);
            status[n] = MRTS_OPTIMAL;
            continue;
        }
#endif
        if (in_lanes) {
            mrts_form_of_sample(in, stride, n, &search.form, arg);
        } else {
            mrts_next_form(&forms, n, &search.form, arg);
        }
        mrts_add_motors(K, M, &here, &search.form);
        status[n] = (unsigned char)mrts_torques_of_sample(&search, arg[MRTS_ROTATION], &here, c2[n * c2_stride], torque + n * M,
                                                          wrench + n * N);
#if MRTS_TORQUE_LANES
        if (in_lanes && lane + 1 < MRTS_LANES) mrts_try_active(&search, &lanes); /* likewise */
#endif
    }
    return 0;
}

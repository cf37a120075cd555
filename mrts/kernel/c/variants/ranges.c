/* SPDX-License-Identifier: MIT
 *
 * The range of c^2 over the whole motion of many variants: the intersection of those of their samples, and what sets its ends.
 */
#include "../linear_programs.h"
#include "ranges.h"

/* Share of an end by which another sample's may differ and still count as the same: twice that of the samples that tie.
 */
#define MRTS_TIE 1e-7

/* A sample is at rest where c^2 moves no row by more than this share of what it does elsewhere. */
#define MRTS_REST 1e-12

/* What mrts_ranges takes and finds at the samples of a variant. */
typedef struct {
    double *columns; /* of the rotations, as generated functions want them */
    double *most, *end[2], *effect;
    float *dual[2];
    short *basis[2];
    unsigned char *status[2];
} mrts_samples_found;

/* Reals of memory of a sample. */
#define MRTS_SAMPLE_FOUND (14 + 2 * MRTS_VK)

static mrts_samples_found mrts_found_in(long long samples, double *memory) {
    mrts_samples_found in;
    in.columns = memory;
    in.most = in.columns + 9 * samples;
    in.effect = in.most + samples;
    for (int end = 0; end < 2; ++end) in.end[end] = in.effect + (end + 1) * samples;
    for (int end = 0; end < 2; ++end) in.dual[end] = (float *)(in.end[1] + samples) + end * MRTS_VK * samples;
    for (int end = 0; end < 2; ++end) in.basis[end] = (short *)(in.dual[1] + MRTS_VK * samples) + end * MRTS_VK * samples;
    for (int end = 0; end < 2; ++end) in.status[end] = (unsigned char *)(in.basis[1] + MRTS_VK * samples) + end * samples;
    return in;
}

/* What is looked at of a variant, and with what. */
typedef struct {
    long long samples;
    const double *const *inputs; /* of the wrench form */
    mrts_samples_found found;
    mrts_samples here;
    mrts_rows rows;
    double *work;
    int *iwork;
} mrts_variant_motion;

/* How far apart the inputs of two samples lie. */
static const long long mrts_apart[] = {MRTS_JOINTS, MRTS_JOINTS, MRTS_JOINTS, 9, 6, 6, 0, 0};

/* The least (end 0) or largest c^2 of sample n, as mrts_ranges finds it, started cold; the status of its program, with
 * wrenches x that go with it, and the rows and multipliers that determine it or prove that there is none. */
static int mrts_exact_end(mrts_variant_motion *in, long long n, int end, int *basis, double *c2, double *x, double *y,
                          int *entering) {
    enum { K = MRTS_VK };
    mrts_rows *rows = &in->rows;
    double g[K] = {0}, column[K];
    mrts_take_samples(in->inputs, mrts_apart, n, n + 1, 1, &in->here);
    if (!in->here.finite[0]) return MRTS_STOPPED;
    mrts_rows_of_lane(K, &in->here, 0, rows);
    mrts_scale_columns(K, rows, column);
    mrts_bound_speed(K, in->found.most[n], column, rows);
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
    enum { K = MRTS_VK };
    double x[K], y[K], its;
    int basis[K], entering;
    long long at = -1, first = -1;
    range->sample[end] = -1;
    range->count[end] = range->capped = 0;
    range->c2[end] = c2 < MRTS_INFINITY ? c2 : INFINITY;
    if (end ? c2 >= MRTS_INFINITY : c2 <= 0) return MRTS_OPTIMAL;
    for (long long n = 0; n < in->samples; ++n) {
        its = in->found.end[end][n];
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

/* Why a sample has no range: the limits that conflict there. */
static int mrts_conflict(mrts_variant_motion *in, long long n, mrts_variant_range *range) {
    double x[MRTS_VK], y[MRTS_VK], c2;
    int basis[MRTS_VK], entering;
    const int status = mrts_exact_end(in, n, 0, basis, &c2, x, y, &entering);
    range->sample[0] = (int)n;
    if (status != MRTS_INFEASIBLE) return MRTS_STOPPED;
    mrts_name_conflict(in->here.limits, &in->rows, basis, y, entering, range);
    return status;
}

/* The range of one variant, of whose samples those are known. */
static int mrts_range_of_variant(mrts_variant_motion *in, mrts_variant_range *range) {
    const mrts_samples_found *found = &in->found;
    double largest = 0, low = 0, high = MRTS_INFINITY;
    for (long long n = 0; n < in->samples; ++n) largest = fmax(largest, found->effect[n]);
    if (!(largest < MRTS_INFINITY)) return MRTS_STOPPED;
    for (long long n = 0; n < in->samples; ++n) {
        const int at_rest = found->effect[n] <= MRTS_REST * largest;
        if (found->status[0][n] == MRTS_INFEASIBLE) return mrts_conflict(in, n, range);
        if (found->status[0][n] != MRTS_OPTIMAL || found->status[1][n] != MRTS_OPTIMAL) return MRTS_STOPPED;
        if (at_rest && found->end[0][n] > 0) return MRTS_STOPPED;
        if (at_rest || !(found->end[1][n] < INFINITY)) found->end[1][n] = found->most[n];
        if (found->end[0][n] > low) low = found->end[0][n];
        if (found->end[1][n] < high) high = found->end[1][n];
    }
    const int status = mrts_settle(in, 0, low, range);
    return status == MRTS_OPTIMAL ? mrts_settle(in, 1, high, range) : status;
}

/* Reals and ints of work of mrts_variant_ranges. */
MRTS_EXPORT void mrts_variant_ranges_work(int rows, int samples, long long *reals, long long *ints) {
    const int most = 2 * rows + MRTS_MOST_NAMED;
    long long of_ranges, ints_of_ranges;
    mrts_ranges_work(rows, &of_ranges, &ints_of_ranges);
    *reals = MRTS_ROWS_WORK(MRTS_VK, rows) + MRTS_ROWS_WORK(MRTS_VK, most) + MRTS_LP_WORK(MRTS_VK) + MRTS_SAMPLES_WORK(rows) +
             (long long)samples * MRTS_SAMPLE_FOUND + of_ranges;
    *ints = MRTS_ROWS_IWORK(rows) + MRTS_LP_IWORK(MRTS_VK, most) + ints_of_ranges;
}

/* The ranges of variants 0 .. count - 1 of the same number of samples, from arrays of all one after the other; a
 * stride, in reals from one variant to the next, is 0 where they share one. Which limits there are is the same for all:
 * `limits` has the rows, each variant its own lower and upper sides and values. Variants with `skipped` are passed
 * over. */
MRTS_EXPORT void mrts_variant_ranges(long long count, long long samples, const double *const *given,
                                     const long long *stride, const mrts_limits *limits, const mrts_terms *terms,
                                     const unsigned char *skipped, mrts_variant_range *range, double *work,
                                     int *iwork) {
    enum { Q, DQ, DDQ, ROTATION, TWIST, ACCELERATION, LOAD, GEOMETRY, MOST, LOWER, UPPER, VALUES, GIVEN };
    const int most = 2 * limits->rows + MRTS_MOST_NAMED;
    mrts_limits here = *limits;
    double base[9 * MRTS_ROBOTS];
    mrts_variant_motion in = {.samples = samples};
    in.work = work + MRTS_ROWS_WORK(MRTS_VK, limits->rows);
    in.iwork = iwork + MRTS_ROWS_IWORK(limits->rows);
    double *samples_work = in.work + MRTS_ROWS_WORK(MRTS_VK, most) + MRTS_LP_WORK(MRTS_VK);
    double *found_in = samples_work + MRTS_SAMPLES_WORK(limits->rows), *ranges_work = found_in + samples * MRTS_SAMPLE_FOUND;
    int *ranges_iwork = in.iwork + MRTS_LP_IWORK(MRTS_VK, most);
    const mrts_samples_found found = in.found = mrts_found_in(samples, found_in);
    for (long long v = 0; v < count; ++v) {
        const double *of[GIVEN];
        if (skipped[v]) continue;
        for (int i = 0; i < GIVEN; ++i) of[i] = given[i] + v * stride[i];
        const double *const inputs[] = {of[Q],     of[DQ],           of[DDQ],  found.columns,
                                        of[TWIST], of[ACCELERATION], of[LOAD], of[GEOMETRY]};
        const mrts_terms own = mrts_terms_of_sample(terms, v * samples, limits->rows);
        here.lower = of[LOWER];
        here.upper = of[UPPER];
        here.value = of[VALUES];
        if (limits->base) here.base = base;
        for (int i = 0; limits->base && i < 9 * MRTS_ROBOTS; ++i) {
            base[i] = MRTS_ARM(of[GEOMETRY], i / 9)->base_rotation[3 * (i % 9 / 3) + limits->axes[i % 3]];
        }
        for (long long n = 0; n < samples; ++n) {
            for (int i = 0; i < 9; ++i) found.columns[9 * n + i] = of[ROTATION][9 * n + 3 * (i % 3) + i / 3];
            found.most[n] = of[MOST][n];
        }
        range[v].status = MRTS_STOPPED;
        if (!mrts_rows_over(MRTS_VK, &here, work, iwork, &in.rows)) continue;
        mrts_ranges(samples, inputs, mrts_apart, &here, &own, found.most, found.end[0], found.end[1], found.status[0],
                    found.status[1], found.effect, found.basis[0], found.basis[1], found.dual[0], found.dual[1],
                    ranges_work, ranges_iwork);
        in.inputs = inputs;
        mrts_samples_in(&here, &own, &in.rows, samples_work, &in.here);
        range[v].status = mrts_range_of_variant(&in, range + v);
    }
}

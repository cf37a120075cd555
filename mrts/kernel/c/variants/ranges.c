/* SPDX-License-Identifier: MIT
 *
 * The range of c^2 over the whole motion of many variants: the intersection of those of their samples, which takes the exact
 * range of few of them. A sample at which some wrenches hold the object at an end of what the others leave does not cut it
 * there; those of a sample nearby, in the middle of all limits, usually do.
 */
#include "../basis/kept_basis.h"
#include "../tracking/null_space.h"
#include "ranges.h"

/* Share of an end by which another sample's may differ and still count as the same: twice that of the samples that tie.
 */
#define MRTS_TIE 1e-7

/* A sample is at rest where c^2 moves no row by more than this share of what it does elsewhere. */
#define MRTS_REST 1e-12

/* Share of all limits that wrenches must keep free to serve other samples. */
#define MRTS_MIDDLE 1e-3

/* One end of the range of a variant, and what finds it. */
typedef struct {
    double c2;              /* of the samples seen so far */
    int has_middle;         /* whether there are */
    double middle[MRTS_VK]; /* wrenches of all arms but the last in the middle of the limits of some sample */
    int basis[MRTS_VK];     /* of the last program of an end */
    int middle_basis[MRTS_VK];
} mrts_side;

/* Whether given wrenches hold the object at c^2 within all limits. */
static int mrts_holds(const mrts_limits *limits, const mrts_rows *rows, const mrts_sample *sample, const double *x,
                      double c2) {
    enum { M = MRTS_JOINTS, N = MRTS_WRENCHES };
    const mrts_form *form = &sample->form;
    double value[M + 2 * N];
    for (int part = 0; part < 3; ++part) {
        const double *map = part == 0 ? form->torque_map : part == 1 ? form->wrench_map : form->object_map;
        const double *offset = part == 0 ? form->torque_offset : part == 1 ? form->wrench_offset : form->object_offset;
        const int size = part == 0 ? M : N;
        double *of_part = value + (part == 0 ? 0 : part == 1 ? M : M + N);
        if (!map) continue;
        for (int i = 0; i < size; ++i) of_part[i] = offset[i] + map[MRTS_VF * size + i] * c2;
        for (int j = 0; j < MRTS_VF; ++j) {
            for (int i = 0; i < size; ++i) of_part[i] += map[j * size + i] * x[j];
        }
    }
    for (int i = 0; i < rows->count; ++i) {
        const int row = rows->which[i];
        const mrts_terms *terms = &sample->terms;
        const double margin = terms->margin ? terms->margin[row] : 0;
        double sum = (terms->square ? terms->square[row] * c2 : 0) + (terms->offset ? terms->offset[row] : 0);
        for (int entry = limits->start[row]; entry < limits->start[row + 1]; ++entry) {
            sum += limits->value[entry] * value[limits->column[entry]];
        }
        if (!(sum >= limits->lower[row] + margin && sum <= limits->upper[row] - margin)) return 0;
    }
    return 1;
}

/* Wrenches in the middle of the limits of a sample at c^2, by a program: those whose least distance to any limit, in
 * its unit, is the largest. 0 if that is too small to serve, or not found. */
static int mrts_find_middle(const mrts_limits *limits, mrts_rows *rows, const mrts_sample *sample, double c2,
                            mrts_side *side, double *work, int *iwork) {
    enum { K = MRTS_VK, F = MRTS_VF };
    double *A = work, *lower = A + 2 * limits->rows * K, *upper = lower + 2 * limits->rows + K;
    double g[K], x[K], y[K], column[K];
    int count = 0, entering;
    if (!mrts_build_rows(K, MRTS_JOINTS, MRTS_WRENCHES, &sample->form, limits, &sample->terms, rows)) return 0;
    mrts_fix_speed(K, limits, c2, 0, rows);
    mrts_scale_columns(F, rows, column);
    for (int i = 0; i < rows->count; ++i) {
        for (int sign = -1; sign <= 1; sign += 2) {
            const double limit = sign < 0 ? -rows->lower[i] : rows->upper[i];
            if (limit >= MRTS_INFINITY) continue;
            for (int j = 0; j < F; ++j) A[count * K + j] = sign * rows->A[i * F + j];
            A[count * K + F] = 1;
            lower[count] = -MRTS_INFINITY;
            upper[count++] = limit;
        }
    }
    for (int j = 0; j < K; ++j) {
        lower[count + j] = j < F ? -MRTS_INFINITY : 0;
        upper[count + j] = j < F ? MRTS_INFINITY : 1;
        g[j] = j < F ? 0 : -1;
    }
    const int status = mrts_lp(K, count, A, lower, upper, g, side->middle_basis, x, y, &entering,
                               upper + 2 * limits->rows + K, iwork);
    if (status != MRTS_OPTIMAL) {
        side->middle_basis[0] = 0;
        return 0;
    }
    if (x[F] < MRTS_MIDDLE) return 0;
    side->has_middle = 1;
    for (int j = 0; j < F; ++j) side->middle[j] = x[j] * column[j];
    return 1;
}

/* The least (end 0) or largest c^2 of a sample, as mrts_ranges finds it, started from a basis; the status of its
 * program, with wrenches x that go with it, and the rows and multipliers that determine it or prove that there is none.
 */
static int mrts_exact_end(const mrts_limits *limits, mrts_rows *rows, const mrts_sample *sample, int end, int *basis,
                          double *c2, double *x, double *y, int *entering, double *work, int *iwork) {
    enum { K = MRTS_VK };
    double g[K], column[K];
    if (!mrts_build_rows(K, MRTS_JOINTS, MRTS_WRENCHES, &sample->form, limits, &sample->terms, rows)) return MRTS_STOPPED;
    mrts_scale_columns(K, rows, column);
    mrts_free_unknowns(K, rows);
    mrts_bound_speed(K, sample->most, column, rows);
    for (int j = 0; j < K; ++j) g[j] = j < K - 1 ? 0 : end ? -1 : 1;
    const int status = mrts_lp_again(K, rows->count, rows->A, rows->lower, rows->upper, g, basis, x, y, entering, work,
                                     iwork);
    *c2 = x[K - 1] * column[K - 1];
    for (int j = 0; j < K - 1; ++j) x[j] *= column[j];
    if (end && x[K - 1] >= MRTS_UNBOUNDED * (1 - MRTS_AT_UNBOUNDED)) *c2 = MRTS_INFINITY;
    return status;
}

/* What a sample leaves of the range at one end. Returns the status of a program that has no answer, else MRTS_OPTIMAL.
 */
static int mrts_cut_end(const mrts_limits *limits, mrts_rows *rows, mrts_sample *sample, int end, int at_rest,
                    mrts_side *side, double *y, int *entering, double *work, int *iwork) {
    double x[MRTS_VK];
    const double most = sample->most;
    double asked = at_rest ? 0 : side->c2 * (end ? 1 + 2 * MRTS_TIE : 1 - 2 * MRTS_TIE);
    int status, capped = end && most <= asked;
    if (capped) asked = most;
    if (end && at_rest) {
        sample->known[1] = most < MRTS_INFINITY;
        sample->end[1] = most;
        if (most < side->c2) side->c2 = most;
        return MRTS_OPTIMAL;
    }
    if (asked < MRTS_INFINITY && ((side->has_middle && mrts_holds(limits, rows, sample, side->middle, asked)) ||
                                  mrts_find_middle(limits, rows, sample, asked, side, work, iwork))) {
        if (!capped) return MRTS_OPTIMAL;
        sample->end[1] = most;
    } else {
        status = mrts_exact_end(limits, rows, sample, end, side->basis, sample->end + end, x, y, entering, work, iwork);
        if (status == MRTS_OPTIMAL && at_rest && sample->end[0] > 0) status = MRTS_STOPPED;
        if (status != MRTS_OPTIMAL) return status;
    }
    sample->known[end] = 1;
    if (end ? sample->end[1] < side->c2 : sample->end[0] > side->c2) side->c2 = sample->end[end];
    return MRTS_OPTIMAL;
}

/* The inputs of one variant: of all its samples one after the other, load, geometry, and limits of velocities. */
typedef struct {
    const double *q, *dq, *ddq, *rotation, *twist, *acceleration, *load, *geometry, *velocity;
} mrts_variant;

/* Evaluates the wrench form at all samples of a variant; the largest effect of c^2 on any row. */
static double mrts_forms_of_variant(long long samples, const mrts_variant *of, const mrts_limits *limits,
                                    const mrts_rows *rows, const mrts_terms *terms, mrts_sample *sample, double *memory) {
    enum { M = MRTS_JOINTS, N = MRTS_WRENCHES, FORM = MRTS_FORM_WORK(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES) };
    const long long each = FORM + (limits->base ? MRTS_TURNED_WORK(MRTS_UNKNOWNS, MRTS_WRENCHES) : 0);
    double largest = 0, columns[9];
    for (long long n = 0; n < samples; ++n) {
        mrts_sample *here = sample + n;
        double *own = memory + n * each;
        const double *const inputs[] = {of->q + n * M,     of->dq + n * M,           of->ddq + n * M, columns,
                                  of->twist + 6 * n, of->acceleration + 6 * n, of->load,        of->geometry};
        int binding;
        for (int i = 0; i < 9; ++i) columns[i] = of->rotation[9 * n + 3 * (i % 3) + i / 3];
        here->form = mrts_form_in(MRTS_VK, M, N, own);
        here->terms = mrts_terms_of_sample(terms, n, limits->rows);
        double *const res[] = {here->form.torque_map, here->form.torque_offset, here->form.wrench_map, here->form.wrench_offset};
        MRTS_WRENCH_FORM(inputs, res);
        mrts_add_motors(MRTS_VK, M, &here->terms, &here->form);
        mrts_turn_wrenches(MRTS_VK, MRTS_ROBOTS, MRTS_SIZE, limits, columns, 1, 3, own + FORM, &here->form);
        here->known[0] = here->known[1] = 0;
        here->most = mrts_speed_cap(M, of->dq + n * M, of->twist + 6 * n, of->velocity, &binding);
        here->effect = 0;
        for (int i = 0; i < rows->count; ++i) {
            const int row = rows->which[i];
            double a = here->terms.square ? here->terms.square[row] : 0;
            for (int entry = limits->start[row]; entry < limits->start[row + 1]; ++entry) {
                const int column = limits->column[entry], place = column < M ? column : (column - M) % N;
                const double *map = column < M ? here->form.torque_map + MRTS_VF * M
                                               : (column < M + N ? here->form.wrench_map : here->form.object_map) + MRTS_VF * N;
                a += limits->value[entry] * map[place];
            }
            here->effect = fmax(here->effect, fabs(a) / rows->unit[i]);
        }
        largest = fmax(largest, here->effect);
    }
    return largest;
}

/* An end of a range, of the samples where it is known: from cold starts, so that what is found is the same whatever
 * came before. */
static int mrts_settle(long long samples, const mrts_limits *limits, mrts_rows *rows, const mrts_sample *sample, int end,
                       double c2, mrts_variant_range *range, double *work, int *iwork) {
    enum { K = MRTS_VK };
    double x[K], y[K], its;
    int basis[K] = {0}, entering, status;
    long long at = -1, first = -1;
    range->sample[end] = -1;
    range->count[end] = range->capped = 0;
    range->c2[end] = c2 < MRTS_INFINITY ? c2 : INFINITY;
    if (end ? c2 >= MRTS_INFINITY : c2 <= 0) return MRTS_OPTIMAL;
    for (long long n = 0; n < samples; ++n) {
        its = sample[n].end[end];
        if (!sample[n].known[end]) continue;
        if (at < 0 && its == c2) at = n;
        if (first < 0 && (end ? its <= c2 + MRTS_TIE * c2 : its >= c2 - MRTS_TIE * c2)) first = n;
    }
    if (at < 0) return MRTS_STOPPED;
    range->sample[end] = (int)first;
    status = mrts_exact_end(limits, rows, sample + at, end, basis, range->c2 + end, x, y, &entering, work, iwork);
    its = range->c2[end];
    if (status == MRTS_OPTIMAL && first != at) {
        basis[0] = 0;
        status = mrts_exact_end(limits, rows, sample + first, end, basis, &its, x, y, &entering, work, iwork);
    }
    if (status != MRTS_OPTIMAL) return status;
    return mrts_name_rows(limits, rows, sample + first, end, its, x, basis, y, range, work, iwork) ? MRTS_OPTIMAL : MRTS_STOPPED;
}

/* The range of one variant. `order` is that in which its samples are looked at. */
static void mrts_range_of_variant(long long samples, const mrts_limits *limits, mrts_rows *rows, const int *order,
                                  double largest, mrts_sample *sample, mrts_variant_range *range, double *work, int *iwork) {
    mrts_side side[2];
    double y[MRTS_VK];
    int entering;
    for (int end = 0; end < 2; ++end) {
        side[end].c2 = end ? MRTS_INFINITY : 0;
        side[end].has_middle = side[end].basis[0] = side[end].middle_basis[0] = 0;
    }
    for (long long place = 0; place < samples; ++place) {
        const int n = order[place], at_rest = sample[n].effect <= MRTS_REST * largest;
        for (int end = 0; end < 2; ++end) {
            range->status = mrts_cut_end(limits, rows, sample + n, end, at_rest, side + end, y, &entering, work, iwork);
            if (range->status == MRTS_OPTIMAL) continue;
            range->sample[0] = n;
            if (range->status != MRTS_INFEASIBLE) return;
            mrts_name_conflict(limits, rows, side[end].basis, y, entering, range);
            return;
        }
    }
    for (int end = 0; end < 2 && range->status == MRTS_OPTIMAL; ++end) {
        range->status = mrts_settle(samples, limits, rows, sample, end, side[end].c2, range, work, iwork);
    }
}

/* Reals and ints of work of mrts_variant_ranges. */
MRTS_EXPORT void mrts_variant_ranges_work(int rows, int samples, long long *reals, long long *ints) {
    const long long each = MRTS_FORM_WORK(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES) +
                           MRTS_TURNED_WORK(MRTS_UNKNOWNS, MRTS_WRENCHES);
    const long long header = (long long)((sizeof(mrts_sample) + sizeof(double) - 1) / sizeof(double));
    const int most = 2 * rows + MRTS_MOST_NAMED;
    *reals = MRTS_ROWS_WORK(MRTS_VK, rows) + MRTS_ROWS_WORK(MRTS_VK, most) + MRTS_LP_WORK(MRTS_VK) +
             samples * (each + header);
    *ints = MRTS_ROWS_IWORK(rows) + MRTS_LP_IWORK(MRTS_VK, most);
}

/* The ranges of variants 0 .. count - 1 of the same number of samples, from arrays of all one after the other; a
 * stride, in reals from one variant to the next, is 0 where they share one. Which limits there are is the same for all:
 * `limits` has the rows, each variant its own lower and upper sides and values. Variants with `skipped` are passed
 * over. */
MRTS_EXPORT void mrts_variant_ranges(long long count, long long samples, const double *const *given,
                                     const long long *stride, const mrts_limits *limits, const mrts_terms *terms,
                                     const int *order, const unsigned char *skipped, mrts_variant_range *range,
                                     double *work,
                                     int *iwork) {
    enum { Q, DQ, DDQ, ROTATION, TWIST, ACCELERATION, LOAD, GEOMETRY, VELOCITY, LOWER, UPPER, VALUES, GIVEN };
    mrts_limits here = *limits;
    mrts_rows rows;
    double base[9 * MRTS_ROBOTS];
    double *lp_work = work + MRTS_ROWS_WORK(MRTS_VK, limits->rows);
    mrts_sample *sample = (mrts_sample *)(void *)(lp_work + MRTS_ROWS_WORK(MRTS_VK, 2 * limits->rows + MRTS_MOST_NAMED) +
                                                  MRTS_LP_WORK(MRTS_VK));
    double *memory = (double *)(void *)(sample + samples);
    int *lp_iwork = iwork + MRTS_ROWS_IWORK(limits->rows);
    for (long long v = 0; v < count; ++v) {
        const double *of[GIVEN];
        if (skipped[v]) continue;
        for (int i = 0; i < GIVEN; ++i) of[i] = given[i] + v * stride[i];
        const mrts_variant variant = {of[Q],     of[DQ],           of[DDQ],  of[ROTATION], of[TWIST],
                                      of[ACCELERATION], of[LOAD], of[GEOMETRY], of[VELOCITY]};
        const mrts_terms own = mrts_terms_of_sample(terms, v * samples, limits->rows);
        here.lower = of[LOWER];
        here.upper = of[UPPER];
        here.value = of[VALUES];
        if (limits->base) here.base = base;
        for (int i = 0; limits->base && i < 9 * MRTS_ROBOTS; ++i) {
            base[i] = MRTS_ARM(variant.geometry, i / 9)->base_rotation[3 * (i % 9 / 3) + limits->axes[i % 3]];
        }
        range[v].status = MRTS_STOPPED;
        if (!mrts_rows_over(MRTS_VK, &here, work, iwork, &rows)) continue;
        const double largest = mrts_forms_of_variant(samples, &variant, &here, &rows, &own, sample, memory);
        if (!(largest < MRTS_INFINITY)) continue;
        mrts_range_of_variant(samples, &here, &rows, order, largest, sample, range + v, lp_work, lp_iwork);
    }
}

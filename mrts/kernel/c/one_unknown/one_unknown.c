/* SPDX-License-Identifier: MIT
 *
 * Samples whose wrenches the object's balance fixes, of one arm or by given shares of the load: every row is a line in c^2,
 * so there is no program to solve.
 */
#include "../cell_sizes.h"
#include "../trajectory.h"

/* Rows bind together if their ends differ by no more than this share; `BINDING_TOLERANCE` of mrts/program/range_ends.py. */
#define MRTS_TIED 1e-7

/* A generated function of a moving sample and its inputs at the first: like the wrench form it gives maps and offsets of
 * torques and wrenches, with c^2 for the only unknown. */
typedef struct {
    MRTS_GENERATED((*run));
    int inputs;
    const double *const *in;
    const long long *stride;
    const double *arg[MRTS_INPUTS + 2]; /* of the sample that was evaluated last */
} mrts_known;

/* Evaluates the function at a sample. */
static void mrts_known_at(mrts_known *known, long long sample, mrts_form *form) {
    for (int i = 0; i < known->inputs; ++i) known->arg[i] = known->in[i] + sample * known->stride[i];
    double *const res[] = {form->torque_map, form->torque_offset, form->wrench_map, form->wrench_offset};
    known->run(known->arg, res);
}

/* The c^2 >= 0 that keep a c^2 <= limit: [*least, *most], from infinity to minus infinity where there are none. */
static void mrts_below(double a, double limit, double *least, double *most) {
    *least = limit >= 0 ? 0 : a < 0 ? limit / a : INFINITY;
    *most = limit >= 0 ? (a > 0 ? limit / a : INFINITY) : a < 0 ? INFINITY : -INFINITY;
}

/* The c^2 that each row leaves, and by which side (1: upper) it sets both ends. */
typedef struct {
    double *least, *most;
    signed char *least_side, *most_side;
} mrts_row_ends;

/* Returns 0 where limits cross, so that no c^2 keeps them, or are no numbers. */
static int mrts_ends_of_rows(const mrts_rows *rows, mrts_row_ends *ends) {
    for (int i = 0; i < rows->count; ++i) {
        const double a = rows->A[i];
        if (!(rows->lower[i] <= rows->upper[i])) return 0;
        double below[2] = {0, INFINITY}, above[2] = {0, INFINITY};
        if (rows->upper[i] < MRTS_INFINITY) mrts_below(a, rows->upper[i], below, below + 1);
        if (rows->lower[i] > -MRTS_INFINITY) mrts_below(-a, -rows->lower[i], above, above + 1);
        ends->least_side[i] = below[0] >= above[0] ? 1 : -1;
        ends->least[i] = below[0] >= above[0] ? below[0] : above[0];
        ends->most_side[i] = below[1] <= above[1] ? 1 : -1;
        ends->most[i] = below[1] <= above[1] ? below[1] : above[1];
    }
    return 1;
}

/* Which rows tie at an end, each as the side that sets it; none at 0 or where nothing bounds. */
static void mrts_tied(const mrts_rows *rows, double c2, const double *ends, const signed char *side, signed char *tied) {
    if (!(c2 > 0 && c2 < INFINITY)) return;
    for (int i = 0; i < rows->count; ++i) {
        if (MRTS_ABS(ends[i] - c2) <= MRTS_TIED * c2) tied[rows->which[i]] = side[i];
    }
}

MRTS_EXPORT void mrts_known_ranges_work(int rows, long long *reals, long long *ints) {
    *reals = MRTS_ROWS_WORK(1, rows) + 3 * rows;
    *ints = MRTS_ROWS_IWORK(rows);
}

/* Eq. (38): least and largest c^2 <= most of samples 0 .. count - 1, the largest effect of c^2 = 1 on a row, and which rows
 * tie at each end, Shape (count, rows), as 1 at an upper and -1 at a lower limit; these are zero on entry. Where no c^2 keeps all
 * rows, low is above high. `run` is a function of so many inputs that leaves c^2 as the only unknown, `terms` are those of
 * all samples one after the other. Returns 1 if a lower limit is above its upper one. */
MRTS_EXPORT int mrts_known_ranges(long long count, const double *const *in, const long long *stride,
                                  const mrts_limits *limits, const mrts_terms *terms, const double *most,
                                  MRTS_GENERATED((*run)), int inputs,
                                  double *low, double *high, double *effect, signed char *low_tied,
                                  signed char *high_tied,
                                  double *work, int *iwork) {
    mrts_known known = {.run = run, .inputs = inputs, .in = in, .stride = stride};
    double memory[MRTS_FORM_WORK(1, MRTS_JOINTS, MRTS_WRENCHES)], turned[MRTS_TURNED_WORK(1, MRTS_WRENCHES)];
    mrts_form form = mrts_form_in(1, MRTS_JOINTS, MRTS_WRENCHES, memory);
    mrts_row_ends ends;
    mrts_rows rows;
    if (!mrts_rows_over(1, limits, work, iwork, &rows)) return 1;
    ends.least = work + MRTS_ROWS_WORK(1, limits->rows);
    ends.most = ends.least + limits->rows;
    ends.least_side = (signed char *)(ends.most + limits->rows);
    ends.most_side = ends.least_side + limits->rows;
    for (long long n = 0; n < count; ++n) {
        const mrts_terms here = mrts_terms_of_sample(terms, n, limits->rows);
        mrts_known_at(&known, n, &form);
        mrts_add_motors(1, MRTS_JOINTS, &here, &form);
        mrts_turn_wrenches(1, MRTS_ROBOTS, MRTS_SIZE, limits, known.arg[MRTS_ROTATION], 1, 3, turned, &form);
        low[n] = INFINITY;
        high[n] = -INFINITY;
        effect[n] = 0;
        if (!mrts_build_rows(1, MRTS_JOINTS, MRTS_WRENCHES, &form, limits, &here, &rows)) continue;
        if (!mrts_ends_of_rows(&rows, &ends)) continue;
        low[n] = 0;
        high[n] = most[n] < MRTS_INFINITY ? most[n] : INFINITY;
        for (int i = 0; i < rows.count; ++i) {
            if (MRTS_ABS(rows.A[i]) > effect[n]) effect[n] = MRTS_ABS(rows.A[i]);
            if (ends.least[i] > low[n]) low[n] = ends.least[i];
            if (ends.most[i] < high[n]) high[n] = ends.most[i];
        }
        mrts_tied(&rows, low[n], ends.least, ends.least_side, low_tied + n * limits->rows);
        mrts_tied(&rows, high[n], ends.most, ends.most_side, high_tied + n * limits->rows);
    }
    return 0;
}

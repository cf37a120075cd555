/* SPDX-License-Identifier: MIT
 *
 * Whole batches in one call from Python: linear and quadratic programs, and intervals of speeds. */
#include "quadratic_programs.h"
#include "speed_intervals.h"

/* Reals and ints of work of each batch of programs. */
MRTS_EXPORT void mrts_batch_work(int k, int rows, long long *reals, long long *ints) {
    *reals = MRTS_LP_WORK(k) + MRTS_QP_WORK(k) + MRTS_CURVE_WORK(k, rows) + 4 * k + 2;
    *ints = MRTS_LP_IWORK(k, rows) + MRTS_QP_IWORK(k, rows) + MRTS_CURVE_IWORK(k, rows) + (MRTS_CURVE_BASES + 2) * (k + 1);
}

/* `count` linear programs, or with H strictly convex quadratic ones; each linear one starts from the answer of the one before.
 * Limits of rows and, after them, of the unknowns, Shape (count, rows + k). Multipliers likewise: Hx + g + A'dual_rows +
 * dual_unknowns = 0. */
MRTS_EXPORT void mrts_solve_batch(long long count, int k, int rows, const double *H, const double *g, const double *A,
                                  const double *lower, const double *upper, double *x, double *dual, unsigned char *status,
                                  double *work, int *iwork) {
    double *y = work + MRTS_LP_WORK(k) + MRTS_QP_WORK(k);
    int *basis = iwork + MRTS_LP_IWORK(k, rows) + MRTS_QP_IWORK(k, rows), binding = k, entering = 0;
    basis[0] = 0;
    for (long long n = 0; n < count; ++n, g += k, A += k * rows, x += k) {
        const double *lo = lower + n * (rows + k), *up = upper + n * (rows + k);
        double *d = dual + n * (rows + k);
        const int found = H ? mrts_qp(k, rows, H + n * k * k, A, lo, up, g, x, basis, y, &binding, work, iwork)
                            : mrts_lp_again(k, rows, A, lo, up, g, basis, x, y, &entering, work, iwork);
        for (int i = 0; i < rows + k; ++i) d[i] = 0;
        for (int j = 0; j < binding; ++j) d[mrts_abs(basis[j]) - 1] = H && basis[j] > 0 ? y[j] : -y[j];
        if (entering) d[mrts_abs(entering) - 1] = entering < 0 ? -1 : 1;
        status[n] = (unsigned char)found;
        if (found != MRTS_OPTIMAL) basis[0] = 0;
    }
}

/* The highest interval of speeds c <= most of `count` samples with rows over k unknowns, c^2 last, whose columns have been
 * multiplied by `column`, Shape (count, k), and with what a speed of 1 adds to them. Least and largest c^2, one in the gap
 * below as of mrts_interval, a status of mrts_lp, and multipliers of the rows at both ends. */
MRTS_EXPORT void mrts_interval_batch(long long count, int k, int rows, const double *A, const double *lower,
                                     const double *upper, const double *column, const double *speed, const double *most,
                                     double *low, double *high, double *gap, double *low_dual, double *high_dual,
                                     unsigned char *status, double *work, int *iwork) {
    const int n = k + 1;
    double *end_dual = work + MRTS_CURVE_WORK(k, rows);
    int *basis = iwork + MRTS_CURVE_IWORK(k, rows), *end_basis = basis + MRTS_CURVE_BASES * n;
    for (long long sample = 0; sample < count; ++sample) {
        mrts_rows given = {0};
        mrts_curve_ends ends = {0, basis, end_basis, end_dual};
        mrts_curve curve;
        mrts_interval found;
        given.count = rows;
        given.A = (double *)A + sample * rows * k;
        given.lower = (double *)lower + sample * rows;
        given.upper = (double *)upper + sample * rows;
        for (int i = 0; i < MRTS_CURVE_BASES; ++i) basis[i * n] = 0;
        const double unit = mrts_curve_over(k, &given, column + sample * k, speed + sample * rows, work, iwork, &curve);
        const double size = unit > 0 ? MRTS_SQRT(unit) : 1;
        status[sample] = (unsigned char)mrts_highest_interval(&curve, MRTS_SQRT(most[sample]) / size, &ends, &found);
        if (status[sample] != MRTS_OPTIMAL) continue;
        low[sample] = found.low * size * (found.low * size);
        high[sample] = found.high < MRTS_INFINITY ? found.high * size * (found.high * size) : MRTS_INFINITY;
        gap[sample] = found.gap * size * (found.gap * size);
        for (int j = 0; j < 2 * n; ++j) {
            const int row = mrts_abs(end_basis[j]);
            double *dual = (j < n ? low_dual : high_dual) + sample * rows;
            if (row > 0 && row <= rows) dual[row - 1] = end_basis[j] < 0 ? -MRTS_ABS(end_dual[j]) : MRTS_ABS(end_dual[j]);
        }
    }
}

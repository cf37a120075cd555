/* SPDX-License-Identifier: MIT
 *
 * The fastest speed along a path by reachability analysis (Pham and Pham, A new approach to time-optimal path
 * parameterization based on reachability analysis, IEEE T-RO 2018): x is the squared speed, u its rate, and
 * u = (x_(i+1) - x_i) / (2 step_i) is constant on a segment. Each sample has half-planes n_u u + n_x x <= h, which hold
 * at both ends of every segment (the interpolation scheme).
 */

/* Rounding that a controllable set of one point may miss itself by, in units of the limits. */
#define MRTS_MISSED 1e-9

/* Rounding of a speed on a limit, relative to 1 and the limit: a row that hardly depends on the next speed must not
 * turn it into a large step. */
#define MRTS_ON_LIMIT 2e-10

/* The half-planes of a segment over (x_i, x_(i+1)); returns their number. */
static int mrts_segment(double step, const double *left, int left_count, const double *right, int right_count,
                        double *A, double *upper) {
    const double rate = 1 / (2 * step);
    int row = 0;
    for (int end = 0; end < 2; ++end) {
        const double *plane = end ? right : left;
        const int count = end ? right_count : left_count;
        for (int i = 0; i < count; ++i, ++row, plane += 3) {
            const double by_rate = plane[0] * rate;
            A[2 * row] = -by_rate + (end ? 0 : plane[1]);
            A[2 * row + 1] = by_rate + (end ? plane[1] : 0);
            upper[row] = plane[2];
        }
    }
    return row;
}

/* Least and largest x_i from which some u leads into [low[1], high[1]]; low[0] and high[0] bound it on entry. */
static int mrts_controllable(int rows, double *A, double *lower, double *upper, double *low, double *high,
                             double *work, int *iwork) {
    double g[2] = {0, 0}, column[2], z[2], y[2], found[2];
    int basis[2], entering;
    for (int j = 0; j < 2; ++j) {
        double size = 0;
        for (int row = 0; row < rows; ++row) {
            if (MRTS_ABS(A[2 * row + j]) > size) size = MRTS_ABS(A[2 * row + j]);
        }
        column[j] = size > 0 ? 1 / size : high[j] > 0 ? high[j] : 1;
        for (int row = 0; row < rows; ++row) A[2 * row + j] *= column[j];
        lower[rows + j] = low[j] / column[j];
        upper[rows + j] = high[j] / column[j];
    }
    for (int row = 0; row < rows; ++row) lower[row] = -MRTS_INFINITY;
    for (int end = 0; end < 2; ++end) {
        int status = MRTS_STOPPED;
        g[0] = end ? -1 : 1;
        for (int attempt = 0; attempt < 2; ++attempt) {
            basis[0] = 0;
            status = mrts_lp(2, rows, A, lower, upper, g, basis, z, y, &entering, work, iwork);
            if (status == MRTS_OPTIMAL || status == MRTS_INFEASIBLE) break;
            for (int row = 0; row < rows; ++row) upper[row] += MRTS_MISSED;
        }
        if (status != MRTS_OPTIMAL) return status;
        found[end] = z[0] * column[0];
    }
    low[0] = found[0] > low[0] ? found[0] : low[0];
    high[0] = found[1] < high[0] ? found[1] : high[0];
    if (low[0] > high[0]) low[0] = high[0];
    return MRTS_OPTIMAL;
}

/* Backward: the controllable sets [low, high] of samples 0 .. last, given as bounds of x and that of the last sample.
 * Returns the sample that has none, -1 if all have one. start[i] .. start[i + 1] - 1 are the half-planes of sample i. */
MRTS_EXPORT long long mrts_backward(long long last, const double *step, const long long *start, const double *planes,
                                    double *low, double *high, double *work, int *iwork) {
    for (long long i = last - 1; i >= 0; --i) {
        const int left = (int)(start[i + 1] - start[i]), right = (int)(start[i + 2] - start[i + 1]);
        double *A = work, *lower = A + 2 * (left + right), *upper = lower + left + right + 2;
        double *lp_work = upper + left + right + 2;
        const int rows = mrts_segment(step[i], planes + 3 * start[i], left, planes + 3 * start[i + 1], right, A, upper);
        if (low[i] > high[i]) return i;
        if (mrts_controllable(rows, A, lower, upper, low + i, high + i, lp_work, iwork) != MRTS_OPTIMAL) return i;
    }
    return -1;
}

/* Forward: from x[0] the largest controllable speed at each next sample. */
MRTS_EXPORT void mrts_forward(long long last, const double *step, const long long *start, const double *planes,
                              const double *low, const double *high, double *x, double *work) {
    for (long long i = 0; i < last; ++i) {
        const int left = (int)(start[i + 1] - start[i]), right = (int)(start[i + 2] - start[i + 1]);
        double *A = work, *upper = A + 2 * (left + right), least = low[i + 1], most = high[i + 1];
        const int rows = mrts_segment(step[i], planes + 3 * start[i], left, planes + 3 * start[i + 1], right, A, upper);
        for (int row = 0; row < rows; ++row) {
            const double a = A[2 * row + 1];
            const double room = upper[row] - A[2 * row] * x[i] + MRTS_ON_LIMIT * (1 + MRTS_ABS(upper[row]));
            if (a > 0 && room / a < most) most = room / a;
            if (a < 0 && room / a > least) least = room / a;
        }
        x[i + 1] = most >= least ? most : (most + least) / 2; /* they miss each other by rounding only */
        if (x[i + 1] < 0) x[i + 1] = 0;
    }
}

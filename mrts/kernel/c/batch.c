/* SPDX-License-Identifier: MIT
 *
 * Whole batches in one call from Python: linear and quadratic programs, intervals of speeds, and
 * the passes of the fastest timing.
 */
#include "quadratic_programs.h"
#include "speed_intervals.h"

/* Reals and ints of work of the batches below. */
MRTS_EXPORT void mrts_lp_batch_work(int k, int rows, long long *reals, long long *ints) {
    *reals = MRTS_LP_WORK(k) + k;
    *ints = MRTS_LP_IWORK(k, rows) + k;
}

MRTS_EXPORT void mrts_qp_batch_work(int k, int rows, long long *reals, long long *ints) {
    *reals = MRTS_QP_WORK(k) + k;
    *ints = MRTS_QP_IWORK(k, rows) + k;
}

/* `count` linear programs, each started from the answer of the one before. Limits of rows and, after them, of the
 * unknowns, Shape (count, rows + k). Multipliers likewise: g + A'dual_rows + dual_unknowns = 0. */
MRTS_EXPORT void mrts_lp_batch(long long count, int k, int rows, const double *g, const double *A, const double *lower,
                               const double *upper, double *x, double *dual, unsigned char *status, double *work,
                               int *iwork) {
    double *y = work + MRTS_LP_WORK(k);
    int *basis = iwork + MRTS_LP_IWORK(k, rows), entering;
    basis[0] = 0;
    for (long long n = 0; n < count; ++n) {
        const double *lo = lower + n * (rows + k), *up = upper + n * (rows + k);
        double *d = dual + n * (rows + k);
        int found = mrts_lp(k, rows, A + n * k * rows, lo, up, g + n * k, basis, x + n * k, y, &entering, work, iwork);
        if (found == MRTS_STOPPED) {
            basis[0] = 0;
            found = mrts_lp(k, rows, A + n * k * rows, lo, up, g + n * k, basis, x + n * k, y, &entering, work, iwork);
        }
        for (int i = 0; i < rows + k; ++i) d[i] = 0;
        for (int j = 0; j < k; ++j) d[mrts_abs(basis[j]) - 1] = -y[j];
        if (entering) d[mrts_abs(entering) - 1] = entering < 0 ? -1 : 1;
        status[n] = (unsigned char)found;
        if (found != MRTS_OPTIMAL) basis[0] = 0;
    }
}

/* `count` strictly convex quadratic programs; as above, with Hx + g + A'dual_rows + dual_unknowns = 0. */
MRTS_EXPORT void mrts_qp_batch(long long count, int k, int rows, const double *H, const double *g, const double *A,
                               const double *lower, const double *upper, double *x, double *dual,
                               unsigned char *status, double *work, int *iwork) {
    double *u = work + MRTS_QP_WORK(k);
    int *active = iwork + MRTS_QP_IWORK(k, rows), active_count;
    for (long long n = 0; n < count; ++n) {
        const double *lo = lower + n * (rows + k), *up = upper + n * (rows + k);
        double *d = dual + n * (rows + k);
        status[n] = (unsigned char)mrts_qp(k, rows, H + n * k * k, A + n * k * rows, lo, up, g + n * k, x + n * k, active,
                                           u, &active_count, work, iwork);
        for (int i = 0; i < rows + k; ++i) d[i] = 0;
        for (int j = 0; j < active_count; ++j) {
            d[mrts_abs(active[j]) - 1] = active[j] < 0 ? -u[j] : u[j];
        }
    }
}

MRTS_EXPORT void mrts_interval_batch_work(int k, int rows, long long *reals, long long *ints) {
    *reals = MRTS_CURVE_WORK(k, rows) + k + 2 * (k + 1);
    *ints = MRTS_CURVE_IWORK(k, rows) + (MRTS_CURVE_BASES + 2) * (k + 1);
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

/*
 * The fastest speed along a path by reachability analysis (Pham and Pham, A new approach to time-optimal path
 * parameterization based on reachability analysis, IEEE T-RO 2018): x is the squared speed, u half its slope, constant
 * on each segment: x_(i+1) = x_i + 2 step_i u. Each sample has half-planes n_u u + n_x x <= h, which hold at both ends of
 * every segment (the interpolation scheme). Where u is to rise by a given amount along a segment, u is its mean.
 */
/* Rounding of a speed on a limit, relative to 1 and the limit, so that a region of one point does not miss itself. */
#define MRTS_ON_LIMIT 2e-10

/* A coefficient of u that is none: beside it all else would be infinite. */
#define MRTS_NO_RATE 1e-200

/* Half-planes over (u, x) as bounds start - slope x of u, and those without u as bounds of x. */
typedef struct {
    int least_count, most_count; /* of bounds from below, from above */
    double *least, *most;        /* start and slope of each, one after the other */
    double low, high;            /* of x */
} mrts_bounds;

/* Adds n_u u + n_x x <= h. */
static void mrts_add_bound(double u, double x, double h, mrts_bounds *bounds) {
    if (MRTS_ABS(u) > MRTS_NO_RATE) {
        const double per_u = 1 / u;
        double *next = u > 0 ? bounds->most + 2 * bounds->most_count++ : bounds->least + 2 * bounds->least_count++;
        next[0] = h * per_u;
        next[1] = x * per_u;
    } else if (x > 0) {
        if (h / x < bounds->high) bounds->high = h / x;
    } else if (x < 0) {
        if (h / x > bounds->low) bounds->low = h / x;
    }
}

/* The bounds of a segment over (u, x_i), x_i in [low, high]: those of its start, those of its end with x_(i+1) put in, and
 * the interval that x_(i+1) is to reach. `work` is for them all. */
static mrts_bounds mrts_segment(double step, double rise, const double *left, int left_count, const double *right,
                                int right_count, const double *reach, double low, double high, double *work) {
    mrts_bounds bounds = {0, 0, work, work + 2 * (left_count + right_count + 2), low, high};
    for (int end = 0; end < 2; ++end) {
        const double *plane = end ? right : left;
        const int count = end ? right_count : left_count;
        for (int i = 0; i < count; ++i, plane += 3) {
            mrts_add_bound(plane[0] + (end ? 2 * step * plane[1] : 0), plane[1],
                           plane[2] + MRTS_ON_LIMIT * (1 + MRTS_ABS(plane[2])) + (end ? -0.5 : 0.5) * rise * plane[0], &bounds);
        }
    }
    mrts_add_bound(-2 * step, -1, -reach[0], &bounds);
    mrts_add_bound(2 * step, 1, reach[1], &bounds);
    return bounds;
}

/* The interval of u at one x; its ends are on the lines start - slope x. */
typedef struct {
    double least, least_start, least_slope, most, most_start, most_slope;
} mrts_rates;

/* The interval of u that bounds leave at one x. */
static mrts_rates mrts_rates_at(const mrts_bounds *bounds, double x) {
    mrts_rates u = {-MRTS_INFINITY, -MRTS_INFINITY, 0, MRTS_INFINITY, MRTS_INFINITY, 0};
    for (const double *line = bounds->most; line < bounds->most + 2 * bounds->most_count; line += 2) {
        const double value = line[0] - line[1] * x;
        if (value >= u.most) continue;
        u.most = value;
        u.most_start = line[0];
        u.most_slope = line[1];
    }
    for (const double *line = bounds->least; line < bounds->least + 2 * bounds->least_count; line += 2) {
        const double value = line[0] - line[1] * x;
        if (value <= u.least) continue;
        u.least = value;
        u.least_start = line[0];
        u.least_slope = line[1];
    }
    return u;
}

/* The x nearest to `from` on the way to `to` that leaves some u: the interval's length is concave in x, so Newton's method
 * from outside ends at the exact line after finitely many steps. Returns 0 if there is none. */
static int mrts_nearest(const mrts_bounds *bounds, double from, double to, double *x) {
    const double inward = to >= from ? 1 : -1;
    *x = from;
    for (int step = 0; step <= bounds->least_count + bounds->most_count; ++step) {
        const mrts_rates u = mrts_rates_at(bounds, *x);
        const double slope = u.least_slope - u.most_slope;
        if (u.most >= u.least) return 1;
        if (slope * inward <= 0) return 0;
        /* where the two lines meet, from their coefficients: `from` may be many orders of magnitude away */
        const double next = (u.least_start - u.most_start) / slope;
        if (next == *x) return 1; /* nothing but rounding is left */
        if (*x == to) return 0;
        *x = (next - to) * inward > 0 ? to : next;
    }
    return 1;
}

/* Least and largest x_i that leave some u. Returns 0 if there is none. */
static int mrts_controllable(const mrts_bounds *bounds, double *low, double *high) {
    double least, most;
    if (bounds->low > bounds->high) return 0;
    if (!mrts_nearest(bounds, bounds->low, bounds->high, &least)) return 0;
    if (!mrts_nearest(bounds, bounds->high, bounds->low, &most)) return 0;
    *low = least;
    *high = most > least ? most : least;
    return 1;
}

/* Backward: the controllable sets [low, high] of samples 0 .. last, given as bounds of x and that of the last sample.
 * Returns the sample that has none, -1 if all have one. start[i] .. start[i + 1] - 1 are the half-planes of sample i. */
MRTS_EXPORT long long mrts_backward(long long last, const double *step, const double *rise, const long long *start,
                                    const double *planes, double *low, double *high, double *work) {
    for (long long i = last - 1; i >= 0; --i) {
        const int left = (int)(start[i + 1] - start[i]), right = (int)(start[i + 2] - start[i + 1]);
        const double reach[2] = {low[i + 1], high[i + 1]};
        const mrts_bounds bounds = mrts_segment(step[i], rise[i], planes + 3 * start[i], left, planes + 3 * start[i + 1], right,
                                                reach, low[i], high[i], work);
        if (!mrts_controllable(&bounds, low + i, high + i)) return i;
    }
    return -1;
}

/* Reals of work of both passes, where no two samples in a row have more than so many half-planes. */
MRTS_EXPORT long long mrts_segment_work(long long planes) { return 4 * (planes + 2); }

/* Forward: from x[0] the largest controllable speed at each next sample. */
MRTS_EXPORT void mrts_forward(long long last, const double *step, const double *rise, const long long *start,
                              const double *planes, const double *low, const double *high, double *x, double *work) {
    for (long long i = 0; i < last; ++i) {
        const int left = (int)(start[i + 1] - start[i]), right = (int)(start[i + 2] - start[i + 1]);
        const double reach[2] = {low[i + 1], high[i + 1]};
        const mrts_bounds bounds = mrts_segment(step[i], rise[i], planes + 3 * start[i], left, planes + 3 * start[i + 1], right,
                                                reach, x[i], x[i], work);
        const mrts_rates u = mrts_rates_at(&bounds, x[i]);
        const double next = x[i] + 2 * step[i] * (u.most >= u.least ? u.most : (u.most + u.least) / 2);
        x[i + 1] = next < low[i + 1] ? low[i + 1] : next > high[i + 1] ? high[i + 1] : next;
    }
}

/* SPDX-License-Identifier: MIT
 *
 * Whole batches in one call from Python: linear and quadratic programs, intervals of speeds, and
 * the passes of the fastest timing. */
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

/*
 * The fastest speed along a path by reachability analysis (Pham and Pham, A new approach to time-optimal path
 * parameterization based on reachability analysis, IEEE T-RO 2018): x is the squared speed, u half its slope, constant
 * on each segment: x_(i+1) = x_i + 2 step_i u. Each sample has half-planes n_u u + n_x x <= h, which hold at both ends of
 * every segment (the interpolation scheme). Where u is to rise by a given amount along a segment, u is its mean. */
/* Rounding of a speed on a limit, relative to 1 and the limit, so that a region of one point does not miss itself. */
#define MRTS_ON_LIMIT 2e-10

/* A coefficient of u that is none: beside it all else would be infinite. */
#define MRTS_NO_RATE 1e-200

/* Bounds start - slope x of u, from below and from above, and of x. */
typedef struct {
    double *least, *least_end, *most, *most_end; /* start and slope of each, one after the other */
    double low, high;
} mrts_bounds;

/* Adds n_u u + n_x x <= h. */
static inline void mrts_add_bound(double u, double x, double h, mrts_bounds *bounds) {
    const double per_u = 1 / u;
    if (u > MRTS_NO_RATE) {
        bounds->most_end[0] = h * per_u;
        bounds->most_end[1] = x * per_u;
        bounds->most_end += 2;
    } else if (u < -MRTS_NO_RATE) {
        bounds->least_end[0] = h * per_u;
        bounds->least_end[1] = x * per_u;
        bounds->least_end += 2;
    } else if (x > 0) {
        if (h / x < bounds->high) bounds->high = h / x;
    } else if (x < 0) {
        if (h / x > bounds->low) bounds->low = h / x;
    }
}

/* The bounds of a segment over (u, x_i), x_i in [low, high]: those of its start, those of its end with x_(i+1) put in, and
 * the interval that x_(i+1) is to reach. `work` has 4 reals for each of them all and of the interval's two ends. */
static inline mrts_bounds mrts_segment(double step, double rise, const double *left, const double *right,
                                       const double *right_end, const double *reach, double low, double high,
                                       double *work) {
    double *half = work + 2 * ((right_end - left) / 3 + 2);
    mrts_bounds bounds = {work, work, half, half, low, high};
    double ahead = 0, away = 0.5 * rise;
    for (const double *plane = left; plane < right_end; plane += 3) {
        if (plane == right) {
            ahead = 2 * step;
            away = -away;
        }
        mrts_add_bound(plane[0] + ahead * plane[1], plane[1],
                       plane[2] + MRTS_ON_LIMIT * (1 + MRTS_ABS(plane[2])) + away * plane[0], &bounds);
    }
    mrts_add_bound(-2 * step, -1, -reach[0], &bounds);
    mrts_add_bound(2 * step, 1, reach[1], &bounds);
    return bounds;
}

/* The interval of u at one x, and the bounds that its ends are on. */
typedef struct {
    double least, most;
    const double *least_bound, *most_bound;
} mrts_rates;

static inline mrts_rates mrts_rates_at(const mrts_bounds *bounds, double x) {
    mrts_rates u = {-MRTS_INFINITY, MRTS_INFINITY, 0, 0};
    for (const double *bound = bounds->most; bound < bounds->most_end; bound += 2) {
        const double value = bound[0] - bound[1] * x;
        if (value >= u.most) continue;
        u.most = value;
        u.most_bound = bound;
    }
    for (const double *bound = bounds->least; bound < bounds->least_end; bound += 2) {
        const double value = bound[0] - bound[1] * x;
        if (value <= u.least) continue;
        u.least = value;
        u.least_bound = bound;
    }
    return u;
}

/* The x nearest to `from` on the way to `to` that leaves some u: the interval's length is concave in x, so Newton's method
 * from outside ends at the exact line after finitely many steps. Returns 0 if there is none. `meet` are places of the two
 * bounds that met there on a segment before, or -1: where they meet now is outside too, and near. */
static int mrts_nearest(const mrts_bounds *bounds, double from, double to, long long *meet, double *x) {
    const double inward = to >= from ? 1 : -1;
    const double *least = bounds->least + 2 * meet[0], *most = bounds->most + 2 * meet[1];
    *x = from;
    if (meet[0] >= 0 && least < bounds->least_end && most < bounds->most_end && (least[1] - most[1]) * inward > 0) {
        const double before = (least[0] - most[0]) / (least[1] - most[1]);
        if ((before - from) * inward > 0) *x = (before - to) * inward > 0 ? to : before;
    }
    for (long long left = bounds->least_end - bounds->least + bounds->most_end - bounds->most; left >= 0; left -= 2) {
        const mrts_rates u = mrts_rates_at(bounds, *x);
        if (u.most >= u.least) return 1;
        const double slope = u.least_bound[1] - u.most_bound[1];
        if (slope * inward <= 0) return 0;
        /* where the two lines meet, from their coefficients: `from` may be many orders of magnitude away */
        const double next = (u.least_bound[0] - u.most_bound[0]) / slope;
        if (next == *x) return 1; /* nothing but rounding is left */
        if (*x == to) return 0;
        *x = (next - to) * inward > 0 ? to : next;
        meet[0] = (u.least_bound - bounds->least) / 2;
        meet[1] = (u.most_bound - bounds->most) / 2;
    }
    return 1;
}

/* Backward: the controllable sets [low, high] of samples 0 .. last, given as bounds of x and that of the last sample.
 * Forward: from the x[0] in them the largest controllable speed at each next sample. Returns the sample that has none, -1 if all
 * have one. start[i] .. start[i + 1] - 1 are the half-planes of sample i. */
MRTS_EXPORT long long mrts_fastest(long long last, const double *step, const double *rise, const long long *start,
                                   const double *planes, double *low, double *high, double *x, double *work) {
    long long meet[2][2] = {{-1, -1}, {-1, -1}};
    for (long long i = last - 1; i >= 0; --i) {
        const double reach[2] = {low[i + 1], high[i + 1]};
        const mrts_bounds bounds = mrts_segment(step[i], rise[i], planes + 3 * start[i], planes + 3 * start[i + 1],
                                                planes + 3 * start[i + 2], reach, low[i], high[i], work);
        double least, most; /* x_i that leaves some u */
        if (bounds.low > bounds.high || !mrts_nearest(&bounds, bounds.low, bounds.high, meet[0], &least) ||
            !mrts_nearest(&bounds, bounds.high, bounds.low, meet[1], &most)) {
            return i;
        }
        low[i] = least;
        high[i] = most > least ? most : least;
    }
    for (long long i = 0; i <= last; ++i) {
        x[i] = x[i] < low[i] ? low[i] : x[i] > high[i] ? high[i] : x[i];
        if (i == last) break;
        const double reach[2] = {low[i + 1], high[i + 1]};
        const mrts_bounds bounds = mrts_segment(step[i], rise[i], planes + 3 * start[i], planes + 3 * start[i + 1],
                                                planes + 3 * start[i + 2], reach, x[i], x[i], work);
        const mrts_rates u = mrts_rates_at(&bounds, x[i]);
        x[i + 1] = x[i] + 2 * step[i] * (u.most >= u.least ? u.most : (u.most + u.least) / 2);
    }
    return -1;
}

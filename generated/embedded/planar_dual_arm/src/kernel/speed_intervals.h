/* SPDX-License-Identifier: MIT
 *
 * Which speeds one sample admits where its rows have a term in the speed beside one in its square:
 *
 *     lower_i <= a_i'F + b_i x + d_i y <= upper_i   with   x = y^2, y >= 0.
 *
 * At a fixed y that is a polytope of F. Of all (F, x, y) the rows leave a polytope too; the admissible y are where the
 * curve (y^2, y) meets its projection onto the plane (x, y), a convex polygon: a union of intervals, of which the highest
 * is found, by linear programs. The largest and the least y with some x >= y^2 bound a convex set: tangents of the parabola
 * are cuts, and the edge that each answer lies on says where the next one touches. What they leave lacks only points where
 * every x is above the parabola: the lower hull of the polygon is followed there, edge by edge from above, until one is
 * found that lies above the parabola. So both ends are on chords of feasible points. */
#ifndef MRTS_SPEED_INTERVALS_H
#define MRTS_SPEED_INTERVALS_H

#include "linear_programs.h"
#include "rows.h"

/* The rows over F, x and y, in whose place mrts_highest_interval works: n unknowns, x and y last, and one row more than the
 * sample has, for tangents. */
typedef struct {
    int n, rows;
    mrts_real *A;              /* Shape (rows, n) */
    mrts_real *lower, *upper; /* of the rows, then of the unknowns */
    mrts_real *work;
    int *iwork;
} mrts_curve;

/* Where the programs of one sample ended, from which those of the next start (zeros: cold), and the rows that determine its
 * least and its largest y with their multipliers, as mrts_lp gives them: low first, then high. Row `rows - 1` is a tangent. */
#define MRTS_CURVE_BASES 3
typedef struct {
    mrts_real speed;      /* largest y */
    int *basis;           /* MRTS_CURVE_BASES * n */
    int *end_basis;       /* 2 * n */
    mrts_real *end_dual;  /* 2 * n */
} mrts_curve_ends;

/* Reals and ints of work of a curve over `rows` limits and k unknowns F, x. */
#define MRTS_CURVE_WORK(k, rows) \
    (((rows) + 1) * ((k) + 1) + 2 * ((rows) + (k) + 2) + 3 * ((k) + 1) + MRTS_LP_WORK((k) + 1))
#define MRTS_CURVE_IWORK(k, rows) (MRTS_LP_IWORK((k) + 1, (rows) + 1))

/* An interval of y that a sample admits, high MRTS_INFINITY where nothing bounds it, and a y in the gap between it and what
 * may be admitted below, 0 where nothing is. */
typedef struct {
    mrts_real low, high, gap;
} mrts_interval;

/* How far a point may be off the parabola, relative to it. */
#define MRTS_ON_CURVE MRTS_EITHER(1e-12, 1e-5)

/* What is rounding of x beside a point of the parabola; an edge is final if nothing lies further out than EDGES times it. */
static mrts_real mrts_near_curve(mrts_real y) { return MRTS_ON_CURVE * y * y + MRTS_ROUNDING; }
#define MRTS_EDGES 100

/* Tangents of one end, corners of the lower hull between both, and chords that are looked at for them. */
enum { MRTS_TANGENTS = 60, MRTS_HULL = 32, MRTS_TURNS = 4 * MRTS_HULL };

enum { MRTS_BASIS_UPPER, MRTS_BASIS_LOWER, MRTS_BASIS_HULL };

typedef struct {
    mrts_real x, y;
} mrts_point;

/* The column of y: what a speed of 1 adds to each row, in units of its limit. */
static inline void mrts_speed_column(int joints, const mrts_limits *limits, const mrts_terms *terms, const mrts_rows *rows,
                                     mrts_real *speed) {
    for (int i = 0; i < rows->count; ++i) {
        const int row = rows->which[i];
        mrts_real sum = terms->speed ? terms->speed[row] : 0;
        for (int entry = limits->start[row]; terms->torque_speed && entry < limits->start[row + 1]; ++entry) {
            if (limits->column[entry] < joints) sum += limits->value[entry] * terms->torque_speed[limits->column[entry]];
        }
        speed[i] = sum / rows->unit[i];
    }
}

/* Puts scaled rows over F and x = c^2 and a column of y together; `column` are the scales of mrts_scale_columns. Returns the
 * unit of x, that of y is its root: so that together they move some row by about one limit. 0 where neither moves any. */
static inline mrts_real mrts_curve_over(int k, const mrts_rows *rows, const mrts_real *column, const mrts_real *speed,
                                        mrts_real *work, int *iwork, mrts_curve *curve) {
    const int n = k + 1, count = rows->count + 1;
    mrts_real of_square = 0, of_speed = 0, unit = 0;
    curve->n = n;
    curve->rows = count;
    curve->A = work;
    curve->lower = curve->A + count * n;
    curve->upper = curve->lower + count + n;
    curve->work = curve->upper + count + n;
    curve->iwork = iwork;
    for (int i = 0; i < rows->count; ++i) {
        if (rows->A[i * k + k - 1] != 0) of_square = 1 / column[k - 1];
        if (MRTS_ABS(speed[i]) > of_speed) of_speed = MRTS_ABS(speed[i]);
    }
    of_speed *= of_speed;
    if (of_square > MRTS_NO_EFFECT || of_speed > MRTS_NO_EFFECT) unit = 1 / (of_square > of_speed ? of_square : of_speed);
    const mrts_real root = MRTS_SQRT(unit);
    for (int i = 0; i < rows->count; ++i) {
        for (int j = 0; j < k - 1; ++j) curve->A[i * n + j] = rows->A[i * k + j];
        curve->A[i * n + k - 1] = rows->A[i * k + k - 1] * (unit * of_square);
        curve->A[i * n + k] = speed[i] * root;
        curve->lower[i] = rows->lower[i];
        curve->upper[i] = rows->upper[i];
    }
    for (int j = 0; j < n; ++j) {
        curve->A[(count - 1) * n + j] = 0;
        curve->lower[count + j] = -MRTS_INFINITY;
        curve->upper[count + j] = MRTS_INFINITY;
    }
    return unit;
}

/* The cut x - 2 t y >= -t^2, which touches the parabola at t. Returns what the row is divided by. */
static mrts_real mrts_cut(mrts_curve *curve, mrts_real t) {
    mrts_real *row = curve->A + (curve->rows - 1) * curve->n + curve->n - 2;
    const mrts_real size = t > MRTS_C(0.5) ? 2 * t : 1;
    row[0] = 1 / size;
    row[1] = -2 * t / size;
    curve->lower[curve->rows - 1] = -t * t / size;
    curve->upper[curve->rows - 1] = MRTS_INFINITY;
    return size;
}

static void mrts_box(mrts_curve *curve, mrts_real least_x, mrts_real most_x, mrts_real least_y, mrts_real most_y) {
    const int x = curve->rows + curve->n - 2;
    curve->lower[x] = least_x;
    curve->upper[x] = most_x;
    curve->lower[x + 1] = least_y;
    curve->upper[x + 1] = most_y;
}

/* The point that minimises gx x + gy y, and the multiplier of the cut, >= 0; a status of mrts_lp. */
static int mrts_outermost(mrts_curve *curve, mrts_real gx, mrts_real gy, int *basis, mrts_point *found, mrts_real *of_cut) {
    const int n = curve->n;
    mrts_real *g = curve->work, *z = g + n, *dual = z + n;
    int entering;
    for (int j = 0; j < n; ++j) g[j] = 0;
    g[n - 2] = gx;
    g[n - 1] = gy;
    const int status = mrts_lp_again(n, curve->rows, curve->A, curve->lower, curve->upper, g, basis, z, dual, &entering,
                                     dual + n, curve->iwork);
    *of_cut = 0;
    if (status != MRTS_OPTIMAL) {
        basis[0] = 0;
        return status;
    }
    for (int j = 0; j < n; ++j) {
        if (basis[j] == -curve->rows) *of_cut = dual[j];
    }
    found->x = z[n - 2];
    found->y = z[n - 1];
    return status;
}

/* Where the parabola meets the edge m x + (side - 2 t m) y <= m p_x + (side - 2 t m) p_y through a point p, m >= 0, on the
 * side of p; where they do not meet, the y at which the parabola comes closest to it. */
static mrts_real mrts_next_tangent(mrts_real m, mrts_real t, mrts_real side, mrts_point p) {
    const mrts_real slope = side - 2 * t * m, limit = m * p.x + slope * p.y;
    const mrts_real square = slope * slope + 4 * m * limit;
    if (m <= 0) return p.y;
    if (square <= 0) return -slope / (2 * m);
    const mrts_real root = MRTS_SQRT(square);
    if (side > 0) return slope >= 0 ? 2 * limit / (slope + root) : (root - slope) / (2 * m);
    return slope <= 0 ? -2 * limit / (root - slope) : -(slope + root) / (2 * m);
}

/* The point with the largest (side 1) or the least (side -1) y that has some x >= y^2, to rounding. */
static int mrts_outer_end(mrts_curve *curve, mrts_real side, mrts_real t, int *basis, mrts_point *end) {
    for (int turn = 0; turn < MRTS_TANGENTS; ++turn) {
        mrts_real of_cut;
        const mrts_real size = mrts_cut(curve, t);
        const int status = mrts_outermost(curve, 0, -side, basis, end, &of_cut);
        if (status != MRTS_OPTIMAL) return status;
        if (end->y * end->y - end->x <= mrts_near_curve(end->y)) return MRTS_OPTIMAL;
        const mrts_real next = mrts_next_tangent(of_cut / size, t, side, *end);
        t = next > 0 ? next : 0;
    }
    return MRTS_STOPPED;
}

/* How far a chord reaches above the parabola, in units of x, and where, from *low to *high; 0 if by no more than rounding. */
static mrts_real mrts_above_curve(mrts_point a, mrts_point b, mrts_real *low, mrts_real *high) {
    const mrts_real width = b.y - a.y, slope = width > 0 ? (b.x - a.x) / width : 0, start = a.x - slope * a.y;
    mrts_real top = slope / 2;
    if (top < a.y) top = a.y;
    if (top > b.y) top = b.y;
    const mrts_real height = start + slope * top - top * top;
    if (height <= MRTS_EDGES * mrts_near_curve(b.y)) return 0;
    const mrts_real root = MRTS_SQRT(slope * slope + 4 * start);
    const mrts_real far = (slope >= 0 ? slope + root : slope - root) / 2, near = far != 0 ? -start / far : 0;
    *low = far < near ? far : near;
    *high = far < near ? near : far;
    if (*low < a.y) *low = a.y;
    if (*high > b.y) *high = b.y;
    return height;
}

static int mrts_is_above(mrts_point p) { return p.x - p.y * p.y > MRTS_EDGES * mrts_near_curve(p.y); }

/* Keeps what determined the last answer as what determines an end (0: low, 1: high). */
static void mrts_keep_end(const mrts_curve *curve, const int *basis, int end, mrts_curve_ends *ends) {
    const mrts_real *dual = curve->work + 2 * curve->n;
    for (int j = 0; j < curve->n; ++j) {
        ends->end_basis[end * curve->n + j] = basis[j];
        ends->end_dual[end * curve->n + j] = dual[j];
    }
}

/* The points with the least and the largest y that have some x >= y^2. */
static int mrts_outer_ends(mrts_curve *curve, mrts_real reach, mrts_curve_ends *ends, mrts_point *low, mrts_point *high) {
    const int n = curve->n, y = curve->rows + n - 1;
    int *basis = ends->basis + MRTS_BASIS_UPPER * n, status;
    mrts_real unused;
    mrts_box(curve, 0, reach * reach, 0, reach);
    status = mrts_outer_end(curve, 1, ends->speed > 0 && ends->speed < reach ? ends->speed : reach < 1 ? reach : 1, basis,
                            high);
    if (status != MRTS_OPTIMAL) return status;
    mrts_keep_end(curve, basis, 1, ends);
    basis = ends->basis + MRTS_BASIS_LOWER * n;
    curve->lower[curve->rows - 1] = -MRTS_INFINITY; /* no cut */
    mrts_box(curve, 0, 0, 0, 0);
    if (mrts_outermost(curve, 0, 0, basis, low, &unused) == MRTS_OPTIMAL) {
        for (int j = 0; j < n; ++j) {
            ends->end_basis[j] = -1 - y;
            ends->end_dual[j] = j == 0;
        }
        return MRTS_OPTIMAL;
    }
    mrts_box(curve, 0, reach * reach, 0, reach); /* it cannot stand still */
    basis[0] = 0;
    status = mrts_outer_end(curve, -1, 0, basis, low);
    if (status == MRTS_OPTIMAL) mrts_keep_end(curve, basis, 0, ends);
    basis[0] = 0;
    return status;
}

/* The highest interval of admissible y <= most. Returns MRTS_OPTIMAL, MRTS_INFEASIBLE where no y is admissible, or another
 * status of mrts_lp where that was not decided. */
static inline int mrts_highest_interval(mrts_curve *curve, mrts_real most, mrts_curve_ends *ends, mrts_interval *found) {
    const mrts_real bound = MRTS_SQRT(MRTS_UNBOUNDED), reach = most < bound ? most : bound;
    mrts_point below[MRTS_HULL], a, b, corner; /* corners of the hull below b, the highest last */
    int *basis = ends->basis + MRTS_BASIS_HULL * curve->n, count = 1, is_open = 0;
    mrts_real unused, low, high;

    int status = mrts_outer_ends(curve, reach, ends, below, &b);
    if (status != MRTS_OPTIMAL) return status;
    const mrts_real top = b.y;
    if (top < below[0].y) b = below[0];
    ends->speed = top;
    curve->lower[curve->rows - 1] = -MRTS_INFINITY;
    found->high = top >= bound * (1 - MRTS_EDGES * MRTS_ON_CURVE) ? MRTS_INFINITY : b.y;
    found->gap = 0;
    for (int turn = 0; count > 0; ++turn) {
        if (turn == MRTS_TURNS) return MRTS_STOPPED;
        a = below[count - 1];
        const mrts_real height = mrts_above_curve(a, b, &low, &high);
        if (height <= 0) {
            is_open = 1;
            b = below[--count];
            continue;
        }
        const mrts_real slope = b.y > a.y ? (b.x - a.x) / (b.y - a.y) : 0;
        /* what the chord cuts off has no larger x; a wider box would multiply the rounding of its multiplier */
        mrts_box(curve, -top * top, a.x > b.x ? a.x : b.x, a.y, b.y);
        status = mrts_outermost(curve, 1, -slope, basis, &corner, &unused);
        if (status != MRTS_OPTIMAL) return status;
        if (corner.x - a.x - slope * (corner.y - a.y) < -MRTS_EDGES * mrts_near_curve(b.y)) {
            if (corner.y <= a.y + MRTS_ON_CURVE * b.y) {
                below[count - 1].x = corner.x;
            } else if (corner.y >= b.y - MRTS_ON_CURVE * b.y) {
                b.x = corner.x;
            } else if (count == MRTS_HULL) {
                return MRTS_STOPPED;
            } else {
                below[count++] = corner;
            }
            continue;
        }
        /* the chord is an edge, above the parabola from low to high */
        const int opens = !mrts_is_above(a) || low > a.y;
        is_open = is_open || !mrts_is_above(b) || high < b.y;
        if (is_open && !(opens && height <= MRTS_SEPARATED * (1 + b.y * b.y))) { /* else no gap can be proved */
            found->low = high;
            found->gap = opens || count > 1 ? (low + high) / 2 : 0;
            mrts_keep_end(curve, basis, 0, ends);
            return MRTS_OPTIMAL;
        }
        if (!is_open && opens) {
            is_open = 1;
            found->high = low;
            mrts_keep_end(curve, basis, 1, ends);
        }
        b = below[--count];
    }
    found->low = b.y;
    return is_open ? MRTS_OPTIMAL : MRTS_INFEASIBLE;
}

#endif

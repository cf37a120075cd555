/* SPDX-License-Identifier: MIT
 *
 * Which speeds one sample admits where its rows have a term in the speed beside one in its square:
 *
 *     lower_i <= a_i'F + b_i x + d_i y <= upper_i   with   x = y^2, y >= 0.
 *
 * At a fixed y that is a polytope of F. Of all (F, x, y) the rows leave a polytope too; the admissible y are where the
 * curve (y^2, y) meets its projection onto the plane (x, y), a convex polygon: a union of intervals, of which the highest
 * is found.
 */
#ifndef MRTS_SPEED_INTERVALS_H
#define MRTS_SPEED_INTERVALS_H

#include "linear_programs.h"
#include "rows.h"

/* The rows over F, x and y, in whose place mrts_highest_interval works: n unknowns, x and y last, and one row more than the
 * sample has, for tangents. */
typedef struct {
    int n, rows;
    mrts_real *A;     /* Shape (rows, n) */
    mrts_real *lower; /* of the rows, then of the unknowns */
    mrts_real *upper;
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

/* The column of y: what a speed of 1 adds to each row, in units of its limit. */
MRTS_LOCAL void mrts_speed_column(int joints, const mrts_limits *limits, const mrts_terms *terms, const mrts_rows *rows,
                                  mrts_real *speed);

/* Puts scaled rows over F and x = c^2 and a column of y together; `column` are the scales of mrts_scale_columns. Returns the
 * unit of x, that of y is its root: so that together they move some row by about one limit. 0 where neither moves any. */
MRTS_LOCAL mrts_real mrts_curve_over(int k, const mrts_rows *rows, const mrts_real *column, const mrts_real *speed,
                                     mrts_real *work, int *iwork, mrts_curve *curve);

/* An interval of y that a sample admits, high MRTS_INFINITY where nothing bounds it, and a y in the gap between it and what
 * may be admitted below, 0 where nothing is. */
typedef struct {
    mrts_real low, high, gap;
} mrts_interval;

/* The highest interval of admissible y <= most. Returns MRTS_OPTIMAL, MRTS_INFEASIBLE where no y is admissible, or another
 * status of mrts_lp where that was not decided. */
MRTS_LOCAL int mrts_highest_interval(mrts_curve *curve, mrts_real most, mrts_curve_ends *ends, mrts_interval *found);

#endif

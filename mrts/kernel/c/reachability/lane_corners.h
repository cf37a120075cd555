/* SPDX-License-Identifier: MIT
 *
 * Projections of several samples side by side, whose corners have the rows of the sample before.
 */
#ifndef MRTS_LANE_CORNERS_H
#define MRTS_LANE_CORNERS_H

#include "../lanes/lane_types.h"
#include "projection.h"

/* Polytopes one after the other: rows which[0 .. rows - 1] of `all` rows of A, Shape (count, all, k), whose columns are
 * multiplied by scale, Shape (count, k), and bounds of u and x, the last two of the k unknowns, Shape (count, 2) each. */
typedef struct {
    long long count;
    int k;
    int all;
    int rows;
    const int *which;
    const double *A;
    const double *lower;
    const double *upper;
    const double *scale;
    const double *least;
    const double *most;
} mrts_polytopes;

/* A limit as mrts_lp has it. */
static inline double mrts_finite(double limit) {
    return limit < -MRTS_INFINITY ? -MRTS_INFINITY : limit > MRTS_INFINITY ? MRTS_INFINITY : limit;
}

/* Some of them in lanes, and what is known of all: the unknown that a row alone bounds. */
typedef struct {
    const mrts_polytopes *of;
    mrts_lanes *A; /* (rows, k) */
    mrts_lanes *lower;
    mrts_lanes *upper;
    mrts_lanes *least; /* limits with their rounding */
    mrts_lanes *most;
    mrts_lanes *per;    /* of a row that bounds one unknown alone: 1 over its coefficient, (rows) */
    mrts_lanes *corner; /* of each corner u, x, and of u and of x what rows of the basis weigh in it, (MRTS_CORNERS, 2 + 2 k) */
    mrts_lanes *z;      /* a point, (k) */
    mrts_lanes *B;      /* of the rows that bound several unknowns, (k, k) */
    mrts_lanes *right;  /* their right-hand sides, (k) */
    mrts_lanes *limit;  /* of the rows of the basis, (k) */
    mrts_lanes *share;  /* what those of several unknowns weigh in u and in x, (2, k) */
    const mrts_lanes **row; /* these rows, (k) */
    int *alone;         /* of each row the unknown that it alone bounds, -1 where it bounds several, (rows) */
    int *several;       /* rows that bound several, in fours: the last is repeated, (rows + 3) */
    int several_count;
    int *fixing;        /* of each unknown the place in the basis that alone determines it, -1 where none does, (k) */
    int *open;          /* unknowns that none alone determines, then the others, (k) */
    int *joint;         /* places of the rows that determine these, (k) */
    mrts_lane_mask fit; /* samples whose rows bound one unknown alone where they are said to */
} mrts_lane_polytopes;

#define MRTS_LANE_CORNER(k) (2 + 2 * (k))
#define MRTS_LANE_POLYTOPES_WORK(k, rows) \
    (MRTS_LANES * ((rows) * ((k) + 1) + 4 * ((rows) + (k)) + MRTS_CORNERS * MRTS_LANE_CORNER(k) + (k) * (k) + 6 * (k)))
#define MRTS_LANE_POLYTOPES_IWORK(k, rows) (2 * (rows) + 3 + 3 * (k))

/* Lays them out in work arrays. */
MRTS_LOCAL mrts_lane_polytopes mrts_lane_polytopes_in(const mrts_polytopes *of, double *work, int *iwork);

/* Takes the samples from `first` on; beyond the last the last is repeated. */
MRTS_LOCAL void mrts_take_polytopes(long long first, mrts_lane_polytopes *in);

/* Of which samples the bases of an outline are all corners: each is verified as a corner of mrts_project, and each edge. */
MRTS_LOCAL void mrts_known_outline(const mrts_lane_polytopes *in, const mrts_outline *outline, mrts_lane_mask *known);

#endif

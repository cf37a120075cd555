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

/* Some of them in lanes. */
typedef struct {
    const mrts_polytopes *of;
    mrts_lanes *A; /* (rows, k) */
    mrts_lanes *lower;
    mrts_lanes *upper;
    mrts_lanes *corner; /* of each corner u, x, and of u and of x what rows of the basis weigh in it, (MRTS_CORNERS, 2 + 2 k) */
    int *basis;         /* of each corner, its rows in the order of these weights, (MRTS_CORNERS, k) */
    mrts_lanes *work;   /* (k + 2, k) */
    int *row;           /* (k) */
} mrts_lane_polytopes;

#define MRTS_LANE_CORNER(k) (2 + 2 * (k))
#define MRTS_LANE_POLYTOPES_WORK(k, rows) \
    (MRTS_LANES * ((rows) * (k) + 2 * ((rows) + (k)) + MRTS_CORNERS * MRTS_LANE_CORNER(k) + (k) * (k) + 2 * (k)))
#define MRTS_LANE_POLYTOPES_IWORK(k) ((MRTS_CORNERS + 1) * (k))

/* Lays them out in work arrays. */
MRTS_LOCAL mrts_lane_polytopes mrts_lane_polytopes_in(const mrts_polytopes *of, double *work, int *iwork);

/* Takes the samples from `first` on; beyond the last the last is repeated. */
MRTS_LOCAL void mrts_take_polytopes(long long first, mrts_lane_polytopes *in);

/* Of which samples the bases of an outline are all corners: each is verified as a corner of mrts_project, and each edge. */
MRTS_LOCAL mrts_lane_mask mrts_known_outline(const mrts_lane_polytopes *in, const mrts_outline *outline);

#endif

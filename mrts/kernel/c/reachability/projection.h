/* SPDX-License-Identifier: MIT
 *
 * The projection of a polytope onto its last two unknowns, u and x, from inside: its corners are projections of points that
 * keep all limits, so whatever is a mixture of them is feasible. They are counter-clockwise in the plane (u, x).
 */
#ifndef MRTS_PROJECTION_H
#define MRTS_PROJECTION_H

#include "corners.h"

/* Most corners of one projection; a polygon with more is replaced by one inside it. */
#define MRTS_CORNERS 64

/* The bases of a projection's corners; of one without inside that of one corner, and none at all for a cold start. */
typedef struct {
    int count;
    int *basis; /* (MRTS_CORNERS, k) */
} mrts_outline;

#define MRTS_OUTLINE_IWORK(k) (MRTS_CORNERS * (k))

/* The corners, started from an outline, which becomes that of this projection; a status of mrts_lp. */
#define MRTS_PROJECT_WORK(k, rows) (MRTS_FURTHEST_WORK(k, rows) + (MRTS_CORNERS + 1) * MRTS_CORNER_WORK(k))
#define MRTS_PROJECT_IWORK(k, rows) (MRTS_LP_IWORK(k, rows) + (MRTS_CORNERS + 1) * (k))
MRTS_LOCAL int mrts_project(mrts_polytope *polytope, mrts_outline *outline, int *count, double *corners, double *work,
                            int *iwork);

#endif

/* SPDX-License-Identifier: MIT
 *
 * The projection of a polytope onto its last two unknowns, u and x, from inside: its corners are projections of points that
 * keep all limits, so whatever is a mixture of them is feasible. They are counter-clockwise in the plane (u, x). Each is
 * given by k rows at a limit, the basis, as mrts_lp codes it.
 */
#ifndef MRTS_PROJECTION_H
#define MRTS_PROJECTION_H

#include "../linear_programs.h"

/* An edge is final if nothing lies further out than this, in units of the limits and of the corners' size. */
#define MRTS_OUTSIDE 1e-9

/* Most corners of one projection; a polygon with more is replaced by one inside it. */
#define MRTS_CORNERS 64

/* { z : lower <= (A z, z) <= upper }, limits of the rows and then of the k unknowns, as a program of mrts_lp has them. */
typedef struct {
    int k;
    int rows;
    double *A; /* (rows, k) */
    double *lower;
    double *upper;
} mrts_polytope;

/* Reals of a polytope's memory. */
#define MRTS_POLYTOPE_WORK(k, rows) ((rows) * (k) + 2 * ((rows) + (k)))

/* The bases of a projection's corners, from the first of which the next projection starts; none for a cold start. */
typedef struct {
    int count;
    int *basis; /* (MRTS_CORNERS, k) */
} mrts_outline;

#define MRTS_OUTLINE_IWORK(k) (MRTS_CORNERS * (k))

/* The corners, started from an outline, which becomes that of this projection; a status of mrts_lp. */
#define MRTS_PROJECT_WORK(k) (MRTS_LP_WORK(k) + 3 * (k) + (MRTS_CORNERS + 1) * (2 + 2 * (k)))
#define MRTS_PROJECT_IWORK(k, rows) (MRTS_LP_IWORK(k, rows) + (MRTS_CORNERS + 1) * (k))
MRTS_LOCAL int mrts_project(const mrts_polytope *polytope, mrts_outline *outline, int *count, double *corners, double *work,
                            int *iwork);

#endif

/* SPDX-License-Identifier: MIT
 *
 * The corners of a polytope's projection onto its last two unknowns, u and x. Each is the projection of a point that keeps
 * all limits, given by k rows at a limit, the basis, as mrts_lp codes it.
 */
#ifndef MRTS_CORNERS_H
#define MRTS_CORNERS_H

#include "../linear_programs.h"

/* An edge is final if nothing lies further out than this, in units of the limits and of the corners' size. */
#define MRTS_OUTSIDE 1e-9

/* Lengths are multiples of four: loops then take four numbers at a time, two of them in one instruction. */
#define MRTS_FOURS(count) (((count) + 3) / 4 * 4)

/* { z : lower <= (A z, z) <= upper }, limits of the rows and then of the k unknowns, as a program of mrts_lp has them, and
 * the inverse of the last basis that was looked at. */
typedef struct {
    int k;
    int rows;
    int width;     /* k in fours: what follows it below are zeros */
    double *A;     /* (rows, width) */
    double *fours; /* the same, four rows at a time: (rows / 4, k, 4) */
    double *lower;
    double *upper;
    double *least; /* limits with their rounding */
    double *most;
    double *inverse; /* of the rows of the basis, (k, width) */
    double *alpha;   /* how a row is made up of them, (width) */
    double *y;       /* multipliers, (width) */
    double *point;   /* (width) */
    int *place;      /* of each row in the basis, -1 if it is none of it */
    int *code;       /* of each place, as in mrts_lp */
    int *kept;       /* whether a place is one of the next basis */
    int *missing;
    int *is_single; /* rows with one coefficient cost little */
} mrts_polytope;

/* Reals and ints of a polytope's memory, and the polytope laid out in them. */
#define MRTS_POLYTOPE_WORK(k, rows) \
    (((rows) + MRTS_FOURS(rows) + (k) + 3) * MRTS_FOURS(k) + 4 * (MRTS_FOURS(rows) + (k)))
#define MRTS_POLYTOPE_IWORK(k, rows) (2 * (rows) + 4 * (k))
MRTS_LOCAL mrts_polytope mrts_polytope_in(int k, int rows, double *work, int *iwork);

/* To be called once A, lower and upper are there. */
MRTS_LOCAL void mrts_begin_polytope(mrts_polytope *polytope);

/* A corner, with the rows that determine it and how their multipliers depend on the direction (du, dx). */
typedef struct {
    double *at;   /* u, x */
    double *rate; /* of du and of dx, (2, width) */
    int *basis;
} mrts_corner;

/* Reals of a corner, and corner n in the memory of all. */
#define MRTS_CORNER_WORK(k) (2 + 2 * MRTS_FOURS(k))
static inline mrts_corner mrts_corner_at(int n, int k, double *places, int *bases) {
    const mrts_corner corner = {places + n * MRTS_CORNER_WORK(k), places + n * MRTS_CORNER_WORK(k) + 2, bases + n * k};
    return corner;
}

/* What rounding of a corner is measured by. */
static inline double mrts_corner_size(const double *p) { return 1 + MRTS_ABS(p[0]) + MRTS_ABS(p[1]); }

/* Whether two corners differ by no more than rounding. */
static inline int mrts_same_corner(const double *p, const double *q) {
    return MRTS_ABS(p[0] - q[0]) + MRTS_ABS(p[1] - q[1]) <= MRTS_OUTSIDE * mrts_corner_size(p);
}

/* Whether the basis of a corner gives a point that keeps all limits. If so the corner becomes that; no program is solved. */
MRTS_LOCAL int mrts_is_corner(mrts_polytope *polytope, mrts_corner corner);

/* The corner that lies furthest in a direction, by a linear program from the basis that it holds (basis[0] == 0: cold);
 * a status of mrts_lp. Reals of work, and ints, those of mrts_lp. */
#define MRTS_FURTHEST_WORK(k, rows) (MRTS_LP_WORK(k) + 3 * (k) + (rows) * (k))
MRTS_LOCAL int mrts_furthest(mrts_polytope *polytope, const double *direction, mrts_corner corner, double *work,
                             int *iwork);

/* Whether the multipliers of a corner show that nothing lies further out in a direction: they have the signs of limits that
 * there are (a free unknown of a basis has none), and make it up of the rows as given. */
MRTS_LOCAL int mrts_is_furthest(mrts_polytope *polytope, mrts_corner corner, const double *direction);

/* A direction in which a corner lies furthest, in the middle of all of them; returns whether there is one. */
MRTS_LOCAL int mrts_outward(mrts_polytope *polytope, mrts_corner corner, double *direction);

#endif

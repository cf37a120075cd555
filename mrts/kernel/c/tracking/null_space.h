/* SPDX-License-Identifier: MIT
 *
 * What a grasp takes of an arm's joints and what it leaves free, and the positions that redundant arms prefer of all that
 * hold their grasps; mrts/following/tracking.py has the mathematics.
 */
#ifndef MRTS_NULL_SPACE_H
#define MRTS_NULL_SPACE_H

#include "../cell_sizes.h"
#include "../numbers.h"

/* Where an arm's joints begin: a constant of the compiler where each has as many as its wrench components, which is
 * faster. */
#ifdef MRTS_UNEVEN
static const int mrts_first_joints[MRTS_ROBOTS + 1] = MRTS_FIRST_JOINTS;
#define MRTS_FIRST(robot) mrts_first_joints[robot]
#else
#define MRTS_FIRST(robot) ((robot) * MRTS_SIZE)
#endif

/* What the arms of a cell prefer; one value a joint of all arms [rad or m]. */
typedef struct {
    const double *lower; /* position limits, infinite where there are none */
    const double *upper;
    const double *zone; /* widths beside them */
    double push;        /* what h adds at a limit */
} mrts_preference;

/* The transpose of an arm's Jacobian as Q R: the first MRTS_SIZE columns of Q span what the grasp takes of the joints, the
 * others what it leaves free. */
typedef struct {
    double Q[MRTS_MOST_JOINTS * MRTS_MOST_JOINTS]; /* orthogonal, (joints, joints) */
    double inverse[MRTS_SIZE * MRTS_SIZE];         /* of R, upper triangle */
    double condition;                              /* a bound of the Jacobian's condition number, infinite if singular */
} mrts_split;

/* Splits the joints of an arm with at least MRTS_SIZE of them by its Jacobian, by columns. */
MRTS_LOCAL void mrts_split_joints(int joints, const double *J, mrts_split *split);

/* The least x with J x = y, and F of least squares of J'F = x. */
MRTS_LOCAL void mrts_least_joints(int joints, const mrts_split *split, const double *y, double *x);

/* Condition number of a Jacobian, by columns, in the 2-norm: by rotations of its rows (one-sided Jacobi). */
MRTS_LOCAL double mrts_condition(int joints, const double *J);

/* Solves a square system in place by elimination with row exchanges; 0 if it is singular. */
MRTS_LOCAL int mrts_eliminate(int size, double *matrix, double *rhs);

#ifdef MRTS_REDUNDANT

/* One redundant arm at given joint positions. */
typedef struct {
    mrts_split split;
    double gradient[MRTS_MOST_JOINTS];                   /* h(q) - h(reference) */
    double hessian[MRTS_MOST_JOINTS * MRTS_MOST_JOINTS]; /* h' minus the geometric stiffness, by rows; h' at a fold */
    double bend[MRTS_MOST_JOINTS];                       /* h'' */
    int folds;                                           /* H has no minimum here */
} mrts_null_space;

/* The null spaces of the redundant arms at q, and their multipliers F of least squares. `fold` is the curvature of H at
 * which its minimum ends. */
MRTS_LOCAL void mrts_null_spaces(const mrts_preference *wish, double fold, const double *geometry, const double *q,
                                 const double *reference, const double *J_all, mrts_null_space *spaces, double *F);

/* Adds to x, what the grasp wants of the joints, what makes hessian x = change + J'(anything); returns its length. */
MRTS_LOCAL double mrts_add_preferred(int joints, const mrts_null_space *space, const double *change, double *x);

/* hessian q'' - J'F'' of the redundant arms, Shape (M,), from the second derivative of h(q) - h(reference) = J'F. */
MRTS_LOCAL void mrts_change_along(const double *geometry, const double *q, const double *dq, const mrts_null_space *spaces,
                                  const double *F, double *change);

#endif

#endif

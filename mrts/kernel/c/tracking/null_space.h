/* SPDX-License-Identifier: MIT
 *
 * The joint positions that redundant arms prefer of all that hold their grasps; mrts/inverse_kinematics/null_space.py has
 * the mathematics.
 */
#ifndef MRTS_NULL_SPACE_H
#define MRTS_NULL_SPACE_H

#include "../cell_sizes.h"
#include "../numbers.h"

/* Where an arm's joints begin: a constant of the compiler where no arm is redundant, which is faster. */
#ifdef MRTS_REDUNDANT
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

#ifdef MRTS_REDUNDANT

/* One redundant arm at given joint positions. */
typedef struct {
    double gradient[MRTS_MOST_JOINTS];                   /* h(q) - h(reference) */
    double hessian[MRTS_MOST_JOINTS * MRTS_MOST_JOINTS]; /* h' minus the geometric stiffness, by rows */
    double bend[MRTS_MOST_JOINTS];                       /* h'' */
} mrts_null_space;

/* The null spaces of the redundant arms at q, and their multipliers F of least squares; 0 if an arm is singular. */
MRTS_LOCAL int mrts_null_spaces(const mrts_preference *wish, const double *geometry, const double *q,
                                const double *reference,
                                const double *J_all, mrts_null_space *spaces, double *F);

/* x with J x + damping F = along and hessian x - J'F = change, J by columns; returns the determinant. */
MRTS_LOCAL double mrts_preferred(int joints, const double *J, const mrts_null_space *space, double damping,
                                 const double *along, const double *change, double *x, double *F);

/* J J' of an arm, J by columns. */
MRTS_LOCAL void mrts_square(int joints, const double *J, double *square);

/* hessian q'' - J'F'' of the redundant arms from the rates F' of their multipliers, Shape (M,). */
MRTS_LOCAL void mrts_change_along(const double *geometry, const double *q, const double *dq,
                                 const mrts_null_space *spaces, const double *F,
                                 const double *dF, double *change);

/* A product of the curvatures of H on the set that holds the grasp, from both determinants. */
MRTS_LOCAL double mrts_curvature(int joints, const double *J, double determinant);

#endif

#endif

/* SPDX-License-Identifier: MIT
 *
 * Inverse kinematics at one sample; tracking.c has the method.
 */
#ifndef MRTS_TRACKING_H
#define MRTS_TRACKING_H

#include "null_space.h"

/* What the arms of a cell are to hold, and how, at every sample. */
typedef struct {
    int steps;            /* most Newton steps at a sample */
    double settled;       /* joint step at which the iteration ends [rad or m] */
    double longest;       /* largest joint step [rad or m] */
    double reached;       /* remaining error at which a grasp counts as held [m, rad] */
    int components[6];    /* rows of a six-component twist that this cell uses */
    mrts_preference wish; /* of redundant arms */
    const double *geometry;
} mrts_tracking;

/* a x b. */
MRTS_LOCAL void mrts_cross(const double *a, const double *b, double *out);

/* Inverse of a matrix by Gauss-Jordan elimination with row exchanges; 0 if it is singular. */
MRTS_LOCAL int mrts_invert(const double *matrix, double *inverse);

/* Velocity and acceleration of a grasp in base axes and cell components. */
MRTS_LOCAL void mrts_tip_rates(const mrts_tracking *task, const mrts_arm *arm, const double *rotation,
                               const double *twist, const double *acceleration, double *velocity, double *change);

/* Error of one arm's tip against its grasp on the object, in the world, and its sizes. */
MRTS_LOCAL void mrts_tip_error(const mrts_arm *arm, const double *position, const double *rotation, const double *tip,
                               const double *tip_rotation, double *off, double *turned, double *gap, double *turn);

/* Error of an arm's tip in base axes and cell components; returns the damping that it wants. */
MRTS_LOCAL double mrts_arm_error(const mrts_tracking *task, const mrts_arm *arm, const double *off,
                                 const double *turned, double *error);

/* Joint positions with the smallest errors met from `now` on, which is moved; of those that hold a grasp with a redundant
 * arm, those with the smallest step still to go. 0 if an arm is singular. */
MRTS_LOCAL int mrts_hold_grasps(const mrts_tracking *task, const double *position, const double *rotation,
                                const double *reference, double *now, double *best, double *gap, double *turn,
                                double *drift, const double **arg, double **res, long long *iw, double *w);

/* q' = J^-1 v and q'' = J^-1 (a - J' q') of all arms, of redundant ones as null_space.h prefers. 0 if one is singular. */
MRTS_LOCAL int mrts_joint_rates(const mrts_tracking *task, const double *rotation, const double *twist,
                                const double *acceleration, const double *reference, const double *q, double *dq,
                                double *ddq, double *condition, double *curvature, const double **arg, double **res,
                                long long *iw, double *w);

#endif

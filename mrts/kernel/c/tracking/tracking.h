/* SPDX-License-Identifier: MIT
 *
 * Inverse kinematics along a path: tracking.c has the rule of one sample, quick_sample.c the same where it is easy, path.c
 * both in turn.
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
    double condition;     /* of a Jacobian, at which an arm may be singular */
    int components[6];    /* rows of a six-component twist that this cell uses */
    mrts_preference wish; /* of redundant arms */
    const double *geometry;
} mrts_tracking;

/* The object at one sample; the rotation by rows. */
typedef struct {
    const double *position, *rotation, *twist, *acceleration;
} mrts_path;

/* How the arms hold their grasps at a sample. */
typedef struct {
    double gap[MRTS_ROBOTS], turn[MRTS_ROBOTS]; /* remaining errors, or larger [m, rad] */
    double jump[MRTS_ROBOTS];                   /* largest difference of a joint from Taylor's prediction [rad or m] */
    double condition[MRTS_ROBOTS];              /* bound of the Jacobian's condition number */
    double drift[MRTS_ROBOTS];                  /* step still to go of a redundant arm [rad or m] */
    double curvature[MRTS_ROBOTS];              /* at the positions that it prefers */
} mrts_held;

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
                                double *drift);

/* q' = J^-1 v and q'' = J^-1 (a - J' q') of all arms, of redundant ones as null_space.h prefers. 0 if one is singular. */
MRTS_LOCAL int mrts_joint_rates(const mrts_tracking *task, const double *rotation, const double *twist,
                                const double *acceleration, const double *reference, const double *q, double *dq,
                                double *ddq, double *condition, double *curvature);

#ifndef MRTS_REDUNDANT
/* q, q', q'' at a sample by undamped Newton steps from `now`, which is moved; 0 where they do not lead to the grasps at
 * once. Arms that are left out stay. */
MRTS_LOCAL int mrts_quick_sample(const mrts_tracking *task, const mrts_path *at, const unsigned char *left_out, double *now,
                                 double *dq, double *ddq, mrts_held *held);
#endif

/* Sample n of a path: q, q', q'' of all arms, which lie behind those of the samples before it, or, at the first one,
 * from positions in q that hold the grasps. `even` counts the steps of one length that lead here. Where the grasps cannot
 * be held the errors tell; 0 if an arm is singular. */
MRTS_LOCAL int mrts_track_sample(const mrts_tracking *task, const double *time, const mrts_path *path, long long n,
                                 const double *reference, const unsigned char *left_out, long long *even, double *q,
                                 double *dq, double *ddq, mrts_held *held);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Inverse kinematics along a path: tracking.c has the rule of one sample, quick_sample.c the same where it is easy, path.c
 * both in turn, follow.c whole paths of many variants.
 */
#ifndef MRTS_TRACKING_H
#define MRTS_TRACKING_H

#include "../point_motion.h"
#include "null_space.h"

/* What the arms of a cell are to hold, and how, at every sample. */
typedef struct {
    int steps;            /* most Newton steps at a sample */
    double settled;       /* joint step at which the iteration ends [rad or m] */
    double longest;       /* largest joint step [rad or m] */
    double reached;       /* remaining error at which a grasp counts as held [m, rad] */
    double condition;     /* of a Jacobian, at which an arm is singular */
    double jump;          /* correction of a predicted joint at which an arm has lost its branch [rad or m] */
    double drift;         /* step left to a redundant arm that is not settled [rad or m] */
    double fold;          /* curvature at which its positions end */
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
    double condition[MRTS_ROBOTS];              /* of the Jacobian; a bound where that is below the limit */
    double drift[MRTS_ROBOTS];                  /* step still to go of a redundant arm [rad or m] */
    int folds[MRTS_ROBOTS];                     /* whether the positions that it prefers end here */
} mrts_held;

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
 * arm, those with the smallest step still to go. Without a reference redundant arms move no further than needed. Arms that
 * are left out stay. */
MRTS_LOCAL void mrts_hold_grasps(const mrts_tracking *task, const double *position, const double *rotation,
                                 const double *reference, const unsigned char *left_out, double *now, double *best,
                                 double *gap, double *turn, double *drift);

/* q' = J^-1 v and q'' = J^-1 (a - J' q') of all arms, of redundant ones as null_space.h prefers. */
MRTS_LOCAL void mrts_joint_rates(const mrts_tracking *task, const mrts_path *at, const double *reference,
                                 const unsigned char *left_out, const double *q, double *dq, double *ddq,
                                 mrts_held *held);

#ifndef MRTS_UNEVEN
/* q, q', q'' at a sample by undamped Newton steps from `now`, which is moved; 0 where they do not lead to the grasps at
 * once. Arms that are left out stay. */
MRTS_LOCAL int mrts_quick_sample(const mrts_tracking *task, const mrts_path *at, const unsigned char *left_out, double *now,
                                 double *dq, double *ddq, mrts_held *held);
#endif

/* Sample n of a path: q, q', q'' of all arms, which lie behind those of the samples before it, or, at the first one,
 * from positions in q that hold the grasps. `even` counts the steps of one length that lead here. What is held tells of
 * arms that cannot follow. Those that are left out stay. */
MRTS_LOCAL void mrts_track_sample(const mrts_tracking *task, const double *time, const mrts_path *path, long long n,
                                  const double *reference, const unsigned char *left_out, long long *even, double *q,
                                  double *dq, double *ddq, mrts_held *held);

#endif

/* SPDX-License-Identifier: MIT
 *
 * A retimed motion between the samples of its path.
 */
#ifndef MRTS_PLACES_H
#define MRTS_PLACES_H

#include "../cell_sizes.h"

/* A path of joints, Shape (samples, MRTS_JOINTS) each, with its places. */
typedef struct {
    const double *time; /* the path parameter */
    const double *q, *dq, *ddq;
    const double *weight; /* of velocities and accelerations at both ends of a segment in the way, the velocity and its change
                           * at each place, see denser_motion.py, (places, 3, 4); the same for all segments */
    const double *at;     /* where each place is in its segment, in (0, 1) */
    const double *whole;  /* weights of the way over a whole segment, (4) */
    int places;
} mrts_joint_path;

/* Places of all segments in a row, and what is known and found there. */
typedef struct {
    const mrts_joint_path *path;
    const double *x, *u;    /* squared speed at the samples; half its slope at the start and at the end of each segment */
    const double *geometry;
    const int *components;  /* those of a twist that a wrench of the cell has */
    /* Time from the first place of all on; rotations by columns, as generated functions want them. */
    double *time, *q, *dq, *ddq, *position, *rotation, *twist, *acceleration;
} mrts_places;

#endif

/* SPDX-License-Identifier: MIT
 *
 * How points of arms and of the object move at one sample: velocity p' and acceleration p''. An exported library finds
 * them with this source; what is read without a compiler, mrts/limits/motion_limits.py, in numpy. */
#ifndef MRTS_POINT_MOTION_H
#define MRTS_POINT_MOTION_H

#include "numbers.h"

/* An arm with every joint at zero, from the base to the last joint that counts. */
typedef struct {
    int joints;
    const mrts_real *axes;   /* of length 1, base axes, (joints, 3) */
    const mrts_real *points; /* one on each axis, base axes, (joints, 3) [m] */
    const int *slides;       /* whether the joint is prismatic, (joints) */
} mrts_chain;

static inline void mrts_cross(const mrts_real *a, const mrts_real *b, mrts_real *out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Turns a vector about an axis of length 1. */
static inline void mrts_turn(const mrts_real *axis, mrts_real sine, mrts_real cosine, mrts_real *vector) {
    mrts_real across[3], inward[3];
    mrts_cross(axis, vector, across);
    mrts_cross(axis, across, inward);
    for (int i = 0; i < 3; ++i) vector[i] += sine * across[i] + (1 - cosine) * inward[i];
}

/* Velocity p' and acceleration p'' of a point that a chain moves, base axes; `place` is the point with every joint at zero
 * and becomes where it is. */
static inline void mrts_arm_point(const mrts_chain *chain, const mrts_real *q, const mrts_real *dq, const mrts_real *ddq,
                                  mrts_real *place, mrts_real *velocity, mrts_real *acceleration) {
    for (int i = 0; i < 3; ++i) velocity[i] = acceleration[i] = 0;
    for (int joint = chain->joints - 1; joint >= 0; --joint) {
        const mrts_real *axis = chain->axes + 3 * joint, *on_axis = chain->points + 3 * joint;
        const mrts_real speed = dq[joint], change = ddq[joint];
        if (chain->slides[joint]) {
            for (int i = 0; i < 3; ++i) {
                place[i] += axis[i] * q[joint];
                velocity[i] += axis[i] * speed;
                acceleration[i] += axis[i] * change;
            }
            continue;
        }
        const mrts_real sine = MRTS_MATH(sin, q[joint]), cosine = MRTS_MATH(cos, q[joint]);
        mrts_real around[3], inward[3], coriolis[3];
        for (int i = 0; i < 3; ++i) place[i] -= on_axis[i];
        mrts_turn(axis, sine, cosine, place);
        mrts_turn(axis, sine, cosine, velocity);
        mrts_turn(axis, sine, cosine, acceleration);
        mrts_cross(axis, place, around);
        mrts_cross(axis, around, inward);
        mrts_cross(axis, velocity, coriolis);
        for (int i = 0; i < 3; ++i) {
            acceleration[i] += around[i] * change + (inward[i] * speed + 2 * coriolis[i]) * speed;
            velocity[i] += around[i] * speed;
            place[i] += on_axis[i];
        }
    }
}

/* Likewise of a point of the object, given in its frame; world axes. The rotation is row after row. */
static inline void mrts_object_point(const mrts_real *rotation, const mrts_real *twist, const mrts_real *given,
                                     const mrts_real *point, mrts_real *velocity, mrts_real *acceleration) {
    mrts_real arm[3], around[3], change[3], inward[3];
    for (int i = 0; i < 3; ++i) arm[i] = mrts_dot(3, rotation + 3 * i, point);
    mrts_cross(twist + 3, arm, around);
    mrts_cross(given + 3, arm, change);
    mrts_cross(twist + 3, around, inward);
    for (int i = 0; i < 3; ++i) {
        velocity[i] = twist[i] + around[i];
        acceleration[i] = given[i] + change[i] + inward[i];
    }
}

#endif

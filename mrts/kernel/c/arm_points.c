/* SPDX-License-Identifier: MIT
 *
 * How a point of an arm moves at all samples, in one call from Python.
 */
#include "point_motion.h"

/* `joints` of the arm move the point; q, dq, ddq have as many, sample after sample. */
MRTS_EXPORT void mrts_arm_points(long long samples, int joints, const double *axes, const double *points, const int *slides,
                                 const double *at_zero, const double *q, const double *dq, const double *ddq,
                                 double *velocity, double *acceleration) {
    const mrts_chain chain = {joints, axes, points, slides};
    for (long long sample = 0; sample < samples; ++sample) {
        const long long joint = joints * sample;
        double place[3] = {at_zero[0], at_zero[1], at_zero[2]};
        mrts_arm_point(&chain, q + joint, dq + joint, ddq + joint, place, velocity + 3 * sample, acceleration + 3 * sample);
    }
}

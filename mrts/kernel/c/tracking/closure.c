/* SPDX-License-Identifier: MIT
 *
 * How far given joints are from holding an object that moves as given, over all samples of a motion.
 */
#include "../trajectory.h"
#include "tracking.h"

/* What is told of an arm, the largest of all samples: the distance of its tip from its grasp, squared [m^2], the squares of
 * the differences of their rotation matrices, summed, and the largest component of velocities and of accelerations, of what
 * holds the grasp or of the tip, and of their differences, in base axes. */
enum { MRTS_APART, MRTS_TURNED, MRTS_VELOCITY, MRTS_SLIP, MRTS_CHANGE, MRTS_CHANGE_SLIP, MRTS_CLOSURE_SIZES };

/* The larger of what is known and a number; infinity where that is none. */
static void mrts_known_most(double value, double *most) {
    if (!(value <= *most)) *most = value < MRTS_INFINITY ? value : INFINITY;
}

/* The rates of one arm's tip against those of its grasp. */
static void mrts_slips(const double *expected, const double *tip, double *most) {
    for (int j = 0; j < MRTS_SIZE; ++j) {
        mrts_known_most(MRTS_ABS(expected[j]), most);
        mrts_known_most(MRTS_ABS(tip[j]), most);
        mrts_known_most(MRTS_ABS(tip[j] - expected[j]), most + 1);
    }
}

/* The pose of one arm's tip against its grasp; rotations by columns. */
static void mrts_off_grasp(const mrts_arm *arm, const double *position, const double *R, const double *tip, const double *turn,
                           double *most) {
    double apart = 0, turned = 0;
    for (int i = 0; i < 3; ++i) {
        const double r = R[i] * arm->tip_position[0] + R[3 + i] * arm->tip_position[1] + R[6 + i] * arm->tip_position[2];
        const double gap = tip[i] - position[i] - r;
        apart += gap * gap;
        for (int j = 0; j < 3; ++j) {
            const double off = R[i] * arm->tip_rotation[j] + R[3 + i] * arm->tip_rotation[3 + j] +
                               R[6 + i] * arm->tip_rotation[6 + j] - turn[3 * j + i];
            turned += off * off;
        }
    }
    mrts_known_most(apart, most + MRTS_APART);
    mrts_known_most(turned, most + MRTS_TURNED);
}

/* The largest of samples 0 .. count - 1, (MRTS_ROBOTS, MRTS_CLOSURE_SIZES), infinity where one is no number; `in` are the
 * inputs of the wrench form, `components` those of a twist that a wrench of the cell has. */
MRTS_EXPORT void mrts_closure(long long count, const double *const *in, const long long *stride, const double *position,
                              const double *geometry, const int *components, double *most) {
    static const int joints[] = MRTS_FIRST_JOINTS;
    double tips[3 * MRTS_ROBOTS], turns[9 * MRTS_ROBOTS], J[MRTS_SIZE * MRTS_JOINTS], bias[MRTS_SIZE * MRTS_ROBOTS];
    double *const poses[] = {tips, turns, J}, *const biases[] = {bias};
    mrts_tracking task = {0};
    for (int i = 0; i < MRTS_SIZE; ++i) task.components[i] = components[i];
    for (int i = 0; i < MRTS_ROBOTS * MRTS_CLOSURE_SIZES; ++i) most[i] = 0;
    for (long long n = 0; n < count; ++n) {
        const double *arg[MRTS_INPUTS];
        double rows[9];
        for (int i = 0; i < MRTS_INPUTS; ++i) arg[i] = in[i] + n * stride[i];
        const double *q = arg[0], *dq = arg[MRTS_DQ], *ddq = arg[MRTS_DDQ], *R = arg[MRTS_ROTATION];
        const double *const at[] = {q, arg[MRTS_INPUTS - 1]}, *const moving[] = {q, dq, arg[MRTS_INPUTS - 1]};
        MRTS_KINEMATICS(at, poses);
        MRTS_BIAS_ACCELERATION(moving, biases);
        for (int i = 0; i < 9; ++i) rows[i] = R[i % 3 * 3 + i / 3];
        for (int robot = 0; robot < MRTS_ROBOTS; ++robot) {
            const mrts_arm *arm = MRTS_ARM(geometry, robot);
            double velocity[MRTS_SIZE], change[MRTS_SIZE], rate[MRTS_SIZE];
            double *known = most + robot * MRTS_CLOSURE_SIZES, *own = bias + robot * MRTS_SIZE;
            mrts_tip_by_joints(joints[robot], joints[robot + 1], J, dq, ddq, rate, own);
            mrts_tip_rates(&task, arm, rows, arg[MRTS_TWIST], arg[MRTS_ACCELERATION], velocity, change);
            mrts_off_grasp(arm, position + 3 * n, R, tips + 3 * robot, turns + 9 * robot, known);
            mrts_slips(velocity, rate, known + MRTS_VELOCITY);
            mrts_slips(change, own, known + MRTS_CHANGE);
        }
    }
}

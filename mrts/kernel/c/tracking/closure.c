/* SPDX-License-Identifier: MIT
 *
 * How far given joints are from holding an object that moves as given, over all samples of a motion.
 */
#include "../lanes/lanes.h"

/* What is told of an arm, the largest of all samples: the distance of its tip from its grasp, squared [m^2], the squares of
 * the differences of their rotation matrices, summed, and the largest component of velocities and of accelerations, of what
 * holds the grasp or of the tip, and of their differences, in base axes. */
enum { MRTS_APART, MRTS_TURNED, MRTS_VELOCITY, MRTS_SLIP, MRTS_CHANGE, MRTS_CHANGE_SLIP, MRTS_CLOSURE_SIZES };

/* The larger of what is known and a number of the samples; a number that is none is told. */
static void mrts_known_most(mrts_lanes value, mrts_lanes *most, mrts_lane_mask *finite) {
    *finite &= mrts_above(mrts_each(MRTS_INFINITY), value);
    *most = mrts_larger_lanes(*most, value);
}

/* The rates of one arm's tip against those of its grasp, both with their largest component and that of the difference. */
static void mrts_slips(const mrts_arm *arm, const int *components, const mrts_lanes *wanted,
                                     const mrts_lanes *tip, mrts_lanes *most, mrts_lane_mask *finite) {
    for (int j = 0; j < MRTS_SIZE; ++j) {
        const mrts_lanes *rate = wanted + components[j] / 3 * 3;
        const double *axis = arm->base_rotation + components[j] % 3;
        const mrts_lanes expected = axis[0] * rate[0] + axis[3] * rate[1] + axis[6] * rate[2];
        mrts_known_most(mrts_sizes(expected), most, finite);
        mrts_known_most(mrts_sizes(tip[j]), most, finite);
        mrts_known_most(mrts_sizes(tip[j] - expected), most + 1, finite);
    }
}

/* One arm's tip against its grasp; `given` are the inputs of the wrench form, `tip` and `turn` its pose, by columns, `rate`
 * and `change` its rates. */
static void mrts_off_grasp(const mrts_arm *arm, const int *components, const mrts_lanes *const *given,
                                         const mrts_lanes *position, const mrts_lanes *tip, const mrts_lanes *turn,
                                         const mrts_lanes *rate, const mrts_lanes *change, mrts_lanes *most,
                                         mrts_lane_mask *finite) {
    const mrts_lanes *R = given[MRTS_ROTATION], *w = given[MRTS_TWIST] + 3, *dw = given[MRTS_ACCELERATION] + 3;
    mrts_lanes r[3], velocity[6], acceleration[6], apart = mrts_each(0), turned = apart;
    mrts_lanes swing[3] = {mrts_each(0), mrts_each(0), mrts_each(0)};
    for (int i = 0; i < 3; ++i) {
        r[i] = R[i] * arm->tip_position[0] + R[3 + i] * arm->tip_position[1] + R[6 + i] * arm->tip_position[2];
        const mrts_lanes gap = tip[i] - position[i] - r[i];
        apart += gap * gap;
        for (int j = 0; j < 3; ++j) {
            const mrts_lanes held =
                R[i] * arm->tip_rotation[j] + R[3 + i] * arm->tip_rotation[3 + j] + R[6 + i] * arm->tip_rotation[6 + j];
            const mrts_lanes off = held - turn[3 * j + i];
            turned += off * off;
        }
    }
    mrts_known_most(apart, most + MRTS_APART, finite);
    mrts_known_most(turned, most + MRTS_TURNED, finite);
    mrts_less_cross(r, w, swing); /* w x r */
    for (int i = 0; i < 3; ++i) {
        velocity[i] = given[MRTS_TWIST][i] + swing[i];
        velocity[3 + i] = w[i];
        acceleration[i] = given[MRTS_ACCELERATION][i];
        acceleration[3 + i] = dw[i];
    }
    mrts_less_cross(r, dw, acceleration);
    mrts_less_cross(swing, w, acceleration);
    mrts_slips(arm, components, velocity, rate, most + MRTS_VELOCITY, finite);
    mrts_slips(arm, components, acceleration, change, most + MRTS_CHANGE, finite);
}

/* Makes what is known of the closure of each arm, (MRTS_ROBOTS, MRTS_CLOSURE_SIZES), the larger of that and of some samples,
 * and takes from `finite` those of which one is no number; `given` are the inputs of the wrench form. */
static void mrts_closures(const double *geometry, const int *components, const mrts_lanes *const *given,
                                        const mrts_lanes *position, mrts_lanes *most, mrts_lane_mask *finite) {
    static const int joints[] = MRTS_FIRST_JOINTS;
    const mrts_lanes *q = given[0], *dq = given[MRTS_DQ], *ddq = given[MRTS_DDQ], *placed = given[MRTS_INPUTS - 1];
    mrts_lanes tips[3 * MRTS_ROBOTS], turns[9 * MRTS_ROBOTS], J[MRTS_SIZE * MRTS_JOINTS], change[MRTS_SIZE * MRTS_ROBOTS];
    mrts_lanes sines[2 * MRTS_JOINTS];
    const mrts_lanes *const at[] = {q, placed}, *const moving[] = {q, dq, placed};
    mrts_lanes *const poses[] = {tips, turns, J}, *const bias[] = {change};
    mrts_sines(MRTS_JOINTS, q, sines);
    MRTS_KINEMATICS_LANES(at, sines, poses);
    MRTS_BIAS_ACCELERATION_LANES(moving, sines, bias);
    for (int robot = 0; robot < MRTS_ROBOTS; ++robot) {
        mrts_lanes rate[MRTS_SIZE], *own = change + robot * MRTS_SIZE;
        mrts_tip_by_joints(joints[robot], joints[robot + 1], J, dq, ddq, rate, own);
        mrts_off_grasp(MRTS_ARM(geometry, robot), components, given, position, tips + 3 * robot, turns + 9 * robot,
                                rate, own, most + robot * MRTS_CLOSURE_SIZES, finite);
    }
}

/* The largest of samples 0 .. count - 1, (MRTS_ROBOTS, MRTS_CLOSURE_SIZES), infinity where one is no number; `in` are the
 * inputs of the wrench form, `components` those of a twist that a wrench of the cell has. */
MRTS_EXPORT void mrts_closure(long long count, const double *const *in, const long long *stride, const double *position,
                              const double *geometry, const int *components, double *most) {
    enum { NUMBERS = MRTS_ROBOTS * MRTS_CLOSURE_SIZES };
    mrts_lane_inputs inputs;
    mrts_lanes object[3], found[NUMBERS];
    mrts_lane_mask finite = MRTS_EVERY_LANE;
    for (int i = 0; i < NUMBERS; ++i) found[i] = (mrts_lanes){0};
    for (long long n = 0; n < count; n += MRTS_LANES) {
        mrts_take_inputs(in, stride, n, count, n == 0, &inputs);
        for (int lane = 0; lane < MRTS_LANES; ++lane) {
            for (int i = 0; i < 3; ++i) object[i][lane] = position[3 * inputs.at[lane] + i];
        }
        mrts_closures(geometry, components, inputs.arg, object, found, &finite);
    }
    for (int i = 0; i < NUMBERS; ++i) {
        most[i] = 0;
        for (int lane = 0; lane < MRTS_LANES; ++lane) {
            if (!finite[lane]) most[i] = INFINITY;
            if (found[i][lane] > most[i]) most[i] = found[i][lane];
        }
    }
}

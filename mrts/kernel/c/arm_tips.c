/* SPDX-License-Identifier: MIT
 *
 * Where joints have the tips of their arms, several samples at a time: between the samples of a path, and beside grasps. */
#include "lanes/lanes.h"

/* v -= w x r */
static void mrts_less_cross(const mrts_lanes *w, const mrts_lanes *r, mrts_lanes *v) {
    v[0] -= w[1] * r[2] - w[2] * r[1];
    v[1] -= w[2] * r[0] - w[0] * r[2];
    v[2] -= w[0] * r[1] - w[1] * r[0];
}

/* The rates of a tip from those of its arm's joints, first .. end - 1 of all; `change` is the bias acceleration before. */
static void mrts_tip_by_joints(int first, int end, const mrts_lanes *J, const mrts_lanes *dq, const mrts_lanes *ddq,
                               mrts_lanes *rate, mrts_lanes *change) {
    for (int i = 0; i < MRTS_SIZE; ++i) rate[i] = mrts_each(0);
    for (int j = first; j < end; ++j) {
        for (int i = 0; i < MRTS_SIZE; ++i) {
            rate[i] += J[j * MRTS_SIZE + i] * dq[j];
            change[i] += J[j * MRTS_SIZE + i] * ddq[j];
        }
    }
}

/*
 * A retimed motion between the samples of its path, several places at a time: joints on polynomials through the samples, the
 * object where the first arm carries it, both at their speeds. */

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

/* Joints at some places, by the parameter of the path; `inside` are their places in their segments, h long. */
static void mrts_joints_at(const mrts_joint_path *path, const long long *segments, const long long *inside, mrts_lanes h,
                           mrts_lanes at, mrts_lanes *q, mrts_lanes *dq, mrts_lanes *ddq) {
    enum { M = MRTS_JOINTS };
    mrts_lanes weight[12];
    for (int i = 0; i < 12; ++i) weight[i] = mrts_term(path->weight, inside, 12, i);
    for (int i = 0; i < M; ++i) { /* those of the next sample stand M further */
        const mrts_lanes before = mrts_term(path->q, segments, M, i), after = mrts_term(path->q, segments, M, M + i);
        const mrts_lanes given[] = {mrts_term(path->dq, segments, M, i), mrts_term(path->ddq, segments, M, i) * h,
                                    mrts_term(path->dq, segments, M, M + i), mrts_term(path->ddq, segments, M, M + i) * h};
        mrts_lanes way = mrts_each(0), whole = way, rate = way, change = way;
        MRTS_UNROLL
        for (int j = 0; j < 4; ++j) {
            way += weight[j] * given[j];
            rate += weight[4 + j] * given[j];
            change += weight[8 + j] * given[j];
            whole += path->whole[j] * given[j];
        }
        q[i] = before + h * way + at * (after - before - h * whole);
        dq[i] = rate;
        ddq[i] = change / h;
    }
}

/* The rate of a tip in base axes and cell components, linear and angular in the world. */
static void mrts_rate_in_world(const mrts_arm *arm, const int *components, const mrts_lanes *rate, mrts_lanes *world) {
    const double *R = arm->base_rotation;
    mrts_lanes in_base[6];
    for (int i = 0; i < 6; ++i) in_base[i] = mrts_each(0);
    for (int j = 0; j < MRTS_SIZE; ++j) in_base[components[j]] = rate[j];
    for (int i = 0; i < 6; ++i) {
        const mrts_lanes *half = in_base + i / 3 * 3;
        world[i] = R[3 * (i % 3)] * half[0] + R[3 * (i % 3) + 1] * half[1] + R[3 * (i % 3) + 2] * half[2];
    }
}

/* The object that the first arm carries: its pose, the rotation by columns, and its rates in the world. */
static void mrts_carried(const mrts_arm *arm, const int *components, const mrts_lanes *geometry, const mrts_lanes *q,
                         const mrts_lanes *dq, const mrts_lanes *ddq, mrts_lanes *position, mrts_lanes *rotation,
                         mrts_lanes *twist, mrts_lanes *acceleration) {
    mrts_lanes tips[3 * MRTS_ROBOTS], turns[9 * MRTS_ROBOTS], J[MRTS_SIZE * MRTS_JOINTS], change[MRTS_SIZE * MRTS_ROBOTS];
    mrts_lanes sines[2 * MRTS_JOINTS], velocity[MRTS_SIZE], r[3], turning[3] = {mrts_each(0), mrts_each(0), mrts_each(0)};
    const mrts_lanes *const at[] = {q, geometry}, *const moving[] = {q, dq, geometry};
    mrts_lanes *const poses[] = {tips, turns, J}, *const bias[] = {change};
    mrts_sines(MRTS_FIRST(1), q, sines);
    for (int i = 2 * MRTS_FIRST(1); i < 2 * MRTS_JOINTS; ++i) sines[i] = mrts_each(0); /* of other arms nothing is wanted */
    MRTS_KINEMATICS_LANES(at, sines, poses);
    MRTS_BIAS_ACCELERATION_LANES(moving, sines, bias);
    mrts_tip_by_joints(0, MRTS_FIRST(1), J, dq, ddq, velocity, change);
    for (int i = 0; i < 3; ++i) { /* of the tip by columns, turned back by that of the grasp in the object */
        for (int j = 0; j < 3; ++j) {
            rotation[3 * j + i] = turns[i] * arm->tip_rotation[3 * j] + turns[3 + i] * arm->tip_rotation[3 * j + 1] +
                                  turns[6 + i] * arm->tip_rotation[3 * j + 2];
        }
    }
    for (int i = 0; i < 3; ++i) {
        r[i] = rotation[i] * arm->tip_position[0] + rotation[3 + i] * arm->tip_position[1] +
               rotation[6 + i] * arm->tip_position[2];
        position[i] = tips[i] - r[i];
    }
    mrts_rate_in_world(arm, components, velocity, twist);
    mrts_rate_in_world(arm, components, change, acceleration);
    mrts_less_cross(twist + 3, r, twist);
    mrts_less_cross(acceleration + 3, r, acceleration);
    mrts_less_cross(r, twist + 3, turning); /* w x r */
    mrts_less_cross(twist + 3, turning, acceleration);
}

static void mrts_put_numbers(int count, const mrts_lanes *numbers, const long long *places, double *all) {
    double *own[] = {all + places[0] * count, all + places[1] * count, all + places[2] * count, all + places[3] * count};
    for (int i = 0; i < count; ++i) {
        const mrts_lanes number = numbers[i];
        own[0][i] = number[0];
        own[1][i] = number[1];
        own[2][i] = number[2];
        own[3][i] = number[3];
    }
}

/* All `count` places of some segments in a row, those looked at, rising: the time from the first place of all on, joints and
 * object, of which the first arm tells, its rotation by columns, as generated functions want it. x is the squared speed at
 * the samples, u half its slope at the start and at the end of each segment, a line between; `components` are those of a
 * twist that a wrench of the cell has. */
MRTS_EXPORT void mrts_path_places(long long count, const mrts_joint_path *path, const double *x, const double *u,
                                  const double *geometry, const long long *segments, const int *components, double *time,
                                  double *q, double *dq, double *ddq, double *position, double *rotation, double *twist,
                                  double *acceleration) {
    enum { M = MRTS_JOINTS };
    const double *first = path->time + segments[0], start = first[0] + (first[1] - first[0]) * path->at[0];
    mrts_lanes placed[MRTS_GEOMETRY_NUMBERS], joints[M], pose[12], rate[M + 6], change[M + 6];
    for (int i = 0; i < MRTS_GEOMETRY_NUMBERS; ++i) placed[i] = mrts_each(geometry[i]);
    for (long long n = 0; n < count; n += MRTS_LANES) { /* beyond the last the last is repeated */
        long long places[MRTS_LANES], inside[MRTS_LANES], of[MRTS_LANES];
        for (int lane = 0; lane < MRTS_LANES; ++lane) {
            places[lane] = n + lane < count ? n + lane : count - 1;
            inside[lane] = places[lane] % path->places;
            of[lane] = segments[places[lane] / path->places];
        }
        const mrts_lanes before = mrts_term(path->time, of, 1, 0), h = mrts_term(path->time, of, 1, 1) - before;
        const mrts_lanes at = mrts_term(path->at, inside, 1, 0), passed = before + h * at - start;
        const mrts_lanes low = mrts_term(u, of, 2, 0), high = mrts_term(u, of, 2, 1);
        const mrts_lanes square = mrts_term(x, of, 1, 0) + 2 * h * at * (low + (high - low) * at / 2);
        const mrts_lanes slope = low + (high - low) * at, speed = mrts_roots(square);
        mrts_joints_at(path, of, inside, h, at, joints, rate, change);
        mrts_carried(MRTS_ARM(geometry, 0), components, placed, joints, rate, change, pose, pose + 3, rate + M, change + M);
        for (int i = 0; i < M + 6; ++i) { /* eq. (10) and its derivative */
            change[i] = change[i] * square + rate[i] * slope;
            rate[i] *= speed;
        }
        mrts_put_numbers(1, &passed, places, time);
        mrts_put_numbers(M, joints, places, q);
        mrts_put_numbers(M, rate, places, dq);
        mrts_put_numbers(M, change, places, ddq);
        mrts_put_numbers(3, pose, places, position);
        mrts_put_numbers(9, pose + 3, places, rotation);
        mrts_put_numbers(6, rate + M, places, twist);
        mrts_put_numbers(6, change + M, places, acceleration);
    }
}

/* How far an arm is from holding an object that moves as given, the largest of all samples: the distance of its tip from its
 * grasp, squared [m^2], the squares of the differences of their rotation matrices, summed, and the largest component of
 * velocities and of accelerations, of what holds the grasp or of the tip, and of their differences, in base axes. */
enum { MRTS_APART, MRTS_TURNED, MRTS_VELOCITY, MRTS_SLIP, MRTS_CHANGE, MRTS_CHANGE_SLIP, MRTS_CLOSURE_SIZES };

/* The larger of what is known and a number of the samples; a number that is none is told. */
static void mrts_known_most(mrts_lanes value, mrts_lanes *most, mrts_lane_mask *finite) {
    *finite &= value < MRTS_INFINITY;
    *most = mrts_larger_lanes(*most, value);
}

/* The rates of one arm's tip against those of its grasp, both with their largest component and that of the difference. */
static void mrts_slips(const mrts_arm *arm, const int *components, const mrts_lanes *wanted, const mrts_lanes *tip,
                       mrts_lanes *most, mrts_lane_mask *finite) {
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
                           const mrts_lanes *rate, const mrts_lanes *change, mrts_lanes *most, mrts_lane_mask *finite) {
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

/* The largest of samples 0 .. count - 1, (MRTS_ROBOTS, MRTS_CLOSURE_SIZES), infinity where one is no number; `in` are the
 * inputs of the wrench form, `components` those of a twist that a wrench of the cell has. */
MRTS_EXPORT void mrts_closure(long long count, const double *const *in, const long long *stride, const double *position,
                              const double *geometry, const int *components, double *most) {
    enum { NUMBERS = MRTS_ROBOTS * MRTS_CLOSURE_SIZES };
    mrts_lanes tips[3 * MRTS_ROBOTS], turns[9 * MRTS_ROBOTS], J[MRTS_SIZE * MRTS_JOINTS], change[MRTS_SIZE * MRTS_ROBOTS];
    mrts_lanes sines[2 * MRTS_JOINTS], rate[MRTS_SIZE], object[3], found[NUMBERS];
    mrts_lanes *const poses[] = {tips, turns, J}, *const bias[] = {change};
    mrts_lane_mask finite = MRTS_EVERY_LANE;
    mrts_lane_inputs inputs;
    for (int i = 0; i < NUMBERS; ++i) found[i] = mrts_each(0);
    for (long long n = 0; n < count; n += MRTS_LANES) {
        mrts_take_inputs(in, stride, n, count, n == 0, &inputs);
        const mrts_lanes *q = inputs.arg[0], *dq = inputs.arg[MRTS_DQ], *placed = inputs.arg[MRTS_INPUTS - 1];
        const mrts_lanes *const at[] = {q, placed}, *const moving[] = {q, dq, placed};
        for (int i = 0; i < 3; ++i) object[i] = mrts_term(position, inputs.at, 3, i);
        mrts_sines(MRTS_JOINTS, q, sines);
        MRTS_KINEMATICS_LANES(at, sines, poses);
        MRTS_BIAS_ACCELERATION_LANES(moving, sines, bias);
        for (int robot = 0; robot < MRTS_ROBOTS; ++robot) {
            mrts_lanes *own = change + robot * MRTS_SIZE;
            mrts_tip_by_joints(MRTS_FIRST(robot), MRTS_FIRST(robot + 1), J, dq, inputs.arg[MRTS_DDQ], rate, own);
            mrts_off_grasp(MRTS_ARM(geometry, robot), components, inputs.arg, object, tips + 3 * robot, turns + 9 * robot,
                           rate, own, found + robot * MRTS_CLOSURE_SIZES, &finite);
        }
    }
    for (int i = 0; i < NUMBERS; ++i) {
        most[i] = 0;
        for (int lane = 0; lane < MRTS_LANES; ++lane) {
            if (!finite[lane]) most[i] = INFINITY;
            if (found[i][lane] > most[i]) most[i] = found[i][lane];
        }
    }
}

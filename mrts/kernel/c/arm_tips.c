/* SPDX-License-Identifier: MIT
 *
 * Where joints have the tips of their arms, several samples at a time: between the samples of a path, and beside grasps.
 */
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
 * object where the first arm carries it, both at their speeds.
 */

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
    const long long *segments; /* those that are looked at, rising */
    const int *components;  /* those of a twist that a wrench of the cell has */
    /* Time from the first place of all on; rotations by columns, as generated functions want them. */
    double *time, *q, *dq, *ddq, *position, *rotation, *twist, *acceleration;
} mrts_places;

/* Joints at some places, by the parameter of the path. */
static void mrts_joints_at(const mrts_joint_path *path, const long long *segments, const long long *places,
                                         mrts_lanes h, mrts_lanes at, mrts_lanes *q, mrts_lanes *dq, mrts_lanes *ddq) {
    mrts_lanes weight[12];
    long long start[MRTS_LANES];
    MRTS_UNROLL
    for (int lane = 0; lane < MRTS_LANES; ++lane) {
        const int place = (int)(places[lane] % path->places);
        start[lane] = segments[lane] * MRTS_JOINTS;
        for (int i = 0; i < 12; ++i) weight[i][lane] = path->weight[12 * place + i];
    }
    for (int i = 0; i < MRTS_JOINTS; ++i) {
        mrts_lanes given[4], before, after, way = mrts_each(0), whole = way, rate = way, change = way;
        MRTS_UNROLL
        for (int lane = 0; lane < MRTS_LANES; ++lane) {
            const long long here = start[lane] + i, next = here + MRTS_JOINTS;
            before[lane] = path->q[here];
            after[lane] = path->q[next];
            given[0][lane] = path->dq[here];
            given[1][lane] = path->ddq[here];
            given[2][lane] = path->dq[next];
            given[3][lane] = path->ddq[next];
        }
        given[1] *= h;
        given[3] *= h;
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

/* The object that the first arm carries: its pose by rows, its rates in the world. */
static void mrts_carried(const mrts_places *places, const mrts_lanes *geometry, const mrts_lanes *q, const mrts_lanes *dq,
                                      const mrts_lanes *ddq, mrts_lanes *position, mrts_lanes *rotation, mrts_lanes *twist,
                                      mrts_lanes *acceleration) {
    static const int first_joints[] = MRTS_FIRST_JOINTS;
    const mrts_arm *arm = MRTS_ARM(places->geometry, 0);
    mrts_lanes tips[3 * MRTS_ROBOTS], turns[9 * MRTS_ROBOTS], J[MRTS_SIZE * MRTS_JOINTS], change[MRTS_SIZE * MRTS_ROBOTS];
    mrts_lanes sines[2 * MRTS_JOINTS], velocity[MRTS_SIZE], r[3], turning[3] = {mrts_each(0), mrts_each(0), mrts_each(0)};
    const mrts_lanes *const at[] = {q, geometry}, *const moving[] = {q, dq, geometry};
    mrts_lanes *const poses[] = {tips, turns, J}, *const bias[] = {change};
    mrts_sines(first_joints[1], q, sines);
    for (int i = 2 * first_joints[1]; i < 2 * MRTS_JOINTS; ++i) sines[i] = mrts_each(0); /* of other arms nothing is wanted */
    MRTS_KINEMATICS_LANES(at, sines, poses);
    MRTS_BIAS_ACCELERATION_LANES(moving, sines, bias);
    mrts_tip_by_joints(0, first_joints[1], J, dq, ddq, velocity, change);
    for (int i = 0; i < 3; ++i) { /* of the tip by columns, turned back by that of the grasp in the object */
        for (int j = 0; j < 3; ++j) {
            rotation[3 * i + j] = turns[i] * arm->tip_rotation[3 * j] + turns[3 + i] * arm->tip_rotation[3 * j + 1] +
                                  turns[6 + i] * arm->tip_rotation[3 * j + 2];
        }
    }
    for (int i = 0; i < 3; ++i) {
        r[i] = rotation[3 * i] * arm->tip_position[0] + rotation[3 * i + 1] * arm->tip_position[1] +
               rotation[3 * i + 2] * arm->tip_position[2];
        position[i] = tips[i] - r[i];
    }
    mrts_rate_in_world(arm, places->components, velocity, twist);
    mrts_rate_in_world(arm, places->components, change, acceleration);
    mrts_less_cross(twist + 3, r, twist);
    mrts_less_cross(acceleration + 3, r, acceleration);
    mrts_less_cross(r, twist + 3, turning); /* w x r */
    mrts_less_cross(twist + 3, turning, acceleration);
}

/* Puts some numbers of each place where they belong. */
static void mrts_put_numbers(int count, const mrts_lanes *numbers, const long long *places, double *all) {
    double *own[MRTS_LANES];
    for (int lane = 0; lane < MRTS_LANES; ++lane) own[lane] = all + places[lane] * count;
    for (int i = 0; i < count; ++i) {
        const mrts_lanes number = numbers[i];
        MRTS_UNROLL
        for (int lane = 0; lane < MRTS_LANES; ++lane) own[lane][i] = number[lane];
    }
}

/* How fast the path is played at some places: x, its rate u, and the speed; u is a line on each segment. */
static void mrts_speeds_at(const mrts_places *to, const long long *segments, mrts_lanes h, mrts_lanes at, mrts_lanes *x,
                                         mrts_lanes *u, mrts_lanes *speed) {
    mrts_lanes first, last, start;
    MRTS_UNROLL
    for (int lane = 0; lane < MRTS_LANES; ++lane) {
        first[lane] = to->u[2 * segments[lane]];
        last[lane] = to->u[2 * segments[lane] + 1];
        start[lane] = to->x[segments[lane]];
    }
    *x = start + 2 * h * at * (first + (last - first) * at / 2);
    *u = first + (last - first) * at;
    MRTS_UNROLL
    for (int lane = 0; lane < MRTS_LANES; ++lane) (*speed)[lane] = MRTS_SQRT((*x)[lane]);
}

/* Some places in a row: see mrts_path_places. */
static void mrts_some_places(const mrts_places *to, const mrts_lanes *geometry, const long long *places) {
    const mrts_joint_path *path = to->path;
    mrts_lanes q[MRTS_JOINTS], position[3], rotation[9], columns[9], x, u, speed, time, h, at;
    long long segments[MRTS_LANES];
    mrts_lanes rate[MRTS_JOINTS + 6], change[MRTS_JOINTS + 6], *twist = rate + MRTS_JOINTS, *acceleration = change + MRTS_JOINTS;
    MRTS_UNROLL
    for (int lane = 0; lane < MRTS_LANES; ++lane) {
        segments[lane] = to->segments[places[lane] / path->places];
        time[lane] = path->time[segments[lane]];
        h[lane] = path->time[segments[lane] + 1] - path->time[segments[lane]];
        at[lane] = path->at[places[lane] % path->places];
    }
    mrts_joints_at(path, segments, places, h, at, q, rate, change);
    mrts_carried(to, geometry, q, rate, change, position, rotation, twist, acceleration);
    mrts_speeds_at(to, segments, h, at, &x, &u, &speed);
    for (int i = 0; i < MRTS_JOINTS + 6; ++i) { /* eq. (10) and its derivative */
        change[i] = change[i] * x + rate[i] * u;
        rate[i] *= speed;
    }
    time += h * at;
    const double *first = path->time + to->segments[0];
    time -= first[0] + (first[1] - first[0]) * path->at[0];
    mrts_put_numbers(1, &time, places, to->time);
    mrts_put_numbers(MRTS_JOINTS, q, places, to->q);
    mrts_put_numbers(MRTS_JOINTS, rate, places, to->dq);
    mrts_put_numbers(MRTS_JOINTS, change, places, to->ddq);
    mrts_put_numbers(3, position, places, to->position);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) columns[3 * j + i] = rotation[3 * i + j];
    }
    mrts_put_numbers(9, columns, places, to->rotation);
    mrts_put_numbers(6, twist, places, to->twist);
    mrts_put_numbers(6, acceleration, places, to->acceleration);
}

/* All `count` places of some segments in a row, see mrts_places: the time from the first place of all, joints and object. */
MRTS_EXPORT void mrts_path_places(long long count, const mrts_joint_path *path, const double *x, const double *u,
                                  const double *geometry, const long long *segments, const int *components, double *time,
                                  double *q, double *dq, double *ddq, double *position, double *rotation, double *twist,
                                  double *acceleration) {
    const mrts_places to = {path, x,  u,   geometry, segments, components, time,
                            q,    dq, ddq, position, rotation, twist,      acceleration};
    long long places[MRTS_LANES];
    mrts_lanes numbers[MRTS_GEOMETRY_NUMBERS];
    for (int i = 0; i < MRTS_GEOMETRY_NUMBERS; ++i) numbers[i] = mrts_each(geometry[i]);
    for (long long n = 0; n < count; n += MRTS_LANES) { /* beyond the last the last is repeated */
        for (int lane = 0; lane < MRTS_LANES; ++lane) places[lane] = n + lane < count ? n + lane : count - 1;
        mrts_some_places(&to, numbers, places);
    }
}

/*
 * How far given joints are from holding an object that moves as given, over all samples of a motion.
 */

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

/* SPDX-License-Identifier: MIT
 *
 * A retimed motion between the samples of its path: joints on polynomials through the samples, the
 * object where the first arm carries it, both at their speeds.
 */
#include "../tracking/tracking.h"

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

/* Joints at a place of a segment, by the parameter of the path. */
static void mrts_joints_at(const mrts_joint_path *path, long long segment, int place, double h, double *q, double *dq,
                           double *ddq) {
    const double *weight = path->weight + 12 * place, at = path->at[place];
    for (int i = 0; i < MRTS_JOINTS; ++i) {
        const long long here = segment * MRTS_JOINTS + i, next = here + MRTS_JOINTS;
        const double given[4] = {path->dq[here], path->ddq[here] * h, path->dq[next], path->ddq[next] * h};
        double way = 0, whole = 0, rate = 0, change = 0;
        for (int j = 0; j < 4; ++j) {
            way += weight[j] * given[j];
            rate += weight[4 + j] * given[j];
            change += weight[8 + j] * given[j];
            whole += path->whole[j] * given[j];
        }
        q[i] = path->q[here] + h * way + at * (path->q[next] - path->q[here] - h * whole);
        dq[i] = rate;
        ddq[i] = change / h;
    }
}

/* v -= w x r */
static void mrts_less_cross(const double *w, const double *r, double *v) {
    v[0] -= w[1] * r[2] - w[2] * r[1];
    v[1] -= w[2] * r[0] - w[0] * r[2];
    v[2] -= w[0] * r[1] - w[1] * r[0];
}

/* The rate of a tip in base axes and cell components, linear and angular in the world. */
static void mrts_rate_in_world(const mrts_arm *arm, const int *components, const double *rate, double *world) {
    const double *R = arm->base_rotation;
    double in_base[6];
    for (int i = 0; i < 6; ++i) in_base[i] = 0;
    for (int j = 0; j < MRTS_SIZE; ++j) in_base[components[j]] = rate[j];
    for (int i = 0; i < 6; ++i) {
        const double *half = in_base + i / 3 * 3;
        world[i] = R[3 * (i % 3)] * half[0] + R[3 * (i % 3) + 1] * half[1] + R[3 * (i % 3) + 2] * half[2];
    }
}

/* The object that the first arm carries: its pose by rows, its rates in the world. */
static void mrts_carried(const mrts_places *places, const double *q, const double *dq, const double *ddq, double *position,
                         double *rotation, double *twist, double *acceleration) {
    static const int first_joints[] = MRTS_FIRST_JOINTS;
    const mrts_arm *arm = MRTS_ARM(places->geometry, 0);
    double tips[3 * MRTS_ROBOTS], turns[9 * MRTS_ROBOTS], J[MRTS_SIZE * MRTS_JOINTS], change[MRTS_SIZE * MRTS_ROBOTS];
    double velocity[MRTS_SIZE], r[3], turning[3] = {0, 0, 0};
    const double *const at[] = {q, places->geometry}, *const moving[] = {q, dq, places->geometry};
    double *const poses[] = {tips, turns, J}, *const bias[] = {change};
    MRTS_KINEMATICS(at, poses);
    MRTS_BIAS_ACCELERATION(moving, bias);
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

/* A place: see mrts_path_places. */
static void mrts_one_place(const mrts_places *to, long long n) {
    const mrts_joint_path *path = to->path;
    const long long segment = n / path->places;
    const int place = (int)(n - segment * path->places);
    const double h = path->time[segment + 1] - path->time[segment], at = path->at[place];
    const double first = to->u[2 * segment], last = to->u[2 * segment + 1];
    const double x = to->x[segment] + 2 * h * at * (first + (last - first) * at / 2), u = first + (last - first) * at;
    const double speed = MRTS_SQRT(x);
    double *dq = to->dq + n * MRTS_JOINTS, *ddq = to->ddq + n * MRTS_JOINTS;
    double *twist = to->twist + 6 * n, *acceleration = to->acceleration + 6 * n, rotation[9];
    mrts_joints_at(path, segment, place, h, to->q + n * MRTS_JOINTS, dq, ddq);
    mrts_carried(to, to->q + n * MRTS_JOINTS, dq, ddq, to->position + 3 * n, rotation, twist, acceleration);
    for (int i = 0; i < MRTS_JOINTS + 6; ++i) { /* eq. (10) and its derivative */
        double *rate = i < MRTS_JOINTS ? dq + i : twist + i - MRTS_JOINTS;
        double *change = i < MRTS_JOINTS ? ddq + i : acceleration + i - MRTS_JOINTS;
        *change = *change * x + *rate * u;
        *rate *= speed;
    }
    to->time[n] = path->time[segment] + h * at - (path->time[0] + (path->time[1] - path->time[0]) * path->at[0]);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) to->rotation[9 * n + 3 * j + i] = rotation[3 * i + j];
    }
}

/* All `count` places of all segments in a row, see mrts_places: the time from the first place of all, joints and object. */
MRTS_EXPORT void mrts_path_places(long long count, const mrts_joint_path *path, const double *x, const double *u,
                                  const double *geometry, const int *components, double *time, double *q, double *dq,
                                  double *ddq, double *position, double *rotation, double *twist, double *acceleration) {
    const mrts_places to = {path, x, u, geometry, components, time, q, dq, ddq, position, rotation, twist, acceleration};
    for (long long n = 0; n < count; ++n) mrts_one_place(&to, n);
}

/* SPDX-License-Identifier: MIT
 *
 * A retimed motion between the samples of its path: joints on polynomials through the samples, the object where the first
 * arm carries it, both at their speeds.
 */
#include "../cell_sizes.h"
#include "../numbers.h"

/* Weights of one place in its segment for velocities and accelerations at both ends, see denser_motion.py: of the way, of
 * the velocity and of its change; the same for all segments. */
typedef struct {
    double way[4], rate[4], change[4];
} mrts_place;

/* A path of joints, Shape (samples, MRTS_JOINTS) each, with its places. */
typedef struct {
    const double *time; /* the path parameter */
    const double *q, *dq, *ddq;
    const mrts_place *place;
    const double *at; /* where each place is in its segment, in (0, 1) */
    const double *whole; /* weights of the way over a whole segment, (4) */
    int places;
} mrts_joint_path;

/* Joints at a place of a segment, by the parameter of the path. */
static void mrts_joints_at(const mrts_joint_path *path, long long segment, int place, double *q, double *dq, double *ddq) {
    const double h = path->time[segment + 1] - path->time[segment], at = path->at[place];
    const mrts_place *weight = path->place + place;
    for (int i = 0; i < MRTS_JOINTS; ++i) {
        const long long start = segment * MRTS_JOINTS + i, end = start + MRTS_JOINTS;
        const double given[4] = {path->dq[start], h * path->ddq[start], path->dq[end], h * path->ddq[end]};
        const double missed = path->q[end] - path->q[start] - h * mrts_dot(4, path->whole, given);
        q[i] = path->q[start] + h * mrts_dot(4, weight->way, given) + at * missed;
        dq[i] = mrts_dot(4, weight->rate, given);
        ddq[i] = mrts_dot(4, weight->change, given) / h;
    }
}

/* y = M x, or y = M'x, of a rotation matrix by rows. */
static void mrts_rotated(const double *M, int transposed, const double *x, double *y) {
    for (int i = 0; i < 3; ++i) {
        y[i] = 0;
        for (int j = 0; j < 3; ++j) y[i] += M[transposed ? 3 * j + i : 3 * i + j] * x[j];
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
    double full[6] = {0};
    for (int i = 0; i < MRTS_SIZE; ++i) full[components[i]] = rate[i];
    mrts_rotated(arm->base_rotation, 0, full, world);
    mrts_rotated(arm->base_rotation, 0, full + 3, world + 3);
}

/* The object that the first arm carries: its pose by rows, its rates in the world. */
static int mrts_carried(const double *geometry, const int *components, const double *q, const double *dq,
                        const double *ddq, double *position, double *rotation, double *twist, double *acceleration,
                        const double **arg, double **res, long long *iw, double *w) {
    static const int first_joints[] = MRTS_FIRST_JOINTS;
    const mrts_arm *arm = MRTS_ARM(geometry, 0);
    double tips[3 * MRTS_ROBOTS], turns[9 * MRTS_ROBOTS], J[MRTS_SIZE * MRTS_JOINTS], bias[MRTS_SIZE * MRTS_ROBOTS];
    double velocity[MRTS_SIZE], change[MRTS_SIZE], r[3], turning[3] = {0};
    arg[0] = q;
    arg[1] = geometry;
    res[0] = tips;
    res[1] = turns;
    res[2] = J;
    if (MRTS_KINEMATICS(arg, res, iw, w, 0)) return 1;
    arg[1] = dq;
    arg[2] = geometry;
    res[0] = bias;
    if (MRTS_BIAS_ACCELERATION(arg, res, iw, w, 0)) return 1;
    for (int i = 0; i < MRTS_SIZE; ++i) {
        velocity[i] = 0;
        change[i] = bias[i];
    }
    for (int j = 0; j < first_joints[1]; ++j) {
        for (int i = 0; i < MRTS_SIZE; ++i) {
            velocity[i] += J[j * MRTS_SIZE + i] * dq[j];
            change[i] += J[j * MRTS_SIZE + i] * ddq[j];
        }
    }
    for (int i = 0; i < 3; ++i) { /* of the tip by columns, turned back by that of the grasp in the object */
        for (int j = 0; j < 3; ++j) {
            double sum = 0;
            for (int l = 0; l < 3; ++l) sum += turns[3 * l + i] * arm->tip_rotation[3 * j + l];
            rotation[3 * i + j] = sum;
        }
    }
    mrts_rotated(rotation, 0, arm->tip_position, r);
    for (int i = 0; i < 3; ++i) position[i] = tips[i] - r[i];
    mrts_rate_in_world(arm, components, velocity, twist);
    mrts_rate_in_world(arm, components, change, acceleration);
    mrts_less_cross(twist + 3, r, twist);
    mrts_less_cross(acceleration + 3, r, acceleration);
    mrts_less_cross(r, twist + 3, turning); /* w x r */
    mrts_less_cross(twist + 3, turning, acceleration);
    return 0;
}

/* rates times the speed, and changes where the speed is the root of x and its rate u: eq. (10) and its derivative. */
static void mrts_played(int count, double speed, double x, double u, double *rates, double *changes) {
    for (int i = 0; i < count; ++i) {
        changes[i] = changes[i] * x + rates[i] * u;
        rates[i] *= speed;
    }
}

/* Places first .. first + count - 1 of all segments in a row: joints and object, each place at its squared speed x and its
 * rate u; `components` are those of a twist that a wrench of the cell has. Returns 1 if a generated function failed. */
MRTS_EXPORT int mrts_path_places(long long first, long long count, const mrts_joint_path *path, const double *x,
                                 const double *u, const double *geometry, const int *components, double *q, double *dq,
                                 double *ddq, double *position, double *rotation, double *twist, double *acceleration,
                                 const double **arg, double **res, long long *iw, double *w) {
    for (long long n = first; n < first + count; ++n) {
        double *rate = dq + n * MRTS_JOINTS, *change = ddq + n * MRTS_JOINTS;
        mrts_joints_at(path, n / path->places, (int)(n % path->places), q + n * MRTS_JOINTS, rate, change);
        if (mrts_carried(geometry, components, q + n * MRTS_JOINTS, rate, change, position + 3 * n, rotation + 9 * n,
                         twist + 6 * n, acceleration + 6 * n, arg, res, iw, w)) {
            return 1;
        }
        const double speed = MRTS_SQRT(x[n]);
        mrts_played(MRTS_JOINTS, speed, x[n], u[n], rate, change);
        mrts_played(6, speed, x[n], u[n], twist + 6 * n, acceleration + 6 * n);
    }
    return 0;
}

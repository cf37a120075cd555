/* SPDX-License-Identifier: MIT
 *
 * Inverse kinematics at a sample: damped Newton steps (Sugihara, Solvability-unconcerned inverse kinematics by
 * the Levenberg-Marquardt method, IEEE Transactions on Robotics 27, 2011), for arms with as many joints as wrench components, and those that null_space.h prefers for arms with more.
 */
#include "tracking.h"

/* Sine of an angle below which a turn has no axis: it is none, or half a turn. */
#define MRTS_NO_TURN 1e-9

/* R v and R'v of a rotation matrix by rows. */
static void mrts_times(const double *R, const double *v, double *out) {
    for (int i = 0; i < 3; ++i) out[i] = R[3 * i] * v[0] + R[3 * i + 1] * v[1] + R[3 * i + 2] * v[2];
}

static void mrts_transposed_times(const double *R, const double *v, double *out) {
    for (int i = 0; i < 3; ++i) out[i] = R[i] * v[0] + R[3 + i] * v[1] + R[6 + i] * v[2];
}

MRTS_LOCAL void mrts_cross(const double *a, const double *b, double *out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Rotation vector of target times the transpose of tip; tip is stored by columns. */
static void mrts_turn_between(const double *target, const double *tip, double *turn) {
    double E[9], axis[3], sine, cosine;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            E[3 * i + j] = target[3 * i] * tip[j] + target[3 * i + 1] * tip[3 + j] + target[3 * i + 2] * tip[6 + j];
        }
    }
    axis[0] = (E[7] - E[5]) / 2;
    axis[1] = (E[2] - E[6]) / 2;
    axis[2] = (E[3] - E[1]) / 2;
    sine = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    cosine = (E[0] + E[4] + E[8] - 1) / 2;
    for (int i = 0; i < 3; ++i) turn[i] = sine > MRTS_NO_TURN ? axis[i] * (atan2(sine, cosine) / sine) : axis[i];
    if (sine <= MRTS_NO_TURN && cosine < 0) turn[0] = 3.14159265358979; /* half a turn: its axis does not matter here */
}

MRTS_LOCAL int mrts_invert(const double *matrix, double *inverse) {
    enum { W = MRTS_SIZE };
    double M[W * W];
    for (int i = 0; i < W * W; ++i) {
        M[i] = matrix[i];
        inverse[i] = i % (W + 1) == 0;
    }
    for (int j = 0; j < W; ++j) {
        int p = j;
        for (int i = j + 1; i < W; ++i) {
            if (fabs(M[i * W + j]) > fabs(M[p * W + j])) p = i;
        }
        if (!(fabs(M[p * W + j]) > 0)) return 0;
        if (p != j) {
            for (int l = 0; l < W; ++l) {
                double t = M[j * W + l];
                M[j * W + l] = M[p * W + l];
                M[p * W + l] = t;
                t = inverse[j * W + l];
                inverse[j * W + l] = inverse[p * W + l];
                inverse[p * W + l] = t;
            }
        }
        const double factor = 1 / M[j * W + j];
        for (int l = 0; l < W; ++l) {
            M[j * W + l] *= factor;
            inverse[j * W + l] *= factor;
        }
        for (int i = 0; i < W; ++i) {
            const double f = M[i * W + j];
            if (i == j || f == 0) continue;
            for (int l = 0; l < W; ++l) {
                M[i * W + l] -= f * M[j * W + l];
                inverse[i * W + l] -= f * inverse[j * W + l];
            }
        }
    }
    return 1;
}

MRTS_LOCAL void mrts_tip_rates(const mrts_tracking *task, const mrts_arm *arm, const double *rotation,
                               const double *twist, const double *acceleration, double *velocity, double *change) {
    double r[3], wr[3], wwr[3], dwr[3], v[3], a[3], six[6];
    mrts_times(rotation, arm->tip_position, r);
    mrts_cross(twist + 3, r, wr);
    mrts_cross(twist + 3, wr, wwr);
    mrts_cross(acceleration + 3, r, dwr);
    for (int i = 0; i < 3; ++i) {
        v[i] = twist[i] + wr[i];
        a[i] = acceleration[i] + dwr[i] + wwr[i];
    }
    mrts_transposed_times(arm->base_rotation, v, six);
    mrts_transposed_times(arm->base_rotation, twist + 3, six + 3);
    for (int i = 0; i < MRTS_SIZE; ++i) velocity[i] = six[task->components[i]];
    mrts_transposed_times(arm->base_rotation, a, six);
    mrts_transposed_times(arm->base_rotation, acceleration + 3, six + 3);
    for (int i = 0; i < MRTS_SIZE; ++i) change[i] = six[task->components[i]];
}

MRTS_LOCAL void mrts_tip_error(const mrts_arm *arm, const double *position, const double *rotation, const double *tip,
                               const double *tip_rotation, double *off, double *turned, double *gap, double *turn) {
    double target[9];
    mrts_times(rotation, arm->tip_position, off);
    for (int i = 0; i < 3; ++i) off[i] += position[i] - tip[i];
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            target[3 * i + j] = rotation[3 * i] * arm->tip_rotation[j] + rotation[3 * i + 1] * arm->tip_rotation[3 + j] +
                                rotation[3 * i + 2] * arm->tip_rotation[6 + j];
        }
    }
    mrts_turn_between(target, tip_rotation, turned);
    *gap = sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
    *turn = sqrt(turned[0] * turned[0] + turned[1] * turned[1] + turned[2] * turned[2]);
}

MRTS_LOCAL double mrts_arm_error(const mrts_tracking *task, const mrts_arm *arm, const double *off,
                                 const double *turned, double *error) {
    enum { W = MRTS_SIZE };
    double six[6], damping = 0;
    mrts_transposed_times(arm->base_rotation, off, six);
    mrts_transposed_times(arm->base_rotation, turned, six + 3);
    for (int i = 0; i < W; ++i) {
        error[i] = six[task->components[i]];
        damping += error[i] * error[i] / 2;
    }
    return damping;
}

/* One damped Newton step of an arm, J by columns: (J J' + |error|^2 / 2)^-1; 0 if that is singular. */
static int mrts_newton_step(const double *J, const double *error, double damping, double *step) {
    enum { W = MRTS_SIZE };
    double square[W * W], solved[W * W], weight[W];
    for (int i = 0; i < W; ++i) {
        for (int j = 0; j < W; ++j) {
            square[i * W + j] = i == j ? damping : 0;
            for (int l = 0; l < W; ++l) square[i * W + j] += J[l * W + i] * J[l * W + j];
        }
    }
    if (!mrts_invert(square, solved)) return 0;
    for (int i = 0; i < W; ++i) weight[i] = mrts_dot(W, solved + i * W, error);
    for (int l = 0; l < W; ++l) {
        step[l] = mrts_dot(W, J + l * W, weight);
    }
    return 1;
}

/* Shortens a step that is too long; returns how long it was. */
static double mrts_shorten(const mrts_tracking *task, int joints, double *step) {
    double longest = 0;
    for (int l = 0; l < joints; ++l) longest = fmax(longest, fabs(step[l]));
    for (int l = 0; longest > task->longest && l < joints; ++l) step[l] *= task->longest / longest;
    return longest;
}

MRTS_LOCAL int mrts_hold_grasps(const mrts_tracking *task, const double *position, const double *rotation,
                                const double *reference, double *now, double *best, double *gap, double *turn,
                                double *drift) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double tips[3 * R], rotations[9 * R], J_all[W * M], off[3], turned[3], error[W], step[M], least[R];
    const double *const at[] = {now, task->geometry};
    double *const poses[] = {tips, rotations, J_all};
    (void)reference; /* of redundant arms */
    for (int robot = 0; robot < R; ++robot) gap[robot] = turn[robot] = drift[robot] = least[robot] = MRTS_INFINITY;
    for (int iteration = 0; iteration < task->steps; ++iteration) {
        double largest = 0;
        MRTS_KINEMATICS(at, poses);
#ifdef MRTS_REDUNDANT
        mrts_null_space spaces[R];
        double F[W * R], fall[M], unused[W];
        if (!mrts_null_spaces(&task->wish, task->geometry, now, reference, J_all, spaces, F)) return 0;
#endif
        for (int robot = 0; robot < R; ++robot) {
            const mrts_arm *arm = MRTS_ARM(task->geometry, robot);
            const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
            const double *J = J_all + W * first;
            double gap_now, turn_now, size, left = 0, *q = now + first;
            mrts_tip_error(arm, position, rotation, tips + 3 * robot, rotations + 9 * robot, off, turned, &gap_now,
                           &turn_now);
            size = fmax(gap_now, turn_now);
            const double damping = mrts_arm_error(task, arm, off, turned, error);
            if (joints == W && !mrts_newton_step(J, error, damping, step)) return 0;
#ifdef MRTS_REDUNDANT
            if (joints > W) {
                for (int i = 0; i < joints; ++i) fall[i] = -spaces[robot].gradient[i];
                if (mrts_preferred(joints, J, spaces + robot, damping, error, fall, step, unused) == 0) return 0;
            }
#endif
            const double longest = mrts_shorten(task, joints, step);
            if (joints > W) left = longest;
            if (joints > W && size <= task->reached) size = task->reached * tanh(left);
            if (size < least[robot]) {
                least[robot] = size;
                gap[robot] = gap_now;
                turn[robot] = turn_now;
                drift[robot] = left;
                for (int i = 0; i < joints; ++i) best[first + i] = q[i];
            }
            for (int i = 0; i < joints; ++i) {
                q[i] += step[i];
                if (fabs(step[i]) > largest) largest = fabs(step[i]);
            }
        }
        if (largest <= task->settled) break;
    }
    return 1;
}

/* What an arm's tip is to do at a sample, and the inverse that it takes: of J, of a redundant arm of J J'. */
typedef struct {
    double velocity[MRTS_SIZE];
    double change[MRTS_SIZE];
    double inverse[MRTS_SIZE * MRTS_SIZE];
} mrts_task_rates;

/* Rates of all tips, and a bound of each Jacobian's condition number. 0 if an arm is singular. */
static int mrts_rates_of_tips(const mrts_tracking *task, const double *rotation, const double *twist,
                              const double *acceleration, const double *J_all, mrts_task_rates *rates,
                              double *condition) {
    enum { R = MRTS_ROBOTS, W = MRTS_SIZE };
    for (int robot = 0; robot < R; ++robot) {
        mrts_task_rates *rate = rates + robot;
        const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
        const double *J = J_all + W * first;
        double matrix[W * W];
        if (joints == W) {
            for (int i = 0; i < W; ++i) {
                for (int j = 0; j < W; ++j) matrix[i * W + j] = J[j * W + i];
            }
        }
#ifdef MRTS_REDUNDANT
        if (joints > W) mrts_square(joints, J, matrix);
#endif
        if (!mrts_invert(matrix, rate->inverse)) return 0;
        condition[robot] = sqrt(mrts_dot(W * W, matrix, matrix) * mrts_dot(W * W, rate->inverse, rate->inverse));
        if (joints > W) condition[robot] = sqrt(condition[robot] * W);
        mrts_tip_rates(task, MRTS_ARM(task->geometry, robot), rotation, twist, acceleration, rate->velocity,
                       rate->change);
    }
    return 1;
}

MRTS_LOCAL int mrts_joint_rates(const mrts_tracking *task, const double *rotation, const double *twist,
                                const double *acceleration, const double *reference, const double *q, double *dq,
                                double *ddq, double *condition, double *curvature) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double tips[3 * R], rotations[9 * R], J[W * M], bias[W * R];
    const double *const at[] = {q, task->geometry}, *const moving[] = {q, dq, task->geometry};
    double *const poses[] = {tips, rotations, J}, *const biases[] = {bias};
    mrts_task_rates rates[R];
    (void)reference; /* of redundant arms */
    MRTS_KINEMATICS(at, poses);
    if (!mrts_rates_of_tips(task, rotation, twist, acceleration, J, rates, condition)) return 0;
#ifdef MRTS_REDUNDANT
    mrts_null_space spaces[R];
    double F[W * R], dF[W * R] = {0}, change[M], nothing[M] = {0};
    if (!mrts_null_spaces(&task->wish, task->geometry, q, reference, J, spaces, F)) return 0;
#endif
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
        curvature[robot] = 1;
        for (int i = 0; joints == W && i < W; ++i) {
            dq[first + i] = mrts_dot(W, rates[robot].inverse + i * W, rates[robot].velocity);
        }
#ifdef MRTS_REDUNDANT
        if (joints > W) {
            const double determinant = mrts_preferred(joints, J + W * first, spaces + robot, 0, rates[robot].velocity,
                                                      nothing, dq + first, dF + W * robot);
            curvature[robot] = mrts_curvature(joints, J + W * first, determinant);
        }
#endif
    }
    MRTS_BIAS_ACCELERATION(moving, biases);
#ifdef MRTS_REDUNDANT
    mrts_change_along(task->geometry, q, dq, spaces, F, dF, change);
#endif
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
        double *wanted = rates[robot].change;
        for (int i = 0; i < W; ++i) wanted[i] -= bias[robot * W + i];
        for (int i = 0; joints == W && i < W; ++i) ddq[first + i] = mrts_dot(W, rates[robot].inverse + i * W, wanted);
#ifdef MRTS_REDUNDANT
        if (joints > W) {
            double unused[W];
            mrts_preferred(joints, J + W * first, spaces + robot, 0, wanted, change + first, ddq + first, unused);
        }
#endif
    }
    return 1;
}

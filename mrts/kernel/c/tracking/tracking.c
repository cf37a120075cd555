/* SPDX-License-Identifier: MIT
 *
 * Inverse kinematics at a sample: damped Newton steps (Sugihara, Solvability-unconcerned inverse kinematics by
 * the Levenberg-Marquardt method, IEEE Transactions on Robotics 27, 2011), and, for arms with more joints than wrench
 * components, those that null_space.h prefers.
 */
#include "tracking.h"

/* Sine of an angle below which a turn has no axis: it is none, or half a turn. */
#define MRTS_NO_TURN 1e-9

/* Damping, as a share of the trace of J J', of a step that has no other where that is singular. */
#define MRTS_LEAST_DAMPING 1e-14

/* R v and R'v of a rotation matrix by rows. */
static void mrts_times(const double *R, const double *v, double *out) {
    for (int i = 0; i < 3; ++i) out[i] = R[3 * i] * v[0] + R[3 * i + 1] * v[1] + R[3 * i + 2] * v[2];
}

static void mrts_transposed_times(const double *R, const double *v, double *out) {
    for (int i = 0; i < 3; ++i) out[i] = R[i] * v[0] + R[3 + i] * v[1] + R[6 + i] * v[2];
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

MRTS_LOCAL void mrts_tip_rates(const mrts_tracking *task, const mrts_arm *arm, const double *rotation,
                               const double *twist, const double *acceleration, double *velocity, double *change) {
    double v[3], a[3], six[6];
    mrts_object_point(rotation, twist, acceleration, arm->tip_position, v, a);
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

/* One damped Newton step of an arm, J by columns: J' (J J' + damping)^-1 error. */
static void mrts_newton_step(int joints, const double *J, const double *error, double damping, double *step) {
    enum { W = MRTS_SIZE };
    double square[W * W], weight[W];
    for (int attempt = 0; attempt < 2; ++attempt) {
        double trace = 0;
        for (int i = 0; i < W; ++i) {
            weight[i] = error[i];
            for (int j = 0; j < W; ++j) {
                square[i * W + j] = i == j ? damping : 0;
                for (int l = 0; l < joints; ++l) square[i * W + j] += J[l * W + i] * J[l * W + j];
            }
            trace += square[i * W + i];
        }
        if (mrts_eliminate(W, square, weight)) break;
        damping = MRTS_LEAST_DAMPING * trace;
    }
    for (int l = 0; l < joints; ++l) step[l] = mrts_dot(W, J + l * W, weight);
}

MRTS_LOCAL void mrts_hold_grasps(const mrts_tracking *task, const double *position, const double *rotation,
                                 const double *reference, const unsigned char *left_out, double *now, double *best,
                                 double *gap, double *turn, double *drift) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double tips[3 * R], rotations[9 * R], J_all[W * M], off[3], turned[3], error[W], step[M], least[R];
    const double *const at[] = {now, task->geometry};
    double *const poses[] = {tips, rotations, J_all};
    for (int robot = 0; robot < R; ++robot) gap[robot] = turn[robot] = drift[robot] = least[robot] = MRTS_INFINITY;
    for (int i = 0; i < M; ++i) best[i] = now[i];
    for (int iteration = 0; iteration < task->steps; ++iteration) {
        double largest = 0, farthest = 0;
        MRTS_KINEMATICS(at, poses);
#ifdef MRTS_REDUNDANT
        mrts_null_space spaces[R];
        double F[W * R], fall[MRTS_MOST_JOINTS];
        if (reference) mrts_null_spaces(&task->wish, task->fold, task->geometry, now, reference, J_all, spaces, F);
#else
        (void)reference;
#endif
        for (int robot = 0; robot < R; ++robot) {
            const mrts_arm *arm = MRTS_ARM(task->geometry, robot);
            const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
            double gap_now, turn_now, left = 0, longest = 0, *q = now + first;
            if (left_out[robot]) continue;
            mrts_tip_error(arm, position, rotation, tips + 3 * robot, rotations + 9 * robot, off, turned, &gap_now,
                           &turn_now);
            double size = fmax(gap_now, turn_now);
            farthest = fmax(farthest, size);
            const double damping = mrts_arm_error(task, arm, off, turned, error);
            mrts_newton_step(joints, J_all + W * first, error, damping, step);
#ifdef MRTS_REDUNDANT
            if (reference && joints > W) {
                for (int i = 0; i < joints; ++i) fall[i] = -spaces[robot].gradient[i];
                left = mrts_add_preferred(joints, spaces + robot, fall, step);
                if (size <= task->reached) size = task->reached * tanh(left);
            }
#endif
            if (size < least[robot]) {
                least[robot] = size;
                gap[robot] = gap_now;
                turn[robot] = turn_now;
                drift[robot] = left;
                for (int i = 0; i < joints; ++i) best[first + i] = q[i];
            }
            for (int i = 0; i < joints; ++i) longest = fmax(longest, fabs(step[i]));
            const double share = longest > task->longest ? task->longest / longest : 1;
            for (int i = 0; i < joints; ++i) q[i] += share * step[i];
            largest = fmax(largest, longest);
        }
        if (largest <= task->settled && farthest <= task->reached) break; /* farther away, rounding leaves a saddle */
    }
}

MRTS_LOCAL void mrts_joint_rates(const mrts_tracking *task, const mrts_path *at, const double *reference,
                                 const unsigned char *left_out, const double *q, double *dq, double *ddq,
                                 mrts_held *held) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double tips[3 * R], rotations[9 * R], J_all[W * M], bias[W * R], wanted[W * R], velocity[W];
    const double *const here[] = {q, task->geometry}, *const moving[] = {q, dq, task->geometry};
    double *const poses[] = {tips, rotations, J_all}, *const biases[] = {bias};
    mrts_split splits[R];
    MRTS_KINEMATICS(here, poses);
#ifdef MRTS_REDUNDANT
    mrts_null_space spaces[R];
    double F[W * R], change[M];
    const double nothing[MRTS_MOST_JOINTS] = {0};
    mrts_null_spaces(&task->wish, task->fold, task->geometry, q, reference, J_all, spaces, F);
#else
    (void)reference;
#endif
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
        const double *J = J_all + W * first;
        held->folds[robot] = 0;
        for (int i = 0; i < joints; ++i) dq[first + i] = ddq[first + i] = 0;
        if (left_out[robot]) continue;
        mrts_split_joints(joints, J, splits + robot);
        held->condition[robot] = splits[robot].condition;
        if (!(held->condition[robot] < task->condition)) held->condition[robot] = mrts_condition(joints, J);
        mrts_tip_rates(task, MRTS_ARM(task->geometry, robot), at->rotation, at->twist, at->acceleration, velocity,
                       wanted + W * robot);
        mrts_least_joints(joints, splits + robot, velocity, dq + first);
#ifdef MRTS_REDUNDANT
        if (joints > W) {
            mrts_add_preferred(joints, spaces + robot, nothing, dq + first);
            held->folds[robot] = spaces[robot].folds;
        }
#endif
    }
    MRTS_BIAS_ACCELERATION(moving, biases);
#ifdef MRTS_REDUNDANT
    mrts_change_along(task->geometry, q, dq, spaces, F, change);
#endif
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
        if (left_out[robot]) continue;
        for (int i = W * robot; i < W * (robot + 1); ++i) wanted[i] -= bias[i];
        mrts_least_joints(joints, splits + robot, wanted + W * robot, ddq + first);
#ifdef MRTS_REDUNDANT
        if (joints > W) mrts_add_preferred(joints, spaces + robot, change + first, ddq + first);
#endif
    }
}

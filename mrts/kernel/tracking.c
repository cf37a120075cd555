/* SPDX-License-Identifier: MIT
 *
 * Inverse kinematics along a whole path: damped Newton steps (Sugihara, Solvability-unconcerned inverse kinematics by
 * the Levenberg-Marquardt method, IEEE Transactions on Robotics 27, 2011) from positions predicted by the sample before,
 * for arms with as many joints as wrench components.
 *
 * The cell's generated C and these macros come first:
 *     MRTS_JOINTS, MRTS_ROBOTS, MRTS_SIZE         joints in all, arms, wrench components (and joints of each arm)
 *     MRTS_KINEMATICS, MRTS_BIAS_ACCELERATION     the generated functions
 */

/* One arm in its place: rotation matrices by rows. */
typedef struct {
    double base_rotation[9];
    double tip_rotation[9]; /* of the grasp in the object frame */
    double tip_position[3];
} mrts_arm;

typedef struct {
    int steps;       /* most Newton steps at a sample */
    double settled;  /* joint step at which the iteration ends */
    double longest;  /* largest joint step */
    int components[6]; /* rows of a six-component twist that this cell uses */
    mrts_arm arm[MRTS_ROBOTS];
} mrts_tracking;

static void mrts_times(const double *R, const double *v, double *out) {
    for (int i = 0; i < 3; ++i) out[i] = R[3 * i] * v[0] + R[3 * i + 1] * v[1] + R[3 * i + 2] * v[2];
}

static void mrts_transposed_times(const double *R, const double *v, double *out) {
    for (int i = 0; i < 3; ++i) out[i] = R[i] * v[0] + R[3 + i] * v[1] + R[6 + i] * v[2];
}

static void mrts_cross(const double *a, const double *b, double *out) {
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
    for (int i = 0; i < 3; ++i) turn[i] = sine > 1e-9 ? axis[i] * (atan2(sine, cosine) / sine) : axis[i];
    if (sine <= 1e-9 && cosine < 0) turn[0] = 3.14159265358979; /* half a turn: its axis does not matter here */
}

/* Inverse of a matrix by Gauss-Jordan elimination with row exchanges; 0 if it is singular. */
static int mrts_invert(const double *matrix, double *inverse) {
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

/* Velocity and acceleration of a grasp in base axes and cell components. */
static void mrts_tip_rates(const mrts_tracking *task, const mrts_arm *arm, const double *rotation, const double *twist,
                           const double *acceleration, double *velocity, double *change) {
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

/* Error of one arm's tip against its grasp on the object, in the world, and its sizes. */
static void mrts_tip_error(const mrts_arm *arm, const double *position, const double *rotation, const double *tip,
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

/* One damped Newton step of an arm, J by columns: (J J' + |error|^2 / 2)^-1; 0 if that is singular. */
static int mrts_newton_step(const mrts_tracking *task, const mrts_arm *arm, const double *J, const double *off,
                            const double *turned, double *step) {
    enum { W = MRTS_SIZE };
    double six[6], error[W], square[W * W], solved[W * W], weight[W], damping = 0, longest = 0;
    mrts_transposed_times(arm->base_rotation, off, six);
    mrts_transposed_times(arm->base_rotation, turned, six + 3);
    for (int i = 0; i < W; ++i) {
        error[i] = six[task->components[i]];
        damping += error[i] * error[i] / 2;
    }
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
        if (fabs(step[l]) > longest) longest = fabs(step[l]);
    }
    for (int l = 0; longest > task->longest && l < W; ++l) step[l] *= task->longest / longest;
    return 1;
}

/* Joint positions with the smallest errors met from `now` on, which is moved. 0 if an arm is singular. */
static int mrts_hold_grasps(const mrts_tracking *task, const double *position, const double *rotation, double *now,
                            double *best, double *gap, double *turn, const double **arg, double **res, long long *iw,
                            double *w) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double tips[3 * R], rotations[9 * R], J[W * M], off[3], turned[3], step[W];
    for (int robot = 0; robot < R; ++robot) gap[robot] = turn[robot] = 1e300;
    for (int iteration = 0; iteration < task->steps; ++iteration) {
        double largest = 0;
        arg[0] = now;
        res[0] = tips;
        res[1] = rotations;
        res[2] = J;
        if (MRTS_KINEMATICS(arg, res, iw, w, 0)) return 0;
        for (int robot = 0; robot < R; ++robot) {
            const mrts_arm *arm = task->arm + robot;
            double gap_now, turn_now, *q = now + robot * W;
            mrts_tip_error(arm, position, rotation, tips + 3 * robot, rotations + 9 * robot, off, turned, &gap_now,
                           &turn_now);
            if (fmax(gap_now, turn_now) < fmax(gap[robot], turn[robot])) {
                gap[robot] = gap_now;
                turn[robot] = turn_now;
                for (int i = 0; i < W; ++i) best[robot * W + i] = q[i];
            }
            if (!mrts_newton_step(task, arm, J + robot * W * W, off, turned, step)) return 0;
            for (int i = 0; i < W; ++i) {
                q[i] += step[i];
                if (fabs(step[i]) > largest) largest = fabs(step[i]);
            }
        }
        if (largest <= task->settled) break;
    }
    return 1;
}

/* q' = J^-1 v and q'' = J^-1 (a - J' q') of all arms, and a bound of each condition number. 0 if an arm is singular. */
static int mrts_joint_rates(const mrts_tracking *task, const double *rotation, const double *twist,
                            const double *acceleration, const double *q, double *dq, double *ddq, double *condition,
                            const double **arg, double **res, long long *iw, double *w) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double tips[3 * R], rotations[9 * R], J[W * M], bias[W * R], inverse[R][W * W], change[R][W];
    arg[0] = q;
    res[0] = tips;
    res[1] = rotations;
    res[2] = J;
    if (MRTS_KINEMATICS(arg, res, iw, w, 0)) return 0;
    for (int robot = 0; robot < R; ++robot) {
        double velocity[W], matrix[W * W];
        for (int i = 0; i < W; ++i) {
            for (int j = 0; j < W; ++j) matrix[i * W + j] = J[(robot * W + j) * W + i];
        }
        if (!mrts_invert(matrix, inverse[robot])) return 0;
        condition[robot] = sqrt(mrts_dot(W * W, matrix, matrix) * mrts_dot(W * W, inverse[robot], inverse[robot]));
        mrts_tip_rates(task, task->arm + robot, rotation, twist, acceleration, velocity, change[robot]);
        for (int i = 0; i < W; ++i) dq[robot * W + i] = mrts_dot(W, inverse[robot] + i * W, velocity);
    }
    arg[0] = q;
    arg[1] = dq;
    res[0] = bias;
    if (MRTS_BIAS_ACCELERATION(arg, res, iw, w, 0)) return 0;
    for (int robot = 0; robot < R; ++robot) {
        for (int i = 0; i < W; ++i) change[robot][i] -= bias[robot * W + i];
        for (int i = 0; i < W; ++i) ddq[robot * W + i] = mrts_dot(W, inverse[robot] + i * W, change[robot]);
    }
    return 1;
}

/* Follows the grasps from q at sample 0, which holds them. For each sample and arm: remaining errors of position and
 * rotation, the largest correction of a predicted joint, and a bound of the Jacobian's condition number. Rotations of
 * the object come by rows. Ends early, with the number of samples done, where an arm is singular. */
MRTS_EXPORT long long mrts_track(long long count, const mrts_tracking *task, const double *time, const double *position,
                                 const double *rotation, const double *twist, const double *acceleration, double *q,
                                 double *dq, double *ddq, double *gap, double *turn, double *jump, double *condition,
                                 const double **arg, double **res, long long *iw, double *w) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    for (long long n = 0; n < count; ++n) {
        double predicted[M], now[M], *qn = q + n * M, *dqn = dq + n * M, *ddqn = ddq + n * M;
        const double h = n > 0 ? time[n] - time[n - 1] : 0;
        for (int i = 0; i < M; ++i) {
            predicted[i] = n > 0 ? qn[i - M] + h * dqn[i - M] + h * h / 2 * ddqn[i - M] : qn[i];
            now[i] = predicted[i];
        }
        if (!mrts_hold_grasps(task, position + 3 * n, rotation + 9 * n, now, qn, gap + n * R, turn + n * R, arg, res, iw,
                              w) ||
            !mrts_joint_rates(task, rotation + 9 * n, twist + 6 * n, acceleration + 6 * n, qn, dqn, ddqn,
                              condition + n * R, arg, res, iw, w)) {
            return n;
        }
        for (int robot = 0; robot < R; ++robot) {
            double largest = 0;
            for (int i = robot * W; i < robot * W + W; ++i) largest = fmax(largest, fabs(qn[i] - predicted[i]));
            jump[n * R + robot] = largest;
        }
    }
    return count;
}

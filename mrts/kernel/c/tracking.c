/* SPDX-License-Identifier: MIT
 *
 * Inverse kinematics of many variants of one cell along its motion; one motion is one variant. */
#include "cell_sizes.h"
#include "point_motion.h"

typedef void (*mrts_function)(const double *const *arg, double *const *res);

/* Evaluates a generated function at `count` samples; a stride of 0 repeats an input. `in` and `out` move along. Where the speed
 * varies, `moving` has room for the outputs of a sample, and outputs of rows[i] > 0 get the column of r'' before their last,
 * that of r'^2: what the last one is of inputs `still`, at rest with velocities as accelerations. */
MRTS_EXPORT void mrts_map(mrts_function function, long long count, int inputs, const double **in, const double **still,
                          const long long *in_stride, int outputs, double **out, const long long *out_stride,
                          const long long *rows, double **moving) {
    for (long long sample = 0; sample < count; ++sample) {
        function(in, moving ? moving : out);
        if (moving) function(still, out);
        for (int i = 0; i < outputs; ++i) {
            out[i] += out_stride[i];
            for (int j = 0; j < rows[i]; ++j) out[i][j - rows[i]] = moving[i][out_stride[i] - 2 * rows[i] + j];
        }
        for (int i = 0; i < inputs; ++i) {
            in[i] += in_stride[i];
            if (moving) still[i] += in_stride[i];
        }
    }
}

/* What a grasp takes of an arm's joints and what it leaves free, and the positions that redundant arms prefer of all that
 * hold their grasps; mrts/following/tracking.py has the mathematics. */

/* What the arms of a cell prefer; one value a joint of all arms [rad or m]. */
typedef struct {
    const double *lower; /* position limits, infinite where there are none */
    const double *upper;
    const double *zone; /* widths beside them */
    double push;        /* what h adds at a limit */
} mrts_preference;

/* The transpose of an arm's Jacobian as Q R: the first MRTS_SIZE columns of Q span what the grasp takes of the joints, the
 * others what it leaves free. */
typedef struct {
    double Q[MRTS_MOST_JOINTS * MRTS_MOST_JOINTS]; /* orthogonal, (joints, joints) */
    double inverse[MRTS_SIZE * MRTS_SIZE];         /* of R, upper triangle */
    double condition;                              /* a bound of the Jacobian's condition number, infinite if singular */
} mrts_split;

#ifdef MRTS_REDUNDANT

typedef struct {
    mrts_split split;
    double gradient[MRTS_MOST_JOINTS];                   /* h(q) - h(reference) */
    double hessian[MRTS_MOST_JOINTS * MRTS_MOST_JOINTS]; /* h' minus the geometric stiffness, by rows; h' at a fold */
    double bend[MRTS_MOST_JOINTS];                       /* h'' */
    int folds;                                           /* H has no minimum here */
} mrts_null_space;

#endif

/* Rounds of Jacobi rotations, which converge as squares do; needed where an arm may be singular only. */
enum { MRTS_ROUNDS = 12 };

/* Solves a square system in place; 0 if it is singular. */
static int mrts_solve_square(int size, double *matrix, double *rhs) {
    int place[MRTS_MOST_JOINTS + MRTS_SIZE];
    double x[MRTS_MOST_JOINTS + MRTS_SIZE];
    for (int j = 0; j < size; ++j) place[j] = j;
    mrts_factor(size, place, matrix);
    for (int j = 0; j < size; ++j) {
        x[j] = rhs[place[j]];
        if (!(fabs(matrix[j * (size + 1)]) < MRTS_INFINITY)) return 0;
    }
    mrts_solve(size, matrix, x);
    for (int j = 0; j < size; ++j) rhs[j] = x[j];
    return 1;
}

/* Splits the joints of an arm with at least MRTS_SIZE of them by its Jacobian, by columns. */
static void mrts_split_joints(int joints, const double *J, mrts_split *split) {
    enum { W = MRTS_SIZE };
    double R[MRTS_MOST_JOINTS * W], squares[2] = {0, 0}, *Q = split->Q, *X = split->inverse;
    for (int i = 0; i < joints * W; ++i) {
        R[i] = J[i];
        squares[0] += J[i] * J[i];
    }
    for (int i = 0; i < joints * joints; ++i) Q[i] = i % (joints + 1) == 0;
    for (int j = 0; j < W; ++j) { /* a reflection leaves nothing of column j of R below its diagonal */
        double v[MRTS_MOST_JOINTS], square = 0;
        for (int i = j; i < joints; ++i) {
            v[i] = R[i * W + j];
            square += v[i] * v[i];
        }
        if (!(square > 0)) continue;
        const double half = square + sqrt(square) * fabs(v[j]);
        v[j] += v[j] < 0 ? -sqrt(square) : sqrt(square);
        for (int c = j; c < W; ++c) {
            double along = 0;
            for (int i = j; i < joints; ++i) along += v[i] * R[i * W + c];
            for (int i = j; i < joints; ++i) R[i * W + c] -= along / half * v[i];
        }
        for (int r = 0; r < joints; ++r) {
            double along = 0;
            for (int i = j; i < joints; ++i) along += v[i] * Q[r * joints + i];
            for (int i = j; i < joints; ++i) Q[r * joints + i] -= along / half * v[i];
        }
    }
    split->condition = MRTS_INFINITY;
    for (int j = 0; j < W; ++j) {
        for (int i = 0; i < W; ++i) X[i * W + j] = 0;
    }
    for (int j = 0; j < W; ++j) {
        if (!(fabs(R[j * W + j]) > 0)) return;
        X[j * W + j] = 1 / R[j * W + j];
        for (int i = j - 1; i >= 0; --i) {
            for (int l = i + 1; l <= j; ++l) X[i * W + j] -= R[i * W + l] * X[l * W + j];
            X[i * W + j] /= R[i * W + i];
        }
    }
    for (int i = 0; i < W * W; ++i) squares[1] += X[i] * X[i];
    split->condition = sqrt(squares[0] * squares[1]);
}

/* The least x with J x = y, and F of least squares of J'F = x. */
static void mrts_least_joints(int joints, const mrts_split *split, const double *y, double *x) {
    enum { W = MRTS_SIZE };
    double in_basis[W] = {0};
    for (int l = 0; l < W; ++l) {
        for (int i = l; i < W; ++i) in_basis[i] += split->inverse[l * W + i] * y[l];
    }
    for (int r = 0; r < joints; ++r) x[r] = mrts_dot(W, split->Q + r * joints, in_basis);
}

/* The least x with J x = y but for directions that are lost at a condition number of `most`; returns that of J. One-sided
 * Jacobi rotations make its rows orthogonal; y stands behind them. */
static double mrts_regular_joints(int joints, const double *J, double most, const double *y, double *x) {
    enum { W = MRTS_SIZE };
    double rows[W][MRTS_MOST_JOINTS + 1], largest = 0, least = MRTS_INFINITY;
    for (int i = 0; i < W; ++i) {
        for (int l = 0; l < joints; ++l) rows[i][l] = J[l * W + i];
        rows[i][joints] = y[i];
    }
    for (int pair = 0; pair < MRTS_ROUNDS * W * W; ++pair) {
        double *a = rows[pair % W], *b = rows[pair / W % W];
        const double apart = mrts_dot(joints, b, b) - mrts_dot(joints, a, a);
        const double angle = atan2(2 * mrts_dot(joints, a, b), apart) / 2, c = cos(angle), s = sin(angle);
        for (int l = 0; l <= joints && a < b; ++l) {
            const double before = a[l];
            a[l] = c * before - s * b[l];
            b[l] = s * before + c * b[l];
        }
    }
    for (int i = 0; i < W; ++i) largest = fmax(largest, mrts_dot(joints, rows[i], rows[i]));
    for (int l = 0; l < joints; ++l) x[l] = 0;
    for (int i = 0; i < W; ++i) {
        const double square = mrts_dot(joints, rows[i], rows[i]);
        least = fmin(least, square);
        for (int l = 0; l < joints && square * most * most > largest; ++l) x[l] += rows[i][l] * rows[i][joints] / square;
    }
    return sqrt(largest / least);
}

#ifdef MRTS_REDUNDANT

/* h, h' and h'' of joint j at q. */
static double mrts_stretched(const mrts_preference *wish, int j, double q, double *slope, double *bend) {
    const double over = fmax((q - wish->upper[j]) / wish->zone[j] + 1, 0);
    const double under = fmax((wish->lower[j] - q) / wish->zone[j] + 1, 0);
    const double over3 = over * over * over, under3 = under * under * under;
    *slope = 1 + wish->push * 5 / wish->zone[j] * (over3 * over + under3 * under);
    *bend = wish->push * 20 / (wish->zone[j] * wish->zone[j]) * (over3 - under3);
    return q + wish->push * (over3 * over * over - under3 * under * under);
}

/* F of least squares of J'F = x. */
static void mrts_multipliers(int joints, const mrts_split *split, const double *x, double *F) {
    enum { W = MRTS_SIZE };
    for (int i = 0; i < W; ++i) F[i] = 0;
    for (int j = 0; j < W; ++j) {
        const double part = -mrts_less(joints, 0, split->Q + j, joints, x);
        for (int i = 0; i <= j; ++i) F[i] += split->inverse[i * W + j] * part;
    }
}

/* The Hessian in the basis of the null space, (joints - W, joints - W). */
static void mrts_reduced(int joints, const double *hessian, const double *Q, double *reduced) {
    enum { W = MRTS_SIZE };
    const int free = joints - W;
    for (int a = 0; a < free; ++a) {
        for (int b = 0; b < free; ++b) {
            reduced[a * free + b] = 0;
            for (int i = 0; i < joints; ++i) { /* less what H moves along a column of Q */
                reduced[a * free + b] -= Q[i * joints + W + a] * mrts_less(joints, 0, Q + W + b, joints, hessian + i * joints);
            }
        }
    }
}

/* Whether all eigenvalues of the symmetric part of a matrix, which is overwritten, are larger than `least`: then its
 * difference has a Cholesky factor. */
static int mrts_larger_than(int size, double *matrix, double least) {
    for (int i = 0; i < size; ++i) {
        for (int j = 0; j <= i; ++j) matrix[i * size + j] = (matrix[i * size + j] + matrix[j * size + i]) / 2;
        matrix[i * size + i] -= least;
    }
    mrts_cholesky(size, matrix, matrix);
    for (int j = 0; j < size; ++j) {
        if (!(matrix[j * size + j] < MRTS_INFINITY)) return 0;
    }
    return 1;
}

/* Adds to x, what the grasp wants of the joints, what makes hessian x = change + J'(anything); returns its length. */
static double mrts_add_preferred(int joints, const mrts_null_space *space, const double *change, double *x) {
    enum { W = MRTS_SIZE };
    const int free = joints - W;
    double reduced[MRTS_MOST_JOINTS * MRTS_MOST_JOINTS], y[MRTS_MOST_JOINTS] = {0};
    mrts_reduced(joints, space->hessian, space->split.Q, reduced);
    for (int i = 0; i < joints; ++i) {
        const double rest = change[i] - mrts_dot(joints, space->hessian + i * joints, x);
        for (int a = 0; a < free; ++a) y[a] += space->split.Q[i * joints + W + a] * rest;
    }
    if (!mrts_solve_square(free, reduced, y)) return MRTS_INFINITY;
    for (int i = 0; i < joints; ++i) x[i] += mrts_dot(free, space->split.Q + i * joints + W, y);
    return sqrt(mrts_dot(free, y, y));
}

/* The null spaces of the redundant arms at q, and their multipliers F of least squares. `fold` is the curvature of H at
 * which its minimum ends. */
static void mrts_null_spaces(const mrts_preference *wish, double fold, const double *geometry, const double *q,
                             const double *reference, const double *J_all, mrts_null_space *spaces, double *F) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double stiffness[M * M], slope[M], reduced[MRTS_MOST_JOINTS * MRTS_MOST_JOINTS], unused;
    double *const res[] = {stiffness};
    const double *const at[] = {q, F, geometry};
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
        mrts_null_space *space = spaces + robot;
        for (int i = 0; i < W; ++i) F[W * robot + i] = 0;
        if (joints <= W) continue;
        for (int i = 0; i < joints; ++i) {
            const double kept = mrts_stretched(wish, first + i, reference[first + i], &unused, &unused);
            space->gradient[i] = mrts_stretched(wish, first + i, q[first + i], slope + first + i, space->bend + i) - kept;
        }
        mrts_split_joints(joints, J_all + W * first, &space->split);
        mrts_multipliers(joints, &space->split, space->gradient, F + W * robot);
    }
    MRTS_GEOMETRIC_STIFFNESS(at, res);
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
        mrts_null_space *space = spaces + robot;
        if (joints <= W) continue;
        for (int i = 0; i < joints; ++i) {
            for (int j = 0; j < joints; ++j) {
                const double own = i == j ? slope[first + i] : 0;
                space->hessian[i * joints + j] = own - stiffness[(first + j) * M + first + i];
            }
        }
        mrts_reduced(joints, space->hessian, space->split.Q, reduced);
        space->folds = !mrts_larger_than(joints - W, reduced, fold);
        for (int i = 0; space->folds && i < joints * joints; ++i) {
            space->hessian[i] = i % (joints + 1) == 0 ? slope[first + i / joints] : 0;
        }
    }
}

/* hessian q'' - J'F'' of the redundant arms, Shape (M,), from the second derivative of h(q) - h(reference) = J'F. */
static void mrts_change_along(const double *geometry, const double *q, const double *dq, const mrts_null_space *spaces,
                              const double *F, double *change) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double stiffness[M * M], dF[W * R] = {0}, torque[MRTS_MOST_JOINTS];
    const double *const moving[] = {q, dq, F, geometry}, *const at[] = {q, dF, geometry};
    double *const changes[] = {change}, *const stiffnesses[] = {stiffness};
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
        if (joints <= W) continue;
        for (int i = 0; i < joints; ++i) torque[i] = mrts_dot(joints, spaces[robot].hessian + i * joints, dq + first);
        mrts_multipliers(joints, &spaces[robot].split, torque, dF + W * robot);
    }
    MRTS_GEOMETRIC_STIFFNESS_RATE(moving, changes);
    MRTS_GEOMETRIC_STIFFNESS(at, stiffnesses);
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), last = MRTS_FIRST(robot + 1);
        if (last - first <= W) continue;
        for (int i = first; i < last; ++i) {
            for (int j = first; j < last; ++j) change[i] += 2 * stiffness[j * M + i] * dq[j];
            change[i] -= spaces[robot].bend[i - first] * dq[i] * dq[i];
        }
    }
}
#endif

/* Inverse kinematics at a sample: damped Newton steps (Sugihara, Solvability-unconcerned inverse kinematics by
 * the Levenberg-Marquardt method, IEEE Transactions on Robotics 27, 2011), and, for arms with more joints than wrench
 * components, those that are preferred. */

/* How the arms of a cell hold their grasps and follow. */
typedef struct {
    int start_steps;            /* most Newton steps from the posture to the grasp at the first sample */
    int further_steps;          /* from each of the starts that are tried where it leads to nothing */
    int steps;                  /* at a sample */
    double reached;             /* remaining error at which a grasp counts as held [m, rad] */
    double condition;           /* of a Jacobian, at which an arm is singular */
    double drift;               /* step left to a redundant arm that is not settled [rad or m] */
    double past;                /* how far a joint may pass its limit [rad or m] */
    int components[6];          /* rows of a six-component twist that this cell uses */
    mrts_preference wish;       /* of redundant arms */
    const unsigned char *turns; /* whether whole turns of a joint are the same position, (joints) */
    const double *geometry;     /* of a variant its own */
} mrts_tracking;

/* Largest joint step at which the iteration ends: what is left is rounding; the largest that is made, so that a far start
 * does not leap over its branch; the largest correction of a prediction: beyond it the branch is another [rad or m]. */
#define MRTS_SETTLED 1e-12
#define MRTS_LONGEST 0.3
#define MRTS_JUMP 0.5

/* Curvature of H on the set that holds the grasp (1 far from limits on a flat set) below which its minimum ends. */
#define MRTS_FOLD 1e-3

/* The object at one sample; the rotation by rows. */
typedef struct {
    const double *position, *rotation, *twist, *acceleration;
} mrts_path;

/* How the arms hold their grasps at a sample. */
typedef struct {
    double gap[MRTS_ROBOTS], turn[MRTS_ROBOTS]; /* remaining errors, or larger [m, rad] */
    double jump[MRTS_ROBOTS];                   /* largest difference of a joint from Taylor's prediction [rad or m] */
    double condition[MRTS_ROBOTS];              /* of the Jacobian; a bound where that is below the limit */
    double drift[MRTS_ROBOTS];                  /* step still to go of a redundant arm [rad or m] */
    int folds[MRTS_ROBOTS];                     /* whether the positions that it prefers end here */
} mrts_held;

/* Sine of an angle below which a turn has no axis: it is none, or half a turn. */
#define MRTS_NO_TURN 1e-9

/* Damping, as a share of the trace of J J', of a step that has no other where that is singular. */
#define MRTS_LEAST_DAMPING 1e-14

/* R'v of a rotation matrix by rows. */
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

/* Velocity and acceleration of a grasp in base axes and cell components. */
static void mrts_tip_rates(const mrts_tracking *task, const mrts_arm *arm, const double *rotation, const double *twist,
                           const double *acceleration, double *velocity, double *change) {
    double v[3], a[3], six[6];
    mrts_object_point(rotation, twist, acceleration, arm->tip_position, v, a);
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
    for (int i = 0; i < 3; ++i) {
        off[i] = mrts_dot(3, rotation + 3 * i, arm->tip_position) + (position[i] - tip[i]);
        for (int j = 0; j < 3; ++j) {
            target[3 * i + j] = rotation[3 * i] * arm->tip_rotation[j] + rotation[3 * i + 1] * arm->tip_rotation[3 + j] +
                                rotation[3 * i + 2] * arm->tip_rotation[6 + j];
        }
    }
    mrts_turn_between(target, tip_rotation, turned);
    *gap = sqrt(off[0] * off[0] + off[1] * off[1] + off[2] * off[2]);
    *turn = sqrt(turned[0] * turned[0] + turned[1] * turned[1] + turned[2] * turned[2]);
}

/* Error of an arm's tip in base axes and cell components; returns the damping that it wants. */
static double mrts_arm_error(const mrts_tracking *task, const mrts_arm *arm, const double *off, const double *turned,
                             double *error) {
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
        if (mrts_solve_square(W, square, weight)) break;
        damping = MRTS_LEAST_DAMPING * trace;
    }
    for (int l = 0; l < joints; ++l) step[l] = mrts_dot(W, J + l * W, weight);
}

/* Joint positions with the smallest errors met from `now` on, which is moved; of those that hold a grasp with a redundant
 * arm, those with the smallest step still to go. Without a reference redundant arms move no further than needed. Arms that
 * are left out stay. */
static void mrts_hold_grasps(const mrts_tracking *task, int steps, const double *position, const double *rotation,
                             const double *reference, const unsigned char *left_out, double *now, double *best, double *gap,
                             double *turn, double *drift) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double tips[3 * R], rotations[9 * R], J_all[W * M], off[3], turned[3], error[W], step[M], least[R];
    const double *const at[] = {now, task->geometry};
    double *const poses[] = {tips, rotations, J_all};
    for (int robot = 0; robot < R; ++robot) gap[robot] = turn[robot] = drift[robot] = least[robot] = MRTS_INFINITY;
    for (int i = 0; i < M; ++i) best[i] = now[i];
    for (int iteration = 0; iteration < steps; ++iteration) {
        double largest = 0, farthest = 0;
        MRTS_KINEMATICS(at, poses);
#ifdef MRTS_REDUNDANT
        mrts_null_space spaces[R];
        double F[W * R], fall[MRTS_MOST_JOINTS];
        if (reference) mrts_null_spaces(&task->wish, MRTS_FOLD, task->geometry, now, reference, J_all, spaces, F);
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
            const double share = longest > MRTS_LONGEST ? MRTS_LONGEST / longest : 1;
            for (int i = 0; i < joints; ++i) q[i] += share * step[i];
            largest = fmax(largest, longest);
        }
        if (largest <= MRTS_SETTLED && farthest <= task->reached) break; /* farther away, rounding leaves a saddle */
    }
}

/* Adds the least to the rates of an arm's joints that makes J rate = wanted, of a singular arm what it still can; returns
 * the condition number of J, or a bound below the limit. */
static double mrts_add_least(const mrts_tracking *task, int joints, const double *J, const mrts_split *split,
                             const double *wanted, double *rate) {
    enum { W = MRTS_SIZE };
    double left[W], step[MRTS_MOST_JOINTS], condition = split->condition;
    for (int i = 0; i < W; ++i) left[i] = mrts_less(joints, wanted[i], J + i, W, rate);
    if (condition < task->condition) mrts_least_joints(joints, split, left, step);
    else condition = mrts_regular_joints(joints, J, task->condition, left, step);
    for (int l = 0; l < joints; ++l) rate[l] += step[l];
    return condition;
}

/* The nearest to given rates with J q' = v and J q'' = a - J' q'; of redundant arms with a reference what is preferred. */
static void mrts_joint_rates(const mrts_tracking *task, const mrts_path *at, const double *reference,
                             const unsigned char *left_out, const double *q, double *dq, double *ddq, mrts_held *held) {
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
    if (reference) mrts_null_spaces(&task->wish, MRTS_FOLD, task->geometry, q, reference, J_all, spaces, F);
#else
    (void)reference;
#endif
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
        const double *J = J_all + W * first;
        held->folds[robot] = 0;
        if (left_out[robot]) continue;
        mrts_split_joints(joints, J, splits + robot);
        mrts_tip_rates(task, MRTS_ARM(task->geometry, robot), at->rotation, at->twist, at->acceleration, velocity,
                       wanted + W * robot);
        held->condition[robot] = mrts_add_least(task, joints, J, splits + robot, velocity, dq + first);
#ifdef MRTS_REDUNDANT
        if (reference && joints > W) {
            mrts_add_preferred(joints, spaces + robot, nothing, dq + first);
            held->folds[robot] = spaces[robot].folds;
        }
#endif
    }
    MRTS_BIAS_ACCELERATION(moving, biases);
#ifdef MRTS_REDUNDANT
    if (reference) mrts_change_along(task->geometry, q, dq, spaces, F, change);
#endif
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
        if (left_out[robot]) continue;
        for (int i = W * robot; i < W * (robot + 1); ++i) wanted[i] -= bias[i];
        mrts_add_least(task, joints, J_all + W * first, splits + robot, wanted + W * robot, ddq + first);
#ifdef MRTS_REDUNDANT
        if (reference && joints > W) mrts_add_preferred(joints, spaces + robot, change + first, ddq + first);
#endif
    }
}

/* One sample from joints that are predicted well takes one evaluation of the kinematics, one factorisation of each arm. */

/* Largest step [rad or m] after which the Jacobian before it counts as that after it: its share of an error of q'. */
#define MRTS_FINE 1e-11

/* Steps of the fast iteration; what takes more is left to the rule of tracking.c. */
enum { MRTS_QUICK = 4 };

#ifndef MRTS_UNEVEN

/* A Jacobian as the product of two triangles, for arms with as many joints as wrench components. */
typedef struct {
    double triangles[MRTS_SIZE * MRTS_SIZE];
    int row[MRTS_SIZE]; /* of the Jacobian, of each row of theirs */
} mrts_factors;

/* Factors J, by columns. Returns a bound of its condition number by its determinant (H.
 * Guggenheimer, A. Edelman, C. Johnson, A simple estimate of the condition number of a linear system, The College
 * Mathematics Journal 26, 1995), infinite where it is singular. */
static double mrts_factor_jacobian(const double *J, mrts_factors *factors) {
    enum { W = MRTS_SIZE };
    double *LU = factors->triangles, square = 0, determinant = 1;
    for (int i = 0; i < W; ++i) {
        factors->row[i] = i;
        for (int j = 0; j < W; ++j) {
            LU[i * W + j] = J[j * W + i];
            square += J[j * W + i] * J[j * W + i];
        }
    }
    mrts_factor(W, factors->row, LU);
    for (int i = 0; i < W; ++i) determinant /= LU[i * (W + 1)] * LU[i * (W + 1)] * square / W;
    return 2 / sqrt(determinant);
}

static void mrts_solve_jacobian(const mrts_factors *factors, const double *y, double *x) {
    for (int i = 0; i < MRTS_SIZE; ++i) x[i] = y[factors->row[i]];
    mrts_solve(MRTS_SIZE, factors->triangles, x);
}

/* q, q', q'' at a sample by undamped Newton steps from `now`, which is moved; 0 where they do not lead to the grasps at
 * once. Arms that are left out stay. */
static int mrts_quick_sample(const mrts_tracking *task, const mrts_path *at, const unsigned char *left_out, double *now,
                             double *dq, double *ddq, mrts_held *held) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double tips[3 * R], rotations[9 * R], J[W * M], off[3], turned[3], error[W], step[W], change[W * R], bias[W * R];
    const double *const given[] = {now, task->geometry}, *const moving[] = {now, dq, task->geometry};
    double *const poses[] = {tips, rotations, J}, *const biases[] = {bias};
    mrts_factors factors[R];
    for (int iteration = 0; iteration < MRTS_QUICK; ++iteration) {
        double largest = 0, furthest = 0;
        MRTS_KINEMATICS(given, poses);
        for (int robot = 0; robot < R; ++robot) {
            const mrts_arm *arm = MRTS_ARM(task->geometry, robot);
            if (left_out[robot]) continue;
            mrts_tip_error(arm, at->position, at->rotation, tips + 3 * robot, rotations + 9 * robot, off, turned,
                           held->gap + robot, held->turn + robot);
            mrts_arm_error(task, arm, off, turned, error);
            held->condition[robot] = mrts_factor_jacobian(J + W * W * robot, factors + robot);
            if (!(held->condition[robot] < task->condition)) return 0;
            if (!(fmax(held->gap[robot], held->turn[robot]) <= furthest)) furthest = fmax(held->gap[robot], held->turn[robot]);
            mrts_solve_jacobian(factors + robot, error, step);
            for (int i = 0; i < W; ++i) {
                now[W * robot + i] += step[i];
                if (!(fabs(step[i]) <= largest)) largest = fabs(step[i]);
            }
        }
        if (!(largest <= MRTS_LONGEST)) return 0;
        if (largest > MRTS_FINE || !(furthest <= task->reached)) continue;
        for (int robot = 0; robot < R; ++robot) {
            double velocity[W];
            held->drift[robot] = 0;
            held->folds[robot] = 0;
            if (left_out[robot]) continue;
            mrts_tip_rates(task, MRTS_ARM(task->geometry, robot), at->rotation, at->twist, at->acceleration, velocity,
                           change + W * robot);
            mrts_solve_jacobian(factors + robot, velocity, dq + W * robot);
        }
        MRTS_BIAS_ACCELERATION(moving, biases);
        for (int robot = 0; robot < R; ++robot) {
            if (left_out[robot]) continue;
            for (int i = W * robot; i < W * (robot + 1); ++i) change[i] -= bias[i];
            mrts_solve_jacobian(factors + robot, change + W * robot, ddq + W * robot);
        }
        return 1;
    }
    return 0;
}

#endif

/* How far the prediction from two samples may be from that of one [rad or m]: beyond, something jumps. */
#define MRTS_SMOOTH 1e-2

/* Relative difference of two steps of time that is rounding. */
#define MRTS_SAME_STEP 1e-9

/* q at a sample from q, q', q'' at those before it, a step h apart each: the polynomial through the last three of them.
 * Taylor's of second degree from the last one where fewer are known, or where the two differ. */
static void mrts_predict(const double *q, const double *dq, const double *ddq, double h, long long known,
                         const unsigned char *left_out, double *taylor, double *now) {
    enum { M = MRTS_JOINTS };
    double apart = 0;
    for (int robot = 0; robot < MRTS_ROBOTS; ++robot) {
        for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1); ++i) {
            const double b = q[i], b1 = h * dq[i], b2 = h * h * ddq[i];
            now[i] = taylor[i] = left_out[robot] ? b : b + b1 + b2 / 2;
            if (known < 3 || left_out[robot]) continue;
            const double a = q[i - M], a1 = h * dq[i - M], a2 = h * h * ddq[i - M];
            const double z = q[i - 2 * M], z1 = h * dq[i - 2 * M], z2 = h * h * ddq[i - 2 * M];
            now[i] = b + 228.5 * (b - a) - 122.5 * (a - z) - 94.5 * b1 - 54 * a1 + 43.5 * z1 + 13.5 * b2 - 54 * a2 + 4.5 * z2;
            apart = fmax(apart, fabs(now[i] - taylor[i]));
        }
    }
    for (int i = 0; i < M && !(apart <= MRTS_SMOOTH); ++i) now[i] = taylor[i];
}

/* How far each arm's joints are from Taylor's prediction; returns the farthest. */
static double mrts_note_jumps(const double *q, const double *taylor, mrts_held *held) {
    double farthest = 0;
    for (int robot = 0; robot < MRTS_ROBOTS; ++robot) {
        held->jump[robot] = 0;
        for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1); ++i) {
            held->jump[robot] = fmax(held->jump[robot], fabs(q[i] - taylor[i]));
        }
        farthest = fmax(farthest, held->jump[robot]);
    }
    return farthest;
}

/* Sample n of a path: q, q', q'' of all arms, which lie behind those of the samples before it, or, at the first one,
 * from positions in q that hold the grasps. `even` counts the steps of one length that lead here. What is held tells of
 * arms that cannot follow. Those that are left out stay. */
static void mrts_track_sample(const mrts_tracking *task, const double *time, const mrts_path *path, long long n,
                              const double *reference, const unsigned char *left_out, long long *even, double *q,
                              double *dq, double *ddq, mrts_held *held) {
    enum { M = MRTS_JOINTS };
    const mrts_path at = {path->position + 3 * n, path->rotation + 9 * n, path->twist + 6 * n, path->acceleration + 6 * n};
    double taylor[M], now[M];
    for (int i = 0; i < M; ++i) dq[i] = ddq[i] = 0;
    if (n == 0) {
        for (int i = 0; i < M; ++i) taylor[i] = q[i];
    } else {
        const double h = time[n] - time[n - 1];
        *even = n > 1 && fabs(time[n - 1] - time[n - 2] - h) <= MRTS_SAME_STEP * h ? *even + 1 : 1;
        mrts_predict(q - M, dq - M, ddq - M, h, *even, left_out, taylor, q);
    }
#ifndef MRTS_UNEVEN
    if (mrts_quick_sample(task, &at, left_out, q, dq, ddq, held) && mrts_note_jumps(q, taylor, held) <= MRTS_JUMP) {
        return;
    }
#endif
    for (int i = 0; i < M; ++i) now[i] = taylor[i];
    mrts_hold_grasps(task, task->steps, at.position, at.rotation, reference, left_out, now, q, held->gap, held->turn,
                     held->drift);
    mrts_joint_rates(task, &at, reference, left_out, q, dq, ddq, held);
    mrts_note_jumps(q, taylor, held);
}

/* How following ends for an arm. */
enum {
    MRTS_FOLLOWED = 0,
    MRTS_NO_START = 1,     /* no start leads to the grasp at the first sample; amounts: the least errors [m, rad] */
    MRTS_START_PAST = 2,   /* those that do are past a limit of a joint; amount: its position */
    MRTS_OUT_OF_REACH = 3, /* amounts: remaining errors [m, rad] */
    MRTS_LOST = 4,         /* it would have to jump; amount: how far [rad or m] */
    MRTS_FOLDED = 5,       /* the positions that a redundant arm prefers end */
    MRTS_SINGULAR = 6,     /* amount: condition number */
    MRTS_PAST_LIMIT = 7,   /* of a joint, of an arm that is followed to the end; amount: its position */
    MRTS_LEFT_LIMITS = 8,  /* a redundant arm, which then failed; amount: the joint's position */
    MRTS_REFUSED = 9       /* by the caller: passed over */
};

typedef struct {
    int code, sample, joint; /* the joint counted in its arm */
    int start;               /* which led to the grasp: 0 the posture, then the further ones */
    double amount[2];
} mrts_outcome;

#define MRTS_TURN 6.283185307179586

/* What to add to the positions of a joint along a path, from `low` to `high`, to bring them inside its limits by whole
 * turns; 0 where that does not help. */
static double mrts_turns_inside(double low, double high, double lower, double upper, double past) {
    const double turn = MRTS_TURN, down = ceil((high - upper) / turn - past), up = ceil((lower - low) / turn - past);
    double moved = 0;
    if (down > 0 && low - turn * down >= lower - past) moved -= turn * down;
    if (up > 0 && high + turn * up <= upper + past) moved += turn * up;
    return moved;
}

/* Moves the paths of an arm's joints, some samples long, inside their limits by whole turns, where they may turn and that
 * does it; tells of the first sample at which one is still past a limit. */
static void mrts_past_limits(const mrts_tracking *task, long long samples, int turns, int robot, double *q,
                             mrts_outcome *outcome) {
    enum { M = MRTS_JOINTS };
    long long earliest = samples;
    for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1) && samples > 0; ++i) {
        const double lower = task->wish.lower[i], upper = task->wish.upper[i];
        double low = MRTS_INFINITY, high = -MRTS_INFINITY, moved = 0;
        for (long long n = 0; n < samples; ++n) {
            low = fmin(low, q[n * M + i]);
            high = fmax(high, q[n * M + i]);
        }
        if (turns && task->turns[i]) moved = mrts_turns_inside(low, high, lower, upper, task->past);
        for (long long n = 0; moved != 0 && n < samples; ++n) q[n * M + i] += moved;
        if (fmax(lower - low - moved, high + moved - upper) <= task->past) continue;
        for (long long n = 0; n < earliest; ++n) {
            const double at = q[n * M + i];
            if (!(fmax(lower - at, at - upper) > task->past)) continue;
            *outcome = (mrts_outcome){MRTS_PAST_LIMIT, (int)n, i - MRTS_FIRST(robot), outcome->start, {at, 0}};
            earliest = n;
        }
    }
}

/* What has been found of one arm's start: the nearest positions that hold the grasp, and of the others why not. */
typedef struct {
    double distance, q[MRTS_JOINTS];
    double gap, turn;
    int attempt;
    mrts_outcome past; /* of the first that are past a limit */
} mrts_start;

static void mrts_take_start(const mrts_tracking *task, int robot, const double *posture, const double *found, double gap,
                            double turn, int attempt, mrts_start *start) {
    const int first = MRTS_FIRST(robot), end = MRTS_FIRST(robot + 1);
    double q[MRTS_JOINTS], distance = 0;
    mrts_outcome past = {MRTS_FOLLOWED, 0, 0, 0, {0, 0}};
    if (fmax(gap, turn) < fmax(start->gap, start->turn)) {
        start->gap = gap;
        start->turn = turn;
    }
    if (!(fmax(gap, turn) <= task->reached)) return;
    for (int i = first; i < end; ++i) q[i] = found[i];
    mrts_past_limits(task, 1, 1, robot, q, &past);
    if (past.code != MRTS_FOLLOWED) {
        if (start->past.code == MRTS_FOLLOWED) start->past = past;
        return;
    }
    for (int i = first; i < end; ++i) {
        const double away = found[i] - posture[i] + MRTS_TURN / 2;
        q[i] = found[i];
        if (attempt && task->turns[i]) q[i] = posture[i] + (away - MRTS_TURN * floor(away / MRTS_TURN)) - MRTS_TURN / 2;
    }
    if (attempt) mrts_past_limits(task, 1, 1, robot, q, &past);
    for (int i = first; i < end && attempt; ++i) distance = fmax(distance, fabs(q[i] - posture[i]));
    if (distance >= start->distance) return;
    start->distance = distance;
    start->attempt = attempt;
    for (int i = first; i < end; ++i) start->q[i] = q[i];
}

/* Joints that hold the grasps at the first sample, near the posture; 0 where an arm has none. The first search begins at
 * the posture; `further` are the starts that follow where that leads to nothing, (more, joints). */
static int mrts_find_start(const mrts_tracking *task, const mrts_path *at, const double *posture, int more,
                           const double *further, double *q, mrts_outcome *outcome) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS };
    double now[M], reference[M], gap[R], turn[R], drift[R], found[M];
    unsigned char done[R] = {0};
    mrts_start start[R];
    int lost = R;
    for (int robot = 0; robot < R; ++robot) {
        start[robot].distance = start[robot].gap = start[robot].turn = MRTS_INFINITY;
        start[robot].past.code = MRTS_FOLLOWED;
    }
    for (int i = 0; i < M; ++i) reference[i] = fmin(fmax(posture[i], task->wish.lower[i]), task->wish.upper[i]);
    for (int attempt = 0; attempt <= more && lost; ++attempt) {
        for (int i = 0; i < M; ++i) now[i] = attempt ? further[(attempt - 1) * M + i] : posture[i];
        const int steps = attempt ? task->further_steps : task->start_steps;
        mrts_hold_grasps(task, steps, at->position, at->rotation, reference, done, now, found, gap, turn, drift);
        for (int robot = 0; robot < R; ++robot) {
            if (done[robot]) continue;
            mrts_take_start(task, robot, posture, found, gap[robot], turn[robot], attempt, start + robot);
            done[robot] = start[robot].distance == 0;
            lost -= done[robot];
        }
    }
    for (int robot = 0; robot < R; ++robot) {
        const mrts_start *of = start + robot;
        outcome[robot] = (mrts_outcome){MRTS_FOLLOWED, 0, 0, of->attempt, {0, 0}};
        if (of->distance < MRTS_INFINITY) {
            for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1); ++i) q[i] = of->q[i];
            continue;
        }
        lost = -1;
        outcome[robot] = of->past;
        if (of->past.code == MRTS_PAST_LIMIT) outcome[robot].code = MRTS_START_PAST;
        else outcome[robot] = (mrts_outcome){MRTS_NO_START, 0, 0, 0, {of->gap, of->turn}};
    }
    return lost >= 0;
}

static void mrts_note_failure(const mrts_tracking *task, const mrts_held *held, int robot, int sample,
                              mrts_outcome *outcome) {
    const double jump = held->jump[robot], condition = held->condition[robot];
    const double gap = held->gap[robot], turn = held->turn[robot];
    mrts_outcome found = {MRTS_FOLLOWED, sample, 0, outcome->start, {0, 0}};
    if (!(fmax(gap, turn) <= task->reached)) {
        found.code = MRTS_OUT_OF_REACH;
        found.amount[0] = gap;
        found.amount[1] = turn;
    } else if (!(held->drift[robot] <= task->drift)) {
        found.code = MRTS_FOLDED;
    } else if (jump > MRTS_JUMP) {
        found.code = MRTS_LOST;
        found.amount[0] = jump;
    } else if (!(condition < task->condition)) {
        found.code = MRTS_SINGULAR;
        found.amount[0] = condition;
    } else if (held->folds[robot]) {
        found.code = MRTS_FOLDED;
    }
    if (found.code != MRTS_FOLLOWED) *outcome = found;
}

/* Follows one variant from its start: q, q', q'' of all samples, and how that ends for each arm. One that fails is not
 * looked at again. */
static void mrts_follow_one(const mrts_tracking *task, long long samples, const double *time, const mrts_path *path,
                            double *q, double *dq, double *ddq, mrts_outcome *outcome) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS };
    double reference[M];
    unsigned char failed[R] = {0};
    mrts_held held;
    long long even = 0;
    int left = R;
    for (int i = 0; i < M; ++i) reference[i] = q[i];
    for (long long n = 0; n < samples && left; ++n) {
        const long long at = n * M;
        mrts_track_sample(task, time, path, n, reference, failed, &even, q + at, dq + at, ddq + at, &held);
        for (int robot = 0; robot < R; ++robot) {
            if (failed[robot]) continue;
            mrts_note_failure(task, &held, robot, (int)n, outcome + robot);
            failed[robot] = outcome[robot].code != MRTS_FOLLOWED;
            left -= failed[robot];
            if (failed[robot] && MRTS_FIRST(robot + 1) - MRTS_FIRST(robot) > MRTS_SIZE) {
                /* between its limits a redundant arm fails soon after it passed one, which is then the reason */
                mrts_past_limits(task, n, 0, robot, q, outcome + robot);
                if (outcome[robot].code == MRTS_PAST_LIMIT) outcome[robot].code = MRTS_LEFT_LIMITS;
            }
        }
    }
    for (int robot = 0; robot < R; ++robot) {
        if (!failed[robot]) mrts_past_limits(task, samples, 1, robot, q, outcome + robot);
    }
}

/* Follows variants 0 .. count - 1, each of the same number of samples. Arrays are of all variants one after the other;
 * a stride, in reals from one variant to the next, is 0 where they share one. Outcomes are of each arm of each variant;
 * variants of which the first has MRTS_REFUSED are passed over. `further` starts are tried after the postures; -1 where these
 * hold the grasps. */
MRTS_EXPORT void mrts_follow(long long count, long long samples, const mrts_tracking *task, int further,
                             const double *const *given, const long long *stride, double *q, double *dq, double *ddq,
                             mrts_outcome *outcome) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS };
    enum { TIME, POSITION, ROTATION, TWIST, ACCELERATION, GEOMETRY, POSTURE, FURTHER, GIVEN };
    mrts_tracking here = *task;
    for (long long v = 0; v < count; ++v, outcome += R) {
        const double *of[GIVEN] = {0};
        const long long first = v * samples * M;
        if (outcome->code == MRTS_REFUSED) continue;
        for (int i = 0; i < (further > 0 ? GIVEN : FURTHER); ++i) of[i] = given[i] + v * stride[i];
        const mrts_path path = {of[POSITION], of[ROTATION], of[TWIST], of[ACCELERATION]};
        here.geometry = of[GEOMETRY];
        for (int i = 0; i < M; ++i) q[first + i] = of[POSTURE][i];
        if (further < 0 || mrts_find_start(&here, &path, of[POSTURE], further, of[FURTHER], q + first, outcome)) {
            mrts_follow_one(&here, samples, of[TIME], &path, q + first, dq + first, ddq + first, outcome);
        }
    }
}

/* Joints that hold the grasps at one sample each, (count, joints): from q on, and the rates nearest to those given, which
 * they replace. Of references and of rates there may be none; strides as above. */
MRTS_EXPORT void mrts_hold(long long count, const mrts_tracking *task, int steps, const double *const *given,
                           const long long *stride, double *q, double *dq, double *ddq, double *gap, double *turn,
                           double *drift) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, POSITION = 0, ROTATION, TWIST, ACCELERATION, REFERENCE, GIVEN };
    const unsigned char left_out[R] = {0};
    mrts_held held;
    for (long long n = 0; n < count; ++n, q += M, gap += R, turn += R, drift += R) {
        const double *of[GIVEN];
        double now[M];
        for (int i = 0; i < GIVEN; ++i) of[i] = given[i] ? given[i] + n * stride[i] : given[i];
        const mrts_path at = {of[POSITION], of[ROTATION], of[TWIST], of[ACCELERATION]};
        for (int i = 0; i < M; ++i) now[i] = q[i];
        mrts_hold_grasps(task, steps, at.position, at.rotation, of[REFERENCE], left_out, now, q, gap, turn, drift);
        if (dq) mrts_joint_rates(task, &at, 0, left_out, q, dq + n * M, ddq + n * M, &held);
    }
}

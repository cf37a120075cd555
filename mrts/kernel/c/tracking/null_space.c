/* SPDX-License-Identifier: MIT
 *
 * The joints of an arm by its Jacobian: those that its grasp takes, and what redundant arms prefer in the others.
 */
#include "null_space.h"

/* Share of the product of two lengths below which vectors are orthogonal, and the most rounds that make them so. */
#define MRTS_ORTHOGONAL 1e-15
enum { MRTS_ROUNDS = 30 };

MRTS_LOCAL int mrts_eliminate(int size, double *matrix, double *rhs) {
    for (int j = 0; j < size; ++j) {
        int p = j;
        for (int i = j + 1; i < size; ++i) {
            if (fabs(matrix[i * size + j]) > fabs(matrix[p * size + j])) p = i;
        }
        if (!(fabs(matrix[p * size + j]) > 0)) return 0;
        if (p != j) {
            double t = rhs[j];
            rhs[j] = rhs[p];
            rhs[p] = t;
            for (int l = j; l < size; ++l) {
                t = matrix[j * size + l];
                matrix[j * size + l] = matrix[p * size + l];
                matrix[p * size + l] = t;
            }
        }
        for (int i = j + 1; i < size; ++i) {
            const double factor = matrix[i * size + j] / matrix[j * size + j];
            if (factor == 0) continue;
            for (int l = j + 1; l < size; ++l) matrix[i * size + l] -= factor * matrix[j * size + l];
            rhs[i] -= factor * rhs[j];
        }
    }
    for (int i = size - 1; i >= 0; --i) {
        for (int l = i + 1; l < size; ++l) rhs[i] -= matrix[i * size + l] * rhs[l];
        rhs[i] /= matrix[i * size + i];
    }
    return 1;
}

MRTS_LOCAL void mrts_split_joints(int joints, const double *J, mrts_split *split) {
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

MRTS_LOCAL void mrts_least_joints(int joints, const mrts_split *split, const double *y, double *x) {
    enum { W = MRTS_SIZE };
    double in_basis[W] = {0};
    for (int l = 0; l < W; ++l) {
        for (int i = l; i < W; ++i) in_basis[i] += split->inverse[l * W + i] * y[l];
    }
    for (int r = 0; r < joints; ++r) x[r] = mrts_dot(W, split->Q + r * joints, in_basis);
}

MRTS_LOCAL double mrts_condition(int joints, const double *J) {
    enum { W = MRTS_SIZE };
    double row[W][MRTS_MOST_JOINTS], most = 0, least = MRTS_INFINITY;
    int turned = 1;
    for (int i = 0; i < W; ++i) {
        for (int l = 0; l < joints; ++l) row[i][l] = J[l * W + i];
    }
    for (int round = 0; round < MRTS_ROUNDS && turned; ++round) {
        turned = 0;
        for (int i = 0; i < W; ++i) {
            for (int j = i + 1; j < W; ++j) {
                const double a = mrts_dot(joints, row[i], row[i]), b = mrts_dot(joints, row[j], row[j]);
                const double both = mrts_dot(joints, row[i], row[j]);
                if (!(fabs(both) > MRTS_ORTHOGONAL * sqrt(a * b))) continue;
                const double cotangent = (b - a) / (2 * both);
                const double t = (cotangent < 0 ? -1 : 1) / (fabs(cotangent) + sqrt(1 + cotangent * cotangent));
                const double c = 1 / sqrt(1 + t * t), s = c * t;
                turned = 1;
                for (int l = 0; l < joints; ++l) {
                    const double x = row[i][l];
                    row[i][l] = c * x - s * row[j][l];
                    row[j][l] = s * x + c * row[j][l];
                }
            }
        }
    }
    for (int i = 0; i < W; ++i) {
        const double square = mrts_dot(joints, row[i], row[i]);
        most = fmax(most, square);
        least = fmin(least, square);
    }
    return least > 0 ? sqrt(most / least) : MRTS_INFINITY;
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
        double part = 0;
        for (int r = 0; r < joints; ++r) part += split->Q[r * joints + j] * x[r];
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
            for (int i = 0; i < joints; ++i) {
                double along = 0;
                for (int j = 0; j < joints; ++j) along += hessian[i * joints + j] * Q[j * joints + W + b];
                reduced[a * free + b] += Q[i * joints + W + a] * along;
            }
        }
    }
}

/* Whether all eigenvalues of the symmetric part of a matrix, which is overwritten, are larger than `least`: then all
 * pivots of its difference are positive. */
static int mrts_larger_than(int size, double *matrix, double least) {
    for (int i = 0; i < size; ++i) {
        for (int j = 0; j <= i; ++j) matrix[i * size + j] = (matrix[i * size + j] + matrix[j * size + i]) / 2;
        matrix[i * size + i] -= least;
    }
    for (int j = 0; j < size; ++j) {
        if (!(matrix[j * size + j] > 0)) return 0;
        for (int i = size - 1; i > j; --i) {
            const double factor = matrix[i * size + j] / matrix[j * size + j];
            for (int l = j + 1; l <= i; ++l) matrix[i * size + l] -= factor * matrix[l * size + j];
        }
    }
    return 1;
}

MRTS_LOCAL double mrts_add_preferred(int joints, const mrts_null_space *space, const double *change, double *x) {
    enum { W = MRTS_SIZE };
    const int free = joints - W;
    double reduced[MRTS_MOST_JOINTS * MRTS_MOST_JOINTS], y[MRTS_MOST_JOINTS] = {0};
    mrts_reduced(joints, space->hessian, space->split.Q, reduced);
    for (int i = 0; i < joints; ++i) {
        const double rest = change[i] - mrts_dot(joints, space->hessian + i * joints, x);
        for (int a = 0; a < free; ++a) y[a] += space->split.Q[i * joints + W + a] * rest;
    }
    if (!mrts_eliminate(free, reduced, y)) return MRTS_INFINITY;
    for (int i = 0; i < joints; ++i) x[i] += mrts_dot(free, space->split.Q + i * joints + W, y);
    return sqrt(mrts_dot(free, y, y));
}

MRTS_LOCAL void mrts_null_spaces(const mrts_preference *wish, double fold, const double *geometry, const double *q,
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

MRTS_LOCAL void mrts_change_along(const double *geometry, const double *q, const double *dq, const mrts_null_space *spaces,
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

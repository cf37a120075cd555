/* SPDX-License-Identifier: MIT
 *
 * The null spaces of redundant arms and what they prefer in them. Empty where no arm is redundant.
 */
#include "null_space.h"

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

/* Solves a square system in place by elimination with row exchanges; returns its determinant, 0 if it is singular. */
static double mrts_solve(int size, double *matrix, double *rhs) {
    double determinant = 1;
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
            determinant = -determinant;
        }
        determinant *= matrix[j * size + j];
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
    return determinant;
}

MRTS_LOCAL double mrts_preferred(int joints, const double *J, const mrts_null_space *space, double damping,
                                 const double *along, const double *change, double *x, double *F) {
    enum { W = MRTS_SIZE, MOST = MRTS_MOST_JOINTS + MRTS_SIZE };
    const int size = joints + W;
    double matrix[MOST * MOST], rhs[MOST];
    for (int i = 0; i < joints; ++i) {
        rhs[i] = change[i];
        for (int j = 0; j < joints; ++j) matrix[i * size + j] = space->hessian[i * joints + j];
        for (int j = 0; j < W; ++j) matrix[i * size + joints + j] = -J[i * W + j];
    }
    for (int i = 0; i < W; ++i) {
        rhs[joints + i] = along[i];
        for (int j = 0; j < joints; ++j) matrix[(joints + i) * size + j] = J[j * W + i];
        for (int j = 0; j < W; ++j) matrix[(joints + i) * size + joints + j] = i == j ? damping : 0;
    }
    const double determinant = mrts_solve(size, matrix, rhs);
    for (int i = 0; i < joints; ++i) x[i] = rhs[i];
    for (int i = 0; i < W; ++i) F[i] = rhs[joints + i];
    return determinant;
}

MRTS_LOCAL void mrts_square(int joints, const double *J, double *square) {
    enum { W = MRTS_SIZE };
    for (int i = 0; i < W; ++i) {
        for (int j = 0; j < W; ++j) {
            square[i * W + j] = 0;
            for (int l = 0; l < joints; ++l) square[i * W + j] += J[l * W + i] * J[l * W + j];
        }
    }
}

MRTS_LOCAL int mrts_null_spaces(const mrts_preference *wish, const double *geometry, const double *q,
                                const double *reference, const double *J_all,
                                mrts_null_space *spaces, double *F) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double stiffness[M * M], slope[M], unused, *const res[] = {stiffness};
    const double *const at[] = {q, F, geometry};
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
        const double *J = J_all + W * first;
        double square[W * W], *multiplier = F + W * robot;
        mrts_null_space *space = spaces + robot;
        for (int i = 0; i < W; ++i) multiplier[i] = 0;
        if (joints == W) continue;
        for (int i = 0; i < joints; ++i) {
            const double kept = mrts_stretched(wish, first + i, reference[first + i], &unused, &unused);
            space->gradient[i] = mrts_stretched(wish, first + i, q[first + i], slope + first + i, space->bend + i) - kept;
            for (int l = 0; l < W; ++l) multiplier[l] += J[i * W + l] * space->gradient[i];
        }
        mrts_square(joints, J, square);
        if (mrts_solve(W, square, multiplier) == 0) return 0;
    }
    MRTS_GEOMETRIC_STIFFNESS(at, res);
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
        if (joints == W) continue;
        for (int i = 0; i < joints; ++i) {
            for (int j = 0; j < joints; ++j) {
                const double own = i == j ? slope[first + i] : 0;
                spaces[robot].hessian[i * joints + j] = own - stiffness[(first + j) * M + first + i];
            }
        }
    }
    return 1;
}

MRTS_LOCAL void mrts_change_along(const double *geometry, const double *q, const double *dq,
                                 const mrts_null_space *spaces, const double *F,
                                 const double *dF, double *change) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double stiffness[M * M], *const rates[] = {change}, *const res[] = {stiffness};
    const double *const moving[] = {q, dq, F, geometry}, *const at[] = {q, dF, geometry};
    MRTS_GEOMETRIC_STIFFNESS_RATE(moving, rates);
    MRTS_GEOMETRIC_STIFFNESS(at, res);
    for (int robot = 0; robot < R; ++robot) {
        const int first = MRTS_FIRST(robot), last = MRTS_FIRST(robot + 1);
        if (last - first == W) continue;
        for (int i = first; i < last; ++i) {
            for (int j = first; j < last; ++j) change[i] += 2 * stiffness[j * M + i] * dq[j];
            change[i] -= spaces[robot].bend[i - first] * dq[i] * dq[i];
        }
    }
}

MRTS_LOCAL double mrts_curvature(int joints, const double *J, double determinant) {
    enum { W = MRTS_SIZE };
    double square[W * W], unused[W] = {0};
    mrts_square(joints, J, square);
    return determinant / mrts_solve(W, square, unused);
}
#endif

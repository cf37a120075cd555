/* SPDX-License-Identifier: MIT
 *
 * One sample from joints that are predicted well, as along a smooth motion: that takes one evaluation of the kinematics
 * and one factorisation of each Jacobian, which is used for everything.
 */
#include "tracking.h"

/* Largest step [rad or m] after which the Jacobian before it counts as that after it: its share of an error of q'. */
#define MRTS_FINE 1e-11

/* Steps of the fast iteration; what takes more is left to the rule of tracking.c. */
enum { MRTS_QUICK = 4 };

#ifndef MRTS_UNEVEN

/* J' q' of one arm in cell components from the columns of J alone: a joint turns every column behind it about its axis,
 * and one behind it moves with it. */
static void mrts_bias_of_columns(const mrts_tracking *task, const double *J, const double *dq, double *bias) {
    enum { W = MRTS_SIZE };
    double before[3] = {0}, six[6] = {0};
    for (int l = 0; l < W; ++l) {
        double column[6] = {0}, both[3], moved[3], turned[3];
        for (int i = 0; i < W; ++i) column[task->components[i]] = J[l * W + i];
        for (int i = 0; i < 3; ++i) both[i] = 2 * before[i] + column[3 + i] * dq[l];
        mrts_cross(both, column, moved);
        mrts_cross(before, column + 3, turned);
        for (int i = 0; i < 3; ++i) {
            six[i] += moved[i] * dq[l];
            six[3 + i] += turned[i] * dq[l];
            before[i] += column[3 + i] * dq[l];
        }
    }
    for (int i = 0; i < W; ++i) bias[i] = six[task->components[i]];
}

/* A Jacobian as the product of two triangles, for arms with as many joints as wrench components. */
typedef struct {
    double triangles[MRTS_SIZE * MRTS_SIZE];
    int row[MRTS_SIZE]; /* of the Jacobian, of each row of theirs */
} mrts_factors;

/* Factors J, by columns, with row exchanges. Returns a bound of its condition number by its determinant (H.
 * Guggenheimer, A. Edelman, C. Johnson, A simple estimate of the condition number of a linear system, The College
 * Mathematics Journal 26, 1995), infinite where it is singular. */
static double mrts_factor(const double *J, mrts_factors *factors) {
    enum { W = MRTS_SIZE };
    double *LU = factors->triangles, square = 0, determinant = 1;
    for (int i = 0; i < W; ++i) {
        factors->row[i] = i;
        for (int j = 0; j < W; ++j) {
            LU[i * W + j] = J[j * W + i];
            square += J[j * W + i] * J[j * W + i];
        }
    }
    for (int j = 0; j < W; ++j) {
        int p = j;
        for (int i = j + 1; i < W; ++i) {
            if (fabs(LU[i * W + j]) > fabs(LU[p * W + j])) p = i;
        }
        if (!(fabs(LU[p * W + j]) > 0)) return MRTS_INFINITY;
        if (p != j) {
            const int row = factors->row[j];
            factors->row[j] = factors->row[p];
            factors->row[p] = row;
            for (int l = 0; l < W; ++l) {
                const double t = LU[j * W + l];
                LU[j * W + l] = LU[p * W + l];
                LU[p * W + l] = t;
            }
        }
        determinant *= LU[j * W + j] * LU[j * W + j];
        const double factor = 1 / LU[j * W + j];
        for (int i = j + 1; i < W; ++i) {
            const double f = LU[i * W + j] *= factor;
            for (int l = j + 1; l < W; ++l) LU[i * W + l] -= f * LU[j * W + l];
        }
        LU[j * W + j] = factor;
    }
    for (int i = 0; i < W; ++i) determinant /= square / W;
    return 2 / sqrt(determinant);
}

/* x with J x = y. */
static void mrts_solve(const mrts_factors *factors, const double *y, double *x) {
    enum { W = MRTS_SIZE };
    const double *LU = factors->triangles;
    for (int i = 0; i < W; ++i) {
        double rest = y[factors->row[i]];
        for (int l = 0; l < i; ++l) rest -= LU[i * W + l] * x[l];
        x[i] = rest;
    }
    for (int i = W - 1; i >= 0; --i) {
        double rest = x[i];
        for (int l = i + 1; l < W; ++l) rest -= LU[i * W + l] * x[l];
        x[i] = rest * LU[i * W + i];
    }
}

MRTS_LOCAL int mrts_quick_sample(const mrts_tracking *task, const mrts_path *at, const unsigned char *left_out, double *now,
                                 double *dq, double *ddq, mrts_held *held) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double tips[3 * R], rotations[9 * R], J[W * M], off[3], turned[3], error[W], step[W];
    const double *const given[] = {now, task->geometry};
    double *const poses[] = {tips, rotations, J};
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
            held->condition[robot] = mrts_factor(J + W * W * robot, factors + robot);
            if (!(held->condition[robot] < task->condition)) return 0;
            if (!(fmax(held->gap[robot], held->turn[robot]) <= furthest)) furthest = fmax(held->gap[robot], held->turn[robot]);
            mrts_solve(factors + robot, error, step);
            for (int i = 0; i < W; ++i) {
                now[W * robot + i] += step[i];
                if (!(fabs(step[i]) <= largest)) largest = fabs(step[i]);
            }
        }
        if (!(largest <= task->longest)) return 0;
        if (largest > MRTS_FINE || !(furthest <= task->reached)) continue;
        for (int robot = 0; robot < R; ++robot) {
            double velocity[W], change[W], bias[W];
            for (int i = 0; i < W; ++i) dq[W * robot + i] = ddq[W * robot + i] = 0;
            held->drift[robot] = 0;
            held->folds[robot] = 0;
            if (left_out[robot]) continue;
            mrts_tip_rates(task, MRTS_ARM(task->geometry, robot), at->rotation, at->twist, at->acceleration, velocity,
                           change);
            mrts_solve(factors + robot, velocity, dq + W * robot);
            mrts_bias_of_columns(task, J + W * W * robot, dq + W * robot, bias);
            for (int i = 0; i < W; ++i) change[i] -= bias[i];
            mrts_solve(factors + robot, change, ddq + W * robot);
        }
        return 1;
    }
    return 0;
}

#endif

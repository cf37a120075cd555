/* SPDX-License-Identifier: MIT
 *
 * Small dense strictly convex quadratic programs: minimise 1/2 x'Hx + g'x under the limits of linear_programs.h, by the dual
 * method of Goldfarb and Idnani, A numerically stable dual method for solving strictly convex quadratic programs,
 * Mathematical Programming 27, 1983; two-sided rows and a final refinement are added. */
#ifndef MRTS_QUADRATIC_PROGRAMS_H
#define MRTS_QUADRATIC_PROGRAMS_H

#include "linear_programs.h"

#define MRTS_QP_WORK(k) (3 * (k) * (k) + 7 * (k))
#define MRTS_QP_IWORK(k, rows) ((rows) + (k))

/* Cholesky factor of H and the inverse of its transpose, upper triangular, by columns in J; 0 if H is not definite. */
static int mrts_qp_factor(int k, const mrts_real *H, mrts_real *L, mrts_real *J) {
    mrts_cholesky(k, H, L);
    for (int j = 0; j < k; ++j) { /* column j of L^-T, stored as J[j * k + i] */
        if (!(L[j * k + j] < MRTS_INFINITY)) return 0;
        for (int i = 0; i < k; ++i) J[j * k + i] = 0;
        J[j * k + j] = L[j * k + j];
        for (int i = j - 1; i >= 0; --i) J[j * k + i] = mrts_less(j - i, 0, L + (i + 1) * k + i, k, J + j * k + i + 1) * L[i * k + i];
    }
    return 1;
}

/* Rotates the pair of vectors a, b by the angle of cosine c and sine s. */
static void mrts_rotate(int k, mrts_real c, mrts_real s, mrts_real *a, mrts_real *b) {
    for (int i = 0; i < k; ++i) {
        const mrts_real t = c * a[i] + s * b[i];
        b[i] = c * b[i] - s * a[i];
        a[i] = t;
    }
}

/* Adds a row with J'a = d as the last active one: rotates d's tail into one entry. R is upper triangular, by columns. */
static void mrts_qp_add(int k, int count, mrts_real *d, mrts_real *J, mrts_real *R) {
    for (int j = k - 1; j > count; --j) {
        if (d[j] == 0) continue;
        const mrts_real a = d[j - 1], b = d[j];
        const mrts_real size = MRTS_SQRT(a * a + b * b);
        mrts_rotate(k, a / size, b / size, J + (j - 1) * k, J + j * k);
        d[j - 1] = size;
        d[j] = 0;
    }
    for (int i = 0; i <= count; ++i) R[count * k + i] = d[i];
}

/* Takes active row `out` away and restores the triangle. */
static void mrts_qp_drop(int k, int count, int out, mrts_real *J, mrts_real *R) {
    for (int j = out; j + 1 < count; ++j) {
        for (int i = 0; i <= j + 1; ++i) R[j * k + i] = R[(j + 1) * k + i];
    }
    for (int j = out; j + 1 < count; ++j) {
        const mrts_real a = R[j * k + j], b = R[j * k + j + 1];
        if (b == 0) continue;
        const mrts_real size = MRTS_SQRT(a * a + b * b), c = a / size, s = b / size;
        for (int l = j; l + 1 < count; ++l) {
            const mrts_real t = c * R[l * k + j] + s * R[l * k + j + 1];
            R[l * k + j + 1] = c * R[l * k + j + 1] - s * R[l * k + j];
            R[l * k + j] = t;
        }
        mrts_rotate(k, c, s, J + j * k, J + (j + 1) * k);
    }
}

/* One step of refinement of x and u on the active rows, whose residuals are solved for. */
static void mrts_qp_refine(int k, int count, const mrts_real *J, const mrts_real *R, const mrts_real *gradient,
                           mrts_real *w, mrts_real *x, mrts_real *u) {
    for (int j = 0; j < count; ++j) { /* R'w = what the rows miss */
        w[j] = mrts_less(j, w[j], R + j * k, 1, w) / R[j * k + j];
    }
    for (int j = count; j < k; ++j) w[j] = -mrts_dot(k, J + j * k, gradient);
    for (int j = 0; j < k; ++j) {
        for (int i = 0; i < k; ++i) x[i] += w[j] * J[j * k + i];
    }
    for (int j = 0; j < count; ++j) w[j] += mrts_dot(k, J + j * k, gradient);
    for (int j = count - 1; j >= 0; --j) {
        w[j] = mrts_less(count - 1 - j, w[j], R + (j + 1) * k + j, k, w + j + 1) / R[j * k + j];
        u[j] += w[j];
    }
}

/* Quadratic program by the dual active set method.
 * H:      Shape (k, k), symmetric and positive definite.
 * active: on return *count rows that bind, coded as the basis of a linear program.
 * u:      their multipliers, >= 0 in size: H x + g = sum_j s_j u_j a_j with s_j = 1 at a lower, -1 at an upper limit. */
static inline int mrts_qp(int k, int rows, const mrts_real *H, const mrts_real *A, const mrts_real *lower,
                          const mrts_real *upper, const mrts_real *g, mrts_real *x, int *active, mrts_real *u, int *count,
                          mrts_real *work, int *iwork) {
    mrts_real *L = work, *J = L + k * k, *R = J + k * k, *a = R + k * k, *d = a + k, *z = d + k, *r = z + k;
    int *is_active = iwork;
    const int limit = 20 + 4 * (k + rows);
    int m = 0;

    *count = 0;
    if (!mrts_qp_factor(k, H, L, J)) return MRTS_STOPPED;
    for (int i = 0; i < rows + k; ++i) is_active[i] = 0;
    for (int i = 0; i < k; ++i) x[i] = 0;
    for (int j = 0; j < k; ++j) { /* the unconstrained minimiser */
        const mrts_real step = -mrts_dot(k, J + j * k, g);
        for (int i = 0; i <= j; ++i) x[i] += step * J[j * k + i];
    }
    for (int iteration = 0; iteration < limit; ++iteration) {
        mrts_real excess;
        const int found = mrts_lp_price(k, rows, A, lower, upper, x, is_active, 0, &excess);
        if (found == 0) {
            *count = m;
            for (int turn = 0;; ++turn) {
                const int fits = mrts_qp_residuals(k, rows, H, A, lower, upper, g, active, m, x, u, d, z);
                if (turn == 2 && !fits) return MRTS_STOPPED;
                if (turn == 2) break;
                mrts_qp_refine(k, m, J, R, d, z, x, u);
            }
            return mrts_lp_price(k, rows, A, lower, upper, x, is_active, 0, &excess) ? MRTS_STOPPED : MRTS_OPTIMAL;
        }
        const int p = mrts_abs(found) - 1;
        mrts_real multiplier = 0, missing = excess; /* a'x >= b is missed by this much */
        const mrts_real sign = found < 0 ? 1 : -1;
        for (int i = 0; i < k; ++i) a[i] = p < rows ? sign * A[p * k + i] : p - rows == i ? sign : 0;
        for (;;) {
            mrts_real curvature = 0, size = 0, full = MRTS_INFINITY, part = MRTS_INFINITY;
            int out = -1;
            for (int j = 0; j < k; ++j) {
                d[j] = mrts_dot(k, J + j * k, a);
                size += d[j] * d[j];
                if (j >= m) curvature += d[j] * d[j];
            }
            for (int i = 0; i < k; ++i) z[i] = 0;
            for (int j = m; j < k; ++j) {
                for (int i = 0; i < k; ++i) z[i] += d[j] * J[j * k + i];
            }
            for (int j = m - 1; j >= 0; --j) {
                r[j] = mrts_less(m - 1 - j, d[j], R + (j + 1) * k + j, k, r + j + 1) / R[j * k + j];
            }
            if (curvature > MRTS_PIVOT * MRTS_PIVOT * size) full = missing / curvature;
            for (int j = 0; j < m; ++j) {
                const int row = mrts_abs(active[j]) - 1;
                if (r[j] > 0 && lower[row] < upper[row] && u[j] < part * r[j]) {
                    part = u[j] / r[j];
                    out = j;
                }
            }
            if (full >= MRTS_INFINITY && part >= MRTS_INFINITY) {
                mrts_real weight = 1;
                for (int j = 0; j < m; ++j) weight += MRTS_ABS(r[j]);
                return missing > MRTS_SEPARATED * weight ? MRTS_INFEASIBLE : MRTS_MARGINAL;
            }
            const mrts_real step = full < part ? full : part;
            for (int j = 0; j < m; ++j) u[j] -= step * r[j];
            multiplier += step;
            if (full < MRTS_INFINITY) {
                for (int i = 0; i < k; ++i) x[i] += step * z[i];
                missing -= step * curvature;
            }
            if (full <= part) {
                mrts_qp_add(k, m, d, J, R);
                active[m] = found; /* < 0: its lower limit binds */
                u[m++] = multiplier;
                is_active[p] = 1;
                break;
            }
            is_active[mrts_abs(active[out]) - 1] = 0;
            mrts_qp_drop(k, m, out, J, R);
            for (int j = out; j + 1 < m; ++j) {
                u[j] = u[j + 1];
                active[j] = active[j + 1];
            }
            --m;
            if (++iteration >= limit) return MRTS_STOPPED;
        }
    }
    return MRTS_STOPPED;
}

#endif

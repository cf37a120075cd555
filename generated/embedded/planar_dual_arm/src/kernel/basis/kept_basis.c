/* SPDX-License-Identifier: MIT
 *
 * A linear program answered by the basis of the one before: its rows are solved for once, and the answer is checked as
 * that of the simplex method is.
 */
#include "kept_basis.h"

/* The row with the largest entry in column c, of those at place c and below, and its side, change places with those at c.
 */
static void mrts_take_pivot(int k, int c, int *row, int *side, mrts_real *B) {
    int best = c;
    mrts_real largest = MRTS_ABS(B[c * k + c]);
    for (int j = c + 1; j < k; ++j) {
        const mrts_real size = MRTS_ABS(B[j * k + c]);
        if (size > largest) {
            largest = size;
            best = j;
        }
    }
    if (best == c) return;
    const int its_row = row[c], its_side = side[c];
    row[c] = row[best];
    side[c] = side[best];
    row[best] = its_row;
    side[best] = its_side;
    for (int i = 0; i < k; ++i) {
        const mrts_real entry = B[c * k + i];
        B[c * k + i] = B[best * k + i];
        B[best * k + i] = entry;
    }
}

/* sum - a'b, the entries of a being `apart`. */
static inline mrts_real mrts_less(int k, mrts_real sum, const mrts_real *a, int apart, const mrts_real *b) {
    MRTS_UNROLL
    for (; k > 0; --k, a += apart, ++b) sum -= *a * *b;
    return sum;
}

/* B = L U of the rows of a basis: L below the diagonal, U above it, on it the reciprocals of U's. */
static inline void mrts_kept_factor(int k, int rows, const mrts_real *A, int *row, int *side, mrts_real *B) {
    for (int j = 0; j < k; ++j) {
        const int unknown = row[j] - rows;
        const mrts_real *a = A + (unknown < 0 ? row[j] : 0) * k;
        MRTS_UNROLL
        for (int i = 0; i < k; ++i) B[j * k + i] = unknown < 0 ? a[i] : 0;
        if (unknown >= 0) B[j * k + unknown] = 1;
    }
    for (int c = 0; c < k; ++c) {
        mrts_real *pivot = B + c * (k + 1), *below = pivot;
        mrts_take_pivot(k, c, row, side, B);
        const mrts_real inverse = 1 / *pivot;
        *pivot = inverse;
        for (int j = c + 1; j < k; ++j) {
            below += k;
            if (*below == 0) continue;
            const mrts_real factor = *below * inverse;
            *below = factor;
            MRTS_UNROLL
            for (int i = 1; i < k - c; ++i) below[i] -= factor * pivot[i];
        }
    }
}

/* x of B x = b, and y of B' y = g, both given in place; g has nothing before `first`. */
static inline void mrts_kept_solve(int k, const mrts_real *B, mrts_real *x, mrts_real *y, int first) {
    const mrts_real *from = B + first * k;
    for (int j = 1; j < k; ++j) x[j] = mrts_less(j, x[j], B + j * k, 1, x);
    for (int j = first; j < k; ++j) y[j] = B[j * k + j] * mrts_less(j - first, y[j], from + j, k, y + first);
    for (int j = k - 1; j >= 0; --j) {
        const mrts_real *diagonal = B + j * (k + 1);
        x[j] = *diagonal * mrts_less(k - 1 - j, x[j], diagonal + 1, 1, x + j + 1);
        y[j] = mrts_less(k - 1 - j, y[j], diagonal + k, k, y + j + 1);
    }
}

/* Whether a value keeps its limits. */
static inline int mrts_keeps(mrts_real value, mrts_real lower, mrts_real upper) {
    return value - upper <= MRTS_FEASIBLE && lower - value <= MRTS_FEASIBLE;
}

/* Whether rows and unknowns keep their limits at x. */
static inline int mrts_kept_feasible(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                                     const mrts_real *x) {
    int kept = 1;
    for (int i = 0; i < rows; ++i) {
        mrts_real value = 0;
        MRTS_UNROLL
        for (int j = 0; j < k; ++j) value += *A++ * x[j];
        if (!mrts_keeps(value, *lower++, *upper++)) return 0;
    }
    for (int j = 0; j < k; ++j) kept &= mrts_keeps(x[j], lower[j], upper[j]);
    return kept;
}

/* Minimises g'x where the rows of a basis still determine the answer: all of x, y and its multipliers have passed what
 * mrts_lp asks of an answer, where the result holds. `B` is k * k of work, `rest` k. */
static inline int mrts_kept_basis(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                                  const mrts_real *g, int *row, int *side, mrts_real *x, mrts_real *y, mrts_real *B,
                                  mrts_real *rest) {
    mrts_real largest = 0, doubt = 0, cost = 0, most = 0, *limits = rest;
    int first = k;
    mrts_kept_factor(k, rows, A, row, side, B);
    for (int j = k - 1; j >= 0; --j) {
        const mrts_real limit = limits[j] = side[j] < 0 ? lower[row[j]] : upper[row[j]];
        x[j] = MRTS_ABS(limit) < MRTS_INFINITY ? limit : 0;
        y[j] = g[j];
        if (g[j] == 0) continue;
        most = mrts_larger(most, MRTS_ABS(g[j]));
        first = j;
    }
    mrts_kept_solve(k, B, x, y, first);
    if (!mrts_kept_feasible(k, rows, A, lower, upper, x)) return 0;
    rest = B; /* whose factors have served */
    for (int j = 0; j < k; ++j) {
        rest[j] = g[j];
        cost += g[j] * x[j];
        largest = mrts_larger(largest, MRTS_ABS(y[j]));
    }
    for (int j = 0; j < k; ++j) {
        const int limited = MRTS_ABS(limits[j]) < MRTS_INFINITY;
        const mrts_real limit = limited ? limits[j] : 0; /* a row that has none is held at 0 */
        const mrts_real wrong = mrts_larger(side[j] < 0 ? -y[j] : y[j], 0);
        const mrts_real weight = MRTS_ABS(y[j]);
        mrts_real missing = limit;
        if (row[j] < rows) {
            const mrts_real *a = A + row[j] * k;
            const mrts_real its = y[j];
            MRTS_UNROLL
            for (int i = 0; i < k; ++i) {
                missing -= a[i] * x[i];
                rest[i] -= its * a[i];
            }
            doubt += weight * (MRTS_ROUNDING * (1 + MRTS_ABS(limit)));
        } else {
            missing -= x[row[j] - rows];
            rest[row[j] - rows] -= y[j];
        }
        doubt += wrong * (upper[row[j]] - lower[row[j]]);
        if (!((limited ? wrong : weight) <= MRTS_ZERO * largest) || !(MRTS_ABS(missing) <= MRTS_AS_IT_IS)) return 0;
    }
    int kept = 1;
    for (int i = 0; i < k; ++i) kept &= MRTS_ABS(rest[i]) <= MRTS_AS_IT_IS * most;
    cost = MRTS_ABS(cost);
    return kept & (doubt <= MRTS_GAP * mrts_larger(cost, MRTS_SMALL));
}

MRTS_LOCAL int mrts_lp_again(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                             const mrts_real *g, int *basis, mrts_real *x, mrts_real *y, int *entering,
                             mrts_real *work, int *iwork) {
    int *row = iwork, *side = row + k;
    const int cold = basis[0] == 0;
    if (!cold) {
        for (int j = 0; j < k; ++j) {
            row[j] = mrts_abs(basis[j]) - 1;
            side[j] = basis[j];
        }
        if (mrts_kept_basis(k, rows, A, lower, upper, g, row, side, x, y, work, work + k * k)) {
            for (int j = 0; j < k; ++j) basis[j] = side[j];
            *entering = 0;
            return MRTS_OPTIMAL;
        }
    }
    const int status = mrts_lp(k, rows, A, lower, upper, g, basis, x, y, entering, work, iwork);
    if (status == MRTS_OPTIMAL || cold) return status;
    basis[0] = 0;
    return mrts_lp(k, rows, A, lower, upper, g, basis, x, y, entering, work, iwork);
}

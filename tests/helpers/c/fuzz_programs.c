/* SPDX-License-Identifier: MIT
 * Fuzz target: programs made from bytes, solved cold and warm; every answer is checked by substitution. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#define MRTS_LOCAL static
#include "linear_programs.c"
#include "quadratic_programs.c"

enum { MOST = 8, ROWS = 20, ALL = ROWS + MOST };
static const double VALUES[16] = {0, 0, 1, -1, 0.5, -0.25, 2, -3, 1e-3, 1e3, -1e-6, 7, 0.1, -0.7, 1e-9, -10};

typedef struct {
    const uint8_t *bytes;
    size_t left;
} stream;

static unsigned next(stream *s) {
    if (!s->left) return 0;
    --s->left;
    return *s->bytes++;
}

static double number(stream *s) {
    const unsigned byte = next(s);
    return VALUES[byte & 15] * (1 + (byte >> 4) / 16.0);
}

static void demand(int holds, const char *rule) {
    if (!holds) {
        fprintf(stderr, "broken: %s\n", rule);
        abort();
    }
}

static double value_of(int k, int rows, const double *A, int row, const double *x, double *size) {
    double sum = 0;
    *size = 1;
    if (row >= rows) {
        *size += fabs(x[row - rows]);
        return x[row - rows];
    }
    for (int i = 0; i < k; ++i) {
        sum += A[row * k + i] * x[i];
        *size += fabs(A[row * k + i] * x[i]);
    }
    return sum;
}

static void check_feasible(int k, int rows, const double *A, const double *lower, const double *upper, const double *x) {
    double size;
    for (int row = 0; row < rows + k; ++row) {
        const double value = value_of(k, rows, A, row, x, &size);
        demand(value >= lower[row] - 1e-8 * (size + fabs(lower[row])), "lower limit");
        demand(value <= upper[row] + 1e-8 * (size + fabs(upper[row])), "upper limit");
    }
}

static void check_linear(int k, int rows, const double *A, const double *lower, const double *upper, const double *g,
                         int status, const int *basis, const double *x, const double *y, int entering) {
    double rest[MOST], terms[MOST], gap = 0, weight = 0, largest = 0, size;
    demand(status >= MRTS_OPTIMAL && status <= MRTS_STOPPED, "status");
    if (status != MRTS_OPTIMAL && status != MRTS_INFEASIBLE) return;
    for (int i = 0; i < k; ++i) rest[i] = terms[i] = status == MRTS_OPTIMAL ? g[i] : 0;
    for (int j = -1; j < k; ++j) { /* j = -1: the entering row of a certificate */
        if (j < 0 && status == MRTS_OPTIMAL) continue;
        const int code = j < 0 ? entering : basis[j], row = abs(code) - 1;
        const double factor = j < 0 ? (entering > 0 ? -1 : 1) : y[j];
        demand(row >= 0 && row < rows + k, "row");
        for (int i = 0; i < k; ++i) {
            const double a = row < rows ? A[row * k + i] : row - rows == i;
            rest[i] -= factor * a;
            terms[i] = fmax(fabs(terms[i]), fabs(factor * a));
        }
        if (status == MRTS_OPTIMAL) {
            const double limit = factor > 0 ? lower[row] : upper[row];
            const double value = value_of(k, rows, A, row, x, &size);
            double most = 0;
            for (int l = 0; l < k; ++l) most = fmax(most, fabs(y[l]));
            demand(fabs(factor * (value - limit)) <= 1e-8 * most * (size + fabs(limit)), "complementarity");
        } else { /* factor > 0: the row is at least its lower limit */
            weight += fabs(factor);
            gap += factor * (factor > 0 ? lower[row] : factor < 0 ? upper[row] : 0);
        }
    }
    for (int i = 0; i < k; ++i) largest = fmax(largest, terms[i]);
    for (int i = 0; i < k; ++i) demand(fabs(rest[i]) <= 1e-8 * largest, "stationarity");
    if (status == MRTS_OPTIMAL) check_feasible(k, rows, A, lower, upper, x);
    else demand(gap > 0.5e-9 * weight, "certificate");
}

static void check_quadratic(int k, int rows, const double *H, const double *A, const double *lower, const double *upper,
                            const double *g, const double *x, const int *active, const double *u, int count) {
    double gradient[MOST], size = 0, largest = 0;
    for (int j = 0; j < count; ++j) largest = fmax(largest, u[j]);
    for (int i = 0; i < k; ++i) {
        gradient[i] = g[i];
        for (int j = 0; j < k; ++j) gradient[i] += H[i * k + j] * x[j];
        size = fmax(size, fabs(g[i]));
    }
    for (int j = 0; j < count; ++j) {
        const int row = abs(active[j]) - 1;
        const double sign = active[j] < 0 ? 1 : -1;
        demand(u[j] >= -1e-9 * largest || lower[row] >= upper[row], "multiplier");
        for (int i = 0; i < k; ++i) {
            const double a = row < rows ? A[row * k + i] : row - rows == i;
            gradient[i] -= sign * u[j] * a;
            size = fmax(size, fabs(u[j] * a));
        }
    }
    for (int i = 0; i < k; ++i) demand(fabs(gradient[i]) <= 1e-9 * (size + 1), "gradient");
    check_feasible(k, rows, A, lower, upper, x);
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t length) {
    stream s = {bytes, length};
    const int k = 1 + (int)(next(&s) % MOST), rows = (int)(next(&s) % (ROWS + 1));
    double A[ROWS * MOST], lower[ALL], upper[ALL], g[MOST] = {0}, H[MOST * MOST], x[MOST], y[MOST];
    double work[MRTS_QP_WORK(MOST)];
    int iwork[MRTS_LP_IWORK(MOST, ROWS) + MOST], basis[MOST] = {0}, active[MOST], entering, count;
    for (int i = 0; i < rows * k; ++i) A[i] = number(&s);
    for (int row = 0; row < rows + k; ++row) {
        const unsigned kind = next(&s);
        const double a = number(&s), b = number(&s);
        lower[row] = kind & 1 ? -MRTS_INFINITY : fmin(a, b);
        upper[row] = kind & 2 ? MRTS_INFINITY : kind & 4 ? (kind & 1 ? a : lower[row]) : fmax(a, b);
    }
    for (int j = 0; j < k; ++j) { /* as every caller does: the largest coefficient of an unknown is 1 */
        double size = 0;
        for (int row = 0; row < rows; ++row) size = fmax(size, fabs(A[row * k + j]));
        for (int row = 0; size > 0 && row < rows; ++row) A[row * k + j] /= size;
    }
    for (int row = 0; row < rows; ++row) { /* and no row is made of tiny ones */
        double size = 0;
        for (int j = 0; j < k; ++j) size = fmax(size, fabs(A[row * k + j]));
        if (size == 0 || size > 1e-2) continue;
        for (int j = 0; j < k; ++j) A[row * k + j] /= size;
        if (lower[row] > -MRTS_INFINITY) lower[row] /= size;
        if (upper[row] < MRTS_INFINITY) upper[row] /= size;
    }
    lower[rows + k - 1] = 0;
    upper[rows + k - 1] = 1e6;
    for (int turn = 0; turn < 3; ++turn) { /* cold, then warm with the other end, then with other limits */
        g[k - 1] = turn == 1 ? -1 : 1;
        if (turn == 2) {
            for (int row = 0; row < rows; ++row) {
                const double shift = number(&s);
                if (lower[row] > -MRTS_INFINITY) lower[row] += shift;
                if (upper[row] < MRTS_INFINITY) upper[row] += shift;
            }
        }
        const int status = mrts_lp(k, rows, A, lower, upper, g, basis, x, y, &entering, work, iwork);
        check_linear(k, rows, A, lower, upper, g, status, basis, x, y, entering);
        if (status != MRTS_OPTIMAL) basis[0] = 0;
    }
    for (int i = 0; i < k * k; ++i) H[i] = i % (k + 1) == 0 ? 1 + fabs(number(&s)) : 0;
    for (int i = 0; i < k; ++i) g[i] = number(&s);
    const int status = mrts_qp(k, rows, H, A, lower, upper, g, x, active, y, &count, work, iwork);
    demand(status >= MRTS_OPTIMAL && status <= MRTS_STOPPED, "status");
    if (status == MRTS_OPTIMAL) check_quadratic(k, rows, H, A, lower, upper, g, x, active, y, count);
    return 0;
}

/* SPDX-License-Identifier: MIT */
#include "fronts.h"

#define MRTS_FRONT_PIVOT 1e-16 /* a pivot below this share of its diagonal is rounding: its unknown does not move */
#define MRTS_FRONT_ROWS 4         /* of a front that are worked on together */
#define MRTS_FRONT_SOFT 1e-15  /* of its diagonal, added to each: F that nothing determines stays where it is */

MRTS_LOCAL long long mrts_front_size(const mrts_smooth_program *p) {
    const long long f = p->free;
    return (p->nodes - 1) * (2 * f + 3) * (f + 1) + (f + 2) * (f + 2);
}

MRTS_LOCAL long long mrts_front_work(const mrts_smooth_program *p) {
    const long long f = p->free;
    return (2 * f + 3) * (2 * f + 3) + (f + 2) + (f + 2) * (f + 2) +
           (2 * f + 3) / MRTS_FRONT_ROWS + 1;
}

/* Whether F_k, control point k is given. */
static int mrts_front_held(const mrts_smooth_program *p, int k) {
    return (k == 0 && p->held_start) || (k == p->nodes - 1 && p->held_end);
}
static int mrts_front_given(const mrts_smooth_program *p, int k) {
    return p->timed || (k == 0 && p->given_start) || (k == p->nodes && p->given_end);
}

/* A += by a b', columns of A from a row of `stride` to the next; the count is a constant where it is often met. */
static inline void mrts_front_outer(int count, int stride, double by, const double *a, const double *b, double *A) {
    for (int i = 0; i < count; ++i) {
        const double left = by * a[i];
        for (int l = 0; l < count; ++l) A[i * stride + l] += left * b[l];
    }
}

static void mrts_front_add_outer(int count, int stride, double by, const double *a, const double *b, double *A) {
    if (count == 6) mrts_front_outer(6, stride, by, a, b, A);
    else if (count == 3) mrts_front_outer(3, stride, by, a, b, A);
    else mrts_front_outer(count, stride, by, a, b, A);
}

/* Adds node k to the lower triangle of a front of size m; c_(k+1) has the place `next`. Its own places are adjacent. */
static void mrts_front_add_node(const mrts_smooth_program *p, const mrts_smooth_state *state, int k, int m, int next,
                                double *A, double *diagonal) {
    const int f = p->free, r = p->rows;
    const long long at = (long long)k * r;
    const double *weight = state->row_weight + at, *cross = state->row_cross + at, *rate = p->rate + at;
    const double *entry = p->entry + (long long)k * p->width;
    const double near = state->near[k], far = state->far[k], slope = state->slope[k];
    const double xx = state->node_second[3 * k];
    double xu = state->node_second[3 * k + 1], uu = state->node_second[3 * k + 2];
    double *of_c = A + f * m, *of_next = A + next * m;
    for (int i = 0; i < f; ++i) diagonal[i] = A[i * m + i];
    for (int j = 0; j < r; ++j) {
        const double *e = entry + p->place[j];
        const double along_u = weight[j] * rate[j];
        const double by_c = near * cross[j] - slope * along_u, by_next = far * cross[j] + slope * along_u;
        const int first = p->first[j], count = p->count[j];
        xu += cross[j] * rate[j];
        uu += along_u * rate[j];
        mrts_front_add_outer(count, m, weight[j], e, e, A + first * m + first);
        for (int i = 0; i < count; ++i) {
            of_c[first + i] += by_c * e[i];
            of_next[first + i] += by_next * e[i];
        }
    }
    for (int i = 0; i < f; ++i) diagonal[i] = A[i * m + i] - diagonal[i];
    const double cc = near * near * xx - 2 * near * slope * xu + slope * slope * uu;
    const double nn = far * far * xx + 2 * far * slope * xu + slope * slope * uu;
    of_c[f] += cc;
    of_next[f] += near * far * xx + slope * (near - far) * xu - slope * slope * uu;
    of_next[next] += nn;
    diagonal[f] = cc;
    diagonal[f + 1] = nn;
}

/* Adds what segment k has between its nodes. */
static void mrts_front_add_segment(const mrts_smooth_program *p, const mrts_smooth_state *state, int k, double *A) {
    const int f = p->free, r = p->rows, c = p->changes, m = 2 * f + 3;
    const double *entry0 = p->entry + (long long)k * p->width, *entry1 = entry0 + p->width;
    const double *rate0 = p->rate + (long long)k * r, *rate1 = rate0 + r;
    const double near0 = state->near[k], far0 = state->far[k], slope0 = state->slope[k];
    const double near1 = state->near[k + 1], far1 = state->far[k + 1], slope1 = state->slope[k + 1];
    double xx = state->segment_second[4 * k], xu = state->segment_second[4 * k + 1];
    double ux = state->segment_second[4 * k + 2], uu = state->segment_second[4 * k + 3];
    double *of_c1 = A + (2 * f + 1) * m, *of_c2 = A + (2 * f + 2) * m;
    for (int i = 0; i < c; ++i) {
        const int j = p->limited[i], first = p->first[j], count = p->count[j];
        const double weight = state->change_weight[(long long)k * c + i];
        const double before = state->change_before[(long long)k * c + i];
        const double after = state->change_after[(long long)k * c + i];
        const double *e0 = entry0 + p->place[j], *e1 = entry1 + p->place[j];
        xu -= before * rate1[j];
        ux -= after * rate0[j];
        uu -= weight * rate0[j] * rate1[j];
        const double here1 = -near1 * after + slope1 * weight * rate1[j]; /* value here with c_(k+1), c_(k+2) there */
        const double here2 = -far1 * after - slope1 * weight * rate1[j];
        const double there0 = -near0 * before + slope0 * weight * rate0[j]; /* value there with c_k, c_(k+1) here */
        const double there1 = -far0 * before - slope0 * weight * rate0[j];
        mrts_front_add_outer(count, m, -weight, e1, e0, A + (f + 1 + first) * m + first);
        for (int l = 0; l < count; ++l) {
            A[(f + 1 + first + l) * m + f] += there0 * e1[l];
            of_c1[f + 1 + first + l] += there1 * e1[l];
            of_c1[first + l] += here1 * e0[l];
            of_c2[first + l] += here2 * e0[l];
        }
    }
    /* (x, u) of the nodes by (c_k, c_(k+1)) and (c_(k+1), c_(k+2)) */
    const double x1 = near1 * xx - slope1 * xu, x2 = far1 * xx + slope1 * xu;
    const double u1 = near1 * ux - slope1 * uu, u2 = far1 * ux + slope1 * uu;
    of_c1[f] += near0 * x1 - slope0 * u1;
    of_c2[f] += near0 * x2 - slope0 * u2;
    of_c1[2 * f + 1] += 2 * (far0 * x1 + slope0 * u1);
    of_c2[2 * f + 1] += far0 * x2 + slope0 * u2;
}

/* Takes the row and column of an unknown out of a front of size m. */
static void mrts_front_hold(int m, int i, double *A, double one) {
    for (int l = 0; l < i; ++l) A[i * m + l] = 0;
    for (int l = i + 1; l < m; ++l) A[l * m + i] = 0;
    A[i * m + i] = one;
}

/* Products of some rows of `stride` with another one, from a column to before another. */
static inline void mrts_front_dots(int count, int from, int to, int stride, const double *rows, const double *with,
                                   double *sums) {
    if (count < MRTS_FRONT_ROWS) {
        for (int k = 0; k < count; ++k) sums[k] = mrts_dot(to - from, rows + k * stride + from, with + from);
        return;
    }
    const double *a = rows, *b = a + stride, *c = b + stride, *d = c + stride;
    double s0 = 0, s1 = 0, s2 = 0, s3 = 0; /* what is independent overlaps */
    for (int l = from; l < to; ++l) {
        const double by = with[l];
        s0 += a[l] * by;
        s1 += b[l] * by;
        s2 += c[l] * by;
        s3 += d[l] * by;
    }
    sums[0] = s0;
    sums[1] = s1;
    sums[2] = s2;
    sums[3] = s3;
}

/* The first column of rows of a front that is not 0, at most p. */
static int mrts_front_first(int rows, int p, int m, const double *A) {
    for (int l = 0; l < p; ++l) {
        for (int i = 0; i < rows; ++i) {
            if (A[i * m + l] != 0) return l;
        }
    }
    return p;
}

/* Eliminates the first p unknowns of a front of size m: their columns of the factor go to L, (m, p), what is left
 * stays in the lower triangle of A. Rows begin where they are not 0: unknowns of one corner of a box of loads meet
 * those of others only by what elimination fills in. */
static void mrts_front_eliminate(int m, int p, double *A, const double *diagonal, double *L, double *starts) {
    double sums[MRTS_FRONT_ROWS];
    for (int i = 0; i < m; i += MRTS_FRONT_ROWS) {
        const int rows = m - i < MRTS_FRONT_ROWS ? m - i : MRTS_FRONT_ROWS, done = i < p ? i : p;
        const int start = mrts_front_first(rows, done, m, A + i * m);
        double *row = L + i * p;
        starts[i / MRTS_FRONT_ROWS] = start;
        for (int k = 0; k < rows * p; ++k) row[k] = 0;
        for (int j = start; j < done; ++j) {
            mrts_front_dots(rows, start, j, p, row, L + j * p, sums);
            for (int k = 0; k < rows; ++k) row[k * p + j] = (A[(i + k) * m + j] - sums[k]) * L[j * p + j];
        }
        for (int k = i; k < i + rows; ++k, row += p) { /* what the rows have between themselves */
            for (int j = done; j < k && j < p; ++j) {
                row[j] = (A[k * m + j] - mrts_dot(j - start, row + start, L + j * p + start)) * L[j * p + j];
            }
            if (k >= p) continue; /* a diagonal is kept as its reciprocal */
            const double taken = mrts_dot(k - start, row + start, row + start);
            const double pivot = A[k * m + k] + MRTS_FRONT_SOFT * diagonal[k] - taken;
            row[k] = pivot > MRTS_FRONT_PIVOT * diagonal[k] ? 1 / sqrt(pivot) : 0;
        }
    }
    for (int i = p; i < m; i += MRTS_FRONT_ROWS) {
        const int rows = m - i < MRTS_FRONT_ROWS ? m - i : MRTS_FRONT_ROWS;
        for (int j = p; j < i + rows; ++j) {
            const int start = (int)starts[j / MRTS_FRONT_ROWS];
            mrts_front_dots(rows, start, p, p, L + i * p, L + j * p, sums);
            for (int k = 0; k < rows; ++k) A[(i + k) * m + j] -= sums[k];
        }
    }
}

MRTS_LOCAL void mrts_front_factor(const mrts_smooth_program *p, const mrts_smooth_state *state, double *factor,
                                  double *work) {
    const int n = p->nodes, f = p->free, size = f + 2;
    double *A = work, *diagonal = work + (2 * f + 3) * (2 * f + 3), *carried = diagonal + size;
    double *starts = carried + size * size;
    for (int i = 0; i < size * size; ++i) carried[i] = 0;
    for (int k = 0; k < n; ++k) {
        const int last = k == n - 1, pivots = last ? size : f + 1;
        const int m = last ? size : 2 * f + 3, next = last ? f + 1 : 2 * f + 1;
        for (int i = 0; i < m * m; ++i) A[i] = 0;
        for (int i = 0; i < size; ++i) {
            double *row = A + (i < f + 1 ? i : next) * m;
            for (int j = 0; j <= i; ++j) row[j < f + 1 ? j : next] = carried[i * size + j];
        }
        mrts_front_add_node(p, state, k, m, next, A, diagonal);
        if (!last) mrts_front_add_segment(p, state, k, A);
        for (int i = 0; i < f && mrts_front_held(p, k); ++i) mrts_front_hold(m, i, A, diagonal[i] = 1);
        for (int i = 0; i < f && !last && mrts_front_held(p, k + 1); ++i) mrts_front_hold(m, f + 1 + i, A, 0);
        if (mrts_front_given(p, k)) mrts_front_hold(m, f, A, diagonal[f] = 1);
        if (mrts_front_given(p, k + 1)) mrts_front_hold(m, next, A, last ? (diagonal[f + 1] = 1) : 0);
        if (!last && mrts_front_given(p, k + 2)) mrts_front_hold(m, 2 * f + 2, A, 0);
        mrts_front_eliminate(m, pivots, A, diagonal, factor, starts);
        factor += m * pivots;
        for (int i = 0; i < size && !last; ++i) {
            for (int j = 0; j <= i; ++j) carried[i * size + j] = A[(pivots + i) * m + pivots + j];
        }
    }
}

MRTS_LOCAL void mrts_front_solve(const mrts_smooth_program *p, const double *factor, double *b) {
    const int n = p->nodes, f = p->free, q = f + 1, m = 2 * f + 3;
    for (int k = 0; k < n; ++k) { /* what is given does not move */
        for (int i = 0; i < f && mrts_front_held(p, k); ++i) b[(long long)k * q + i] = 0;
        if (mrts_front_given(p, k)) b[(long long)k * q + f] = 0;
    }
    if (mrts_front_given(p, n)) b[(long long)n * q] = 0;
    for (int k = 0; k < n; ++k) {
        const double *L = factor + (long long)k * m * q;
        double *here = b + (long long)k * q;
        const int pivots = k < n - 1 ? q : f + 2;
        for (int i = 0; i < pivots; ++i) here[i] = (here[i] - mrts_dot(i, L + i * pivots, here)) * L[i * pivots + i];
        if (k == n - 1) break;
        for (int i = 0; i < q; ++i) here[q + i] -= mrts_dot(q, L + (q + i) * q, here);
        here[k == n - 2 ? 2 * q : 2 * q + f] -= mrts_dot(q, L + 2 * q * q, here);
    }
    for (int k = n - 1; k >= 0; --k) {
        const double *L = factor + (long long)k * m * q;
        double *here = b + (long long)k * q;
        const int pivots = k < n - 1 ? q : f + 2;
        for (int i = q; i < m && k < n - 1; ++i) {
            const double z = i < 2 * q ? here[i] : here[k == n - 2 ? 2 * q : 2 * q + f];
            for (int j = 0; j < q; ++j) here[j] -= z * L[i * q + j];
        }
        for (int i = pivots - 1; i >= 0; --i) {
            here[i] *= L[i * pivots + i];
            for (int j = 0; j < i; ++j) here[j] -= here[i] * L[i * pivots + j];
        }
    }
}

MRTS_LOCAL void mrts_front_gather(const mrts_smooth_program *p, const mrts_smooth_state *state, const double *gx,
                                  const double *gu, const double *gf, double *b) {
    const int f = p->free, q = f + 1;
    double passed = 0;
    for (int k = 0; k < p->nodes; ++k) {
        double *here = b + (long long)k * q;
        for (int i = 0; i < f; ++i) here[i] = gf[(long long)k * f + i];
        here[f] = passed + state->near[k] * gx[k] - state->slope[k] * gu[k];
        passed = state->far[k] * gx[k] + state->slope[k] * gu[k];
    }
    b[(long long)p->nodes * q] = passed;
}

MRTS_LOCAL void mrts_front_scatter(const mrts_smooth_program *p, const mrts_smooth_state *state, const double *b,
                                   double *dx, double *du, double *df) {
    const int n = p->nodes, f = p->free, q = f + 1;
    for (int k = 0; k < n; ++k) {
        const double *here = b + (long long)k * q;
        const double c = here[f], next = k < n - 1 ? here[q + f] : here[q];
        for (int i = 0; i < f; ++i) df[(long long)k * f + i] = here[i];
        dx[k] = state->near[k] * c + state->far[k] * next;
        du[k] = state->slope[k] * (next - c);
    }
}

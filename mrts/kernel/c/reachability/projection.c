/* SPDX-License-Identifier: MIT
 *
 * Corners are found by linear programs: outward of every edge, until nothing lies outside.
 */
#include "projection.h"

/* A corner, with the rows that determine it and how their multipliers depend on the direction (du, dx). */
typedef struct {
    double *at;   /* u, x */
    double *rate; /* of du and of dx, (2, k) */
    int *basis;
} mrts_corner;

/* Where the corners of a polygon are, linked counter-clockwise, and work of their programs. */
typedef struct {
    int k, count;
    double *places;
    int *bases;
    int next[MRTS_CORNERS];
    double *work;
    int *iwork;
} mrts_polygon;

static mrts_corner mrts_corner_at(const mrts_polygon *of, int n) {
    double *place = of->places + n * (2 + 2 * of->k);
    const mrts_corner corner = {place, place + 2, of->bases + n * of->k};
    return corner;
}

/* What rounding of a corner is measured by. */
static double mrts_corner_size(const double *p) { return 1 + MRTS_ABS(p[0]) + MRTS_ABS(p[1]); }

/* Whether two corners differ by no more than rounding. */
static int mrts_same_corner(const double *p, const double *q) {
    return MRTS_ABS(p[0] - q[0]) + MRTS_ABS(p[1] - q[1]) <= MRTS_OUTSIDE * mrts_corner_size(p);
}

/* Whether a point keeps all limits, but for rounding. */
static int mrts_keeps_limits(const mrts_polytope *in, const double *z) {
    for (int row = 0; row < in->rows + in->k; ++row) {
        const double value = mrts_lp_value(in->rows, in->A, in->k, row, z), low = in->lower[row], high = in->upper[row];
        if (!(low - value <= MRTS_FEASIBLE * (1 + MRTS_ABS(low)))) return 0;
        if (!(value - high <= MRTS_FEASIBLE * (1 + MRTS_ABS(high)))) return 0;
    }
    return 1;
}

/* The corner that lies furthest in a direction, by a linear program from the basis that it holds (basis[0] == 0: cold);
 * a status of mrts_lp. */
static int mrts_furthest(const mrts_polytope *in, const mrts_polygon *of, const double *direction, mrts_corner corner) {
    const int k = in->k;
    double *g = of->work, *z = g + k, *y = z + k, *inverse = y + k; /* mrts_lp leaves its columns there */
    int entering, status = MRTS_STOPPED;
    for (int j = 0; j < k; ++j) g[j] = 0;
    g[k - 2] = -direction[0];
    g[k - 1] = -direction[1];
    for (int attempt = 0; attempt < 2; ++attempt) {
        const int cold = corner.basis[0] == 0;
        status = mrts_lp(k, in->rows, in->A, in->lower, in->upper, g, corner.basis, z, y, &entering, inverse, of->iwork);
        if (status == MRTS_OPTIMAL || cold) break;
        corner.basis[0] = 0;
    }
    /* rows that are alike but for rounding leave multipliers of either sign: nearly the furthest is good enough */
    if (status == MRTS_STOPPED && mrts_keeps_limits(in, z)) status = MRTS_OPTIMAL;
    if (status != MRTS_OPTIMAL) corner.basis[0] = 0;
    corner.at[0] = z[k - 2];
    corner.at[1] = z[k - 1];
    for (int j = 0; j < k; ++j) {
        corner.rate[j] = -inverse[j * k + k - 2];
        corner.rate[k + j] = -inverse[j * k + k - 1];
    }
    return status;
}

/* Whether the multipliers of a corner show that nothing lies further out in a direction: they have the signs of limits that
 * there are (a free unknown of a basis has none), and make it up of the rows as given. */
static int mrts_is_furthest(const mrts_polytope *in, const mrts_polygon *of, mrts_corner corner, const double *direction) {
    const int k = in->k;
    double *y = of->work, *rest = y + k, size = 1;
    for (int j = 0; j < k; ++j) {
        y[j] = direction[0] * corner.rate[j] + direction[1] * corner.rate[k + j];
        size = mrts_larger(MRTS_ABS(y[j]), size);
        rest[j] = 0;
    }
    rest[k - 2] = direction[0];
    rest[k - 1] = direction[1];
    for (int j = 0; j < k; ++j) {
        const int code = corner.basis[j], row = mrts_abs(code) - 1;
        if (code < 0 ? y[j] > 0 && in->lower[row] > -MRTS_INFINITY : y[j] < 0 && in->upper[row] < MRTS_INFINITY) continue;
        if (MRTS_ABS(y[j]) > MRTS_OUTSIDE / 10 * size && in->lower[row] != in->upper[row]) return 0;
    }
    for (int j = 0; j < k; ++j) {
        const int row = mrts_abs(corner.basis[j]) - 1;
        for (int i = 0; i < k && row < in->rows; ++i) rest[i] += y[j] * in->A[row * k + i];
        if (row >= in->rows) rest[row - in->rows] += y[j];
    }
    for (int i = 0; i < k; ++i) {
        if (!(MRTS_ABS(rest[i]) <= MRTS_FEASIBLE * size)) return 0;
    }
    return 1;
}

/* Whether nothing lies outside of the edge from a corner to the next, whose unit normal, outward, it becomes. */
static int mrts_is_final(const mrts_polytope *in, const mrts_polygon *of, int at, double *normal) {
    const mrts_corner p = mrts_corner_at(of, at), q = mrts_corner_at(of, of->next[at]);
    normal[0] = q.at[1] - p.at[1];
    normal[1] = p.at[0] - q.at[0];
    const double length = MRTS_SQRT(normal[0] * normal[0] + normal[1] * normal[1]);
    if (!(length > 0)) return 1;
    normal[0] /= length;
    normal[1] /= length;
    return mrts_is_furthest(in, of, p, normal) || mrts_is_furthest(in, of, q, normal);
}

/* The corners furthest along the axes, the first from a basis (basis[0] == 0: cold); a status of mrts_lp. */
static int mrts_axis_corners(const mrts_polytope *in, const int *basis, mrts_polygon *found) {
    static const double axes[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    for (int d = 0; d < 4; ++d) {
        const int n = found->count;
        const mrts_corner corner = mrts_corner_at(found, n), before = mrts_corner_at(found, n > 0 ? n - 1 : 0);
        if (n > 0 && mrts_is_furthest(in, found, before, axes[d])) continue;
        for (int j = 0; j < in->k; ++j) corner.basis[j] = n > 0 ? before.basis[j] : basis[j];
        const int status = mrts_furthest(in, found, axes[d], corner);
        if (status != MRTS_OPTIMAL) return status;
        if (n > 0 && mrts_same_corner(corner.at, before.at)) continue;
        if (n > 0) found->next[n - 1] = n;
        found->next[n] = 0;
        ++found->count;
    }
    const int last = found->count - 1; /* which may be the first */
    if (last > 0 && mrts_same_corner(mrts_corner_at(found, last).at, found->places)) {
        found->next[last - 1] = 0;
        --found->count;
    }
    return MRTS_OPTIMAL;
}

/* Corners outward of the edges until nothing lies outside; a status of mrts_lp. */
static int mrts_close(const mrts_polytope *in, mrts_polygon *of) {
    int at = 0;
    while (of->count > 1) {
        double normal[2];
        if (of->count < MRTS_CORNERS && !mrts_is_final(in, of, at, normal)) {
            const mrts_corner p = mrts_corner_at(of, at), q = mrts_corner_at(of, of->next[at]);
            const mrts_corner r = mrts_corner_at(of, of->count);
            for (int j = 0; j < in->k; ++j) r.basis[j] = p.basis[j];
            const int status = mrts_furthest(in, of, normal, r);
            if (status != MRTS_OPTIMAL) return status;
            const double beyond = normal[0] * (r.at[0] - p.at[0]) + normal[1] * (r.at[1] - p.at[1]);
            if (beyond > MRTS_OUTSIDE * mrts_corner_size(p.at) && !mrts_same_corner(r.at, p.at) &&
                !mrts_same_corner(r.at, q.at)) {
                of->next[of->count] = of->next[at];
                of->next[at] = of->count++;
                continue;
            }
        }
        at = of->next[at];
        if (at == 0) break;
    }
    return MRTS_OPTIMAL;
}

MRTS_LOCAL int mrts_project(const mrts_polytope *in, mrts_outline *outline, int *count, double *corners, double *work,
                            int *iwork) {
    const int k = in->k;
    mrts_polygon found = {.k = k, .work = work, .iwork = iwork};
    found.places = work + MRTS_LP_WORK(k) + 3 * k;
    found.bases = iwork + MRTS_LP_IWORK(k, in->rows);
    if (outline->count == 0) outline->basis[0] = 0;
    int status = mrts_axis_corners(in, outline->basis, &found);
    if (status == MRTS_OPTIMAL) status = mrts_close(in, &found);
    outline->count = status == MRTS_OPTIMAL ? found.count : 0;
    *count = outline->count;
    for (int i = 0, at = 0; i < outline->count; ++i, at = found.next[at]) {
        const mrts_corner corner = mrts_corner_at(&found, at);
        corners[2 * i] = corner.at[0];
        corners[2 * i + 1] = corner.at[1];
        for (int j = 0; j < k; ++j) outline->basis[i * k + j] = corner.basis[j];
    }
    return status;
}

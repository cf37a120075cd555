/* SPDX-License-Identifier: MIT
 *
 * The projection of a polytope onto two of its unknowns, from inside: the corners are the projections of linear
 * programs' answers, so whatever is a mixture of them is feasible.
 */
#include "linear_programs.h"

/* Most corners of one projection; a polygon with more is replaced by one inside it. */
#define MRTS_CORNERS 64

/* An edge is final if nothing lies further out than this, in units of the limits and of the corners' size. */
#define MRTS_OUTSIDE 1e-9

/* A corner, with the rows that determine it and how their multipliers depend on the direction (du, dx). */
typedef struct {
    double *at;   /* u, x */
    double *rate; /* k pairs */
    int *basis;
} mrts_corner;

/* Corner n in the memory of all. */
static mrts_corner mrts_corner_at(int n, int k, double *places, int *bases) {
    const mrts_corner corner = {places + n * (2 + 2 * k), places + n * (2 + 2 * k) + 2, bases + n * k};
    return corner;
}

/* Whether z keeps all limits, but for rounding. */
static int mrts_keeps_limits(int k, int rows, const double *A, const double *lower, const double *upper,
                             const double *z) {
    for (int row = 0; row < rows + k; ++row) {
        const double value = mrts_lp_value(rows, A, k, row, z);
        if (!(value >= lower[row] - MRTS_FEASIBLE * (1 + MRTS_ABS(lower[row])))) return 0;
        if (!(value <= upper[row] + MRTS_FEASIBLE * (1 + MRTS_ABS(upper[row])))) return 0;
    }
    return 1;
}

/* The corner of { z : limits } that lies furthest in the direction (du, dx) of the last two unknowns, starting from the
 * basis that it holds (basis[0] == 0: cold). */
static int mrts_furthest(int k, int rows, const double *A, const double *lower, const double *upper, double du,
                         double dx, mrts_corner corner, double *work, int *iwork) {
    double *g = work, *z = g + k, *y = z + k, *lp_work = y + k;
    int entering, status = MRTS_STOPPED;
    for (int j = 0; j < k; ++j) g[j] = 0;
    g[k - 2] = -du;
    g[k - 1] = -dx;
    for (int attempt = 0; attempt < 2; ++attempt) {
        const int cold = corner.basis[0] == 0;
        status = mrts_lp(k, rows, A, lower, upper, g, corner.basis, z, y, &entering, lp_work, iwork);
        if (status == MRTS_OPTIMAL || cold) break;
        corner.basis[0] = 0;
    }
    /* rows that are alike but for rounding leave multipliers of either sign: nearly the furthest is good enough */
    if (status == MRTS_STOPPED && mrts_keeps_limits(k, rows, A, lower, upper, z)) status = MRTS_OPTIMAL;
    if (status != MRTS_OPTIMAL) corner.basis[0] = 0;
    corner.at[0] = z[k - 2];
    corner.at[1] = z[k - 1];
    for (int j = 0; j < k; ++j) { /* lp_work starts with the columns of the basis' inverse */
        corner.rate[2 * j] = -lp_work[j * k + k - 2];
        corner.rate[2 * j + 1] = -lp_work[j * k + k - 1];
    }
    return status;
}

/* Whether a corner is the furthest in a direction as well: its multipliers keep their signs, and those that need a limit
 * have one (a free unknown of a basis has none). */
static int mrts_is_furthest(int k, const double *lower, const double *upper, mrts_corner corner, double du, double dx) {
    double size = 1;
    for (int j = 0; j < k; ++j) {
        const double y = du * corner.rate[2 * j] + dx * corner.rate[2 * j + 1];
        if (MRTS_ABS(y) > size) size = MRTS_ABS(y);
    }
    for (int j = 0; j < k; ++j) {
        const double y = du * corner.rate[2 * j] + dx * corner.rate[2 * j + 1];
        const int at_lower = corner.basis[j] < 0, row = (at_lower ? -corner.basis[j] : corner.basis[j]) - 1;
        const int held = at_lower ? lower[row] > -MRTS_INFINITY : upper[row] < MRTS_INFINITY;
        const double least = held && at_lower ? MRTS_INFINITY : MRTS_OUTSIDE / 10 * size;
        const double most = held && !at_lower ? MRTS_INFINITY : MRTS_OUTSIDE / 10 * size;
        if (y > least || y < -most) return 0;
    }
    return 1;
}

/* What rounding of a corner is measured by. */
static double mrts_corner_size(const double *p) { return 1 + MRTS_ABS(p[0]) + MRTS_ABS(p[1]); }

/* Whether two corners differ by no more than rounding. */
static int mrts_same_corner(const double *p, const double *q) {
    return MRTS_ABS(p[0] - q[0]) + MRTS_ABS(p[1] - q[1]) <= MRTS_OUTSIDE * mrts_corner_size(p);
}

/* The corners of one projection, counter-clockwise in the plane (u, x); returns a status of mrts_lp. */
static int mrts_project(int k, int rows, const double *A, const double *lower, const double *upper, int *count,
                        double *corners, double *places, int *bases, double *work, int *iwork) {
    static const double first[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    int next[MRTS_CORNERS], n = 0, at = 0;
    for (int d = 0; d < 4; ++d) {
        const mrts_corner corner = mrts_corner_at(n, k, places, bases);
        if (n > 0) {
            const mrts_corner before = mrts_corner_at(n - 1, k, places, bases);
            if (mrts_is_furthest(k, lower, upper, before, first[d][0], first[d][1])) continue;
            for (int j = 0; j < k; ++j) corner.basis[j] = before.basis[j];
        }
        const int status = mrts_furthest(k, rows, A, lower, upper, first[d][0], first[d][1], corner, work, iwork);
        if (status != MRTS_OPTIMAL) return status;
        if (n == 0 || !mrts_same_corner(corner.at, mrts_corner_at(n - 1, k, places, bases).at)) ++n;
    }
    if (n > 1 && mrts_same_corner(mrts_corner_at(n - 1, k, places, bases).at, places)) --n;
    for (int i = 0; i < n; ++i) next[i] = (i + 1) % n;
    while (n > 1) {
        const mrts_corner p = mrts_corner_at(at, k, places, bases), q = mrts_corner_at(next[at], k, places, bases);
        double du = q.at[1] - p.at[1], dx = p.at[0] - q.at[0];
        const double length = MRTS_SQRT(du * du + dx * dx);
        if (length > 0 && n < MRTS_CORNERS) {
            du /= length;
            dx /= length;
            if (!mrts_is_furthest(k, lower, upper, p, du, dx) &&
                !mrts_is_furthest(k, lower, upper, q, du, dx)) {
                const mrts_corner r = mrts_corner_at(n, k, places, bases);
                for (int j = 0; j < k; ++j) r.basis[j] = p.basis[j];
                const int status = mrts_furthest(k, rows, A, lower, upper, du, dx, r, work, iwork);
                if (status != MRTS_OPTIMAL) return status;
                if (du * (r.at[0] - p.at[0]) + dx * (r.at[1] - p.at[1]) > MRTS_OUTSIDE * mrts_corner_size(p.at) &&
                    !mrts_same_corner(r.at, p.at) && !mrts_same_corner(r.at, q.at)) {
                    next[n] = next[at];
                    next[at] = n++;
                    continue;
                }
            }
        }
        at = next[at];
        if (at == 0) break;
    }
    *count = n;
    at = 0;
    for (int i = 0; i < n; ++i, at = next[at]) {
        const double *place = mrts_corner_at(at, k, places, bases).at;
        corners[2 * i] = place[0];
        corners[2 * i + 1] = place[1];
    }
    return MRTS_OPTIMAL;
}

/* Reals and ints of work of the projections below. */
MRTS_EXPORT void mrts_project_batch_work(int k, int rows, long long *reals, long long *ints) {
    *reals = MRTS_LP_WORK(k) + 3 * k + (MRTS_CORNERS + 1) * (2 + 2 * k);
    *ints = MRTS_LP_IWORK(k, rows) + (MRTS_CORNERS + 1) * k;
}

/* `count` projections of { z : lower <= (A z, z) <= upper }, limits of the rows and then of the unknowns; each starts from
 * the first corner of the one before, the first of a chunk cold. */
MRTS_EXPORT void mrts_project_batch(long long count, int k, int rows, const double *A, const double *lower,
                                    const double *upper, int *corner_count, double *corners, unsigned char *status,
                                    double *work, int *iwork) {
    double *places = work + MRTS_LP_WORK(k) + 3 * k;
    int *bases = iwork + MRTS_LP_IWORK(k, rows);
    for (long long n = 0; n < count; ++n) {
        if (n % MRTS_CHUNK == 0) bases[0] = 0;
        corner_count[n] = 0;
        status[n] = (unsigned char)mrts_project(k, rows, A + n * rows * k, lower + n * (rows + k), upper + n * (rows + k),
                                                corner_count + n, corners + n * 2 * MRTS_CORNERS, places, bases, work,
                                                iwork);
    }
}

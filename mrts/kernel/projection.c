/* SPDX-License-Identifier: MIT
 *
 * The projection of a polytope onto two of its unknowns, from inside: the corners are the projections of linear
 * programs' answers, so whatever is a mixture of them is feasible.
 */

/* Most corners of one projection; a polygon with more is replaced by one inside it. */
#define MRTS_CORNERS 64

/* An edge is final if nothing lies further out than this, in units of the limits and of the corners' size. */
#define MRTS_OUTSIDE 1e-9

/* The corner of { z : limits } that lies furthest in the direction (du, dx) of the last two unknowns. */
static int mrts_furthest(int k, int rows, const double *A, const double *lower, const double *upper, double du,
                         double dx, int *basis, double *corner, double *work, int *iwork) {
    double *g = work, *z = g + k, *y = z + k, *lp_work = y + k;
    int entering, status = MRTS_STOPPED;
    for (int j = 0; j < k; ++j) g[j] = 0;
    g[k - 2] = -du;
    g[k - 1] = -dx;
    for (int attempt = 0; attempt < 2; ++attempt) {
        const int cold = basis[0] == 0;
        status = mrts_lp(k, rows, A, lower, upper, g, basis, z, y, &entering, lp_work, iwork);
        if (status == MRTS_OPTIMAL || cold) break;
        basis[0] = 0;
    }
    if (status != MRTS_OPTIMAL) basis[0] = 0;
    corner[0] = z[k - 2];
    corner[1] = z[k - 1];
    return status;
}

static double mrts_size(const double *p) { return 1 + MRTS_ABS(p[0]) + MRTS_ABS(p[1]); }

static int mrts_same_corner(const double *p, const double *q) {
    return MRTS_ABS(p[0] - q[0]) + MRTS_ABS(p[1] - q[1]) <= MRTS_OUTSIDE * mrts_size(p);
}

/* The corners of one projection, counter-clockwise in the plane (u, x); returns a status of mrts_lp. */
static int mrts_project(int k, int rows, const double *A, const double *lower, const double *upper, int *basis,
                        int *count, double *corners, double *work, int *iwork) {
    static const double first[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    double found[MRTS_CORNERS][2];
    int next[MRTS_CORNERS], n = 0, at = 0;
    for (int d = 0; d < 4; ++d) {
        const int status = mrts_furthest(k, rows, A, lower, upper, first[d][0], first[d][1], basis, found[n], work, iwork);
        if (status != MRTS_OPTIMAL) return status;
        if (n == 0 || !mrts_same_corner(found[n], found[n - 1])) ++n;
    }
    if (n > 1 && mrts_same_corner(found[n - 1], found[0])) --n;
    for (int i = 0; i < n; ++i) next[i] = (i + 1) % n;
    while (n > 1) {
        const double *p = found[at], *q = found[next[at]];
        double du = q[1] - p[1], dx = p[0] - q[0];
        const double length = MRTS_SQRT(du * du + dx * dx);
        if (length > 0 && n < MRTS_CORNERS) {
            du /= length;
            dx /= length;
            const int status = mrts_furthest(k, rows, A, lower, upper, du, dx, basis, found[n], work, iwork);
            if (status != MRTS_OPTIMAL) return status;
            const double *r = found[n];
            if (du * (r[0] - p[0]) + dx * (r[1] - p[1]) > MRTS_OUTSIDE * mrts_size(p) && !mrts_same_corner(r, p) &&
                !mrts_same_corner(r, q)) {
                next[n] = next[at];
                next[at] = n++;
                continue;
            }
        }
        at = next[at];
        if (at == 0) break;
    }
    *count = n;
    at = 0;
    for (int i = 0; i < n; ++i, at = next[at]) {
        corners[2 * i] = found[at][0];
        corners[2 * i + 1] = found[at][1];
    }
    return MRTS_OPTIMAL;
}

/* `count` projections of { z : lower <= (A z, z) <= upper }, limits of the rows and then of the unknowns. */
MRTS_EXPORT void mrts_project_batch(long long count, int k, int rows, const double *A, const double *lower,
                                    const double *upper, int *corner_count, double *corners, unsigned char *status,
                                    double *work, int *iwork) {
    int *basis = iwork + MRTS_LP_IWORK(k, rows);
    basis[0] = 0;
    for (long long n = 0; n < count; ++n) {
        corner_count[n] = 0;
        status[n] = (unsigned char)mrts_project(k, rows, A + n * rows * k, lower + n * (rows + k), upper + n * (rows + k),
                                                basis, corner_count + n, corners + n * 2 * MRTS_CORNERS, work, iwork);
    }
}

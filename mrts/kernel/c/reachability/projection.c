/* SPDX-License-Identifier: MIT
 *
 * Corners are found by linear programs: outward of every edge, until nothing lies outside. Of the sample before the bases of
 * all corners are known; where they hold here as well, as nearly always, no program is solved, and each corner and each edge
 * is verified all the same.
 */
#include "projection.h"

/* Where the corners of a polygon are, linked counter-clockwise. */
typedef struct {
    int count;
    double *places;
    int *bases;
    int next[MRTS_CORNERS];
} mrts_polygon;

static mrts_corner mrts_polygon_corner(const mrts_polygon *of, int k, int n) {
    return mrts_corner_at(n, k, of->places, of->bases);
}

/* One more corner, whose memory is filled, unless it is the one before. */
static void mrts_append(mrts_polygon *to, int k) {
    const int n = to->count;
    if (n > 0 && mrts_same_corner(mrts_polygon_corner(to, k, n).at, mrts_polygon_corner(to, k, n - 1).at)) return;
    to->next[n] = 0;
    if (n > 0) to->next[n - 1] = n;
    ++to->count;
}

/* The last corner may be the first. */
static void mrts_join(mrts_polygon *of, int k) {
    const int last = of->count - 1;
    if (last < 1 || !mrts_same_corner(mrts_polygon_corner(of, k, last).at, of->places)) return;
    of->next[last - 1] = 0;
    --of->count;
}

/* The corners of an outline that are corners here; returns whether all are. */
static int mrts_known_corners(mrts_polytope *in, const mrts_outline *outline, mrts_polygon *found) {
    const int k = in->k;
    int all = 1;
    found->count = 0;
    for (int i = 0; i < outline->count; ++i) {
        const mrts_corner corner = mrts_polygon_corner(found, k, found->count);
        for (int j = 0; j < k; ++j) corner.basis[j] = outline->basis[i * k + j];
        if (mrts_is_corner(in, corner)) {
            mrts_append(found, k);
        } else {
            all = 0;
        }
    }
    mrts_join(found, k);
    return all;
}

/* The unit normal of an edge, outward; its length */
static double mrts_normal(const double *p, const double *q, double *normal) {
    normal[0] = q[1] - p[1];
    normal[1] = p[0] - q[0];
    const double length = MRTS_SQRT(normal[0] * normal[0] + normal[1] * normal[1]);
    if (length > 0) {
        normal[0] /= length;
        normal[1] /= length;
    }
    return length;
}

/* Whether nothing lies outside of the edge from a corner to the next. */
static int mrts_is_final(mrts_polytope *in, const mrts_polygon *of, int at, double *normal) {
    const mrts_corner p = mrts_polygon_corner(of, in->k, at), q = mrts_polygon_corner(of, in->k, of->next[at]);
    return mrts_normal(p.at, q.at, normal) == 0 || mrts_is_furthest(in, p, normal) || mrts_is_furthest(in, q, normal);
}

/* Whether nothing lies outside of any edge. As each edge leads on from the one before, they then go round all of it. */
static int mrts_is_closed(mrts_polytope *in, const mrts_polygon *of) {
    double normal[2];
    for (int at = 0; at < of->count; ++at) {
        if (!mrts_is_final(in, of, at, normal)) return 0;
    }
    return of->count > 2;
}

/* Leaves the corners that lie furthest in some direction; returns whether these turn once round, each by less than half a
 * turn from the one before, so that they are the corners of a convex polygon in order. */
static int mrts_keep_outermost(mrts_polytope *in, mrts_polygon *of) {
    const int k = in->k, count = of->count;
    double first[2] = {0, 0}, before[2] = {0, 0}, direction[2];
    int turns = 0;
    of->count = 0;
    for (int i = 0; i <= count; ++i) {
        const mrts_corner corner = mrts_polygon_corner(of, k, i), to = mrts_polygon_corner(of, k, of->count);
        if (i == count) {
            direction[0] = first[0];
            direction[1] = first[1];
        } else if (!mrts_outward(in, corner, direction)) {
            continue;
        }
        if (of->count > 0) {
            if (!(before[0] * direction[1] - before[1] * direction[0] > 0)) return 0;
            turns += before[1] < 0 && direction[1] >= 0;
        } else {
            first[0] = direction[0];
            first[1] = direction[1];
        }
        before[0] = direction[0];
        before[1] = direction[1];
        if (i == count) break;
        for (int j = 0; j < MRTS_CORNER_WORK(k); ++j) to.at[j] = corner.at[j];
        for (int j = 0; j < k; ++j) to.basis[j] = corner.basis[j];
        mrts_append(of, k);
    }
    return of->count > 2 && turns == 1;
}

/* The corners furthest along the axes, the first from a basis (basis[0] == 0: cold); a status of mrts_lp. */
static int mrts_axis_corners(mrts_polytope *in, const int *basis, mrts_polygon *found, double *work, int *iwork) {
    static const double axes[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    const int k = in->k;
    found->count = 0;
    for (int d = 0; d < 4; ++d) {
        const mrts_corner corner = mrts_polygon_corner(found, k, found->count);
        if (found->count > 0) {
            const mrts_corner before = mrts_polygon_corner(found, k, found->count - 1);
            if (mrts_is_furthest(in, before, axes[d])) continue;
            for (int j = 0; j < k; ++j) corner.basis[j] = before.basis[j];
        } else {
            for (int j = 0; j < k; ++j) corner.basis[j] = basis[j];
        }
        const int status = mrts_furthest(in, axes[d], corner, work, iwork);
        if (status != MRTS_OPTIMAL) return status;
        mrts_append(found, k);
    }
    mrts_join(found, k);
    return MRTS_OPTIMAL;
}

/* Corners outward of the edges until nothing lies outside; a status of mrts_lp. */
static int mrts_close(mrts_polytope *in, mrts_polygon *of, double *work, int *iwork) {
    const int k = in->k;
    int at = 0;
    while (of->count > 1) {
        double normal[2];
        if (of->count < MRTS_CORNERS && !mrts_is_final(in, of, at, normal)) {
            const mrts_corner p = mrts_polygon_corner(of, k, at), q = mrts_polygon_corner(of, k, of->next[at]);
            const mrts_corner r = mrts_polygon_corner(of, k, of->count);
            for (int j = 0; j < k; ++j) r.basis[j] = p.basis[j];
            const int status = mrts_furthest(in, normal, r, work, iwork);
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

/* How many rows of a basis are not of another, or if there is none, have several coefficients: what it costs to turn to it. */
static int mrts_cost(const mrts_polytope *in, const int *basis, const int *from) {
    const int k = in->k;
    int cost = 0;
    for (int j = 0; j < k; ++j) {
        const int row = (basis[j] < 0 ? -basis[j] : basis[j]) - 1;
        int known = !from && (row >= in->rows || in->is_single[row]);
        for (int i = 0; from && i < k; ++i) known |= (from[i] < 0 ? -from[i] : from[i]) - 1 == row;
        cost += !known;
    }
    return cost;
}

/* What the next projection is started from, and with which corner: the edge before it is not gone along. */
static void mrts_remember(const mrts_polytope *in, const mrts_polygon *of, mrts_outline *outline) {
    const int k = in->k;
    int first = 0, least = 2 * k;
    for (int at = 0; at < of->count; ++at) {
        const int *here = of->bases + at * k, *ahead = of->bases + of->next[at] * k;
        const int cost = mrts_cost(in, ahead, 0) - mrts_cost(in, ahead, here);
        if (cost < least) {
            least = cost;
            first = of->next[at];
        }
    }
    outline->count = of->count > 2 ? of->count : 1;
    if (of->count < 3) first = 0;
    for (int i = 0, at = first; i < outline->count; ++i, at = of->next[at]) {
        for (int j = 0; j < k; ++j) outline->basis[i * k + j] = of->bases[at * k + j];
    }
}

MRTS_LOCAL int mrts_project(mrts_polytope *in, mrts_outline *outline, int *count, double *corners, double *work,
                            int *iwork) {
    const int k = in->k;
    mrts_polygon found;
    found.count = 0;
    found.places = work + MRTS_FURTHEST_WORK(k, in->rows);
    found.bases = iwork + MRTS_LP_IWORK(k, in->rows);
    const int known = outline->count > 2, all = known && mrts_known_corners(in, outline, &found);
    if (!all || !mrts_is_closed(in, &found)) {
        int status = MRTS_OPTIMAL;
        if (outline->count == 0) outline->basis[0] = 0;
        if (!known || !mrts_keep_outermost(in, &found)) {
            status = mrts_axis_corners(in, outline->basis, &found, work, iwork);
        }
        if (status == MRTS_OPTIMAL) status = mrts_close(in, &found, work, iwork);
        if (status != MRTS_OPTIMAL) {
            outline->count = 0;
            return status;
        }
        mrts_remember(in, &found, outline);
    }
    for (int i = 0, at = 0; i < found.count; ++i, at = found.next[at]) {
        const double *place = mrts_polygon_corner(&found, k, at).at;
        corners[2 * i] = place[0];
        corners[2 * i + 1] = place[1];
    }
    *count = found.count;
    return MRTS_OPTIMAL;
}

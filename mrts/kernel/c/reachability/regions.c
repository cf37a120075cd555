/* SPDX-License-Identifier: MIT
 *
 * The admissible pairs of u and x of whole batches in one call from Python.
 * Work is cut into chunks of fixed length by the caller, so results do not depend on the number of threads.
 */
#include "lane_corners.h"

/* The largest coefficient of each unknown in rows which[0 .. rows - 1] of `all` rows of A, without its sign: Shape (count, k).
 * Zeros on entry. */
MRTS_EXPORT void mrts_effects(long long count, int k, int all, int rows, const int *which, const double *A,
                              double *effect) {
    for (long long n = 0; n < count; ++n, A += all * k, effect += k) {
        for (int i = 0; i < rows; ++i) {
            const double *row = A + which[i] * k;
            for (int j = 0; j < k; ++j) {
                const double size = MRTS_ABS(row[j]);
                if (!(size <= effect[j])) effect[j] = size;
            }
        }
    }
}

/* The half-planes n_u u + n_x x <= h of polygons, number[n] corners (u, x) of each in a row, counter-clockwise: the edges that
 * are not those of |u| <= box or x <= cap (`near` is the share from which one is), and of a point or a segment what bounds it
 * along itself, where u has a unit. Units of u and x are (count, 2). Those of polygon n are start[n] .. start[n + 1] - 1 of
 * `planes`, which have room for two a polygon more than there are corners. Least and largest x of each too, 0 of none. */
MRTS_EXPORT void mrts_half_planes(long long count, const int *number, const double *corners, const double *unit,
                                  const double *cap, double box, double near, long long *start, double *planes, double *low,
                                  double *high) {
    double *next = planes;
    for (long long n = 0; n < count; corners += 2 * number[n++]) {
        const double u_unit = unit[2 * n], x_unit = unit[2 * n + 1];
        double least = INFINITY, most = -INFINITY;
        start[n] = (next - planes) / 3;
        low[n] = high[n] = number[n] > 0 ? corners[1] : 0;
        for (int i = 0; i < number[n]; ++i) {
            const double *here = corners + 2 * i, *after = corners + 2 * ((i + 1) % number[n]);
            const double along_u = after[0] - here[0], along_x = after[1] - here[1];
            const double length = MRTS_SQRT(along_u * along_u + along_x * along_x);
            const double inner = here[1] < after[1] ? here[1] : after[1], outer = here[1] < after[1] ? after[1] : here[1];
            if (here[0] < least) least = here[0];
            if (here[0] > most) most = here[0];
            if (here[1] < low[n]) low[n] = here[1];
            if (here[1] > high[n]) high[n] = here[1];
            if (!(length > 0) || (MRTS_ABS(here[0]) >= near * box && MRTS_ABS(after[0]) >= near * box)) continue;
            if (inner >= near * cap[n] || outer <= 1 / (box * box)) continue;
            const double normal_u = along_x / length, normal_x = -along_u / length;
            next[0] = normal_u / u_unit;
            next[1] = normal_x / x_unit;
            next[2] = normal_u * here[0] + normal_x * here[1];
            next += 3;
        }
        if (number[n] < 1 || number[n] > 2 || !(u_unit < INFINITY)) continue;
        next[0] = 1 / u_unit;
        next[3] = -1 / u_unit;
        next[1] = next[4] = 0;
        next[2] = most;
        next[5] = -least;
        next += 6;
    }
    start[count] = (next - planes) / 3;
}

/* Reals and ints of work of the projections below. */
MRTS_EXPORT void mrts_project_batch_work(int k, int rows, long long *reals, long long *ints) {
    *reals = MRTS_POLYTOPE_WORK(k, rows) + MRTS_PROJECT_WORK(k) + MRTS_LANE_POLYTOPES_WORK(k, rows);
    *ints = MRTS_OUTLINE_IWORK(k) + MRTS_PROJECT_IWORK(k, rows) + MRTS_LANE_POLYTOPES_IWORK(k);
}

/* The corners of one sample, in order. */
static void mrts_take_outline(const mrts_lane_polytopes *in, int lane, int count, double *corners) {
    for (int i = 0; i < count; ++i) {
        const mrts_lanes *corner = in->corner + i * MRTS_LANE_CORNER(in->of->k);
        corners[2 * i] = corner[0][lane];
        corners[2 * i + 1] = corner[1][lane];
    }
}

/* The polytope of a sample. */
static void mrts_take_polytope(const mrts_lane_polytopes *of, int lane, const mrts_polytope *in) {
    mrts_take_lane(in->rows * in->k, of->A, lane, in->A);
    mrts_take_lane(in->rows + in->k, of->lower, lane, in->lower);
    mrts_take_lane(in->rows + in->k, of->upper, lane, in->upper);
}

/* `count` projections of { z : lower <= A z <= upper, least <= (u, x) <= most }, see mrts_polytopes. Each starts from the one
 * before, the first of a chunk cold. */
MRTS_EXPORT void mrts_project_batch(long long count, int k, int all, int rows, const int *which, const double *A,
                                    const double *lower, const double *upper, const double *scale, const double *least,
                                    const double *most, int *corner_count, double *corners, unsigned char *status,
                                    double *work, int *iwork) {
    const mrts_polytopes of = {count, k, all, rows, which, A, lower, upper, scale, least, most};
    double *project_work = work + MRTS_POLYTOPE_WORK(k, rows);
    mrts_outline outline = {0, iwork};
    int *project_iwork = outline.basis + MRTS_OUTLINE_IWORK(k);
    const mrts_polytope in = {k, rows, work, work + rows * k, work + rows * k + rows + k};
    mrts_lane_polytopes lanes =
        mrts_lane_polytopes_in(&of, project_work + MRTS_PROJECT_WORK(k), project_iwork + MRTS_PROJECT_IWORK(k, rows));
    const mrts_lane_mask none = {0};
    mrts_lane_mask known = none;
    for (long long n = 0; n < count; ++n) {
        double *found = corners + n * 2 * MRTS_CORNERS;
        const int lane = (int)(n % MRTS_LANES);
        if (lane == 0) {
            mrts_take_polytopes(n, &lanes);
            known = outline.count > 2 ? mrts_known_outline(&lanes, &outline) : none;
        }
        if (known[lane]) {
            mrts_take_outline(&lanes, lane, outline.count, found);
            corner_count[n] = outline.count;
            status[n] = MRTS_OPTIMAL;
            continue;
        }
        mrts_take_polytope(&lanes, lane, &in);
        for (int attempt = 0; attempt < 2; ++attempt) {
            const int cold = outline.count == 0;
            corner_count[n] = 0;
            status[n] = (unsigned char)mrts_project(&in, &outline, corner_count + n, found, project_work, project_iwork);
            if (status[n] == MRTS_OPTIMAL || status[n] == MRTS_INFEASIBLE || cold) break;
        }
        known = lane + 1 < MRTS_LANES && outline.count > 2 ? mrts_known_outline(&lanes, &outline) : none; /* beside this one */
    }
}

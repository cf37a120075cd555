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

/* Reals and ints of work of the projections below. */
MRTS_EXPORT void mrts_project_batch_work(int k, int rows, long long *reals, long long *ints) {
    *reals = MRTS_POLYTOPE_WORK(k, rows) + MRTS_PROJECT_WORK(k, rows) + MRTS_LANE_POLYTOPES_WORK(k, rows);
    *ints = MRTS_POLYTOPE_IWORK(k, rows) + MRTS_OUTLINE_IWORK(k) + MRTS_PROJECT_IWORK(k, rows);
    *ints += MRTS_LANE_POLYTOPES_IWORK(k, rows);
}

#if MRTS_LANES > 1
/* Which unknown each row alone bounds, and which rows bound several. */
static void mrts_learn_alone(const mrts_polytope *of, mrts_lane_polytopes *in) {
    in->several_count = 0;
    for (int i = 0; i < of->rows; ++i) {
        in->alone[i] = -1;
        for (int j = 0; j < of->k && of->is_single[i]; ++j) {
            if (of->A[i * of->width + j] != 0) in->alone[i] = j;
        }
        if (in->alone[i] < 0) in->several[in->several_count++] = i;
    }
    for (int n = in->several_count; n % 4 != 0; ++n) in->several[n] = in->several[in->several_count - 1];
}

/* The corners of one sample, in order. */
static void mrts_take_outline(const mrts_lane_polytopes *in, int lane, int count, double *corners) {
    for (int i = 0; i < count; ++i) {
        const mrts_lanes *corner = in->corner + i * MRTS_LANE_CORNER(in->of->k);
        corners[2 * i] = corner[0][lane];
        corners[2 * i + 1] = corner[1][lane];
    }
}
#endif

/* The polytope of a sample. */
static void mrts_take_polytope(const mrts_polytopes *of, long long n, mrts_polytope *in) {
    const int k = of->k, rows = of->rows;
    const double *A = of->A + n * of->all * k, *lower = of->lower + n * of->all, *upper = of->upper + n * of->all;
    for (int i = 0; i < rows; ++i) {
        const int row = of->which[i];
        for (int j = 0; j < k; ++j) in->A[i * in->width + j] = A[row * k + j] * of->scale[n * k + j];
        in->lower[i] = mrts_finite(lower[row]);
        in->upper[i] = mrts_finite(upper[row]);
    }
    for (int j = 0; j < 2; ++j) {
        in->lower[rows + k - 2 + j] = mrts_finite(of->least[2 * n + j]);
        in->upper[rows + k - 2 + j] = mrts_finite(of->most[2 * n + j]);
    }
    mrts_begin_polytope(in);
}

/* `count` projections of { z : lower <= A z <= upper, least <= (u, x) <= most }, see mrts_polytopes. Each starts from the one
 * before, the first of a chunk cold. */
MRTS_EXPORT void mrts_project_batch(long long count, int k, int all, int rows, const int *which, const double *A,
                                    const double *lower, const double *upper, const double *scale, const double *least,
                                    const double *most, int *corner_count, double *corners, unsigned char *status,
                                    double *work, int *iwork) {
    const mrts_polytopes of = {count, k, all, rows, which, A, lower, upper, scale, least, most};
    double *project_work = work + MRTS_POLYTOPE_WORK(k, rows);
    mrts_outline outline = {0, iwork + MRTS_POLYTOPE_IWORK(k, rows)};
    int *project_iwork = outline.basis + MRTS_OUTLINE_IWORK(k);
    mrts_polytope in = mrts_polytope_in(k, rows, work, iwork);
    for (int j = 0; j < k - 2; ++j) {
        in.lower[rows + j] = -MRTS_INFINITY;
        in.upper[rows + j] = MRTS_INFINITY;
    }
#if MRTS_LANES > 1
    const mrts_corner_functions functions = mrts_corner_functions_here();
    mrts_lane_polytopes lanes =
        mrts_lane_polytopes_in(&of, project_work + MRTS_PROJECT_WORK(k, rows), project_iwork + MRTS_PROJECT_IWORK(k, rows));
    mrts_lane_mask known = {0};
#endif
    for (long long n = 0; n < count; ++n) {
        double *found = corners + n * 2 * MRTS_CORNERS;
        if (n % MRTS_CHUNK == 0) outline.count = 0;
#if MRTS_LANES > 1
        const int lane = (int)(n % MRTS_LANES);
        if (lane == 0) {
            known = (mrts_lane_mask){0};
            if (outline.count > 2) {
                functions.take(n, &lanes);
                functions.outline(&lanes, &outline, &known);
            }
        }
        if (known[lane]) {
            mrts_take_outline(&lanes, lane, outline.count, found);
            corner_count[n] = outline.count;
            status[n] = MRTS_OPTIMAL;
            continue;
        }
#endif
        mrts_take_polytope(&of, n, &in);
        for (int attempt = 0; attempt < 2; ++attempt) {
            const int cold = outline.count == 0;
            corner_count[n] = 0;
            status[n] = (unsigned char)mrts_project(&in, &outline, corner_count + n, found, project_work, project_iwork);
            if (status[n] == MRTS_OPTIMAL || status[n] == MRTS_INFEASIBLE || cold) break;
        }
#if MRTS_LANES > 1
        known = (mrts_lane_mask){0};
        if (outline.count > 2) { /* for the samples beside this one */
            mrts_learn_alone(&in, &lanes);
            if (lane + 1 < MRTS_LANES) {
                functions.take(n - lane, &lanes);
                functions.outline(&lanes, &outline, &known);
            }
        }
#endif
    }
}

/* SPDX-License-Identifier: MIT
 *
 * The admissible pairs of u and x of whole batches in one call from Python.
 * Work is cut into chunks of fixed length by the caller, so results do not depend on the number of threads.
 */
#include "projection.h"

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
    *reals = MRTS_POLYTOPE_WORK(k, rows) + MRTS_PROJECT_WORK(k, rows);
    *ints = MRTS_POLYTOPE_IWORK(k, rows) + MRTS_OUTLINE_IWORK(k) + MRTS_PROJECT_IWORK(k, rows);
}

/* A limit as mrts_lp has it. */
static double mrts_finite(double limit) {
    return limit < -MRTS_INFINITY ? -MRTS_INFINITY : limit > MRTS_INFINITY ? MRTS_INFINITY : limit;
}

/* `count` projections of { z : lower <= A z <= upper, least <= (u, x) <= most }, (u, x) being the last two of the k
 * unknowns: rows which[0 .. rows - 1] of `all` rows of A, Shape (count, all, k), whose columns are multiplied by scale,
 * Shape (count, k). least and most are (count, 2). Each starts from the one before, the first of a chunk cold. */
MRTS_EXPORT void mrts_project_batch(long long count, int k, int all, int rows, const int *which, const double *A,
                                    const double *lower, const double *upper, const double *scale, const double *least,
                                    const double *most, int *corner_count, double *corners, unsigned char *status,
                                    double *work, int *iwork) {
    double *project_work = work + MRTS_POLYTOPE_WORK(k, rows);
    mrts_outline outline = {0, iwork + MRTS_POLYTOPE_IWORK(k, rows)};
    int *project_iwork = outline.basis + MRTS_OUTLINE_IWORK(k);
    mrts_polytope in = mrts_polytope_in(k, rows, work, iwork);
    for (int j = 0; j < k - 2; ++j) {
        in.lower[rows + j] = -MRTS_INFINITY;
        in.upper[rows + j] = MRTS_INFINITY;
    }
    for (long long n = 0; n < count; ++n, A += all * k, lower += all, upper += all, scale += k, least += 2, most += 2) {
        for (int i = 0; i < rows; ++i) {
            for (int j = 0; j < k; ++j) in.A[i * in.width + j] = A[which[i] * k + j] * scale[j];
            in.lower[i] = mrts_finite(lower[which[i]]);
            in.upper[i] = mrts_finite(upper[which[i]]);
        }
        for (int j = 0; j < 2; ++j) {
            in.lower[rows + k - 2 + j] = mrts_finite(least[j]);
            in.upper[rows + k - 2 + j] = mrts_finite(most[j]);
        }
        mrts_begin_polytope(&in);
        if (n % MRTS_CHUNK == 0) outline.count = 0;
        for (int attempt = 0; attempt < 2; ++attempt) {
            const int cold = outline.count == 0;
            corner_count[n] = 0;
            status[n] = (unsigned char)mrts_project(&in, &outline, corner_count + n, corners + n * 2 * MRTS_CORNERS,
                                                    project_work, project_iwork);
            if (status[n] == MRTS_OPTIMAL || status[n] == MRTS_INFEASIBLE || cold) break;
        }
    }
}

/* SPDX-License-Identifier: MIT
 *
 * Whole batches in one call from Python: maps of generated functions, linear and quadratic programs.
 * Work is cut into chunks of fixed length by the caller, so results do not depend on the number of threads.
 */
#include "quadratic_programs.h"

/* Samples between cold starts. */
MRTS_EXPORT int mrts_chunk(void) { return MRTS_CHUNK; }

typedef int (*mrts_function)(const double **arg, double **res, long long *iw, double *w, int mem);

/* Evaluates a generated function at `count` samples; a stride of 0 repeats an input. */
MRTS_EXPORT int mrts_map(mrts_function function, long long count, int inputs, const double *const *in,
                         const long long *in_stride, int outputs, double *const *out, const long long *out_stride,
                         const double **arg, double **res, long long *iw, double *w) {
    for (long long sample = 0; sample < count; ++sample) {
        for (int i = 0; i < inputs; ++i) arg[i] = in[i] + sample * in_stride[i];
        for (int i = 0; i < outputs; ++i) res[i] = out[i] + sample * out_stride[i];
        if (function(arg, res, iw, w, 0)) return 1;
    }
    return 0;
}

/* Reals and ints of work of the batches below. */
MRTS_EXPORT void mrts_lp_batch_work(int k, int rows, long long *reals, long long *ints) {
    *reals = MRTS_LP_WORK(k) + k;
    *ints = MRTS_LP_IWORK(k, rows) + k;
}

MRTS_EXPORT void mrts_qp_batch_work(int k, int rows, long long *reals, long long *ints) {
    *reals = MRTS_QP_WORK(k) + k;
    *ints = MRTS_QP_IWORK(k, rows) + k;
}

/* `count` linear programs, each started from the answer of the one before. Limits of rows and, after them, of the
 * unknowns, Shape (count, rows + k). Multipliers likewise: g + A'dual_rows + dual_unknowns = 0. */
MRTS_EXPORT void mrts_lp_batch(long long count, int k, int rows, const double *g, const double *A, const double *lower,
                               const double *upper, double *x, double *dual, unsigned char *status, double *work,
                               int *iwork) {
    double *y = work + MRTS_LP_WORK(k);
    int *basis = iwork + MRTS_LP_IWORK(k, rows), entering;
    basis[0] = 0;
    for (long long n = 0; n < count; ++n) {
        const double *lo = lower + n * (rows + k), *up = upper + n * (rows + k);
        double *d = dual + n * (rows + k);
        int found = mrts_lp(k, rows, A + n * k * rows, lo, up, g + n * k, basis, x + n * k, y, &entering, work, iwork);
        if (found == MRTS_STOPPED) {
            basis[0] = 0;
            found = mrts_lp(k, rows, A + n * k * rows, lo, up, g + n * k, basis, x + n * k, y, &entering, work, iwork);
        }
        for (int i = 0; i < rows + k; ++i) d[i] = 0;
        for (int j = 0; j < k; ++j) d[(basis[j] < 0 ? -basis[j] : basis[j]) - 1] = -y[j];
        if (entering) d[(entering < 0 ? -entering : entering) - 1] = entering < 0 ? -1 : 1;
        status[n] = (unsigned char)found;
        if (found != MRTS_OPTIMAL) basis[0] = 0;
    }
}

/* `count` strictly convex quadratic programs; as above, with Hx + g + A'dual_rows + dual_unknowns = 0. */
MRTS_EXPORT void mrts_qp_batch(long long count, int k, int rows, const double *H, const double *g, const double *A,
                               const double *lower, const double *upper, double *x, double *dual,
                               unsigned char *status, double *work, int *iwork) {
    double *u = work + MRTS_QP_WORK(k);
    int *active = iwork + MRTS_QP_IWORK(k, rows), active_count;
    for (long long n = 0; n < count; ++n) {
        const double *lo = lower + n * (rows + k), *up = upper + n * (rows + k);
        double *d = dual + n * (rows + k);
        status[n] = (unsigned char)mrts_qp(k, rows, H + n * k * k, A + n * k * rows, lo, up, g + n * k, x + n * k, active,
                                           u, &active_count, work, iwork);
        for (int i = 0; i < rows + k; ++i) d[i] = 0;
        for (int j = 0; j < active_count; ++j) {
            d[(active[j] < 0 ? -active[j] : active[j]) - 1] = active[j] < 0 ? -u[j] : u[j];
        }
    }
}

/* SPDX-License-Identifier: MIT
 *
 * The range of c^2 and the torques along a whole trajectory: the generated wrench form evaluated at each sample, its
 * rows put together, and the programs solved, each started from the answer at the sample before.
 *
 * The cell's generated C and these macros come first:
 *     MRTS_JOINTS, MRTS_WRENCHES, MRTS_UNKNOWNS   sizes: torques, stacked wrench components, unknowns with c^2 last
 *     MRTS_WRENCH_FORM                            the generated function
 */

/* c^2 may grow until it moves some row by this many limits; beyond that nothing bounds it. */
#define MRTS_UNBOUNDED 1e9

/* Inputs of a moving sample: q, dq, ddq, rotation, twist, acceleration, load. */
enum { MRTS_INPUTS = 7, MRTS_OUTPUTS = 4 };

/* Rows over torques and wrenches, in compressed form: row i has the entries start[i] .. start[i + 1] - 1, each a column
 * (torques first, then wrenches) and a value; lower and upper limits and the unit that each row is measured in. */
typedef struct {
    int rows;
    const int *start;
    const int *column;
    const double *value;
    const double *lower;
    const double *upper;
    const double *unit;
} mrts_limits;

typedef struct {
    double torque_map[MRTS_UNKNOWNS * MRTS_JOINTS]; /* by columns */
    double torque_offset[MRTS_JOINTS];
    double wrench_map[MRTS_UNKNOWNS * MRTS_WRENCHES];
    double wrench_offset[MRTS_WRENCHES];
} mrts_form;

static int mrts_evaluate(const double *const *in, const long long *stride, long long sample, mrts_form *form,
                         const double **arg, double **res, long long *iw, double *w) {
    for (int i = 0; i < MRTS_INPUTS; ++i) arg[i] = in[i] + sample * stride[i];
    res[0] = form->torque_map;
    res[1] = form->torque_offset;
    res[2] = form->wrench_map;
    res[3] = form->wrench_offset;
    return MRTS_WRENCH_FORM(arg, res, iw, w, 0);
}

/* The rows of one sample, each in its unit: A (rows of MRTS_UNKNOWNS) and limits without the offsets. */
static void mrts_rows(const mrts_form *form, const mrts_limits *limits, double *A, double *lower, double *upper) {
    for (int row = 0; row < limits->rows; ++row) {
        double offset = 0, *a = A + row * MRTS_UNKNOWNS;
        const double per_unit = 1 / limits->unit[row];
        for (int j = 0; j < MRTS_UNKNOWNS; ++j) a[j] = 0;
        for (int entry = limits->start[row]; entry < limits->start[row + 1]; ++entry) {
            const int column = limits->column[entry], is_torque = column < MRTS_JOINTS;
            const int place = is_torque ? column : column - MRTS_JOINTS;
            const int size = is_torque ? MRTS_JOINTS : MRTS_WRENCHES;
            const double *map = is_torque ? form->torque_map : form->wrench_map;
            const double value = limits->value[entry] * per_unit;
            for (int j = 0; j < MRTS_UNKNOWNS; ++j) a[j] += value * map[j * size + place];
            offset += value * (is_torque ? form->torque_offset[place] : form->wrench_offset[place]);
        }
        lower[row] = limits->lower[row] <= -MRTS_INFINITY ? -MRTS_INFINITY : limits->lower[row] * per_unit - offset;
        upper[row] = limits->upper[row] >= MRTS_INFINITY ? MRTS_INFINITY : limits->upper[row] * per_unit - offset;
    }
}

static int mrts_all_finite(int count, const double *values) {
    for (int i = 0; i < count; ++i) {
        if (!(MRTS_ABS(values[i]) < MRTS_INFINITY)) return 0;
    }
    return 1;
}

/* An unknown that moves no row by more than this share of a limit moves none: its scale would not be finite. */
#define MRTS_NO_EFFECT 1e-300

/* Scales the unknowns so that each moves some row by one limit: x = column * x_scaled. */
static void mrts_scale(int k, int rows, double *A, int stride, double *column) {
    for (int j = 0; j < k; ++j) {
        double size = 0;
        for (int row = 0; row < rows; ++row) {
            const double value = MRTS_ABS(A[row * stride + j]);
            if (value > size) size = value;
        }
        const int moves = size > MRTS_NO_EFFECT;
        column[j] = moves ? 1 / size : 1;
        for (int row = 0; row < rows; ++row) A[row * stride + j] = moves ? A[row * stride + j] * column[j] : 0;
    }
}

/* Least and largest c^2 <= most of samples 0 .. count - 1. For each sample the status of both programs, the largest effect of
 * c^2 = 1 on a row, the rows that determine each end and their multipliers (see mrts_lp); the bounds of
 * c^2 are row rows + MRTS_UNKNOWNS - 1. */
MRTS_EXPORT int mrts_ranges(long long count, const double *const *in, const long long *stride,
                            const mrts_limits *limits, const double *most, double *low, double *high,
                            unsigned char *low_status,
                            unsigned char *high_status, double *effect, short *low_basis, short *high_basis,
                            float *low_dual, float *high_dual, const double **arg, double **res, long long *iw,
                            double *w, double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS };
    const int rows = limits->rows;
    double *A = work, *lower = A + rows * K, *upper = lower + rows + K, *lp_work = upper + rows + K;
    double g[K], x[K], y[K], column[K];
    int low_rows[K], high_rows[K], entering;
    mrts_form form;
    low_rows[0] = high_rows[0] = 0;
    for (int j = 0; j < K; ++j) g[j] = 0;
    for (long long n = 0; n < count; ++n) {
        if (n % MRTS_CHUNK == 0) low_rows[0] = high_rows[0] = 0; /* so that chunks do not depend on each other */
        if (mrts_evaluate(in, stride, n, &form, arg, res, iw, w)) return 1;
        mrts_rows(&form, limits, A, lower, upper);
        if (!mrts_all_finite(rows * K, A)) {
            low_status[n] = high_status[n] = MRTS_STOPPED;
            low_rows[0] = high_rows[0] = 0;
            continue;
        }
        mrts_scale(K, rows, A, K, column);
        effect[n] = 0;
        for (int row = 0; row < rows; ++row) {
            if (A[row * K + K - 1] != 0) effect[n] = 1 / column[K - 1];
        }
        for (int j = 0; j < K; ++j) {
            lower[rows + j] = j < K - 1 ? -MRTS_INFINITY : 0;
            upper[rows + j] = j < K - 1 ? MRTS_INFINITY : MRTS_UNBOUNDED;
        }
        if (most[n] / column[K - 1] < MRTS_UNBOUNDED) upper[rows + K - 1] = most[n] / column[K - 1];
        for (int end = 0; end < 2; ++end) {
            int *basis = end ? high_rows : low_rows;
            short *kept = (end ? high_basis : low_basis) + n * K;
            float *dual = (end ? high_dual : low_dual) + n * K;
            unsigned char *status = (end ? high_status : low_status) + n;
            if (end && low_status[n] != MRTS_OPTIMAL) {
                high_status[n] = low_status[n];
                high[n] = 0;
            } else {
                g[K - 1] = end ? -1 : 1;
                for (int attempt = 0; attempt < 2; ++attempt) {
                    *status = (unsigned char)mrts_lp(K, rows, A, lower, upper, g, basis, x, y, &entering, lp_work, iwork);
                    if (*status == MRTS_OPTIMAL || basis[0] == 0) break;
                    basis[0] = 0;
                }
                (end ? high : low)[n] = x[K - 1] * column[K - 1];
                if (end && x[K - 1] >= MRTS_UNBOUNDED * (1 - 1e-9)) high[n] = INFINITY;
            }
            for (int j = 0; j < K; ++j) {
                kept[j] = (short)basis[j];
                dual[j] = (float)y[j];
            }
            if (*status != MRTS_OPTIMAL) basis[0] = 0;
        }
    }
    return 0;
}

/* Torques and wrenches that minimise t'Wt at c2 (one value, or one a sample with c2_stride 1). Limits are widened by
 * `slack` of their unit where they are not equal. */
MRTS_EXPORT int mrts_torques(long long count, const double *const *in, const long long *stride,
                             const mrts_limits *limits, const double *c2, int c2_stride, const double *weights,
                             double slack, double *torque, double *wrench, unsigned char *status, const double **arg,
                             double **res, long long *iw, double *w, double *work, int *iwork) {
    enum { K = MRTS_UNKNOWNS, F = MRTS_UNKNOWNS - 1, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    const int rows = limits->rows;
    double *A = work, *lower = A + rows * K, *upper = lower + rows + K, *free_A = upper + rows + K;
    double *qp_work = free_A + rows * K;
    double H[F * F + 1], g[F + 1], x[K], u[F + 1], column[K], weighted[M], at_rest[M];
    int active[F + 1], active_count, is_diagonal = 1;
    mrts_form form;
    for (int i = 0; i < M; ++i) {
        for (int j = 0; j < M; ++j) is_diagonal &= i == j || weights[i * M + j] == 0;
    }
    for (long long n = 0; n < count; ++n) {
        const double speed = c2[n * c2_stride];
        double largest = 0;
        if (mrts_evaluate(in, stride, n, &form, arg, res, iw, w)) return 1;
        mrts_rows(&form, limits, A, lower, upper);
        if (!mrts_all_finite(rows * K, A)) {
            status[n] = MRTS_STOPPED;
            continue;
        }
        for (int row = 0; row < rows; ++row) {
            const double given = A[row * K + F] * speed;
            const double gap = limits->lower[row] < limits->upper[row] ? slack : 0;
            for (int j = 0; j < F; ++j) free_A[row * F + j] = A[row * K + j];
            if (lower[row] > -MRTS_INFINITY) lower[row] -= given + gap;
            if (upper[row] < MRTS_INFINITY) upper[row] += gap - given;
        }
        mrts_scale(F, rows, free_A, F, column);
        for (int j = 0; j < F; ++j) {
            lower[rows + j] = -MRTS_INFINITY;
            upper[rows + j] = MRTS_INFINITY;
            for (int i = 0; i < M; ++i) form.torque_map[j * M + i] *= column[j];
            for (int i = 0; i < N; ++i) form.wrench_map[j * N + i] *= column[j];
        }
        for (int i = 0; i < M; ++i) at_rest[i] = form.torque_map[F * M + i] * speed + form.torque_offset[i];
        for (int j = 0; j < F; ++j) {
            const double *map = form.torque_map + j * M;
            for (int i = 0; i < M; ++i) {
                weighted[i] = is_diagonal ? weights[i * M + i] * map[i] : mrts_dot(M, weights + i * M, map);
            }
            g[j] = mrts_dot(M, weighted, at_rest);
            for (int l = 0; l <= j; ++l) {
                H[j * F + l] = H[l * F + j] = mrts_dot(M, weighted, form.torque_map + l * M);
                if (MRTS_ABS(H[j * F + l]) > largest) largest = MRTS_ABS(H[j * F + l]);
            }
        }
        if (largest > 0) {
            for (int i = 0; i < F * F; ++i) H[i] /= largest;
            for (int j = 0; j < F; ++j) g[j] /= largest;
        }
        status[n] = (unsigned char)mrts_qp(F, rows, H, free_A, lower, upper, g, x, active, u, &active_count, qp_work,
                                           iwork);
        for (int i = 0; i < M; ++i) torque[n * M + i] = at_rest[i];
        for (int i = 0; i < N; ++i) wrench[n * N + i] = form.wrench_map[F * N + i] * speed + form.wrench_offset[i];
        for (int j = 0; j < F; ++j) {
            for (int i = 0; i < M; ++i) torque[n * M + i] += x[j] * form.torque_map[j * M + i];
            for (int i = 0; i < N; ++i) wrench[n * N + i] += x[j] * form.wrench_map[j * N + i];
        }
    }
    return 0;
}

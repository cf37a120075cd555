/* SPDX-License-Identifier: MIT
 *
 * The rows that set an end of a variant's range, and those that conflict where it has none.
 */
#include "../linear_programs.h"
#include "ranges.h"

/* As of mrts/program: a multiplier above this share of the largest binds; limits are moved outward by this share of
 * themselves, and a row is at its limit if no solution keeps further away than this share. One above MRTS_SURE is so in
 * any case. */
#define MRTS_BINDING 1e-7
#define MRTS_WIDER 3e-9
#define MRTS_NEAR 1e-4
#define MRTS_SURE 1e-2

/* Adds a row, coded as of a program, in its place; 0 if there is no more room. */
static int mrts_name(const mrts_limits *limits, const mrts_rows *rows, int code, int end, mrts_variant_range *range) {
    const int row = mrts_row_of_limits(limits, rows, code);
    int *named = range->rows[end], at = range->count[end];
    if (at == MRTS_MOST_NAMED) return 0;
    for (; at > 0 && mrts_abs(named[at - 1]) > mrts_abs(row); --at) named[at] = named[at - 1];
    named[at] = row;
    ++range->count[end];
    return 1;
}

/* The largest distance, at most 1, that wrenches within all limits can keep from some sides of rows at once, or more
 * than that where rounding leaves it open: what a program stops at is on the far side. `rows` has c^2 put in. */
static double mrts_keep_away(const mrts_rows *rows, int count, const int *sides, double *work, int *iwork) {
    enum { K = MRTS_VK, F = MRTS_VF };
    double *A = work, *lower = A + (rows->count + MRTS_MOST_NAMED) * K, *upper = lower + rows->count + MRTS_MOST_NAMED + K;
    double g[K], x[K], y[K];
    int basis[K] = {0}, entering;
    const int total = rows->count + count;
    for (int i = 0; i < total; ++i) {
        const int code = i < rows->count ? i + 1 : sides[i - rows->count], row = mrts_abs(code) - 1;
        for (int j = 0; j < F; ++j) A[i * K + j] = code > 0 ? rows->A[row * F + j] : -rows->A[row * F + j];
        A[i * K + F] = i < rows->count ? 0 : 1;
        lower[i] = i < rows->count ? rows->lower[i] : -MRTS_INFINITY;
        upper[i] = code > 0 ? rows->upper[row] : -rows->lower[row];
    }
    for (int j = 0; j < K; ++j) {
        lower[total + j] = j < F ? -MRTS_INFINITY : 0;
        upper[total + j] = j < F ? MRTS_INFINITY : 1;
        g[j] = j < F ? 0 : -1;
    }
    mrts_lp(K, total, A, lower, upper, g, basis, x, y, &entering, upper + rows->count + MRTS_MOST_NAMED + K, iwork);
    return x[F];
}

MRTS_LOCAL int mrts_name_rows(const mrts_samples *sample, mrts_rows *rows, int end, double c2, const double *x,
                              const int *basis, const double *y, mrts_variant_range *range, double *work, int *iwork) {
    enum { K = MRTS_VK, F = MRTS_VF };
    const mrts_limits *limits = sample->limits;
    int near[MRTS_MOST_NAMED], count = 0, sure[K], certain = 0;
    double largest = 0, column[K];
    for (int j = 0; j < K; ++j) largest = fmax(largest, fabs(y[j]));
    for (int j = 0; j < K; ++j) {
        const int row = mrts_abs(basis[j]) - 1;
        if (end && row >= rows->count && basis[j] > 0) range->capped = fabs(y[j]) > MRTS_BINDING * largest;
        if (row < rows->count && fabs(y[j]) > MRTS_SURE * largest) sure[certain++] = basis[j];
    }
    mrts_rows_of_lane(K, sample, 0, rows);
    mrts_fix_speed(K, limits, c2, MRTS_WIDER, rows);
    for (int i = 0; i < rows->count; ++i) {
        const double value = mrts_dot(F, rows->A + i * F, x);
        if (!(rows->upper[i] - rows->lower[i] > 2 * MRTS_NEAR)) continue;
        for (int code = i + 1; code >= -i - 1; code -= 2 * i + 2) {
            int is_sure = 0;
            if ((code > 0 ? rows->upper[i] - value : value - rows->lower[i]) > MRTS_NEAR) continue;
            for (int j = 0; j < certain; ++j) is_sure |= sure[j] == code;
            if (is_sure && !mrts_name(limits, rows, code, end, range)) return 0;
            if (is_sure) continue;
            if (count == MRTS_MOST_NAMED) return 0;
            near[count++] = code;
        }
    }
    if (count == 0) return 1;
    mrts_scale_columns(F, rows, column);
    if (mrts_keep_away(rows, count, near, work, iwork) > MRTS_NEAR) return 1;
    for (int i = 0; i < count; ++i) {
        if (mrts_keep_away(rows, 1, near + i, work, iwork) > MRTS_NEAR) continue;
        if (!mrts_name(limits, rows, near[i], end, range)) return 0;
    }
    return 1;
}

MRTS_LOCAL void mrts_name_conflict(const mrts_limits *limits, const mrts_rows *rows, const int *basis, const double *y,
                               int entering, mrts_variant_range *range) {
    double largest = 1;
    range->count[0] = 0;
    for (int j = 0; j < MRTS_VK; ++j) largest = fmax(largest, fabs(y[j]));
    for (int j = -1; j < MRTS_VK; ++j) {
        const int row = mrts_abs(j < 0 ? entering : basis[j]), above = j < 0 ? entering > 0 : y[j] < 0;
        if (row > rows->count || (j >= 0 && !(fabs(y[j]) > MRTS_SEPARATED * largest))) continue;
        mrts_name(limits, rows, above ? row : -row, 0, range);
    }
}

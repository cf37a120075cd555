/* SPDX-License-Identifier: MIT
 *
 * Linear programs one after another, one at a time.
 */
#include "kept_basis.h"

/* The row with the largest entry in column c, of those at place c and below, and its side, change places with those at c.
 */
static void mrts_take_pivot(int k, int c, int *row, int *side, mrts_real *B) {
    int best = c;
    mrts_real largest = MRTS_ABS(B[c * k + c]);
    for (int j = c + 1; j < k; ++j) {
        const mrts_real size = MRTS_ABS(B[j * k + c]);
        if (size > largest) {
            largest = size;
            best = j;
        }
    }
    if (best == c) return;
    const int its_row = row[c], its_side = side[c];
    row[c] = row[best];
    side[c] = side[best];
    row[best] = its_row;
    side[best] = its_side;
    for (int i = 0; i < k; ++i) {
        const mrts_real entry = B[c * k + i];
        B[c * k + i] = B[best * k + i];
        B[best * k + i] = entry;
    }
}

#define MRTS_STATIC static inline
#define MRTS_V mrts_real
#define MRTS_V_OF(value) ((mrts_real)(value))
#define MRTS_MASK int
#define MRTS_ALL 1
#define MRTS_CHOOSE(mask, a, b) ((mask) ? (a) : (b))
#define MRTS_BOTH(a, b) ((a) && (b))
#define MRTS_LARGER(a, b) mrts_larger(a, b)
#define MRTS_SIZE_OF(a) MRTS_ABS(a)
#define MRTS_OF(name) name
#define MRTS_TAKE_PIVOT(k, c, row, side, B) mrts_take_pivot(k, c, row, side, B)
#define MRTS_IS_NONE(value) ((value) == 0)
#include "kept_basis.inc"

MRTS_LOCAL int mrts_lp_again(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                             const mrts_real *g, int *basis, mrts_real *x, mrts_real *y, int *entering,
                             mrts_real *work, int *iwork) {
    int *row = iwork, *side = row + k;
    const int cold = basis[0] == 0;
    if (!cold) {
        for (int j = 0; j < k; ++j) {
            row[j] = mrts_abs(basis[j]) - 1;
            side[j] = basis[j];
        }
        if (mrts_kept_basis(k, rows, A, lower, upper, g, row, side, x, y, work, work + k * k)) {
            for (int j = 0; j < k; ++j) basis[j] = side[j];
            *entering = 0;
            return MRTS_OPTIMAL;
        }
    }
    const int status = mrts_lp(k, rows, A, lower, upper, g, basis, x, y, entering, work, iwork);
    if (status == MRTS_OPTIMAL || cold) return status;
    basis[0] = 0;
    return mrts_lp(k, rows, A, lower, upper, g, basis, x, y, entering, work, iwork);
}

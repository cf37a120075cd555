/* SPDX-License-Identifier: MIT
 *
 * Linear programs one after another: the basis of the one before is tried first.
 */
#ifndef MRTS_KEPT_BASIS_H
#define MRTS_KEPT_BASIS_H

#include "../linear_programs.h"

/* As mrts_lp, and of its answers; where the rows of `basis` still determine the minimiser they are only solved for, and
 * stay what they are, in the order of their pivots. Where a basis leads to no answer, the program starts cold. */
MRTS_LOCAL int mrts_lp_again(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                             const mrts_real *g, int *basis, mrts_real *x, mrts_real *y, int *entering,
                             mrts_real *work, int *iwork);

#endif

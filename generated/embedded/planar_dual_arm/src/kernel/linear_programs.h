/* SPDX-License-Identifier: MIT
 *
 * Small dense linear programs, solved exactly, one after another with slowly changing data.
 *
 *     minimise g'x  subject to   lower_i <= a_i'x <= upper_i,  i < rows
 *                          and   lower_(rows+j) <= x_j <= upper_(rows+j),  j < k
 *
 * The caller scales: the largest coefficient of each unknown and of each row is about 1; tolerances refer to that. Rows
 * are stored one after another; an absent limit is +-MRTS_INFINITY. Iterations are bounded.
 */
#ifndef MRTS_LINEAR_PROGRAMS_H
#define MRTS_LINEAR_PROGRAMS_H

#include "numbers.h"

/* How a program ends, a linear or a quadratic one. */
enum {
    MRTS_OPTIMAL = 0,
    MRTS_INFEASIBLE = 1, /* with a certificate */
    MRTS_MARGINAL = 2,   /* the limits miss each other by no more than rounding */
    MRTS_STOPPED = 3     /* iteration limit, or data that do not allow an answer */
};

/* Reals of work, and ints of work besides the basis. */
#define MRTS_LP_WORK(k) ((k) * (k) + (k))
#define MRTS_LP_IWORK(k, rows) ((rows) + 6 * (k))

/* Linear program by the bounded dual simplex method with bound flipping.
 *
 * basis[k]: rows that determine x, -1 - row if at its lower, 1 + row at its upper limit; a free one is 1 + row too.
 *           basis[0] == 0 starts cold; otherwise the method starts from the rows that it holds. On return the last one.
 * x[k]:     the minimiser.
 * y[k]:     multipliers of the basis, g = sum_j y_j a_(basis j), >= 0 at a lower and <= 0 at an upper limit. If
 *           infeasible, a certificate: with g = 0 the same sum over the basis and the row *entering, coded as a basis
 *           row, whose multiplier is -1 at its upper and 1 at its lower limit; then sum_i y_i limit_i > 0.
 * An unknown with a cost needs the limit that its cost pushes it against. Returns one of the statuses above. `work`
 * starts with the columns of the basis' inverse.
 */
MRTS_LOCAL int mrts_lp(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                       const mrts_real *g, int *basis, mrts_real *x, mrts_real *y, int *entering, mrts_real *work,
                       int *iwork);

/* As mrts_lp, and of its answers; where the rows of `basis` still determine the minimiser they are only solved for, and
 * stay what they are, in the order of their pivots. Where a basis leads to no answer, the program starts cold. */
MRTS_LOCAL int mrts_lp_again(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                             const mrts_real *g, int *basis, mrts_real *x, mrts_real *y, int *entering,
                             mrts_real *work, int *iwork);

/* Value of a row, or of the unknown row - rows, at x. */
MRTS_LOCAL mrts_real mrts_lp_value(int rows, const mrts_real *A, int k, int row, const mrts_real *x);

/* The row, of those that `skipped` does not mark, that oversteps its limits the most: 1 + row above its upper, -1 - row
 * below its lower limit, 0 if none does; under Bland's rule the first one that does. */
MRTS_LOCAL int mrts_lp_price(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                             const mrts_real *x, const int *skipped, int bland, mrts_real *excess);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Small dense strictly convex quadratic programs: minimise 1/2 x'Hx + g'x under the limits of linear_programs.h.
 */
#ifndef MRTS_QUADRATIC_PROGRAMS_H
#define MRTS_QUADRATIC_PROGRAMS_H

#include "linear_programs.h"

/* Reals and ints of work. */
#define MRTS_QP_WORK(k) (3 * (k) * (k) + 7 * (k))
#define MRTS_QP_IWORK(k, rows) ((rows) + (k))

/* Quadratic program by the dual active set method.
 *
 * H:      Shape (k, k), symmetric and positive definite.
 * active: on return *count rows that bind, coded as the basis of a linear program.
 * u:      their multipliers, >= 0 in size: H x + g = sum_j s_j u_j a_j with s_j = 1 at a lower, -1 at an upper limit.
 */
MRTS_LOCAL int mrts_qp(int k, int rows, const mrts_real *H, const mrts_real *A, const mrts_real *lower,
                       const mrts_real *upper, const mrts_real *g, mrts_real *x, int *active, mrts_real *u, int *count,
                       mrts_real *work, int *iwork);

#endif

/* SPDX-License-Identifier: MIT
 *
 * The programs of smooth_program.h by a primal-dual interior point method: Newton steps with predictor and corrector
 * (S. Mehrotra, On the implementation of a primal-dual interior point method, SIAM J. Optimization 2, 1992), started
 * outside the limits.
 */
#ifndef MRTS_INTERIOR_POINT_H
#define MRTS_INTERIOR_POINT_H

#include "fronts.h"

/* How a program ends. */
enum { MRTS_SMOOTH_FOUND = 0, MRTS_SMOOTH_STOPPED = 1 };

/* Reals of work, and of the iterate at its end that a program leaves for one that is near: slacks and multipliers of all
 * slots, F, control points of x, and the unit of the objective. */
MRTS_EXPORT long long mrts_smooth_work(const mrts_smooth_program *p);
MRTS_EXPORT long long mrts_smooth_kept(const mrts_smooth_program *p);

/* Solves a program.
 *
 * x, u, free: the answer, (n), (n), (n, f). Where the timing is given, x and u are read; F at a held end is read.
 * share: by which limits of changes and jerks are passed, 0 where they are not relaxed.
 * iterations: how many it took.
 * Returns one of the statuses above; without an answer nothing that is written is one.
 */
MRTS_EXPORT int mrts_smooth_solve(const mrts_smooth_program *p, double *x, double *u, double *free, double *share,
                                  int *iterations, double *work);

#endif

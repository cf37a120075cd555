/* SPDX-License-Identifier: MIT
 *
 * The Newton matrix of smooth timing, factored node by node. Unknowns are F_0, c_0, F_1, c_1, ..., F_(n-1), c_(n-1),
 * c_n with the control points c; node k's front is F_k, c_k, which are eliminated, and F_(k+1), c_(k+1), c_(k+2), which
 * are all that they meet.
 */
#ifndef MRTS_FRONTS_H
#define MRTS_FRONTS_H

#include "smooth_program.h"

/* Number of unknowns. */
static inline long long mrts_front_unknowns(const mrts_smooth_program *p) {
    return (long long)p->nodes * (p->free + 1) + 1;
}

/* Reals of the factor, and of work of one front. */
MRTS_LOCAL long long mrts_front_size(const mrts_smooth_program *p);
MRTS_LOCAL long long mrts_front_work(const mrts_smooth_program *p);

/* Factors the matrix that the second derivatives of the state make. */
MRTS_LOCAL void mrts_front_factor(const mrts_smooth_program *p, const mrts_smooth_state *state, double *factor,
                                  double *work);

/* Solves for a right side in place; entries of what is given are 0 on return. */
MRTS_LOCAL void mrts_front_solve(const mrts_smooth_program *p, const double *factor, double *b);

/* A gradient along x, u and F as one along the unknowns. */
MRTS_LOCAL void mrts_front_gather(const mrts_smooth_program *p, const mrts_smooth_state *state, const double *gx,
                                  const double *gu, const double *gf, double *b);

/* A step of the unknowns as one of x, u and F. */
MRTS_LOCAL void mrts_front_scatter(const mrts_smooth_program *p, const mrts_smooth_state *state, const double *b,
                                   double *dx, double *du, double *df);

#endif

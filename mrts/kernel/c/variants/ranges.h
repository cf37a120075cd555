/* SPDX-License-Identifier: MIT
 *
 * The range of c^2 of a variant: its samples, what is found of it, and the names of the rows that set its ends.
 */
#ifndef MRTS_RANGES_H
#define MRTS_RANGES_H

#include "../trajectory.h"

/* Most rows that are named at an end, or near to it. */
#define MRTS_MOST_NAMED (4 * MRTS_UNKNOWNS)

enum { MRTS_VK = MRTS_UNKNOWNS, MRTS_VF = MRTS_UNKNOWNS - 1 };

/* Where a variant's range ends, and why. */
typedef struct {
    int status;    /* MRTS_OPTIMAL, MRTS_INFEASIBLE at sample[0], or MRTS_STOPPED */
    int capped;    /* whether limits of the motion alone bound the largest c^2 */
    int sample[2]; /* of the least and the largest c^2, the first of those that differ by rounding only; -1: none sets it */
    int count[2];  /* of the rows that set each end there; of rows[0] those of the certificate of MRTS_INFEASIBLE */
    int rows[2][MRTS_MOST_NAMED]; /* 1 + row at an upper, -1 - row at a lower limit, in their order */
    double c2[2];
} mrts_variant_range;

/* Names the rows that are at their limit in every solution at an end, as mrts/program/range_ends.py does: those with a
 * multiplier that cannot be rounding, and of those near their limit in the solution found the ones that no other keeps
 * away from it. `sample` has the rows of one sample, not scaled, in its first lane. */
MRTS_LOCAL int mrts_name_rows(const mrts_samples *sample, mrts_rows *rows, int end, double c2, const double *x,
                              const int *basis, const double *y, mrts_variant_range *range, double *work, int *iwork);

/* Names the rows of a certificate, whose limits exclude each other: of the basis those with a multiplier, and the one
 * that was to enter. Bounds of c^2 are none. */
MRTS_LOCAL void mrts_name_conflict(const mrts_limits *limits, const mrts_rows *rows, const int *basis, const double *y,
                               int entering, mrts_variant_range *range);

#endif

/* SPDX-License-Identifier: MIT
 *
 * What programs along a trajectory share: the terms of one of its samples, and the names of the rows that a program returns.
 */
#ifndef MRTS_TRAJECTORY_H
#define MRTS_TRAJECTORY_H

#include "lanes/lanes.h"

/* Rounding of an answer at the bound of c^2, as a share. */
#define MRTS_AT_UNBOUNDED 1e-9

/* The terms of a sample, of those of all samples one after the other. */
static inline mrts_terms mrts_terms_of_sample(const mrts_terms *all, long long sample, int rows) {
    const long long torques = sample * MRTS_JOINTS, limits = sample * rows;
    mrts_terms here;
    here.torque_square = all->torque_square ? all->torque_square + torques : 0;
    here.torque_offset = all->torque_offset ? all->torque_offset + torques : 0;
    here.square = all->square ? all->square + limits : 0;
    here.offset = all->offset ? all->offset + limits : 0;
    here.margin = all->margin ? all->margin + limits : 0;
    here.torque_speed = all->torque_speed ? all->torque_speed + torques : 0;
    here.speed = all->speed ? all->speed + limits : 0;
    return here;
}

/* See trajectory.c. */
MRTS_EXPORT void mrts_ranges_work(int rows, long long *reals, long long *ints);
MRTS_EXPORT int mrts_ranges(long long count, const double *const *in, const long long *stride, const mrts_limits *limits,
                            const mrts_terms *terms, const double *most, double *low, double *high,
                            unsigned char *low_status, unsigned char *high_status, double *effect, short *low_basis,
                            short *high_basis, float *low_dual, float *high_dual, double *work, int *iwork);

/* A row of a basis, 1 + row or -1 - row, as a row of the limits; the unknowns come after those. */
static inline short mrts_row_of_limits(const mrts_limits *limits, const mrts_rows *rows, int code) {
    const int row = mrts_abs(code) - 1;
    const int place = row < rows->count ? rows->which[row] : limits->rows + row - rows->count;
    return (short)(code < 0 ? -place - 1 : place + 1);
}

#endif

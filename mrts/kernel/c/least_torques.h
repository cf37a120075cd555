/* SPDX-License-Identifier: MIT
 *
 * Torques and contact wrenches of one sample at a given speed, distributed among the arms.
 */
#ifndef MRTS_LEAST_TORQUES_H
#define MRTS_LEAST_TORQUES_H

#include "quadratic_programs.h"
#include "rows.h"

/* W of t'Wt: its diagonal, whose entries are so many places apart; 0 where W is not diagonal, and all of it is here. */
typedef struct {
    const mrts_real *entries;
    int apart;
} mrts_weights;

/* Reals of work besides those of mrts_qp for k - 1 unknowns. */
#define MRTS_LEAST_TORQUES_WORK(k, joints) ((k) * (k) + 4 * (k) + (joints))

/* Torques and wrenches that minimise t'Wt at c^2 within the rows of a form, whose columns are scaled; limits move outward
 * by `widening` as in mrts_fix_speed. Rows that bind are coded as those of mrts_qp, whose status is returned. */
MRTS_LOCAL int mrts_least_torques(int k, int joints, int wrenches, const mrts_limits *limits, const mrts_weights *weights,
                                  mrts_real c2, mrts_real widening, mrts_form *form, mrts_rows *rows, int *active,
                                  int *count, mrts_real *torque, mrts_real *wrench, mrts_real *work, mrts_real *qp_work,
                                  int *iwork);

#endif

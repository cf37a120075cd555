/* SPDX-License-Identifier: MIT
 *
 * The least torques of several samples: those of the active rows of the sample before, verified.
 */
#ifndef MRTS_KEPT_TORQUES_H
#define MRTS_KEPT_TORQUES_H

#include "lanes.h"

/* The quadratic programs of the torques of several samples, over the scaled free wrenches. */
typedef struct {
    const mrts_rows_lanes *rows;
    mrts_lanes H[MRTS_UNKNOWNS * MRTS_UNKNOWNS], g[MRTS_UNKNOWNS];
    mrts_lanes L[MRTS_UNKNOWNS * MRTS_UNKNOWNS]; /* H = L L', on the diagonal the reciprocals */
    mrts_lanes x[MRTS_UNKNOWNS];                 /* the answer */
} mrts_lane_program;

/* Of which samples the active rows, coded as those of mrts_qp, are those of the minimiser, verified as there. */
MRTS_LOCAL mrts_lane_mask mrts_kept_torques(mrts_lane_program *program, const int *active, int count);

#endif

/* SPDX-License-Identifier: MIT
 *
 * What a dense check knows when it comes to a sample.
 */
#ifndef MRTS_WRENCHES_BEFORE_H
#define MRTS_WRENCHES_BEFORE_H

#include "../cell_sizes.h"

/* What is known of the wrenches when a sample is looked at. */
typedef struct {
    double wrench[MRTS_UNKNOWNS]; /* those of the sample before that are free */
    double scale[MRTS_UNKNOWNS];  /* what a step of each is measured by */
    int active[MRTS_UNKNOWNS];    /* rows that bounded them, coded as the basis of a linear program */
    int count;                    /* of those; -1 where nothing is known */
} mrts_wrenches_before;

#endif

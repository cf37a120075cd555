/* SPDX-License-Identifier: MIT
 *
 * The rows of one sample: limits of torques and wrenches, put in the unknowns of its programs. The desktop and an
 * exported library build them with this source, so that both have the same units and scales. */
#ifndef MRTS_ROWS_H
#define MRTS_ROWS_H

#include "numbers.h"

/* Limits of torques and wrenches in compressed form: row i has the entries start[i] .. start[i + 1] - 1, each a column
 * (torques, then wrenches in base axes, then the same wrenches in object axes) and a value. */
typedef struct {
    int rows;
    const int *start;
    const int *column;
    const mrts_real *value;
    const mrts_real *lower; /* in the unit of the row, -MRTS_INFINITY where there is none */
    const mrts_real *upper; /* MRTS_INFINITY where there is none */
    const int *group;       /* alike for rows of which one measures another's limit of zero */
    const mrts_real *base;  /* rotation of each arm's base in the world, its columns as a triple of a wrench has its
                             * components, (arms, 3, 3); null where no row is in object axes */
    const int *axes;        /* of the object that a triple has, x, y, z being 0, 1, 2, (3) */
} mrts_limits;

/* What is added at one sample to what the generated function and the limits say; null is nothing. Of the torques what
 * motors give besides, of the rows terms of their own. */
typedef struct {
    const mrts_real *torque_square; /* what c^2 adds to each torque, (joints) */
    const mrts_real *torque_offset; /* what is added to each torque, (joints) */
    const mrts_real *square;        /* what c^2 adds to each row of the limits, in its unit, (rows) */
    const mrts_real *offset;        /* what is added to each row, likewise */
    const mrts_real *margin;        /* by how much both limits of each row move inward, likewise */
    const mrts_real *torque_speed;  /* what the speed c adds to each torque, (joints): only ranges of c take it */
    const mrts_real *speed;         /* what it adds to each row, in its unit, (rows): likewise */
} mrts_terms;

/* W of t'Wt: its diagonal, whose entries are so many places apart; 0 where W is not diagonal, and all of it is here. */
typedef struct {
    const mrts_real *entries;
    int apart;
} mrts_weights;

/* Numbers of a form, of its wrenches in object axes, and of the rows besides A's unit; ints of the rows. */
#define MRTS_FORM_WORK(k, joints, wrenches) (((k) + 1) * ((joints) + (wrenches)))
#define MRTS_TURNED_WORK(k, wrenches) (((k) + 1) * (wrenches))
#define MRTS_ROWS_WORK(k, rows) ((rows) * (k) + 3 * (rows) + 3 * (k))
#define MRTS_ROWS_IWORK(rows) (rows)

#include "number_type.inc"
#include "rows.inc"

/* Size of a limit: its larger finite side, 0 where it has none. */
static inline mrts_real mrts_limit_size(mrts_real lower, mrts_real upper) {
    const mrts_real both = mrts_larger(MRTS_ABS(lower), MRTS_ABS(upper));
    if (both < MRTS_INFINITY) return both;
    return lower > -MRTS_INFINITY ? MRTS_ABS(lower) : upper < MRTS_INFINITY ? MRTS_ABS(upper) : 0;
}

/* What a limit of zero is measured by: the largest limit of its group, or 1. */
static inline mrts_real mrts_group_size(const mrts_limits *limits, int group) {
    mrts_real largest = 0;
    for (int row = 0; row < limits->rows; ++row) {
        const mrts_real size = mrts_limit_size(limits->lower[row], limits->upper[row]);
        if (limits->group[row] == group && size > largest) largest = size;
    }
    return largest > 0 ? largest : 1;
}

/* Lays rows out in work arrays, finds which limits there are and measures them; once for all samples. The unit of a limit
 * is its larger finite side; of a limit of zero the largest of its group, or 1. Returns 0 where a lower limit is not at
 * most the upper one. */
static inline int mrts_rows_over(int k, const mrts_limits *limits, mrts_real *work, int *iwork, mrts_rows *rows) {
    rows->count = 0;
    rows->which = iwork;
    rows->unit = work;
    rows->A = rows->unit + limits->rows;
    rows->lower = rows->A + limits->rows * k;
    rows->upper = rows->lower + limits->rows + k;
    rows->size = rows->upper + limits->rows + k;
    for (int row = 0; row < limits->rows; ++row) {
        const mrts_real lower = limits->lower[row], upper = limits->upper[row], size = mrts_limit_size(lower, upper);
        if (!(lower <= upper)) return 0;
        if (!(size > 0) && lower <= -MRTS_INFINITY && upper >= MRTS_INFINITY) continue;
        rows->unit[rows->count] = size > 0 ? size : mrts_group_size(limits, limits->group[row]);
        rows->which[rows->count++] = row;
    }
    return 1;
}

#endif

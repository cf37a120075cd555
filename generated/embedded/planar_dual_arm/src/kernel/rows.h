/* SPDX-License-Identifier: MIT
 *
 * The rows of one sample: limits of torques and wrenches, put in the unknowns of its programs. The desktop and an
 * exported library build them with this source, so that both have the same units and scales.
 */
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

/* Torques and wrenches as affine functions of k unknowns, the last of which is c^2: what a generated function gives.
 * Maps are by columns, Shape (joints, k) and (wrenches, k). */
typedef struct {
    mrts_real *torque_map;
    mrts_real *torque_offset;
    mrts_real *wrench_map;
    mrts_real *wrench_offset;
    mrts_real *object_map; /* of the wrenches in object axes, see mrts_turn_wrenches */
    mrts_real *object_offset;
} mrts_form;

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

/* Reals of memory of a form, those of its wrenches in object axes, and a form laid out in the first. */
#define MRTS_FORM_WORK(k, joints, wrenches) (((k) + 1) * ((joints) + (wrenches)))
#define MRTS_TURNED_WORK(k, wrenches) (((k) + 1) * (wrenches))

static inline mrts_form mrts_form_in(int k, int joints, int wrenches, mrts_real *memory) {
    mrts_form form;
    form.torque_map = memory;
    form.torque_offset = form.torque_map + k * joints;
    form.wrench_map = form.torque_offset + joints;
    form.wrench_offset = form.wrench_map + k * wrenches;
    form.object_map = form.object_offset = 0;
    return form;
}

/* Rows lower <= A x <= upper of one sample, each divided by its unit. Behind the limits of the rows stand those of the
 * unknowns. Rows without a limit are left out. */
typedef struct {
    int count;
    int *which;      /* place of each row among the limits */
    mrts_real *unit; /* what 100 % of each limit is */
    mrts_real *A;    /* Shape (count, k) */
    mrts_real *lower;
    mrts_real *upper;
    mrts_real *size; /* largest coefficient of each unknown, before they are scaled, (k) */
} mrts_rows;

/* Reals and ints of work that the rows stand in. */
#define MRTS_ROWS_WORK(k, rows) ((rows) * (k) + 3 * (rows) + 3 * (k))
#define MRTS_ROWS_IWORK(rows) (rows)

/* Lays rows out in work arrays, finds which limits there are and measures them; once for all samples. The unit of a limit
 * is its larger finite side; of a limit of zero the largest of its group, or 1. Returns 0 where a lower limit is not at
 * most the upper one. */
MRTS_LOCAL int mrts_rows_over(int k, const mrts_limits *limits, mrts_real *work, int *iwork, mrts_rows *rows);

/* Adds what motors give besides to the torques of a form. */
static inline void mrts_add_motors(int k, int joints, const mrts_terms *terms, mrts_form *form) {
    for (int i = 0; i < joints; ++i) {
        if (terms->torque_square) form->torque_map[(k - 1) * joints + i] += terms->torque_square[i];
        if (terms->torque_offset) form->torque_offset[i] += terms->torque_offset[i];
    }
}

/* Turns the wrenches of a form into object axes, in memory of MRTS_TURNED_WORK, where the limits want them. `size` is of
 * one wrench, 6 or in a planar cell 3. Entry (i, j) of the object's rotation is rotation[i * down + j * across]. */
MRTS_LOCAL void mrts_turn_wrenches(int k, int arms, int size, const mrts_limits *limits, const mrts_real *rotation,
                                   int down, int across, mrts_real *memory, mrts_form *form);

/* Fills the rows of one sample; of the terms it takes those of the rows. Returns 0 where a coefficient is not finite. */
MRTS_LOCAL int mrts_build_rows(int k, int joints, int wrenches, const mrts_form *form, const mrts_limits *limits,
                               const mrts_terms *terms, mrts_rows *rows);

/* Puts a value of c^2 in: what it adds moves to the limits, and k - 1 unknowns are left. Limits whose sides differ are
 * moved outward by `widening` of their unit. */
MRTS_LOCAL void mrts_fix_speed(int k, const mrts_limits *limits, mrts_real c2, mrts_real widening, mrts_rows *rows);

/* Scales k unknowns so that each moves some row by one limit: x = column * x_scaled. One that moves none has scale 1. */
MRTS_LOCAL void mrts_scale_columns(int k, mrts_rows *rows, mrts_real *column);

/* Unknowns without limits of their own. */
MRTS_LOCAL void mrts_free_unknowns(int k, mrts_rows *rows);

/* 0 <= c^2 <= most, or what counts as unbounded; c^2 is the last of k scaled unknowns. */
MRTS_LOCAL void mrts_bound_speed(int k, mrts_real most, const mrts_real *column, mrts_rows *rows);

/* The largest c^2 that velocity limits allow, MRTS_INFINITY where nothing that is limited moves; *binding is the limit
 * that sets it, -1 where none does.
 *
 * dq:    Of the joints in the motion as given [rad/s or m/s].
 * twist: Of the object, linear and angular [m/s, rad/s].
 * limit: Of each joint, then of the object's linear and angular speed, > 0; MRTS_INFINITY where there is none.
 */
MRTS_LOCAL mrts_real mrts_speed_cap(int joints, const mrts_real *dq, const mrts_real *twist, const mrts_real *limit,
                                    int *binding);

#endif

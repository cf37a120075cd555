/* @NOTICE@
 * What the files of this library share among themselves. */
#ifndef @MACRO@_INTERNAL_H
#define @MACRO@_INTERNAL_H

#include "@NAME@_config.h"

#include "kernel/rows.h"

enum {
    JOINTS = @MACRO@_JOINTS,
    WRENCHES = @MACRO@_WRENCHES,
    ROWS = @MACRO@_ROWS,
    VELOCITIES = @MACRO@_VELOCITIES,
    K = @MACRO@_UNKNOWNS,
    F = @MACRO@_UNKNOWNS - 1
};

#define NO_EFFECT MRTS_C(1e-30) /* an effect of c^2 = 1 on a limit below this share of it is none */
#ifdef MRTS_SINGLE
#define BINDING MRTS_C(1e-4)    /* a row binds if its multiplier exceeds this share of the largest */
#define SLACK MRTS_C(1e-5)      /* widening of limits for torques: at the end of a range the feasible set is a point */
#else
#define BINDING 1e-7
#define SLACK 1e-9
#endif

/* Size of an array, or an error at compile time where the workspace does not hold what the kernel asks for. */
#define HOLDS(field, type, count) (sizeof(((@NAME@_workspace *)0)->field) >= (count) * sizeof(type) ? 1 : -1)

/* The cell's limits of torques and wrenches, as `mrts_limits` has them. */
extern const int @NAME@_row_start[@MACRO@_ROWS + 1];
extern const int @NAME@_row_column[@ENTRIES@];
extern const mrts_real @NAME@_row_value[@ENTRIES@];
extern const int @NAME@_row_group[@MACRO@_ROWS];

int @NAME@_all_finite(int count, const mrts_real *values);

/* Whether all numbers of a sample and its load are finite, and the mass is > 0. */
int @NAME@_is_sound(const @NAME@_sample *sample, const mrts_real *load);

/* Inputs of the generated functions; matrices there are column after column, hence the rotation `turned`. */
void @NAME@_point_to(const @NAME@_sample *sample, const mrts_real *load, mrts_real turned[9], const mrts_real **arg);

/* The wrench form of a sample, in the workspace. */
mrts_form @NAME@_wrench_form(const @NAME@_sample *sample, const mrts_real *load, @NAME@_workspace *workspace);

mrts_limits @NAME@_limits(const @NAME@_settings *settings);

/* Rows of the limits in `unknowns` unknowns of a form, in the workspace; 0 if limits are reversed or a coefficient is
 * not finite. */
int @NAME@_rows(const mrts_limits *limits, int unknowns, const mrts_form *form, @NAME@_workspace *workspace,
                mrts_rows *rows);

/* Largest c^2 that the velocities allow, MRTS_INFINITY if none bounds it, -1 if a limit is not > 0; `named` is the one
 * that sets it, as in @NAME@_range, 0 if none does. */
mrts_real @NAME@_velocity_cap(const @NAME@_sample *sample, const @NAME@_settings *settings, int *named);

#endif

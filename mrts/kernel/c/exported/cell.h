/* SPDX-License-Identifier: MIT
 *
 * Time scaling of one cell on a controller: its arms hold one object, a motion q(r), r = c t, is given, and c^2 must keep
 * torques, contact wrenches and velocities inside their limits. Link with src/cell.c and src/cell_model.c.
 *
 * Units: m, rad, s, kg, N, N m. Derivatives q', q'' are those of the motion as given (c = 1). World axes unless said
 * otherwise; contact wrenches are what an arm exerts on the object at its contact, in the axes of that arm's base.
 * Every function is re-entrant: it writes only to its arguments. Iterations are bounded. Nothing is allocated. */
#ifndef MRTS_CELL_H
#define MRTS_CELL_H

#ifdef __cplusplus
extern "C" {
#endif

#include "cell_constants.h"

typedef enum {
    CELL_OK = 0,
    CELL_UNBOUNDED = 1,   /* feasible, and nothing bounds c^2 from above: upper is CELL_UNLIMITED */
    CELL_INFEASIBLE = 2,  /* no c^2: the rows named conflict, whatever the speed */
    CELL_EMPTY = 3,       /* samples or loads are feasible one by one, but their ranges have no c^2 in common */
    CELL_UNDECIDED = 4,   /* the data are too close to infeasible, or too badly scaled, for this precision */
    CELL_BAD_ARGUMENT = 5 /* not finite, a reversed limit, a mass, weight or velocity limit that is not > 0, c^2 < 0 */
} cell_status;
#if CELL_MOTORS

/* Where in its motion a sample lies. That tells what dry friction does in a joint that stands there (q' = 0): it is
 * against the direction in which the joint travels just before and just after. */
typedef enum {
    CELL_INSIDE = 0, /* both: where the joint turns back, limits hold with the friction of either direction */
    CELL_START = 1,  /* the motion begins here: only after, along q'' */
    CELL_END = 2     /* it ends here: only before, against q'' */
} cell_place;
#endif

/* One sample of the given motion. */
typedef struct {
    cell_real q[CELL_JOINTS];       /* rad or m */
    cell_real dq[CELL_JOINTS];      /* q' */
    cell_real ddq[CELL_JOINTS];     /* q'' */
    cell_real rotation[9];             /* of the object in the world, row after row */
    cell_real twist[6];                /* p' and the angular velocity of the object */
    cell_real acceleration[6];         /* p'' and the angular acceleration */
#if CELL_MOTORS
    cell_place place;                 /* CELL_INSIDE, which is 0, but for the first and the last sample */
#endif
} cell_sample;

/* What may change at run time. Start from cell_default_settings. */
typedef struct {
    cell_real load[CELL_LOAD];
    cell_real lower[CELL_ROWS];     /* in the row's unit; -CELL_UNLIMITED where there is none */
    cell_real upper[CELL_ROWS];
    cell_real velocity[CELL_VELOCITIES]; /* > 0, rad/s or m/s; CELL_UNLIMITED where none is enforced */
    cell_real weight[CELL_JOINTS];  /* diagonal of W in t'Wt, > 0 */
#if CELL_MOTORS
    cell_real armature[CELL_JOINTS]; /* of motors: rotor inertia times gear ratio squared, kg m^2 or kg, >= 0 */
    cell_real coulomb[CELL_JOINTS]; /* dry friction, N m or N, >= 0 */
    cell_real viscous[CELL_JOINTS]; /* friction that grows with the speed, N m s/rad or N s/m, >= 0 */
    cell_real rest_speed;              /* |q'| up to which a joint stands, rad/s or m/s, >= 0 */
    cell_real rest_acceleration;       /* |q''| up to which it then does not leave, >= 0 */
    cell_real most; /* largest c^2 that is asked for, > 0: ranges are the highest intervals up to it; no row is named there */
#endif
#if CELL_LINES
    cell_real slope[CELL_LINES];    /* of torque-speed lines |torque| <= upper - slope |q'| r', >= 0 */
#endif
#if CELL_MOTIONS
    cell_real acceleration_lower[CELL_JOINTS]; /* of joints, < 0, rad/s^2 or m/s^2; -CELL_UNLIMITED where there is none */
    cell_real acceleration_upper[CELL_JOINTS]; /* > 0 */
    cell_real object_acceleration[2];          /* of its frame, linear and angular, > 0, m/s^2 and rad/s^2 */
#endif
#if CELL_POINTS
    cell_real point_speed[CELL_POINTS];        /* > 0, m/s */
    cell_real point_acceleration[CELL_POINTS]; /* > 0, m/s^2 */
#endif
#if CELL_THINGS
    cell_real friction[CELL_THINGS];           /* between a thing and the object, > 0; CELL_UNLIMITED: it cannot slide */
    cell_real tilt[2 * CELL_THINGS]; /* half width over height of the centre of mass, along a and b, > 0; CELL_UNLIMITED: it
                                         * cannot tip. The centre itself stays where it is in the cell file */
#endif
} cell_settings;

/* Range of c^2. Rows are 1 + row at an upper and -1 - row at a lower limit, the strongest first; 0 stands for c^2 >= 0,
 * 1 + CELL_ROWS + i for velocity i, of several that bind for the first; 1 + CELL_ROWS + CELL_VELOCITIES + i is limit i
 * of accelerations (of joints, at either side; of the object), points (speed and acceleration of each) and things (friction,
 * and tilt to either side along a and b). Of an infeasible sample `upper_rows` are the rows in conflict. */
typedef struct {
    cell_status status;
    cell_real lower;
    cell_real upper;
    int lower_count, upper_count;
    int lower_rows[CELL_UNKNOWNS + 1];
    int upper_rows[CELL_UNKNOWNS + 1];
} cell_range;

/* Work of the caller: one for each thread of control. Set it to zero, or call cell_reset, before the first use; what
 * it keeps from call to call only makes the next call faster. */
typedef struct {
    int basis[2 * CELL_UNKNOWNS + 3 * CELL_MOTORS * (CELL_UNKNOWNS + 1)];
    int which[CELL_ROWS], integers[CELL_ROWS + 6 * CELL_UNKNOWNS];
#if CELL_MOTORS
    int curve_integers[CELL_ROWS + 7 + 6 * CELL_UNKNOWNS];
#endif
    cell_real form[(CELL_UNKNOWNS + 1) * (CELL_JOINTS + CELL_WRENCHES)];
#if CELL_TURNED
    cell_real turned[(CELL_UNKNOWNS + 1) * CELL_WRENCHES];
#endif
    cell_real rows[CELL_ROWS * (CELL_UNKNOWNS + 3) + 3 * CELL_UNKNOWNS];
    cell_real work[3 * CELL_UNKNOWNS * CELL_UNKNOWNS + 7 * CELL_UNKNOWNS];
#if CELL_MOTORS
    cell_real torque_square[CELL_JOINTS], torque_offset[CELL_JOINTS], torque_speed[CELL_JOINTS];
    cell_real row_offset[CELL_ROWS], row_margin[CELL_ROWS], row_speed[CELL_ROWS], by_speed[CELL_ROWS];
    cell_real curve[(CELL_ROWS + 1) * (CELL_UNKNOWNS + 1) + 2 * (CELL_ROWS + CELL_UNKNOWNS + 2) +
                      (CELL_UNKNOWNS + 1) * (CELL_UNKNOWNS + 5)];
    cell_real curve_speed;
#endif
} cell_workspace;

const char *cell_status_text(cell_status status);
/* Such as "left/elbow torque"; row as in cell_range, 0 is "c^2 >= 0". */
const char *cell_row_text(int row);
/* Load and limits of the cell file; weights are 1 / limit^2 of each torque. */
void cell_default_settings(cell_settings *settings);
/* CELL_OK or CELL_BAD_ARGUMENT: call it once after settings have changed. */
cell_status cell_check_settings(const cell_settings *settings);
void cell_reset(cell_workspace *workspace);

/* A horizon of samples, fed one by one: the intersection of their ranges. If that is empty and there are motors, slower
 * intervals may have a c^2 in common: set `most` of the settings to `upper` and feed it again. */
typedef struct {
    cell_status status;
    cell_real lower, upper;
    long samples, lower_sample, upper_sample; /* how many, and which set the ends; -1 where none does */
} cell_horizon;

void cell_horizon_start(cell_horizon *horizon);
cell_status cell_horizon_add(cell_horizon *horizon, const cell_range *range);

/* Terms of (11) to (18): torque = E r'^2 + A r'' + G + J'F of each arm, sum B F = P r'^2 + S r'' + Q of the object. J
 * and B stand arm beside arm, column after column: J has CELL_WRENCH rows and CELL_JOINTS columns, B
 * CELL_WRENCH rows and CELL_WRENCHES columns. */
typedef struct {
    cell_real E[CELL_JOINTS], A[CELL_JOINTS], G[CELL_JOINTS];
    cell_real J[CELL_WRENCH * CELL_JOINTS], B[CELL_WRENCH * CELL_WRENCHES];
    cell_real P[CELL_WRENCH], S[CELL_WRENCH], Q[CELL_WRENCH];
#if CELL_MOTORS
    cell_real V[CELL_JOINTS], C[CELL_JOINTS]; /* friction: torque = ... + V r' + C, of motors; E, A have armature */
    cell_real turning[CELL_JOINTS]; /* dry friction of a joint that turns back: it acts in both directions; C is 0 */
#endif
} cell_terms_of_sample;

void cell_terms(const cell_sample *sample, const cell_settings *settings, cell_terms_of_sample *terms);

/* Least and largest c^2 at a sample, torques distributed freely. */
cell_status cell_range_of_sample(const cell_sample *sample, const cell_settings *settings, cell_range *range,
                                 cell_workspace *workspace);

/* The same for every load of a list at once: the intersection. For the corners of a box that is the range guaranteed
 * for every load of the box. `lower_load` and `upper_load` (or null) become the loads that set the ends. */
cell_status cell_guaranteed_range(const cell_sample *sample, const cell_settings *settings,
                                  const cell_real (*loads)[CELL_LOAD], int count, cell_range *range,
                                  int *lower_load, int *upper_load, cell_workspace *workspace);

/* Corners of the cell file's load variation. */
extern const cell_real cell_load_corners[CELL_CORNERS][CELL_LOAD];

/* Range of c^2 where every arm carries an equal share of the load: closed form, one row at a time, unless
 * rows have terms in the speed. */
cell_status cell_equal_share_range(const cell_sample *sample, const cell_settings *settings, cell_range *range,
                                   cell_workspace *workspace);

/* Torques and contact wrenches with the least t'Wt at a c^2 of the range; only with CELL_OK do they keep the
 * limits. */
cell_status cell_torques(const cell_sample *sample, const cell_settings *settings, cell_real c2,
                         cell_real torque[CELL_JOINTS], cell_real wrench[CELL_WRENCHES], cell_workspace *workspace);

#ifdef __cplusplus
}
#endif

#endif

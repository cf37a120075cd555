/* SPDX-License-Identifier: MIT
 *
 * A plan of the cell played at a speed that may change at any tick, within every limit. The plan has a time of its own,
 * s from 0 to its duration; its speed ds/dt is 1 as planned, 0 where the cell holds still. At every s the accelerations
 * d2s/dt2 that keep all limits lie between two ends, at rest and at the largest speed, and torques and wrenches of what
 * lies between are mixtures of those at the ends; nothing is solved here. Include after cell.h, link with
 * src/cell_override.c; docs/override_controller.cpp of mrts plays a plan. */
#ifndef MRTS_CELL_OVERRIDE_H
#define MRTS_CELL_OVERRIDE_H

#include "cell.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { CELL_BRAKE = 0, CELL_PUSH = 1, CELL_AT_REST = 0, CELL_AT_MOST = 1, CELL_ENDS_OF_SPEED = 2 };

/* The plan at one s: its path, what the limits leave, and contact wrenches in the axes of the object. */
typedef struct {
    cell_real time;                                         /* s */
    cell_real q[CELL_JOINTS], dq[CELL_JOINTS], ddq[CELL_JOINTS]; /* and its derivatives by s */
    cell_real most;                                         /* largest squared speed */
    cell_real acceleration[2][2];                           /* least and largest, at rest and at the largest speed */
    cell_real rate[2];       /* largest change of the acceleration in a second, at rest and at the largest speed */
    cell_real rate_ahead;    /* the least of these until the acceleration has become 0 again */
    cell_real hold[2][CELL_WRENCHES];          /* wrenches without acceleration, at rest and at the largest speed */
    cell_real accelerate[2][2][CELL_WRENCHES]; /* with the least and with the largest, likewise */
    short active[5]; /* limits that set the accelerations, in the order above, and that of the speed */
} cell_plan_node;

typedef struct {
    const cell_plan_node *nodes; /* in the order of s; two with one s where the plan's acceleration jumps */
    int count;
    int backwards;           /* whether limits hold against the plan's direction too */
    int varies;              /* whether the largest speed is not 1 everywhere */
    int keeps_rates;         /* whether rates of torques are kept */
    const char *const *limits; /* names of what is active */
    cell_real load[CELL_LOAD];
#if CELL_MOTORS
    cell_real armature[CELL_JOINTS], coulomb[CELL_JOINTS], viscous[CELL_JOINTS]; /* as in cell_settings */
#endif
#ifdef CELL_GEOMETRY
    const cell_real *geometry;
#endif
} cell_plan;

/* What a controller commands now. */
typedef struct {
    cell_real time, speed, acceleration; /* s, ds/dt, and d2s/dt2 until the next tick */
    cell_real q[CELL_JOINTS], dq[CELL_JOINTS], ddq[CELL_JOINTS]; /* by time: rad, rad/s, rad/s^2 or m, ... */
    cell_real torque[CELL_JOINTS];   /* of the motors, N m or N */
    cell_real wrench[CELL_WRENCHES]; /* of the contacts, in the axes of the arms' bases */
    int active;   /* what keeps the speed from the wanted one: its place in `limits`; 0 is nothing */
    int finished; /* 1: at rest at an end of the plan */
    int node, direction;
    cell_real inside, aim;
} cell_override;

/* Stand at s = time with a speed, negative where backwards; CELL_INFEASIBLE if limits do not admit it there, and
 * CELL_BAD_ARGUMENT if it is no place of the plan. A state that is refused is left as it is. */
cell_status cell_override_start(const cell_plan *plan, cell_real time, cell_real speed, cell_override *state);

/* One tick: go on for dt seconds with the acceleration that was chosen last, then choose one that leads to the wanted
 * speed by the next tick, or as near to it as limits let. At s = 0 and at the end the cell comes to rest by itself.
 * CELL_BAD_ARGUMENT, and nothing done, unless wanted is finite and dt > 0. */
cell_status cell_override_step(const cell_plan *plan, cell_real wanted, cell_real dt, cell_override *state);

/* Stand still at the place of the plan that is nearest to measured joint positions, such as after an emergency stop;
 * CELL_INFEASIBLE if a joint is farther than `within` from it. */
cell_status cell_override_resume(const cell_plan *plan, const cell_real q[CELL_JOINTS], cell_real within,
                                 cell_override *state);

/* Seconds until the cell stands still if 0 is wanted from now on at ticks of dt, and the s where it then stands, or null;
 * CELL_UNLIMITED if that takes more than 100 000 ticks, or dt is not > 0. Costs about a tenth of a tick for each of these. */
cell_real cell_override_stop_time(const cell_plan *plan, const cell_override *state, cell_real dt, cell_real *stands);

/* The largest speed at the place of a state from which the cell stands still within some seconds. */
cell_real cell_override_speed_for_stop(const cell_plan *plan, const cell_override *state, cell_real seconds, cell_real dt);

#ifndef CELL_GEOMETRY
/* The exported plan. */
extern const cell_plan cell_planned;

#endif
#ifdef __cplusplus
}
#endif

#endif

/* SPDX-License-Identifier: MIT
 *
 * The fastest speed along a path with n nodes whose rows, changes of rows and jerks are limited: a convex program.
 *
 * x is the squared speed, u half its slope along the path, linear between nodes, F free unknowns at each node. Row j of
 * node k has the value v = square x + rate u + root sqrt(x) + free F + offset, and
 *
 *     lower <= v_k <= upper                                          at every node
 *     sqrt(z' gram z) <= bound' z with z = (u, x, 1)                 at every node, of each cone
 *     |v_(k+1) - v_k| <= change Dt_k                                 on every segment
 *     |q1 (u_(k+1) - u_k) / step + 3 q2 u + q3 x| <= jerk / sqrt(x)  at both ends of every segment
 *
 * with Dt_k = 2 step / (sqrt(x_k) + sqrt(x_(k+1))). What is not convex is replaced by what is stricter and touches it
 * at the profile `around`: Dt and 1 / sqrt(x) by their tangents, root sqrt(x) by its own where it presses towards a limit.
 * The least of time * duration + effort * sum of spacing weight v^2 / sqrt(x) + uneven * sum of (u_(k+1) - u_k)^2 / step
 * is looked for.
 *
 * Each one-sided constraint has a slot: g <= 0 in units of its limit, a slack s and a multiplier, which is 0 where there
 * is no limit.
 * Node k has the slots [rows above, rows below, cones, changes above, changes below, jerks at the start of its segment
 * above, below, at its end above, below]; the last two slots of all are those of the duration and of the share.
 */
#ifndef MRTS_SMOOTH_PROGRAM_H
#define MRTS_SMOOTH_PROGRAM_H

#include "../numbers.h"

typedef struct {
    int nodes;       /* n >= 2 */
    int rows;        /* r of a node */
    int free;        /* f of a node */
    int width;       /* of a node: coefficients of its rows, each row's columns only */
    int cones;       /* of a node */
    int changes;     /* rows whose change is limited */
    int jerks;       /* joints whose jerk is limited */
    int timed;       /* x and u are given: F alone is looked for */
    int again;       /* `work` ends with the iterate of a program that is near: start from there */
    int moving;      /* tangents are laid anew in each iteration, until it is near its end */
    int given_start; /* x at the first node is given */
    int given_end;
    int held_start; /* F at the first node is given */
    int held_end;
    const int *first;   /* column of F that a row begins with, (r) */
    const int *count;   /* columns that it has, (r) */
    const int *place;   /* of its first coefficient among those of a node, (r) */
    const int *limited; /* rows whose change is limited, (changes) */
    double time;
    double effort;
    double longest;      /* of the duration, MRTS_INFINITY where there is none */
    double uneven;       /* weight of the sum of (u_(k+1) - u_k)^2 / step, which leaves no u to jump to and fro for nothing */
    double relaxed;      /* weight of a share by which all limits of changes and jerks are relaxed; 0 relaxes none, and
                            where it is not 0 there is no longest duration */
    const double *step;   /* (n - 1) */
    const double *square; /* (n, r), as rate, root, offset, lower, upper */
    const double *rate;
    const double *root; /* null where all are 0 */
    const double *offset;
    const double *entry; /* coefficients of F, (n, width) */
    const double *lower;
    const double *upper;
    const double *gram;   /* (n, cones, 3, 3), symmetric */
    const double *bound;  /* (n, cones, 3), of which the last is infinite where there is no limit */
    const double *change; /* (changes) */
    const double *weight; /* (r), null where all are 0 */
    const double *q1;     /* (n, jerks) */
    const double *q2;     /* (n, jerks) */
    const double *q3;     /* (n - 1, 2, jerks) */
    const double *jerk;   /* (jerks) */
    const double *around; /* x > 0 where tangents are laid, (n) */
} mrts_smooth_program;

/* A profile and what belongs to it, in the caller's memory. */
typedef struct {
    double *x, *u, *free;     /* (n), (n), (n, f) */
    double *control;          /* x is a spline: x_k = near_k control_k + far_k control_(k+1), (n + 1) */
    double *near, *far;       /* (n) */
    double *slope;            /* u_k = slope_k (control_(k+1) - control_k), (n) */
    double *around;           /* where tangents are laid, (n) */
    double *root_around;      /* (n) */
    double *by_time;          /* 1 / Dt at `around`, (n - 1) */
    double *time_x, *time_x1; /* slopes of the tangent of Dt / Dt_around along x_k, x_(k+1), (n - 1) */
    double *by_change;        /* 1 / change, (changes) */
    double *value;            /* v without its root, (n, r) */
    double *above, *below;    /* convex above v, concave below v, equal to v at `around`, (n, r) */
    double *above_x, *below_x; /* their slopes along x, (n, r) */
    double *cone_u, *cone_x;  /* slopes of the cones' left sides, (n, cones) */
    double *cone_root;        /* their left sides, (n, cones) */
    double *duration_x;       /* slopes of the duration, (n) */
    double *row_weight, *row_cross; /* of a node's second derivatives along (value, value) and (x, value), (n, r) */
    double *change_weight, *change_before, *change_after; /* likewise between two nodes, (n - 1, changes) */
    double *node_second;      /* along (x, x), (x, u), (u, u), (n, 3) */
    double *segment_second;   /* along (x, x'), (x, u'), (u, x'), (u, u'), (n - 1, 4) */
    double *pressing, *holding; /* of a node: multipliers above and below, (r) */
    double unit;              /* of the objective */
} mrts_smooth_state;

/* Slots of a node alone, and with those of its segment. */
static inline int mrts_smooth_node_slots(const mrts_smooth_program *p) { return 2 * p->rows + p->cones; }
static inline int mrts_smooth_slots(const mrts_smooth_program *p) {
    return mrts_smooth_node_slots(p) + 2 * (p->changes + 2 * p->jerks);
}

/* Reals of a state, and a state laid out in them. */
MRTS_LOCAL long long mrts_smooth_state_size(const mrts_smooth_program *p);
MRTS_LOCAL void mrts_smooth_state_in(const mrts_smooth_program *p, double *memory, mrts_smooth_state *state);

/* Lays tangents at a profile. */
MRTS_LOCAL void mrts_smooth_tangents(const mrts_smooth_program *p, mrts_smooth_state *state, const double *around);

/* Starts where tangents are laid; the state holds what of x is given. */
MRTS_LOCAL void mrts_smooth_start(const mrts_smooth_program *p, mrts_smooth_state *state);

/* x and u of the control points. */
MRTS_LOCAL void mrts_smooth_profile(const mrts_smooth_program *p, mrts_smooth_state *state);

/* g of every slot, and what of the rows goes into it. */
MRTS_LOCAL void mrts_smooth_values(const mrts_smooth_program *p, mrts_smooth_state *state, double *g);

/* What a step (dx, du, df) of the profile changes in every g, to first order. */
MRTS_LOCAL void mrts_smooth_moved(const mrts_smooth_program *p, const mrts_smooth_state *state, const double *dx,
                                  const double *du, const double *df, double *dg);

/* Sums of multipliers y by the rows of node k, into `pressing` where what lies above the row's value is to be small,
 * and into `holding` where what lies below it is to be large. */
MRTS_LOCAL void mrts_smooth_presses(const mrts_smooth_program *p, mrts_smooth_state *state, const double *y, int k);

/* Adds the gradient of sum y g along x, u and F. */
MRTS_LOCAL void mrts_smooth_pulled(const mrts_smooth_program *p, mrts_smooth_state *state, const double *y, double *gx,
                                   double *gu, double *gf);

/* The objective in its unit, its gradient added along x, u and F, and the duration. */
MRTS_LOCAL double mrts_smooth_objective(const mrts_smooth_program *p, mrts_smooth_state *state, double *gx, double *gu,
                                        double *gf, double *duration);

/* Second derivatives of objective + sum of multiplier g, plus sum of weight times g's gradient squared. */
MRTS_LOCAL void mrts_smooth_second(const mrts_smooth_program *p, mrts_smooth_state *state, const double *weight,
                                   const double *multiplier);

#endif

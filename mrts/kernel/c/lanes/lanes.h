/* SPDX-License-Identifier: MIT
 *
 * Samples side by side in the lanes of vector registers: the same operations in the same order in each lane, whatever
 * registers the machine has, so that all machines give the same bits.
 */
#ifndef MRTS_LANES_H
#define MRTS_LANES_H

#include "../cell_sizes.h"
#include "../dense/places.h"
#include "../dense/wrenches_before.h"
#include "../rows.h"
#include "../tracking/closure.h"
#include "lane_types.h"

/* Unknowns up to which torques are found in lanes: their programs stand on the stack, 10 kB times the square of the number of
 * arms, 1 MB here. */
#ifndef MRTS_MOST_LANE_UNKNOWNS
#define MRTS_MOST_LANE_UNKNOWNS 55
#endif
#define MRTS_TORQUE_LANES (MRTS_LANES > 1 && MRTS_UNKNOWNS <= MRTS_MOST_LANE_UNKNOWNS)

#if MRTS_LANES > 1
/* Generated functions for lanes: every input is there, with sine and cosine of each of the first input's numbers, and every
 * output. */
#define MRTS_LANE_FUNCTION(name) void name(const mrts_lanes *const *arg, const mrts_lanes *sines, mrts_lanes *const *res)
MRTS_LANE_FUNCTION(mrts_form_of_lanes);
MRTS_LANE_FUNCTION(mrts_kinematics_of_lanes);
MRTS_LANE_FUNCTION(mrts_bias_of_lanes);
#ifdef MRTS_WIDE
MRTS_LANE_FUNCTION(mrts_form_of_wide_lanes);
MRTS_LANE_FUNCTION(mrts_kinematics_of_wide_lanes);
MRTS_LANE_FUNCTION(mrts_bias_of_wide_lanes);
#endif

/* Scaled rows of several samples, as of mrts_rows. */
typedef struct {
    const mrts_rows *of; /* which rows, and their units */
    mrts_lanes *A;
    mrts_lanes *lower;
    mrts_lanes *upper;
    mrts_lanes size[MRTS_UNKNOWNS];
    mrts_lanes column[MRTS_UNKNOWNS];
} mrts_lane_rows;

/* Reals of work in which they stand. */
#define MRTS_LANE_WORK(k, rows) (MRTS_LANES * ((rows) * (k) + 2 * ((rows) + (k))))

/* Some samples of a dense check: their forms with what motors give, by columns, offsets last, see rows.h. */
typedef struct {
    const mrts_limits *limits;
    const mrts_terms *terms; /* of all samples of the call */
    const mrts_rows *of;     /* which rows, and their units */
    const long long *samples;
    mrts_lanes c2;
    mrts_lanes torque[(MRTS_UNKNOWNS + 1) * MRTS_JOINTS], wrench[(MRTS_UNKNOWNS + 1) * MRTS_WRENCHES];
    mrts_lanes turn[9 * MRTS_ROBOTS]; /* from base axes to those of the object, where limits want them */
} mrts_dense_lanes;

/* The quadratic programs of the torques of several samples, over the scaled free wrenches. */
typedef struct {
    const double *weights; /* W, (MRTS_JOINTS, MRTS_JOINTS) */
    double widening;       /* by which limits move outward where they are not equal, in their unit */
    mrts_lane_rows rows;   /* over the wrenches and c^2, then over the scaled wrenches alone */
    /* As those of mrts_dense_lanes, of the scaled wrenches; the column of c^2 is what there is without them. */
    mrts_lanes torque[(MRTS_UNKNOWNS + 1) * MRTS_JOINTS], wrench[(MRTS_UNKNOWNS + 1) * MRTS_WRENCHES];
    mrts_lanes H[MRTS_UNKNOWNS * MRTS_UNKNOWNS], g[MRTS_UNKNOWNS];
    mrts_lanes L[MRTS_UNKNOWNS * MRTS_UNKNOWNS]; /* H = L L', on the diagonal the reciprocals */
    mrts_lanes x[MRTS_UNKNOWNS], least_torque[MRTS_JOINTS], its_wrench[MRTS_WRENCHES]; /* the answer */
} mrts_lane_program;

/* What works on lanes. */
typedef struct {
    /* The generated wrench form. */
    void (*form)(const mrts_lanes *const *arg, mrts_lanes *const *res);
    /* Evaluates the wrench form and builds scaled rows of the samples at the places `at`; `terms` are those of all. */
    void (*rows)(const mrts_lanes *const *arg, const mrts_limits *limits, const mrts_terms *terms, const long long *at,
                 const double *most, mrts_lane_rows *rows);
    /* Whether the basis of a program with cost `sign` of c^2 answers it, of each lane: see mrts_kept_basis. */
    void (*end)(const mrts_lane_rows *rows, double sign, const int *basis, mrts_lanes *x, mrts_lanes *y,
                mrts_lane_mask *kept);
    /* The forms of samples of a dense check. */
    void (*dense_form)(const mrts_lanes *const *arg, mrts_dense_lanes *at);
    /* Moves free wrenches to the nearest whose known rows bind again, in the unit of their scale. What they are worth is
     * seen when they are put in. */
    void (*dense_bound)(const mrts_dense_lanes *at, const mrts_wrenches_before *known, mrts_lanes *free);
    /* By how much a row is passed with given free wrenches, in shares of its limit, at most, 0 if none is; and whether all
     * rows are numbers. */
    void (*dense_passed)(const mrts_dense_lanes *at, const mrts_lanes *free, mrts_lanes *most, mrts_lane_mask *finite);
    /* Finds what is wanted at some places of a path. */
    int (*places)(const mrts_places *to, const mrts_lanes *geometry, const long long *places);
    /* Makes what is known of the closure of each arm, (MRTS_ROBOTS, MRTS_CLOSURE_SIZES), the larger of that and of some
     * samples, and takes from `finite` those of which one is no number; `given` are the inputs of the wrench form. */
    void (*closures)(const double *geometry, const int *components, const mrts_lanes *const *given,
                     const mrts_lanes *position, mrts_lanes *most, mrts_lane_mask *finite);
    /* Evaluates the wrench form and makes the programs of the samples at the places `at`, each at its c2. */
    void (*programs)(const mrts_lanes *const *arg, const mrts_limits *limits, const mrts_terms *terms, const long long *at,
                     const mrts_lanes *c2, mrts_lane_program *program);
    /* Of which samples the active rows, coded as those of mrts_qp, are those of the minimiser, verified as there. */
    void (*torques)(mrts_lane_program *program, const int *active, int count, mrts_lane_mask *kept);
} mrts_lane_functions;

/* Those for this machine. */
MRTS_LOCAL mrts_lane_functions mrts_lane_functions_here(void);

#else
#define MRTS_LANE_WORK(k, rows) 0
#endif

#endif

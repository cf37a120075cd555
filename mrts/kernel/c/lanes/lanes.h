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

/* Samples at a time; without the vectors of GNU C one after the other. */
#if defined(__GNUC__) && !defined(MRTS_NO_LANES)
#define MRTS_LANES 4
typedef double mrts_lanes __attribute__((vector_size(8 * MRTS_LANES), aligned(8)));
typedef long long mrts_lane_mask __attribute__((vector_size(8 * MRTS_LANES), aligned(8)));
#pragma GCC diagnostic ignored "-Wpsabi" /* between functions of ours only, of the same target */

/* Wider registers than every x86-64 has, for machines that have them. */
#if defined(__x86_64__) && !defined(MRTS_NARROW)
#define MRTS_WIDE __attribute__((target("avx2")))
#endif

/* Generated functions for lanes: every input is there, with sine and cosine of each of the first input's numbers, and every
 * output, of kinematics and bias acceleration those of the first arm alone. */
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
} mrts_lane_functions;

/* Those for this machine. */
MRTS_LOCAL mrts_lane_functions mrts_lane_functions_here(void);

#else
#define MRTS_LANES 1
#define MRTS_LANE_WORK(k, rows) 0
#endif

#endif

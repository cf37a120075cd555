/* SPDX-License-Identifier: MIT
 *
 * Samples side by side in the lanes of vector registers: the same operations in the same order in each lane, whatever
 * registers the machine has, so that all machines give the same bits.
 */
#ifndef MRTS_LANES_H
#define MRTS_LANES_H

#include "../cell_sizes.h"
#include "../rows.h"
#include "lane_types.h"

/* Unknowns up to which torques are found in lanes: their programs stand on the stack, 10 kB times the square of the number of
 * arms, 1 MB here. */
#ifndef MRTS_MOST_LANE_UNKNOWNS
#define MRTS_MOST_LANE_UNKNOWNS 55
#endif
#define MRTS_TORQUE_LANES (MRTS_UNKNOWNS <= MRTS_MOST_LANE_UNKNOWNS)

/* Generated functions for lanes: every input is there, with sine and cosine of each of the first input's numbers, and every
 * output. */
#define MRTS_LANE_FUNCTION(name) void name(const mrts_lanes *const *arg, const mrts_lanes *sines, mrts_lanes *const *res)
MRTS_LANE_FUNCTION(MRTS_WRENCH_FORM_LANES);
MRTS_LANE_FUNCTION(MRTS_KINEMATICS_LANES);
MRTS_LANE_FUNCTION(MRTS_BIAS_ACCELERATION_LANES);

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

/* The quadratic programs of the torques of several samples, over the scaled free wrenches. */
typedef struct {
    const double *weights; /* W, (MRTS_JOINTS, MRTS_JOINTS) */
    double widening;       /* by which limits move outward where they are not equal, in their unit */
    mrts_lane_rows rows;   /* over the wrenches and c^2, then over the scaled wrenches alone */
    /* By columns, offsets last, of the scaled wrenches; the column of c^2 is what there is without them. */
    mrts_lanes torque[(MRTS_UNKNOWNS + 1) * MRTS_JOINTS], wrench[(MRTS_UNKNOWNS + 1) * MRTS_WRENCHES];
    mrts_lanes H[MRTS_UNKNOWNS * MRTS_UNKNOWNS], g[MRTS_UNKNOWNS];
    mrts_lanes L[MRTS_UNKNOWNS * MRTS_UNKNOWNS]; /* H = L L', on the diagonal the reciprocals */
    mrts_lanes x[MRTS_UNKNOWNS], least_torque[MRTS_JOINTS], its_wrench[MRTS_WRENCHES]; /* the answer */
} mrts_lane_program;

/* Sines and cosines of some angles, both of one after the other. */
MRTS_LOCAL void mrts_sines(int count, const mrts_lanes *angle, mrts_lanes *both);

/* The generated wrench form. */
MRTS_LOCAL void mrts_lane_form(const mrts_lanes *const *arg, mrts_lanes *const *res);

/* H = L L', (k, k), on the diagonal the reciprocals; what is not definite gives no numbers. H and L may be the same. */
MRTS_LOCAL void mrts_lane_cholesky(int k, const mrts_lanes *H, mrts_lanes *L);

/* b of L b = b, and of L' b = b. */
MRTS_LOCAL void mrts_lane_forward(int k, const mrts_lanes *L, mrts_lanes *b);
MRTS_LOCAL void mrts_lane_backward(int k, const mrts_lanes *L, mrts_lanes *b);

/* A term of each sample, of those of all samples one after the other, `size` each. */
MRTS_LOCAL mrts_lanes mrts_term(const double *all, const long long *at, int size, int place);

/* What motors give besides. */
MRTS_LOCAL void mrts_lane_motors(const mrts_terms *terms, const long long *at, mrts_lanes *torque_square,
                                 mrts_lanes *torque_offset);

/* As mrts_build_rows, without wrenches in object axes. */
MRTS_LOCAL void mrts_lane_build(const mrts_lanes *torque, const mrts_lanes *wrench, const mrts_limits *limits,
                                const mrts_terms *terms, const long long *at, mrts_lane_rows *rows);

/* Evaluates the wrench form and builds scaled rows of the samples at the places `at`; `terms` are those of all. */
MRTS_LOCAL void mrts_lane_rows_of(const mrts_lanes *const *arg, const mrts_limits *limits, const mrts_terms *terms,
                                  const long long *at, const double *most, mrts_lane_rows *rows);

/* Whether the basis of a program with cost `sign` of c^2 answers it, of each lane: see mrts_kept_basis. */
MRTS_LOCAL void mrts_lane_end(const mrts_lane_rows *rows, double sign, const int *basis, mrts_lanes *x, mrts_lanes *y,
                              mrts_lane_mask *kept);

/* v -= w x r */
MRTS_LOCAL void mrts_less_cross(const mrts_lanes *w, const mrts_lanes *r, mrts_lanes *v);

/* The rates of a tip from those of its arm's joints, first .. end - 1 of all; `change` is the bias acceleration before. */
MRTS_LOCAL void mrts_tip_by_joints(int first, int end, const mrts_lanes *J, const mrts_lanes *dq, const mrts_lanes *ddq,
                                   mrts_lanes *rate, mrts_lanes *change);

/* Evaluates the wrench form and makes the programs of the samples at the places `at`, each at its c2. */
MRTS_LOCAL void mrts_lane_programs(const mrts_lanes *const *arg, const mrts_limits *limits, const mrts_terms *terms,
                                   const long long *at, const mrts_lanes *c2, mrts_lane_program *program);

/* Of which samples the active rows, coded as those of mrts_qp, are those of the minimiser, verified as there. */
MRTS_LOCAL void mrts_lane_torques(mrts_lane_program *program, const int *active, int count, mrts_lane_mask *kept);

/* Inputs of some samples in lanes: those that are the same for all stand there once. */
typedef struct {
    mrts_lanes numbers[MRTS_INPUT_NUMBERS];
    const mrts_lanes *arg[MRTS_INPUTS];
    long long at[MRTS_LANES];
} mrts_lane_inputs;

/* Takes the inputs of samples from `first` on, those that are the same for all only if `all`; beyond the last the last is
 * repeated. */
MRTS_LOCAL void mrts_take_inputs(const double *const *in, const long long *stride, long long first, long long count,
                                 int all, mrts_lane_inputs *lanes);

/* One lane of some numbers. */
MRTS_LOCAL void mrts_take_lane(int count, const mrts_lanes *from, int lane, double *to);

#endif

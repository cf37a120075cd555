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

/* Places of inputs of a moving sample: q, dq, ddq, rotation, twist, acceleration, load, and what a function takes besides. */
enum { MRTS_DQ = 1, MRTS_DDQ, MRTS_ROTATION, MRTS_TWIST, MRTS_ACCELERATION };

/* Generated functions for lanes: every input is there, with sine and cosine of each of the first input's numbers, and every
 * output. */
#define MRTS_LANE_FUNCTION(name) void name(const mrts_lanes *const *arg, const mrts_lanes *sines, mrts_lanes *const *res)
/* q, q', q'', rotation, twist, acceleration, load to the affine maps of torques and wrenches, see rows.h. */
MRTS_LANE_FUNCTION(MRTS_WRENCH_FORM_LANES);
MRTS_LANE_FUNCTION(MRTS_KINEMATICS_LANES);
MRTS_LANE_FUNCTION(MRTS_BIAS_ACCELERATION_LANES);

/* As mrts_terms, without what only mrts_speed_ranges takes. */
typedef struct {
    const mrts_lanes *torque_square, *torque_offset, *square, *offset, *margin;
} mrts_terms_lanes;

#define MRTS_IN_LANES
#include "../number_type.inc"
#include "../rows.inc"
#undef MRTS_IN_LANES

/* Inputs of some samples: those that are the same for all stand there once. */
typedef struct {
    mrts_lanes numbers[MRTS_INPUT_NUMBERS];
    const mrts_lanes *arg[MRTS_INPUTS];
    long long at[MRTS_LANES];
} mrts_lane_inputs;

/* Some samples of a call, with their forms and rows. */
typedef struct {
    const mrts_limits *limits;
    const mrts_terms *terms; /* of all samples, one after the other */
    mrts_lane_inputs inputs;
    mrts_terms_lanes own;
    mrts_form_lanes form;
    mrts_rows_lanes rows;
    mrts_lanes column[MRTS_UNKNOWNS]; /* scales of the unknowns, where they are scaled */
    mrts_lane_mask finite;            /* whether the rows are */
    mrts_lanes *turned, *its_terms;
} mrts_samples;

/* Reals of their memory, and samples laid out in it. `rows` has which rows there are, and their units. */
#define MRTS_SAMPLES_WORK(rows)                                                                                   \
    (MRTS_LANES * (MRTS_FORM_WORK(MRTS_UNKNOWNS, MRTS_JOINTS, MRTS_WRENCHES) + 2 * MRTS_JOINTS + 3 * (rows) +     \
                   MRTS_TURNED_WORK(MRTS_UNKNOWNS, MRTS_WRENCHES) + (rows) * MRTS_UNKNOWNS + 2 * (rows) + 3 * MRTS_UNKNOWNS))
MRTS_LOCAL void mrts_samples_in(const mrts_limits *limits, const mrts_terms *terms, const mrts_rows *rows, double *memory,
                                mrts_samples *samples);

/* Takes the samples from `first` on, with the inputs that are the same for all only if `all`, and builds their rows; beyond
 * the last sample the last is repeated. */
MRTS_LOCAL void mrts_take_samples(const double *const *in, const long long *stride, long long first, long long count,
                                  int all, mrts_samples *samples);

/* The rows of one of them over k unknowns; of the unknowns whatever limits they have. */
MRTS_LOCAL void mrts_rows_of_lane(int k, const mrts_samples *samples, int lane, mrts_rows *rows);

/* One number of each sample, of those of all samples one after the other, `size` each. */
MRTS_LOCAL mrts_lanes mrts_term(const double *all, const long long *at, int size, int place);

/* Takes inputs alone. */
MRTS_LOCAL void mrts_take_inputs(const double *const *in, const long long *stride, long long first, long long count,
                                 int all, mrts_lane_inputs *lanes);

/* Sines and cosines of some angles, both of one after the other. */
MRTS_LOCAL void mrts_sines(int count, const mrts_lanes *angle, mrts_lanes *both);

/* H = L L', (k, k), on the diagonal the reciprocals; what is not definite gives no numbers. H and L may be the same. */
MRTS_LOCAL void mrts_lane_cholesky(int k, const mrts_lanes *H, mrts_lanes *L);

/* b of L b = b, and of L' b = b. */
MRTS_LOCAL void mrts_lane_forward(int k, const mrts_lanes *L, mrts_lanes *b);
MRTS_LOCAL void mrts_lane_backward(int k, const mrts_lanes *L, mrts_lanes *b);

/* v -= w x r */
MRTS_LOCAL void mrts_less_cross(const mrts_lanes *w, const mrts_lanes *r, mrts_lanes *v);

/* The rates of a tip from those of its arm's joints, first .. end - 1 of all; `change` is the bias acceleration before. */
MRTS_LOCAL void mrts_tip_by_joints(int first, int end, const mrts_lanes *J, const mrts_lanes *dq, const mrts_lanes *ddq,
                                   mrts_lanes *rate, mrts_lanes *change);

#endif

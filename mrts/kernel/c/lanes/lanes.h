/* SPDX-License-Identifier: MIT
 *
 * Samples side by side in the lanes of vector registers: the same operations in the same order in each lane, whatever
 * registers the machine has, so that all machines give the same bits. */
#ifndef MRTS_LANES_H
#define MRTS_LANES_H

#include "../cell_sizes.h"
#include "../rows.h"
#include "lane_types.h"

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
#include "../sines.inc"
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

/* Sines and cosines of some angles, both of one after the other. */
static inline void mrts_sines(int count, const mrts_lanes *angle, mrts_lanes *both) {
    mrts_lane_mask far = {0};
    for (int i = 0; i < count; ++i) {
        mrts_sine_cosine_lanes(angle[i], both + 2 * i);
        far |= ~(mrts_sizes(angle[i]) <= MRTS_MOST_ANGLE);
    }
    for (int i = 0; mrts_any(far) && i < count * MRTS_LANES; ++i) {
        const double its = angle[i / MRTS_LANES][i % MRTS_LANES];
        if (MRTS_ABS(its) <= MRTS_MOST_ANGLE) continue;
        both[i / MRTS_LANES * 2][i % MRTS_LANES] = sin(its);
        both[i / MRTS_LANES * 2 + 1][i % MRTS_LANES] = cos(its);
    }
}

/* b of L b = b, and of L' b = b. */
static inline void mrts_lane_forward(int k, const mrts_lanes *L, mrts_lanes *b) {
    for (int i = 0; i < k; ++i) b[i] = mrts_less_lanes(i, b[i], L + i * k, 1, b) * L[i * (k + 1)];
}

static inline void mrts_lane_backward(int k, const mrts_lanes *L, mrts_lanes *b) {
    for (int i = k - 1; i >= 0; --i) {
        b[i] = mrts_less_lanes(k - 1 - i, b[i], L + (i + 1) * k + i, k, b + i + 1) * L[i * (k + 1)];
    }
}

static inline void mrts_take_inputs(const double *const *in, const long long *stride, long long first, long long count,
                                    int all, mrts_lane_inputs *lanes) {
    static const int sizes[MRTS_INPUTS] = MRTS_INPUT_SIZES;
    mrts_lanes *next = lanes->numbers;
    for (int lane = 0; lane < MRTS_LANES; ++lane) lanes->at[lane] = first + lane < count ? first + lane : count - 1;
    for (int i = 0; i < MRTS_INPUTS; next += sizes[i++]) {
        lanes->arg[i] = next;
        if (!all && !stride[i]) continue;
        const double *const own[] = {in[i] + lanes->at[0] * stride[i], in[i] + lanes->at[1] * stride[i],
                                     in[i] + lanes->at[2] * stride[i], in[i] + lanes->at[3] * stride[i]};
        MRTS_UNROLL
        for (int number = 0; number < sizes[i]; ++number) {
            next[number] = (mrts_lanes){own[0][number], own[1][number], own[2][number], own[3][number]};
        }
    }
}

static inline void mrts_samples_in(const mrts_limits *limits, const mrts_terms *terms, const mrts_rows *rows,
                                   double *memory, mrts_samples *samples) {
    enum { K = MRTS_UNKNOWNS };
    mrts_lanes *next = (mrts_lanes *)(void *)memory;
    samples->limits = limits;
    samples->terms = terms;
    samples->form = mrts_form_in_lanes(K, MRTS_JOINTS, MRTS_WRENCHES, next);
    samples->turned = next += MRTS_FORM_WORK(K, MRTS_JOINTS, MRTS_WRENCHES);
    samples->its_terms = next += MRTS_TURNED_WORK(K, MRTS_WRENCHES);
    samples->rows.count = rows->count;
    samples->rows.which = rows->which;
    samples->rows.unit = rows->unit;
    samples->rows.A = next += 2 * MRTS_JOINTS + 3 * limits->rows;
    samples->rows.lower = next += rows->count * K;
    samples->rows.upper = next += rows->count + K;
    samples->rows.size = next + rows->count + K;
}

static inline void mrts_take_terms(mrts_samples *samples) {
    const mrts_terms *all = samples->terms;
    const double *given[] = {all->torque_square, all->torque_offset, all->square, all->offset, all->margin};
    mrts_terms_lanes *own = &samples->own;
    const mrts_lanes **taken[] = {&own->torque_square, &own->torque_offset, &own->square, &own->offset, &own->margin};
    mrts_lanes *next = samples->its_terms;
    for (int i = 0; i < 5; ++i) {
        const int size = i < 2 ? MRTS_JOINTS : samples->limits->rows;
        *taken[i] = given[i] ? next : 0;
        for (int place = 0; given[i] && place < size; ++place) *next++ = mrts_term(given[i], samples->inputs.at, size, place);
    }
}

/* Takes the samples from `first` on, with the inputs that are the same for all only if `all`, and builds their rows; beyond
 * the last sample the last is repeated. */
static inline void mrts_take_samples(const double *const *in, const long long *stride, long long first, long long count,
                                     int all, mrts_samples *samples) {
    enum { K = MRTS_UNKNOWNS, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    mrts_form_lanes *form = &samples->form;
    mrts_lanes *const res[] = {form->torque_map, form->torque_offset, form->wrench_map, form->wrench_offset};
    mrts_lanes sines[2 * M];
    mrts_take_inputs(in, stride, first, count, all, &samples->inputs);
    mrts_take_terms(samples);
    mrts_sines(M, samples->inputs.arg[0], sines);
    MRTS_WRENCH_FORM_LANES(samples->inputs.arg, sines, res);
    mrts_add_motors_lanes(K, M, &samples->own, form);
    mrts_turn_wrenches_lanes(K, MRTS_ROBOTS, MRTS_SIZE, samples->limits, samples->inputs.arg[MRTS_ROTATION], 1, 3,
                             samples->turned, form);
    samples->finite = mrts_build_rows_lanes(K, M, N, form, samples->limits, &samples->own, &samples->rows);
}

/* The rows of one of them over k unknowns; of the unknowns whatever limits they have. */
static inline void mrts_rows_of_lane(int k, const mrts_samples *samples, int lane, mrts_rows *rows) {
    const mrts_rows_lanes *from = &samples->rows;
    mrts_take_lane(from->count * k, from->A, lane, rows->A);
    mrts_take_lane(from->count + k, from->lower, lane, rows->lower);
    mrts_take_lane(from->count + k, from->upper, lane, rows->upper);
    mrts_take_lane(k, from->size, lane, rows->size);
}

#endif

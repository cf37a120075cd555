/* SPDX-License-Identifier: MIT
 *
 * Many variants of one cell along its motion: the same arms and rows, other numbers.
 */
#ifndef MRTS_VARIANTS_H
#define MRTS_VARIANTS_H

#include "../tracking/tracking.h"

/* How variants start and follow. */
typedef struct {
    mrts_tracking task;         /* of the steps at a sample; the geometry is each variant's */
    int start_steps;            /* most Newton steps from the posture to the grasp at the first sample */
    int further;                /* starts that are tried where the posture leads to nothing */
    int further_steps;          /* most steps from each of them */
    double jump;                /* correction of a predicted joint at which an arm has lost its branch [rad or m] */
    double drift;               /* step left to a redundant arm that is not settled [rad or m] */
    double fold;                /* curvature at which its positions end */
    double past;                /* how far a joint may pass its limit [rad or m] */
    const unsigned char *turns; /* whether whole turns of a joint are the same position, (joints) */
} mrts_following;

/* How following a variant ends. */
enum {
    MRTS_FOLLOWED = 0,
    MRTS_NO_START = 1,     /* no start leads to the grasp at the first sample; amounts: the least errors [m, rad] */
    MRTS_START_PAST = 2,   /* those that do are past a limit of a joint; amount: its position */
    MRTS_OUT_OF_REACH = 3, /* amounts: remaining errors [m, rad] */
    MRTS_LOST = 4,         /* it would have to jump; amount: how far [rad or m] */
    MRTS_PAST_LIMIT = 5,   /* of a joint; amount: its position */
    MRTS_UNSETTLED = 6,    /* left to another way to decide */
    MRTS_REFUSED = 7       /* by the caller: passed over */
};

/* Of the first arm in order that cannot follow. */
typedef struct {
    int code, robot, sample, joint; /* the joint counted in its arm */
    double amount[2];
} mrts_outcome;

#endif

/* SPDX-License-Identifier: MIT
 *
 * The joints of many variants of one cell along its motion; one motion is one variant.
 */
#ifndef MRTS_FOLLOW_H
#define MRTS_FOLLOW_H

#include "tracking.h"

/* How variants start and follow. */
typedef struct {
    mrts_tracking task;         /* of the steps at a sample; the geometry is each variant's */
    int start_steps;            /* most Newton steps from the posture to the grasp at the first sample; 0: it holds it */
    int further;                /* starts that are tried where the posture leads to nothing */
    int further_steps;          /* most steps from each of them */
    double past;                /* how far a joint may pass its limit [rad or m] */
    const unsigned char *turns; /* whether whole turns of a joint are the same position, (joints) */
} mrts_following;

/* How following ends for an arm. */
enum {
    MRTS_FOLLOWED = 0,
    MRTS_NO_START = 1,     /* no start leads to the grasp at the first sample; amounts: the least errors [m, rad] */
    MRTS_START_PAST = 2,   /* those that do are past a limit of a joint; amount: its position */
    MRTS_OUT_OF_REACH = 3, /* amounts: remaining errors [m, rad] */
    MRTS_LOST = 4,         /* it would have to jump; amount: how far [rad or m] */
    MRTS_FOLDED = 5,       /* the positions that a redundant arm prefers end */
    MRTS_SINGULAR = 6,     /* amount: condition number */
    MRTS_PAST_LIMIT = 7,   /* of a joint, of an arm that is followed to the end; amount: its position */
    MRTS_LEFT_LIMITS = 8,  /* a redundant arm, which then failed; amount: the joint's position */
    MRTS_REFUSED = 9       /* by the caller: passed over */
};

/* Of one arm of a variant. */
typedef struct {
    int code, sample, joint; /* the joint counted in its arm */
    int start;               /* which led to the grasp: 0 the posture, then the further ones */
    double amount[2];
} mrts_outcome;

#endif

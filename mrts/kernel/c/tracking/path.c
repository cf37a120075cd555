/* SPDX-License-Identifier: MIT
 *
 * Inverse kinematics at a sample of a path, from positions that those before it predict.
 */
#include "tracking.h"

/* How far the prediction from two samples may be from that of one [rad or m]: beyond, something jumps. */
#define MRTS_SMOOTH 1e-2

/* Relative difference of two steps of time that is rounding. */
#define MRTS_SAME_STEP 1e-9

/* q at a sample from q, q', q'' at those before it, a step h apart each: the polynomial through the last three or two
 * of them. Taylor's of second degree from the last one where there is no more (known = 1), or where the two differ. */
static void mrts_predict(const double *q, const double *dq, const double *ddq, double h, long long known,
                         const unsigned char *left_out, double *taylor, double *now) {
    enum { M = MRTS_JOINTS };
    double apart = 0;
    for (int robot = 0; robot < MRTS_ROBOTS; ++robot) {
        for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1); ++i) {
            const double b = q[i], b1 = h * dq[i], b2 = h * h * ddq[i];
            now[i] = taylor[i] = left_out[robot] ? b : b + b1 + b2 / 2;
            if (known < 2 || left_out[robot]) continue;
            const double a = q[i - M], a1 = h * dq[i - M], a2 = h * h * ddq[i - M];
            if (known == 2) {
                now[i] = b + 31 * (b - a) - 16 * b1 - 14 * a1 + 4 * b2 - 2 * a2;
            } else {
                const double z = q[i - 2 * M], z1 = h * dq[i - 2 * M], z2 = h * h * ddq[i - 2 * M];
                now[i] = b + 228.5 * (b - a) - 122.5 * (a - z) - 94.5 * b1 - 54 * a1 + 43.5 * z1 + 13.5 * b2 - 54 * a2 +
                         4.5 * z2;
            }
            apart = fmax(apart, fabs(now[i] - taylor[i]));
        }
    }
    for (int i = 0; i < M && !(apart <= MRTS_SMOOTH); ++i) now[i] = taylor[i];
}

/* How far each arm's joints are from Taylor's prediction; returns the farthest. */
static double mrts_note_jumps(const double *q, const double *taylor, mrts_held *held) {
    double farthest = 0;
    for (int robot = 0; robot < MRTS_ROBOTS; ++robot) {
        held->jump[robot] = 0;
        for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1); ++i) {
            held->jump[robot] = fmax(held->jump[robot], fabs(q[i] - taylor[i]));
        }
        farthest = fmax(farthest, held->jump[robot]);
    }
    return farthest;
}

MRTS_LOCAL void mrts_track_sample(const mrts_tracking *task, const double *time, const mrts_path *path, long long n,
                                  const double *reference, const unsigned char *left_out, long long *even, double *q,
                                  double *dq, double *ddq, mrts_held *held) {
    enum { M = MRTS_JOINTS };
    const mrts_path at = {path->position + 3 * n, path->rotation + 9 * n, path->twist + 6 * n, path->acceleration + 6 * n};
    double taylor[M], now[M];
    if (n == 0) {
        for (int i = 0; i < M; ++i) taylor[i] = q[i];
    } else {
        const double h = time[n] - time[n - 1];
        *even = n > 1 && fabs(time[n - 1] - time[n - 2] - h) <= MRTS_SAME_STEP * h ? *even + 1 : 1;
        mrts_predict(q - M, dq - M, ddq - M, h, *even, left_out, taylor, q);
    }
#ifndef MRTS_UNEVEN
    if (mrts_quick_sample(task, &at, left_out, q, dq, ddq, held) &&
        mrts_note_jumps(q, taylor, held) <= task->jump) {
        return;
    }
#endif
    for (int i = 0; i < M; ++i) now[i] = taylor[i];
    mrts_hold_grasps(task, at.position, at.rotation, reference, left_out, now, q, held->gap, held->turn, held->drift);
    mrts_joint_rates(task, &at, reference, left_out, q, dq, ddq, held);
    mrts_note_jumps(q, taylor, held);
}

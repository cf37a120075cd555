/* SPDX-License-Identifier: MIT
 *
 * Inverse kinematics along a whole path, each sample from positions that those before it predict.
 */
#include "tracking.h"

/* How far the prediction from two samples may be from that of one [rad or m]: beyond, something jumps. */
#define MRTS_SMOOTH 1e-2

/* Relative difference of two steps of time that is rounding. */
#define MRTS_SAME_STEP 1e-9

/* q at a sample from q, q', q'' at those before it, a step h apart each: the polynomial through the last three or two
 * of them. Taylor's of second degree from the last one where there is no more (known = 1), or where the two differ. */
static void mrts_predict(const double *q, const double *dq, const double *ddq, double h, long long known, double *taylor,
                         double *now) {
    enum { M = MRTS_JOINTS };
    double apart = 0;
    for (int i = 0; i < M; ++i) {
        const double b = q[i], b1 = h * dq[i], b2 = h * h * ddq[i];
        now[i] = taylor[i] = b + b1 + b2 / 2;
        if (known < 2) continue;
        const double a = q[i - M], a1 = h * dq[i - M], a2 = h * h * ddq[i - M];
        if (known == 2) {
            now[i] = b + 31 * (b - a) - 16 * b1 - 14 * a1 + 4 * b2 - 2 * a2;
        } else {
            const double z = q[i - 2 * M], z1 = h * dq[i - 2 * M], z2 = h * h * ddq[i - 2 * M];
            now[i] = b + 228.5 * (b - a) - 122.5 * (a - z) - 94.5 * b1 - 54 * a1 + 43.5 * z1 + 13.5 * b2 - 54 * a2 + 4.5 * z2;
        }
        apart = fmax(apart, fabs(now[i] - taylor[i]));
    }
    for (int i = 0; i < M && !(apart <= MRTS_SMOOTH); ++i) now[i] = taylor[i];
}

/* One sample by the rule of tracking.c, from Taylor's prediction; 0 if an arm is singular. */
static int mrts_sample_by_rule(const mrts_tracking *task, const mrts_path *at, const double *reference,
                               const double *taylor, double *q, double *dq, double *ddq, mrts_held *held) {
    double now[MRTS_JOINTS];
    for (int i = 0; i < MRTS_JOINTS; ++i) now[i] = taylor[i];
    return mrts_hold_grasps(task, at->position, at->rotation, reference, now, q, held->gap, held->turn, held->drift) &&
           mrts_joint_rates(task, at->rotation, at->twist, at->acceleration, reference, q, dq, ddq, held->condition, held->curvature);
}

MRTS_LOCAL int mrts_track_sample(const mrts_tracking *task, const double *time, const mrts_path *path, long long n,
                                 const double *reference, const unsigned char *left_out, long long *even, double *q,
                                 double *dq, double *ddq, mrts_held *held) {
    enum { M = MRTS_JOINTS };
    const mrts_path at = {path->position + 3 * n, path->rotation + 9 * n, path->twist + 6 * n, path->acceleration + 6 * n};
    double taylor[M];
    int done = 0;
    if (n == 0) {
        for (int i = 0; i < M; ++i) taylor[i] = q[i];
    } else {
        const double h = time[n] - time[n - 1];
        *even = n > 1 && fabs(time[n - 1] - time[n - 2] - h) <= MRTS_SAME_STEP * h ? *even + 1 : 1;
        mrts_predict(q - M, dq - M, ddq - M, h, *even, taylor, q);
    }
#ifdef MRTS_REDUNDANT
    (void)left_out;
#else
    done = mrts_quick_sample(task, &at, left_out, q, dq, ddq, held);
#endif
    if (!done && !mrts_sample_by_rule(task, &at, reference, taylor, q, dq, ddq, held)) return 0;
    for (int robot = 0; robot < MRTS_ROBOTS; ++robot) {
        held->jump[robot] = 0;
        for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1); ++i) {
            held->jump[robot] = fmax(held->jump[robot], fabs(q[i] - taylor[i]));
        }
    }
    return 1;
}

/* Follows the grasps from q at sample 0, which holds them, and tells of each sample how they are held. Rotations of the
 * object come by rows. Ends early, with the number of samples done, where an arm is singular. */
MRTS_EXPORT long long mrts_track(long long count, const mrts_tracking *task, const double *time, const double *position,
                                 const double *rotation, const double *twist, const double *acceleration, double *q,
                                 double *dq, double *ddq, mrts_held *held) {
    enum { M = MRTS_JOINTS };
    const mrts_path path = {position, rotation, twist, acceleration};
    const unsigned char left_out[MRTS_ROBOTS] = {0};
    double reference[M];
    long long even = 0;
    for (int i = 0; i < M; ++i) reference[i] = q[i];
    for (long long n = 0; n < count; ++n) {
        if (!mrts_track_sample(task, time, &path, n, reference, left_out, &even, q + n * M, dq + n * M, ddq + n * M,
                               held + n)) {
            return n;
        }
    }
    return count;
}

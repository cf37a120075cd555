/* SPDX-License-Identifier: MIT
 *
 * The joints of many variants of a cell along its motion: where each starts, and how it follows from there.
 */
#include "variants.h"

/* A whole turn [rad]. */
#define MRTS_TURN 6.283185307179586

/* What to add to the positions of a joint along a path, from `low` to `high`, to bring them inside its limits by whole
 * turns; 0 where that does not help. */
static double mrts_turns_inside(double low, double high, double lower, double upper, double past) {
    const double turn = MRTS_TURN, down = ceil((high - upper) / turn - past), up = ceil((lower - low) / turn - past);
    double moved = 0;
    if (down > 0 && low - turn * down >= lower - past) moved -= turn * down;
    if (up > 0 && high + turn * up <= upper + past) moved += turn * up;
    return moved;
}

/* Moves positions of one arm at one sample inside their limits where whole turns do it; the first joint that is still
 * past one by more than rounding, -1 if none is. */
static int mrts_into_limits(const mrts_following *rule, int robot, double *q) {
    for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1); ++i) {
        double *at = q + i - MRTS_FIRST(robot);
        const double lower = rule->task.wish.lower[i], upper = rule->task.wish.upper[i];
        if (rule->turns[i]) *at += mrts_turns_inside(*at, *at, lower, upper, rule->past);
    }
    for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1); ++i) {
        const double at = q[i - MRTS_FIRST(robot)];
        if (fmax(rule->task.wish.lower[i] - at, at - rule->task.wish.upper[i]) > rule->past) return i - MRTS_FIRST(robot);
    }
    return -1;
}

/* The first sample at which a joint of an arm is past its limits, whole turns of its whole path aside. */
static int mrts_past_limits(const mrts_following *rule, long long samples, int robot, const double *q,
                            mrts_outcome *outcome) {
    enum { M = MRTS_JOINTS };
    long long earliest = samples;
    for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1); ++i) {
        const double lower = rule->task.wish.lower[i], upper = rule->task.wish.upper[i];
        double low = q[i], high = q[i], moved = 0;
        for (long long n = 1; n < samples; ++n) {
            low = fmin(low, q[n * M + i]);
            high = fmax(high, q[n * M + i]);
        }
        if (rule->turns[i]) moved = mrts_turns_inside(low, high, lower, upper, rule->past);
        if (fmax(lower - low - moved, high + moved - upper) <= rule->past) continue;
        for (long long n = 0; n < earliest; ++n) {
            const double at = q[n * M + i] + moved;
            if (fmax(lower - at, at - upper) > rule->past) {
                earliest = n;
                *outcome = (mrts_outcome){MRTS_PAST_LIMIT, robot, (int)n, i - MRTS_FIRST(robot), {at, 0}};
            }
        }
    }
    return earliest < samples;
}

/* What has been found of one arm's start: the nearest positions that hold the grasp, and of the others why not. */
typedef struct {
    double distance, q[MRTS_MOST_JOINTS];
    double gap, turn;
    int past;
    double at;
} mrts_start;

/* Takes up where one start of an arm led. */
static void mrts_take_start(const mrts_following *rule, int robot, const double *posture, const double *found, double gap,
                            double turn, int given, mrts_start *start) {
    const int first = MRTS_FIRST(robot), joints = MRTS_FIRST(robot + 1) - first;
    double q[MRTS_MOST_JOINTS], distance = 0;
    if (fmax(gap, turn) < fmax(start->gap, start->turn)) {
        start->gap = gap;
        start->turn = turn;
    }
    if (!(fmax(gap, turn) <= rule->task.reached)) return;
    for (int i = 0; i < joints; ++i) q[i] = found[first + i];
    const int past = mrts_into_limits(rule, robot, q);
    if (past >= 0 && start->past < 0) {
        start->past = past;
        start->at = q[past];
    }
    if (past >= 0) return;
    for (int i = 0; i < joints && !given; ++i) {
        const double away = found[first + i] - posture[first + i] + MRTS_TURN / 2;
        q[i] = rule->turns[first + i] ? posture[first + i] + (away - MRTS_TURN * floor(away / MRTS_TURN)) - MRTS_TURN / 2
                                      : found[first + i];
    }
    if (!given) mrts_into_limits(rule, robot, q);
    for (int i = 0; i < joints && !given; ++i) distance = fmax(distance, fabs(q[i] - posture[first + i]));
    if (distance >= start->distance) return;
    start->distance = distance;
    for (int i = 0; i < joints; ++i) start->q[i] = given ? found[first + i] : q[i];
}

/* Joints that hold the grasps at the first sample, near the posture; 0 where an arm has none. `seed` is where the first
 * search begins; `further` are the starts that follow where that leads to nothing, (further, joints). */
static int mrts_find_start(const mrts_following *rule, const mrts_path *at, const double *posture, const double *seed,
                           const double *further, double *q, mrts_outcome *outcome) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS };
    double now[M], reference[M], gap[R], turn[R], drift[R], found[M];
    mrts_tracking task = rule->task;
    mrts_start start[R];
    int lost = 0;
    for (int i = 0; i < M; ++i) {
        now[i] = seed[i];
        reference[i] = fmin(fmax(posture[i], task.wish.lower[i]), task.wish.upper[i]);
    }
    *outcome = (mrts_outcome){MRTS_UNSETTLED, 0, 0, 0, {0, 0}};
    for (int attempt = 0; attempt <= rule->further && (attempt == 0 || lost); ++attempt) {
        for (int i = 0; i < M && attempt > 0; ++i) now[i] = further[(attempt - 1) * M + i];
        task.steps = attempt ? rule->further_steps : rule->start_steps;
        if (!mrts_hold_grasps(&task, at->position, at->rotation, reference, now, found, gap, turn, drift)) {
            return 0;
        }
        for (int robot = 0; robot < R; ++robot) {
            if (attempt == 0) {
                start[robot].distance = start[robot].gap = start[robot].turn = MRTS_INFINITY;
                start[robot].past = -1;
            } else if (start[robot].distance == 0) {
                continue;
            }
            mrts_take_start(rule, robot, posture, found, gap[robot], turn[robot], attempt == 0, start + robot);
            if (attempt == 0) lost += start[robot].distance > 0;
        }
    }
    for (int robot = 0; robot < R; ++robot) {
        const mrts_start *of_arm = start + robot;
        if (of_arm->distance >= MRTS_INFINITY) {
            *outcome = of_arm->past < 0
                           ? (mrts_outcome){MRTS_NO_START, robot, 0, 0, {of_arm->gap, of_arm->turn}}
                           : (mrts_outcome){MRTS_START_PAST, robot, 0, of_arm->past, {of_arm->at, 0}};
            return 0;
        }
        for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1); ++i) q[i] = of_arm->q[i - MRTS_FIRST(robot)];
    }
    return 1;
}

/* Takes up how the arms hold their grasps at a sample: those that fail there, by what they fail. 0 where that cannot be
 * told. */
static int mrts_note_failures(const mrts_following *rule, const mrts_held *held, int sample, mrts_outcome *failures,
                              unsigned char *failed) {
    for (int robot = 0; robot < MRTS_ROBOTS; ++robot) {
        mrts_outcome *of = failures + robot;
        if (failed[robot]) continue;
        if (!(fmax(held->gap[robot], held->turn[robot]) <= rule->task.reached)) {
            *of = (mrts_outcome){MRTS_OUT_OF_REACH, robot, sample, 0, {held->gap[robot], held->turn[robot]}};
        } else if (!(held->condition[robot] < rule->task.condition && held->drift[robot] <= rule->drift &&
                     held->curvature[robot] > rule->fold)) {
            return 0;
        } else if (held->jump[robot] > rule->jump) {
            *of = (mrts_outcome){MRTS_LOST, robot, sample, 0, {held->jump[robot], 0}};
        }
        failed[robot] = of->code != MRTS_FOLLOWED;
    }
    return 1;
}

/* Follows one variant from its start: q, q', q'' of all samples, and how that ends. An arm that fails is not looked at
 * again; what counts is the first one in order. */
static void mrts_follow_one(const mrts_following *rule, long long samples, const double *time, const mrts_path *path,
                            double *q, double *dq, double *ddq, mrts_outcome *outcome) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS };
    double reference[M];
    unsigned char failed[R] = {0};
    mrts_outcome failures[R];
    mrts_held held;
    long long even = 0;
    for (int robot = 0; robot < R; ++robot) failures[robot].code = MRTS_FOLLOWED;
    for (int i = 0; i < M; ++i) reference[i] = q[i];
    for (long long n = 0; n < samples && !failed[0]; ++n) {
        const long long at = n * M;
        if (!mrts_track_sample(&rule->task, time, path, n, reference, failed, &even, q + at, dq + at, ddq + at, &held) ||
            !mrts_note_failures(rule, &held, (int)n, failures, failed)) {
            outcome->code = MRTS_UNSETTLED;
            return;
        }
    }
    outcome->code = MRTS_FOLLOWED;
    for (int robot = 0; robot < R && outcome->code == MRTS_FOLLOWED; ++robot) *outcome = failures[robot];
    for (int robot = 0; robot < R && outcome->code == MRTS_FOLLOWED; ++robot) {
        mrts_past_limits(rule, samples, robot, q, outcome);
    }
}

/* Follows variants 0 .. count - 1, each of the same number of samples. Arrays are of all variants one after the other;
 * a stride, in reals from one variant to the next, is 0 where they share one. Variants with MRTS_REFUSED are passed
 * over. */
MRTS_EXPORT void mrts_follow_variants(long long count, long long samples, const mrts_following *rule,
                                      const double *const *given, const long long *stride, double *q, double *dq,
                                      double *ddq, mrts_outcome *outcome) {
    enum { M = MRTS_JOINTS, TIME = 0, POSITION, ROTATION, TWIST, ACCELERATION, GEOMETRY, POSTURE, SEED, FURTHER, GIVEN };
    mrts_following here = *rule;
    for (long long v = 0; v < count; ++v) {
        const double *of[GIVEN];
        const long long first = v * samples * M;
        if (outcome[v].code == MRTS_REFUSED) continue;
        for (int i = 0; i < GIVEN; ++i) of[i] = given[i] + v * stride[i];
        const mrts_path path = {of[POSITION], of[ROTATION], of[TWIST], of[ACCELERATION]};
        here.task.geometry = of[GEOMETRY];
        if (mrts_find_start(&here, &path, of[POSTURE], of[SEED], of[FURTHER], q + first, outcome + v)) {
            mrts_follow_one(&here, samples, of[TIME], &path, q + first, dq + first, ddq + first, outcome + v);
        }
    }
}

/* SPDX-License-Identifier: MIT
 *
 * The joints of many variants of a cell along its motion: where each starts, and how its arms follow from there.
 */
#include "follow.h"

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

/* Moves a joint's path of some samples inside its limits by whole turns, where it may turn and they do it; takes up the
 * first sample before `earliest` at which it is still past one, which is returned. */
static long long mrts_joint_past(const mrts_following *rule, long long samples, int turns, int robot, int i, double *q,
                                 long long earliest, mrts_outcome *outcome) {
    enum { M = MRTS_JOINTS };
    const double lower = rule->task.wish.lower[i], upper = rule->task.wish.upper[i];
    double low = MRTS_INFINITY, high = -MRTS_INFINITY, moved = 0;
    for (long long n = 0; n < samples; ++n) {
        low = fmin(low, q[n * M + i]);
        high = fmax(high, q[n * M + i]);
    }
    if (turns && rule->turns[i]) moved = mrts_turns_inside(low, high, lower, upper, rule->past);
    for (long long n = 0; moved != 0 && n < samples; ++n) q[n * M + i] += moved;
    if (fmax(lower - low - moved, high + moved - upper) <= rule->past) return earliest;
    for (long long n = 0; n < earliest; ++n) {
        const double at = q[n * M + i];
        if (fmax(lower - at, at - upper) > rule->past) {
            *outcome = (mrts_outcome){MRTS_PAST_LIMIT, (int)n, i - MRTS_FIRST(robot), outcome->start, {at, 0}};
            return n;
        }
    }
    return earliest;
}

/* The same of all joints of an arm. */
static void mrts_past_limits(const mrts_following *rule, long long samples, int turns, int robot, double *q,
                             mrts_outcome *outcome) {
    long long earliest = samples;
    for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1) && samples > 0; ++i) {
        earliest = mrts_joint_past(rule, samples, turns, robot, i, q, earliest, outcome);
    }
}

/* What has been found of one arm's start: the nearest positions that hold the grasp, and of the others why not. */
typedef struct {
    double distance, q[MRTS_MOST_JOINTS];
    double gap, turn;
    int past, attempt;
    double at;
} mrts_start;

/* Takes up where one start of an arm led. */
static void mrts_take_start(const mrts_following *rule, int robot, const double *posture, const double *found, double gap,
                            double turn, int attempt, mrts_start *start) {
    const int given = attempt == 0;
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
    start->attempt = attempt;
    for (int i = 0; i < joints; ++i) start->q[i] = given ? found[first + i] : q[i];
}

/* Joints that hold the grasps at the first sample, near the posture; 0 where an arm has none. The first search begins at
 * the posture; `further` are the starts that follow where that leads to nothing, (further, joints). */
static int mrts_find_start(const mrts_following *rule, const mrts_path *at, const double *posture, const double *further,
                           double *q, mrts_outcome *outcome) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS };
    double now[M], reference[M], gap[R], turn[R], drift[R], found[M];
    unsigned char done[R] = {0};
    mrts_tracking task = rule->task;
    mrts_start start[R];
    int lost = R;
    for (int robot = 0; robot < R; ++robot) {
        start[robot].distance = start[robot].gap = start[robot].turn = MRTS_INFINITY;
        start[robot].past = -1;
    }
    for (int i = 0; i < M; ++i) reference[i] = fmin(fmax(posture[i], task.wish.lower[i]), task.wish.upper[i]);
    for (int attempt = 0; attempt <= rule->further && lost; ++attempt) {
        for (int i = 0; i < M; ++i) now[i] = attempt ? further[(attempt - 1) * M + i] : posture[i];
        task.steps = attempt ? rule->further_steps : rule->start_steps;
        mrts_hold_grasps(&task, at->position, at->rotation, reference, done, now, found, gap, turn, drift);
        for (int robot = 0; robot < R; ++robot) {
            if (done[robot]) continue;
            mrts_take_start(rule, robot, posture, found, gap[robot], turn[robot], attempt, start + robot);
            done[robot] = start[robot].distance == 0;
            lost -= done[robot];
        }
    }
    for (int robot = 0; robot < R; ++robot) {
        const mrts_start *of = start + robot;
        outcome[robot] = (mrts_outcome){MRTS_FOLLOWED, 0, 0, of->attempt, {0, 0}};
        if (of->distance < MRTS_INFINITY) {
            for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1); ++i) q[i] = of->q[i - MRTS_FIRST(robot)];
            continue;
        }
        lost = -1;
        outcome[robot] = of->past < 0 ? (mrts_outcome){MRTS_NO_START, 0, 0, 0, {of->gap, of->turn}}
                                      : (mrts_outcome){MRTS_START_PAST, 0, of->past, 0, {of->at, 0}};
    }
    return lost >= 0;
}

/* How an arm fails to hold its grasp at a sample, if it does. */
static void mrts_note_failure(const mrts_tracking *task, const mrts_held *held, int robot, int sample,
                              mrts_outcome *outcome) {
    const double jump = held->jump[robot], condition = held->condition[robot];
    const double gap = held->gap[robot], turn = held->turn[robot];
    mrts_outcome found = {MRTS_FOLLOWED, sample, 0, outcome->start, {0, 0}};
    if (!(fmax(gap, turn) <= task->reached)) {
        found.code = MRTS_OUT_OF_REACH;
        found.amount[0] = gap;
        found.amount[1] = turn;
    } else if (!(held->drift[robot] <= task->drift)) {
        found.code = MRTS_FOLDED;
    } else if (jump > task->jump) {
        found.code = MRTS_LOST;
        found.amount[0] = jump;
    } else if (!(condition < task->condition)) {
        found.code = MRTS_SINGULAR;
        found.amount[0] = condition;
    } else if (held->folds[robot]) {
        found.code = MRTS_FOLDED;
    }
    if (found.code != MRTS_FOLLOWED) *outcome = found;
}

/* Follows one variant from its start: q, q', q'' of all samples, and how that ends for each arm. One that fails is not
 * looked at again. */
static void mrts_follow_one(const mrts_following *rule, long long samples, const double *time, const mrts_path *path,
                            double *q, double *dq, double *ddq, mrts_outcome *outcome) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS };
    double reference[M];
    unsigned char failed[R] = {0};
    mrts_held held;
    long long even = 0;
    int left = R;
    for (int i = 0; i < M; ++i) reference[i] = q[i];
    for (long long n = 0; n < samples && left; ++n) {
        const long long at = n * M;
        mrts_track_sample(&rule->task, time, path, n, reference, failed, &even, q + at, dq + at, ddq + at, &held);
        for (int robot = 0; robot < R; ++robot) {
            if (failed[robot]) continue;
            mrts_note_failure(&rule->task, &held, robot, (int)n, outcome + robot);
            failed[robot] = outcome[robot].code != MRTS_FOLLOWED;
            left -= failed[robot];
            if (failed[robot] && MRTS_FIRST(robot + 1) - MRTS_FIRST(robot) > MRTS_SIZE) {
                /* between its limits a redundant arm fails soon after it passed one, which is then the reason */
                mrts_past_limits(rule, n, 0, robot, q, outcome + robot);
                if (outcome[robot].code == MRTS_PAST_LIMIT) outcome[robot].code = MRTS_LEFT_LIMITS;
            }
        }
    }
    for (int robot = 0; robot < R; ++robot) {
        if (!failed[robot]) mrts_past_limits(rule, samples, 1, robot, q, outcome + robot);
    }
}

/* Follows variants 0 .. count - 1, each of the same number of samples. Arrays are of all variants one after the other;
 * a stride, in reals from one variant to the next, is 0 where they share one. Outcomes are of each arm of each variant;
 * variants of which the first has MRTS_REFUSED are passed over. */
MRTS_EXPORT void mrts_follow(long long count, long long samples, const mrts_following *rule, const double *const *given,
                             const long long *stride, double *q, double *dq, double *ddq, mrts_outcome *outcome) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS };
    enum { TIME, POSITION, ROTATION, TWIST, ACCELERATION, GEOMETRY, POSTURE, FURTHER, GIVEN };
    mrts_following here = *rule;
    for (long long v = 0; v < count; ++v, outcome += R) {
        const double *of[GIVEN];
        const long long first = v * samples * M;
        if (outcome->code == MRTS_REFUSED) continue;
        for (int i = 0; i < GIVEN; ++i) of[i] = given[i] + v * stride[i];
        const mrts_path path = {of[POSITION], of[ROTATION], of[TWIST], of[ACCELERATION]};
        here.task.geometry = of[GEOMETRY];
        for (int i = 0; i < M; ++i) q[first + i] = of[POSTURE][i];
        if (rule->start_steps == 0 || mrts_find_start(&here, &path, of[POSTURE], of[FURTHER], q + first, outcome)) {
            mrts_follow_one(&here, samples, of[TIME], &path, q + first, dq + first, ddq + first, outcome);
        }
    }
}

/* Joints that hold the grasps at one sample each, (count, joints): from q on, which they replace. Of references there may
 * be none; strides as above. */
MRTS_EXPORT void mrts_hold(long long count, const mrts_tracking *task, const double *const *given, const long long *stride,
                           double *q, double *gap, double *turn, double *drift) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, POSITION = 0, ROTATION, REFERENCE, GIVEN };
    const unsigned char left_out[R] = {0};
    for (long long n = 0; n < count; ++n, q += M, gap += R, turn += R, drift += R) {
        const double *of[GIVEN];
        double now[M];
        for (int i = 0; i < GIVEN; ++i) of[i] = given[i] ? given[i] + n * stride[i] : given[i];
        for (int i = 0; i < M; ++i) now[i] = q[i];
        mrts_hold_grasps(task, of[POSITION], of[ROTATION], of[REFERENCE], left_out, now, q, gap, turn, drift);
    }
}

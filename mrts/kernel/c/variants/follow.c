/* SPDX-License-Identifier: MIT
 *
 * The joints of many variants of a cell along its motion: where each starts, and how it follows from there. The rule is
 * that of tracking.c; a sample takes one evaluation of the kinematics where the two samples before predict it well.
 */
#include "variants.h"

/* Largest step [rad or m] after which the Jacobian before it counts as that after it: its share of an error of q'. */
#define MRTS_FINE 1e-11

/* How far the prediction from two samples may be from that of one [rad or m]: beyond, something jumps. */
#define MRTS_SMOOTH 1e-2

/* Relative difference of two steps of time that is rounding. */
#define MRTS_SAME_STEP 1e-9

/* A whole turn [rad]. */
#define MRTS_TURN 6.283185307179586

/* Steps of the fast iteration; what takes more is left to the rule of tracking.c. */
enum { MRTS_QUICK = 4 };

/* q at a sample from q, q', q'' at those before it, a step h apart each: the polynomial through the last three or two of them.
 * Taylor's of second degree from the last one where there is no more (known = 1), or where the two differ. */
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

#ifndef MRTS_REDUNDANT

/* J' q' of one arm in cell components from the columns of J alone: a joint turns every column behind it about its axis, and
 * one behind it moves with it. */
static void mrts_bias_of_columns(const mrts_tracking *task, const double *J, const double *dq, double *bias) {
    enum { W = MRTS_SIZE };
    double before[3] = {0}, six[6] = {0};
    for (int l = 0; l < W; ++l) {
        double column[6] = {0}, both[3], moved[3], turned[3];
        for (int i = 0; i < W; ++i) column[task->components[i]] = J[l * W + i];
        for (int i = 0; i < 3; ++i) both[i] = 2 * before[i] + column[3 + i] * dq[l];
        mrts_cross(both, column, moved);
        mrts_cross(before, column + 3, turned);
        for (int i = 0; i < 3; ++i) {
            six[i] += moved[i] * dq[l];
            six[3 + i] += turned[i] * dq[l];
            before[i] += column[3 + i] * dq[l];
        }
    }
    for (int i = 0; i < W; ++i) bias[i] = six[task->components[i]];
}

/* A Jacobian as the product of two triangles, for arms with as many joints as wrench components. */
typedef struct {
    double triangles[MRTS_SIZE * MRTS_SIZE];
    int row[MRTS_SIZE]; /* of the Jacobian, of each row of theirs */
} mrts_factors;

/* Factors J, by columns, with row exchanges. Returns a bound of its condition number by its determinant (H. Guggenheimer,
 * A. Edelman, C. Johnson, A simple estimate of the condition number of a linear system, The College Mathematics Journal 26,
 * 1995), infinite where it is singular. */
static double mrts_factor(const double *J, mrts_factors *factors) {
    enum { W = MRTS_SIZE };
    double *LU = factors->triangles, square = 0, determinant = 1;
    for (int i = 0; i < W; ++i) {
        factors->row[i] = i;
        for (int j = 0; j < W; ++j) {
            LU[i * W + j] = J[j * W + i];
            square += J[j * W + i] * J[j * W + i];
        }
    }
    for (int j = 0; j < W; ++j) {
        int p = j;
        for (int i = j + 1; i < W; ++i) {
            if (fabs(LU[i * W + j]) > fabs(LU[p * W + j])) p = i;
        }
        if (!(fabs(LU[p * W + j]) > 0)) return MRTS_INFINITY;
        if (p != j) {
            const int row = factors->row[j];
            factors->row[j] = factors->row[p];
            factors->row[p] = row;
            for (int l = 0; l < W; ++l) {
                const double t = LU[j * W + l];
                LU[j * W + l] = LU[p * W + l];
                LU[p * W + l] = t;
            }
        }
        determinant *= LU[j * W + j] * LU[j * W + j];
        const double factor = 1 / LU[j * W + j];
        for (int i = j + 1; i < W; ++i) {
            const double f = LU[i * W + j] *= factor;
            for (int l = j + 1; l < W; ++l) LU[i * W + l] -= f * LU[j * W + l];
        }
        LU[j * W + j] = factor;
    }
    for (int i = 0; i < W; ++i) determinant /= square / W;
    return 2 / sqrt(determinant);
}

/* x with J x = y. */
static void mrts_solve(const mrts_factors *factors, const double *y, double *x) {
    enum { W = MRTS_SIZE };
    const double *LU = factors->triangles;
    for (int i = 0; i < W; ++i) {
        double rest = y[factors->row[i]];
        for (int l = 0; l < i; ++l) rest -= LU[i * W + l] * x[l];
        x[i] = rest;
    }
    for (int i = W - 1; i >= 0; --i) {
        double rest = x[i];
        for (int l = i + 1; l < W; ++l) rest -= LU[i * W + l] * x[l];
        x[i] = rest * LU[i * W + i];
    }
}

/* q, q', q'' at a sample by undamped Newton steps from `now`, which is moved, and a bound of each Jacobian's condition
 * number; 0 where they do not lead to the grasps at once. */
static int mrts_quick_sample(const mrts_tracking *task, const mrts_path *at, const mrts_outcome *failures, double *now,
                             double *dq, double *ddq, double *condition, mrts_scratch *scratch) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS, W = MRTS_SIZE };
    double tips[3 * R], rotations[9 * R], J[W * M], off[3], turned[3], error[W], step[W];
    mrts_factors factors[R];
    for (int iteration = 0; iteration < MRTS_QUICK; ++iteration) {
        double largest = 0, furthest = 0;
        scratch->arg[0] = now;
        scratch->arg[1] = task->geometry;
        scratch->res[0] = tips;
        scratch->res[1] = rotations;
        scratch->res[2] = J;
        if (MRTS_KINEMATICS(scratch->arg, scratch->res, scratch->iw, scratch->w, 0)) return 0;
        for (int robot = 0; robot < R; ++robot) {
            const mrts_arm *arm = MRTS_ARM(task->geometry, robot);
            double gap, turn;
            condition[robot] = 1;
            if (failures[robot].code != MRTS_FOLLOWED) continue;
            mrts_tip_error(arm, at->position, at->rotation, tips + 3 * robot, rotations + 9 * robot, off, turned, &gap,
                           &turn);
            mrts_arm_error(task, arm, off, turned, error);
            condition[robot] = mrts_factor(J + W * W * robot, factors + robot);
            if (!(condition[robot] < MRTS_INFINITY)) return 0;
            if (!(fmax(gap, turn) <= furthest)) furthest = fmax(gap, turn);
            mrts_solve(factors + robot, error, step);
            for (int i = 0; i < W; ++i) {
                now[W * robot + i] += step[i];
                if (!(fabs(step[i]) <= largest)) largest = fabs(step[i]);
            }
        }
        if (!(largest <= task->longest)) return 0;
        if (largest > MRTS_FINE || furthest > task->reached) continue;
        for (int robot = 0; robot < R; ++robot) {
            double velocity[W], change[W], bias[W];
            for (int i = 0; i < W; ++i) dq[W * robot + i] = ddq[W * robot + i] = 0;
            if (failures[robot].code != MRTS_FOLLOWED) continue;
            mrts_tip_rates(task, MRTS_ARM(task->geometry, robot), at->rotation, at->twist, at->acceleration, velocity,
                           change);
            mrts_solve(factors + robot, velocity, dq + W * robot);
            mrts_bias_of_columns(task, J + W * W * robot, dq + W * robot, bias);
            for (int i = 0; i < W; ++i) change[i] -= bias[i];
            mrts_solve(factors + robot, change, ddq + W * robot);
        }
        return 1;
    }
    return 0;
}

#endif

/* What to add to the positions of a joint along a path, from `low` to `high`, to bring them inside its limits by whole turns;
 * 0 where that does not help. */
static double mrts_turns_inside(double low, double high, double lower, double upper, double past) {
    const double turn = MRTS_TURN, down = ceil((high - upper) / turn - past), up = ceil((lower - low) / turn - past);
    double moved = 0;
    if (down > 0 && low - turn * down >= lower - past) moved -= turn * down;
    if (up > 0 && high + turn * up <= upper + past) moved += turn * up;
    return moved;
}

/* Moves positions of one arm at one sample inside their limits where whole turns do it; the first joint that is still past one
 * by more than rounding, -1 if none is. */
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
                           const double *further, double *q, mrts_outcome *outcome, mrts_scratch *scratch) {
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
        if (!mrts_hold_grasps(&task, at->position, at->rotation, reference, now, found, gap, turn, drift, scratch->arg,
                              scratch->res, scratch->iw, scratch->w)) {
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

/* One sample by the rule of tracking.c, from positions predicted by Taylor's polynomial; notes arms that fail there, by what
 * they fail. 0 where that cannot be told. */
static int mrts_sample_by_rule(const mrts_following *rule, const mrts_path *at, const double *reference,
                               const double *taylor, double *q, double *dq, double *ddq, int sample,
                               mrts_outcome *failures, mrts_scratch *scratch) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS };
    double now[M], gap[R], turn[R], drift[R], condition[R], curvature[R];
    for (int i = 0; i < M; ++i) now[i] = taylor[i];
    if (!mrts_hold_grasps(&rule->task, at->position, at->rotation, reference, now, q, gap, turn, drift, scratch->arg,
                          scratch->res, scratch->iw, scratch->w) ||
        !mrts_joint_rates(&rule->task, at->rotation, at->twist, at->acceleration, reference, q, dq, ddq, condition,
                          curvature, scratch->arg, scratch->res, scratch->iw, scratch->w)) {
        return 0;
    }
    for (int robot = 0; robot < R; ++robot) {
        if (failures[robot].code != MRTS_FOLLOWED) continue;
        if (!(fmax(gap[robot], turn[robot]) <= rule->task.reached)) {
            failures[robot] = (mrts_outcome){MRTS_OUT_OF_REACH, robot, sample, 0, {gap[robot], turn[robot]}};
        } else if (!(condition[robot] < rule->condition && drift[robot] <= rule->drift && curvature[robot] > rule->fold)) {
            return 0;
        }
    }
    return 1;
}

/* Follows one variant from its start: q, q', q'' of all samples, and how that ends. An arm that fails is not looked at again;
 * what counts is the first one in order. */
static void mrts_follow_one(const mrts_following *rule, long long samples, const double *time, const mrts_path *path,
                            double *q, double *dq, double *ddq, mrts_outcome *outcome, mrts_scratch *scratch) {
    enum { M = MRTS_JOINTS, R = MRTS_ROBOTS };
    double reference[M], taylor[M], condition[R];
    mrts_outcome failures[R];
    long long even = 0;
    for (int robot = 0; robot < R; ++robot) failures[robot].code = MRTS_FOLLOWED;
    for (int i = 0; i < M; ++i) reference[i] = q[i];
    for (long long n = 0; n < samples && failures[0].code == MRTS_FOLLOWED; ++n) {
        const mrts_path at = {path->position + 3 * n, path->rotation + 9 * n, path->twist + 6 * n, path->acceleration + 6 * n};
        double *qn = q + n * M, *dqn = dq + n * M, *ddqn = ddq + n * M;
        int quick = 0;
        (void)condition; /* of arms that are not redundant */
        if (n == 0) {
            for (int i = 0; i < M; ++i) taylor[i] = qn[i];
        } else {
            const double h = time[n] - time[n - 1];
            even = n > 1 && fabs(time[n - 1] - time[n - 2] - h) <= MRTS_SAME_STEP * h ? even + 1 : 1;
            mrts_predict(qn - M, dqn - M, ddqn - M, h, even, taylor, qn);
        }
#ifndef MRTS_REDUNDANT
        quick = mrts_quick_sample(&rule->task, &at, failures, qn, dqn, ddqn, condition, scratch);
        for (int robot = 0; robot < R; ++robot) quick &= condition[robot] < rule->condition;
#endif
        if (!quick && !mrts_sample_by_rule(rule, &at, reference, taylor, qn, dqn, ddqn, (int)n, failures, scratch)) {
            outcome->code = MRTS_UNSETTLED;
            return;
        }
        for (int robot = 0; robot < R; ++robot) {
            double jump = 0;
            for (int i = MRTS_FIRST(robot); i < MRTS_FIRST(robot + 1); ++i) jump = fmax(jump, fabs(qn[i] - taylor[i]));
            if (failures[robot].code == MRTS_FOLLOWED && jump > rule->jump) {
                failures[robot] = (mrts_outcome){MRTS_LOST, robot, (int)n, 0, {jump, 0}};
            }
        }
    }
    outcome->code = MRTS_FOLLOWED;
    for (int robot = 0; robot < R && outcome->code == MRTS_FOLLOWED; ++robot) *outcome = failures[robot];
    for (int robot = 0; robot < R && outcome->code == MRTS_FOLLOWED; ++robot) {
        mrts_past_limits(rule, samples, robot, q, outcome);
    }
}

/* Follows variants 0 .. count - 1, each of the same number of samples. Arrays are of all variants one after the other; a
 * stride, in reals from one variant to the next, is 0 where they share one. Variants with MRTS_REFUSED are passed over. */
MRTS_EXPORT void mrts_follow_variants(long long count, long long samples, const mrts_following *rule,
                                      const double *const *given, const long long *stride, double *q, double *dq,
                                      double *ddq, mrts_outcome *outcome, const double **arg, double **res, long long *iw,
                                      double *w) {
    enum { M = MRTS_JOINTS, TIME = 0, POSITION, ROTATION, TWIST, ACCELERATION, GEOMETRY, POSTURE, SEED, FURTHER, GIVEN };
    mrts_scratch scratch = {arg, res, iw, w};
    mrts_following here = *rule;
    for (long long v = 0; v < count; ++v) {
        const double *of[GIVEN];
        const long long first = v * samples * M;
        if (outcome[v].code == MRTS_REFUSED) continue;
        for (int i = 0; i < GIVEN; ++i) of[i] = given[i] + v * stride[i];
        const mrts_path path = {of[POSITION], of[ROTATION], of[TWIST], of[ACCELERATION]};
        here.task.geometry = of[GEOMETRY];
        if (mrts_find_start(&here, &path, of[POSTURE], of[SEED], of[FURTHER], q + first, outcome + v, &scratch)) {
            mrts_follow_one(&here, samples, of[TIME], &path, q + first, dq + first, ddq + first, outcome + v, &scratch);
        }
    }
}

/* SPDX-License-Identifier: MIT
 *
 * The speed of a plan at run time; see cell_override.h. */
#include "cell_override.h"
#include "cell_model.h"

enum { JOINTS = CELL_JOINTS, WRENCHES = CELL_WRENCHES, MOST_TICKS = 100000, HALVINGS = 24, MOST_SPEED = 4 };

static cell_real between(cell_real a, cell_real b, cell_real share) { return a + share * (b - a); }
static cell_real within(cell_real a, cell_real low, cell_real high) { return a < low ? low : a > high ? high : a; }

typedef struct {
    const cell_plan_node *here, *next;
    cell_real step, share;
} cell_segment;

static cell_segment segment_of(const cell_plan *plan, const cell_override *state) {
    cell_segment at;
    at.here = plan->nodes + state->node;
    at.next = at.here + 1;
    at.step = at.next->time - at.here->time;
    at.share = at.step > 0 ? state->inside / at.step : 0;
    return at;
}

static cell_real most_at(const cell_segment *at) { return between(at->here->most, at->next->most, at->share); }

/* The least or the largest acceleration at a share of the largest squared speed. */
static cell_real acceleration_at(const cell_segment *at, int side, cell_real share) {
    const cell_real *here = at->here->acceleration[side], *next = at->next->acceleration[side];
    return between(between(here[0], next[0], at->share), between(here[1], next[1], at->share), share);
}

/* Move by some of the plan's time; whether an end is reached. */
static int moved(const cell_plan *plan, cell_override *state, cell_real by) {
    const cell_plan_node *nodes = plan->nodes;
    const int last = plan->count - 2;
    int ends = 0;
    state->inside += by;
    while (state->node < last && state->inside >= nodes[state->node + 1].time - nodes[state->node].time) {
        state->inside -= nodes[state->node + 1].time - nodes[state->node].time;
        ++state->node;
    }
    while (state->node > 0 && state->inside < 0) {
        --state->node;
        state->inside += nodes[state->node + 1].time - nodes[state->node].time;
    }
    if (state->inside < 0) {
        state->inside = 0;
        ends = 1;
    }
    if (state->node == last && state->inside >= nodes[last + 1].time - nodes[last].time) {
        state->inside = nodes[last + 1].time - nodes[last].time;
        ends = 1;
    }
    state->time = nodes[state->node].time + state->inside;
    return ends;
}

/* Go on for dt with the chosen acceleration; the speed does not pass what it was chosen for. */
static void advance(const cell_plan *plan, cell_real dt, cell_override *state) {
    const cell_real before = state->speed;
    cell_real after = before + state->acceleration * dt;
    if (state->finished && state->acceleration == 0) return;
    if ((before - state->aim) * (after - state->aim) <= 0) after = state->aim;
    state->speed = after;
    if (before + after != 0) state->direction = before + after < 0 ? -1 : 1;
    state->finished = 0;
    if (moved(plan, state, (before + after) / 2 * dt)) {
        const int at_start = state->node == 0 && state->inside == 0;
        if (at_start ? after < 0 : after >= 0) {
            state->finished = 1;
            state->speed = state->acceleration = 0;
            state->active = 0;
        }
    }
}

/* The nearer of a pair's two nodes, and of its two speeds. */
static int nearer(const cell_segment *at, int side, cell_real share) {
    const cell_plan_node *node = at->share < (cell_real)0.5 ? at->here : at->next;
    return node->active[2 * side + (share > (cell_real)0.5)];
}

static void choose(const cell_plan *plan, cell_real wanted, cell_real dt, cell_override *state) {
    const cell_segment at = segment_of(plan, state);
    const cell_real most = most_at(&at), fastest = plan->varies ? MRTS_SQRT(most) : most, speed = state->speed;
    const cell_real share = within(speed * speed / most, 0, 1);
    const cell_real low = acceleration_at(&at, CELL_BRAKE, share), high = acceleration_at(&at, CELL_PUSH, share);
    const cell_real aim = within(wanted, plan->backwards ? -fastest : 0, fastest);
    cell_real chosen = (aim - speed) / dt;
    int active = wanted != aim ? at.here->active[4] : 0;
    state->aim = aim;
    if (plan->keeps_rates) {
        /* steps of `change` that end at 0 when the wanted speed is reached */
        const cell_real ahead = between(at.here->rate_ahead, at.next->rate_ahead, at.share) * dt;
        const cell_real left = MRTS_ABS(aim - speed) / dt;
        const cell_real reach = ahead > 0 ? 2 * ahead * left / (MRTS_SQRT(ahead * ahead / 4 + 2 * ahead * left) + ahead / 2) : 0;
        if (MRTS_ABS(chosen) > reach) {
            chosen = chosen < 0 ? -reach : reach;
            active = plan->keeps_rates;
        }
    }
    if (chosen < low) {
        chosen = low;
        active = nearer(&at, CELL_BRAKE, share);
    } else if (chosen > high) {
        chosen = high;
        active = nearer(&at, CELL_PUSH, share);
    }
    if (plan->keeps_rates) {
        const cell_real at_rest = between(at.here->rate[0], at.next->rate[0], at.share);
        const cell_real at_most = between(at.here->rate[1], at.next->rate[1], at.share);
        const cell_real change = within(between(at_rest, at_most, within(MRTS_ABS(speed) / fastest, 0, 1)), 0, at_rest) * dt;
        const cell_real limited = within(chosen, state->acceleration - change, state->acceleration + change);
        if (limited != chosen) active = plan->keeps_rates;
        chosen = limited;
    }
    if (plan->varies) { /* the largest speed where the next tick will be: no faster than that */
        for (int turn = 0; turn < 2; ++turn) {
            cell_override there = *state;
            cell_segment next;
            cell_real cap;
            moved(plan, &there, (speed + chosen * dt / 2) * dt);
            next = segment_of(plan, &there);
            cap = MRTS_SQRT(most_at(&next));
            if (MRTS_ABS(speed + chosen * dt) <= cap) break;
            chosen = ((speed < 0 ? -cap : cap) - speed) / dt;
            state->aim = speed < 0 ? -cap : cap;
            active = next.here->active[4];
        }
        chosen = within(chosen, low, high);
    }
    state->acceleration = chosen;
    state->active = active;
}

static void play(const cell_plan *plan, cell_override *state) {
    const cell_segment at = segment_of(plan, state);
    const cell_plan_node *a = at.here, *b = at.next;
    const cell_real z = at.share, h = at.step, v = state->speed, x = v * v, u = state->acceleration;
    const cell_real zz = z * z, zzz = zz * z, zzzz = zz * zz;
    /* by s: velocities are cubic between nodes, of their values and slopes; positions their integral, and a line that
     * closes what is left; the first factor is of the difference of the velocities */
    const cell_real of_q[3] = {h * (zzz - zzzz / 2 - z / 2), h * h * (zz / 2 - 2 * zzz / 3 + zzzz / 4 - z / 12),
                               h * h * (zzzz / 4 - zzz / 3 + z / 12)};
    const cell_real of_dq[3] = {3 * zz - 2 * zzz, h * (z - 2 * zz + zzz), h * (zzz - zz)};
    const cell_real of_ddq[3] = {6 * (z - zz) / h, 1 - 4 * z + 3 * zz, 3 * zz - 2 * z};
    const cell_real most = most_at(&at), fast = within(x / most, 0, 1);
    const int side = u < 0 ? CELL_BRAKE : CELL_PUSH;
    const cell_real end = acceleration_at(&at, side, fast);
    const cell_real mixed = end != 0 ? within(u / end, 0, 1) : 0;
    const cell_real *const ours = a->accelerate[side][0], *const theirs = b->accelerate[side][0];
    cell_real weight[8];
    cell_real shares[WRENCHES];
#if CELL_MOTORS
    cell_real travel[JOINTS];
#endif
    const cell_real *given[] = {state->q, state->dq, state->ddq, plan->load, shares,
#ifdef CELL_GEOMETRY
                                plan->geometry
#endif
    };
    cell_real *found[] = {state->torque, state->wrench};
    for (int j = 0; j < JOINTS; ++j) {
        const cell_real faster = b->dq[j] - a->dq[j], before = a->ddq[j], after = b->ddq[j];
        const cell_real dq = a->dq[j] + of_dq[0] * faster + of_dq[1] * before + of_dq[2] * after;
        const cell_real ddq = of_ddq[0] * faster + of_ddq[1] * before + of_ddq[2] * after;
        state->q[j] = between(a->q[j], b->q[j], z) + of_q[0] * faster + of_q[1] * before + of_q[2] * after;
        state->dq[j] = dq * v;
#if CELL_MOTORS
        travel[j] = dq;
#endif
        state->ddq[j] = ddq * x + dq * u;
    }
    for (int k = 0; k < 8; ++k) {
        weight[k] = (k & 1 ? z : 1 - z) * (k & 2 ? fast : 1 - fast) * (k & 4 ? mixed : 1 - mixed);
    }
    for (int i = 0; i < WRENCHES; ++i) {
        shares[i] = weight[0] * a->hold[0][i] + weight[1] * b->hold[0][i] + weight[2] * a->hold[1][i] +
                    weight[3] * b->hold[1][i] + weight[4] * ours[i] + weight[5] * theirs[i] +
                    weight[6] * ours[WRENCHES + i] + weight[7] * theirs[WRENCHES + i];
    }
    cell_model_played_torques(given, found);
#if CELL_MOTORS
    for (int j = 0; j < JOINTS; ++j) {
        const cell_real ahead = travel[j] != 0 ? travel[j] : b->q[j] - a->q[j];
        const cell_real way = (cell_real)(((ahead > 0) - (ahead < 0)) * state->direction);
        state->torque[j] += plan->armature[j] * state->ddq[j] + plan->viscous[j] * state->dq[j] + plan->coulomb[j] * way;
    }
#endif
}

cell_status cell_override_start(const cell_plan *plan, cell_real time, cell_real speed, cell_override *state) {
    const cell_plan_node *nodes = plan->nodes;
    cell_override found = {0};
    cell_segment at;
    if (!(time >= 0 && time <= nodes[plan->count - 1].time && MRTS_ABS(speed) <= MOST_SPEED)) return CELL_BAD_ARGUMENT;
    moved(plan, &found, time);
    at = segment_of(plan, &found);
    if (speed * speed > most_at(&at) * (1 + (cell_real)1e-6) || (speed < 0 && !plan->backwards)) return CELL_INFEASIBLE;
    found.speed = found.aim = speed;
    found.direction = speed < 0 ? -1 : 1;
    play(plan, &found);
    *state = found;
    return CELL_OK;
}

cell_status cell_override_step(const cell_plan *plan, cell_real wanted, cell_real dt, cell_override *state) {
    if (!(MRTS_ABS(wanted) < CELL_UNLIMITED && dt > 0 && dt < CELL_UNLIMITED)) return CELL_BAD_ARGUMENT;
    advance(plan, dt, state);
    if (!state->finished || wanted * (state->inside > 0 ? 1 : -1) < 0) choose(plan, wanted, dt, state);
    play(plan, state);
    return CELL_OK;
}

cell_status cell_override_resume(const cell_plan *plan, const cell_real q[CELL_JOINTS], cell_real near,
                                 cell_override *state) {
    cell_override found;
    cell_real best = CELL_UNLIMITED, time = 0;
    for (int k = 0; k + 1 < plan->count; ++k) {
        const cell_plan_node *a = plan->nodes + k, *b = a + 1;
        cell_real length = 0, along = 0, off = 0, share;
        for (int j = 0; j < JOINTS; ++j) {
            length += (b->q[j] - a->q[j]) * (b->q[j] - a->q[j]);
            along += (b->q[j] - a->q[j]) * (q[j] - a->q[j]);
        }
        share = length > 0 ? within(along / length, 0, 1) : 0;
        for (int j = 0; j < JOINTS; ++j) {
            const cell_real by = q[j] - between(a->q[j], b->q[j], share);
            off += by * by;
        }
        if (off < best) {
            best = off;
            time = between(a->time, b->time, share);
        }
    }
    if (!(best < CELL_UNLIMITED) || cell_override_start(plan, time, 0, &found) != CELL_OK) return CELL_BAD_ARGUMENT;
    for (int j = 0; j < JOINTS; ++j) {
        if (!(MRTS_ABS(q[j] - found.q[j]) <= near)) return CELL_INFEASIBLE;
    }
    *state = found;
    return CELL_OK;
}

cell_real cell_override_stop_time(const cell_plan *plan, const cell_override *state, cell_real dt, cell_real *stands) {
    cell_override ahead = *state;
    int ticks = dt > 0 && dt < CELL_UNLIMITED ? 0 : MOST_TICKS;
    while ((ahead.speed != 0 || ahead.acceleration != 0) && ticks < MOST_TICKS) {
        advance(plan, dt, &ahead);
        if (!ahead.finished) choose(plan, 0, dt, &ahead);
        ++ticks;
    }
    if (stands) *stands = ahead.time;
    return ticks < MOST_TICKS ? (cell_real)ticks * dt : CELL_UNLIMITED;
}

cell_real cell_override_speed_for_stop(const cell_plan *plan, const cell_override *state, cell_real seconds, cell_real dt) {
    const cell_segment at = segment_of(plan, state);
    const cell_real way = state->direction < 0 ? (cell_real)-1 : (cell_real)1;
    cell_override tried = *state;
    cell_real low = 0, high = MRTS_SQRT(most_at(&at));
    tried.acceleration = 0;
    for (int turn = 0; turn <= HALVINGS; ++turn) {
        const cell_real speed = turn ? (low + high) / 2 : high;
        tried.speed = tried.aim = way * speed;
        if (cell_override_stop_time(plan, &tried, dt, 0) <= seconds) {
            low = speed;
            if (!turn) break;
        } else {
            high = speed;
        }
    }
    return low;
}

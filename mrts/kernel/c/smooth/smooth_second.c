/* SPDX-License-Identifier: MIT
 *
 * The objective of smooth timing and all second derivatives, by nodes and segments, along x, u and the rows' values.
 */
#include "smooth_program.h"

/* Half the lengths of the segments beside a node: the trapezoidal rule. */
static double mrts_smooth_spacing(const mrts_smooth_program *p, int k) {
    return ((k > 0 ? p->step[k - 1] : 0) + (k < p->nodes - 1 ? p->step[k] : 0)) / 2;
}

MRTS_LOCAL double mrts_smooth_objective(const mrts_smooth_program *p, mrts_smooth_state *state, double *gx, double *gu,
                                        double *gf, double *duration) {
    const int n = p->nodes, r = p->rows;
    double total = 0, effort = 0;
    for (int k = 0; k < n; ++k) state->duration_x[k] = 0;
    for (int k = 0; k < n - 1; ++k) {
        const double root = sqrt(state->x[k]), next = sqrt(state->x[k + 1]), sum = root + next;
        total += 2 * p->step[k] / sum;
        state->duration_x[k] -= p->step[k] / (sum * sum * root);
        state->duration_x[k + 1] -= p->step[k] / (sum * sum * next);
    }
    *duration = total;
    for (int k = 0; k < n; ++k) gx[k] += p->time / state->unit * state->duration_x[k];
    for (int k = 0; p->effort > 0 && p->weight && k < n; ++k) {
        const long long at = (long long)k * r;
        const double root = sqrt(state->x[k]), a = state->root_around[k];
        const double by = p->effort * mrts_smooth_spacing(p, k) / state->unit;
        const double tangent = a + (state->x[k] - a * a) / (2 * a);
        const double *entry = p->entry + (long long)k * p->width;
        double *F = gf + (long long)k * p->free;
        for (int j = 0; j < r; ++j) {
            const double weight = by * p->weight[j], v = state->value[at + j], lift = p->root ? p->root[at + j] : 0;
            if (weight == 0) continue;
            const double along = weight * (2 * v / root + 2 * lift);
            effort += weight * (v * v / root + 2 * lift * v + lift * lift * tangent);
            gx[k] += along * p->square[at + j] + weight * (lift * lift / (2 * a) - v * v / (2 * root * state->x[k]));
            gu[k] += along * p->rate[at + j];
            const double *e = entry + p->place[j];
            double *f = F + p->first[j];
            for (int l = 0; l < p->count[j]; ++l) f[l] += along * e[l];
        }
    }
    double uneven = 0;
    for (int k = 0; k < n - 1; ++k) {
        const double by = p->uneven / (state->unit * p->step[k]), jump = state->u[k + 1] - state->u[k];
        uneven += by * jump * jump;
        gu[k] -= 2 * by * jump;
        gu[k + 1] += 2 * by * jump;
    }
    return p->time / state->unit * total + effort + uneven;
}

/* Of a node: its cones' slots. */
static void mrts_smooth_cone_second(const mrts_smooth_program *p, const mrts_smooth_state *state, const double *weight,
                                    const double *multiplier, int k, double *second) {
    for (int i = 0; i < p->cones; ++i) {
        const long long at = (long long)k * p->cones + i;
        const double *gram = p->gram + 9 * at, *bound = p->bound + 3 * at;
        const double u = state->cone_u[at], x = state->cone_x[at], bend = multiplier[i] / state->cone_root[at];
        const double along_u = u - bound[0], along_x = x - bound[1];
        second[0] += weight[i] * along_x * along_x + bend * (gram[4] - x * x);
        second[1] += weight[i] * along_x * along_u + bend * (gram[1] - x * u);
        second[2] += weight[i] * along_u * along_u + bend * (gram[0] - u * u);
    }
}

/* Of a node: its slots, the effort, and the bend of what replaces roots. */
static void mrts_smooth_node_second(const mrts_smooth_program *p, mrts_smooth_state *state, const double *weight,
                                    const double *multiplier, int k) {
    const int r = p->rows, slots = mrts_smooth_slots(p);
    const long long at = (long long)k * r;
    const double *above = weight + (long long)k * slots, *below = above + r;
    double *along = state->row_weight + at, *cross = state->row_cross + at, second = 0;
    for (int j = 0; j < r; ++j) {
        const double up = above[j], down = below[j];
        const double up_x = state->above_x[at + j], down_x = state->below_x[at + j];
        along[j] = up + down;
        cross[j] = up * up_x + down * down_x;
        second += up * up_x * up_x + down * down_x * down_x;
    }
    const double x = state->x[k], root = sqrt(x);
    if (p->effort > 0 && p->weight) {
        const double by = p->effort * mrts_smooth_spacing(p, k) / state->unit;
        for (int j = 0; j < r; ++j) {
            const double share = by * p->weight[j] / root, square = p->square[at + j], v = state->value[at + j] / x;
            along[j] += 2 * share;
            cross[j] += share * (2 * square - v);
            second += share * (2 * square * square - 2 * square * v + 0.75 * v * v);
        }
    }
    if (p->root) {
        mrts_smooth_presses(p, state, multiplier, k);
        for (int j = 0; j < r; ++j) {
            const double by = p->root[at + j];
            second += (by < 0 ? -by * state->pressing[j] : by * state->holding[j]) / (4 * x * root);
        }
    }
    state->node_second[3 * k] = second;
    state->node_second[3 * k + 1] = state->node_second[3 * k + 2] = 0;
    mrts_smooth_cone_second(p, state, below + r, multiplier + (long long)k * slots + 2 * r, k,
                            state->node_second + 3 * k);
}

/* Of a segment: the duration, weighed by `time`. */
static void mrts_smooth_time_second(const mrts_smooth_program *p, mrts_smooth_state *state, double time, int k) {
    const double x = state->x[k], next = state->x[k + 1], root = sqrt(x), root1 = sqrt(next), sum = root + root1;
    const double by = time * p->step[k] / (sum * sum);
    state->node_second[3 * k] += by * (1 / (sum * x) + 1 / (2 * x * root));
    state->node_second[3 * k + 3] += by * (1 / (sum * next) + 1 / (2 * next * root1));
    state->segment_second[4 * k] += by / (sum * root * root1);
}

/* Of a segment: its changes. */
static void mrts_smooth_change_second(const mrts_smooth_program *p, mrts_smooth_state *state, const double *weights,
                                      int k) {
    const int r = p->rows, c = p->changes;
    const long long at = (long long)k * r, of = (long long)k * c;
    const double time0 = state->time_x[k], time1 = state->time_x1[k];
    double second0 = 0, second1 = 0, mixed = 0;
    for (int i = 0; i < c; ++i) {
        const int j = p->limited[i];
        const double by = state->by_time[k] * state->by_change[i];
        const double up = weights[i], down = weights[c + i];
        const double up0 = by * state->below_x[at + j] + time0, up1 = by * state->above_x[at + r + j] - time1;
        const double down0 = by * state->above_x[at + j] - time0, down1 = by * state->below_x[at + r + j] + time1;
        const double weight = by * by * (up + down);
        const double before = by * (up * up0 + down * down0), after = by * (up * up1 + down * down1);
        state->change_weight[of + i] = weight;
        state->change_before[of + i] = before;
        state->change_after[of + i] = after;
        state->row_weight[at + j] += weight;
        state->row_weight[at + r + j] += weight;
        state->row_cross[at + j] += before;
        state->row_cross[at + r + j] += after;
        second0 += up * up0 * up0 + down * down0 * down0;
        second1 += up * up1 * up1 + down * down1 * down1;
        mixed -= up * up0 * up1 + down * down0 * down1;
    }
    state->node_second[3 * k] += second0;
    state->node_second[3 * k + 3] += second1;
    state->segment_second[4 * k] += mixed;
}

/* Of a segment: its jerks. */
static void mrts_smooth_jerk_second(const mrts_smooth_program *p, mrts_smooth_state *state, const double *weights,
                                    int k) {
    const int J = p->jerks;
    double *segment = state->segment_second + 4 * k;
    for (int e = 0; e < 2; ++e, weights += 2 * J) {
        const double *q1 = p->q1 + (long long)(k + e) * J, *q2 = p->q2 + (long long)(k + e) * J;
        const double *q3 = p->q3 + (2LL * k + e) * J;
        const double share = 1 / (2 * state->around[k + e]), root = state->root_around[k + e], by_step = 1 / p->step[k];
        double xx = 0, x_here = 0, x_there = 0, here_here = 0, here_there = 0, there_there = 0;
        for (int i = 0; i < J; ++i) { /* `here` is the u of end e */
            const double by = root / p->jerk[i], slope = e ? by * q1[i] * by_step : -by * q1[i] * by_step;
            const double here = slope + 3 * by * q2[i], there = -slope;
            const double up = weights[i], down = weights[J + i];
            const double up_x = by * q3[i] + share, down_x = by * q3[i] - share;
            const double weight = up + down, cross = up * up_x + down * down_x;
            xx += up * up_x * up_x + down * down_x * down_x;
            x_here += cross * here;
            x_there += cross * there;
            here_here += weight * here * here;
            here_there += weight * here * there;
            there_there += weight * there * there;
        }
        double *at = state->node_second + 3 * (k + e), *other = state->node_second + 3 * (k + 1 - e);
        at[0] += xx;
        at[1] += x_here;
        at[2] += here_here;
        other[2] += there_there;
        segment[e ? 2 : 1] += x_there;
        segment[3] += here_there;
    }
}

MRTS_LOCAL void mrts_smooth_second(const mrts_smooth_program *p, mrts_smooth_state *state, const double *weight,
                                   const double *multiplier) {
    const int n = p->nodes, slots = mrts_smooth_slots(p);
    double time = p->time / state->unit;
    if (p->longest < MRTS_INFINITY) time += multiplier[(long long)n * slots] / p->longest;
    for (int k = 0; k < n; ++k) mrts_smooth_node_second(p, state, weight, multiplier, k);
    for (int k = 0; k < n - 1; ++k) {
        const long long at = (long long)k * slots + mrts_smooth_node_slots(p);
        for (int i = 0; i < 4; ++i) state->segment_second[4 * k + i] = 0;
        mrts_smooth_time_second(p, state, time, k);
        const double even = 2 * p->uneven / (state->unit * p->step[k]);
        state->node_second[3 * k + 2] += even;
        state->node_second[3 * k + 5] += even;
        state->segment_second[4 * k + 3] -= even;
        mrts_smooth_change_second(p, state, weight + at, k);
        mrts_smooth_jerk_second(p, state, weight + at + 2 * p->changes, k);
    }
}

/* SPDX-License-Identifier: MIT
 *
 * Values of the constraints of smooth timing at a profile, what a step changes in them, and what multipliers pull at.
 */
#include "smooth_program.h"

#define MRTS_SMOOTH_APEX 1e-4 /* of a limit: cones are rounded there, and narrower by half its square at most */

MRTS_LOCAL long long mrts_smooth_state_size(const mrts_smooth_program *p) {
    const long long n = p->nodes, r = p->rows;
    return 21 * n + n * p->free + 7 * n * r + 3 * n * (p->cones + p->changes) + p->changes + 2 * r;
}

static double *mrts_smooth_take(double **memory, long long size) {
    double *taken = *memory;
    *memory += size;
    return taken;
}

MRTS_LOCAL void mrts_smooth_state_in(const mrts_smooth_program *p, double *memory, mrts_smooth_state *state) {
    const long long n = p->nodes, r = p->rows, cones = n * p->cones, c = p->changes;
    double **at = &memory;
    state->x = mrts_smooth_take(at, n);
    state->u = mrts_smooth_take(at, n);
    state->free = mrts_smooth_take(at, n * p->free);
    state->control = mrts_smooth_take(at, n + 1);
    state->near = mrts_smooth_take(at, n);
    state->far = mrts_smooth_take(at, n);
    state->slope = mrts_smooth_take(at, n);
    state->around = mrts_smooth_take(at, n);
    state->root_around = mrts_smooth_take(at, n);
    state->by_time = mrts_smooth_take(at, n - 1);
    state->time_x = mrts_smooth_take(at, n);
    state->time_x1 = mrts_smooth_take(at, n);
    state->by_change = mrts_smooth_take(at, c);
    state->value = mrts_smooth_take(at, n * r);
    state->above = mrts_smooth_take(at, n * r);
    state->below = mrts_smooth_take(at, n * r);
    state->above_x = mrts_smooth_take(at, n * r);
    state->below_x = mrts_smooth_take(at, n * r);
    state->cone_u = mrts_smooth_take(at, cones);
    state->cone_x = mrts_smooth_take(at, cones);
    state->cone_root = mrts_smooth_take(at, cones);
    state->duration_x = mrts_smooth_take(at, n);
    state->row_weight = mrts_smooth_take(at, n * r);
    state->row_cross = mrts_smooth_take(at, n * r);
    state->change_weight = mrts_smooth_take(at, n * c);
    state->change_before = mrts_smooth_take(at, n * c);
    state->change_after = mrts_smooth_take(at, n * c);
    state->node_second = mrts_smooth_take(at, 3 * n);
    state->segment_second = mrts_smooth_take(at, 4 * n);
    state->pressing = mrts_smooth_take(at, r);
    state->holding = mrts_smooth_take(at, r);
    state->unit = 1;
}

MRTS_LOCAL void mrts_smooth_tangents(const mrts_smooth_program *p, mrts_smooth_state *state, const double *around) {
    for (int k = 0; k < p->nodes; ++k) {
        state->around[k] = around[k];
        state->root_around[k] = sqrt(around[k]);
    }
    for (int k = 0; k < p->nodes - 1; ++k) {
        const double sum = state->root_around[k] + state->root_around[k + 1];
        state->by_time[k] = sum / (2 * p->step[k]);
        state->time_x[k] = -1 / (2 * sum * state->root_around[k]);
        state->time_x1[k] = -1 / (2 * sum * state->root_around[k + 1]);
    }
}

MRTS_LOCAL void mrts_smooth_start(const mrts_smooth_program *p, mrts_smooth_state *state) {
    const int n = p->nodes;
    const double *around = state->around;
    for (int k = 0; k < n; ++k) {
        const double before = k > 0 ? p->step[k - 1] : 0, after = k < n - 1 ? p->step[k] : 0;
        state->slope[k] = 1 / (before + after);
        state->near[k] = after / (before + after); /* 0 and 1 at the ends */
        state->far[k] = before / (before + after);
    }
    for (int i = 0; i < p->changes; ++i) state->by_change[i] = 1 / p->change[i];
    if (p->timed) return;
    state->control[0] = p->given_start ? state->x[0] : around[0];
    state->control[n] = p->given_end ? state->x[n - 1] : around[n - 1];
    for (int k = 1; k < n; ++k) state->control[k] = (around[k - 1] + around[k]) / 2;
    mrts_smooth_profile(p, state);
}

MRTS_LOCAL void mrts_smooth_profile(const mrts_smooth_program *p, mrts_smooth_state *state) {
    const double *c = state->control;
    for (int k = 0; k < p->nodes; ++k) {
        state->x[k] = state->near[k] * c[k] + state->far[k] * c[k + 1];
        state->u[k] = state->slope[k] * (c[k + 1] - c[k]);
    }
}

/* Rows of one node: values without and with their roots replaced, from above and from below. */
static void mrts_smooth_node(const mrts_smooth_program *p, mrts_smooth_state *state, int k) {
    const int r = p->rows;
    const long long at = (long long)k * r;
    const double x = state->x[k], u = state->u[k];
    const double *F = state->free + (long long)k * p->free, *entry = p->entry + (long long)k * p->width;
    const double *square = p->square + at, *rate = p->rate + at, *offset = p->offset + at;
    double *value = state->value + at, *above = state->above + at, *below = state->below + at;
    for (int j = 0; j < r; ++j) {
        double sum = square[j] * x + rate[j] * u + offset[j];
        const double *f = F + p->first[j], *e = entry + p->place[j];
        for (int l = 0; l < p->count[j]; ++l) sum += e[l] * f[l];
        value[j] = sum;
    }
    double *above_x = state->above_x + at, *below_x = state->below_x + at;
    if (!p->root) {
        for (int j = 0; j < r; ++j) {
            above[j] = below[j] = value[j];
            above_x[j] = below_x[j] = square[j];
        }
        return;
    }
    const double root = sqrt(x), a = state->root_around[k];
    const double exact_x = 1 / (2 * root), tangent_x = 1 / (2 * a), tangent = a + (x - a * a) * tangent_x;
    for (int j = 0; j < r; ++j) {
        const double by = p->root[at + j];
        above[j] = value[j] + by * (by > 0 ? tangent : root);
        below[j] = value[j] + by * (by > 0 ? root : tangent);
        above_x[j] = square[j] + by * (by > 0 ? tangent_x : exact_x);
        below_x[j] = square[j] + by * (by > 0 ? exact_x : tangent_x);
    }
}

/* Cones of one node. */
static void mrts_smooth_cones(const mrts_smooth_program *p, mrts_smooth_state *state, int k, double *g) {
    const double u = state->u[k], x = state->x[k];
    for (int i = 0; i < p->cones; ++i) {
        const long long at = (long long)k * p->cones + i;
        const double *gram = p->gram + 9 * at, *bound = p->bound + 3 * at;
        const double along_u = gram[0] * u + gram[1] * x + gram[2], along_x = gram[3] * u + gram[4] * x + gram[5];
        const double square = along_u * u + along_x * x + gram[6] * u + gram[7] * x + gram[8];
        const double root = sqrt((square > 0 ? square : 0) + MRTS_SMOOTH_APEX * MRTS_SMOOTH_APEX);
        state->cone_u[at] = along_u / root;
        state->cone_x[at] = along_x / root;
        state->cone_root[at] = root;
        g[i] = root - bound[0] * u - bound[1] * x - bound[2];
    }
}

/* Of joint i at end e of a segment: q1 (u' - u) / step + 3 q2 u_e + q3 x_e, in units of its limit at `around`. */
static double mrts_smooth_jerk(const mrts_smooth_program *p, const mrts_smooth_state *state, int k, int e, int i,
                               double slope, double u, double x) {
    const long long node = (long long)(k + e) * p->jerks + i, segment = (2LL * k + e) * p->jerks + i;
    return (p->q1[node] * slope + 3 * p->q2[node] * u + p->q3[segment] * x) * state->root_around[k + e] / p->jerk[i];
}

/* The slots of a segment; with `shift` 1 values g, with 0 what they change where x, u, above and below are changes. */
static void mrts_smooth_segment(const mrts_smooth_program *p, const mrts_smooth_state *state, int k, int shift,
                                const double *x, const double *u, const double *above, const double *below, double *g) {
    const int r = p->rows, c = p->changes, J = p->jerks;
    const double *a = state->around;
    const double dx0 = x[k] - shift * a[k], dx1 = x[k + 1] - shift * a[k + 1];
    const double time = shift + state->time_x[k] * dx0 + state->time_x1[k] * dx1;
    const double *above0 = above + (long long)k * r, *below0 = below + (long long)k * r;
    const double *above1 = above0 + r, *below1 = below0 + r;
    for (int i = 0; i < c; ++i) {
        const int j = p->limited[i];
        const double by = state->by_time[k] * state->by_change[i];
        g[i] = by * (above1[j] - below0[j]) - time;
        g[c + i] = by * (above0[j] - below1[j]) - time;
    }
    g += 2 * c;
    const double slope = (u[k + 1] - u[k]) / p->step[k];
    for (int e = 0; e < 2; ++e, g += 2 * J) {
        const double limit = shift - (e ? dx1 : dx0) / (2 * a[k + e]);
        for (int i = 0; i < J; ++i) {
            const double jerk = mrts_smooth_jerk(p, state, k, e, i, slope, u[k + e], x[k + e]);
            g[i] = jerk - limit;
            g[J + i] = -jerk - limit;
        }
    }
}

MRTS_LOCAL void mrts_smooth_values(const mrts_smooth_program *p, mrts_smooth_state *state, double *g) {
    const int n = p->nodes, r = p->rows, slots = mrts_smooth_slots(p);
    const int segment = mrts_smooth_node_slots(p);
    for (int k = 0; k < n; ++k) {
        mrts_smooth_node(p, state, k);
        mrts_smooth_cones(p, state, k, g + (long long)k * slots + 2 * r);
        const long long at = (long long)k * r;
        double *here = g + (long long)k * slots;
        for (int j = 0; j < r; ++j) {
            here[j] = state->above[at + j] - p->upper[at + j];
            here[r + j] = p->lower[at + j] - state->below[at + j];
        }
    }
    for (int k = 0; k < n - 1; ++k) {
        mrts_smooth_segment(p, state, k, 1, state->x, state->u, state->above, state->below,
                            g + (long long)k * slots + segment);
    }
}

MRTS_LOCAL void mrts_smooth_moved(const mrts_smooth_program *p, const mrts_smooth_state *state, const double *dx,
                                  const double *du, const double *df, double *dg) {
    const int n = p->nodes, r = p->rows, slots = mrts_smooth_slots(p);
    double *above = state->row_weight, *below = state->row_cross; /* their second derivatives have been used */
    for (int k = 0; k < n; ++k) {
        const long long at = (long long)k * r;
        const double *F = df + (long long)k * p->free, *entry = p->entry + (long long)k * p->width;
        double *here = dg + (long long)k * slots;
        for (int j = 0; j < r; ++j) {
            double sum = p->rate[at + j] * du[k];
            const double *f = F + p->first[j], *e = entry + p->place[j];
            for (int l = 0; l < p->count[j]; ++l) sum += e[l] * f[l];
            above[at + j] = here[j] = sum + state->above_x[at + j] * dx[k];
            below[at + j] = sum + state->below_x[at + j] * dx[k];
            here[r + j] = -below[at + j];
        }
        for (int i = 0; i < p->cones; ++i) {
            const long long cone = (long long)k * p->cones + i;
            here[2 * r + i] = (state->cone_u[cone] - p->bound[3 * cone]) * du[k] +
                              (state->cone_x[cone] - p->bound[3 * cone + 1]) * dx[k];
        }
    }
    for (int k = 0; k < n - 1; ++k) {
        mrts_smooth_segment(p, state, k, 0, dx, du, above, below, dg + (long long)k * slots + mrts_smooth_node_slots(p));
    }
    if (p->longest < MRTS_INFINITY) dg[(long long)n * slots] = mrts_dot(n, state->duration_x, dx) / p->longest;
}

MRTS_LOCAL void mrts_smooth_presses(const mrts_smooth_program *p, mrts_smooth_state *state, const double *y, int k) {
    const int n = p->nodes, r = p->rows, c = p->changes, slots = mrts_smooth_slots(p);
    const double *here = y + (long long)k * slots;
    for (int j = 0; j < r; ++j) {
        state->pressing[j] = here[j];
        state->holding[j] = here[r + j];
    }
    for (int s = k > 0 ? k - 1 : 0; s <= k && s < n - 1; ++s) {
        const double *up = y + (long long)s * slots + mrts_smooth_node_slots(p), *down = up + c;
        const double *pressing = s < k ? up : down, *holding = s < k ? down : up;
        for (int i = 0; i < c; ++i) {
            const double by = state->by_time[s] * state->by_change[i];
            state->pressing[p->limited[i]] += by * pressing[i];
            state->holding[p->limited[i]] += by * holding[i];
        }
    }
}

MRTS_LOCAL void mrts_smooth_pulled(const mrts_smooth_program *p, mrts_smooth_state *state, const double *y, double *gx,
                                   double *gu, double *gf) {
    const int n = p->nodes, r = p->rows, c = p->changes, J = p->jerks, slots = mrts_smooth_slots(p);
    for (int k = 0; k < n; ++k) {
        const long long at = (long long)k * r;
        const double *entry = p->entry + (long long)k * p->width;
        double *F = gf + (long long)k * p->free, along_x = 0, along_u = 0;
        mrts_smooth_presses(p, state, y, k);
        for (int j = 0; j < r; ++j) {
            const double up = state->pressing[j], down = state->holding[j], both = up - down;
            along_x += up * state->above_x[at + j] - down * state->below_x[at + j];
            along_u += both * p->rate[at + j];
            const double *e = entry + p->place[j];
            double *f = F + p->first[j];
            for (int l = 0; l < p->count[j]; ++l) f[l] += both * e[l];
        }
        for (int i = 0; i < p->cones; ++i) {
            const long long cone = (long long)k * p->cones + i;
            const double by = y[(long long)k * slots + 2 * r + i];
            along_u += by * (state->cone_u[cone] - p->bound[3 * cone]);
            along_x += by * (state->cone_x[cone] - p->bound[3 * cone + 1]);
        }
        gx[k] += along_x;
        gu[k] += along_u;
    }
    for (int k = 0; k < n - 1; ++k) {
        const double *here = y + (long long)k * slots + mrts_smooth_node_slots(p);
        double time = 0, slope = 0;
        for (int i = 0; i < 2 * c; ++i) time += here[i];
        gx[k] -= time * state->time_x[k];
        gx[k + 1] -= time * state->time_x1[k];
        here += 2 * c;
        for (int e = 0; e < 2; ++e, here += 2 * J) {
            const double *q1 = p->q1 + (long long)(k + e) * J, *q2 = p->q2 + (long long)(k + e) * J;
            const double *q3 = p->q3 + (2LL * k + e) * J;
            const double root = state->root_around[k + e], share = 1 / (2 * state->around[k + e]);
            for (int i = 0; i < J; ++i) {
                const double both = (here[i] - here[J + i]) * root / p->jerk[i];
                slope += both * q1[i];
                gu[k + e] += both * 3 * q2[i];
                gx[k + e] += both * q3[i] + (here[i] + here[J + i]) * share;
            }
        }
        gu[k] -= slope / p->step[k];
        gu[k + 1] += slope / p->step[k];
    }
    if (p->longest < MRTS_INFINITY) {
        const double by = y[(long long)n * slots] / p->longest;
        for (int k = 0; k < n; ++k) gx[k] += by * state->duration_x[k];
    }
}

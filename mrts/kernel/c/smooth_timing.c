/* SPDX-License-Identifier: MIT
 *
 * The fastest speed along a path with n nodes whose rows, changes of rows and jerks are limited: a convex program.
 *
 * x is the squared speed, u half its slope along the path, linear between nodes, F free unknowns at each node. Row j of
 * node k has the value v = square x + rate u + root sqrt(x) + free F + offset, and
 *
 *     lower <= v_k <= upper                                          at every node
 *     sqrt(z' gram z) <= bound' z with z = (u, x, 1)                 at every node, of each cone
 *     |v_(k+1) - v_k| <= change Dt_k                                 on every segment
 *     |q1 (u_(k+1) - u_k) / step + 3 q2 u + q3 x| <= jerk / sqrt(x)  at both ends of every segment
 *
 * with Dt_k = 2 step / (sqrt(x_k) + sqrt(x_(k+1))). What is not convex is replaced by what is stricter and touches it
 * at the profile `around`: Dt and 1 / sqrt(x) by their tangents, root sqrt(x) by its own where it presses towards a limit.
 * The least of time * duration + effort * sum of spacing weight v^2 / sqrt(x) + uneven * sum of (u_(k+1) - u_k)^2 / step
 * is looked for. The last of F may be a share s by which sides of rows move outward: v + low s and v - high s then stand
 * for v in the first line.
 *
 * Each one-sided constraint has a slot: g <= 0 in units of its limit, a slack s and a multiplier, which is 0 where there
 * is no limit.
 * Node k has the slots [rows above, rows below, cones, changes above, changes below, jerks at the start of its segment
 * above, below, at its end above, below]; the last two slots of all are those of the duration and of the share. */
#include "lanes/lane_types.h"

typedef struct {
    int nodes;       /* n >= 2 */
    int rows;        /* r of a node, a multiple of MRTS_LANES; those whose change is limited come first */
    int free;        /* f of a node */
    int cones;       /* of a node */
    int changes;     /* rows whose change is limited */
    int jerks;       /* joints whose jerk is limited */
    int timed;       /* x and u are given: F alone is looked for */
    int again;       /* `work` ends with the iterate of a program that is near: start from there */
    int moving;      /* tangents are laid anew in each iteration, until it is near its end */
    int given_start; /* x at the first node is given */
    int given_end;
    int held_start; /* F at the first node is given */
    int held_end;
    const int *first; /* column of F that MRTS_LANES rows begin with, (r / MRTS_LANES) */
    const int *count; /* columns that they have, likewise */
    double time;
    double effort;
    double longest;      /* of the duration, MRTS_INFINITY where there is none */
    double uneven;       /* weight of the sum of (u_(k+1) - u_k)^2 / step, which leaves no u to jump to and fro for nothing */
    double relaxed;      /* weight of a share by which all limits of changes and jerks are relaxed; 0 relaxes none, and
                            where it is not 0 there is no longest duration */
    const double *step;   /* (n - 1) */
    const double *square; /* (n, r), as rate, root, offset, lower, upper */
    const double *rate;
    const double *root; /* null where all are 0 */
    const double *offset;
    const double *entry; /* coefficients of F, (n, f, r) */
    const double *lower;
    const double *upper;
    const double *low;    /* (n, r), as high; null where the last of F is no share */
    const double *high;
    const double *gram;   /* (n, cones, 3, 3), symmetric */
    const double *bound;  /* (n, cones, 3), of which the last is infinite where there is no limit */
    const double *change; /* (changes) */
    const double *weight; /* (r), null where all are 0 */
    const double *q1;     /* (n, jerks) */
    const double *q2;     /* (n, jerks) */
    const double *q3;     /* (n - 1, 2, jerks) */
    const double *jerk;   /* (jerks) */
    const double *around; /* x > 0 where tangents are laid, (n) */
} mrts_smooth_program;

/* A profile and what belongs to it, and the iterates and their steps, in the caller's memory. Slots are those of all nodes,
 * then those of the duration and of the share. */
typedef struct {
    double *x, *u, *free;     /* (n), (n), (n, f) */
    double *control;          /* x is a spline: x_k = near_k control_k + far_k control_(k+1), (n + 1) */
    double *near, *far;       /* (n) */
    double *slope;            /* u_k = slope_k (control_(k+1) - control_k), (n) */
    double *around;           /* where tangents are laid, (n) */
    double *root_around;      /* (n) */
    double *by_time;          /* 1 / Dt at `around`, (n - 1) */
    double *time_x, *time_x1; /* slopes of the tangent of Dt / Dt_around along x_k, x_(k+1), (n - 1) */
    double *by_change;        /* 1 / change, (changes) */
    double *value;            /* v without its root, (n, r) */
    double *above, *below;    /* convex above v, concave below v, equal to v at `around`, (n, r) */
    double *above_x, *below_x; /* their slopes along x, (n, r) */
    double *cone_u, *cone_x;  /* slopes of the cones' left sides, (n, cones) */
    double *cone_root;        /* their left sides, (n, cones) */
    double *duration_x;       /* slopes of the duration, (n) */
    double *row_weight, *row_cross; /* of a node's second derivatives along (value, value) and (x, value), (n, r) */
    double *change_weight, *change_before, *change_after; /* likewise between two nodes, (n - 1, changes) */
    double *node_second;      /* along (x, x), (x, u), (u, u), (n, 3) */
    double *row_share;        /* of a node along (value, s), (n, r) */
    double *share_second;     /* along (x, s), (u, s), (s, s), (n, 3) */
    double *segment_second;   /* along (x, x'), (x, u'), (u, x'), (u, u'), (n - 1, 4) */
    double *pressing, *holding; /* of a node: multipliers above and below, (r) */
    double *column[4];        /* weights of rows, (r) */
    double unit;              /* of the objective */
    long long slots;           /* how many, a multiple of MRTS_LANES */
    int present;               /* slots with a limit */
    double *s, *y;             /* slacks and multipliers, infinity and 0 where there is no limit */
    double *by_s, *weight;     /* 1 / s, 0 where there is no limit, and y / s */
    double *missed, *ds, *dy;  /* g + s, and the steps */
    double *target;            /* multipliers that the right side is made of */
    double *gx, *gu, *gf;      /* the gradient of the objective */
    double *px, *pu, *pf;      /* another one, or a step */
    double *b, *w;             /* unknowns: a right side and its step; the factor's answer to what borders the matrix */
    double *border;            /* unknowns: how the share pulls at them, or the duration */
    double share;              /* by which limits of changes and jerks are relaxed */
    double share_step;         /* of it */
    double pull;               /* the second derivative along the border that the factor leaves */
    double *factor, *fronts;
    double slack_reach;        /* the longest parts of a step that leave slacks, multipliers and x no less than 0 */
    double dual_reach, x_reach;
    double *kept;              /* an iterate far from the limits: its s, y, F, control points and unit */
} mrts_smooth_state;

static inline int mrts_lanes_whole(int count) { return (count + MRTS_LANES - 1) / MRTS_LANES * MRTS_LANES; }

static inline int mrts_smooth_node_slots(const mrts_smooth_program *p) { return 2 * p->rows + p->cones; }
static inline int mrts_smooth_slots(const mrts_smooth_program *p) {
    return mrts_smooth_node_slots(p) + 2 * (p->changes + 2 * p->jerks);
}

#define MRTS_SMOOTH_APEX 1e-4 /* of a limit: cones are rounded there, and narrower by half its square at most */

static void mrts_smooth_tangents(const mrts_smooth_program *p, mrts_smooth_state *state, const double *around) {
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

static void mrts_smooth_profile(const mrts_smooth_program *p, mrts_smooth_state *state) {
    const double *c = state->control;
    for (int k = 0; k < p->nodes; ++k) {
        state->x[k] = state->near[k] * c[k] + state->far[k] * c[k + 1];
        state->u[k] = state->slope[k] * (c[k + 1] - c[k]);
    }
}

/* Starts where tangents are laid; the state holds what of x is given. */
static void mrts_smooth_start(const mrts_smooth_program *p, mrts_smooth_state *state) {
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

static inline const double *mrts_smooth_entry(const mrts_smooth_program *p, int k) {
    return p->entry + (long long)k * p->free * p->rows;
}

/* What F moves MRTS_LANES rows of node k by, the first of which is j. */
static inline mrts_lanes mrts_smooth_moved_by(const mrts_smooth_program *p, int k, int j, const double *F) {
    const int first = p->first[j / MRTS_LANES], count = p->count[j / MRTS_LANES];
    const double *entry = mrts_smooth_entry(p, k) + j;
    mrts_lanes sum = {0};
    MRTS_UNROLL
    for (int l = first; l < first + count; ++l) sum += F[l] * *mrts_lanes_at(entry, l * p->rows);
    return sum;
}

/* From row j, where rows begin that have other columns of F than those, or `end`. */
static inline int mrts_smooth_alike(const mrts_smooth_program *p, int j, int end) {
    const int *first = p->first + j / MRTS_LANES, *count = p->count + j / MRTS_LANES;
    int next = 1;
    while (j + next * MRTS_LANES < end && first[next] == *first && count[next] == *count) ++next;
    return j + next * MRTS_LANES;
}

static inline double mrts_smooth_product(int from, int to, const double *a, const double *b) {
    mrts_lanes sum = {0};
    for (int j = from; j < to; j += MRTS_LANES) sum += *mrts_lanes_at(a, j) * *mrts_lanes_at(b, j);
    return mrts_lane_sum(sum);
}

/* Adds the sum of `weight` times the coefficients of F over some rows of node k to every `stride`th of `sums`. */
static void mrts_smooth_add_rows(const mrts_smooth_program *p, int k, int rows, const double *weight, int stride,
                                 double *sums) {
    const double *entry = mrts_smooth_entry(p, k);
    for (int from = 0, to; from < rows; from = to) {
        to = mrts_smooth_alike(p, from, rows);
        const int first = p->first[from / MRTS_LANES], count = p->count[from / MRTS_LANES];
        for (int l = first; l < first + count; ++l) {
            sums[l * stride] += mrts_smooth_product(from, to, weight, entry + l * p->rows);
        }
    }
}

/* Rows of one node: values without and with their roots replaced, from above and from below. */
static void mrts_smooth_node(const mrts_smooth_program *p, mrts_smooth_state *state, int k) {
    const int r = p->rows;
    const long long at = (long long)k * r;
    const double x = state->x[k], u = state->u[k];
    const double *F = state->free + (long long)k * p->free, *square = p->square + at;
    double *value = state->value + at, *above = state->above + at, *below = state->below + at;
    double *above_x = state->above_x + at, *below_x = state->below_x + at;
    for (int j = 0; j < r; j += MRTS_LANES) {
        const mrts_lanes its = *mrts_lanes_at(square, j) * x + *mrts_lanes_at(p->rate, at + j) * u +
                               *mrts_lanes_at(p->offset, at + j) + mrts_smooth_moved_by(p, k, j, F);
        *mrts_lanes_at(value, j) = *mrts_lanes_at(above, j) = *mrts_lanes_at(below, j) = its;
        *mrts_lanes_at(above_x, j) = *mrts_lanes_at(below_x, j) = *mrts_lanes_at(square, j);
    }
    if (!p->root) return;
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
        const double by = state->by_time[k] * state->by_change[i];
        g[i] = by * (above1[i] - below0[i]) - time;
        g[c + i] = by * (above0[i] - below1[i]) - time;
    }
    g += 2 * c;
    const double slope = (u[k + 1] - u[k]) / p->step[k];
    for (int e = 0; e < 2; ++e, g += 2 * J) {
        const double limit = shift - (e ? dx1 : dx0) / (2 * a[k + e]);
        for (int i = 0; i < J; ++i) {
            const long long node = (long long)(k + e) * J + i, segment = (2LL * k + e) * J + i;
            const double jerk = (p->q1[node] * slope + 3 * p->q2[node] * u[k + e] + p->q3[segment] * x[k + e]) *
                                state->root_around[k + e] / p->jerk[i];
            g[i] = jerk - limit;
            g[J + i] = -jerk - limit;
        }
    }
}

/* Takes what a share, or its change, leaves to the rows of node k out of their slots. */
static void mrts_smooth_shared(const mrts_smooth_program *p, int k, const double *free, double *slots) {
    const double s = free[(long long)(k + 1) * p->free - 1];
    for (int j = 0; j < p->rows; ++j) {
        slots[j] -= p->high[(long long)k * p->rows + j] * s;
        slots[p->rows + j] -= p->low[(long long)k * p->rows + j] * s;
    }
}

/* g of every slot, and what of the rows goes into it. */
static void mrts_smooth_values(const mrts_smooth_program *p, mrts_smooth_state *state) {
    const int n = p->nodes, r = p->rows, slots = mrts_smooth_slots(p), segment = mrts_smooth_node_slots(p);
    double *g = state->missed;
    for (int k = 0; k < n; ++k) {
        mrts_smooth_node(p, state, k);
        mrts_smooth_cones(p, state, k, g + (long long)k * slots + 2 * r);
        const long long at = (long long)k * r;
        double *here = g + (long long)k * slots;
        for (int j = 0; j < r; j += MRTS_LANES) {
            *mrts_lanes_at(here, j) = *mrts_lanes_at(state->above, at + j) - *mrts_lanes_at(p->upper, at + j);
            *mrts_lanes_at(here, r + j) = *mrts_lanes_at(p->lower, at + j) - *mrts_lanes_at(state->below, at + j);
        }
        if (p->low) mrts_smooth_shared(p, k, state->free, here);
    }
    for (int k = 0; k < n - 1; ++k) {
        mrts_smooth_segment(p, state, k, 1, state->x, state->u, state->above, state->below,
                            g + (long long)k * slots + segment);
    }
}

/* What the step changes in every g, to first order. */
static void mrts_smooth_moved(const mrts_smooth_program *p, mrts_smooth_state *state) {
    const int n = p->nodes, r = p->rows, slots = mrts_smooth_slots(p);
    const double *dx = state->px, *du = state->pu, *df = state->pf;
    double *dg = state->ds;
    double *above = state->row_weight, *below = state->row_cross; /* their second derivatives have been used */
    for (int k = 0; k < n; ++k) {
        const long long at = (long long)k * r;
        double *here = dg + (long long)k * slots;
        for (int j = 0; j < r; j += MRTS_LANES) {
            const mrts_lanes sum = *mrts_lanes_at(p->rate, at + j) * du[k] +
                                   mrts_smooth_moved_by(p, k, j, df + (long long)k * p->free);
            *mrts_lanes_at(above, at + j) = *mrts_lanes_at(here, j) = sum + *mrts_lanes_at(state->above_x, at + j) * dx[k];
            *mrts_lanes_at(below, at + j) = sum + *mrts_lanes_at(state->below_x, at + j) * dx[k];
            *mrts_lanes_at(here, r + j) = -*mrts_lanes_at(below, at + j);
        }
        if (p->low) mrts_smooth_shared(p, k, df, here);
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

/* Sums of multipliers y by the rows of node k, into `pressing` where what lies above the row's value is to be small,
 * and into `holding` where what lies below it is to be large. */
static void mrts_smooth_presses(const mrts_smooth_program *p, mrts_smooth_state *state, const double *y, int k) {
    const int n = p->nodes, r = p->rows, c = p->changes, slots = mrts_smooth_slots(p);
    const double *here = y + (long long)k * slots;
    for (int j = 0; j < r; ++j) {
        state->pressing[j] = here[j];
        state->holding[j] = here[r + j];
    }
    for (int s = k > 0 ? k - 1 : 0; s <= k && s < n - 1; ++s) {
        const double *up = y + (long long)s * slots + mrts_smooth_node_slots(p), *down = up + c;
        const double *pressing = s < k ? up : down, *holding = s < k ? down : up;
        for (int i = 0; i < c; i += MRTS_LANES) { /* behind the last by_change is 0 */
            const mrts_lanes by = state->by_time[s] * *mrts_lanes_at(state->by_change, i);
            *mrts_lanes_at(state->pressing, i) += by * *mrts_lanes_at(pressing, i);
            *mrts_lanes_at(state->holding, i) += by * *mrts_lanes_at(holding, i);
        }
    }
}

/* Adds the gradient of sum y g along x, u and F to px, pu, pf. */
static void mrts_smooth_pulled(const mrts_smooth_program *p, mrts_smooth_state *state, const double *y) {
    double *gx = state->px, *gu = state->pu, *gf = state->pf;
    const int n = p->nodes, r = p->rows, c = p->changes, J = p->jerks, slots = mrts_smooth_slots(p);
    for (int k = 0; k < n; ++k) {
        const long long at = (long long)k * r;
        double *F = gf + (long long)k * p->free;
        mrts_lanes of_x = {0}, of_u = of_x;
        mrts_smooth_presses(p, state, y, k);
        for (int j = 0; j < r; j += MRTS_LANES) {
            const mrts_lanes up = *mrts_lanes_at(state->pressing, j), down = *mrts_lanes_at(state->holding, j);
            of_x += up * *mrts_lanes_at(state->above_x, at + j) - down * *mrts_lanes_at(state->below_x, at + j);
            of_u += (up - down) * *mrts_lanes_at(p->rate, at + j);
            *mrts_lanes_at(state->pressing, j) = up - down;
        }
        double along_x = mrts_lane_sum(of_x), along_u = mrts_lane_sum(of_u);
        mrts_smooth_add_rows(p, k, r, state->pressing, 1, F);
        const double *here = y + (long long)k * slots;
        if (p->low) {
            F[p->free - 1] -= mrts_smooth_product(0, r, here, p->high + at) + mrts_smooth_product(0, r, here + r, p->low + at);
        }
        for (int i = 0; i < p->cones; ++i) {
            const long long cone = (long long)k * p->cones + i;
            const double by = here[2 * r + i];
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

/* Half the lengths of the segments beside a node: the trapezoidal rule. */
static double mrts_smooth_spacing(const mrts_smooth_program *p, int k) {
    return ((k > 0 ? p->step[k - 1] : 0) + (k < p->nodes - 1 ? p->step[k] : 0)) / 2;
}

/* The objective in its unit, its gradient, and the duration. */
static double mrts_smooth_objective(const mrts_smooth_program *p, mrts_smooth_state *state, double *duration) {
    const int n = p->nodes, r = p->rows;
    double total = 0, effort = 0, *gx = state->gx, *gu = state->gu, *gf = state->gf;
    for (long long i = 0; i < (long long)n * (2 + p->free); ++i) gx[i] = 0;
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
        mrts_lanes spent = {0}, of_x = spent, of_u = spent;
        for (int j = 0; j < r; j += MRTS_LANES) {
            const mrts_lanes weight = by * *mrts_lanes_at(p->weight, j), v = *mrts_lanes_at(state->value, at + j);
            const mrts_lanes lift = p->root ? *mrts_lanes_at(p->root, at + j) : mrts_each(0);
            const mrts_lanes along = weight * (2 * v / root + 2 * lift);
            *mrts_lanes_at(state->column[0], j) = along;
            spent += weight * (v * v / root + 2 * lift * v + lift * lift * tangent);
            of_x += along * *mrts_lanes_at(p->square, at + j) +
                    weight * (lift * lift / (2 * a) - v * v / (2 * root * state->x[k]));
            of_u += along * *mrts_lanes_at(p->rate, at + j);
        }
        effort += mrts_lane_sum(spent);
        gx[k] += mrts_lane_sum(of_x);
        gu[k] += mrts_lane_sum(of_u);
        mrts_smooth_add_rows(p, k, r, state->column[0], 1, gf + (long long)k * p->free);
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
static void mrts_smooth_node_second(const mrts_smooth_program *p, mrts_smooth_state *state, int k) {
    const int r = p->rows, slots = mrts_smooth_slots(p);
    const long long at = (long long)k * r;
    const double *above = state->weight + (long long)k * slots, *below = above + r;
    double *along = state->row_weight + at, *cross = state->row_cross + at;
    mrts_lanes squares = {0};
    for (int j = 0; j < r; j += MRTS_LANES) {
        const mrts_lanes up = *mrts_lanes_at(above, j), down = *mrts_lanes_at(below, j);
        const mrts_lanes up_x = *mrts_lanes_at(state->above_x, at + j), down_x = *mrts_lanes_at(state->below_x, at + j);
        *mrts_lanes_at(along, j) = up + down;
        *mrts_lanes_at(cross, j) = up * up_x + down * down_x;
        squares += up * up_x * up_x + down * down_x * down_x;
    }
    double second = mrts_lane_sum(squares);
    double *shared = state->share_second + 3 * k;
    shared[0] = shared[1] = shared[2] = 0;
    for (int j = 0; j < r && p->low; ++j) {
        const double up = -above[j] * p->high[at + j], down = below[j] * p->low[at + j];
        state->row_share[at + j] = up + down;
        shared[0] += up * state->above_x[at + j] + down * state->below_x[at + j];
        shared[1] += (up + down) * p->rate[at + j];
        shared[2] += down * p->low[at + j] - up * p->high[at + j];
    }
    const double x = state->x[k], root = sqrt(x);
    if (p->effort > 0 && p->weight) {
        const double by = p->effort * mrts_smooth_spacing(p, k) / state->unit;
        for (int j = 0; j < r; j += MRTS_LANES) {
            const mrts_lanes share = by / root * *mrts_lanes_at(p->weight, j), v = *mrts_lanes_at(state->value, at + j) / x;
            const mrts_lanes square = *mrts_lanes_at(p->square, at + j);
            *mrts_lanes_at(along, j) += 2 * share;
            *mrts_lanes_at(cross, j) += share * (2 * square - v);
            second += mrts_lane_sum(share * (2 * square * square - 2 * square * v + 0.75 * v * v));
        }
    }
    if (p->root) {
        mrts_smooth_presses(p, state, state->y, k);
        for (int j = 0; j < r; ++j) {
            const double by = p->root[at + j];
            second += (by < 0 ? -by * state->pressing[j] : by * state->holding[j]) / (4 * x * root);
        }
    }
    state->node_second[3 * k] = second;
    state->node_second[3 * k + 1] = state->node_second[3 * k + 2] = 0;
    mrts_smooth_cone_second(p, state, below + r, state->y + (long long)k * slots + 2 * r, k, state->node_second + 3 * k);
}

static void mrts_smooth_change_second(const mrts_smooth_program *p, mrts_smooth_state *state, const double *weights,
                                      int k) {
    const int r = p->rows, c = p->changes;
    const long long at = (long long)k * r, of = (long long)k * c;
    const double time0 = state->time_x[k], time1 = state->time_x1[k];
    double second0 = 0, second1 = 0, mixed = 0;
    for (int i = 0; i < c; ++i) {
        const double by = state->by_time[k] * state->by_change[i];
        const double up = weights[i], down = weights[c + i];
        const double up0 = by * state->below_x[at + i] + time0, up1 = by * state->above_x[at + r + i] - time1;
        const double down0 = by * state->above_x[at + i] - time0, down1 = by * state->below_x[at + r + i] + time1;
        const double weight = by * by * (up + down);
        const double before = by * (up * up0 + down * down0), after = by * (up * up1 + down * down1);
        state->change_weight[of + i] = weight;
        state->change_before[of + i] = before;
        state->change_after[of + i] = after;
        state->row_weight[at + i] += weight;
        state->row_weight[at + r + i] += weight;
        state->row_cross[at + i] += before;
        state->row_cross[at + r + i] += after;
        second0 += up * up0 * up0 + down * down0 * down0;
        second1 += up * up1 * up1 + down * down1 * down1;
        mixed -= up * up0 * up1 + down * down0 * down1;
    }
    state->node_second[3 * k] += second0;
    state->node_second[3 * k + 3] += second1;
    state->segment_second[4 * k] += mixed;
}

static void mrts_smooth_jerk_second(const mrts_smooth_program *p, mrts_smooth_state *state, const double *weights, int k) {
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

/* Second derivatives of objective + sum of y g, plus sum of weight times g's gradient squared. */
static void mrts_smooth_second(const mrts_smooth_program *p, mrts_smooth_state *state) {
    const int n = p->nodes, slots = mrts_smooth_slots(p);
    double time = p->time / state->unit;
    if (p->longest < MRTS_INFINITY) time += state->y[(long long)n * slots] / p->longest;
    for (int k = 0; k < n; ++k) mrts_smooth_node_second(p, state, k);
    for (int k = 0; k < n - 1; ++k) {
        const long long at = (long long)k * slots + mrts_smooth_node_slots(p);
        double *node = state->node_second + 3 * k, *segment = state->segment_second + 4 * k;
        const double x = state->x[k], next = state->x[k + 1], root = sqrt(x), root1 = sqrt(next), sum = root + root1;
        const double by = time * p->step[k] / (sum * sum), even = 2 * p->uneven / (state->unit * p->step[k]);
        node[0] += by * (1 / (sum * x) + 1 / (2 * x * root));
        node[2] += even;
        node[3] += by * (1 / (sum * next) + 1 / (2 * next * root1));
        node[5] += even;
        segment[0] = by / (sum * root * root1);
        segment[1] = segment[2] = 0;
        segment[3] = -even;
        mrts_smooth_change_second(p, state, state->weight + at, k);
        mrts_smooth_jerk_second(p, state, state->weight + at + 2 * p->changes, k);
    }
}

static void mrts_smooth_clear(long long count, double *a) {
    for (long long i = 0; i < count; ++i) a[i] = 0;
}

static void mrts_smooth_copy(long long count, const double *from, double *to) {
    for (long long i = 0; i < count; ++i) to[i] = from[i];
}

/*
 * The Newton matrix of smooth timing, factored node by node. Unknowns are F_0, c_0, F_1, c_1, ..., F_(n-1), c_(n-1),
 * c_n with the control points c; node k's front is F_k, c_k, which are eliminated, and F_(k+1), c_(k+1), c_(k+2), which
 * are all that they meet. */

static inline long long mrts_front_unknowns(const mrts_smooth_program *p) {
    return (long long)p->nodes * (p->free + 1) + 1;
}

#define MRTS_FRONT_PIVOT 1e-16 /* a pivot below this share of its diagonal is rounding: its unknown does not move */
#define MRTS_FRONT_SOFT 1e-15  /* of its diagonal, added to each: F that nothing determines stays where it is */

/* The place in a front of F_(k+1), and reals from a row of it to the next. */
static inline int mrts_front_next(const mrts_smooth_program *p) { return mrts_lanes_whole(p->free + 1); }
static inline int mrts_front_stride(const mrts_smooth_program *p) {
    return mrts_front_next(p) + mrts_lanes_whole(p->free + 2);
}

/* Reals of the factor of one front: rows of what is eliminated. */
static long long mrts_front_size(const mrts_smooth_program *p) { return (p->free + 2) * mrts_front_stride(p); }

static int mrts_front_held(const mrts_smooth_program *p, int k) {
    return (k == 0 && p->held_start) || (k == p->nodes - 1 && p->held_end);
}
static int mrts_front_given(const mrts_smooth_program *p, int k) {
    return p->timed || (k == 0 && p->given_start) || (k == p->nodes && p->given_end);
}

/* Adds the sum of weight times products of coefficients of F over some rows, those of `left` times those of `right`, to
 * A; where they are the same, above the diagonal alone. */
static void mrts_front_add_products(const mrts_smooth_program *p, int rows, const double *weight, const double *left,
                                    const double *right, double *weighed, double *A) {
    const int stride = mrts_front_stride(p);
    for (int from = 0, to; from < rows; from = to) {
        to = mrts_smooth_alike(p, from, rows);
        const int first = p->first[from / MRTS_LANES], end = first + p->count[from / MRTS_LANES];
        for (int i = first; i < end; ++i) {
            for (int j = from; j < to; j += MRTS_LANES) {
                *mrts_lanes_at(weighed, j) = *mrts_lanes_at(weight, j) * *mrts_lanes_at(left, i * p->rows + j);
            }
            for (int l = left == right ? i : first; l < end; ++l) {
                A[i * stride + l] += mrts_smooth_product(from, to, weighed, right + l * p->rows);
            }
        }
    }
}

/* Adds node k to the upper triangle of a front; c_(k+1) has the place `next`. Its own places are adjacent. */
static void mrts_front_add_node(const mrts_smooth_program *p, const mrts_smooth_state *state, int k, int next, double *A,
                                double *diagonal) {
    const int f = p->free, r = p->rows, m = mrts_front_stride(p);
    const long long at = (long long)k * r;
    const double *weight = state->row_weight + at, *cross = state->row_cross + at, *entry = mrts_smooth_entry(p, k);
    const double near = state->near[k], far = state->far[k], slope = state->slope[k];
    const double xx = state->node_second[3 * k];
    double *by_c = state->column[1], *by_next = state->column[2];
    mrts_lanes mixed = {0}, square = mixed;
    for (int j = 0; j < r; j += MRTS_LANES) {
        const mrts_lanes rate = *mrts_lanes_at(p->rate, at + j), of_x = *mrts_lanes_at(cross, j);
        const mrts_lanes along_u = *mrts_lanes_at(weight, j) * rate;
        *mrts_lanes_at(by_c, j) = near * of_x - slope * along_u;
        *mrts_lanes_at(by_next, j) = far * of_x + slope * along_u;
        mixed += of_x * rate;
        square += along_u * rate;
    }
    const double xu = state->node_second[3 * k + 1] + mrts_lane_sum(mixed);
    const double uu = state->node_second[3 * k + 2] + mrts_lane_sum(square);
    for (int i = 0; i < f; ++i) diagonal[i] = A[i * m + i];
    mrts_front_add_products(p, r, weight, entry, entry, state->column[0], A);
    mrts_smooth_add_rows(p, k, r, by_c, m, A + f);
    mrts_smooth_add_rows(p, k, r, by_next, m, A + next);
    if (p->low) {
        const double *second = state->share_second + 3 * k;
        double *of_s = A + (f - 1) * m;
        mrts_smooth_add_rows(p, k, r, state->row_share + at, m, A + f - 1);
        of_s[f - 1] += second[2];
        of_s[f] += near * second[0] - slope * second[1];
        of_s[next] += far * second[0] + slope * second[1];
    }
    for (int i = 0; i < f; ++i) diagonal[i] = A[i * m + i] - diagonal[i];
    const double cc = near * near * xx - 2 * near * slope * xu + slope * slope * uu;
    const double nn = far * far * xx + 2 * far * slope * xu + slope * slope * uu;
    A[f * m + f] += cc;
    A[f * m + next] += near * far * xx + slope * (near - far) * xu - slope * slope * uu;
    A[next * m + next] += nn;
    diagonal[f] = cc;
    diagonal[f + 1] = nn;
}

static void mrts_front_add_segment(const mrts_smooth_program *p, const mrts_smooth_state *state, int k, double *A) {
    const int f = p->free, r = p->rows, c = p->changes, m = mrts_front_stride(p), next = mrts_front_next(p);
    const int c1 = next + f, c2 = c1 + 1;
    const double *rate0 = p->rate + (long long)k * r, *rate1 = rate0 + r;
    const double near0 = state->near[k], far0 = state->far[k], slope0 = state->slope[k];
    const double near1 = state->near[k + 1], far1 = state->far[k + 1], slope1 = state->slope[k + 1];
    double xx = state->segment_second[4 * k], xu = state->segment_second[4 * k + 1];
    double ux = state->segment_second[4 * k + 2], uu = state->segment_second[4 * k + 3];
    double *by = state->column[1], *of_c = state->column[2], *of_next = state->column[3];
    for (int j = c; j < r; ++j) by[j] = of_c[j] = of_next[j] = 0;
    for (int i = 0; i < c; ++i) { /* value there with c_k, c_(k+1) here */
        const double weight = state->change_weight[(long long)k * c + i];
        const double before = state->change_before[(long long)k * c + i];
        by[i] = -weight;
        xu -= before * rate1[i];
        uu -= weight * rate0[i] * rate1[i];
        of_c[i] = -near0 * before + slope0 * weight * rate0[i];
        of_next[i] = -far0 * before - slope0 * weight * rate0[i];
    }
    mrts_front_add_products(p, c, by, mrts_smooth_entry(p, k), mrts_smooth_entry(p, k + 1), state->column[0], A + next);
    mrts_smooth_add_rows(p, k + 1, c, of_c, 1, A + f * m + next);
    mrts_smooth_add_rows(p, k + 1, c, of_next, m, A + next * m + c1);
    for (int i = 0; i < c; ++i) { /* value here with c_(k+1), c_(k+2) there */
        const double after = state->change_after[(long long)k * c + i];
        ux -= after * rate0[i];
        of_c[i] = -near1 * after - slope1 * by[i] * rate1[i];
        of_next[i] = -far1 * after + slope1 * by[i] * rate1[i];
    }
    mrts_smooth_add_rows(p, k, c, of_c, m, A + c1);
    mrts_smooth_add_rows(p, k, c, of_next, m, A + c2);
    /* (x, u) of the nodes by (c_k, c_(k+1)) and (c_(k+1), c_(k+2)) */
    const double x1 = near1 * xx - slope1 * xu, x2 = far1 * xx + slope1 * xu;
    const double u1 = near1 * ux - slope1 * uu, u2 = far1 * ux + slope1 * uu;
    A[f * m + c1] += near0 * x1 - slope0 * u1;
    A[f * m + c2] += near0 * x2 - slope0 * u2;
    A[c1 * m + c1] += 2 * (far0 * x1 + slope0 * u1);
    A[c1 * m + c2] += far0 * x2 + slope0 * u2;
}

/* Takes the row and column of an unknown out of a front. */
static void mrts_front_hold(int stride, int i, double *A, double one) {
    for (int l = 0; l < i; ++l) A[l * stride + i] = 0;
    for (int l = i + 1; l < stride; ++l) A[i * stride + l] = 0;
    A[i * stride + i] = one;
}

/* Eliminates the first unknowns of a front: their rows of the factor, as multiples of their pivots, whose reciprocals
 * stand on the diagonal; what is left stays in the upper triangle of A. Unknowns of one corner of a box of loads meet those
 * of others only by what elimination fills in: what is 0 takes no time. */
static void mrts_front_eliminate(int pivots, int stride, double *A, const double *diagonal, double *factor) {
    for (int k = 0; k < pivots; ++k) {
        double *row = A + k * stride, *kept = factor + k * stride;
        const double pivot = row[k] + MRTS_FRONT_SOFT * diagonal[k];
        const double by = kept[k] = pivot > MRTS_FRONT_PIVOT * diagonal[k] ? 1 / pivot : 0;
        for (int i = k + 1; i < stride; ++i) {
            const double taken = kept[i] = by * row[i];
            if (taken == 0) continue;
            for (int j = i / MRTS_LANES * MRTS_LANES; j < stride; j += MRTS_LANES) {
                *mrts_lanes_at(A, i * stride + j) -= taken * *mrts_lanes_at(row, j);
            }
        }
    }
}

/* Factors the matrix that the second derivatives of the state make. */
static void mrts_front_factor(const mrts_smooth_program *p, mrts_smooth_state *state) {
    const int n = p->nodes, f = p->free, there = mrts_front_next(p), stride = mrts_front_stride(p);
    double *A = state->fronts, *diagonal = A + stride * stride, *left = diagonal + f + 2;
    mrts_smooth_clear((f + 2) * (f + 2), left);
    for (int k = 0; k < n; ++k) {
        const int last = k == n - 1, pivots = last ? f + 2 : f + 1, next = last ? f + 1 : there + f;
        mrts_smooth_clear(stride * stride, A);
        for (int i = 0; i < f + 2; ++i) {
            double *row = A + (i < f + 1 ? i : next) * stride;
            for (int j = i; j < f + 2; ++j) row[j < f + 1 ? j : next] = left[i * (f + 2) + j];
        }
        mrts_front_add_node(p, state, k, next, A, diagonal);
        if (!last) mrts_front_add_segment(p, state, k, A);
        for (int i = 0; i < f && mrts_front_held(p, k); ++i) mrts_front_hold(stride, i, A, diagonal[i] = 1);
        for (int i = 0; i < f && !last && mrts_front_held(p, k + 1); ++i) mrts_front_hold(stride, there + i, A, 0);
        if (mrts_front_given(p, k)) mrts_front_hold(stride, f, A, diagonal[f] = 1);
        if (mrts_front_given(p, k + 1)) mrts_front_hold(stride, next, A, last ? (diagonal[f + 1] = 1) : 0);
        if (!last && mrts_front_given(p, k + 2)) mrts_front_hold(stride, next + 1, A, 0);
        mrts_front_eliminate(pivots, stride, A, diagonal, state->factor + k * mrts_front_size(p));
        for (int i = 0; i < f + 2 && !last; ++i) {
            mrts_smooth_copy(f + 2 - i, A + (there + i) * (stride + 1), left + i * (f + 3));
        }
    }
}

/* Takes the unknowns of front k from all, in its places; where c_(k+2) is among all. */
static double *mrts_front_take(const mrts_smooth_program *p, int k, double *all, double *its) {
    const int q = p->free + 1, last = k == p->nodes - 1, there = mrts_front_next(p);
    double *here = all + (long long)k * q, *end = here + (k < p->nodes - 2 ? 2 * q + q - 1 : 2 * q);
    mrts_smooth_copy(last ? q + 1 : q, here, its);
    if (last) return 0;
    mrts_smooth_copy(q, here + q, its + there);
    its[there + q] = *end;
    return end;
}

/* Solves for a right side in place, which is 0 at what is given. */
static void mrts_front_solve(const mrts_smooth_program *p, const mrts_smooth_state *state, double *b) {
    const int n = p->nodes, f = p->free, q = f + 1, there = mrts_front_next(p), stride = mrts_front_stride(p);
    double *its = state->fronts;
    mrts_smooth_clear(stride, its);
    for (int k = 0; k < n; ++k) {
        const int pivots = k < n - 1 ? q : q + 1;
        const double *L = state->factor + k * mrts_front_size(p);
        double *here = b + (long long)k * q, *end = mrts_front_take(p, k, b, its);
        for (int i = 0; i < pivots; ++i) {
            for (int j = i + 1; j < pivots; ++j) its[j] -= its[i] * L[i * stride + j];
            here[i] = its[i] * L[i * stride + i];
        }
        if (!end) break;
        for (int j = there; j < stride; j += MRTS_LANES) {
            mrts_lanes sum = *mrts_lanes_at(its, j);
            for (int i = 0; i < pivots; ++i) sum -= its[i] * *mrts_lanes_at(L, i * stride + j);
            *mrts_lanes_at(its, j) = sum;
        }
        mrts_smooth_copy(q, its + there, here + q);
        *end = its[there + q];
    }
    for (int k = n - 1; k >= 0; --k) {
        const int pivots = k < n - 1 ? q : q + 1;
        const double *L = state->factor + k * mrts_front_size(p);
        const int joined = mrts_front_take(p, k, b, its) != 0;
        for (int i = 0; i < pivots && joined; ++i) its[i] -= mrts_smooth_product(there, stride, L + i * stride, its);
        for (int i = pivots - 1; i > 0; --i) {
            for (int l = 0; l < i; ++l) its[l] -= its[i] * L[l * stride + i];
        }
        mrts_smooth_copy(pivots, its, b + (long long)k * q);
    }
}

/* The gradient px, pu, pf as one along the unknowns, 0 along what is given. */
static void mrts_front_gather(const mrts_smooth_program *p, const mrts_smooth_state *state, double *b) {
    const int f = p->free, q = f + 1;
    const double *gx = state->px, *gu = state->pu, *gf = state->pf;
    double passed = 0;
    for (int k = 0; k < p->nodes; ++k) {
        double *here = b + (long long)k * q;
        for (int i = 0; i < f; ++i) here[i] = mrts_front_held(p, k) ? 0 : gf[(long long)k * f + i];
        here[f] = mrts_front_given(p, k) ? 0 : passed + state->near[k] * gx[k] - state->slope[k] * gu[k];
        passed = state->far[k] * gx[k] + state->slope[k] * gu[k];
    }
    b[(long long)p->nodes * q] = mrts_front_given(p, p->nodes) ? 0 : passed;
}

/* The step b of the unknowns as one of x, u and F. */
static void mrts_front_scatter(const mrts_smooth_program *p, mrts_smooth_state *state) {
    const int n = p->nodes, f = p->free, q = f + 1;
    for (int k = 0; k < n; ++k) {
        const double *here = state->b + (long long)k * q;
        const double c = here[f], next = k < n - 1 ? here[q + f] : here[q];
        for (int i = 0; i < f; ++i) state->pf[(long long)k * f + i] = here[i];
        state->px[k] = state->near[k] * c + state->far[k] * next;
        state->pu[k] = state->slope[k] * (next - c);
    }
}

/*
 * The program by a primal-dual interior point method: Newton steps with predictor and corrector
 * (S. Mehrotra, On the implementation of a primal-dual interior point method, SIAM J. Optimization 2, 1992), started
 * outside the limits. */

enum { MRTS_SMOOTH_FOUND = 0, MRTS_SMOOTH_STOPPED = 1 };

#define MRTS_SMOOTH_MOST 200       /* iterations: a step takes 10 to 30, one with room over 3000 nodes 160 */
#define MRTS_SMOOTH_KEPT 5e-9      /* of a limit: rounding of a change over a short segment may be this large */
#define MRTS_SMOOTH_GAP 3e-9       /* between the objective and its bound, of it */
#define MRTS_SMOOTH_AIM 1e-9       /* the gap that steps aim at, at least: below it rounding grows */
#define MRTS_SMOOTH_SHORT 1e-9     /* a step that ends this early leads nowhere */
#define MRTS_SMOOTH_LARGE 1e14     /* a multiplier, of the objective: nothing keeps the limits */
#define MRTS_SMOOTH_BOUNDARY 0.995 /* of the way to the nearest limit */
#define MRTS_SMOOTH_SLACK 0.3      /* least one to start with, of a limit */
#define MRTS_SMOOTH_FIRST 10       /* the gap to start with, of the objective */
#define MRTS_SMOOTH_CENTRAL 0.3    /* the gap, of the objective, and the excess, of a limit, of the iterate kept for a program that is near: with less it
                                   * is too near limits that have moved, with more it gains little */
#define MRTS_SMOOTH_LAID 1e-4      /* the gap, of the objective, below which tangents move no more */
#define MRTS_SMOOTH_ROUNDING 1e-13 /* of a sum, what is left of it where all of it cancels */
#define MRTS_SMOOTH_LEAST 0.1      /* of x: what a step leaves of it at least */

static long long mrts_smooth_duration_slot(const mrts_smooth_program *p) {
    return (long long)p->nodes * mrts_smooth_slots(p);
}
static long long mrts_smooth_share_slot(const mrts_smooth_program *p) { return mrts_smooth_duration_slot(p) + 1; }

static int mrts_smooth_relaxes(const mrts_smooth_program *p, long long slot) {
    return slot < mrts_smooth_duration_slot(p) && slot % mrts_smooth_slots(p) >= mrts_smooth_node_slots(p);
}

/* Reals of the iterate that a program leaves at the end of its work for one that is near: slacks and multipliers of all slots,
 * F, control points of x, and the unit of the objective. */
MRTS_EXPORT long long mrts_smooth_kept(const mrts_smooth_program *p) {
    return 2 * (mrts_smooth_share_slot(p) + 1) + (long long)p->nodes * (p->free + 1) + 2;
}

/* A state laid out in memory, the gradients' parts and those of the steps in a row; how many reals it takes. */
static long long mrts_smooth_state_in(const mrts_smooth_program *p, double *memory, mrts_smooth_state *at) {
    const long long n = p->nodes, r = p->rows, f = n * p->free, nr = n * r, cones = n * p->cones, c = p->changes;
    const long long slots = (mrts_smooth_share_slot(p) / MRTS_LANES + 1) * MRTS_LANES;
    const long long unknowns = mrts_front_unknowns(p), stride = mrts_front_stride(p);
    const struct {
        double **of;
        long long size;
    } parts[] = {
        {&at->x, n}, {&at->u, n}, {&at->near, n}, {&at->far, n}, {&at->slope, n}, {&at->around, n}, {&at->root_around, n},
        {&at->by_time, n}, {&at->time_x, n}, {&at->time_x1, n}, {&at->duration_x, n}, {&at->free, f}, {&at->control, n + 1},
        {&at->by_change, mrts_lanes_whole(p->changes)}, {&at->value, nr}, {&at->above, nr}, {&at->below, nr}, {&at->above_x, nr}, {&at->below_x, nr},
        {&at->row_weight, nr}, {&at->row_cross, nr}, {&at->cone_u, cones}, {&at->cone_x, cones}, {&at->cone_root, cones},
        {&at->change_weight, n * c}, {&at->change_before, n * c}, {&at->change_after, n * c}, {&at->node_second, 3 * n},
        {&at->row_share, nr}, {&at->share_second, 3 * n},
        {&at->segment_second, 4 * n}, {&at->pressing, r}, {&at->holding, r}, {&at->column[0], r},
        {&at->column[1], r}, {&at->column[2], r}, {&at->column[3], r}, {&at->s, slots}, {&at->y, slots},
        {&at->by_s, slots}, {&at->weight, slots}, {&at->missed, slots}, {&at->ds, slots}, {&at->dy, slots},
        {&at->target, slots}, {&at->gx, n}, {&at->gu, n}, {&at->gf, f}, {&at->px, n}, {&at->pu, n},
        {&at->pf, f}, {&at->b, unknowns}, {&at->w, unknowns}, {&at->border, unknowns}, {&at->factor, n * mrts_front_size(p)},
        {&at->fronts, stride * (2 * stride + 1)}, {&at->kept, mrts_smooth_kept(p)},
    };
    long long taken = 0;
    for (unsigned i = 0; i < sizeof parts / sizeof *parts; taken += parts[i++].size) {
        *parts[i].of = memory ? memory + taken : memory;
    }
    at->unit = 1;
    at->slots = slots;
    at->share = 0;
    return taken;
}

MRTS_EXPORT long long mrts_smooth_work(const mrts_smooth_program *p) {
    mrts_smooth_state unused;
    return mrts_smooth_state_in(p, 0, &unused);
}

/* Marks the slots that have a limit by multipliers of 1. */
static void mrts_smooth_present(const mrts_smooth_program *p, mrts_smooth_state *at) {
    const int n = p->nodes, r = p->rows, slots = mrts_smooth_slots(p), segment = mrts_smooth_node_slots(p);
    at->present = 0;
    for (int k = 0; k < n; ++k) {
        double *y = at->y + (long long)k * slots;
        for (int i = 0; i < slots; ++i) y[i] = k < n - 1 && (i < segment + 2 * p->changes || !p->timed);
        for (int j = 0; j < r; ++j) {
            y[j] = p->upper[(long long)k * r + j] < MRTS_INFINITY;
            y[r + j] = p->lower[(long long)k * r + j] > -MRTS_INFINITY;
        }
        for (int i = 0; i < p->cones; ++i) {
            y[2 * r + i] = p->bound[3 * ((long long)k * p->cones + i) + 2] < MRTS_INFINITY;
        }
    }
    at->y[mrts_smooth_duration_slot(p)] = p->longest < MRTS_INFINITY && !p->timed;
    at->y[mrts_smooth_share_slot(p)] = p->relaxed > 0;
    for (long long i = 0; i < at->slots; ++i) at->present += at->y[i] > 0;
}

/* The slope of the Lagrangian along the share, with multipliers y. */
static double mrts_smooth_share_slope(const mrts_smooth_program *p, const double *y) {
    const long long last = mrts_smooth_share_slot(p);
    double slope = p->relaxed - y[last];
    for (long long i = 0; i < last; ++i) slope -= mrts_smooth_relaxes(p, i) ? y[i] : 0;
    return slope;
}

/* By how much the slope of the Lagrangian would let it fall: twice what a Newton step with the last factor gains. */
static double mrts_smooth_decrement(const mrts_smooth_program *p, mrts_smooth_state *at) {
    const long long n = p->nodes, unknowns = mrts_front_unknowns(p);
    double sum = 0;
    mrts_smooth_copy(n * (2 + p->free), at->gx, at->px);
    mrts_smooth_pulled(p, at, at->y);
    mrts_front_gather(p, at, at->b);
    mrts_smooth_copy(unknowns, at->b, at->w);
    mrts_front_solve(p, at, at->w);
    for (long long i = 0; i < unknowns; ++i) sum += at->b[i] * at->w[i];
    if (p->relaxed > 0) {
        const double slope = mrts_smooth_share_slope(p, at->y);
        sum += slope * slope / at->pull;
    }
    return sum;
}

static int mrts_smooth_bordered(const mrts_smooth_program *p, const mrts_smooth_state *at) {
    return p->relaxed > 0 || at->y[mrts_smooth_duration_slot(p)] > 0;
}

/* The right side -gradient - sum of target g's gradient, solved for; the step goes to px, pu, pf and ds, dy. */
static void mrts_smooth_newton(const mrts_smooth_program *p, mrts_smooth_state *at) {
    const long long n = p->nodes, nf = n * p->free, unknowns = mrts_front_unknowns(p), last = mrts_smooth_duration_slot(p);
    for (long long i = 0; i < 2 * n + nf; ++i) at->px[i] = at->gx[i];
    mrts_smooth_pulled(p, at, at->target);
    mrts_front_gather(p, at, at->b);
    for (long long i = 0; i < unknowns; ++i) at->b[i] = -at->b[i];
    mrts_front_solve(p, at, at->b);
    double along = 0; /* the border: the step of the share, or less what the duration's slot adds to its multiplier */
    if (mrts_smooth_bordered(p, at)) {
        const double slope = p->relaxed > 0 ? mrts_smooth_share_slope(p, at->target) : 0;
        along = (mrts_dot((int)unknowns, at->border, at->b) - slope) / at->pull;
        for (long long i = 0; i < unknowns; ++i) at->b[i] += along * at->w[i];
    }
    at->share_step = p->relaxed > 0 ? along : 0;
    mrts_front_scatter(p, at);
    mrts_smooth_moved(p, at);
    if (p->relaxed > 0) {
        for (long long i = 0; i < last; ++i) at->ds[i] -= mrts_smooth_relaxes(p, i) ? along : 0;
        at->ds[mrts_smooth_share_slot(p)] = -along;
    }
    if (at->y[last] > 0) at->ds[last] = -along * at->s[last] / at->y[last]; /* its own sum would cancel */
    mrts_lanes fall = mrts_each(MRTS_SMOOTH_BOUNDARY), dual_fall = fall; /* of slacks and multipliers in the whole step */
    for (long long i = 0; i < at->slots; i += MRTS_LANES) {
        mrts_lanes *ds = mrts_lanes_at(at->ds, i), *dy = mrts_lanes_at(at->dy, i), y = *mrts_lanes_at(at->y, i);
        *dy = *mrts_lanes_at(at->target, i) - y + *mrts_lanes_at(at->weight, i) * *ds;
        *ds = -*mrts_lanes_at(at->missed, i) - *ds;
        fall = mrts_larger_lanes(-*ds * *mrts_lanes_at(at->by_s, i), fall);
        dual_fall = mrts_larger_lanes(-*dy / y, dual_fall); /* 0 / 0 where there is no limit is not larger */
    }
    double x = 1 / (1 - MRTS_SMOOTH_LEAST);
    for (long long k = 0; k < n; ++k) {
        if (-at->px[k] * x > at->x[k]) x = -at->x[k] / at->px[k];
    }
    at->slack_reach = 1 / mrts_largest_lane(fall);
    at->dual_reach = 1 / mrts_largest_lane(dual_fall);
    at->x_reach = x;
}

/* Lengths, at most 1, of a step of the profile and of one of the multipliers that leave a share of what they are. */
static double mrts_smooth_length(const mrts_smooth_state *at, double boundary) {
    return fmin(1, fmin(boundary * at->slack_reach, (1 - MRTS_SMOOTH_LEAST) * at->x_reach));
}
static double mrts_smooth_dual_length(const mrts_smooth_state *at, double boundary) {
    return fmin(1, boundary * at->dual_reach);
}

/* Answers what the share or the duration pulls at by the factor, into w; only one of them is limited. */
static void mrts_smooth_answer_border(const mrts_smooth_program *p, mrts_smooth_state *at) {
    const long long n = p->nodes, unknowns = mrts_front_unknowns(p), last = mrts_smooth_duration_slot(p);
    double along = at->weight[mrts_smooth_share_slot(p)];
    mrts_smooth_clear(n * (2 + p->free), at->px);
    if (p->relaxed > 0) {
        for (long long i = 0; i < last; ++i) { /* multipliers' steps are found later */
            at->dy[i] = mrts_smooth_relaxes(p, i) ? at->weight[i] : 0;
            along += at->dy[i];
        }
        mrts_smooth_pulled(p, at, at->dy);
    } else {
        for (long long k = 0; k < n; ++k) at->px[k] = at->duration_x[k] / p->longest;
    }
    mrts_front_gather(p, at, at->border);
    mrts_smooth_copy(unknowns, at->border, at->w);
    mrts_front_solve(p, at, at->w);
    const double answered = mrts_dot((int)unknowns, at->border, at->w);
    at->pull = p->relaxed > 0 ? along - answered : -at->s[last] / at->y[last] - answered;
    if (p->relaxed > 0 && !(at->pull > MRTS_SMOOTH_ROUNDING * along)) at->pull = MRTS_SMOOTH_ROUNDING * along;
}

/* One iteration from an evaluated point; the length of its step. */
static double mrts_smooth_advance(const mrts_smooth_program *p, mrts_smooth_state *at, double gap, double size) {
    const double mean = gap / at->present;
    for (long long i = 0; i < at->slots; i += MRTS_LANES) {
        const mrts_lanes y = *mrts_lanes_at(at->y, i), by_s = mrts_choose(y > 0, 1 / *mrts_lanes_at(at->s, i), mrts_each(0));
        *mrts_lanes_at(at->by_s, i) = by_s;
        *mrts_lanes_at(at->weight, i) = y * by_s;
        *mrts_lanes_at(at->target, i) = y * by_s * *mrts_lanes_at(at->missed, i);
    }
    mrts_smooth_second(p, at);
    mrts_front_factor(p, at);
    if (mrts_smooth_bordered(p, at)) mrts_smooth_answer_border(p, at);
    mrts_smooth_newton(p, at);
    double length = mrts_smooth_length(at, 1), dual = mrts_smooth_dual_length(at, 1);
    mrts_lanes left = {0};
    for (long long i = 0; i < at->slots; i += MRTS_LANES) {
        left += (*mrts_lanes_at(at->s, i) + length * *mrts_lanes_at(at->ds, i)) *
                (*mrts_lanes_at(at->y, i) + dual * *mrts_lanes_at(at->dy, i));
    }
    const double share = mrts_lane_sum(left) / gap, least = MRTS_SMOOTH_AIM * size / at->present;
    double centre = share * share * share * mean;
    if (centre < least) centre = least;
    for (long long i = 0; i < at->slots; i += MRTS_LANES) {
        const mrts_lanes both = *mrts_lanes_at(at->ds, i) * *mrts_lanes_at(at->dy, i);
        *mrts_lanes_at(at->target, i) += (centre - both) * *mrts_lanes_at(at->by_s, i);
    }
    mrts_smooth_newton(p, at);
    length = mrts_smooth_length(at, MRTS_SMOOTH_BOUNDARY);
    dual = mrts_smooth_dual_length(at, MRTS_SMOOTH_BOUNDARY);
    for (long long i = 0; i < at->slots; i += MRTS_LANES) {
        *mrts_lanes_at(at->s, i) += length * *mrts_lanes_at(at->ds, i);
        *mrts_lanes_at(at->y, i) += dual * *mrts_lanes_at(at->dy, i);
    }
    at->share += length * at->share_step;
    if (!p->timed) {
        const int n = p->nodes, q = p->free + 1;
        for (int k = 0; k < n; ++k) at->control[k] += length * at->b[(long long)k * q + p->free];
        at->control[n] += length * at->b[(long long)n * q];
        mrts_smooth_profile(p, at);
    }
    for (long long i = 0; i < (long long)p->nodes * p->free; ++i) at->free[i] += length * at->pf[i];
    return length;
}

static void mrts_smooth_keep(const mrts_smooth_program *p, mrts_smooth_state *at) {
    const double *of[] = {at->s, at->y, at->free, at->control, &at->unit};
    const long long slots = mrts_smooth_share_slot(p) + 1;
    const long long counts[] = {slots, slots, (long long)p->nodes * p->free, p->nodes + 1, 1};
    double *kept = at->kept;
    for (int i = 0; i < 5; kept += counts[i++]) mrts_smooth_copy(counts[i], of[i], kept);
}

/* Takes the iterate that was kept of a program that is near, but what is given; a slot that had no limit there begins at
 * the centre. */
static void mrts_smooth_take_kept(const mrts_smooth_program *p, mrts_smooth_state *at) {
    const long long slots = mrts_smooth_share_slot(p) + 1;
    const double *s = at->kept, *y = s + slots, *free = y + slots, *control = free + (long long)p->nodes * p->free;
    double gap = 0;
    int both = 0;
    for (long long i = 0; i < slots; ++i) {
        if (!(at->y[i] > 0 && y[i] > 0)) continue;
        gap += s[i] * y[i];
        ++both;
    }
    for (long long i = 0; i < slots; ++i) {
        const int is = at->y[i] > 0, was = y[i] > 0;
        at->s[i] = !is ? MRTS_INFINITY : was ? s[i] : MRTS_SMOOTH_SLACK;
        at->y[i] = !is ? 0 : was ? y[i] : gap / (both * MRTS_SMOOTH_SLACK);
    }
    const int held = p->held_start * p->free;
    mrts_smooth_copy((long long)(p->nodes - p->held_end) * p->free - held, free + held, at->free + held);
    mrts_smooth_copy(p->nodes + 1 - p->given_start - p->given_end, control + p->given_start,
                     at->control + p->given_start);
    at->unit = control[p->nodes + 1];
    if (!p->timed) mrts_smooth_profile(p, at);
}

/* Slacks and multipliers to start with, and a share that leaves room to all that it relaxes. */
static void mrts_smooth_first(const mrts_smooth_program *p, mrts_smooth_state *at) {
    double *g = at->missed;
    for (long long i = 0; i < at->slots && p->relaxed > 0; ++i) {
        const double share = mrts_smooth_relaxes(p, i) && at->y[i] > 0 ? g[i] + MRTS_SMOOTH_SLACK : MRTS_SMOOTH_SLACK;
        if (share > at->share) at->share = share;
    }
    g[mrts_smooth_share_slot(p)] = -at->share;
    const double gap = MRTS_SMOOTH_FIRST * (1 + p->relaxed * at->share);
    for (long long i = 0; i < at->slots; ++i) {
        const double room = (mrts_smooth_relaxes(p, i) ? at->share : 0) - g[i];
        at->s[i] = at->y[i] > 0 ? (room > MRTS_SMOOTH_SLACK ? room : MRTS_SMOOTH_SLACK) : MRTS_INFINITY;
        at->y[i] = at->y[i] > 0 ? gap / (at->s[i] * at->present) : 0;
    }
}

typedef struct {
    double objective, missed, gap, largest; /* of a constraint, of the objective, of multipliers */
} mrts_smooth_distance;

/* Evaluates the iterate; where `first`, also the unit of the objective, slacks and multipliers. */
static mrts_smooth_distance mrts_smooth_judge(const mrts_smooth_program *p, mrts_smooth_state *at, int first) {
    double duration, *g = at->missed;
    mrts_smooth_values(p, at);
    mrts_smooth_distance is = {mrts_smooth_objective(p, at, &duration), 0, 0, 0};
    if (first && is.objective > 0) {
        at->unit = is.objective;
        is.objective = mrts_smooth_objective(p, at, &duration);
    }
    g[mrts_smooth_duration_slot(p)] = p->longest < MRTS_INFINITY ? duration / p->longest - 1 : 0;
    g[mrts_smooth_share_slot(p)] = -at->share;
    if (first) mrts_smooth_first(p, at);
    is.objective += p->relaxed * at->share;
    for (long long i = 0; i < at->slots && p->relaxed > 0; ++i) g[i] -= mrts_smooth_relaxes(p, i) ? at->share : 0;
    mrts_lanes missed = {0}, gap = missed, largest = missed, sum = missed;
    for (long long i = 0; i < at->slots; i += MRTS_LANES) {
        const mrts_lanes s = *mrts_lanes_at(at->s, i), y = *mrts_lanes_at(at->y, i);
        const mrts_lanes its = mrts_choose(y > 0, *mrts_lanes_at(g, i) + s, mrts_each(0));
        *mrts_lanes_at(g, i) = its;
        gap += s * y;
        sum += its;
        missed = mrts_larger_lanes(mrts_sizes(its), missed);
        largest = mrts_larger_lanes(y, largest);
    }
    is.gap = mrts_lane_sum(gap);
    is.missed = mrts_largest_lane(missed) + 0 * mrts_lane_sum(sum); /* what is no number stays */
    is.largest = mrts_largest_lane(largest);
    return is;
}

/* x, u, free: the answer, (n), (n), (n, f). Where the timing is given, x and u are read; F at a held end is read.
 * share: by which limits of changes and jerks are passed, 0 where they are not relaxed.
 * iterations: how many it took.
 * Returns one of the statuses above; without an answer nothing that is written is one. */
MRTS_EXPORT int mrts_smooth_solve(const mrts_smooth_program *p, double *x, double *u, double *free, double *share,
                                  int *iterations, double *work) {
    const long long n = p->nodes, nf = n * p->free;
    mrts_smooth_state at;
    int found = MRTS_SMOOTH_STOPPED, kept = 0;
    mrts_smooth_state_in(p, work, &at);
    mrts_smooth_clear(mrts_smooth_work(p) - (p->again ? mrts_smooth_kept(p) : 0), work);
    mrts_smooth_copy(n, x, at.x);
    mrts_smooth_copy(n, u, at.u);
    if (p->held_start) mrts_smooth_copy(p->free, free, at.free);
    if (p->held_end) mrts_smooth_copy(p->free, free + nf - p->free, at.free + nf - p->free);
    mrts_smooth_tangents(p, &at, p->around);
    mrts_smooth_start(p, &at);
    mrts_smooth_present(p, &at);
    if (p->again) mrts_smooth_take_kept(p, &at);
    for (*iterations = 0; *iterations < MRTS_SMOOTH_MOST; ++*iterations) {
        const mrts_smooth_distance is = mrts_smooth_judge(p, &at, *iterations == 0 && !p->again);
        const double size = is.objective + MRTS_SMALL;
        if (is.missed <= MRTS_SMOOTH_KEPT && is.gap <= MRTS_SMOOTH_GAP * size &&
            *iterations > 0 && mrts_smooth_decrement(p, &at) <= MRTS_SMOOTH_GAP * size) {
            found = MRTS_SMOOTH_FOUND;
            if (!kept) mrts_smooth_keep(p, &at);
            break;
        }
        if (at.present == 0 || !(is.gap < MRTS_INFINITY) || !(is.largest < MRTS_SMOOTH_LARGE)) break;
        if (!kept && p->relaxed <= 0 && is.gap <= MRTS_SMOOTH_CENTRAL * size && is.missed <= MRTS_SMOOTH_CENTRAL) {
            /* of what is relaxed the multipliers of the answer are asked */
            mrts_smooth_keep(p, &at);
            kept = 1;
        }
        if (!(mrts_smooth_advance(p, &at, is.gap, size) > MRTS_SMOOTH_SHORT)) break;
        if (p->moving && is.gap > MRTS_SMOOTH_LAID * size) mrts_smooth_tangents(p, &at, at.x);
    }
    mrts_smooth_copy(n, at.x, x);
    mrts_smooth_copy(n, at.u, u);
    mrts_smooth_copy(nf, at.free, free);
    *share = at.share;
    return found;
}

/* SPDX-License-Identifier: MIT */
#include "interior_point.h"

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
#define MRTS_SMOOTH_LAID 1e-3      /* the gap, of the objective, below which tangents move no more */
#define MRTS_SMOOTH_LONG 0.3       /* a step this long needs no correction */
#define MRTS_SMOOTH_PULLS 2        /* corrections of one step at most */
#define MRTS_SMOOTH_FURTHER 0.3    /* by how much a correction is to lengthen a step */
#define MRTS_SMOOTH_GAIN 0.05      /* by how much it must, or it was the last */
#define MRTS_SMOOTH_OFF 0.1        /* share of the centre that a product may be */
#define MRTS_SMOOTH_ROUNDING 1e-13 /* of a sum, what is left of it where all of it cancels */
#define MRTS_SMOOTH_LEAST 0.1      /* of x: what a step leaves of it at least */

/* The iterates and their steps. */
typedef struct {
    long long slots;           /* of all nodes, and that of the duration */
    int present;               /* slots with a limit */
    double *s, *y;             /* slacks and multipliers, infinity and 0 where there is no limit */
    double *by_s, *weight;     /* 1 / s, 0 where there is no limit, and y / s */
    double *missed, *ds, *dy;  /* g + s, and the steps */
    double *target, *before;   /* multipliers that the right side is made of, and those tried before */
    double *gx, *gu, *gf;      /* the gradient of the objective */
    double *px, *pu, *pf;      /* another one, or a step */
    double *b, *w;             /* unknowns: a right side and its step; the factor's answer to what borders the matrix */
    double *border;            /* unknowns: how the share pulls at them */
    double share;              /* by which limits of changes and jerks are relaxed */
    double share_step;         /* of it */
    double share_pull;         /* the second derivative along it that the border leaves */
    double *factor, *fronts;
    double slack_reach;        /* the longest parts of a step that leave slacks, multipliers and x no less than 0 */
    double dual_reach, x_reach;
    double *kept;              /* an iterate far from the limits: its s, y, F, control points and unit */
} mrts_smooth_iterate;

static long long mrts_smooth_all_slots(const mrts_smooth_program *p) {
    return (long long)p->nodes * mrts_smooth_slots(p) + 2;
}

/* The slots of the duration and of the share. */
static long long mrts_smooth_duration_slot(const mrts_smooth_program *p) {
    return (long long)p->nodes * mrts_smooth_slots(p);
}
static long long mrts_smooth_share_slot(const mrts_smooth_program *p) { return mrts_smooth_duration_slot(p) + 1; }

/* Whether a slot is that of a change or of a jerk. */
static int mrts_smooth_relaxes(const mrts_smooth_program *p, long long slot) {
    return slot < mrts_smooth_duration_slot(p) && slot % mrts_smooth_slots(p) >= mrts_smooth_node_slots(p);
}

MRTS_EXPORT long long mrts_smooth_kept(const mrts_smooth_program *p) {
    return 2 * mrts_smooth_all_slots(p) + (long long)p->nodes * (p->free + 1) + 2;
}

MRTS_EXPORT long long mrts_smooth_work(const mrts_smooth_program *p) {
    const long long n = p->nodes;
    return mrts_smooth_state_size(p) + 9 * mrts_smooth_all_slots(p) + 2 * n * (2 + p->free) +
           3 * mrts_front_unknowns(p) + mrts_front_size(p) + mrts_front_work(p) + mrts_smooth_kept(p);
}

static void mrts_smooth_iterate_in(const mrts_smooth_program *p, double *memory, mrts_smooth_iterate *at) {
    const long long n = p->nodes, nf = n * p->free, slots = mrts_smooth_all_slots(p);
    double **of[] = {&at->s,  &at->y,  &at->by_s,   &at->weight, &at->missed,
                     &at->ds, &at->dy, &at->target, &at->before};
    at->slots = slots;
    for (int i = 0; i < 9; ++i, memory += slots) *of[i] = memory;
    at->gx = memory;
    at->gu = at->gx + n;
    at->gf = at->gu + n;
    at->px = at->gf + nf;
    at->pu = at->px + n;
    at->pf = at->pu + n;
    at->b = at->pf + nf;
    at->w = at->b + mrts_front_unknowns(p);
    at->border = at->w + mrts_front_unknowns(p);
    at->factor = at->border + mrts_front_unknowns(p);
    at->share = 0;
    at->fronts = at->factor + mrts_front_size(p);
    at->kept = at->fronts + mrts_front_work(p);
}

/* Marks the slots that have a limit by multipliers of 1. */
static void mrts_smooth_present(const mrts_smooth_program *p, mrts_smooth_iterate *at) {
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

static void mrts_smooth_clear(long long count, double *a) {
    for (long long i = 0; i < count; ++i) a[i] = 0;
}

static void mrts_smooth_copy(long long count, const double *from, double *to) {
    for (long long i = 0; i < count; ++i) to[i] = from[i];
}

/* g of all slots into `g`, the objective and its gradient; its unit where `first`. */
static double mrts_smooth_evaluate(const mrts_smooth_program *p, mrts_smooth_state *state, mrts_smooth_iterate *at,
                                   int first, double *g) {
    const long long n = p->nodes;
    double duration, objective;
    mrts_smooth_values(p, state, g);
    for (;;) {
        mrts_smooth_clear(n * (2 + p->free), at->gx);
        objective = mrts_smooth_objective(p, state, at->gx, at->gu, at->gf, &duration);
        if (!first || !(objective > 0)) break;
        state->unit = objective;
        first = 0;
    }
    g[mrts_smooth_duration_slot(p)] = p->longest < MRTS_INFINITY ? duration / p->longest - 1 : 0;
    g[mrts_smooth_share_slot(p)] = -at->share;
    return objective;
}

/* The slope of the Lagrangian along the share, with multipliers y. */
static double mrts_smooth_share_slope(const mrts_smooth_program *p, const double *y) {
    const long long last = mrts_smooth_share_slot(p);
    double slope = p->relaxed - y[last];
    for (long long i = 0; i < last; ++i) slope -= mrts_smooth_relaxes(p, i) ? y[i] : 0;
    return slope;
}

/* By how much the slope of the Lagrangian would let it fall: twice what a Newton step with the last factor gains. */
static double mrts_smooth_decrement(const mrts_smooth_program *p, mrts_smooth_state *state, mrts_smooth_iterate *at) {
    const long long n = p->nodes, unknowns = mrts_front_unknowns(p);
    double sum = 0;
    mrts_smooth_copy(n * (2 + p->free), at->gx, at->px);
    mrts_smooth_pulled(p, state, at->y, at->px, at->pu, at->pf);
    mrts_front_gather(p, state, at->px, at->pu, at->pf, at->b);
    mrts_smooth_copy(unknowns, at->b, at->w);
    mrts_front_solve(p, at->factor, at->w);
    for (long long i = 0; i < unknowns; ++i) sum += at->b[i] * at->w[i];
    if (p->relaxed > 0) {
        const double slope = mrts_smooth_share_slope(p, at->y);
        sum += slope * slope / at->share_pull;
    }
    return sum;
}

/* The right side -gradient - sum of target g's gradient, solved for; the step goes to px, pu, pf and ds, dy. */
static void mrts_smooth_newton(const mrts_smooth_program *p, mrts_smooth_state *state, mrts_smooth_iterate *at) {
    const long long n = p->nodes, nf = n * p->free, unknowns = mrts_front_unknowns(p), last = mrts_smooth_duration_slot(p);
    for (long long i = 0; i < 2 * n + nf; ++i) at->px[i] = at->gx[i];
    mrts_smooth_pulled(p, state, at->target, at->px, at->pu, at->pf);
    mrts_front_gather(p, state, at->px, at->pu, at->pf, at->b);
    for (long long i = 0; i < unknowns; ++i) at->b[i] = -at->b[i];
    mrts_front_solve(p, at->factor, at->b);
    double pulled = 0; /* what the duration's slot adds to its multiplier */
    if (at->y[last] > 0) {
        const double by = at->s[last] / at->y[last] * p->longest;
        mrts_front_scatter(p, state, at->b, at->px, at->pu, at->pf);
        const double alone = mrts_dot((int)n, state->duration_x, at->px);
        mrts_front_scatter(p, state, at->w, at->px, at->pu, at->pf);
        const double answered = mrts_dot((int)n, state->duration_x, at->px);
        pulled = alone / (by + answered / p->longest);
        for (long long i = 0; i < unknowns; ++i) at->b[i] -= pulled / p->longest * at->w[i];
    }
    double relaxed = 0; /* the step of the share */
    if (p->relaxed > 0) {
        for (long long i = 0; i < unknowns; ++i) relaxed += at->border[i] * at->b[i];
        relaxed = (relaxed - mrts_smooth_share_slope(p, at->target)) / at->share_pull;
        for (long long i = 0; i < unknowns; ++i) at->b[i] += relaxed * at->w[i];
        at->ds[mrts_smooth_share_slot(p)] = -relaxed;
    }
    at->share_step = relaxed;
    mrts_front_scatter(p, state, at->b, at->px, at->pu, at->pf);
    mrts_smooth_moved(p, state, at->px, at->pu, at->pf, at->ds);
    for (long long i = 0; i < last && relaxed != 0; ++i) at->ds[i] -= mrts_smooth_relaxes(p, i) ? relaxed : 0;
    if (at->y[last] > 0) at->ds[last] = pulled * at->s[last] / at->y[last]; /* its own sum would cancel */
    double most = 1 / MRTS_SMOOTH_BOUNDARY, up = most, x = 1 / (1 - MRTS_SMOOTH_LEAST);
    for (long long i = 0; i < at->slots; ++i) {
        const double moved = at->ds[i], ds = -at->missed[i] - moved;
        const double dy = at->target[i] - at->y[i] + at->weight[i] * moved;
        at->ds[i] = ds;
        at->dy[i] = dy;
        if (-ds * most > at->s[i]) most = -at->s[i] / ds;
        if (-dy * up > at->y[i]) up = -at->y[i] / dy;
    }
    for (long long k = 0; k < n; ++k) {
        if (-at->px[k] * x > state->x[k]) x = -state->x[k] / at->px[k];
    }
    at->slack_reach = most;
    at->dual_reach = up;
    at->x_reach = x;
}

/* The length, at most 1, of a step of the profile that leaves slacks a share of what they are. */
static double mrts_smooth_length(const mrts_smooth_iterate *at, double boundary) {
    const double slack = boundary * at->slack_reach, x = (1 - MRTS_SMOOTH_LEAST) * at->x_reach;
    const double length = slack < x ? slack : x;
    return length < 1 ? length : 1;
}

/* Likewise of multipliers. */
static double mrts_smooth_dual_length(const mrts_smooth_iterate *at, double boundary) {
    return boundary * at->dual_reach < 1 ? boundary * at->dual_reach : 1;
}

/* Answers the duration's slope by the factor, into w. */
static void mrts_smooth_answer_duration(const mrts_smooth_program *p, const mrts_smooth_state *state,
                                        mrts_smooth_iterate *at) {
    const long long n = p->nodes;
    mrts_smooth_clear(n * (1 + p->free), at->pu);
    mrts_front_gather(p, state, state->duration_x, at->pu, at->pf, at->w);
    mrts_front_solve(p, at->factor, at->w);
}

/* Answers what the share pulls at by the factor, into w. */
static void mrts_smooth_answer_share(const mrts_smooth_program *p, mrts_smooth_state *state, mrts_smooth_iterate *at) {
    const long long n = p->nodes, unknowns = mrts_front_unknowns(p), last = mrts_smooth_duration_slot(p);
    double along = at->weight[mrts_smooth_share_slot(p)], answered = 0;
    mrts_smooth_clear(at->slots, at->before);
    for (long long i = 0; i < last; ++i) {
        if (!mrts_smooth_relaxes(p, i)) continue;
        at->before[i] = at->weight[i];
        along += at->weight[i];
    }
    mrts_smooth_clear(n * (2 + p->free), at->px);
    mrts_smooth_pulled(p, state, at->before, at->px, at->pu, at->pf);
    mrts_front_gather(p, state, at->px, at->pu, at->pf, at->border);
    mrts_smooth_copy(unknowns, at->border, at->w);
    mrts_front_solve(p, at->factor, at->w);
    for (long long i = 0; i < unknowns; ++i) answered += at->border[i] * at->w[i];
    at->share_pull = along - answered;
    if (!(at->share_pull > MRTS_SMOOTH_ROUNDING * along)) at->share_pull = MRTS_SMOOTH_ROUNDING * along;
}

/* While a step is short, pulls the products of slacks and multipliers that it would lead far off towards the centre
 * (J. Gondzio, Multiple centrality corrections in a primal-dual method, Computational Optimization and Applications 6,
 * 1996). */
static void mrts_smooth_centralise(const mrts_smooth_program *p, mrts_smooth_state *state, mrts_smooth_iterate *at,
                                   double centre) {
    const double low = MRTS_SMOOTH_OFF * centre, high = centre / MRTS_SMOOTH_OFF;
    double length = mrts_smooth_length(at, 1), dual = mrts_smooth_dual_length(at, 1);
    for (int again = 0; again < MRTS_SMOOTH_PULLS && (length < MRTS_SMOOTH_LONG || dual < MRTS_SMOOTH_LONG); ++again) {
        const double far = length + MRTS_SMOOTH_FURTHER < 1 ? length + MRTS_SMOOTH_FURTHER : 1;
        const double up = dual + MRTS_SMOOTH_FURTHER < 1 ? dual + MRTS_SMOOTH_FURTHER : 1;
        mrts_smooth_copy(at->slots, at->target, at->before);
        for (long long i = 0; i < at->slots; ++i) {
            const double product = (at->s[i] + far * at->ds[i]) * (at->y[i] + up * at->dy[i]);
            const double by = product < low ? low - product : product > high ? high - product : 0;
            at->target[i] += (by < -high ? -high : by) * at->by_s[i];
        }
        mrts_smooth_newton(p, state, at);
        const double longer = mrts_smooth_length(at, 1);
        const double higher = mrts_smooth_dual_length(at, 1);
        if (longer + higher < length + dual + MRTS_SMOOTH_GAIN) {
            if (longer + higher < length + dual) {
                mrts_smooth_copy(at->slots, at->before, at->target);
                mrts_smooth_newton(p, state, at);
            }
            break;
        }
        length = longer;
        dual = higher;
    }
}

/* One iteration from an evaluated point; the length of its step. */
static double mrts_smooth_advance(const mrts_smooth_program *p, mrts_smooth_state *state, mrts_smooth_iterate *at,
                                  double gap, double size) {
    const double mean = gap / at->present;
    for (long long i = 0; i < at->slots; ++i) {
        at->by_s[i] = at->y[i] > 0 ? 1 / at->s[i] : 0;
        at->weight[i] = at->y[i] * at->by_s[i];
        at->target[i] = at->weight[i] * at->missed[i];
    }
    mrts_smooth_second(p, state, at->weight, at->y);
    mrts_front_factor(p, state, at->factor, at->fronts);
    if (at->y[mrts_smooth_duration_slot(p)] > 0) mrts_smooth_answer_duration(p, state, at);
    if (p->relaxed > 0) mrts_smooth_answer_share(p, state, at);
    mrts_smooth_newton(p, state, at);
    double length = mrts_smooth_length(at, 1), dual = mrts_smooth_dual_length(at, 1), left = 0;
    for (long long i = 0; i < at->slots; ++i) left += (at->s[i] + length * at->ds[i]) * (at->y[i] + dual * at->dy[i]);
    const double share = left / gap, least = MRTS_SMOOTH_AIM * size / at->present;
    double centre = share * share * share * mean;
    if (centre < least) centre = least;
    for (long long i = 0; i < at->slots; ++i) at->target[i] += (centre - at->ds[i] * at->dy[i]) * at->by_s[i];
    mrts_smooth_newton(p, state, at);
    mrts_smooth_centralise(p, state, at, centre);
    length = mrts_smooth_length(at, MRTS_SMOOTH_BOUNDARY);
    dual = mrts_smooth_dual_length(at, MRTS_SMOOTH_BOUNDARY);
    for (long long i = 0; i < at->slots; ++i) {
        at->s[i] += length * at->ds[i];
        at->y[i] += dual * at->dy[i];
    }
    at->share += length * at->share_step;
    if (!p->timed) {
        const int n = p->nodes, q = p->free + 1;
        for (int k = 0; k < n; ++k) state->control[k] += length * at->b[(long long)k * q + p->free];
        state->control[n] += length * at->b[(long long)n * q];
        mrts_smooth_profile(p, state);
    }
    for (long long i = 0; i < (long long)p->nodes * p->free; ++i) state->free[i] += length * at->pf[i];
    return length;
}

/* Keeps the iterate for a program that is near. */
static void mrts_smooth_keep(const mrts_smooth_program *p, const mrts_smooth_state *state, mrts_smooth_iterate *at) {
    const double *of[] = {at->s, at->y, state->free, state->control, &state->unit};
    const long long counts[] = {at->slots, at->slots, (long long)p->nodes * p->free, p->nodes + 1, 1};
    double *kept = at->kept;
    for (int i = 0; i < 5; kept += counts[i++]) mrts_smooth_copy(counts[i], of[i], kept);
}

/* Takes the iterate that was kept of a program that is near, but what is given; a slot that had no limit there begins at
 * the centre. */
static void mrts_smooth_take_kept(const mrts_smooth_program *p, mrts_smooth_state *state, mrts_smooth_iterate *at) {
    const double *s = at->kept, *y = s + at->slots, *free = y + at->slots, *control = free + (long long)p->nodes * p->free;
    double gap = 0;
    int both = 0;
    for (long long i = 0; i < at->slots; ++i) {
        if (!(at->y[i] > 0 && y[i] > 0)) continue;
        gap += s[i] * y[i];
        ++both;
    }
    for (long long i = 0; i < at->slots; ++i) {
        const int is = at->y[i] > 0, was = y[i] > 0;
        at->s[i] = !is ? MRTS_INFINITY : was ? s[i] : MRTS_SMOOTH_SLACK;
        at->y[i] = !is ? 0 : was ? y[i] : gap / (both * MRTS_SMOOTH_SLACK);
    }
    const int held = p->held_start * p->free;
    mrts_smooth_copy((long long)(p->nodes - p->held_end) * p->free - held, free + held, state->free + held);
    mrts_smooth_copy(p->nodes + 1 - p->given_start - p->given_end, control + p->given_start,
                     state->control + p->given_start);
    state->unit = control[p->nodes + 1];
    mrts_smooth_profile(p, state);
}

/* Slacks and multipliers to start with, and a share that leaves room to all that it relaxes. */
static void mrts_smooth_first(const mrts_smooth_program *p, mrts_smooth_iterate *at, double *g) {
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

/* How far an iterate is from an answer. */
typedef struct {
    double objective, missed, gap, largest; /* of a constraint, of the objective, of multipliers */
} mrts_smooth_distance;

/* Evaluates the iterate; where `first`, also the unit of the objective, slacks and multipliers. */
static mrts_smooth_distance mrts_smooth_judge(const mrts_smooth_program *p, mrts_smooth_state *state,
                                              mrts_smooth_iterate *at, int first) {
    mrts_smooth_distance is = {mrts_smooth_evaluate(p, state, at, first, at->missed), 0, 0, 0};
    if (first) mrts_smooth_first(p, at, at->missed);
    is.objective += p->relaxed * at->share;
    for (long long i = 0; i < at->slots; ++i) {
        if (mrts_smooth_relaxes(p, i)) at->missed[i] -= at->share;
        at->missed[i] = at->y[i] > 0 ? at->missed[i] + at->s[i] : 0;
        is.gap += at->s[i] * at->y[i];
        const double missed = MRTS_ABS(at->missed[i]);
        if (is.missed == is.missed && !(missed <= is.missed)) is.missed = missed; /* what is no number stays */
        if (at->y[i] > is.largest) is.largest = at->y[i];
    }
    return is;
}

MRTS_EXPORT int mrts_smooth_solve(const mrts_smooth_program *p, double *x, double *u, double *free, double *share,
                                  int *iterations, double *work) {
    const long long n = p->nodes, nf = n * p->free;
    mrts_smooth_state state;
    mrts_smooth_iterate at;
    int found = MRTS_SMOOTH_STOPPED, kept = 0;
    mrts_smooth_state_in(p, work, &state);
    mrts_smooth_iterate_in(p, work + mrts_smooth_state_size(p), &at);
    mrts_smooth_clear(mrts_smooth_work(p) - (p->again ? mrts_smooth_kept(p) : 0), work);
    mrts_smooth_copy(n, x, state.x);
    mrts_smooth_copy(n, u, state.u);
    if (p->held_start) mrts_smooth_copy(p->free, free, state.free);
    if (p->held_end) mrts_smooth_copy(p->free, free + nf - p->free, state.free + nf - p->free);
    mrts_smooth_tangents(p, &state, p->around);
    mrts_smooth_start(p, &state);
    mrts_smooth_present(p, &at);
    if (p->again) mrts_smooth_take_kept(p, &state, &at);
    for (*iterations = 0; *iterations < MRTS_SMOOTH_MOST; ++*iterations) {
        const mrts_smooth_distance is = mrts_smooth_judge(p, &state, &at, *iterations == 0 && !p->again);
        const double size = is.objective + MRTS_SMALL;
        if (is.missed <= MRTS_SMOOTH_KEPT && is.gap <= MRTS_SMOOTH_GAP * size &&
            *iterations > 0 && mrts_smooth_decrement(p, &state, &at) <= MRTS_SMOOTH_GAP * size) {
            found = MRTS_SMOOTH_FOUND;
            if (!kept) mrts_smooth_keep(p, &state, &at);
            break;
        }
        if (at.present == 0 || !(is.gap < MRTS_INFINITY) || !(is.largest < MRTS_SMOOTH_LARGE)) break;
        if (!kept && !p->timed && is.gap <= MRTS_SMOOTH_CENTRAL * size && is.missed <= MRTS_SMOOTH_CENTRAL) {
            mrts_smooth_keep(p, &state, &at);
            kept = 1;
        }
        if (!(mrts_smooth_advance(p, &state, &at, is.gap, size) > MRTS_SMOOTH_SHORT)) break;
        if (p->moving && is.gap > MRTS_SMOOTH_LAID * size) mrts_smooth_tangents(p, &state, state.x);
    }
    mrts_smooth_copy(n, state.x, x);
    mrts_smooth_copy(n, state.u, u);
    mrts_smooth_copy(nf, state.free, free);
    *share = at.share;
    return found;
}

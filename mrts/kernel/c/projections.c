/* SPDX-License-Identifier: MIT
 *
 * The projection of a polytope onto its last two unknowns, u and x, from inside: its corners are projections of points that
 * keep all limits, so whatever is a mixture of them is feasible. They are counter-clockwise in the plane (u, x). Each is
 * given by k rows at a limit, the basis, as mrts_lp codes it. */
#include "lanes/lane_types.h"
#include "linear_programs.h"

/* An edge is final if nothing lies further out than this, in units of the limits and of the corners' size. */
#define MRTS_OUTSIDE 1e-9

/* Most corners of one projection; a polygon with more is replaced by one inside it. */
#define MRTS_CORNERS 64

/* { z : lower <= (A z, z) <= upper }, limits of the rows and then of the k unknowns, as a program of mrts_lp has them. */
typedef struct {
    int k, rows;
    double *A, *lower, *upper; /* (rows, k), (rows + k) */
} mrts_polytope;

#define MRTS_POLYTOPE_WORK(k, rows) ((rows) * (k) + 2 * ((rows) + (k)))

/* A projection's corners with their bases, from which the next projection starts; none for a cold start. */
typedef struct {
    int count;
    int *basis;       /* (MRTS_CORNERS, k) */
    const double *at; /* (MRTS_CORNERS, 2) */
} mrts_outline;

#define MRTS_OUTLINE_IWORK(k) (MRTS_CORNERS * (k))

/* The corners, started from an outline, which becomes that of this projection; a status of mrts_lp. */
#define MRTS_PROJECT_WORK(k) (MRTS_LP_WORK(k) + 3 * (k) + (MRTS_CORNERS + 1) * (2 + 2 * (k)))
#define MRTS_PROJECT_IWORK(k, rows) (MRTS_LP_IWORK(k, rows) + (MRTS_CORNERS + 1) * (k))

/* Corners are found by linear programs: outward of every edge, until nothing lies outside. */

/* A corner, with the rows that determine it and how their multipliers depend on the direction (du, dx). */
typedef struct {
    double *at;   /* u, x */
    double *rate; /* of du and of dx, (2, k) */
    int *basis;
} mrts_corner;

/* Where the corners of a polygon are, linked counter-clockwise, and work of their programs. */
typedef struct {
    int k, count;
    double *places;
    int *bases;
    int next[MRTS_CORNERS];
    double *work;
    int *iwork;
} mrts_polygon;

static mrts_corner mrts_corner_at(const mrts_polygon *of, int n) {
    double *place = of->places + n * (2 + 2 * of->k);
    const mrts_corner corner = {place, place + 2, of->bases + n * of->k};
    return corner;
}

static double mrts_corner_size(const double *p) { return 1 + MRTS_ABS(p[0]) + MRTS_ABS(p[1]); }

static int mrts_same_corner(const double *p, const double *q) {
    return MRTS_ABS(p[0] - q[0]) + MRTS_ABS(p[1] - q[1]) <= MRTS_OUTSIDE * mrts_corner_size(p);
}

/* The basis of the corner of an outline that lies furthest in a direction, or another where there is none. */
static const int *mrts_towards(int k, const mrts_outline *outline, const double *direction, const int *other) {
    double most = -MRTS_INFINITY;
    for (int i = 0; i < outline->count; ++i) {
        const double along = direction[0] * outline->at[2 * i] + direction[1] * outline->at[2 * i + 1];
        if (!(along > most)) continue;
        most = along;
        other = outline->basis + i * k;
    }
    return other;
}

/* The corner that lies furthest in a direction, by a linear program from the basis that it holds (basis[0] == 0: cold);
 * a status of mrts_lp. */
static int mrts_furthest(const mrts_polytope *in, const mrts_polygon *of, const double *direction, mrts_corner corner) {
    const int k = in->k;
    double *g = of->work, *z = g + k, *y = z + k, *inverse = y + k; /* mrts_lp leaves its columns there */
    int entering, status = MRTS_STOPPED;
    double unused;
    for (int j = 0; j < k; ++j) g[j] = 0;
    g[k - 2] = -direction[0];
    g[k - 1] = -direction[1];
    for (int attempt = 0; attempt < 2; ++attempt) {
        const int cold = corner.basis[0] == 0;
        status = mrts_lp(k, in->rows, in->A, in->lower, in->upper, g, corner.basis, z, y, &entering, inverse, of->iwork);
        if (status == MRTS_OPTIMAL || cold) break;
        corner.basis[0] = 0;
    }
    /* rows that are alike but for rounding leave multipliers of either sign: nearly the furthest is good enough */
    for (int row = 0; row < in->rows + k; ++row) of->iwork[row] = 0;
    if (status == MRTS_STOPPED && !mrts_lp_price(k, in->rows, in->A, in->lower, in->upper, z, of->iwork, 0, &unused)) {
        status = MRTS_OPTIMAL;
    }
    if (status != MRTS_OPTIMAL) corner.basis[0] = 0;
    corner.at[0] = z[k - 2];
    corner.at[1] = z[k - 1];
    for (int j = 0; j < k; ++j) {
        corner.rate[j] = -inverse[j * k + k - 2];
        corner.rate[k + j] = -inverse[j * k + k - 1];
    }
    return status;
}

/* Whether the multipliers of a corner show that nothing lies further out in a direction: they have the signs of limits that
 * there are (a free unknown of a basis has none), and make it up of the rows as given. */
static int mrts_is_furthest(const mrts_polytope *in, const mrts_polygon *of, mrts_corner corner, const double *direction) {
    const int k = in->k;
    double *y = of->work, *rest = y + k, size = 1;
    for (int j = 0; j < k; ++j) {
        y[j] = direction[0] * corner.rate[j] + direction[1] * corner.rate[k + j];
        size = mrts_larger(MRTS_ABS(y[j]), size);
        rest[j] = 0;
    }
    rest[k - 2] = direction[0];
    rest[k - 1] = direction[1];
    for (int j = 0; j < k; ++j) {
        const int code = corner.basis[j], row = mrts_abs(code) - 1;
        if (code < 0 ? y[j] > 0 && in->lower[row] > -MRTS_INFINITY : y[j] < 0 && in->upper[row] < MRTS_INFINITY) continue;
        if (MRTS_ABS(y[j]) > MRTS_OUTSIDE / 10 * size && in->lower[row] != in->upper[row]) return 0;
    }
    for (int j = 0; j < k; ++j) {
        const int row = mrts_abs(corner.basis[j]) - 1, terms = row < in->rows ? k : 0;
        MRTS_UNROLL
        for (int i = 0; i < terms; ++i) rest[i] += y[j] * in->A[row * k + i];
        if (row >= in->rows) rest[row - in->rows] += y[j];
    }
    for (int i = 0; i < k; ++i) {
        if (!(MRTS_ABS(rest[i]) <= MRTS_FEASIBLE * size)) return 0;
    }
    return 1;
}

/* Whether nothing lies outside of the edge from a corner to the next, whose unit normal, outward, it becomes. */
static int mrts_is_final(const mrts_polytope *in, const mrts_polygon *of, int at, double *normal) {
    const mrts_corner p = mrts_corner_at(of, at), q = mrts_corner_at(of, of->next[at]);
    normal[0] = q.at[1] - p.at[1];
    normal[1] = p.at[0] - q.at[0];
    const double length = MRTS_SQRT(normal[0] * normal[0] + normal[1] * normal[1]);
    if (!(length > 0)) return 1;
    normal[0] /= length;
    normal[1] /= length;
    return mrts_is_furthest(in, of, p, normal) || mrts_is_furthest(in, of, q, normal);
}

/* The corners furthest along the axes, started from those of an outline (none: cold); a status of mrts_lp. */
static int mrts_axis_corners(const mrts_polytope *in, const mrts_outline *outline, mrts_polygon *found) {
    static const double axes[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    for (int d = 0; d < 4; ++d) {
        const int n = found->count;
        const mrts_corner corner = mrts_corner_at(found, n), before = mrts_corner_at(found, n > 0 ? n - 1 : 0);
        if (n > 0 && mrts_is_furthest(in, found, before, axes[d])) continue;
        const int *start = mrts_towards(in->k, outline, axes[d], n > 0 ? before.basis : outline->basis);
        for (int j = 0; j < in->k; ++j) corner.basis[j] = start[j];
        const int status = mrts_furthest(in, found, axes[d], corner);
        if (status != MRTS_OPTIMAL) return status;
        if (n > 0 && mrts_same_corner(corner.at, before.at)) continue;
        if (n > 0) found->next[n - 1] = n;
        found->next[n] = 0;
        ++found->count;
    }
    const int last = found->count - 1; /* which may be the first */
    if (last > 0 && mrts_same_corner(mrts_corner_at(found, last).at, found->places)) {
        found->next[last - 1] = 0;
        --found->count;
    }
    return MRTS_OPTIMAL;
}

/* Corners outward of the edges, started from those of an outline, until nothing lies outside; a status of mrts_lp. */
static int mrts_close(const mrts_polytope *in, const mrts_outline *outline, mrts_polygon *of) {
    int at = 0;
    while (of->count > 1) {
        double normal[2];
        if (of->count < MRTS_CORNERS && !mrts_is_final(in, of, at, normal)) {
            const mrts_corner p = mrts_corner_at(of, at), q = mrts_corner_at(of, of->next[at]);
            const mrts_corner r = mrts_corner_at(of, of->count);
            const int *start = mrts_towards(in->k, outline, normal, p.basis);
            for (int j = 0; j < in->k; ++j) r.basis[j] = start[j];
            const int status = mrts_furthest(in, of, normal, r);
            if (status != MRTS_OPTIMAL) return status;
            const double beyond = normal[0] * (r.at[0] - p.at[0]) + normal[1] * (r.at[1] - p.at[1]);
            if (beyond > MRTS_OUTSIDE * mrts_corner_size(p.at) && !mrts_same_corner(r.at, p.at) &&
                !mrts_same_corner(r.at, q.at)) {
                of->next[of->count] = of->next[at];
                of->next[at] = of->count++;
                continue;
            }
        }
        at = of->next[at];
        if (at == 0) break;
    }
    return MRTS_OPTIMAL;
}

static int mrts_project(const mrts_polytope *in, mrts_outline *outline, int *count, double *corners, double *work,
                        int *iwork) {
    const int k = in->k;
    mrts_polygon found = {.k = k, .work = work, .iwork = iwork};
    found.places = work + MRTS_LP_WORK(k) + 3 * k;
    found.bases = iwork + MRTS_LP_IWORK(k, in->rows);
    if (outline->count == 0) outline->basis[0] = 0;
    int status = mrts_axis_corners(in, outline, &found);
    if (status == MRTS_OPTIMAL) status = mrts_close(in, outline, &found);
    outline->count = status == MRTS_OPTIMAL ? found.count : 0;
    *count = outline->count;
    for (int i = 0, at = 0; i < outline->count; ++i, at = found.next[at]) {
        const mrts_corner corner = mrts_corner_at(&found, at);
        corners[2 * i] = corner.at[0];
        corners[2 * i + 1] = corner.at[1];
        for (int j = 0; j < k; ++j) outline->basis[i * k + j] = corner.basis[j];
    }
    outline->at = corners;
    return status;
}

/* Corners of several samples that share their bases: each is solved for, and checked when all rows are put in. */

/* Polytopes one after the other: rows which[0 .. rows - 1] of `all` rows of A, Shape (count, all, k), whose columns are
 * multiplied by scale, Shape (count, k), and bounds of u and x, the last two of the k unknowns, Shape (count, 2) each. */
typedef struct {
    long long count;
    int k, all, rows;
    const int *which;
    const double *A, *lower, *upper, *scale, *least, *most;
} mrts_polytopes;

/* Those of some samples side by side, and what is known of their corners. */
typedef struct {
    const mrts_polytopes *of;
    mrts_lanes *A, *lower, *upper; /* (rows + k, k), a row of each unknown last, and (rows + k) */
    mrts_lanes *corner;  /* of each corner u, x, and of u and of x what rows of the basis weigh in it, (MRTS_CORNERS, 2 + 2 k) */
    int *held;           /* a basis, (k) */
    mrts_lanes *rows_held, *less_limit, *inverse; /* its rows, (k, k), their limits, negative, and the rows' inverse */
    mrts_lanes *work;    /* (k) */
} mrts_lane_polytopes;

#define MRTS_LANE_CORNER(k) (2 + 2 * (k))
#define MRTS_LANE_POLYTOPES_WORK(k, rows) \
    (MRTS_LANES * (((rows) + (k)) * ((k) + 2) + MRTS_CORNERS * MRTS_LANE_CORNER(k) + 2 * (k) * ((k) + 1)))

/* Takes the samples from `first` on; beyond the last the last is repeated. */
static void mrts_take_polytopes(long long first, mrts_lane_polytopes *in) {
    const mrts_polytopes *of = in->of;
    const int k = of->k, rows = of->rows;
    long long at[MRTS_LANES];
    for (int lane = 0; lane < MRTS_LANES; ++lane) at[lane] = first + lane < of->count ? first + lane : of->count - 1;
    for (int j = 0; j < k; ++j) {
        in->work[j] = mrts_term(of->scale, at, k, j);
        in->lower[rows + j] = j < k - 2 ? mrts_each(-MRTS_INFINITY) : mrts_term(of->least, at, 2, j - (k - 2));
        in->upper[rows + j] = j < k - 2 ? mrts_each(MRTS_INFINITY) : mrts_term(of->most, at, 2, j - (k - 2));
    }
    for (int i = 0; i < rows; ++i) {
        const int row = of->which[i];
        for (int j = 0; j < k; ++j) in->A[i * k + j] = mrts_term(of->A, at, of->all * k, row * k + j) * in->work[j];
        in->lower[i] = mrts_larger_lanes(mrts_term(of->lower, at, of->all, row), mrts_each(-MRTS_INFINITY));
        in->upper[i] = -mrts_larger_lanes(-mrts_term(of->upper, at, of->all, row), mrts_each(-MRTS_INFINITY));
    }
}

/* Puts a row, at a limit, or free and so at 0, to a place of the basis that is held. */
static void mrts_hold_row(const mrts_lane_polytopes *in, int place, int code) {
    const int k = in->of->k;
    const mrts_lanes *row = in->A + (mrts_abs(code) - 1) * k, limit = code < 0 ? in->lower[-code - 1] : in->upper[code - 1];
    for (int i = 0; i < k; ++i) in->rows_held[place * k + i] = row[i];
    in->held[place] = code;
    in->less_limit[place] = mrts_choose(mrts_sizes(limit) < MRTS_INFINITY, -limit, mrts_each(0));
}

/* Makes the inverse of the rows that are held that of a basis, which comes into their order: each row that is not held takes the
 * place that has none of the basis yet where it moves the first sample most. */
static void mrts_hold_basis(const mrts_lane_polytopes *in, int *basis) {
    const int k = in->of->k, *held = in->held;
    mrts_lanes *less = in->work; /* what the row is of those that are held, negative */
    for (int n = 0, q = 0; n < k; n = q > n ? n : n + 1) {
        const int code = basis[q = n];
        while (held[n] != code && q < k && mrts_abs(held[q]) != mrts_abs(code)) ++q;
        if (held[n] == code) continue;
        if (q == k) {
            q = n;
            for (int j = 0; j < k; ++j) {
                less[j] = mrts_less_lanes(k, mrts_each(0), in->inverse + j, k, in->A + (mrts_abs(code) - 1) * k);
                if (j > n && held[j] != basis[j] && MRTS_ABS(less[j][0]) > MRTS_ABS(less[q][0])) q = j;
            }
            const mrts_lanes factor = -1 / less[q];
            less[q] = mrts_each(0);
            for (mrts_lanes *row = in->inverse, *end = row + k * k; row < end; row += k) {
                const mrts_lanes its = row[q] *= factor;
                MRTS_UNROLL
                for (int j = 0; j < k; ++j) row[j] += less[j] * its;
            }
        }
        basis[n] = basis[q];
        basis[q] = code;
        mrts_hold_row(in, q, code);
    }
}

/* The corner of the basis that is held, and of which samples it is one: a point that keeps all limits, of which u and x are made
 * up of the rows of the basis by their weights. */
static mrts_lane_mask mrts_lane_corner(const mrts_lane_polytopes *in, mrts_lanes *corner) {
    const int k = in->of->k;
    const mrts_lanes none = mrts_each(0), one = mrts_each(1), *of_u = in->inverse + (k - 2) * k;
    mrts_lanes *z = in->work;
    for (int i = 0; i < k; ++i) z[i] = mrts_less_lanes(k, none, in->inverse + i * k, 1, in->less_limit);
    for (int i = 0; i < 2; ++i) corner[i] = z[k - 2 + i];
    for (int n = 0; n < 2 * k; ++n) corner[2 + n] = of_u[n]; /* of x too */
    mrts_lane_mask right = mrts_kept_feasible_lanes(k, in->of->rows, in->A, in->lower, in->upper, z);
    for (int j = 0; j < k; ++j) {
        const mrts_lanes rest_u = mrts_less_lanes(k, j == k - 2 ? one : none, in->rows_held + j, k, of_u);
        const mrts_lanes rest_x = mrts_less_lanes(k, j == k - 1 ? one : none, in->rows_held + j, k, of_u + k);
        right &= (mrts_sizes(rest_u) <= MRTS_FEASIBLE) & (mrts_sizes(rest_x) <= MRTS_FEASIBLE);
    }
    return right;
}

/* Whether the multipliers of a direction have the signs of limits that there are. */
static mrts_lane_mask mrts_corner_signs(const mrts_lane_polytopes *in, const int *bases, int at, const mrts_lanes *direction) {
    const int k = in->of->k, *basis = bases + at * k;
    const mrts_lanes *of_u = in->corner + at * MRTS_LANE_CORNER(k) + 2, *of_x = of_u + k;
    mrts_lanes *y = in->work, size = mrts_each(1);
    mrts_lane_mask right = MRTS_EVERY_LANE;
    for (int n = 0; n < k; ++n) {
        y[n] = direction[0] * of_u[n] + direction[1] * of_x[n];
        size = mrts_larger_lanes(mrts_sizes(y[n]), size);
    }
    size *= MRTS_OUTSIDE / 10;
    for (int n = 0; n < k; ++n) {
        const int code = basis[n], row = mrts_abs(code) - 1;
        const mrts_lanes low = in->lower[row], high = in->upper[row];
        const mrts_lane_mask limited = code < 0 ? low > -MRTS_INFINITY : high < MRTS_INFINITY;
        const mrts_lanes wrong = mrts_choose(limited, code < 0 ? y[n] : -y[n], mrts_sizes(y[n]));
        right &= (wrong <= size) | (high <= low);
    }
    return right;
}

/* Whether nothing lies outside of the edge from a corner to the next; they are not the same. */
static mrts_lane_mask mrts_edge_is_final(const mrts_lane_polytopes *in, const int *bases, int at, int next) {
    const int k = in->of->k;
    const mrts_lanes *p = in->corner + at * MRTS_LANE_CORNER(k), *q = in->corner + next * MRTS_LANE_CORNER(k);
    mrts_lanes normal[2] = {q[1] - p[1], p[0] - q[0]};
    const mrts_lanes length = mrts_roots(normal[0] * normal[0] + normal[1] * normal[1]);
    const mrts_lanes apart = mrts_sizes(normal[0]) + mrts_sizes(normal[1]);
    normal[0] /= length;
    normal[1] /= length;
    const mrts_lane_mask differ = apart > MRTS_OUTSIDE * (1 + mrts_sizes(p[0]) + mrts_sizes(p[1]));
    mrts_lane_mask final = mrts_corner_signs(in, bases, at, normal);
    if (!(final[0] & final[1] & final[2] & final[3])) final |= mrts_corner_signs(in, bases, next, normal);
    return differ & final;
}

/* Of which samples the bases of an outline are all corners: each is verified as a corner of mrts_project, and each edge. The
 * inverse of one becomes that of the next, which mostly has one other row: each basis comes into that order. */
static mrts_lane_mask mrts_known_outline(const mrts_lane_polytopes *in, const mrts_outline *outline) {
    const int k = in->of->k, count = outline->count;
    mrts_lane_mask known = MRTS_EVERY_LANE;
    for (int i = 0; i < k * k; ++i) in->inverse[i] = in->A[in->of->rows * k + i];
    for (int j = 0; j < k; ++j) mrts_hold_row(in, j, in->of->rows + 1 + j);
    for (int at = 0; at < count && mrts_any(known); ++at) {
        mrts_hold_basis(in, outline->basis + at * k);
        known &= mrts_lane_corner(in, in->corner + at * MRTS_LANE_CORNER(k));
    }
    for (int at = 0; at < count && mrts_any(known); ++at) known &= mrts_edge_is_final(in, outline->basis, at, (at + 1) % count);
    return known;
}

/* Projections end where u or x moves some row by this many limits; what reaches that far counts as unbounded. */
#define MRTS_BOX 1e5

/* Share of such an end from which a corner lies on it: rounding. */
#define MRTS_NEAR (1 - 1e-6)

/* The half-planes n_u u + n_x x <= h of samples: both sides of rows which[0 .. alone - 1], of u and x alone,
 * and the edges of their projections, number[n] corners (u, x) of each in a row, counter-clockwise, that are not
 * those of |u| <= MRTS_BOX or x <= most; of a point or a segment what bounds it along itself. `bound` and scale are those of
 * mrts_scales. Those of sample n are start[n] .. start[n + 1] - 1 of `planes`. Least
 * and largest x of each too. */
MRTS_EXPORT void mrts_half_planes(long long count, int k, int all, int alone, const int *which, const double *A,
                                  const double *lower, const double *upper, const double *scale, const int *number,
                                  const double *corners, const double *most, double bound, long long *start,
                                  double *planes, double *low, double *high) {
    double *next = planes;
    for (long long n = 0; n < count; corners += 2 * number[n++]) {
        const double *unit = scale + n * k + k - 2, per_u = unit[0] > 0 ? 1 / unit[0] : 0, per_x = unit[1] > 0 ? 1 / unit[1] : 0;
        const double farthest = bound * per_x < MRTS_BOX ? bound * per_x : MRTS_BOX;
        const double cap = most[n] * per_x < farthest ? most[n] * per_x : farthest;
        double least_u = INFINITY, most_u = -INFINITY, least_x = INFINITY, most_x = -INFINITY;
        start[n] = (next - planes) / 3;
        for (int i = 0; i < 2 * alone; ++i) {
            const int row = which[i / 2];
            const double sign = i % 2 ? -1 : 1, limit = i % 2 ? -lower[n * all + row] : upper[n * all + row];
            if (limit == INFINITY) continue;
            next[0] = per_u > 0 ? sign * A[(n * all + row) * k + k - 2] : 0;
            next[1] = per_x > 0 ? sign * A[(n * all + row) * k + k - 1] : 0;
            next[2] = limit;
            next += 3;
        }
        for (int i = 0; i < number[n]; ++i) {
            const double *here = corners + 2 * i, *after = corners + 2 * ((i + 1) % number[n]);
            const double along_u = after[0] - here[0], along_x = after[1] - here[1];
            const double length = MRTS_SQRT(along_u * along_u + along_x * along_x);
            const double inner = here[1] < after[1] ? here[1] : after[1], outer = here[1] < after[1] ? after[1] : here[1];
            if (here[0] < least_u) least_u = here[0];
            if (here[0] > most_u) most_u = here[0];
            if (here[1] < least_x) least_x = here[1];
            if (here[1] > most_x) most_x = here[1];
            if (!(length > 0) || (MRTS_ABS(here[0]) >= MRTS_NEAR * MRTS_BOX && MRTS_ABS(after[0]) >= MRTS_NEAR * MRTS_BOX)) continue;
            if (inner >= MRTS_NEAR * cap || outer <= 1 / (MRTS_BOX * MRTS_BOX)) continue;
            next[0] = along_x / length * per_u;
            next[1] = -along_u / length * per_x;
            next[2] = (along_x * here[0] - along_u * here[1]) / length;
            next += 3;
        }
        low[n] = least_x > 0 && number[n] > 0 ? least_x * unit[1] : 0;
        high[n] = per_x > 0 && most_x < MRTS_NEAR * farthest && number[n] > 0 ? most_x * unit[1] : INFINITY;
        if (most[n] < high[n]) high[n] = most[n];
        if (number[n] < 1 || number[n] > 2 || !(per_u > 0)) continue;
        next[0] = per_u;
        next[3] = -per_u;
        next[1] = next[4] = 0;
        next[2] = most_u;
        next[5] = -least_u;
        next += 6;
    }
    start[count] = (next - planes) / 3;
}

MRTS_EXPORT void mrts_project_batch_work(int k, int rows, long long *reals, long long *ints) {
    *reals = MRTS_POLYTOPE_WORK(k, rows) + MRTS_PROJECT_WORK(k) + MRTS_LANE_POLYTOPES_WORK(k, rows);
    *ints = MRTS_OUTLINE_IWORK(k) + MRTS_PROJECT_IWORK(k, rows) + k;
}

/* `count` projections of { z : lower <= A z <= upper, least <= (u, x) <= most }, see mrts_polytopes. Each starts from the one
 * before, the first of a chunk cold. The corners of all are in a row. */
MRTS_EXPORT void mrts_project_batch(long long count, int k, int all, int rows, const int *which, const double *A,
                                    const double *lower, const double *upper, const double *scale, const double *least,
                                    const double *most, int *corner_count, double *corners, unsigned char *status,
                                    double *work, int *iwork) {
    const mrts_polytopes of = {count, k, all, rows, which, A, lower, upper, scale, least, most};
    double *project_work = work + MRTS_POLYTOPE_WORK(k, rows);
    mrts_outline outline = {0, iwork, corners};
    int *project_iwork = outline.basis + MRTS_OUTLINE_IWORK(k);
    const mrts_polytope in = {k, rows, work, work + rows * k, work + rows * k + rows + k};
    mrts_lane_polytopes lanes = {.of = &of, .A = (mrts_lanes *)(void *)(project_work + MRTS_PROJECT_WORK(k))};
    for (int i = 0; i < k * k; ++i) lanes.A[rows * k + i] = mrts_each(i % (k + 1) == 0);
    lanes.lower = lanes.A + (rows + k) * k;
    lanes.upper = lanes.lower + rows + k;
    lanes.corner = lanes.upper + rows + k;
    lanes.rows_held = lanes.corner + MRTS_CORNERS * MRTS_LANE_CORNER(k);
    lanes.inverse = lanes.rows_held + k * k;
    lanes.less_limit = lanes.inverse + k * k;
    lanes.work = lanes.less_limit + k;
    lanes.held = project_iwork + MRTS_PROJECT_IWORK(k, rows);
    const mrts_lane_mask none = {0};
    mrts_lane_mask known = none;
    for (long long n = 0; n < count; corners += 2 * corner_count[n++]) {
        const int lane = (int)(n % MRTS_LANES);
        if (lane == 0) {
            mrts_take_polytopes(n, &lanes);
            known = outline.count > 2 ? mrts_known_outline(&lanes, &outline) : none;
        }
        if (known[lane]) {
            for (int i = 0; i < outline.count; ++i) {
                mrts_take_lane(2, lanes.corner + i * MRTS_LANE_CORNER(k), lane, corners + 2 * i);
            }
            outline.at = corners;
            corner_count[n] = outline.count;
            status[n] = MRTS_OPTIMAL;
            continue;
        }
        mrts_take_lane(rows * k, lanes.A, lane, in.A);
        mrts_take_lane(rows + k, lanes.lower, lane, in.lower);
        mrts_take_lane(rows + k, lanes.upper, lane, in.upper);
        for (int attempt = 0; attempt < 2; ++attempt) {
            const int cold = outline.count == 0;
            corner_count[n] = 0;
            status[n] = (unsigned char)mrts_project(&in, &outline, corner_count + n, corners, project_work, project_iwork);
            if (status[n] == MRTS_OPTIMAL || status[n] == MRTS_INFEASIBLE || cold) break;
        }
        known = lane + 1 < MRTS_LANES && outline.count > 2 ? mrts_known_outline(&lanes, &outline) : none; /* beside this one */
    }
}

/* Speeds squared above this multiple of what the path's length and its accelerations make likely count as unbounded. */
#define MRTS_FARTHEST 1e3

/* u has no effect where it moves no row by more than this share of what it does elsewhere: rounding. */
#define MRTS_AT_REST 1e-12

/* x has none where the largest likely one moves no row by more than this share of a limit: on a straight path what is left of
 * it is rounding. */
#define MRTS_NEGLIGIBLE 1e-11

/* Samples whose accelerations are looked at, to learn how fast the path may become. */
#define MRTS_PROBES 3

/* The median of the largest |u| of some samples at rest, each at least that of a whole limit: some leave none. 0 where u moves
 * nothing. Arguments as of mrts_project_batch. */
static double mrts_likely_rate(long long count, int k, int all, int rows, const int *which, const double *A,
                               const double *lower, const double *upper, const double *scale, double *work, int *iwork) {
    const double least[2] = {-MRTS_BOX, 0}, most[2] = {MRTS_BOX, 0};
    double likely[MRTS_PROBES] = {0}, corners[2 * MRTS_CORNERS];
    long long moving = 0;
    for (long long n = 0; n < count; ++n) moving += scale[n * k + k - 2] > 0;
    for (int probe = 0; probe < MRTS_PROBES && moving > 0; ++probe) {
        long long n = -1;
        for (long long left = probe * (moving - 1) / (MRTS_PROBES - 1); left >= 0; left -= scale[n * k + k - 2] > 0) ++n;
        int number, at = probe;
        unsigned char status;
        mrts_project_batch(1, k, all, rows, which, A + n * all * k, lower + n * all, upper + n * all, scale + n * k, least,
                           most, &number, corners, &status, work, iwork);
        double largest = 1;
        for (int i = 0; i < number; ++i) largest = mrts_larger(MRTS_ABS(corners[2 * i]), largest);
        largest *= scale[n * k + k - 2];
        for (; at > 0 && likely[at - 1] > largest; --at) likely[at] = likely[at - 1];
        likely[at] = largest;
    }
    return likely[MRTS_PROBES / 2];
}

/* What columns of rows which[0 .. rows - 1] are multiplied by, so that each moves some row by a limit at most, Shape (count, k):
 * 0 of what moves none. x is counted in what may be reached on a path of some length with some largest x at its ends, if that is
 * less; `bound`, an x that none reaches, is found where it is 0. And the bounds of a projection, as of mrts_polytopes; and `cap`,
 * the largest x that rows which[rows .. rows + caps - 1], of x alone, allow. Zeros on entry. */
MRTS_EXPORT void mrts_scales(long long count, int k, int all, int rows, int caps, const int *which, const double *A,
                             const double *lower, const double *upper, double length, double ends, double *bound,
                             double *scale, double *least, double *most, double *cap, double *work, int *iwork) {
    double rate = 0, largest_cap = 1;
    for (long long n = 0; n < count; ++n) {
        double *size = scale + n * k, share = 0;
        for (int i = 0; i < rows; ++i) {
            const double *row = A + (n * all + which[i]) * k;
            MRTS_UNROLL
            for (int j = 0; j < k; ++j) {
                if (!(MRTS_ABS(row[j]) <= size[j])) size[j] = MRTS_ABS(row[j]);
            }
        }
        for (int i = rows; i < rows + caps; ++i) {
            const long long row = n * all + which[i];
            const double square = A[row * k + k - 1];
            if (square != 0) share = mrts_larger(square / (square > 0 ? upper[row] : lower[row]), share);
        }
        cap[n] = 1 / share;
        rate = mrts_larger(size[k - 2], rate);
        if (cap[n] < INFINITY) largest_cap = mrts_larger(cap[n], largest_cap);
    }
    for (long long i = 0; i < count * k; ++i) {
        scale[i] = scale[i] > (i % k == k - 2 ? mrts_larger(MRTS_AT_REST * rate, MRTS_NO_EFFECT) : MRTS_NO_EFFECT) ? 1 / scale[i] : 0;
    }
    if (!(*bound > 0)) {
        const double likely = 2 * length * mrts_likely_rate(count, k, all, rows, which, A, lower, upper, scale, work, iwork);
        *bound = MRTS_FARTHEST * mrts_larger(ends, likely > 0 ? likely : largest_cap);
    }
    for (long long n = 0; n < count; ++n) {
        double *unit = scale + n * k + k - 2;
        const double reached = -mrts_larger(-*bound / MRTS_FARTHEST, -cap[n]);
        unit[1] = reached > MRTS_NEGLIGIBLE * unit[1] ? -mrts_larger(-unit[1], -reached) : 0;
        most[2 * n] = unit[0] > 0 ? MRTS_BOX : 0;
        least[2 * n] = -most[2 * n];
        if (unit[1] > 0) most[2 * n + 1] = -mrts_larger(mrts_larger(-*bound, -cap[n]) / unit[1], -MRTS_BOX);
    }
}

/*
 * The fastest speed along a path by reachability analysis (Pham and Pham, A new approach to time-optimal path
 * parameterization based on reachability analysis, IEEE T-RO 2018): x is the squared speed, u half its slope, constant
 * on each segment: x_(i+1) = x_i + 2 step_i u. Each sample has half-planes n_u u + n_x x <= h, which hold at both ends of
 * every segment (the interpolation scheme). Where u is to rise by a given amount along a segment, u is its mean. */
/* Rounding of a speed on a limit, relative to 1 and the limit, so that a region of one point does not miss itself. */
#define MRTS_ON_LIMIT 2e-10

/* A coefficient of u that is none: beside it all else would be infinite. */
#define MRTS_NO_RATE 1e-200

/* Bounds start - slope x of u, from below and from above, and of x. */
typedef struct {
    double *least, *least_end, *most, *most_end; /* start and slope of each, one after the other */
    double low, high;
} mrts_bounds;

/* Adds n_u u + n_x x <= h. */
static inline void mrts_add_bound(double u, double x, double h, mrts_bounds *bounds) {
    const double per_u = 1 / u;
    if (u > MRTS_NO_RATE) {
        bounds->most_end[0] = h * per_u;
        bounds->most_end[1] = x * per_u;
        bounds->most_end += 2;
    } else if (u < -MRTS_NO_RATE) {
        bounds->least_end[0] = h * per_u;
        bounds->least_end[1] = x * per_u;
        bounds->least_end += 2;
    } else if (x > 0) {
        if (h / x < bounds->high) bounds->high = h / x;
    } else if (x < 0) {
        if (h / x > bounds->low) bounds->low = h / x;
    }
}

/* The bounds of a segment over (u, x_i), x_i in [low, high]: those of its start, those of its end with x_(i+1) put in, and
 * the interval that x_(i+1) is to reach. `work` has 4 reals for each of them all and of the interval's two ends. */
static inline mrts_bounds mrts_segment(double step, double rise, const double *left, const double *right,
                                       const double *right_end, const double *reach, double low, double high,
                                       double *work) {
    double *half = work + 2 * ((right_end - left) / 3 + 2);
    mrts_bounds bounds = {work, work, half, half, low, high};
    double ahead = 0, away = 0.5 * rise;
    for (const double *plane = left; plane < right_end; plane += 3) {
        if (plane == right) {
            ahead = 2 * step;
            away = -away;
        }
        mrts_add_bound(plane[0] + ahead * plane[1], plane[1],
                       plane[2] + MRTS_ON_LIMIT * (1 + MRTS_ABS(plane[2])) + away * plane[0], &bounds);
    }
    mrts_add_bound(-2 * step, -1, -reach[0], &bounds);
    mrts_add_bound(2 * step, 1, reach[1], &bounds);
    return bounds;
}

/* The interval of u at one x, and the bounds that its ends are on. */
typedef struct {
    double least, most;
    const double *least_bound, *most_bound;
} mrts_rates;

static inline mrts_rates mrts_rates_at(const mrts_bounds *bounds, double x) {
    mrts_rates u = {-MRTS_INFINITY, MRTS_INFINITY, 0, 0};
    for (const double *bound = bounds->most; bound < bounds->most_end; bound += 2) {
        const double value = bound[0] - bound[1] * x;
        if (value >= u.most) continue;
        u.most = value;
        u.most_bound = bound;
    }
    for (const double *bound = bounds->least; bound < bounds->least_end; bound += 2) {
        const double value = bound[0] - bound[1] * x;
        if (value <= u.least) continue;
        u.least = value;
        u.least_bound = bound;
    }
    return u;
}

/* The x nearest to `from` on the way to `to` that leaves some u: the interval's length is concave in x, so Newton's method
 * from outside ends at the exact line after finitely many steps. Returns 0 if there is none. `meet` are places of the two
 * bounds that met there on a segment before, or -1: where they meet now is outside too, and near. */
static int mrts_nearest(const mrts_bounds *bounds, double from, double to, long long *meet, double *x) {
    const double inward = to >= from ? 1 : -1;
    const double *least = bounds->least + 2 * meet[0], *most = bounds->most + 2 * meet[1];
    *x = from;
    if (meet[0] >= 0 && least < bounds->least_end && most < bounds->most_end && (least[1] - most[1]) * inward > 0) {
        const double before = (least[0] - most[0]) / (least[1] - most[1]);
        if ((before - from) * inward > 0) *x = (before - to) * inward > 0 ? to : before;
    }
    for (long long left = bounds->least_end - bounds->least + bounds->most_end - bounds->most; left >= 0; left -= 2) {
        const mrts_rates u = mrts_rates_at(bounds, *x);
        if (u.most >= u.least) return 1;
        const double slope = u.least_bound[1] - u.most_bound[1];
        if (slope * inward <= 0) return 0;
        /* where the two lines meet, from their coefficients: `from` may be many orders of magnitude away */
        const double next = (u.least_bound[0] - u.most_bound[0]) / slope;
        if (next == *x) return 1; /* nothing but rounding is left */
        if (*x == to) return 0;
        *x = (next - to) * inward > 0 ? to : next;
        meet[0] = (u.least_bound - bounds->least) / 2;
        meet[1] = (u.most_bound - bounds->most) / 2;
    }
    return 1;
}

/* Backward: the controllable sets [low, high] of samples 0 .. last, given as bounds of x and that of the last sample.
 * Forward: from the x[0] in them the largest controllable speed at each next sample. Returns the sample that has none, -1 if all
 * have one. start[i] .. start[i + 1] - 1 are the half-planes of sample i. `work` has 8 reals for each and 14 for each sample. */
MRTS_EXPORT long long mrts_fastest(long long last, const double *step, const double *rise, const long long *start,
                                   const double *planes, double *low, double *high, double *x, double *work) {
    long long meet[2][2] = {{-1, -1}, {-1, -1}};
    mrts_bounds *kept = (mrts_bounds *)(void *)work; /* of the segments, before them all in work */
    work = (double *)(void *)(kept + last);
    for (long long i = last - 1; i >= 0; --i) {
        const double reach[2] = {low[i + 1], high[i + 1]};
        const mrts_bounds *bounds = kept + i;
        kept[i] = mrts_segment(step[i], rise[i], planes + 3 * start[i], planes + 3 * start[i + 1], planes + 3 * start[i + 2],
                               reach, low[i], high[i], work);
        work += 4 * (start[i + 2] - start[i] + 2);
        double least, most; /* x_i that leaves some u */
        if (bounds->low > bounds->high || !mrts_nearest(bounds, bounds->low, bounds->high, meet[0], &least) ||
            !mrts_nearest(bounds, bounds->high, bounds->low, meet[1], &most)) {
            return i;
        }
        low[i] = least;
        high[i] = most > least ? most : least;
    }
    for (long long i = 0; i <= last; ++i) {
        x[i] = x[i] < low[i] ? low[i] : x[i] > high[i] ? high[i] : x[i];
        if (i == last) break;
        const mrts_rates u = mrts_rates_at(kept + i, x[i]);
        x[i + 1] = x[i] + 2 * step[i] * (u.most >= u.least ? u.most : (u.most + u.least) / 2);
    }
    return -1;
}

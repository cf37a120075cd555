/* SPDX-License-Identifier: MIT
 *
 * Corners of several samples that share their bases: each is solved for, and checked when all rows are put in.
 */
#include "lane_corners.h"

MRTS_LOCAL mrts_lane_polytopes mrts_lane_polytopes_in(const mrts_polytopes *of, double *work, int *iwork) {
    const int k = of->k, rows = of->rows;
    mrts_lane_polytopes in;
    in.of = of;
    in.A = (mrts_lanes *)(void *)work;
    in.lower = in.A + rows * k;
    in.upper = in.lower + rows + k;
    in.corner = in.upper + rows + k;
    in.work = in.corner + MRTS_CORNERS * MRTS_LANE_CORNER(k);
    in.basis = iwork;
    in.row = in.basis + MRTS_CORNERS * k;
    return in;
}

MRTS_LOCAL void mrts_take_polytopes(long long first, mrts_lane_polytopes *in) {
    const mrts_polytopes *of = in->of;
    const int k = of->k, rows = of->rows;
    for (int lane = 0; lane < MRTS_LANES; ++lane) {
        const long long n = first + lane < of->count ? first + lane : of->count - 1;
        const double *A = of->A + n * of->all * k, *scale = of->scale + n * k;
        const double *limits[] = {of->lower + n * of->all, of->upper + n * of->all};
        const double *bounds[] = {of->least + 2 * n, of->most + 2 * n};
        for (int i = 0; i < rows; ++i) {
            for (int j = 0; j < k; ++j) in->A[i * k + j][lane] = A[of->which[i] * k + j] * scale[j];
        }
        for (int i = 0; i < rows + k; ++i) {
            const int bound = i - rows - (k - 2);
            for (int side = 0; side < 2; ++side) {
                const double absent = side ? MRTS_INFINITY : -MRTS_INFINITY;
                const double limit = i < rows ? limits[side][of->which[i]] : bound < 0 ? absent : bounds[side][bound];
                (side ? in->upper : in->lower)[i][lane] = limit;
            }
        }
    }
    for (int i = 0; i < rows + k; ++i) {
        in->lower[i] = mrts_larger_lanes(in->lower[i], mrts_each(-MRTS_INFINITY));
        in->upper[i] = -mrts_larger_lanes(-in->upper[i], mrts_each(-MRTS_INFINITY));
    }
}

/* What the rows of a basis weigh in an unknown, and whether they make it up and give the point's. */
static mrts_lane_mask mrts_corner_weights(const mrts_lane_polytopes *in, const int *basis, int unknown, mrts_lanes its,
                                          mrts_lanes *y) {
    const int k = in->of->k, rows = in->of->rows;
    mrts_lanes *rest = in->work + k * k, value = mrts_each(0);
    mrts_lane_mask right = MRTS_EVERY_LANE;
    for (int j = 0; j < k; ++j) rest[j] = y[j] = mrts_each(j == unknown);
    mrts_kept_multipliers_lanes(k, in->work, y, unknown);
    for (int n = 0; n < k; ++n) {
        const int row = mrts_abs(basis[n]) - 1;
        const mrts_lanes limit = basis[n] < 0 ? in->lower[row] : in->upper[row];
        value += y[n] * mrts_choose(mrts_above(mrts_each(MRTS_INFINITY), mrts_sizes(limit)), limit, mrts_each(0));
        if (row >= rows) rest[row - rows] -= y[n];
        for (int j = 0; j < k && row < rows; ++j) rest[j] -= y[n] * in->A[row * k + j];
    }
    for (int j = 0; j < k; ++j) right &= mrts_at_most(mrts_sizes(rest[j]), mrts_each(MRTS_FEASIBLE));
    return right & mrts_at_most(mrts_sizes(value - its), MRTS_FEASIBLE * (1 + mrts_sizes(value)));
}

/* The corner of a basis, which comes into the order of its pivots, and of which samples it is one. */
static mrts_lane_mask mrts_lane_corner(const mrts_lane_polytopes *in, int *basis, mrts_lanes *corner) {
    const int k = in->of->k, rows = in->of->rows;
    mrts_lanes *B = in->work, *z = B + k * k + k;
    for (int n = 0; n < k; ++n) in->row[n] = mrts_abs(basis[n]) - 1;
    mrts_kept_factor_lanes(k, rows, in->A, in->row, basis, B);
    for (int n = 0; n < k; ++n) {
        const mrts_lanes limit = basis[n] < 0 ? in->lower[in->row[n]] : in->upper[in->row[n]];
        z[n] = mrts_choose(mrts_above(mrts_each(MRTS_INFINITY), mrts_sizes(limit)), limit, mrts_each(0));
    }
    mrts_kept_solve_lanes(k, B, z);
    corner[0] = z[k - 2];
    corner[1] = z[k - 1];
    const mrts_lane_mask kept = mrts_kept_feasible_lanes(k, rows, in->A, in->lower, in->upper, z);
    if (!mrts_any(kept)) return kept;
    return kept & mrts_corner_weights(in, basis, k - 2, corner[0], corner + 2) &
           mrts_corner_weights(in, basis, k - 1, corner[1], corner + 2 + k);
}

/* Whether the multipliers of a direction have the signs of limits that there are. */
static mrts_lane_mask mrts_corner_signs(const mrts_lane_polytopes *in, int at, const mrts_lanes *direction) {
    const int k = in->of->k, *basis = in->basis + at * k;
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
        const mrts_lane_mask limited =
            code < 0 ? mrts_above(low, mrts_each(-MRTS_INFINITY)) : mrts_above(mrts_each(MRTS_INFINITY), high);
        const mrts_lanes wrong = mrts_choose(limited, code < 0 ? y[n] : -y[n], mrts_sizes(y[n]));
        right &= mrts_at_most(wrong, size) | mrts_at_most(high, low);
    }
    return right;
}

/* Whether nothing lies outside of the edge from a corner to the next; they are not the same. */
static mrts_lane_mask mrts_edge_is_final(const mrts_lane_polytopes *in, int at, int next) {
    const int k = in->of->k;
    const mrts_lanes *p = in->corner + at * MRTS_LANE_CORNER(k), *q = in->corner + next * MRTS_LANE_CORNER(k);
    mrts_lanes normal[2] = {q[1] - p[1], p[0] - q[0]}, length = normal[0] * normal[0] + normal[1] * normal[1];
    const mrts_lanes apart = mrts_sizes(normal[0]) + mrts_sizes(normal[1]);
    for (int lane = 0; lane < MRTS_LANES; ++lane) length[lane] = MRTS_SQRT(length[lane]);
    normal[0] /= length;
    normal[1] /= length;
    const mrts_lane_mask differ = mrts_above(apart, MRTS_OUTSIDE * (1 + mrts_sizes(p[0]) + mrts_sizes(p[1])));
    mrts_lane_mask final = mrts_corner_signs(in, at, normal);
    if (!(final[0] & final[1] & final[2] & final[3])) final |= mrts_corner_signs(in, next, normal);
    return differ & final;
}

MRTS_LOCAL mrts_lane_mask mrts_known_outline(const mrts_lane_polytopes *in, const mrts_outline *outline) {
    const int k = in->of->k, count = outline->count;
    mrts_lane_mask known = MRTS_EVERY_LANE;
    for (int i = 0; i < count * k; ++i) in->basis[i] = outline->basis[i];
    for (int at = 0; at < count && mrts_any(known); ++at) {
        known &= mrts_lane_corner(in, in->basis + at * k, in->corner + at * MRTS_LANE_CORNER(k));
    }
    for (int at = 0; at < count && mrts_any(known); ++at) known &= mrts_edge_is_final(in, at, at + 1 < count ? at + 1 : 0);
    return known;
}

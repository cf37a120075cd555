/* SPDX-License-Identifier: MIT
 *
 * Corners of several samples that share their bases. Rows that bound one unknown alone give it at
 * once; the others are solved for, their pivots those of the first sample: what that is worth is seen when all is put in.
 */
#include "lane_corners.h"

MRTS_LOCAL mrts_lane_polytopes mrts_lane_polytopes_in(const mrts_polytopes *of, double *work, int *iwork) {
    const int k = of->k, rows = of->rows;
    mrts_lane_polytopes in;
    in.of = of;
    in.A = (mrts_lanes *)(void *)work;
    in.per = in.A + rows * k;
    in.lower = in.per + rows;
    in.upper = in.lower + rows + k;
    in.least = in.upper + rows + k;
    in.most = in.least + rows + k;
    in.corner = in.most + rows + k;
    in.B = in.corner + MRTS_CORNERS * MRTS_LANE_CORNER(k);
    in.z = in.B + k * k;
    in.right = in.z + k;
    in.limit = in.right + k;
    in.share = in.limit + k;
    in.row = (const mrts_lanes **)(void *)(in.share + 2 * k);
    in.alone = iwork;
    in.several = in.alone + rows;
    in.several_count = 0;
    in.fixing = in.several + rows + 3;
    in.open = in.fixing + k;
    in.joint = in.open + k;
    in.fit = (mrts_lane_mask){0};
    return in;
}

MRTS_LOCAL void mrts_take_polytopes(long long first, mrts_lane_polytopes *in) {
    const mrts_polytopes *of = in->of;
    const int k = of->k, rows = of->rows;
    const double *A[MRTS_LANES], *limits[2][MRTS_LANES], *bounds[2][MRTS_LANES], *scale[MRTS_LANES];
    mrts_lane_mask apart = {0};
    for (int lane = 0; lane < MRTS_LANES; ++lane) {
        const long long n = first + lane < of->count ? first + lane : of->count - 1;
        A[lane] = of->A + n * of->all * k;
        limits[0][lane] = of->lower + n * of->all;
        limits[1][lane] = of->upper + n * of->all;
        bounds[0][lane] = of->least + 2 * n;
        bounds[1][lane] = of->most + 2 * n;
        scale[lane] = of->scale + n * k;
    }
    for (int j = 0; j < k; ++j) in->z[j] = (mrts_lanes){scale[0][j], scale[1][j], scale[2][j], scale[3][j]};
    for (int i = 0; i < rows; ++i) {
        const int row = of->which[i] * k;
        mrts_lanes *a = in->A + i * k;
        for (int j = 0; j < k; ++j) {
            a[j] = (mrts_lanes){A[0][row + j], A[1][row + j], A[2][row + j], A[3][row + j]} * in->z[j];
        }
        if (in->alone[i] < 0) continue;
        in->per[i] = 1 / a[in->alone[i]];
        for (int j = 0; j < k; ++j) {
            if (j != in->alone[i]) apart |= ~mrts_at_most(mrts_sizes(a[j]), mrts_each(0)); /* or no number */
        }
    }
    in->fit = ~apart;
    for (int i = 0; i < rows + k; ++i) {
        const int bound = i - rows - (k - 2);
        for (int side = 0; side < 2; ++side) {
            const double *const *from = i < rows ? limits[side] : bounds[side];
            const int place = i < rows ? of->which[i] : bound;
            mrts_lanes limit = mrts_each(side ? MRTS_INFINITY : -MRTS_INFINITY);
            if (i < rows || bound >= 0) limit = (mrts_lanes){from[0][place], from[1][place], from[2][place], from[3][place]};
            limit = mrts_choose(mrts_above(mrts_each(-MRTS_INFINITY), limit), mrts_each(-MRTS_INFINITY), limit);
            limit = mrts_choose(mrts_above(limit, mrts_each(MRTS_INFINITY)), mrts_each(MRTS_INFINITY), limit);
            const mrts_lanes rounding = MRTS_FEASIBLE * (1 + mrts_sizes(limit));
            (side ? in->upper : in->lower)[i] = limit;
            (side ? in->most : in->least)[i] = side ? limit + rounding : limit - rounding;
        }
    }
}

/* The limit that a row of a basis is at, 0 for a free one. */
static mrts_lanes mrts_corner_limit(const mrts_lane_polytopes *in, int code) {
    const mrts_lanes limit = code < 0 ? in->lower[-code - 1] : in->upper[code - 1];
    return mrts_choose(mrts_above(mrts_each(MRTS_INFINITY), mrts_sizes(limit)), limit, mrts_each(0));
}

/* Whether a row keeps its limits, but for rounding. */
static mrts_lane_mask mrts_row_kept(const mrts_lane_polytopes *in, int row, mrts_lanes value) {
    return mrts_at_most(in->least[row], value) & mrts_at_most(value, in->most[row]);
}

/* Whether rows and bounds keep their limits at the point; the rows of several unknowns four at a time. */
static mrts_lane_mask mrts_point_kept(const mrts_lane_polytopes *in) {
    const int k = in->of->k, rows = in->of->rows;
    const mrts_lanes *z = in->z;
    mrts_lane_mask kept = MRTS_EVERY_LANE;
    for (int i = 0; i < in->several_count; i += 4) {
        const int *row = in->several + i;
        const mrts_lanes *a = in->A + row[0] * k, *b = in->A + row[1] * k, *c = in->A + row[2] * k, *d = in->A + row[3] * k;
        mrts_lanes of_a = a[0] * z[0], of_b = b[0] * z[0], of_c = c[0] * z[0], of_d = d[0] * z[0];
        for (int j = 1; j < k; ++j) {
            of_a += a[j] * z[j];
            of_b += b[j] * z[j];
            of_c += c[j] * z[j];
            of_d += d[j] * z[j];
        }
        kept &= mrts_row_kept(in, row[0], of_a) & mrts_row_kept(in, row[1], of_b);
        kept &= mrts_row_kept(in, row[2], of_c) & mrts_row_kept(in, row[3], of_d);
    }
    for (int i = 0; i < rows; ++i) {
        if (in->alone[i] >= 0) kept &= mrts_row_kept(in, i, in->A[i * k + in->alone[i]] * z[in->alone[i]]);
    }
    for (int j = k - 2; j < k; ++j) kept &= mrts_row_kept(in, rows + j, z[j]);
    return kept;
}

/* B = L U of the rows that bound several unknowns, in the order of their pivots, with what they are to be. */
static void mrts_corner_factor(const mrts_lane_polytopes *in, const int *basis, int count) {
    const int k = in->of->k;
    for (int i = 0; i < count; ++i) {
        const mrts_lanes *a = in->row[i] = in->A + (mrts_abs(basis[in->joint[i]]) - 1) * k;
        mrts_lanes right = in->limit[in->joint[i]];
        for (int l = count; l < k; ++l) right -= a[in->open[l]] * in->z[in->open[l]];
        in->right[i] = right;
        for (int l = 0; l < count; ++l) in->B[i * count + l] = a[in->open[l]];
    }
    for (int c = 0; c < count; ++c) {
        mrts_lanes *pivot = in->B + c * count;
        int best = c;
        for (int i = c + 1; i < count; ++i) {
            if (MRTS_ABS(in->B[i * count + c][0]) > MRTS_ABS(in->B[best * count + c][0])) best = i;
        }
        if (best != c) {
            const int place = in->joint[c];
            const mrts_lanes its = in->right[c], *its_row = in->row[c];
            in->row[c] = in->row[best];
            in->row[best] = its_row;
            in->joint[c] = in->joint[best];
            in->joint[best] = place;
            in->right[c] = in->right[best];
            in->right[best] = its;
            for (int l = 0; l < count; ++l) {
                const mrts_lanes entry = pivot[l];
                pivot[l] = in->B[best * count + l];
                in->B[best * count + l] = entry;
            }
        }
        pivot[c] = 1 / pivot[c];
        for (int i = c + 1; i < count; ++i) {
            mrts_lanes *row = in->B + i * count;
            const mrts_lanes factor = row[c] = row[c] * pivot[c];
            for (int l = c + 1; l < count; ++l) row[l] -= factor * pivot[l];
            in->right[i] -= factor * in->right[c];
        }
    }
}

/* What the rows of a basis weigh in u and in x, and whether they make both up and give the point's. */
static mrts_lane_mask mrts_corner_weights(const mrts_lane_polytopes *in, const int *basis, int count,
                                                        mrts_lanes *of_u, mrts_lanes *of_x) {
    const int k = in->of->k;
    mrts_lanes *by_u = in->share, *by_x = by_u + k, rest_u = mrts_each(0), rest_x = rest_u, u = rest_u, x = rest_u;
    for (int c = 0; c < count; ++c) {
        mrts_lanes share_u = mrts_each(in->open[c] == k - 2), share_x = mrts_each(in->open[c] == k - 1);
        for (int l = 0; l < c; ++l) {
            share_u -= in->B[l * count + c] * by_u[l];
            share_x -= in->B[l * count + c] * by_x[l];
        }
        by_u[c] = share_u * in->B[c * count + c];
        by_x[c] = share_x * in->B[c * count + c];
    }
    for (int c = count - 1; c >= 0; --c) {
        mrts_lanes share_u = by_u[c], share_x = by_x[c];
        for (int l = c + 1; l < count; ++l) {
            share_u -= in->B[l * count + c] * by_u[l];
            share_x -= in->B[l * count + c] * by_x[l];
        }
        of_u[in->joint[c]] = by_u[c] = share_u;
        of_x[in->joint[c]] = by_x[c] = share_x;
    }
    for (int j = 0; j < k; ++j) {
        mrts_lanes left_u = mrts_each(j == k - 2), left_x = mrts_each(j == k - 1);
        for (int c = 0; c < count; ++c) {
            const mrts_lanes a = in->row[c][j];
            left_u -= by_u[c] * a;
            left_x -= by_x[c] * a;
        }
        if (in->fixing[j] < 0) {
            rest_u = mrts_larger_lanes(mrts_sizes(left_u), rest_u);
            rest_x = mrts_larger_lanes(mrts_sizes(left_x), rest_x);
        } else {
            const int row = mrts_abs(basis[in->fixing[j]]) - 1;
            of_u[in->fixing[j]] = row < in->of->rows ? left_u * in->per[row] : left_u;
            of_x[in->fixing[j]] = row < in->of->rows ? left_x * in->per[row] : left_x;
        }
    }
    for (int n = 0; n < k; ++n) {
        u += of_u[n] * in->limit[n];
        x += of_x[n] * in->limit[n];
    }
    return mrts_at_most(mrts_sizes(u - in->z[k - 2]), MRTS_FEASIBLE * (1 + mrts_sizes(u))) &
           mrts_at_most(mrts_sizes(x - in->z[k - 1]), MRTS_FEASIBLE * (1 + mrts_sizes(x))) &
           mrts_at_most(rest_u + rest_x, mrts_each(MRTS_FEASIBLE)); /* so they make up any direction */
}

/* The corner of a basis, and of which samples it is one. */
static mrts_lane_mask mrts_lane_corner(const mrts_lane_polytopes *in, const int *basis, mrts_lanes *corner) {
    const int k = in->of->k, rows = in->of->rows;
    int count = 0, opened = 0, closed = k;
    for (int j = 0; j < k; ++j) in->fixing[j] = -1;
    for (int n = 0; n < k; ++n) {
        const int row = mrts_abs(basis[n]) - 1, unknown = row < rows ? in->alone[row] : row - rows;
        in->limit[n] = mrts_corner_limit(in, basis[n]);
        if (unknown < 0) {
            in->joint[count++] = n;
        } else if (in->fixing[unknown] >= 0) {
            return (mrts_lane_mask){0};
        } else {
            in->fixing[unknown] = n;
            in->z[unknown] = row < rows ? in->limit[n] * in->per[row] : in->limit[n];
        }
    }
    for (int j = 0; j < k; ++j) {
        in->open[in->fixing[j] < 0 ? opened++ : --closed] = j;
    }
    mrts_corner_factor(in, basis, count);
    for (int c = count - 1; c >= 0; --c) {
        mrts_lanes its = in->right[c];
        for (int l = c + 1; l < count; ++l) its -= in->B[c * count + l] * in->z[in->open[l]];
        in->z[in->open[c]] = its * in->B[c * count + c];
    }
    corner[0] = in->z[k - 2];
    corner[1] = in->z[k - 1];
    return mrts_point_kept(in) & mrts_corner_weights(in, basis, count, corner + 2, corner + 2 + k);
}

/* Whether the multipliers of a direction have the signs of limits that there are. */
static mrts_lane_mask mrts_corner_signs(const mrts_lane_polytopes *in, const int *basis, const mrts_lanes *corner,
                                                      const mrts_lanes *direction) {
    const int k = in->of->k;
    const mrts_lanes *of_u = corner + 2, *of_x = of_u + k;
    mrts_lanes *y = in->share, size = mrts_each(1);
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
static mrts_lane_mask mrts_edge_is_final(const mrts_lane_polytopes *in, const mrts_outline *outline, int at,
                                                       int next) {
    const int k = in->of->k, *here = outline->basis + at * k, *ahead = outline->basis + next * k;
    const mrts_lanes *p = in->corner + at * MRTS_LANE_CORNER(k), *q = in->corner + next * MRTS_LANE_CORNER(k);
    mrts_lanes normal[2] = {q[1] - p[1], p[0] - q[0]}, length = normal[0] * normal[0] + normal[1] * normal[1];
    const mrts_lanes apart = mrts_sizes(normal[0]) + mrts_sizes(normal[1]);
    for (int lane = 0; lane < MRTS_LANES; ++lane) length[lane] = MRTS_SQRT(length[lane]);
    normal[0] /= length;
    normal[1] /= length;
    const mrts_lane_mask differ = mrts_above(apart, MRTS_OUTSIDE * (1 + mrts_sizes(p[0]) + mrts_sizes(p[1])));
    mrts_lane_mask final = mrts_corner_signs(in, here, p, normal);
    if (!(final[0] & final[1] & final[2] & final[3])) final |= mrts_corner_signs(in, ahead, q, normal);
    return differ & final;
}

MRTS_LOCAL void mrts_known_outline(const mrts_lane_polytopes *in, const mrts_outline *outline,
                                             mrts_lane_mask *known) {
    const int k = in->of->k, count = outline->count;
    mrts_lane_mask found = in->fit;
    for (int at = 0; at < count && (found[0] | found[1] | found[2] | found[3]); ++at) {
        found &= mrts_lane_corner(in, outline->basis + at * k, in->corner + at * MRTS_LANE_CORNER(k));
    }
    for (int at = 0; at < count && (found[0] | found[1] | found[2] | found[3]); ++at) {
        found &= mrts_edge_is_final(in, outline, at, at + 1 < count ? at + 1 : 0);
    }
    *known = found;
}

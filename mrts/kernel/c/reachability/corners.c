/* SPDX-License-Identifier: MIT
 *
 * Along a path the rows that determine a corner rarely change, and neighbouring corners differ by few of them. So the
 * inverse of a basis is made from that of the corner before by exchanging rows, and what it gives is verified with the rows
 * as given: the point must keep all limits, the multipliers must make up the direction. What fails goes to mrts_lp.
 */
#include "corners.h"

MRTS_LOCAL mrts_polytope mrts_polytope_in(int k, int rows, double *work, int *iwork) {
    mrts_polytope in;
    in.k = k;
    in.rows = rows;
    in.A = work;
    in.lower = in.A + rows * k;
    in.upper = in.lower + rows + k;
    in.least = in.upper + rows + k;
    in.most = in.least + rows + k;
    in.inverse = in.most + rows + k;
    in.alpha = in.inverse + k * k;
    in.point = in.alpha + k;
    in.place = iwork;
    in.code = in.place + rows + k;
    in.kept = in.code + k;
    in.missing = in.kept + k;
    in.programs = 0;
    return in;
}

/* The unknowns themselves are the basis that exchanges start from. */
static void mrts_basis_of_unknowns(mrts_polytope *in) {
    const int k = in->k;
    for (int i = 0; i < in->rows; ++i) in->place[i] = -1;
    for (int i = 0; i < k * k; ++i) in->inverse[i] = 0;
    for (int j = 0; j < k; ++j) {
        in->inverse[j * k + j] = 1;
        in->place[in->rows + j] = j;
        in->code[j] = in->rows + j + 1;
    }
}

MRTS_LOCAL void mrts_begin_polytope(mrts_polytope *in) {
    for (int i = 0; i < in->rows + in->k; ++i) {
        in->least[i] = in->lower[i] - MRTS_FEASIBLE * (1 + MRTS_ABS(in->lower[i]));
        in->most[i] = in->upper[i] + MRTS_FEASIBLE * (1 + MRTS_ABS(in->upper[i]));
    }
    in->programs = 0;
    mrts_basis_of_unknowns(in);
}

/* The sum of products, in two parts that compilers take together */
static double mrts_dot_of_pairs(int k, const double *a, const double *b) {
    double even = 0, odd = 0;
    int i = 0;
    for (; i + 1 < k; i += 2) {
        even += a[i] * b[i];
        odd += a[i + 1] * b[i + 1];
    }
    return (i < k ? even + a[i] * b[i] : even) + odd;
}

/* to += factor from, likewise */
static void mrts_add(int k, double factor, const double *restrict from, double *restrict to) {
    int i = 0;
    for (; i + 1 < k; i += 2) {
        to[i] += factor * from[i];
        to[i + 1] += factor * from[i + 1];
    }
    if (i < k) to[i] += factor * from[i];
}

static int mrts_coded_row(int code) { return (code < 0 ? -code : code) - 1; }

/* How a row is made up of the basis: its coefficients times the inverse */
static void mrts_make_up(mrts_polytope *in, int row) {
    const int k = in->k;
    for (int j = 0; j < k; ++j) in->alpha[j] = row < in->rows ? 0 : in->inverse[(row - in->rows) * k + j];
    if (row >= in->rows) return;
    for (int i = 0; i < k; ++i) {
        const double share = in->A[row * k + i];
        if (share != 0) mrts_add(k, share, in->inverse + i * k, in->alpha);
    }
}

/* A row takes a place of the basis that is not kept; returns whether one can be made of it. */
static int mrts_exchange(mrts_polytope *in, int code) {
    const int k = in->k, row = mrts_coded_row(code);
    double best = 0, size = 0;
    int q = -1;
    mrts_make_up(in, row);
    for (int j = 0; j < k; ++j) {
        const double share = MRTS_ABS(in->alpha[j]);
        if (share > size) size = share;
        if (!in->kept[j] && share > best) {
            best = share;
            q = j;
        }
    }
    if (q < 0 || !(best > MRTS_PIVOT * size)) return 0;
    const double factor = 1 / in->alpha[q];
    in->alpha[q] -= 1; /* so that place q becomes itself times the factor */
    for (int i = 0; i < k; ++i) {
        double *inverse = in->inverse + i * k;
        const double share = inverse[q] * factor;
        if (share != 0) mrts_add(k, -share, in->alpha, inverse);
    }
    in->place[mrts_coded_row(in->code[q])] = -1;
    in->place[row] = q;
    in->code[q] = code;
    in->kept[q] = 1;
    return 1;
}

/* Whether a row of A has one coefficient: it costs little while the inverse has few others. */
static int mrts_is_single(const mrts_polytope *in, int row) {
    int count = 0;
    for (int i = 0; i < in->k; ++i) count += in->A[row * in->k + i] != 0;
    return count <= 1;
}

/* The inverse becomes that of a basis, whose places become those of the inverse; returns whether there is one. */
static int mrts_turn_to(mrts_polytope *in, int *basis) {
    const int k = in->k;
    int count = 0;
    for (int j = 0; j < k; ++j) in->kept[j] = 0;
    for (int n = 0; n < k; ++n) {
        const int place = in->place[mrts_coded_row(basis[n])];
        if (place >= 0) {
            in->kept[place] = 1;
            in->code[place] = basis[n];
        } else {
            in->missing[count++] = basis[n];
        }
    }
    for (int pass = count > 2 ? 0 : 1; pass < 2; ++pass) { /* single ones first, where there are many */
        int left = 0;
        for (int n = 0; n < count; ++n) {
            if (pass == 0 && !mrts_is_single(in, mrts_coded_row(in->missing[n]))) {
                in->missing[left++] = in->missing[n];
            } else if (!mrts_exchange(in, in->missing[n])) {
                mrts_basis_of_unknowns(in);
                return 0;
            }
        }
        count = left;
    }
    for (int j = 0; j < k; ++j) basis[j] = in->code[j];
    return 1;
}

/* Whether a point keeps all limits, but for rounding. */
static int mrts_keeps_limits(const mrts_polytope *in, const double *z) {
    const int k = in->k, rows = in->rows;
    for (int row = 0; row < rows + k; ++row) {
        const double value = row < rows ? mrts_dot_of_pairs(k, in->A + row * k, z) : z[row - rows];
        if (!(value >= in->least[row]) || !(value <= in->most[row])) return 0;
    }
    return 1;
}

/* Whether the multipliers of a direction have the signs of limits that there are. */
static int mrts_has_signs(const mrts_polytope *in, mrts_corner corner, const double *direction) {
    const int k = in->k;
    double size = 1;
    for (int j = 0; j < k; ++j) {
        const double y = direction[0] * corner.rate[j] + direction[1] * corner.rate[k + j];
        if (MRTS_ABS(y) > size) size = MRTS_ABS(y);
    }
    for (int j = 0; j < k; ++j) {
        const double y = direction[0] * corner.rate[j] + direction[1] * corner.rate[k + j];
        if (MRTS_ABS(y) <= MRTS_OUTSIDE / 10 * size) continue;
        const int row = mrts_coded_row(corner.basis[j]);
        if (in->lower[row] == in->upper[row]) continue; /* it may push either way */
        if (corner.basis[j] < 0 ? y < 0 || in->lower[row] <= -MRTS_INFINITY : y > 0 || in->upper[row] >= MRTS_INFINITY) {
            return 0;
        }
    }
    return 1;
}

MRTS_LOCAL int mrts_is_furthest(mrts_polytope *in, mrts_corner corner, const double *direction) {
    const int k = in->k;
    double *rest = in->alpha, size = 1;
    if (!mrts_has_signs(in, corner, direction)) return 0;
    for (int i = 0; i < k; ++i) rest[i] = 0;
    rest[k - 2] = direction[0];
    rest[k - 1] = direction[1];
    for (int j = 0; j < k; ++j) {
        const double y = direction[0] * corner.rate[j] + direction[1] * corner.rate[k + j];
        const int row = mrts_coded_row(corner.basis[j]);
        if (MRTS_ABS(y) > size) size = MRTS_ABS(y);
        if (row < in->rows) {
            if (y != 0) mrts_add(k, y, in->A + row * k, rest);
        } else {
            rest[row - in->rows] += y;
        }
    }
    for (int i = 0; i < k; ++i) {
        if (!(MRTS_ABS(rest[i]) <= MRTS_FEASIBLE * size)) return 0;
    }
    return 1;
}

MRTS_LOCAL int mrts_outward(mrts_polytope *in, mrts_corner corner, double *direction) {
    const int k = in->k;
    double right[2] = {0, 0}, left[2] = {0, 0}; /* of the edges, seen from the corner inward */
    for (int j = 0; j < k; ++j) {
        const int row = mrts_coded_row(corner.basis[j]);
        const double sign = corner.basis[j] < 0 ? -1 : 1, edge[2] = {sign * corner.rate[j], sign * corner.rate[k + j]};
        if (in->lower[row] == in->upper[row]) continue;
        const int first = right[0] == 0 && right[1] == 0;
        if (first || right[0] * edge[1] - right[1] * edge[0] < 0) {
            right[0] = edge[0];
            right[1] = edge[1];
        }
        if (first || left[0] * edge[1] - left[1] * edge[0] > 0) {
            left[0] = edge[0];
            left[1] = edge[1];
        }
    }
    const double right_size = MRTS_SQRT(right[0] * right[0] + right[1] * right[1]);
    const double left_size = MRTS_SQRT(left[0] * left[0] + left[1] * left[1]);
    if (!(right_size > 0) || !(left_size > 0)) return 0;
    const double u = right[1] / right_size - left[1] / left_size, x = left[0] / left_size - right[0] / right_size;
    const double size = MRTS_SQRT(u * u + x * x);
    if (!(size > 0)) return 0;
    direction[0] = u / size;
    direction[1] = x / size;
    return mrts_is_furthest(in, corner, direction);
}

MRTS_LOCAL int mrts_is_corner(mrts_polytope *in, mrts_corner corner) {
    const int k = in->k;
    double *limit = in->alpha;
    if (!mrts_turn_to(in, corner.basis)) return 0;
    for (int j = 0; j < k; ++j) {
        corner.rate[j] = -in->inverse[(k - 2) * k + j];
        corner.rate[k + j] = -in->inverse[(k - 1) * k + j];
    }
    for (int j = 0; j < k; ++j) {
        const int row = mrts_coded_row(corner.basis[j]);
        limit[j] = corner.basis[j] < 0 ? in->lower[row] : in->upper[row];
        if (MRTS_ABS(limit[j]) >= MRTS_INFINITY) limit[j] = 0; /* a free one */
    }
    for (int i = 0; i < k; ++i) in->point[i] = mrts_dot_of_pairs(k, in->inverse + i * k, limit);
    if (!mrts_keeps_limits(in, in->point)) return 0;
    corner.at[0] = in->point[k - 2];
    corner.at[1] = in->point[k - 1];
    return 1;
}

MRTS_LOCAL int mrts_furthest(mrts_polytope *in, const double *direction, mrts_corner corner, double *work, int *iwork) {
    const int k = in->k;
    double *g = work, *z = g + k, *y = z + k, *inverse = y + k; /* mrts_lp leaves its columns there */
    int entering, status = MRTS_STOPPED;
    ++in->programs;
    for (int j = 0; j < k; ++j) g[j] = 0;
    g[k - 2] = -direction[0];
    g[k - 1] = -direction[1];
    for (int attempt = 0; attempt < 2; ++attempt) {
        const int cold = corner.basis[0] == 0;
        status = mrts_lp(k, in->rows, in->A, in->lower, in->upper, g, corner.basis, z, y, &entering, inverse, iwork);
        if (status == MRTS_OPTIMAL || cold) break;
        corner.basis[0] = 0;
    }
    /* rows that are alike but for rounding leave multipliers of either sign: nearly the furthest is good enough */
    if (status == MRTS_STOPPED && mrts_keeps_limits(in, z)) status = MRTS_OPTIMAL;
    if (status != MRTS_OPTIMAL) corner.basis[0] = 0;
    corner.at[0] = z[k - 2];
    corner.at[1] = z[k - 1];
    for (int j = 0; j < k; ++j) {
        corner.rate[j] = -inverse[j * k + k - 2];
        corner.rate[k + j] = -inverse[j * k + k - 1];
    }
    return status;
}

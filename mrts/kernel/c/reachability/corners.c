/* SPDX-License-Identifier: MIT
 *
 * Along a path the rows that determine a corner rarely change, and neighbouring corners differ by few of them. So the
 * inverse of a basis is made from that of the corner before by exchanging rows, and what it gives is verified with the rows
 * as given: the point must keep all limits, the multipliers must make up the direction. What fails goes to mrts_lp.
 */
#include "corners.h"

MRTS_LOCAL mrts_polytope mrts_polytope_in(int k, int rows, double *work, int *iwork) {
    const int all = MRTS_FOURS(rows) + k, width = MRTS_FOURS(k);
    mrts_polytope in;
    in.k = k;
    in.rows = rows;
    in.width = width;
    in.A = work;
    in.fours = in.A + rows * width;
    in.inverse = in.fours + MRTS_FOURS(rows) * width;
    in.alpha = in.inverse + k * width;
    in.y = in.alpha + width;
    in.point = in.y + width;
    in.lower = in.point + width;
    in.upper = in.lower + all;
    in.least = in.upper + all;
    in.most = in.least + all;
    in.place = iwork;
    in.code = in.place + rows + k;
    in.kept = in.code + k;
    in.missing = in.kept + k;
    in.is_single = in.missing + k;
    for (int i = 0; i < MRTS_POLYTOPE_WORK(k, rows); ++i) work[i] = 0;
    return in;
}

/* The unknowns themselves are the basis that exchanges start from. */
static void mrts_basis_of_unknowns(mrts_polytope *in) {
    const int k = in->k, width = in->width;
    for (int i = 0; i < in->rows; ++i) in->place[i] = -1;
    for (int i = 0; i < k * width; ++i) in->inverse[i] = 0;
    for (int j = 0; j < k; ++j) {
        in->inverse[j * width + j] = 1;
        in->place[in->rows + j] = j;
        in->code[j] = in->rows + j + 1;
    }
}

MRTS_LOCAL void mrts_begin_polytope(mrts_polytope *in) {
    const int k = in->k, rows = in->rows;
    for (int i = 0; i < rows; ++i) {
        const double *row = in->A + i * in->width;
        double *four = in->fours + i / 4 * 4 * k + i % 4;
        int count = 0;
        for (int j = 0; j < k; ++j) {
            four[4 * j] = row[j];
            count += row[j] != 0;
        }
        in->is_single[i] = count <= 1;
    }
    for (int i = 0; i < rows + k; ++i) {
        in->least[i] = in->lower[i] - MRTS_FEASIBLE * (1 + MRTS_ABS(in->lower[i]));
        in->most[i] = in->upper[i] + MRTS_FEASIBLE * (1 + MRTS_ABS(in->upper[i]));
    }
    mrts_basis_of_unknowns(in);
}

/* to += factor from */
static inline void mrts_add(int width, double factor, const double *restrict from, double *restrict to) {
    for (int i = 0; i < width; i += 4) {
        to[i] += factor * from[i];
        to[i + 1] += factor * from[i + 1];
        to[i + 2] += factor * from[i + 2];
        to[i + 3] += factor * from[i + 3];
    }
}

static inline int mrts_coded_row(int code) { return (code < 0 ? -code : code) - 1; }

/* How a row is made up of the basis: its coefficients times the inverse */
static void mrts_make_up(mrts_polytope *in, int row) {
    const int k = in->k, width = in->width;
    for (int j = 0; j < width; ++j) in->alpha[j] = 0;
    if (row >= in->rows) mrts_add(width, 1, in->inverse + (row - in->rows) * width, in->alpha);
    for (int i = 0; i < k && row < in->rows; ++i) {
        const double share = in->A[row * width + i];
        if (share != 0) mrts_add(width, share, in->inverse + i * width, in->alpha);
    }
}

/* A row takes a place of the basis that is not kept; returns whether one can be made of it. */
static int mrts_exchange(mrts_polytope *in, int code) {
    const int k = in->k, width = in->width, row = mrts_coded_row(code);
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
        double *inverse = in->inverse + i * width;
        const double share = inverse[q] * factor;
        if (share != 0) mrts_add(width, -share, in->alpha, inverse);
    }
    in->place[mrts_coded_row(in->code[q])] = -1;
    in->place[row] = q;
    in->code[q] = code;
    in->kept[q] = 1;
    return 1;
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
    for (int pass = count > 2 ? 0 : 1; pass < 2; ++pass) { /* single ones first, while the inverse has few numbers */
        int left = 0;
        for (int n = 0; n < count; ++n) {
            if (pass == 0 && !in->is_single[mrts_coded_row(in->missing[n])]) {
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
    for (int row = 0; row < rows; row += 4) {
        const double *four = in->fours + row * k, *least = in->least + row, *most = in->most + row;
        double value[4] = {0, 0, 0, 0};
        for (int j = 0; j < k; ++j, four += 4) {
            const double share = z[j];
            value[0] += share * four[0];
            value[1] += share * four[1];
            value[2] += share * four[2];
            value[3] += share * four[3];
        }
        const int count = rows - row < 4 ? rows - row : 4;
        for (int i = 0; i < count; ++i) {
            if (!(value[i] >= least[i]) || !(value[i] <= most[i])) return 0;
        }
    }
    for (int j = 0; j < k; ++j) {
        if (!(z[j] >= in->least[rows + j]) || !(z[j] <= in->most[rows + j])) return 0;
    }
    return 1;
}

/* The multipliers of a direction; whether they have the signs of limits that there are. */
static int mrts_has_signs(mrts_polytope *in, mrts_corner corner, const double *direction, double *size) {
    const int k = in->k, width = in->width;
    const double du = direction[0], dx = direction[1], *of_u = corner.rate, *of_x = of_u + width;
    double *y = in->y;
    for (int j = 0; j < width; j += 4) {
        y[j] = du * of_u[j] + dx * of_x[j];
        y[j + 1] = du * of_u[j + 1] + dx * of_x[j + 1];
        y[j + 2] = du * of_u[j + 2] + dx * of_x[j + 2];
        y[j + 3] = du * of_u[j + 3] + dx * of_x[j + 3];
    }
    *size = 1;
    for (int j = 0; j < k; ++j) {
        const double its_size = MRTS_ABS(y[j]);
        if (its_size > *size) *size = its_size;
    }
    for (int j = 0; j < k; ++j) {
        const int code = corner.basis[j], row = mrts_coded_row(code);
        if (code < 0 ? y[j] > 0 && in->lower[row] > -MRTS_INFINITY : y[j] < 0 && in->upper[row] < MRTS_INFINITY) continue;
        if (MRTS_ABS(y[j]) > MRTS_OUTSIDE / 10 * *size && in->lower[row] != in->upper[row]) return 0;
    }
    return 1;
}

MRTS_LOCAL int mrts_is_furthest(mrts_polytope *in, mrts_corner corner, const double *direction) {
    const int k = in->k, width = in->width;
    double *rest = in->alpha, size;
    if (!mrts_has_signs(in, corner, direction, &size)) return 0;
    for (int i = 0; i < width; ++i) rest[i] = 0;
    rest[k - 2] = direction[0];
    rest[k - 1] = direction[1];
    for (int j = 0; j < k; ++j) {
        const int row = mrts_coded_row(corner.basis[j]);
        if (row < in->rows) {
            mrts_add(width, in->y[j], in->A + row * width, rest);
        } else {
            rest[row - in->rows] += in->y[j];
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
        const double sign = corner.basis[j] < 0 ? -1 : 1, *of_x = corner.rate + in->width;
        const double edge[2] = {sign * corner.rate[j], sign * of_x[j]};
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
    const int k = in->k, width = in->width;
    const double *of_u = in->inverse + (k - 2) * width, *of_x = of_u + width;
    double *limit = in->alpha;
    if (!mrts_turn_to(in, corner.basis)) return 0;
    for (int j = 0; j < width; ++j) {
        corner.rate[j] = -of_u[j];
        corner.rate[width + j] = -of_x[j];
    }
    for (int j = 0; j < k; ++j) {
        const int code = corner.basis[j];
        limit[j] = code < 0 ? in->lower[-code - 1] : in->upper[code - 1];
        if (MRTS_ABS(limit[j]) >= MRTS_INFINITY) limit[j] = 0; /* a free one */
    }
    for (int i = 0; i < k; ++i) {
        const double *inverse = in->inverse + i * width;
        double sum[2] = {0, 0};
        for (int j = 0; j < width; j += 4) {
            sum[0] += inverse[j] * limit[j] + inverse[j + 2] * limit[j + 2];
            sum[1] += inverse[j + 1] * limit[j + 1] + inverse[j + 3] * limit[j + 3];
        }
        in->point[i] = sum[0] + sum[1];
    }
    if (!mrts_keeps_limits(in, in->point)) return 0;
    corner.at[0] = in->point[k - 2];
    corner.at[1] = in->point[k - 1];
    return 1;
}

MRTS_LOCAL int mrts_furthest(mrts_polytope *in, const double *direction, mrts_corner corner, double *work, int *iwork) {
    const int k = in->k, rows = in->rows;
    double *A = work, *g = A + rows * k, *z = g + k, *y = z + k, *inverse = y + k; /* mrts_lp leaves its columns there */
    int entering, status = MRTS_STOPPED;
    for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < k; ++j) A[i * k + j] = in->A[i * in->width + j];
    }
    for (int j = 0; j < k; ++j) g[j] = 0;
    g[k - 2] = -direction[0];
    g[k - 1] = -direction[1];
    for (int attempt = 0; attempt < 2; ++attempt) {
        const int cold = corner.basis[0] == 0;
        status = mrts_lp(k, rows, A, in->lower, in->upper, g, corner.basis, z, y, &entering, inverse, iwork);
        if (status == MRTS_OPTIMAL || cold) break;
        corner.basis[0] = 0;
    }
    /* rows that are alike but for rounding leave multipliers of either sign: nearly the furthest is good enough */
    if (status == MRTS_STOPPED && mrts_keeps_limits(in, z)) status = MRTS_OPTIMAL;
    if (status != MRTS_OPTIMAL) corner.basis[0] = 0;
    corner.at[0] = z[k - 2];
    corner.at[1] = z[k - 1];
    for (int j = 0; j < in->width; ++j) {
        corner.rate[j] = j < k ? -inverse[j * k + k - 2] : 0;
        corner.rate[in->width + j] = j < k ? -inverse[j * k + k - 1] : 0;
    }
    return status;
}

/* SPDX-License-Identifier: MIT
 *
 * Rows and ends of the range of several samples.
 *
 * Sines and cosines of lanes are off by no more than half a unit in the last place of 1: rotations need no more, where they
 * are all but 0 neither. The argument less a multiple of pi / 2, in two parts, and the polynomials of FreeBSD's msun
 * (k_sin, k_cos, Sun Microsystems, 1993). An angle of more than MRTS_MOST_ANGLE is left to the C library.
 */
#include "lanes.h"
#include "../basis/kept_basis.h"
#include "../trajectory.h"

#define MRTS_PER_QUARTER 6.36619772367581382433e-01  /* 2 / pi */
#define MRTS_QUARTER 1.57079632673412561417e+00      /* the first 33 bits of pi / 2 */
#define MRTS_QUARTER_REST 6.07710050650619224932e-11 /* and the rest */
#define MRTS_ROUNDER 6755399441055744.0              /* 1.5 * 2^52: what is added to it is rounded to a whole number */
#define MRTS_MOST_ANGLE 1e5                          /* a multiple of 33 bits is exact [rad] */

/* The sine and the cosine of lanes. */
static void mrts_sine_cosine(mrts_lanes angle, mrts_lanes *both) {
    const mrts_lanes shifted = angle * MRTS_PER_QUARTER + MRTS_ROUNDER, turns = shifted - MRTS_ROUNDER;
    const mrts_lanes first = angle - turns * MRTS_QUARTER, less = turns * MRTS_QUARTER_REST;
    const mrts_lanes x = first - less, tail = (first - x) - less, z = x * x, half = 0.5 * z, w = 1 - half;
    const mrts_lanes of_sine = 8.33333333332248946124e-03 +
                               z * (-1.98412698298579493134e-04 +
                                    z * (2.75573137070700676789e-06 +
                                         z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
    const mrts_lanes of_cosine = z * (4.16666666666666019037e-02 +
                                      z * (-1.38888888888741095749e-03 +
                                           z * (2.48015872894767294178e-05 +
                                                z * (-2.75573143513906633035e-07 +
                                                     z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11)))));
    const mrts_lanes cube = z * x;
    const mrts_lanes sine = x - ((z * (0.5 * tail - cube * of_sine) - tail) - cube * -1.66666666666666324348e-01);
    const mrts_lanes cosine = w + (((1 - w) - half) + (z * of_cosine - x * tail));
    /* the lowest bits of what was shifted count the quarters */
    const mrts_lane_mask quarters = (mrts_lane_mask)shifted, odd = (quarters & 1) != 0;
    both[0] = (mrts_lanes)((mrts_lane_mask)mrts_choose(odd, cosine, sine) ^ (quarters & 2) << 62);
    both[1] = (mrts_lanes)((mrts_lane_mask)mrts_choose(odd, sine, cosine) ^ ((quarters + 1) & 2) << 62);
    const mrts_lane_mask near = mrts_sizes(angle) <= MRTS_MOST_ANGLE;
    for (int lane = 0; lane < MRTS_LANES; ++lane) {
        if (near[lane]) continue;
        both[0][lane] = sin(angle[lane]);
        both[1][lane] = cos(angle[lane]);
    }
}

MRTS_LOCAL void mrts_sines(int count, const mrts_lanes *angle, mrts_lanes *both) {
    for (int i = 0; i < count; ++i) mrts_sine_cosine(angle[i], both + 2 * i);
}

MRTS_LOCAL void mrts_lane_form(const mrts_lanes *const *arg, mrts_lanes *const *res) {
    mrts_lanes sines[2 * MRTS_JOINTS];
    mrts_sines(MRTS_JOINTS, arg[0], sines);
    MRTS_WRENCH_FORM_LANES(arg, sines, res);
}

MRTS_LOCAL void mrts_lane_cholesky(int k, const mrts_lanes *H, mrts_lanes *L) {
    for (int j = 0; j < k; ++j) {
        for (int i = j; i < k; ++i) {
            mrts_lanes sum = H[i * k + j];
            for (int l = 0; l < j; ++l) sum -= L[i * k + l] * L[j * k + l];
            if (i == j) {
                for (int lane = 0; lane < MRTS_LANES; ++lane) sum[lane] = MRTS_SQRT(sum[lane]);
                L[j * k + j] = 1 / sum;
            } else {
                L[i * k + j] = sum * L[j * k + j];
            }
        }
    }
}

MRTS_LOCAL void mrts_lane_forward(int k, const mrts_lanes *L, mrts_lanes *b) {
    for (int i = 0; i < k; ++i) {
        mrts_lanes sum = b[i];
        for (int l = 0; l < i; ++l) sum -= L[i * k + l] * b[l];
        b[i] = sum * L[i * k + i];
    }
}

MRTS_LOCAL void mrts_lane_backward(int k, const mrts_lanes *L, mrts_lanes *b) {
    for (int i = k - 1; i >= 0; --i) {
        mrts_lanes sum = b[i];
        for (int l = i + 1; l < k; ++l) sum -= L[l * k + i] * b[l];
        b[i] = sum * L[i * k + i];
    }
}

MRTS_LOCAL mrts_lanes mrts_term(const double *all, const long long *at, int size, int place) {
    mrts_lanes value = mrts_each(0);
    for (int lane = 0; all && lane < MRTS_LANES; ++lane) value[lane] = all[at[lane] * size + place];
    return value;
}

/* What motors give besides. */
MRTS_LOCAL void mrts_lane_motors(const mrts_terms *terms, const long long *at, mrts_lanes *torque_square,
                                           mrts_lanes *torque_offset) {
    for (int i = 0; terms->torque_square && i < MRTS_JOINTS; ++i) {
        torque_square[i] += mrts_term(terms->torque_square, at, MRTS_JOINTS, i);
    }
    for (int i = 0; terms->torque_offset && i < MRTS_JOINTS; ++i) {
        torque_offset[i] += mrts_term(terms->torque_offset, at, MRTS_JOINTS, i);
    }
}

/* As mrts_build_rows, without wrenches in object axes. */
MRTS_LOCAL void mrts_lane_build(const mrts_lanes *torque, const mrts_lanes *wrench, const mrts_limits *limits,
                                          const mrts_terms *terms, const long long *at, mrts_lane_rows *rows) {
    enum { K = MRTS_UNKNOWNS };
    for (int j = 0; j < K; ++j) rows->size[j] = mrts_each(0);
    for (int i = 0; i < rows->of->count; ++i) {
        const int row = rows->of->which[i];
        const double low = limits->lower[row], high = limits->upper[row], per_unit = 1 / rows->of->unit[i];
        mrts_lanes offset = mrts_each(0), margin = offset, a[K];
        for (int j = 0; j < K; ++j) a[j] = mrts_each(0);
        for (int entry = limits->start[row]; entry < limits->start[row + 1]; ++entry) {
            const int column = limits->column[entry], is_torque = column < MRTS_JOINTS;
            const int size = is_torque ? MRTS_JOINTS : MRTS_WRENCHES;
            const mrts_lanes *map = is_torque ? torque + column : wrench + column - MRTS_JOINTS;
            const double value = limits->value[entry] * per_unit;
            for (int j = 0; j < K; ++j) a[j] += value * map[j * size];
            offset += value * map[K * size];
        }
        if (terms->square) a[K - 1] += mrts_term(terms->square, at, limits->rows, row) * per_unit;
        if (terms->offset) offset += mrts_term(terms->offset, at, limits->rows, row) * per_unit;
        if (terms->margin) margin = mrts_term(terms->margin, at, limits->rows, row) * per_unit;
        for (int j = 0; j < K; ++j) {
            rows->A[i * K + j] = a[j];
            rows->size[j] = mrts_larger_lanes(rows->size[j], mrts_sizes(a[j]));
        }
        rows->lower[i] = low <= -MRTS_INFINITY ? mrts_each(-MRTS_INFINITY) : low * per_unit - offset + margin;
        rows->upper[i] = high >= MRTS_INFINITY ? mrts_each(MRTS_INFINITY) : high * per_unit - offset - margin;
    }
}

MRTS_LOCAL void mrts_lane_rows_of(const mrts_lanes *const *arg, const mrts_limits *limits,
                                            const mrts_terms *terms, const long long *at, const double *most,
                                            mrts_lane_rows *rows) {
    enum { K = MRTS_UNKNOWNS, M = MRTS_JOINTS, N = MRTS_WRENCHES };
    mrts_lanes torque[(K + 1) * M], wrench[(K + 1) * N], *res[] = {torque, torque + K * M, wrench, wrench + K * N};
    const int count = rows->of->count, speed = count + K - 1;
    mrts_lane_form(arg, res);
    mrts_lane_motors(terms, at, torque + (K - 1) * M, torque + K * M);
    mrts_lane_build(torque, wrench, limits, terms, at, rows);
    for (int j = 0; j < K; ++j) {
        const mrts_lane_mask has = rows->size[j] > MRTS_NO_EFFECT;
        const mrts_lanes scale = mrts_choose(has, 1 / rows->size[j], mrts_each(0));
        for (int i = 0; i < count; ++i) rows->A[i * K + j] *= scale;
        rows->column[j] = mrts_choose(has, scale, mrts_each(1));
        rows->lower[count + j] = mrts_each(-MRTS_INFINITY);
        rows->upper[count + j] = mrts_each(MRTS_INFINITY);
    }
    rows->lower[speed] = mrts_each(0);
    for (int lane = 0; lane < MRTS_LANES; ++lane) rows->upper[speed][lane] = most[at[lane]];
    rows->upper[speed] /= rows->column[K - 1];
    rows->upper[speed] = mrts_choose(rows->upper[speed] < MRTS_UNBOUNDED, rows->upper[speed], mrts_each(MRTS_UNBOUNDED));
}

#define MRTS_STATIC static inline
#define MRTS_V mrts_lanes
#define MRTS_V_OF(value) mrts_each(value)
#define MRTS_MASK mrts_lane_mask
#define MRTS_ALL MRTS_EVERY_LANE
#define MRTS_CHOOSE(mask, a, b) mrts_choose(mask, a, b)
#define MRTS_BOTH(a, b) ((a) & (b))
#define MRTS_LARGER(a, b) mrts_larger_lanes(a, b)
#define MRTS_SIZE_OF(a) mrts_sizes(a)
#define MRTS_OF(name) name##_lanes
#define MRTS_TAKE_PIVOT(k, c, row, side, B) (void)(side)
#define MRTS_IS_NONE(value) 0
#include "../basis/kept_basis.inc"

MRTS_LOCAL void mrts_lane_end(const mrts_lane_rows *rows, double sign, const int *basis, mrts_lanes *x,
                                        mrts_lanes *y, mrts_lane_mask *kept) {
    enum { K = MRTS_UNKNOWNS };
    mrts_lanes B[K * K], rest[K];
    double g[K] = {0};
    int row[K], side[K];
    g[K - 1] = sign;
    for (int j = 0; j < K; ++j) {
        row[j] = mrts_abs(basis[j]) - 1;
        side[j] = basis[j];
    }
    *kept = mrts_kept_basis_lanes(K, rows->of->count, rows->A, rows->lower, rows->upper, g, row, side, x, y, B, rest);
}

MRTS_LOCAL void mrts_take_inputs(const double *const *in, const long long *stride, long long first, long long count,
                                 int all, mrts_lane_inputs *lanes) {
    static const int sizes[MRTS_INPUTS] = MRTS_INPUT_SIZES;
    mrts_lanes *next = lanes->numbers;
    for (int lane = 0; lane < MRTS_LANES; ++lane) lanes->at[lane] = first + lane < count ? first + lane : count - 1;
    for (int i = 0; i < MRTS_INPUTS; next += sizes[i++]) {
        const double *own[MRTS_LANES];
        lanes->arg[i] = next;
        if (!all && !stride[i]) continue;
        for (int lane = 0; lane < MRTS_LANES; ++lane) own[lane] = in[i] + lanes->at[lane] * stride[i];
        for (int number = 0; number < sizes[i]; ++number) {
            next[number] = (mrts_lanes){own[0][number], own[1][number], own[2][number], own[3][number]};
        }
    }
}

MRTS_LOCAL void mrts_take_lane(int count, const mrts_lanes *from, int lane, double *to) {
    const double *numbers = (const double *)(const void *)from + lane;
    for (int i = 0; i < count; ++i) to[i] = numbers[i * MRTS_LANES];
}

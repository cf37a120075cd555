/* SPDX-License-Identifier: MIT
 *
 * Building and scaling the rows of one sample.
 */
#include "rows.h"

/* Size of a limit: its larger finite side, 0 where it has none. */
static mrts_real mrts_limit_size(mrts_real lower, mrts_real upper) {
    const mrts_real both = mrts_larger(MRTS_ABS(lower), MRTS_ABS(upper));
    if (both < MRTS_INFINITY) return both;
    return lower > -MRTS_INFINITY ? MRTS_ABS(lower) : upper < MRTS_INFINITY ? MRTS_ABS(upper) : 0;
}

/* What a limit of zero is measured by: the largest limit of its group, or 1. */
static mrts_real mrts_group_size(const mrts_limits *limits, int group) {
    mrts_real largest = 0;
    for (int row = 0; row < limits->rows; ++row) {
        const mrts_real size = mrts_limit_size(limits->lower[row], limits->upper[row]);
        if (limits->group[row] == group && size > largest) largest = size;
    }
    return largest > 0 ? largest : 1;
}

MRTS_LOCAL int mrts_rows_over(int k, const mrts_limits *limits, mrts_real *work, int *iwork, mrts_rows *rows) {
    rows->count = 0;
    rows->which = iwork;
    rows->unit = work;
    rows->A = rows->unit + limits->rows;
    rows->lower = rows->A + limits->rows * k;
    rows->upper = rows->lower + limits->rows + k;
    rows->size = rows->upper + limits->rows + k;
    for (int row = 0; row < limits->rows; ++row) {
        const mrts_real lower = limits->lower[row], upper = limits->upper[row], size = mrts_limit_size(lower, upper);
        if (!(lower <= upper)) return 0;
        if (!(size > 0) && lower <= -MRTS_INFINITY && upper >= MRTS_INFINITY) continue;
        rows->unit[rows->count] = size > 0 ? size : mrts_group_size(limits, limits->group[row]);
        rows->which[rows->count++] = row;
    }
    return 1;
}

MRTS_LOCAL void mrts_turn_wrenches(int k, int arms, int size, const mrts_limits *limits, const mrts_real *rotation,
                                   int down, int across, mrts_real *memory, mrts_form *form) {
    const int wrenches = arms * size;
    if (!limits->base) return;
    form->object_map = memory;
    form->object_offset = memory + k * wrenches;
    for (int arm = 0; arm < arms; ++arm) {
        mrts_real turn[9];
        for (int i = 0; i < 9; ++i) {
            const mrts_real *column = rotation + limits->axes[i / 3] * across, *base = limits->base + 9 * arm + i % 3;
            turn[i] = column[0] * base[0] + column[down] * base[3] + column[2 * down] * base[6];
        }
        for (int j = 0; j <= k; ++j) {
            for (int first = arm * size; first < (arm + 1) * size; first += 3) {
                const mrts_real *given = j < k ? form->wrench_map + j * wrenches + first : form->wrench_offset + first;
                for (int i = 0; i < 3; ++i) memory[j * wrenches + first + i] = mrts_dot(3, turn + 3 * i, given);
            }
        }
    }
}

/* Takes the coefficients of a row into the sizes of the unknowns; what is returned is a number where they all are. */
static mrts_real mrts_take_sizes(int k, const mrts_real *a, mrts_real *size) {
    mrts_real sum = 0;
    MRTS_UNROLL
    for (int j = 0; j < k; ++j) {
        const mrts_real its = MRTS_ABS(a[j]);
        size[j] = mrts_larger(its, size[j]);
        sum += its;
    }
    return sum;
}

MRTS_LOCAL int mrts_build_rows(int k, int joints, int wrenches, const mrts_form *form, const mrts_limits *limits,
                               const mrts_terms *terms, mrts_rows *rows) {
    mrts_real sum = 0;
    MRTS_UNROLL
    for (int j = 0; j < k; ++j) rows->size[j] = 0;
    for (int i = 0; i < rows->count; ++i) {
        const int row = rows->which[i];
        const mrts_real low = limits->lower[row], high = limits->upper[row], per_unit = 1 / rows->unit[i];
        mrts_real offset = 0, *a = rows->A + i * k;
        const int first = limits->start[row], end = limits->start[row + 1];
        for (int j = 0; j < k && first == end; ++j) a[j] = 0;
        for (int entry = first; entry < end; ++entry) {
            const int column = limits->column[entry], size = column < joints ? joints : wrenches;
            const mrts_real *map = form->torque_map + column, *given = form->torque_offset + column;
            const mrts_real value = limits->value[entry] * per_unit;
            if (column >= joints + wrenches) {
                map = form->object_map + (column - joints - wrenches);
                given = form->object_offset + (column - joints - wrenches);
            } else if (column >= joints) {
                map = form->wrench_map + (column - joints);
                given = form->wrench_offset + (column - joints);
            }
            if (entry == first) {
                MRTS_UNROLL
                for (int j = 0; j < k; ++j, map += size) a[j] = value * *map;
            } else {
                for (int j = 0; j < k; ++j, map += size) a[j] += value * *map;
            }
            offset += value * *given;
        }
        if (terms->square) a[k - 1] += terms->square[row] * per_unit;
        if (terms->offset) offset += terms->offset[row] * per_unit;
        sum += mrts_take_sizes(k, a, rows->size);
        const mrts_real margin = terms->margin ? terms->margin[row] * per_unit : 0;
        rows->lower[i] = low <= -MRTS_INFINITY ? -MRTS_INFINITY : low * per_unit - offset + margin;
        rows->upper[i] = high >= MRTS_INFINITY ? MRTS_INFINITY : high * per_unit - offset - margin;
    }
    return sum < MRTS_INFINITY;
}

MRTS_LOCAL void mrts_fix_speed(int k, const mrts_limits *limits, mrts_real c2, mrts_real widening, mrts_rows *rows) {
    const int left = k - 1;
    for (int i = 0; i < rows->count; ++i) {
        const int row = rows->which[i];
        const mrts_real given = rows->A[i * k + left] * c2;
        const mrts_real gap = limits->lower[row] < limits->upper[row] ? widening : 0;
        if (rows->lower[i] > -MRTS_INFINITY) rows->lower[i] -= given + gap;
        if (rows->upper[i] < MRTS_INFINITY) rows->upper[i] += gap - given;
        for (int j = 0; j < left; ++j) rows->A[i * left + j] = rows->A[i * k + j]; /* to a place before its own */
    }
}

MRTS_LOCAL void mrts_scale_columns(int k, mrts_rows *rows, mrts_real *column) {
    mrts_real *a = rows->A;
    for (int j = 0; j < k; ++j) column[j] = rows->size[j] > MRTS_NO_EFFECT ? 1 / rows->size[j] : 0;
    for (int i = 0; i < rows->count; ++i, a += k) {
        MRTS_UNROLL
        for (int j = 0; j < k; ++j) a[j] *= column[j];
    }
    for (int j = 0; j < k; ++j) column[j] = column[j] > 0 ? column[j] : 1;
}

MRTS_LOCAL void mrts_free_unknowns(int k, mrts_rows *rows) {
    for (int j = 0; j < k; ++j) {
        rows->lower[rows->count + j] = -MRTS_INFINITY;
        rows->upper[rows->count + j] = MRTS_INFINITY;
    }
}

MRTS_LOCAL void mrts_bound_speed(int k, mrts_real most, const mrts_real *column, mrts_rows *rows) {
    const int speed = rows->count + k - 1;
    rows->lower[speed] = 0;
    rows->upper[speed] = most / column[k - 1] < MRTS_UNBOUNDED ? most / column[k - 1] : MRTS_UNBOUNDED;
}

MRTS_LOCAL mrts_real mrts_speed_cap(int joints, const mrts_real *dq, const mrts_real *twist, const mrts_real *limit,
                                    int *binding) {
    mrts_real fastest = 0;
    *binding = -1;
    for (int i = 0; i < joints + 2; ++i) {
        if (!(limit[i] < MRTS_INFINITY)) continue;
        const mrts_real *part = twist + (i == joints ? 0 : 3);
        const mrts_real speed = i < joints ? MRTS_ABS(dq[i]) : MRTS_SQRT(mrts_dot(3, part, part));
        if (speed > fastest * limit[i]) {
            fastest = speed / limit[i];
            *binding = i;
        }
    }
    return fastest * fastest > 0 ? 1 / (fastest * fastest) : MRTS_INFINITY;
}

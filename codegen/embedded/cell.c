/* @NOTICE@ */
#include "@NAME@.h"

#include <math.h>
#include <stddef.h>

#include "@NAME@_kernel.h"
#include "@NAME@_model.h"

enum {
    JOINTS = @MACRO@_JOINTS,
    WRENCHES = @MACRO@_WRENCHES,
    ROWS = @MACRO@_ROWS,
    K = @MACRO@_UNKNOWNS,
    F = @MACRO@_UNKNOWNS - 1
};

#define REST @REST@ /* an effect of c^2 = 1 on a limit below this share of it is none */
#define UNBOUNDED_EFFECT @UNBOUNDED_EFFECT@ /* c^2 is unbounded if it may move some row by this many limits */
#define BINDING @BINDING@ /* a row binds if its multiplier exceeds this share of the largest */
#define SLACK @SLACK@ /* widening of limits for torques: at the end of a range the feasible set is a point */

static const char *const ROW_TEXT[ROWS + 1] = {
    "c^2 >= 0",
@ROW_TEXT@
};

/*@begin range*/
const @NAME@_real @NAME@_load_corners[@MACRO@_CORNERS][@MACRO@_LOAD] = {
@LOAD_CORNERS@
};
/*@end range*/

const char *@NAME@_status_text(@NAME@_status status) {
    switch (status) {
    case @MACRO@_OK: return "ok";
    case @MACRO@_UNBOUNDED: return "unbounded: nothing limits the speed";
    case @MACRO@_INFEASIBLE: return "infeasible: limits conflict at every speed";
    case @MACRO@_EMPTY: return "empty: no c^2 in common";
    case @MACRO@_UNDECIDED: return "undecided at this precision";
    case @MACRO@_BAD_ARGUMENT: return "bad argument";
    default: return "unknown status";
    }
}

const char *@NAME@_row_text(int row) {
    const int place = row < 0 ? -row : row;
    return place <= ROWS ? ROW_TEXT[place] : "unknown row";
}

void @NAME@_default_settings(@NAME@_settings *settings) {
    static const @NAME@_settings defaults = {
        {@LOAD@},
        {@LOWER@},
        {@UPPER@},
        {@WEIGHT@},
    };
    *settings = defaults;
}

static int is_finite(@NAME@_real value) { return value > -MRTS_INFINITY && value < MRTS_INFINITY; }

static int all_finite(int count, const @NAME@_real *values) {
    for (int i = 0; i < count; ++i) {
        if (!is_finite(values[i])) return 0;
    }
    return 1;
}

@NAME@_status @NAME@_check_settings(const @NAME@_settings *settings) {
    if (!(settings->load[0] > 0) || !all_finite(@MACRO@_LOAD, settings->load)) return @MACRO@_BAD_ARGUMENT;
    for (int i = 0; i < ROWS; ++i) {
        if (!(settings->lower[i] <= settings->upper[i])) return @MACRO@_BAD_ARGUMENT;
    }
    for (int i = 0; i < JOINTS; ++i) {
        if (!(settings->weight[i] > 0) || !is_finite(settings->weight[i])) return @MACRO@_BAD_ARGUMENT;
    }
    return @MACRO@_OK;
}

void @NAME@_reset(@NAME@_workspace *workspace) {
    for (int j = 0; j < K; ++j) workspace->lower_basis[j] = workspace->upper_basis[j] = 0;
}

/*@begin range share torques*/

static int is_sound(const @NAME@_sample *sample, const @NAME@_real *load) {
    return all_finite(JOINTS, sample->q) && all_finite(JOINTS, sample->dq) && all_finite(JOINTS, sample->ddq) &&
           all_finite(9, sample->rotation) && all_finite(6, sample->twist) && all_finite(6, sample->acceleration) &&
           all_finite(@MACRO@_LOAD, load) && load[0] > 0;
}
/*@end range share torques*/

/* Inputs of the generated functions; matrices there are column after column. */
static void point_to(const @NAME@_sample *sample, const @NAME@_real *load, @NAME@_real turned[9], const @NAME@_real **arg) {
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) turned[3 * j + i] = sample->rotation[3 * i + j];
    }
    arg[0] = sample->q;
    arg[1] = sample->dq;
    arg[2] = sample->ddq;
    arg[3] = turned;
    arg[4] = sample->twist;
    arg[5] = sample->acceleration;
    arg[6] = load;
}

/*@begin terms*/
void @NAME@_terms(const @NAME@_sample *sample, const @NAME@_settings *settings, @NAME@_terms_of_sample *terms) {
    @NAME@_real turned[9];
    const @NAME@_real *arg[7];
    @NAME@_real *res[8];
    point_to(sample, settings->load, turned, arg);
    res[0] = terms->E;
    res[1] = terms->A;
    res[2] = terms->G;
    res[3] = terms->J;
    res[4] = terms->B;
    res[5] = terms->P;
    res[6] = terms->S;
    res[7] = terms->Q;
    @NAME@_model_terms(arg, res);
}
/*@end terms*/

/*@begin range share torques*/
/* Size of a limit: its larger side. */
static @NAME@_real unit_of(@NAME@_real lower, @NAME@_real upper) {
    const @NAME@_real low = lower > -MRTS_INFINITY ? MRTS_ABS(lower) : 0;
    const @NAME@_real high = upper < MRTS_INFINITY ? MRTS_ABS(upper) : 0;
    const @NAME@_real size = low > high ? low : high;
    return size > 0 ? size : 1;
}

/* Columns of the affine maps of `unknowns` unknowns (torques, then wrenches, then their offsets) as rows of limits, each
 * divided by its size; rows without limits are left out. Returns how many, and which; -1 if limits are reversed. */
static int limit_rows(const @NAME@_settings *settings, int unknowns, const @NAME@_real *torque_map,
                      const @NAME@_real *torque_offset, const @NAME@_real *wrench_map, const @NAME@_real *wrench_offset,
                      @NAME@_real *A, @NAME@_real *lower, @NAME@_real *upper, int *which) {
    int count = 0;
    for (int row = 0; row < ROWS; ++row) {
        const int is_torque = row < JOINTS, place = is_torque ? row : row - JOINTS;
        const int size = is_torque ? JOINTS : WRENCHES;
        const @NAME@_real low = settings->lower[row], high = settings->upper[row];
        if (!(low <= high)) return -1;
        if (low <= -MRTS_INFINITY && high >= MRTS_INFINITY) continue;
        const @NAME@_real *map = (is_torque ? torque_map : wrench_map) + place;
        const @NAME@_real offset = (is_torque ? torque_offset : wrench_offset)[place];
        const @NAME@_real factor = 1 / unit_of(low, high);
        for (int j = 0; j < unknowns; ++j) A[count * unknowns + j] = map[j * size] * factor;
        lower[count] = low > -MRTS_INFINITY ? (low - offset) * factor : -MRTS_INFINITY;
        upper[count] = high < MRTS_INFINITY ? (high - offset) * factor : MRTS_INFINITY;
        which[count++] = row;
    }
    return count;
}
/*@end range share torques*/
/*@begin range torques*/

/* Scales unknowns so that each moves some row by one limit: x = column * x_scaled. */
static void scale_columns(int rows, int unknowns, int scaled, @NAME@_real *A, @NAME@_real *column) {
    for (int j = 0; j < scaled; ++j) {
        @NAME@_real size = 0;
        for (int row = 0; row < rows; ++row) {
            const @NAME@_real value = MRTS_ABS(A[row * unknowns + j]);
            if (value > size) size = value;
        }
        column[j] = size > 0 ? 1 / size : 1;
        for (int row = 0; row < rows; ++row) A[row * unknowns + j] *= column[j];
    }
}

/* The affine maps of the wrench form in the workspace. */
static void wrench_form(const @NAME@_sample *sample, const @NAME@_real *load, @NAME@_workspace *workspace,
                        @NAME@_real *res[4]) {
    @NAME@_real turned[9];
    const @NAME@_real *arg[7];
    point_to(sample, load, turned, arg);
    res[0] = workspace->form;
    res[1] = res[0] + K * JOINTS;
    res[2] = res[1] + JOINTS;
    res[3] = res[2] + K * WRENCHES;
    @NAME@_model_wrench_form(arg, res);
}
/*@end range torques*/
/*@begin range*/

/* Rows with a multiplier, the strongest first; returns how many. The side is that of the basis, or of a certificate's
 * multiplier. */
static int name_rows(const int *basis, const @NAME@_real *y, int rows, const int *which, int by_sign, int *named) {
    @NAME@_real largest = 0, size[K];
    int count = 0;
    for (int j = 0; j < K; ++j) {
        size[j] = MRTS_ABS(y[j]);
        if (size[j] > largest) largest = size[j];
    }
    for (int rank = 0; rank < K; ++rank) {
        int next = 0;
        for (int j = 1; j < K; ++j) {
            if (size[j] > size[next]) next = j;
        }
        if (size[next] <= BINDING * largest || size[next] <= 0) break;
        const int code = basis[next], row = (code < 0 ? -code : code) - 1;
        const int at_lower = by_sign ? y[next] > 0 : code < 0;
        named[count++] = row >= rows ? 0 : at_lower ? -which[row] - 1 : which[row] + 1;
        size[next] = 0;
    }
    return count;
}

/* A kept basis that does not fit these rows starts cold. */
static void check_basis(int *basis, int rows) {
    if (basis[0] == 0) return;
    for (int j = 0; j < K; ++j) {
        if (basis[j] == 0 || basis[j] > rows + K || basis[j] < -rows - K) {
            basis[0] = 0;
            return;
        }
    }
}

static @NAME@_status solve_end(int rows, const int *which, @NAME@_real sign, int *basis, @NAME@_real column,
                           @NAME@_workspace *workspace, int *integers, @NAME@_real *end, int *count, int *named) {
    @NAME@_real g[K], x[K], y[K];
    int entering = 0, status = MRTS_STOPPED;
    for (int j = 0; j < K; ++j) g[j] = j == F ? sign : 0;
    check_basis(basis, rows);
    for (int attempt = 0; attempt < 2; ++attempt) {
        const int cold = basis[0] == 0;
        status = mrts_lp(K, rows, workspace->rows, workspace->limits, workspace->limits + ROWS + K, g, basis, x, y,
                         &entering, workspace->work, integers);
        if (status == MRTS_OPTIMAL || cold) break;
        basis[0] = 0;
    }
    if (status == MRTS_INFEASIBLE) {
        const int row = (entering < 0 ? -entering : entering) - 1;
        named[0] = row >= rows ? 0 : entering < 0 ? -which[row] - 1 : which[row] + 1;
        *count = name_rows(basis, y, rows, which, 1, named + 1) + 1;
        basis[0] = 0;
        return @MACRO@_INFEASIBLE;
    }
    if (status != MRTS_OPTIMAL) {
        basis[0] = 0;
        *count = 0;
        return @MACRO@_UNDECIDED;
    }
    *end = x[F] * column;
    if (*end < 0) *end = 0;
    if (sign < 0 && x[F] >= UNBOUNDED_EFFECT * (1 - 10 * MRTS_FEASIBLE)) {
        *end = MRTS_INFINITY;
        *count = 0;
        return @MACRO@_UNBOUNDED;
    }
    *count = name_rows(basis, y, rows, which, 0, named);
    return @MACRO@_OK;
}

static @NAME@_status range_with_load(const @NAME@_sample *sample, const @NAME@_settings *settings, const @NAME@_real *load,
                                 @NAME@_range *range, @NAME@_workspace *workspace) {
    @NAME@_real *res[4], column[K];
    @NAME@_real *lower = workspace->limits, *upper = lower + ROWS + K;
    int *which = workspace->integers, *integers = which + ROWS;
    range->lower = range->upper = 0;
    range->lower_count = range->upper_count = 0;
    if (!is_sound(sample, load)) return range->status = @MACRO@_BAD_ARGUMENT;
    wrench_form(sample, load, workspace, res);
    const int rows = limit_rows(settings, K, res[0], res[1], res[2], res[3], workspace->rows, lower, upper, which);
    if (rows < 0) return range->status = @MACRO@_BAD_ARGUMENT;
    for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < K; ++j) {
            if (!is_finite(workspace->rows[i * K + j])) return range->status = @MACRO@_BAD_ARGUMENT;
        }
    }
    int moves = 0;
    for (int i = 0; i < rows; ++i) moves |= workspace->rows[i * K + F] != 0;
    scale_columns(rows, K, K, workspace->rows, column);
    for (int j = 0; j < K; ++j) {
        lower[rows + j] = j < F ? -MRTS_INFINITY : 0;
        upper[rows + j] = j < F ? MRTS_INFINITY : UNBOUNDED_EFFECT;
    }
    const int at_rest = 1 <= REST * column[F] || !moves;
    for (int i = 0; at_rest && i < rows; ++i) workspace->rows[i * K + F] = 0;
    range->status = solve_end(rows, which, 1, workspace->lower_basis, column[F], workspace, integers,
                              &range->lower, &range->lower_count, range->lower_rows);
    if (range->status != @MACRO@_OK) {
        range->upper_count = range->lower_count;
        for (int i = 0; i < range->lower_count; ++i) range->upper_rows[i] = range->lower_rows[i];
        range->lower_count = 0;
        return range->status;
    }
    if (at_rest) {
        range->upper = MRTS_INFINITY;
        return range->status = @MACRO@_UNBOUNDED;
    }
    return range->status = solve_end(rows, which, -1, workspace->upper_basis, column[F], workspace, integers,
                                     &range->upper, &range->upper_count, range->upper_rows);
}

@NAME@_status @NAME@_range_of_sample(const @NAME@_sample *sample, const @NAME@_settings *settings, @NAME@_range *range,
                         @NAME@_workspace *workspace) {
    return range_with_load(sample, settings, settings->load, range, workspace);
}

@NAME@_status @NAME@_guaranteed_range(const @NAME@_sample *sample, const @NAME@_settings *settings,
                                  const @NAME@_real (*loads)[@MACRO@_LOAD], int count, @NAME@_range *range,
                                  int *lower_load, int *upper_load, @NAME@_workspace *workspace) {
    @NAME@_range one;
    int at_lower = 0, at_upper = 0;
    if (count < 1) return range->status = @MACRO@_BAD_ARGUMENT;
    for (int load = 0; load < count; ++load) {
        const @NAME@_status status = range_with_load(sample, settings, loads[load], &one, workspace);
        if (load == 0) *range = one;
        if (status != @MACRO@_OK && status != @MACRO@_UNBOUNDED) {
            *range = one;
            at_lower = at_upper = load;
            break;
        }
        if (one.lower > range->lower) {
            range->lower = one.lower;
            range->lower_count = one.lower_count;
            for (int i = 0; i < one.lower_count; ++i) range->lower_rows[i] = one.lower_rows[i];
            at_lower = load;
        }
        if (one.upper < range->upper) {
            range->upper = one.upper;
            range->status = one.status;
            range->upper_count = one.upper_count;
            for (int i = 0; i < one.upper_count; ++i) range->upper_rows[i] = one.upper_rows[i];
            at_upper = load;
        }
    }
    if ((range->status == @MACRO@_OK) && range->lower > range->upper) range->status = @MACRO@_EMPTY;
    if (lower_load != NULL) *lower_load = at_lower;
    if (upper_load != NULL) *upper_load = at_upper;
    return range->status;
}
/*@end range*/

void @NAME@_horizon_start(@NAME@_horizon *horizon) {
    horizon->status = @MACRO@_UNBOUNDED;
    horizon->lower = 0;
    horizon->upper = MRTS_INFINITY;
    horizon->samples = 0;
    horizon->lower_sample = horizon->upper_sample = -1;
}

@NAME@_status @NAME@_horizon_add(@NAME@_horizon *horizon, const @NAME@_range *range) {
    const long sample = horizon->samples++;
    const int joined = horizon->status == @MACRO@_OK || horizon->status == @MACRO@_UNBOUNDED;
    if (!joined) return horizon->status;
    if (range->status != @MACRO@_OK && range->status != @MACRO@_UNBOUNDED) {
        horizon->lower_sample = horizon->upper_sample = sample;
        return horizon->status = range->status;
    }
    if (range->lower > horizon->lower || horizon->lower_sample < 0) {
        horizon->lower = range->lower;
        horizon->lower_sample = sample;
    }
    if (range->upper < horizon->upper) {
        horizon->upper = range->upper;
        horizon->upper_sample = sample;
        horizon->status = @MACRO@_OK;
    }
    if (horizon->lower > horizon->upper) horizon->status = @MACRO@_EMPTY;
    return horizon->status;
}
/*@begin share*/

@NAME@_status @NAME@_equal_share_range(const @NAME@_sample *sample, const @NAME@_settings *settings, @NAME@_range *range,
                                   @NAME@_workspace *workspace) {
    @NAME@_real turned[9], shares[@MACRO@_ROBOTS], internal[WRENCHES], *res[4];
    const @NAME@_real *arg[9];
    @NAME@_real *a = workspace->rows, *lower = workspace->limits, *upper = lower + ROWS + K;
    int *which = workspace->integers;
    range->lower = range->upper = 0;
    range->lower_count = range->upper_count = 0;
    if (!is_sound(sample, settings->load)) return range->status = @MACRO@_BAD_ARGUMENT;
    for (int i = 0; i < @MACRO@_ROBOTS; ++i) shares[i] = (@NAME@_real)1 / @MACRO@_ROBOTS;
    for (int i = 0; i < WRENCHES; ++i) internal[i] = 0;
    point_to(sample, settings->load, turned, arg);
    arg[7] = shares;
    arg[8] = internal;
    res[0] = workspace->form;
    res[1] = res[0] + JOINTS;
    res[2] = res[1] + JOINTS;
    res[3] = res[2] + WRENCHES;
    @NAME@_model_fixed_distribution(arg, res);
    const int rows = limit_rows(settings, 1, res[0], res[1], res[2], res[3], a, lower, upper, which);
    if (rows < 0) return range->status = @MACRO@_BAD_ARGUMENT;
    range->lower = 0;
    range->upper = MRTS_INFINITY;
    range->lower_count = 1;
    range->lower_rows[0] = 0;
    range->upper_count = 0;
    for (int i = 0; i < rows; ++i) {
        const int forward = a[i] > 0;
        if (!is_finite(a[i])) return range->status = @MACRO@_BAD_ARGUMENT;
        if (MRTS_ABS(a[i]) <= REST) {
            if (lower[i] <= MRTS_FEASIBLE && upper[i] >= -MRTS_FEASIBLE) continue;
            range->upper_rows[0] = lower[i] > 0 ? -which[i] - 1 : which[i] + 1;
            range->upper_count = 1;
            return range->status = @MACRO@_INFEASIBLE;
        }
        const @NAME@_real from = forward ? lower[i] : upper[i], to = forward ? upper[i] : lower[i];
        if (from > -MRTS_INFINITY && from < MRTS_INFINITY && from / a[i] > range->lower) {
            range->lower = from / a[i];
            range->lower_rows[0] = forward ? -which[i] - 1 : which[i] + 1;
        }
        if (to > -MRTS_INFINITY && to < MRTS_INFINITY && to / a[i] < range->upper) {
            range->upper = to / a[i];
            range->upper_rows[0] = forward ? which[i] + 1 : -which[i] - 1;
            range->upper_count = 1;
        }
    }
    if (range->lower > range->upper) {
        range->upper_rows[1] = range->lower_rows[0];
        range->upper_count = 2;
        return range->status = @MACRO@_INFEASIBLE;
    }
    return range->status = range->upper < MRTS_INFINITY ? @MACRO@_OK : @MACRO@_UNBOUNDED;
}
/*@end share*/
/*@begin torques*/

@NAME@_status @NAME@_torques(const @NAME@_sample *sample, const @NAME@_settings *settings, @NAME@_real c2,
                         @NAME@_real torque[@MACRO@_JOINTS], @NAME@_real wrench[@MACRO@_WRENCHES],
                         @NAME@_workspace *workspace) {
    @NAME@_real *res[4], column[K], x[K], u[K], g[K], H[K * K], at_rest[JOINTS], largest = 0;
    @NAME@_real *A = workspace->rows, *lower = workspace->limits, *upper = lower + ROWS + K;
    int *which = workspace->integers, *integers = which + ROWS, active[K], count = 0, status = MRTS_OPTIMAL;
    for (int i = 0; i < JOINTS; ++i) torque[i] = 0;
    for (int i = 0; i < WRENCHES; ++i) wrench[i] = 0;
    if (!(c2 >= 0) || !is_finite(c2) || !is_sound(sample, settings->load)) return @MACRO@_BAD_ARGUMENT;
    wrench_form(sample, settings->load, workspace, res);
    const int rows = limit_rows(settings, K, res[0], res[1], res[2], res[3], A, lower, upper, which);
    if (rows < 0) return @MACRO@_BAD_ARGUMENT;
    for (int j = 0; j < K; ++j) x[j] = 0;
    for (int i = 0; i < rows; ++i) {
        const int row = which[i];
        const @NAME@_real given = A[i * K + F] * c2, slack = settings->lower[row] < settings->upper[row] ? SLACK : 0;
        if (!is_finite(given)) return @MACRO@_BAD_ARGUMENT;
        if (lower[i] > -MRTS_INFINITY) lower[i] -= given + slack;
        if (upper[i] < MRTS_INFINITY) upper[i] += slack - given;
        for (int j = 0; j < F; ++j) A[i * F + j] = A[i * K + j]; /* rows close up: row i moves to a place before it */
    }
    scale_columns(rows, F, F, A, column);
    for (int i = 0; i < JOINTS; ++i) at_rest[i] = res[0][F * JOINTS + i] * c2 + res[1][i];
    for (int j = 0; j < F; ++j) {
        lower[rows + j] = -MRTS_INFINITY;
        upper[rows + j] = MRTS_INFINITY;
        g[j] = 0;
        for (int i = 0; i < JOINTS; ++i) {
            res[0][j * JOINTS + i] *= column[j];
            g[j] += settings->weight[i] * res[0][j * JOINTS + i] * at_rest[i];
        }
        for (int l = 0; l <= j; ++l) {
            @NAME@_real sum = 0;
            for (int i = 0; i < JOINTS; ++i) sum += settings->weight[i] * res[0][j * JOINTS + i] * res[0][l * JOINTS + i];
            H[j * F + l] = H[l * F + j] = sum;
            if (MRTS_ABS(sum) > largest) largest = MRTS_ABS(sum);
        }
    }
    for (int i = 0; largest > 0 && i < F * F; ++i) H[i] /= largest;
    for (int j = 0; largest > 0 && j < F; ++j) g[j] /= largest;
    if (F > 0) status = mrts_qp(F, rows, H, A, lower, upper, g, x, active, u, &count, workspace->work, integers);
    for (int i = 0; F == 0 && i < rows; ++i) { /* one arm: nothing to choose */
        if (!(lower[i] <= MRTS_FEASIBLE) || !(upper[i] >= -MRTS_FEASIBLE)) status = MRTS_INFEASIBLE;
    }
    for (int i = 0; i < JOINTS; ++i) {
        torque[i] = at_rest[i];
        for (int j = 0; j < F; ++j) torque[i] += x[j] * res[0][j * JOINTS + i];
    }
    for (int i = 0; i < WRENCHES; ++i) {
        wrench[i] = res[2][F * WRENCHES + i] * c2 + res[3][i];
        for (int j = 0; j < F; ++j) wrench[i] += x[j] * column[j] * res[2][j * WRENCHES + i];
    }
    if (!all_finite(JOINTS, torque) || !all_finite(WRENCHES, wrench)) return @MACRO@_UNDECIDED;
    return status == MRTS_OPTIMAL ? @MACRO@_OK : status == MRTS_INFEASIBLE ? @MACRO@_INFEASIBLE : @MACRO@_UNDECIDED;
}
/*@end torques*/

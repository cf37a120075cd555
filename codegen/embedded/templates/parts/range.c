/* @NOTICE@ */
#ifdef MRTS_SINGLE
#define BINDING MRTS_C(1e-4) /* a row binds if its multiplier exceeds this share of the largest */
#else
#define BINDING 1e-7
#endif

typedef char lp_work_holds[HOLDS(work, mrts_real, MRTS_LP_WORK(K))];
typedef char lp_integers_hold[HOLDS(integers, int, MRTS_LP_IWORK(K, ROWS))];

/* A row of the programs as @NAME@_range names it; `velocity` bounds c^2 by itself. */
static int name_of(int code, int at_lower, const mrts_rows *rows, int velocity) {
    const int row = (code < 0 ? -code : code) - 1;
    if (row >= rows->count) return at_lower ? 0 : velocity;
    return at_lower ? -rows->which[row] - 1 : rows->which[row] + 1;
}

/* Rows with a multiplier, the strongest first; returns how many. The side is that of the basis, or of a certificate's
 * multiplier. */
static int name_rows(const int *basis, const mrts_real *y, const mrts_rows *rows, int velocity, int by_sign,
                     int *named) {
    mrts_real largest = 0, size[K];
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
        named[count++] = name_of(basis[next], by_sign ? y[next] > 0 : basis[next] < 0, rows, velocity);
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

static @NAME@_status solve_end(const mrts_rows *rows, int velocity, mrts_real sign, int *basis, mrts_real column,
                               @NAME@_workspace *workspace, mrts_real *end, int *count, int *named) {
    mrts_real g[K], x[K], y[K];
    int entering = 0, status = MRTS_STOPPED;
    for (int j = 0; j < K; ++j) g[j] = j == F ? sign : 0;
    check_basis(basis, rows->count);
    for (int attempt = 0; attempt < 2; ++attempt) {
        const int cold = basis[0] == 0;
        status = mrts_lp(K, rows->count, rows->A, rows->lower, rows->upper, g, basis, x, y, &entering, workspace->work,
                         workspace->integers);
        if (status == MRTS_OPTIMAL || cold) break;
        basis[0] = 0;
    }
    if (status == MRTS_INFEASIBLE) {
        named[0] = name_of(entering, entering < 0, rows, velocity);
        *count = name_rows(basis, y, rows, velocity, 1, named + 1) + 1;
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
    if (sign < 0 && !velocity && x[F] >= MRTS_UNBOUNDED * (1 - 10 * MRTS_FEASIBLE)) return @MACRO@_UNBOUNDED;
    *count = name_rows(basis, y, rows, velocity, 0, named);
    return @MACRO@_OK;
}

static @NAME@_status range_with_load(const @NAME@_sample *sample, const @NAME@_settings *settings,
                                     const mrts_real *load, @NAME@_range *range, @NAME@_workspace *workspace) {
    const mrts_limits limits = limits_of(settings);
    mrts_real column[K];
    mrts_rows rows;
    int fastest, moves = 0;
    range->lower = range->upper = 0;
    range->lower_count = range->upper_count = 0;
    if (!is_sound(sample, load)) return range->status = @MACRO@_BAD_ARGUMENT;
    const mrts_real most = velocity_cap(sample, settings, &fastest);
    mrts_form form = wrench_form(sample, load, workspace);
    if (most < 0 || !build_rows(sample, &limits, K, &form, workspace, &rows)) return range->status = @MACRO@_BAD_ARGUMENT;
    for (int i = 0; i < rows.count; ++i) moves |= rows.A[i * K + F] != 0;
    mrts_scale_columns(K, &rows, column);
    mrts_free_unknowns(K, &rows);
    mrts_bound_speed(K, most, column, &rows);
    const int velocity = most / column[F] < MRTS_UNBOUNDED ? fastest : 0;
    const int at_rest = 1 <= NO_EFFECT * column[F] || !moves;
    for (int i = 0; at_rest && i < rows.count; ++i) rows.A[i * K + F] = 0;
    range->status = solve_end(&rows, velocity, 1, workspace->lower_basis, column[F], workspace, &range->lower,
                              &range->lower_count, range->lower_rows);
    if (range->status != @MACRO@_OK) {
        range->upper_count = range->lower_count;
        for (int i = 0; i < range->lower_count; ++i) range->upper_rows[i] = range->lower_rows[i];
        range->lower_count = 0;
        return range->status;
    }
    if (!at_rest) {
        range->status = solve_end(&rows, velocity, -1, workspace->upper_basis, column[F], workspace, &range->upper,
                                  &range->upper_count, range->upper_rows);
    }
    if (at_rest || range->status == @MACRO@_UNBOUNDED) { /* only velocities bound c^2 */
        range->upper = most;
        range->upper_count = fastest != 0;
        range->upper_rows[0] = fastest;
        range->status = fastest ? @MACRO@_OK : @MACRO@_UNBOUNDED;
    }
    return range->status;
}

@NAME@_status @NAME@_range_of_sample(const @NAME@_sample *sample, const @NAME@_settings *settings, @NAME@_range *range,
                         @NAME@_workspace *workspace) {
    return range_with_load(sample, settings, settings->load, range, workspace);
}

@NAME@_status @NAME@_guaranteed_range(const @NAME@_sample *sample, const @NAME@_settings *settings,
                                  const mrts_real (*loads)[@MACRO@_LOAD], int count, @NAME@_range *range,
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
    if (lower_load != 0) *lower_load = at_lower;
    if (upper_load != 0) *upper_load = at_upper;
    return range->status;
}

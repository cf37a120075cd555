/* @NOTICE@ */
/* An infeasible sample is so at standstill too: the rows that conflict there. */
static @NAME@_status conflict_at_rest(mrts_rows *rows, @NAME@_range *range, @NAME@_workspace *workspace) {
    mrts_real column[K], end;
    int basis[K];
    for (int i = 0; i < rows->count; ++i) rows->A[i * K + F] = 0;
    mrts_scale_columns(K, rows, column);
    mrts_free_unknowns(K, rows);
    mrts_bound_speed(K, 0, column, rows);
    basis[0] = 0;
    range->status = solve_end(rows, 0, 1, basis, column[F], workspace, &end, &range->upper_count, range->upper_rows);
    if (range->status == @MACRO@_INFEASIBLE) return range->status;
    range->upper_count = 0;
    return range->status = @MACRO@_UNDECIDED;
}

/* An end of an interval more exactly, and what binds there: the furthest point (sign -1: upwards) on the tangent of the
 * curve (c^2, c) at that end, along which the rows have one unknown of speed only, as ranges without such terms. */
static void name_end(const mrts_curve *curve, mrts_rows *rows, mrts_real most, int fastest, mrts_real sign, int *basis,
                     @NAME@_workspace *workspace, mrts_real *end, int *count, int *named) {
    const mrts_real at = *end, shift = at * at;
    mrts_real column[K], found = at;
    for (int i = 0; i < rows->count; ++i) {
        const mrts_real *row = curve->A + i * curve->n;
        for (int j = 0; j < F; ++j) rows->A[i * K + j] = row[j];
        rows->A[i * K + F] = 2 * at * row[F] + row[K];
        rows->lower[i] = curve->lower[i] > -MRTS_INFINITY ? curve->lower[i] + row[F] * shift : -MRTS_INFINITY;
        rows->upper[i] = curve->upper[i] < MRTS_INFINITY ? curve->upper[i] + row[F] * shift : MRTS_INFINITY;
    }
    mrts_scale_columns(K, rows, column);
    mrts_free_unknowns(K, rows);
    mrts_bound_speed(K, most, column, rows);
    const int velocity = most / column[F] < MRTS_UNBOUNDED ? fastest : 0;
    if (solve_end(rows, velocity, sign, basis, column[F], workspace, &found, count, named) != @MACRO@_OK) *count = 0;
    if (MRTS_ABS(found - at) <= MRTS_SMALL * at) *end = found;
}

/* The range of rows with terms in c: the interval that ends at the largest c^2. */
static @NAME@_status range_of_speed(mrts_rows *rows, mrts_real most, int fastest, @NAME@_range *range,
                                    @NAME@_workspace *workspace) {
    mrts_real column[K], unit;
    mrts_interval found;
    mrts_curve curve;
    for (int i = 0; i < MRTS_CURVE_BASES; ++i) {
        check_basis(K + 1, workspace->curve_basis + i * (K + 1), rows->count + 1);
    }
    mrts_scale_columns(K, rows, column);
    range->status = speeds_of(K, rows, column, most, workspace->curve_basis, &workspace->curve_speed, workspace, &curve,
                              &unit, &found);
    if (range->status == @MACRO@_INFEASIBLE) return conflict_at_rest(rows, range, workspace);
    if (range->status == @MACRO@_UNDECIDED) return range->status;
    const mrts_real reach = most < MRTS_INFINITY ? MRTS_SQRT(most) / unit : MRTS_INFINITY;
    range->lower_count = 1;
    range->lower_rows[0] = 0;
    if (found.low > 0) {
        name_end(&curve, rows, reach, fastest, 1, workspace->lower_basis, workspace, &found.low, &range->lower_count,
                 range->lower_rows);
    }
    range->upper_count = fastest != 0;
    range->upper_rows[0] = fastest;
    if (found.high < MRTS_INFINITY) {
        name_end(&curve, rows, reach, fastest, -1, workspace->upper_basis, workspace, &found.high, &range->upper_count,
                 range->upper_rows);
    }
    range->lower = found.low * unit * (found.low * unit);
    range->upper = found.high < MRTS_INFINITY ? found.high * unit * (found.high * unit) : most;
    return range->status;
}

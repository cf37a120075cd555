/* @NOTICE@ */
/* The row that is furthest beyond its limits at a speed, as @NAME@_range names it; the speed moves onto its limit. */
static int nearest_limit(const mrts_curve *curve, const mrts_rows *rows, mrts_real *speed) {
    mrts_real most = -MRTS_INFINITY, to = *speed;
    int named = 0;
    for (int i = 0; i < rows->count; ++i) {
        const mrts_real square = curve->A[2 * i], linear = curve->A[2 * i + 1];
        const mrts_real value = (square * *speed + linear) * *speed, slope = 2 * square * *speed + linear;
        const int at_upper = value - curve->upper[i] > curve->lower[i] - value;
        const mrts_real beyond = at_upper ? value - curve->upper[i] : curve->lower[i] - value;
        if (beyond <= most) continue;
        most = beyond;
        named = at_upper ? rows->which[i] + 1 : -rows->which[i] - 1;
        to = slope != 0 ? *speed - (at_upper ? beyond : -beyond) / slope : *speed;
    }
    if (MRTS_ABS(to - *speed) <= MRTS_SMALL * *speed) *speed = to;
    return named;
}

/* The range of rows with terms in c and no unknown beside it: the interval that ends at the largest c^2. */
static @NAME@_status share_of_speed(mrts_rows *rows, mrts_real most, int fastest, @NAME@_range *range,
                                    @NAME@_workspace *workspace) {
    mrts_real column[1], unit, speed = 0;
    mrts_interval found;
    mrts_curve curve;
    int basis[2 * MRTS_CURVE_BASES] = {0};
    mrts_scale_columns(1, rows, column);
    range->status = speeds_of(1, rows, column, most, basis, &speed, workspace, &curve, &unit, &found);
    if (range->status == @MACRO@_INFEASIBLE) {
        range->upper_count = 1;
        speed = 0; /* it is so at standstill too */
        range->upper_rows[0] = nearest_limit(&curve, rows, &speed);
    }
    if (range->status != @MACRO@_OK && range->status != @MACRO@_UNBOUNDED) return range->status;
    range->lower_count = 1;
    range->lower_rows[0] = found.low > 0 ? nearest_limit(&curve, rows, &found.low) : 0;
    const int bound = !(found.high * unit * (found.high * unit) < most * (1 - MRTS_GAP));
    range->upper_rows[0] = bound ? fastest : nearest_limit(&curve, rows, &found.high);
    range->upper_count = range->upper_rows[0] != 0;
    range->lower = found.low * unit * (found.low * unit);
    range->upper = bound ? most : found.high * unit * (found.high * unit);
    return range->status;
}

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

/* The range of rows with terms in c and no unknown beside it: the intervals of c^2, the highest first. */
static @NAME@_status share_of_speed(mrts_rows *rows, mrts_real most, int fastest, @NAME@_range *range,
                                    @NAME@_workspace *workspace) {
    mrts_real column[1], ends[2 * MRTS_INTERVALS], unit, speed = 0;
    @NAME@_interval list[LIST];
    mrts_curve curve;
    int count, basis[2 * MRTS_CURVE_BASES] = {0}, told = 0;
    mrts_scale_columns(1, rows, column);
    const @NAME@_status status =
        speeds_of(1, rows, column, most, basis, &speed, workspace, &curve, &unit, &count, ends);
    if (status == @MACRO@_INFEASIBLE) {
        range->upper_count = 1;
        speed = 0; /* it is so at standstill too */
        range->upper_rows[0] = nearest_limit(&curve, rows, &speed);
    }
    if (status != @MACRO@_OK) return range->status = status;
    for (int i = count - 1; i >= 0 && told < LIST; --i, ++told) {
        @NAME@_interval *here = list + told;
        mrts_real low = ends[2 * i], high = ends[2 * i + 1];
        here->lower_from = here->upper_from = -1;
        here->lower_count = 1;
        here->lower_rows[0] = low > 0 ? nearest_limit(&curve, rows, &low) : 0;
        here->upper_rows[0] = fastest;
        const int bound = !(high * unit * (high * unit) < most * (1 - MRTS_GAP));
        if (!bound) here->upper_rows[0] = nearest_limit(&curve, rows, &high);
        here->upper_count = here->upper_rows[0] != 0;
        here->lower = low * unit * (low * unit);
        here->upper = bound ? most : high * unit * (high * unit);
    }
    return tell(list, told, range);
}

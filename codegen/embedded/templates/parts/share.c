/* @NOTICE@ */
@NAME@_status @NAME@_equal_share_range(const @NAME@_sample *sample, const @NAME@_settings *settings,
                                   @NAME@_range *range, @NAME@_workspace *workspace) {
    mrts_real turned[9], shares[@MACRO@_ROBOTS], internal[WRENCHES], *res[4];
    const mrts_real *arg[9];
    mrts_form form = mrts_form_in(1, JOINTS, WRENCHES, workspace->form);
    mrts_rows rows;
    int fastest;
    range->lower = range->upper = 0;
    range->lower_count = range->upper_count = 0;
    if (!is_sound(sample, settings->load)) return range->status = @MACRO@_BAD_ARGUMENT;
    for (int i = 0; i < @MACRO@_ROBOTS; ++i) shares[i] = (mrts_real)1 / @MACRO@_ROBOTS;
    for (int i = 0; i < WRENCHES; ++i) internal[i] = 0;
    point_to(sample, settings->load, turned, arg);
    arg[7] = shares;
    arg[8] = internal;
    res[0] = form.torque_map;
    res[1] = form.torque_offset;
    res[2] = form.wrench_map;
    res[3] = form.wrench_offset;
    @NAME@_model_fixed_distribution(arg, res);
    const mrts_real most = velocity_cap(sample, settings, &fastest);
    if (most < 0 || !build_rows(sample, settings, 0, 1, &form, workspace, &rows)) {
        return range->status = @MACRO@_BAD_ARGUMENT;
    }@SHARE_OF_SPEED@
    range->lower = 0;
    range->upper = most;
    range->lower_count = 1;
    range->lower_rows[0] = 0;
    range->upper_count = fastest != 0;
    range->upper_rows[0] = fastest;
    for (int i = 0; i < rows.count; ++i) {
        const mrts_real a = rows.A[i], lower = rows.lower[i], upper = rows.upper[i];
        const int forward = a > 0, at_lower = -rows.which[i] - 1, at_upper = rows.which[i] + 1;
        if (MRTS_ABS(a) <= NO_EFFECT) {
            if (lower <= MRTS_FEASIBLE && upper >= -MRTS_FEASIBLE) continue;
            range->upper_rows[0] = lower > 0 ? at_lower : at_upper;
            range->upper_count = 1;
            return range->status = @MACRO@_INFEASIBLE;
        }
        const mrts_real from = forward ? lower : upper, to = forward ? upper : lower;
        if (from > -MRTS_INFINITY && from < MRTS_INFINITY && from / a > range->lower) {
            range->lower = from / a;
            range->lower_rows[0] = forward ? at_lower : at_upper;
        }
        if (to > -MRTS_INFINITY && to < MRTS_INFINITY && to / a < range->upper) {
            range->upper = to / a;
            range->upper_rows[0] = forward ? at_upper : at_lower;
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

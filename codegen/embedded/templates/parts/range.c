/* @NOTICE@ */
static @NAME@_status range_with_load(const @NAME@_sample *sample, const @NAME@_settings *settings,
                                     const mrts_real *load, @NAME@_range *range, @NAME@_workspace *workspace) {
    mrts_real column[K];
    mrts_rows rows;
    int fastest;
    range->lower = range->upper = 0;
    range->lower_count = range->upper_count = 0;
    if (!is_sound(sample, load)) return range->status = @MACRO@_BAD_ARGUMENT;
    const mrts_real most = velocity_cap(sample, settings, &fastest);
    mrts_form form = wrench_form(sample, load, workspace);
    if (most < 0 || !build_rows(sample, settings, 0, K, &form, workspace, &rows)) {
        return range->status = @MACRO@_BAD_ARGUMENT;
    }@RANGE_OF_SPEED@
    mrts_scale_columns(K, &rows, column);
    mrts_free_unknowns(K, &rows);
    mrts_bound_speed(K, most, column, &rows);
    const int velocity = most / column[F] < MRTS_UNBOUNDED ? fastest : 0;
    const int at_rest = 1 <= NO_EFFECT * column[F] || rows.size[F] == 0;
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

/* @NOTICE@ */
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

/* @NOTICE@ */
void @NAME@_horizon_start(@NAME@_horizon *horizon) {
    horizon->status = @MACRO@_UNBOUNDED;
    horizon->lower = 0;
    horizon->upper = MRTS_INFINITY;
    horizon->samples = 0;
    horizon->lower_sample = horizon->upper_sample = -1;
    horizon->below_count = 0;
}

@NAME@_status @NAME@_horizon_add(@NAME@_horizon *horizon, const @NAME@_range *range) {
    const long sample = horizon->samples++;
    @NAME@_interval list[LIST], others[LIST];
    if (!has_intervals(horizon->status)) return horizon->status;
    if (!has_intervals(range->status)) {
        horizon->lower_sample = horizon->upper_sample = sample;
        return horizon->status = range->status;
    }
    list[0].lower = horizon->lower;
    list[0].upper = horizon->upper;
    list[0].lower_from = horizon->lower_sample;
    list[0].upper_from = horizon->upper_sample;
    list[0].lower_count = list[0].upper_count = 0;
    for (int i = 0; i < K + 1; ++i) list[0].lower_rows[i] = list[0].upper_rows[i] = 0;
    for (int i = 0; i < horizon->below_count; ++i) list[1 + i] = horizon->below[i];
    const int count = intersect(list, 1 + horizon->below_count, others, intervals_of(range, sample, others));
    horizon->lower = list[0].lower;
    horizon->upper = list[0].upper;
    horizon->lower_sample = list[0].lower_from;
    horizon->upper_sample = list[0].upper_from;
    horizon->below_count = count > 0 ? count - 1 : 0;
    for (int i = 0; i < horizon->below_count; ++i) horizon->below[i] = list[1 + i];
    return horizon->status = status_of(list, count);
}

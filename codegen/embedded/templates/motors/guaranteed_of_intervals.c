/* @NOTICE@ */
@NAME@_status @NAME@_guaranteed_range(const @NAME@_sample *sample, const @NAME@_settings *settings,
                                  const mrts_real (*loads)[@MACRO@_LOAD], int count, @NAME@_range *range,
                                  int *lower_load, int *upper_load, @NAME@_workspace *workspace) {
    @NAME@_range one;
    @NAME@_interval list[LIST], others[LIST];
    int common = 1, at_lower = 0, at_upper = 0;
    if (count < 1) return range->status = @MACRO@_BAD_ARGUMENT;
    for (int load = 0; load < count; ++load) {
        if (!has_intervals(range_with_load(sample, settings, loads[load], &one, workspace))) {
            *range = one;
            at_lower = at_upper = load;
            break;
        }
        if (load == 0) {
            common = intervals_of(&one, 0, list);
        } else if (common > 0) {
            common = intersect(list, common, others, intervals_of(&one, load, others));
        }
        at_lower = (int)list[0].lower_from;
        at_upper = (int)list[0].upper_from;
        if (load == count - 1) tell(list, common, range);
    }
    if (lower_load != 0) *lower_load = at_lower;
    if (upper_load != 0) *upper_load = at_upper;
    return range->status;
}

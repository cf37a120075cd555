/* @NOTICE@ */
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

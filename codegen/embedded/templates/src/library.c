/* @NOTICE@ */
#include "@NAME@_internal.h"

const char *@NAME@_status_text(@NAME@_status status) {
    switch (status) {
    case @MACRO@_OK: return "ok";
    case @MACRO@_UNBOUNDED: return "unbounded: nothing limits the speed";
    case @MACRO@_INFEASIBLE: return "infeasible: limits conflict at every speed";
    case @MACRO@_EMPTY: return "empty: no c^2 in common";
    case @MACRO@_UNDECIDED: return "undecided at this precision";
    case @MACRO@_BAD_ARGUMENT: return "bad argument";
    default: return "unknown status";
    }
}

@NAME@_status @NAME@_check_settings(const @NAME@_settings *settings) {
    if (!(settings->load[0] > 0) || !@NAME@_all_finite(@MACRO@_LOAD, settings->load) ||
        !@NAME@_all_finite(JOINTS, settings->weight)) {
        return @MACRO@_BAD_ARGUMENT;
    }
    for (int i = 0; i < ROWS; ++i) {
        if (!(settings->lower[i] <= settings->upper[i])) return @MACRO@_BAD_ARGUMENT;
    }
    for (int i = 0; i < VELOCITIES; ++i) {
        if (!(settings->velocity[i] > 0)) return @MACRO@_BAD_ARGUMENT;
    }
    for (int i = 0; i < JOINTS; ++i) {
        if (!(settings->weight[i] > 0)) return @MACRO@_BAD_ARGUMENT;
    }
    return @MACRO@_OK;
}

void @NAME@_reset(@NAME@_workspace *workspace) {
    for (int j = 0; j < K; ++j) workspace->lower_basis[j] = workspace->upper_basis[j] = 0;
}

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

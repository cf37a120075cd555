/* @NOTICE@ */
#include "@NAME@_internal.h"

#define UNLIKELY MRTS_C(1e24) /* c^2 that only rounding of rest allows: velocities are below 1e-12 of their limits */

typedef char rows_hold[HOLDS(rows, mrts_real, MRTS_ROWS_WORK(K, ROWS))];
typedef char which_holds[HOLDS(which, int, MRTS_ROWS_IWORK(ROWS))];

mrts_limits @NAME@_limits(const @NAME@_settings *settings) {
    const mrts_limits limits = {ROWS, @NAME@_row_start, @NAME@_row_column, @NAME@_row_value,
                                settings->lower, settings->upper, @NAME@_row_group};
    return limits;
}

int @NAME@_rows(const mrts_limits *limits, int unknowns, const mrts_form *form, @NAME@_workspace *workspace,
                mrts_rows *rows) {
    return mrts_rows_over(unknowns, limits, workspace->rows, workspace->which, rows) &&
           mrts_build_rows(unknowns, JOINTS, WRENCHES, form, limits, 0, rows);
}

mrts_real @NAME@_velocity_cap(const @NAME@_sample *sample, const @NAME@_settings *settings, int *named) {
    int binding;
    *named = 0;
    for (int i = 0; i < VELOCITIES; ++i) {
        if (!(settings->velocity[i] > 0)) return -1;
    }
    const mrts_real most = mrts_speed_cap(JOINTS, sample->dq, sample->twist, settings->velocity, &binding);
    if (!(most < UNLIKELY)) return MRTS_INFINITY;
    *named = 1 + ROWS + binding;
    return most;
}

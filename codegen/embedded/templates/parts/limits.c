/* @NOTICE@ */
/* The cell's limits of torques and wrenches, as mrts_limits has them. */
static const int row_start[ROWS + 1] = {@ROW_START@};
static const int row_column[@ENTRIES@] = {@ROW_COLUMN@};
static const mrts_real row_value[@ENTRIES@] = {@ROW_VALUE@};
static const int row_group[ROWS] = {@ROW_GROUP@};
@TURNING_TABLES@
#define NO_EFFECT MRTS_C(1e-30) /* an effect of c^2 = 1 on a limit below this share of it is none */
#define UNLIKELY MRTS_C(1e24) /* c^2 that only rounding of rest allows: velocities are below 1e-12 of their limits */

typedef char rows_hold[HOLDS(rows, mrts_real, MRTS_ROWS_WORK(K, ROWS))];
typedef char which_holds[HOLDS(which, int, MRTS_ROWS_IWORK(ROWS))];

/* Whether all numbers of a sample and its load are finite, and the mass is > 0. */
static int is_sound(const @NAME@_sample *sample, const mrts_real *load) {
    mrts_real sum = 0;
    for (int i = 0; i < JOINTS; ++i) sum += MRTS_ABS(sample->q[i]) + MRTS_ABS(sample->dq[i]) + MRTS_ABS(sample->ddq[i]);
    for (int i = 0; i < 6; ++i) sum += MRTS_ABS(sample->twist[i]) + MRTS_ABS(sample->acceleration[i]);
    return sum < MRTS_INFINITY && all_finite(9, sample->rotation) && all_finite(@MACRO@_LOAD, load) && load[0] > 0;
}

static mrts_limits limits_of(const @NAME@_settings *settings) {
    const mrts_limits limits = {ROWS, row_start, row_column, row_value, settings->lower, settings->upper, row_group,
                                @BASE_TABLE@, @AXES_TABLE@};
    return limits;
}

/* Largest c^2 that the velocities allow, MRTS_INFINITY if none bounds it, -1 if a limit is not > 0; `named` is the one
 * that sets it, as in @NAME@_range, 0 if none does. */
static mrts_real velocity_cap(const @NAME@_sample *sample, const @NAME@_settings *settings, int *named) {
    int binding;
    *named = 0;
    for (int i = 0; i < VELOCITIES; ++i) {
        if (!(settings->velocity[i] > 0)) return -1;
    }
    mrts_real most = mrts_speed_cap(JOINTS, sample->dq, sample->twist, settings->velocity, &binding);@MOTOR_ENDS@
    if (!(most < UNLIKELY)) return MRTS_INFINITY;
    *named = 1 + ROWS + binding;
    return most;
}

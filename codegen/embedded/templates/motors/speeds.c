/* @NOTICE@ */
typedef char curve_holds[HOLDS(curve, mrts_real, MRTS_CURVE_WORK(K, ROWS))];
typedef char curve_integers_hold[HOLDS(curve_integers, int, MRTS_CURVE_IWORK(K, ROWS))];
typedef char curve_basis_holds[HOLDS(curve_basis, int, MRTS_CURVE_BASES * (K + 1))];

/* What the speed c adds to each of the rows just built, in the workspace; whether that is anything. */
static int has_speed_terms(const @NAME@_settings *settings, const mrts_rows *rows, @NAME@_workspace *workspace) {
    const mrts_limits limits = limits_of(settings);
    const mrts_terms terms = {0, 0, 0, 0, 0, workspace->torque_speed, workspace->row_speed};
    mrts_speed_column(JOINTS, &limits, &terms, rows, workspace->by_speed);
    for (int i = 0; i < rows->count; ++i) {
        if (workspace->by_speed[i] != 0) return 1;
    }
    return 0;
}

/* The highest interval of admissible speeds of scaled rows over k unknowns, c^2 last, in the returned unit of c. */
static @NAME@_status speeds_of(int k, const mrts_rows *rows, const mrts_real *column, mrts_real most, int *basis,
                               mrts_real *speed, @NAME@_workspace *workspace, mrts_curve *curve, mrts_real *unit,
                               mrts_interval *found) {
    const mrts_real square =
        mrts_curve_over(k, rows, column, workspace->by_speed, workspace->curve, workspace->curve_integers, curve);
    mrts_real end_dual[2 * (K + 1)];
    int end_basis[2 * (K + 1)];
    mrts_curve_ends start = {0, basis, end_basis, end_dual};
    *unit = square > 0 ? MRTS_SQRT(square) : 1;
    if (*speed > 0 && *speed < MRTS_INFINITY) start.speed = *speed / *unit;
    const mrts_real fastest = most < MRTS_INFINITY ? MRTS_SQRT(most) / *unit : MRTS_INFINITY;
    const int status = mrts_highest_interval(curve, fastest, &start, found);
    *speed = start.speed * *unit;
    if (status == MRTS_INFEASIBLE) return @MACRO@_INFEASIBLE;
    if (status != MRTS_OPTIMAL) return @MACRO@_UNDECIDED;
    if (found->low <= MRTS_FEASIBLE) found->low = 0; /* that moves no row by more than rounding */
    return found->high < MRTS_INFINITY || most < MRTS_INFINITY ? @MACRO@_OK : @MACRO@_UNBOUNDED;
}

/* @NOTICE@ */
#ifdef MRTS_SINGLE
#define TORQUE_WIDENING MRTS_C(1e-5) /* of limits: at the end of a range the feasible set is a point */
#else
#define TORQUE_WIDENING 1e-9
#endif

typedef char qp_work_holds[HOLDS(work, mrts_real, MRTS_QP_WORK(F))];
typedef char qp_integers_hold[HOLDS(integers, int, MRTS_QP_IWORK(F, ROWS))];

@NAME@_status @NAME@_torques(const @NAME@_sample *sample, const @NAME@_settings *settings, mrts_real c2,
                         mrts_real torque[@MACRO@_JOINTS], mrts_real wrench[@MACRO@_WRENCHES],
                         @NAME@_workspace *workspace) {
    const mrts_limits limits = limits_of(settings);
    mrts_real column[K], x[K], u[K], g[K], H[K * K], at_rest[JOINTS], largest = 0;
    mrts_rows rows;
    int active[K], count = 0, fastest, status = MRTS_OPTIMAL;
    for (int i = 0; i < JOINTS; ++i) torque[i] = 0;
    for (int i = 0; i < WRENCHES; ++i) wrench[i] = 0;
    if (!(c2 >= 0 && c2 < MRTS_INFINITY) || !is_sound(sample, settings->load)) return @MACRO@_BAD_ARGUMENT;
    const mrts_real most = velocity_cap(sample, settings, &fastest);
    mrts_form form = wrench_form(sample, settings->load, workspace);
    if (most < 0 || !build_rows(sample, settings, c2, K, &form, workspace, &rows)) return @MACRO@_BAD_ARGUMENT;
    mrts_fix_speed(K, &limits, c2, TORQUE_WIDENING, &rows);
    mrts_scale_columns(F, &rows, column);
    mrts_free_unknowns(F, &rows);
    for (int i = 0; i < JOINTS; ++i) at_rest[i] = form.torque_map[F * JOINTS + i] * c2 + form.torque_offset[i];
    for (int j = 0; j < F; ++j) {
        mrts_real *map = form.torque_map + j * JOINTS;
        g[j] = 0;
        for (int i = 0; i < JOINTS; ++i) {
            map[i] *= column[j];
            g[j] += settings->weight[i] * map[i] * at_rest[i];
        }
        for (int l = 0; l <= j; ++l) {
            mrts_real sum = 0;
            for (int i = 0; i < JOINTS; ++i) sum += settings->weight[i] * map[i] * form.torque_map[l * JOINTS + i];
            H[j * F + l] = H[l * F + j] = sum;
            if (MRTS_ABS(sum) > largest) largest = MRTS_ABS(sum);
        }
    }
    for (int i = 0; largest > 0 && i < F * F; ++i) H[i] /= largest;
    for (int j = 0; largest > 0 && j < F; ++j) g[j] /= largest;
    for (int j = 0; j < K; ++j) x[j] = 0;
    if (F > 0) {
        status = mrts_qp(F, rows.count, H, rows.A, rows.lower, rows.upper, g, x, active, u, &count, workspace->work,
                         workspace->integers);
    }
    for (int i = 0; F == 0 && i < rows.count; ++i) { /* one arm: nothing to choose */
        if (!(rows.lower[i] <= MRTS_FEASIBLE) || !(rows.upper[i] >= -MRTS_FEASIBLE)) status = MRTS_INFEASIBLE;
    }
    if (c2 > most * (1 + 2 * TORQUE_WIDENING)) status = MRTS_INFEASIBLE;
    for (int i = 0; i < JOINTS; ++i) {
        torque[i] = at_rest[i];
        for (int j = 0; j < F; ++j) torque[i] += x[j] * form.torque_map[j * JOINTS + i];
    }
    for (int i = 0; i < WRENCHES; ++i) {
        wrench[i] = form.wrench_map[F * WRENCHES + i] * c2 + form.wrench_offset[i];
        for (int j = 0; j < F; ++j) wrench[i] += x[j] * column[j] * form.wrench_map[j * WRENCHES + i];
    }
    if (!all_finite(JOINTS, torque) || !all_finite(WRENCHES, wrench)) return @MACRO@_UNDECIDED;
    return status == MRTS_OPTIMAL ? @MACRO@_OK : status == MRTS_INFEASIBLE ? @MACRO@_INFEASIBLE : @MACRO@_UNDECIDED;
}

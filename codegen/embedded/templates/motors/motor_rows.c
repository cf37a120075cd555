/* @NOTICE@ */
/* What motors add at a sample, in the workspace: to torques and rows with the speed c at a value, what c adds to each of
 * them, and by how much dry friction in both directions narrows limits. */
static mrts_terms motor_terms(const @NAME@_sample *sample, const @NAME@_settings *settings, mrts_real speed,
                              @NAME@_workspace *workspace) {
    mrts_real turning[JOINTS];
    mrts_terms terms;
    for (int joint = 0; joint < JOINTS; ++joint) {
        const mrts_real viscous = settings->viscous[joint] * sample->dq[joint];
        workspace->torque_square[joint] = settings->armature[joint] * sample->ddq[joint];
        workspace->torque_offset[joint] = dry_friction(sample, settings, joint, &turning[joint]) + viscous * speed;
        workspace->torque_speed[joint] = viscous;
    }
    for (int row = 0; row < ROWS; ++row) {
        workspace->row_margin[row] = workspace->row_speed[row] = 0;
        for (int entry = row_start[row]; entry < row_start[row + 1]; ++entry) {
            const int joint = row_column[entry];
            if (joint < JOINTS) workspace->row_margin[row] += MRTS_ABS(row_value[entry]) * turning[joint];
        }
    }@LINE_TERMS@
    for (int row = 0; row < ROWS; ++row) workspace->row_offset[row] = workspace->row_speed[row] * speed;
    terms.torque_square = workspace->torque_square;
    terms.torque_offset = workspace->torque_offset;
    terms.square = 0;
    terms.offset = workspace->row_offset;
    terms.margin = workspace->row_margin;
    terms.torque_speed = workspace->torque_speed;
    terms.speed = workspace->row_speed;
    return terms;
}

/* Rows of the limits in `unknowns` unknowns of a form, in the workspace; 0 if limits are reversed or a number is not
 * finite. What the speed c adds to them is in their limits. */
static int build_rows(const @NAME@_sample *sample, const @NAME@_settings *settings, mrts_real c2, int unknowns,
                      mrts_form *form, @NAME@_workspace *workspace, mrts_rows *rows) {
    const mrts_limits limits = limits_of(settings);
    const mrts_terms terms = motor_terms(sample, settings, MRTS_SQRT(c2), workspace);
    mrts_turn_wrenches(unknowns, @MACRO@_ROBOTS, @MACRO@_WRENCH, &limits, sample->rotation, 3, 1, @TURNED@, form);
    mrts_add_motors(unknowns, JOINTS, &terms, form);
    return (int)sample->place >= 0 && sample->place <= @MACRO@_END && all_finite(JOINTS, terms.torque_square) &&
           all_finite(JOINTS, terms.torque_offset) && all_finite(JOINTS, terms.torque_speed) &&
           all_finite(ROWS, terms.offset) && all_finite(ROWS, terms.margin) && all_finite(ROWS, terms.speed) &&
           mrts_rows_over(unknowns, &limits, workspace->rows, workspace->which, rows) &&
           mrts_build_rows(unknowns, JOINTS, WRENCHES, form, &limits, &terms, rows);
}

/* @NOTICE@ */
/* Rows of the limits in `unknowns` unknowns of a form, in the workspace; 0 if limits are reversed or a coefficient is
 * not finite. Ideal motors add nothing, at no speed. */
static int build_rows(const @NAME@_sample *sample, const @NAME@_settings *settings, mrts_real c2, int unknowns,
                      mrts_form *form, @NAME@_workspace *workspace, mrts_rows *rows) {
    static const mrts_terms nothing = {0, 0, 0, 0, 0, 0, 0};
    const mrts_limits limits = limits_of(settings);
    (void)c2;
    mrts_turn_wrenches(unknowns, @MACRO@_ROBOTS, @MACRO@_WRENCH, &limits, sample->rotation, 3, 1, @TURNED@, form);
    return mrts_rows_over(unknowns, &limits, workspace->rows, workspace->which, rows) &&
           mrts_build_rows(unknowns, JOINTS, WRENCHES, form, &limits, &nothing, rows);
}

/* @NOTICE@ */
typedef char form_holds[HOLDS(form, mrts_real, MRTS_FORM_WORK(K, JOINTS, WRENCHES))];

/* The wrench form of a sample, in the workspace. */
static mrts_form wrench_form(const @NAME@_sample *sample, const mrts_real *load, @NAME@_workspace *workspace) {
    mrts_real turned[9];
    const mrts_real *arg[7];
    mrts_real *res[4];
    const mrts_form form = mrts_form_in(K, JOINTS, WRENCHES, workspace->form);
    point_to(sample, load, turned, arg);
    res[0] = form.torque_map;
    res[1] = form.torque_offset;
    res[2] = form.wrench_map;
    res[3] = form.wrench_offset;
    @NAME@_model_wrench_form(arg, res);
    return form;
}

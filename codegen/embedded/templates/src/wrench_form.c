/* @NOTICE@ */
#include "@NAME@_internal.h"
#include "@NAME@_model.h"

mrts_form @NAME@_wrench_form(const @NAME@_sample *sample, const mrts_real *load, @NAME@_workspace *workspace) {
    mrts_real turned[9];
    const mrts_real *arg[7];
    mrts_real *res[4];
    mrts_form form;
    @NAME@_point_to(sample, load, turned, arg);
    res[0] = form.torque_map = workspace->form;
    res[1] = form.torque_offset = form.torque_map + K * JOINTS;
    res[2] = form.wrench_map = form.torque_offset + JOINTS;
    res[3] = form.wrench_offset = form.wrench_map + K * WRENCHES;
    @NAME@_model_wrench_form(arg, res);
    return form;
}

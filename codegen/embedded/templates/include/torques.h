/* Torques and contact wrenches with the least t'Wt at a c^2 of the range; only with @MACRO@_OK do they keep the
 * limits. */
@NAME@_status @NAME@_torques(const @NAME@_sample *sample, const @NAME@_settings *settings, @NAME@_real c2,
                         @NAME@_real torque[@MACRO@_JOINTS], @NAME@_real wrench[@MACRO@_WRENCHES],
                         @NAME@_workspace *workspace);

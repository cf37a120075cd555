    @NAME@_real torque_square[@MACRO@_JOINTS], torque_offset[@MACRO@_JOINTS], torque_speed[@MACRO@_JOINTS];
    @NAME@_real row_offset[@MACRO@_ROWS], row_margin[@MACRO@_ROWS], row_speed[@MACRO@_ROWS], by_speed[@MACRO@_ROWS];
    @NAME@_real curve[(@MACRO@_ROWS + 1) * (@MACRO@_UNKNOWNS + 1) + 2 * (@MACRO@_ROWS + @MACRO@_UNKNOWNS + 2) +
                      (@MACRO@_UNKNOWNS + 1) * (@MACRO@_UNKNOWNS + 5)];
    @NAME@_real curve_speed;

    @NAME@_real slope[@MACRO@_LINES];    /* of torque-speed lines |torque| <= upper - slope |q'| r', >= 0 */

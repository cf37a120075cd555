    @NAME@_real armature[@MACRO@_JOINTS]; /* of motors: rotor inertia times gear ratio squared, kg m^2 or kg, >= 0 */
    @NAME@_real coulomb[@MACRO@_JOINTS]; /* dry friction, N m or N, >= 0 */
    @NAME@_real viscous[@MACRO@_JOINTS]; /* friction that grows with the speed, N m s/rad or N s/m, >= 0 */
    @NAME@_real rest_speed;              /* |q'| up to which a joint stands, rad/s or m/s, >= 0 */
    @NAME@_real rest_acceleration;       /* |q''| up to which it then does not leave, >= 0 */

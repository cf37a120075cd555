/* @NOTICE@
 * The cell's names, numbers and limits of torques and wrenches, as mrts_limits has them. */
static const char *const ROW_TEXT[1 + CELL_ROWS + CELL_VELOCITIES + CELL_MOTIONS] = @ROW_TEXT@;
static const cell_settings DEFAULTS = {
    @LOAD@,
    @LOWER@,
    @UPPER@,
    @VELOCITY@,
    @WEIGHT@,
#if CELL_MOTORS
    @ARMATURE@,
    @COULOMB@,
    @VISCOUS@,
    @REST@,
    @REST@,
    CELL_UNLIMITED,
#if CELL_LINES
    @SLOPE@,
#endif
#endif
#if CELL_MOTIONS
    @ACCELERATION_LOWER@,
    @ACCELERATION_UPPER@,
    @OBJECT_ACCELERATION@,
#endif
#if CELL_POINTS
    @POINT_SPEED@,
    @POINT_ACCELERATION@,
#endif
#if CELL_THINGS
    @FRICTION@,
    @TILT@,
#endif
};
static const int row_start[CELL_ROWS + 1] = @ROW_START@;
static const int row_column[@ENTRIES@] = @ROW_COLUMN@;
static const cell_real row_value[@ENTRIES@] = @ROW_VALUE@;
static const int row_group[CELL_ROWS] = @ROW_GROUP@;
#if CELL_TURNED
static const cell_real base_rotation[9 * CELL_ROBOTS] = @BASE@;
static const int triple_axes[3] = @AXES@;
#endif
#if CELL_LINES
static const int line_row[CELL_LINES] = @LINE_ROWS@, line_joint[CELL_LINES] = @LINE_JOINTS@;
#endif
#if CELL_ENDS
static const int end_joint[CELL_ENDS] = @END_JOINTS@;
#endif
#if CELL_POINTS
/* Arms with every joint at zero, axes and a point on each. Points: first joint of the arm, how many move it (0: it is one of
 * the object), and where it is, with every joint at zero in base axes or in the object's frame. */
static const cell_real joint_axis[3 * CELL_JOINTS] = @JOINT_AXIS@, joint_point[3 * CELL_JOINTS] = @JOINT_POINT@;
static const int joint_slides[CELL_JOINTS] = @JOINT_SLIDES@;
static const int point_first[CELL_POINTS] = @POINT_FIRST@, point_joints[CELL_POINTS] = @POINT_JOINTS@;
static const cell_real point_place[3 * CELL_POINTS] = @POINT_PLACE@;
#endif
#if CELL_THINGS
/* Of each thing the axes a, b, n as rows and the centre of mass, in the object's frame. */
static const cell_real thing_axes[9 * CELL_THINGS] = @THING_AXES@, thing_centre[3 * CELL_THINGS] = @THING_CENTRE@;
static const cell_real gravity[3] = @GRAVITY@;
#endif
const cell_real cell_load_corners[CELL_CORNERS][CELL_LOAD] = @LOAD_CORNERS@;

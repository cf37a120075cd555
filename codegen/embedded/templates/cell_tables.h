/* @NOTICE@
 * The cell's names, numbers and limits of torques and wrenches, as mrts_limits has them. */
static const char *const ROW_TEXT[1 + CELL_ROWS + CELL_VELOCITIES] = {
    "c^2 >= 0",
@ROW_TEXT@
};
static const cell_settings DEFAULTS = {
    {@LOAD@},
    {@LOWER@},
    {@UPPER@},
    {@VELOCITY@},
    {@WEIGHT@},
#if CELL_MOTORS
    {@ARMATURE@},
    {@COULOMB@},
    {@VISCOUS@},
    @REST@,
    @REST@,
#if CELL_LINES
    {@SLOPE@},
#endif
    CELL_UNLIMITED,
#endif
};
#if CELL_HAS_ROWS
static const int row_start[CELL_ROWS + 1] = {@ROW_START@};
static const int row_column[@ENTRIES@] = {@ROW_COLUMN@};
static const cell_real row_value[@ENTRIES@] = {@ROW_VALUE@};
static const int row_group[CELL_ROWS] = {@ROW_GROUP@};
#if CELL_TURNED
static const cell_real base_rotation[9 * CELL_ROBOTS] = {@BASE@};
static const int triple_axes[3] = {@AXES@};
#endif
#if CELL_LINES
static const int line_row[CELL_LINES] = {@LINE_ROWS@}, line_joint[CELL_LINES] = {@LINE_JOINTS@};
#endif
#if CELL_ENDS
static const int end_joint[CELL_ENDS] = {@END_JOINTS@};
#endif
#endif
#if CELL_HAS_RANGE
const cell_real cell_load_corners[CELL_CORNERS][CELL_LOAD] = {
@LOAD_CORNERS@
};
#endif

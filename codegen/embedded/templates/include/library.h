/* @NOTICE@
 *
 * Time scaling of the cell "@NAME@" on a controller: @ROBOTS@ arms hold one object, a motion q(r), r = c t, is
 * given, and c^2 must keep torques, contact wrenches and velocities inside their limits. Link with
 * src/@NAME@.c and src/@NAME@_model.c.
 *
 * Units: m, rad, s, kg, N, N m. Derivatives q', q'' are those of the motion as given (c = 1). World axes unless said
 * otherwise; contact wrenches are what an arm exerts on the object at its contact, in the axes of that arm's base.
 * Every function is re-entrant: it writes only to its arguments. Iterations are bounded. Nothing is allocated.
 */
#ifndef @MACRO@_H
#define @MACRO@_H

#ifdef __cplusplus
extern "C" {
#endif

typedef @REAL@ @NAME@_real;

#define @MACRO@_ROBOTS @ROBOTS@
#define @MACRO@_JOINTS @JOINTS@      /* of all arms, in the order of the cell file */
#define @MACRO@_WRENCH @SIZE@       /* components of one contact wrench: @COMPONENTS@ */
#define @MACRO@_WRENCHES @WRENCHES@     /* components of all contact wrenches, arm after arm */
#define @MACRO@_UNKNOWNS @UNKNOWNS@     /* of the programs: all wrenches but the last arm's, and c^2 */
#define @MACRO@_ROWS @ROWS@        /* limits of torques and wrenches, in the order of the cell's limits */@MOTOR_COUNT@
#define @MACRO@_VELOCITIES (@MACRO@_JOINTS + 2@MORE_VELOCITIES@) /* of all joints, and the object's linear and angular one@AND_ENDS@ */
#define @MACRO@_LOAD 10        /* mass, mx, my, mz (mass times com), ixx, iyy, izz, ixy, ixz, iyz (about the origin) */
#define @MACRO@_CORNERS @CORNERS@      /* corners of the cell file's load variation; 1 if it has none */
#define @MACRO@_UNLIMITED @UNLIMITED@ /* an absent limit is this, or its negative */

typedef enum {
    @MACRO@_OK = 0,
    @MACRO@_UNBOUNDED = 1,   /* feasible, and nothing bounds c^2 from above: upper is @MACRO@_UNLIMITED */
    @MACRO@_INFEASIBLE = 2,  /* no c^2: the rows named conflict, whatever the speed */
    @MACRO@_EMPTY = 3,       /* samples or loads are feasible one by one, but have no c^2 in common */
    @MACRO@_UNDECIDED = 4,   /* the data are too close to infeasible, or too badly scaled, for this precision */
    @MACRO@_BAD_ARGUMENT = 5 /* not finite, a reversed limit, a mass, weight or velocity limit that is not > 0, c^2 < 0 */
} @NAME@_status;@MOTOR_PLACE@

/* One sample of the given motion. */
typedef struct {
    @NAME@_real q[@MACRO@_JOINTS];       /* rad or m */
    @NAME@_real dq[@MACRO@_JOINTS];      /* q' */
    @NAME@_real ddq[@MACRO@_JOINTS];     /* q'' */
    @NAME@_real rotation[9];             /* of the object in the world, row after row */
    @NAME@_real twist[6];                /* p' and the angular velocity of the object */
    @NAME@_real acceleration[6];         /* p'' and the angular acceleration */@MOTOR_SAMPLE@
} @NAME@_sample;

/* What may change at run time. Start from @NAME@_default_settings. */
typedef struct {
    @NAME@_real load[@MACRO@_LOAD];
    @NAME@_real lower[@MACRO@_ROWS];     /* in the row's unit; -@MACRO@_UNLIMITED where there is none */
    @NAME@_real upper[@MACRO@_ROWS];
    @NAME@_real velocity[@MACRO@_VELOCITIES]; /* > 0, rad/s or m/s; @MACRO@_UNLIMITED where none is enforced */
    @NAME@_real weight[@MACRO@_JOINTS];  /* diagonal of W in t'Wt, > 0 */@MOTOR_SETTINGS@@LINE_SETTINGS@
} @NAME@_settings;

/* Range of c^2. Rows are 1 + row at an upper and -1 - row at a lower limit, the strongest first; 0 stands for c^2 >= 0,
 * 1 + @MACRO@_ROWS + i for velocity i, of several that bind for the first. Of an infeasible sample `upper_rows` are the
 * rows in conflict. */
typedef struct {
    @NAME@_status status;
    @NAME@_real lower;
    @NAME@_real upper;
    int lower_count, upper_count;
    int lower_rows[@MACRO@_UNKNOWNS + 1];
    int upper_rows[@MACRO@_UNKNOWNS + 1];
} @NAME@_range;

/* Work of the caller: one for each thread of control. Set it to zero, or call @NAME@_reset, before the first use; what
 * it keeps from call to call only makes the next call faster. */
typedef struct {
    int lower_basis[@MACRO@_UNKNOWNS], upper_basis[@MACRO@_UNKNOWNS];
    int which[@MACRO@_ROWS], integers[@MACRO@_ROWS + 6 * @MACRO@_UNKNOWNS];@MOTOR_INTEGERS@
    @NAME@_real form[(@MACRO@_UNKNOWNS + 1) * (@MACRO@_JOINTS + @MACRO@_WRENCHES)];
@TURNED_FIELD@    @NAME@_real rows[@MACRO@_ROWS * (@MACRO@_UNKNOWNS + 3) + 3 * @MACRO@_UNKNOWNS];
    @NAME@_real work[3 * @MACRO@_UNKNOWNS * @MACRO@_UNKNOWNS + 7 * @MACRO@_UNKNOWNS];@MOTOR_WORKSPACE@
} @NAME@_workspace;

const char *@NAME@_status_text(@NAME@_status status);
/* Such as "left/elbow torque"; row as in @NAME@_range, 0 is "c^2 >= 0". */
const char *@NAME@_row_text(int row);
/* Load, limits and unit weights of the cell file. */
void @NAME@_default_settings(@NAME@_settings *settings);
/* @MACRO@_OK or @MACRO@_BAD_ARGUMENT: call it once after settings have changed. */
@NAME@_status @NAME@_check_settings(const @NAME@_settings *settings);
void @NAME@_reset(@NAME@_workspace *workspace);

/* A horizon of samples, fed one by one: the intersection of their ranges. */
typedef struct {
    @NAME@_status status;
    @NAME@_real lower, upper;
    long samples, lower_sample, upper_sample; /* how many, and which set the ends; -1 where none does */
} @NAME@_horizon;

void @NAME@_horizon_start(@NAME@_horizon *horizon);
@NAME@_status @NAME@_horizon_add(@NAME@_horizon *horizon, const @NAME@_range *range);

@DECLARATIONS@
#ifdef __cplusplus
}
#endif

#endif

typedef @REAL@ cell_real;

#define CELL_SINGLE @SINGLE@      /* 1 of float, 0 of double */
#define CELL_ROBOTS @ROBOTS@
#define CELL_JOINTS @JOINTS@      /* of all arms, in the order of the cell file */
#define CELL_WRENCH @SIZE@       /* components of one contact wrench: @COMPONENTS@ */
#define CELL_WRENCHES @WRENCHES@     /* components of all contact wrenches, arm after arm */
#define CELL_UNKNOWNS @UNKNOWNS@     /* of the programs: all wrenches but the last arm's, and c^2 */
#define CELL_ROWS @ROWS@        /* limits of torques and wrenches, in the order of the cell's limits */
#define CELL_TURNED @TURNED@      /* 1 where some are of wrenches in object axes */
#define CELL_MOTORS @MOTORS@      /* 1 where motors have armature, friction or torque-speed curves */
#define CELL_LINES @LINES@       /* lines of torque-speed curves: rows that fall with the speed */
#define CELL_ENDS @ENDS@        /* ends of torque-speed curves */
#define CELL_VELOCITIES (CELL_JOINTS + 2 + CELL_ENDS) /* of all joints, the object's linear and angular one, and these ends */
#define CELL_POINTS @POINTS@      /* points of arms and object whose motion is limited */
#define CELL_THINGS @THINGS@      /* things that stand loose on the object */
#define CELL_MOTIONS @MOTIONS@     /* limits of accelerations, points and things */
#define CELL_LOAD 10        /* mass, mx, my, mz (mass times com), ixx, iyy, izz, ixy, ixz, iyz (about the origin) */
#define CELL_CORNERS @CORNERS@      /* corners of the cell file's load variation; 1 if it has none */
#define CELL_UNLIMITED @UNLIMITED@ /* an absent limit is this, or its negative */

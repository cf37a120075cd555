/* SPDX-License-Identifier: MIT
 *
 * Arms of a cell and its generated functions; their sizes and names are macros, see cell_macros of c_text.py. */
#ifndef MRTS_CELL_SIZES_H
#define MRTS_CELL_SIZES_H

/* One arm in its place: rotation matrices by rows. */
typedef struct {
    double base_rotation[9]; /* in the world */
    double base_position[3]; /* likewise [m] */
    double tip_rotation[9];  /* of the grasp in the object frame */
    double tip_position[3];  /* likewise [m] */
} mrts_arm;

/* Where an arm's joints begin. */
static const int mrts_first_joints[MRTS_ROBOTS + 1] = MRTS_FIRST_JOINTS;
#define MRTS_FIRST(robot) mrts_first_joints[robot]

/* A geometry is gravity in the world [m/s^2], the arms, and what joints that are held place. */
#define MRTS_GRAVITY 3
#define MRTS_ARM(geometry, robot) ((const mrts_arm *)((geometry) + MRTS_GRAVITY) + (robot))

/* Places of inputs of a moving sample: q, dq, ddq, rotation, twist, acceleration, load, and what a function takes besides. */
enum { MRTS_DQ = 1, MRTS_DDQ, MRTS_ROTATION, MRTS_TWIST, MRTS_ACCELERATION };

/* A generated function: inputs and outputs. Matrices by columns. */
#define MRTS_GENERATED(name) void name(const double *const *arg, double *const *res)

/* The last input of each is the geometry, see mrts_arm; functions into which it is folded do not read it. */
/* q to positions and rotations of the tips and the Jacobians of all arms side by side. */
MRTS_GENERATED(MRTS_KINEMATICS);
/* q, q' to J' q' of each arm. */
MRTS_GENERATED(MRTS_BIAS_ACCELERATION);
#ifdef MRTS_REDUNDANT
/* q, F to d(J'F)/dq, and q, q', F to the second derivative along q'. */
MRTS_GENERATED(MRTS_GEOMETRIC_STIFFNESS);
MRTS_GENERATED(MRTS_GEOMETRIC_STIFFNESS_RATE);
#endif

#endif

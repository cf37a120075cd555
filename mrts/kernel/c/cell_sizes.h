/* SPDX-License-Identifier: MIT
 *
 * Sizes of a cell and its generated functions. A cell's library defines them before; where a file is read or checked
 * alone, they are those of a sample: two spatial arms of seven joints.
 */
#ifndef MRTS_CELL_SIZES_H
#define MRTS_CELL_SIZES_H

#ifndef MRTS_JOINTS
#define MRTS_ROBOTS 2                  /* arms */
#define MRTS_SIZE 6                    /* components of one wrench */
#define MRTS_JOINTS 14                 /* of all arms */
#define MRTS_WRENCHES 12               /* components of all wrenches */
#define MRTS_UNKNOWNS 7                /* of the range: wrenches of all arms but the last, and c^2 */
#define MRTS_MOST_JOINTS 7             /* of the longest arm */
#define MRTS_FIRST_JOINTS {0, 7, 14}   /* where each arm's joints begin, and their number last */
#define MRTS_INPUTS 8                  /* of the wrench form */
#define MRTS_INPUT_SIZES {14, 14, 14, 9, 6, 6, 10, 51} /* numbers of each */
#define MRTS_INPUT_NUMBERS 124         /* of all */
#define MRTS_GEOMETRY_NUMBERS 51       /* of the geometry that functions read */
#define MRTS_UNEVEN 1                  /* defined if an arm has other than as many joints as a wrench components */
#define MRTS_REDUNDANT 1               /* defined if an arm has more */
#define MRTS_KINEMATICS sample_kinematics
#define MRTS_BIAS_ACCELERATION sample_bias_acceleration
#define MRTS_WRENCH_FORM_LANES sample_wrench_form_lanes
#define MRTS_KINEMATICS_LANES sample_kinematics_lanes
#define MRTS_BIAS_ACCELERATION_LANES sample_bias_acceleration_lanes
#define MRTS_GEOMETRIC_STIFFNESS sample_geometric_stiffness
#define MRTS_GEOMETRIC_STIFFNESS_RATE sample_geometric_stiffness_rate
#endif

/* One arm in its place: rotation matrices by rows. */
typedef struct {
    double base_rotation[9]; /* in the world */
    double base_position[3]; /* likewise [m] */
    double tip_rotation[9];  /* of the grasp in the object frame */
    double tip_position[3];  /* likewise [m] */
} mrts_arm;

/* A geometry is gravity in the world [m/s^2], the arms, and what joints that are held place. */
#define MRTS_GRAVITY 3
#define MRTS_ARM(geometry, robot) ((const mrts_arm *)((geometry) + MRTS_GRAVITY) + (robot))

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

/* @NOTICE@ */
#ifndef CELL_VECTORS_H
#define CELL_VECTORS_H

#include "cell.h"

#define CELL_VECTORS @VECTORS@
#define CELL_PATH_SAMPLES @PATH_SAMPLES@ /* the first ones: one motion with the load of the cell file */
#if CELL_MOTORS
#define CELL_REST_SPEED @REST_SPEED@ /* of their motion: what is rounding of rest */
#define CELL_REST_ACCELERATION @REST_ACCELERATION@
#endif

/* A sample, the mass of its load, and what the Python runtime of mrts finds: status and ends of the range, free and
 * with equal shares, and the torques at one c^2 (0: not compared). */
typedef struct {
    cell_sample sample;
    cell_real mass;
    int status;
    cell_real lower, upper;
    int share_status;
    cell_real share_lower, share_upper;
    cell_real c2;
    cell_real torque[CELL_JOINTS];
} cell_vector;

static const cell_vector cell_vectors[CELL_VECTORS] = @VECTOR_ROWS@;

#endif

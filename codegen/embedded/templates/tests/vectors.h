/* @NOTICE@ */
#ifndef @MACRO@_VECTORS_H
#define @MACRO@_VECTORS_H

#include "@NAME@.h"

#define @MACRO@_VECTORS @VECTORS@
#define @MACRO@_PATH_SAMPLES @PATH_SAMPLES@ /* the first ones: one motion with the load of the cell file */@REST_OF_VECTORS@

/* A sample, the mass of its load, and what the Python runtime of mrts finds: status and ends of the range, free and
 * with equal shares, and the torques at one c^2 (0: not compared). */
typedef struct {
    @NAME@_sample sample;
    @NAME@_real mass;
    int status;
    double lower, upper;
    int share_status;
    double share_lower, share_upper;
    double c2;
    double torque[@MACRO@_JOINTS];
} @NAME@_vector;

static const @NAME@_vector @NAME@_vectors[@MACRO@_VECTORS] = {
@VECTOR_ROWS@
};

#endif

/* @NOTICE@
 * What the kernel's files in kernel/ are compiled with, and the sizes of the cell. */
#ifndef @MACRO@_CONFIG_H
#define @MACRO@_CONFIG_H

#include "@NAME@.h"

#define MRTS_REAL @NAME@_real
#if @SINGLE@
#define MRTS_SINGLE
#endif
#define MRTS_LOCAL @LINKAGE@

enum {
    JOINTS = @MACRO@_JOINTS,
    WRENCHES = @MACRO@_WRENCHES,
    ROWS = @MACRO@_ROWS,
    VELOCITIES = @MACRO@_VELOCITIES,@MOTOR_SIZES@
    K = @MACRO@_UNKNOWNS,
    F = @MACRO@_UNKNOWNS - 1
};

/* Size of an array, or an error at compile time where the workspace does not hold what the kernel asks for. */
#define HOLDS(field, type, count) (sizeof(((@NAME@_workspace *)0)->field) >= (count) * sizeof(type) ? 1 : -1)

#endif

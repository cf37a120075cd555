/* @NOTICE@ */
#include "cell_model.h"

#include <math.h>

#define MRTS_MODEL(name, signature) void name(const cell_real *const *arg, cell_real *const *res)
#define MRTS_NUMBER cell_real
#define MRTS_CONSTANT(value) ((cell_real)(value))
#if CELL_SINGLE
#define MRTS_MATH(function, a) function##f(a)
#else
#define MRTS_MATH(function, a) function(a)
#endif
#define MRTS_SIN(joint, a) MRTS_MATH(sin, a)
#define MRTS_COS(joint, a) MRTS_MATH(cos, a)

@MODEL@

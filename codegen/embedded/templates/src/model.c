/* @NOTICE@ */
#include "@NAME@_model.h"

#include <math.h>

#define MRTS_MODEL(name, signature) void name(const @NAME@_real *const *arg, @NAME@_real *const *res)
#define MRTS_NUMBER @NAME@_real
#define MRTS_CONSTANT(value) ((@NAME@_real)(value))
#define MRTS_MATH(function, a) function@MODEL_SUFFIX@(a)
#define MRTS_SIN(joint, a) MRTS_MATH(sin, a)
#define MRTS_COS(joint, a) MRTS_MATH(cos, a)

@MODEL@

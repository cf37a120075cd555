/* @NOTICE@ */
#ifndef @MACRO@_MODEL_H
#define @MACRO@_MODEL_H

#include "@NAME@.h"

/* Matrices are column after column; see the source for inputs and outputs. */
@MODEL_PROTOTYPES@
#endif

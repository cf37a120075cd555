/* @NOTICE@ */
#include "@NAME@_model.h"

#include <math.h>

@MODEL@

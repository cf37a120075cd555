/* @NOTICE@
 * All but the model as one text, which is faster: the sizes of the cell are constants in the kernel too. */
#include "@NAME@_config.h"
#include "@NAME@_model.h"

#include "kernel/numbers.h"
@INCLUDES@

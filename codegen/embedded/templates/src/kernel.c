/* @NOTICE@
 * The kernel of mrts, as it answers on the desktop. */
#include "@NAME@_config.h"

@KERNEL_INCLUDES@

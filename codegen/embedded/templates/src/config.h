/* @NOTICE@
 * What the kernel's files in kernel/ are compiled with: the type of their numbers, and names of this library's own, so
 * that several libraries can be linked together. */
#ifndef @MACRO@_CONFIG_H
#define @MACRO@_CONFIG_H

#include "@NAME@.h"

#define MRTS_REAL @NAME@_real
#if @SINGLE@
#define MRTS_SINGLE
#endif

#define mrts_lp @NAME@_kernel_lp
#define mrts_lp_value @NAME@_kernel_lp_value
#define mrts_lp_price @NAME@_kernel_lp_price
#define mrts_qp @NAME@_kernel_qp
#define mrts_rows_over @NAME@_kernel_rows_over
#define mrts_build_rows @NAME@_kernel_build_rows
#define mrts_fix_speed @NAME@_kernel_fix_speed
#define mrts_scale_columns @NAME@_kernel_scale_columns
#define mrts_free_unknowns @NAME@_kernel_free_unknowns
#define mrts_bound_speed @NAME@_kernel_bound_speed
#define mrts_speed_cap @NAME@_kernel_speed_cap

#endif

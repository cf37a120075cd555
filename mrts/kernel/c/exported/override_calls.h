/* SPDX-License-Identifier: MIT
 *
 * What cell_override.h takes of cell.h where Python plays plans; sizes and the model are macros of the cell.
 */
#ifndef MRTS_OVERRIDE_CALLS_H
#define MRTS_OVERRIDE_CALLS_H

#include "../numbers.h"

typedef double cell_real;
typedef enum { CELL_OK = 0, CELL_INFEASIBLE = 2, CELL_BAD_ARGUMENT = 5 } cell_status;

#define CELL_UNLIMITED MRTS_INFINITY

#endif

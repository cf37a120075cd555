/* SPDX-License-Identifier: MIT
 *
 * What exported/cell_override.h takes of cell.h where Python plays plans; sizes and the model are macros of the cell.
 */
#include "numbers.h"

typedef double cell_real;
typedef enum { CELL_OK = 0, CELL_INFEASIBLE = 2, CELL_BAD_ARGUMENT = 5 } cell_status;

#define CELL_UNLIMITED MRTS_INFINITY

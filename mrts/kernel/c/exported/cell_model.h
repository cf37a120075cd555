/* SPDX-License-Identifier: MIT
 *
 * The generated functions. Matrices are column after column; see the source for inputs and outputs. */
#ifndef MRTS_CELL_MODEL_H
#define MRTS_CELL_MODEL_H

#include "cell.h"

#define MRTS_REAL cell_real
#if CELL_SINGLE
#define MRTS_SINGLE
#endif
#include "../numbers.h"

void cell_model_terms(const cell_real *const *arg, cell_real *const *res);
void cell_model_wrench_form(const cell_real *const *arg, cell_real *const *res);
void cell_model_played_torques(const cell_real *const *arg, cell_real *const *res);
void cell_model_fixed_distribution(const cell_real *const *arg, cell_real *const *res);

#endif

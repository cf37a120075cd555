/* SPDX-License-Identifier: MIT
 *
 * How far given joints are from holding an object that moves as given.
 */
#ifndef MRTS_CLOSURE_H
#define MRTS_CLOSURE_H

#include "../cell_sizes.h"

/* What is told of an arm, the largest of all samples: the distance of its tip from its grasp, squared [m^2], the squares of
 * the differences of their rotation matrices, summed, and the largest component of velocities and of accelerations, of what
 * holds the grasp or of the tip, and of their differences, in base axes. */
enum { MRTS_APART, MRTS_TURNED, MRTS_VELOCITY, MRTS_SLIP, MRTS_CHANGE, MRTS_CHANGE_SLIP, MRTS_CLOSURE_SIZES };

#endif

/* SPDX-License-Identifier: MIT
 *
 * What every file of the kernel shares: the type of its numbers, how functions are linked, and the tolerances.
 * The kernel is C99, without allocation, input, output or static data that change: the caller owns every array, and a
 * function's *_work says how long its work arrays must be. Matrices are by rows unless said otherwise. */
#ifndef MRTS_NUMBERS_H
#define MRTS_NUMBERS_H

#include <math.h>

/* The type of all numbers. A library in float defines MRTS_REAL and MRTS_SINGLE: tolerances and literals follow. */
#ifndef MRTS_REAL
#define MRTS_REAL double
#endif
typedef MRTS_REAL mrts_real;

/* What Python calls. */
#ifndef MRTS_EXPORT
#define MRTS_EXPORT __attribute__((visibility("default")))
#endif

#ifdef MRTS_SINGLE
#define MRTS_C(value) value##f
#define MRTS_MATH(function, a) function##f(a)
#define MRTS_EITHER(of_double, of_float) of_float##f
#else
#define MRTS_C(value) value
#define MRTS_MATH(function, a) function(a)
#define MRTS_EITHER(of_double, of_float) of_double
#endif
#define MRTS_ABS(value) MRTS_MATH(fabs, value)
#define MRTS_SQRT(value) MRTS_MATH(sqrt, value)

#define MRTS_FEASIBLE MRTS_EITHER(1e-10, 4e-6)  /* excess over a limit, relative to 1 and to it, that is rounding */
#define MRTS_AS_IT_IS MRTS_EITHER(1e-12, 4e-6)  /* residual of an answer that is not refined, relative to 1 */
#define MRTS_SEPARATED MRTS_EITHER(1e-9, 2e-5)  /* a certificate must separate the limits by this share, or proves nothing */
#define MRTS_PIVOT MRTS_EITHER(1e-8, 1e-4)      /* smallest pivot, relative to its row */
#define MRTS_ZERO MRTS_EITHER(1e-13, 1e-6)      /* a multiplier below this share of the largest is rounding */
#define MRTS_ROUNDING MRTS_EITHER(1e-15, 1e-6)  /* of a limit's row, relative to 1 and the limit */
#define MRTS_GAP MRTS_EITHER(1e-9, 3e-5)        /* of an objective, relative to it and MRTS_SMALL */
#define MRTS_SMALL MRTS_EITHER(1e-3, 1e-2)
#define MRTS_INFINITY MRTS_EITHER(1e300, 1e30)  /* an absent limit is this or its negative */
#define MRTS_UNBOUNDED MRTS_EITHER(1e9, 1e6) /* c^2 may grow until it moves some row by this many limits: beyond, nothing
                                              * bounds it, and rounding of a limit (1e-16) may still be told from c^2's share */
#define MRTS_NO_EFFECT MRTS_EITHER(1e-300, 1e-30) /* an unknown that moves no row by more than this share of a limit moves
                                                   * none: the scale that makes its effect 1 would not be finite */
#define MRTS_MOST_ANGLE MRTS_EITHER(1e5, 5e3) /* beyond, multiples of pi / 2 are not exact [rad] */

/* Before a loop over unknowns: of as many as one arm's wrench has the count is mostly known, and counting them costs more
 * than the rest. */
#if defined(__GNUC__) && !defined(__clang__)
#define MRTS_UNROLL _Pragma("GCC unroll 8")
#else
#define MRTS_UNROLL
#endif

/* A row that is coded with its side, without the side. */
static inline int mrts_abs(int code) { return code < 0 ? -code : code; }

static inline mrts_real mrts_larger(mrts_real a, mrts_real b) { return a > b ? a : b; }

static inline mrts_real mrts_dot(int k, const mrts_real *a, const mrts_real *b) {
    mrts_real sum = 0;
    MRTS_UNROLL
    for (int i = 0; i < k; ++i) sum += a[i] * b[i];
    return sum;
}

#include "number_type.inc"
#include "answers.inc"

#endif

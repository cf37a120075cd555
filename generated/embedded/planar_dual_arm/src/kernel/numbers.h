/* SPDX-License-Identifier: MIT
 *
 * What every file of the kernel shares: the type of its numbers, how functions are linked, and the tolerances.
 *
 * The kernel is C99, without allocation, input, output or static data that change: the caller owns every array, and a
 * function's *_work says how long its work arrays must be. Matrices are by rows unless said otherwise.
 */
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
#define MRTS_ABS(value) fabsf(value)
#define MRTS_C(value) value##f
#define MRTS_SQRT(value) sqrtf(value)
#define MRTS_FEASIBLE MRTS_C(4e-6)
#define MRTS_AS_IT_IS MRTS_C(4e-6)
#define MRTS_SEPARATED MRTS_C(2e-5)
#define MRTS_PIVOT MRTS_C(1e-4)
#define MRTS_ZERO MRTS_C(1e-6)
#define MRTS_ROUNDING MRTS_C(1e-6)
#define MRTS_GAP MRTS_C(3e-5)
#define MRTS_SMALL MRTS_C(1e-2)
#define MRTS_INFINITY MRTS_C(1e30)
#define MRTS_UNBOUNDED MRTS_C(1e6)
#define MRTS_NO_EFFECT MRTS_C(1e-30)
#define MRTS_LESS_QUARTERS(angle, turns) ((angle) - (turns) * 1.5703125f - (turns) * 4.83751297e-4f)
#define MRTS_QUARTER_REST 7.54978995e-8f
#define MRTS_MOST_ANGLE 5e3f
#else
#define MRTS_ABS(value) fabs(value)
#define MRTS_C(value) value
#define MRTS_SQRT(value) sqrt(value)
#define MRTS_FEASIBLE 1e-10 /* excess over a limit, relative to 1 and to it, that is rounding */
#define MRTS_AS_IT_IS 1e-12 /* residual of an answer that is taken as it is, relative to 1; another is refined */
#define MRTS_SEPARATED 1e-9 /* a certificate must separate the limits by this share, or proves nothing */
#define MRTS_PIVOT 1e-8     /* smallest pivot, relative to its row */
#define MRTS_ZERO 1e-13     /* a multiplier below this share of the largest is rounding */
#define MRTS_ROUNDING 1e-15 /* of a limit's row, relative to 1 and the limit */
#define MRTS_GAP 1e-9       /* of an objective, relative to it and MRTS_SMALL */
#define MRTS_SMALL 1e-3
#define MRTS_INFINITY 1e300 /* an absent limit is this or its negative */
#define MRTS_UNBOUNDED 1e9  /* c^2 may grow until it moves some row by this many limits: beyond, nothing bounds it, and
                             * rounding of a limit (1e-16) may still be told from what c^2 adds to it */
#define MRTS_NO_EFFECT 1e-300 /* an unknown that moves no row by more than this share of a limit moves none: the scale
                               * that makes its effect 1 would not be finite */
#define MRTS_LESS_QUARTERS(angle, turns) ((angle) - (turns) * 1.57079632673412561417) /* the first 33 bits of pi / 2 */
#define MRTS_QUARTER_REST 6.07710050650619224932e-11                                  /* and the rest */
#define MRTS_MOST_ANGLE 1e5 /* beyond, multiples of the first bits are not exact, and the C library is asked [rad] */
#endif

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

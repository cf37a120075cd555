/* SPDX-License-Identifier: MIT
 *
 * Small dense linear and quadratic programs, solved exactly, one after another with slowly changing data.
 *
 *     minimise g'x  or  1/2 x'Hx + g'x   subject to   lower_i <= a_i'x <= upper_i,  i < rows
 *                                        and          lower_(rows+j) <= x_j <= upper_(rows+j),  j < k
 *
 * The caller scales: the largest coefficient of each unknown and of each row is about 1; tolerances refer to that. Rows are stored one after another; an absent limit is +-MRTS_INFINITY. C99, no allocation, no input or output, no
 * static data, bounded iterations: the caller owns every array.
 */
#ifndef MRTS_DENSE_PROGRAMS_H
#define MRTS_DENSE_PROGRAMS_H

#ifndef MRTS_REAL
#define MRTS_REAL double
#endif
typedef MRTS_REAL mrts_real;

/* MRTS_SINGLE is defined where mrts_real is float: tolerances and literals follow. */
#ifdef MRTS_SINGLE
#define MRTS_C(value) value##f
#define MRTS_FEASIBLE MRTS_C(4e-6)    /* overstepping of a limit, relative to 1 and to it, that is rounding */
#define MRTS_SEPARATED MRTS_C(2e-5)   /* a certificate must separate the limits by this share, or proves nothing */
#define MRTS_PIVOT MRTS_C(1e-4)       /* smallest pivot, relative to its row */
#define MRTS_ZERO MRTS_C(1e-6)        /* a multiplier below this share of the largest is rounding */
#define MRTS_ROUNDING MRTS_C(1e-6)     /* of a limit's row, relative to 1 and the limit */
#define MRTS_GAP MRTS_C(3e-5)          /* of an objective, relative to it and MRTS_SMALL */
#define MRTS_SMALL MRTS_C(1e-2)
#define MRTS_INFINITY MRTS_C(1e30)
#define MRTS_ABS(value) ((value) < 0 ? -(value) : (value))
#define MRTS_SQRT(value) sqrtf(value)
#else
#define MRTS_C(value) value
#define MRTS_FEASIBLE 1e-10
#define MRTS_SEPARATED 1e-9
#define MRTS_PIVOT 1e-8
#define MRTS_ZERO 1e-13
#define MRTS_ROUNDING 1e-15
#define MRTS_GAP 1e-9
#define MRTS_SMALL 1e-3
#define MRTS_INFINITY 1e300
#define MRTS_ABS(value) ((value) < 0 ? -(value) : (value))
#define MRTS_SQRT(value) sqrt(value)
#endif

enum {
    MRTS_OPTIMAL = 0,
    MRTS_INFEASIBLE = 1, /* with a certificate */
    MRTS_MARGINAL = 2,   /* the limits miss each other by no more than rounding */
    MRTS_STOPPED = 3     /* iteration limit, or data that do not allow an answer */
};

/* Number of reals of work. */
#define MRTS_LP_WORK(k) ((k) * (k) + (k))
#define MRTS_QP_WORK(k) (3 * (k) * (k) + 7 * (k))
/* Number of ints of work, besides the basis. */
#define MRTS_LP_IWORK(k, rows) ((rows) + 6 * (k))
#define MRTS_QP_IWORK(k, rows) ((rows) + (k))

/* Linear program by the bounded dual simplex method with bound flipping.
 *
 * basis[k]: rows that determine x, -1 - row if at its lower, 1 + row at its upper limit; a free one is 1 + row too.
 *           basis[0] == 0 starts cold; otherwise the method starts from the rows that it holds. On return the last one.
 * x[k]:     the minimiser.
 * y[k]:     multipliers of the basis, g = sum_j y_j a_(basis j), >= 0 at a lower and <= 0 at an upper limit. If
 *           infeasible, a certificate: with g = 0 the same sum over the basis and the row *entering, coded as a basis
 *           row, whose multiplier is -1 at its upper and 1 at its lower limit; then sum_i y_i limit_i > 0.
 * An unknown with a cost needs the limit that its cost pushes it against. Returns one of the statuses above.
 */
static int mrts_lp(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                   const mrts_real *g, int *basis, mrts_real *x, mrts_real *y, int *entering, mrts_real *work,
                   int *iwork);

/* Strictly convex quadratic program by the dual active set method.
 *
 * H:      Shape (k, k), symmetric and positive definite.
 * active: on return *count rows that bind, coded as the basis above.
 * u:      their multipliers, >= 0 in size: H x + g = sum_j s_j u_j a_j with s_j = 1 at a lower, -1 at an upper limit.
 */
static int mrts_qp(int k, int rows, const mrts_real *H, const mrts_real *A, const mrts_real *lower,
                   const mrts_real *upper, const mrts_real *g, mrts_real *x, int *active, mrts_real *u, int *count,
                   mrts_real *work, int *iwork);

#endif

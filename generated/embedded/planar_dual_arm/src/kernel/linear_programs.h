/* SPDX-License-Identifier: MIT
 *
 * Small dense linear programs, solved exactly, one after another with slowly changing data.
 *
 *     minimise g'x  subject to   lower_i <= a_i'x <= upper_i,  i < rows
 *                          and   lower_(rows+j) <= x_j <= upper_(rows+j),  j < k
 *
 * The caller scales: the largest coefficient of each unknown and of each row is about 1; tolerances refer to that. Rows
 * are stored one after another; an absent limit is +-MRTS_INFINITY. Iterations are bounded.
 *
 * The bounded dual simplex method with the bound flipping ratio test (Maros, Computational Techniques of the Simplex
 * Method, 2003, chapter 10; Koberstein, The dual simplex method, 2005), in its row form: k rows that hold with equality
 * determine x. Free unknowns start as rows without limits and leave first. Bland's rule (1977) ends cycles. */
#ifndef MRTS_LINEAR_PROGRAMS_H
#define MRTS_LINEAR_PROGRAMS_H

#include "numbers.h"

/* How a program ends, a linear or a quadratic one. */
enum {
    MRTS_OPTIMAL = 0,
    MRTS_INFEASIBLE = 1, /* with a certificate */
    MRTS_MARGINAL = 2,   /* the limits miss each other by no more than rounding */
    MRTS_STOPPED = 3     /* iteration limit, or data that do not allow an answer */
};

/* Reals of work, and ints of work besides the basis. */
#define MRTS_LP_WORK(k) ((k) * (k) + (k))
#define MRTS_LP_IWORK(k, rows) ((rows) + 6 * (k))

enum { MRTS_AT_LOWER = -1, MRTS_FREE = 0, MRTS_AT_UPPER = 1 };

/* alpha_j = a_row' c_j: how the row is made of the basis rows */
static void mrts_lp_alpha(int k, int rows, const mrts_real *A, int row, const mrts_real *C, mrts_real *alpha) {
    if (row < rows) {
        for (int j = 0; j < k; ++j) alpha[j] = mrts_dot(k, A + row * k, C + j * k);
    } else {
        for (int j = 0; j < k; ++j) alpha[j] = C[j * k + row - rows];
    }
}

/* The inverse of the basis after its row q has been replaced; C holds the columns of the inverse. */
static void mrts_lp_exchange(int k, int q, const mrts_real *alpha, mrts_real *C) {
    mrts_real *cq = C + q * k;
    const mrts_real factor = 1 / alpha[q];
    for (int i = 0; i < k; ++i) cq[i] *= factor;
    for (int j = 0; j < k; ++j) {
        if (j == q || alpha[j] == 0) continue;
        MRTS_UNROLL
        for (int i = 0; i < k; ++i) C[j * k + i] -= alpha[j] * cq[i];
    }
}

/* Value of a row, or of the unknown row - rows, at x. */
static inline mrts_real mrts_lp_value(int rows, const mrts_real *A, int k, int row, const mrts_real *x) {
    return row < rows ? mrts_dot(k, A + row * k, x) : x[row - rows];
}

/* Puts a side to each basis row that fits the sign of its multiplier, if that exceeds a share of the largest. Returns -1
 * where the limit that it needs is absent, else how many have changed. */
static int mrts_lp_choose_sides(int k, const mrts_real *lower, const mrts_real *upper, const int *row, int *side,
                                const mrts_real *y, mrts_real share) {
    mrts_real largest = 0;
    int changed = 0;
    for (int j = 0; j < k; ++j) largest = mrts_larger(MRTS_ABS(y[j]), largest);
    for (int j = 0; j < k; ++j) {
        const int has_lower = lower[row[j]] > -MRTS_INFINITY, has_upper = upper[row[j]] < MRTS_INFINITY;
        const int before = side[j];
        if (y[j] > share * largest) {
            if (!has_lower) return -1;
            side[j] = MRTS_AT_LOWER;
        } else if (y[j] < -share * largest) {
            if (!has_upper) return -1;
            side[j] = MRTS_AT_UPPER;
        } else if (side[j] == MRTS_AT_UPPER ? !has_upper : side[j] == MRTS_AT_LOWER ? !has_lower : has_lower || has_upper) {
            side[j] = has_lower ? MRTS_AT_LOWER : has_upper ? MRTS_AT_UPPER : MRTS_FREE;
        }
        changed += side[j] != before;
    }
    return changed;
}

/* The limit on one side of a row; a free row is held at 0. */
static mrts_real mrts_limit(const mrts_real *lower, const mrts_real *upper, int row, int side) {
    return side == MRTS_AT_LOWER ? lower[row] : side == MRTS_AT_UPPER ? upper[row] : 0;
}

/* Moves x so that basis row j gains `more` and the others nothing. */
static void mrts_lp_move(int k, int j, mrts_real more, const mrts_real *C, mrts_real *x) {
    MRTS_UNROLL
    for (int i = 0; i < k; ++i) x[i] += more * C[j * k + i];
}

static void mrts_lp_place(int k, const mrts_real *lower, const mrts_real *upper, const int *row, const int *side,
                          const mrts_real *C, mrts_real *x) {
    for (int i = 0; i < k; ++i) x[i] = 0;
    for (int j = 0; j < k; ++j) {
        const mrts_real limit = mrts_limit(lower, upper, row[j], side[j]);
        if (limit != 0) mrts_lp_move(k, j, limit, C, x);
    }
}

/* x of a basis, refined once against its own rows; the largest residual that is left, relative to 1 and the limit, and in
 * *before the one that was there */
static mrts_real mrts_lp_refine(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                                const int *row, const int *side, const mrts_real *C, mrts_real *x, mrts_real *before) {
    mrts_real worst = 0;
    for (int pass = 0; pass < 2; ++pass) {
        worst = 0;
        for (int j = 0; j < k; ++j) {
            const mrts_real limit = mrts_limit(lower, upper, row[j], side[j]);
            const mrts_real missing = limit - mrts_lp_value(rows, A, k, row[j], x);
            const mrts_real size = MRTS_ABS(missing) / (1 + MRTS_ABS(limit));
            if (!(size <= worst)) worst = size; /* so that a value that is no number is seen */
            if (missing != 0 && pass == 0) mrts_lp_move(k, j, missing, C, x);
        }
        if (pass == 0) *before = worst;
        if (worst <= MRTS_FEASIBLE / 100) break; /* nothing to gain */
    }
    return worst;
}

/* How far g (none: zero) is from sum_j y_j a_j and one more row with its multiplier, relative to the largest term */
static mrts_real mrts_lp_stationarity(int k, int rows, const mrts_real *A, const mrts_real *g, const int *row,
                                      const mrts_real *y, int more, mrts_real its_y, mrts_real *rest) {
    mrts_real size = 0, worst = 0;
    for (int i = 0; i < k; ++i) {
        rest[i] = g ? g[i] : 0;
        size = mrts_larger(MRTS_ABS(rest[i]), size);
    }
    for (int j = -1; j < k; ++j) {
        const int its = j < 0 ? more : row[j];
        const mrts_real weight = j < 0 ? its_y : y[j];
        for (int i = 0; i < k && its < rows && weight != 0; ++i) {
            const mrts_real term = weight * A[its * k + i];
            rest[i] -= term;
            size = mrts_larger(MRTS_ABS(term), size);
        }
        if (its < rows) continue;
        rest[its - rows] -= weight;
        size = mrts_larger(MRTS_ABS(weight), size);
    }
    for (int i = 0; i < k; ++i) {
        if (!(MRTS_ABS(rest[i]) <= worst)) worst = MRTS_ABS(rest[i]);
    }
    return size > 0 ? worst / size : worst;
}

/* Rebuilds the inverse for the rows of a basis; rows that depend on others are replaced by unknowns. */
static void mrts_lp_factor(int k, int rows, const mrts_real *A, int *row, int *side, mrts_real *C, mrts_real *alpha,
                           int *wanted, int *taken) {
    int count = 0;
    for (int i = 0; i < k * k; ++i) C[i] = 0;
    for (int j = 0; j < k; ++j) {
        C[j * k + j] = 1;
        taken[j] = 0;
    }
    for (int j = 0; j < k; ++j) { /* unknowns first: they cost nothing */
        if (row[j] >= rows) {
            taken[row[j] - rows] = 1 + side[j] + 1;
        } else {
            wanted[2 * count] = row[j];
            wanted[2 * count + 1] = side[j];
            ++count;
        }
    }
    for (int j = 0; j < k; ++j) {
        row[j] = rows + j;
        side[j] = taken[j] ? taken[j] - 2 : MRTS_FREE;
    }
    for (int next = 0; next < count; ++next) {
        int q = -1;
        mrts_real best = 0, size = 0;
        mrts_lp_alpha(k, rows, A, wanted[2 * next], C, alpha);
        for (int j = 0; j < k; ++j) {
            const mrts_real value = MRTS_ABS(alpha[j]);
            size = mrts_larger(value, size);
            if (!taken[j] && value > best) {
                best = value;
                q = j;
            }
        }
        if (q < 0 || best <= MRTS_PIVOT * size) continue;
        mrts_lp_exchange(k, q, alpha, C);
        row[q] = wanted[2 * next];
        side[q] = wanted[2 * next + 1];
        taken[q] = 1;
    }
}

/* The row, of those that `skipped` does not mark, that oversteps its limits the most: 1 + row above its upper, -1 - row
 * below its lower limit, 0 if none does; under Bland's rule the first one that does. */
static inline int mrts_lp_price(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                                const mrts_real *x, const int *skipped, int bland, mrts_real *excess) {
    int found = 0;
    mrts_real most = 0;
    for (int row = 0; row < rows + k; ++row) {
        if (skipped[row]) continue;
        const mrts_real value = mrts_lp_value(rows, A, k, row, x);
        const mrts_real above = value - upper[row], below = lower[row] - value;
        const mrts_real over = above > below ? above : below;
        if (over <= 0) continue;
        const mrts_real limit = above > below ? upper[row] : lower[row];
        if (!(over <= MRTS_FEASIBLE * (1 + MRTS_ABS(limit))) && !(over <= most)) { /* no number: no answer */
            most = over;
            found = above > below ? row + 1 : -row - 1;
            if (bland) break;
        }
    }
    *excess = most;
    return found;
}

/* Leaving position of the ratio test, -1 if none. The step passes rows whose other limit lies nearer: those flip. */
static int mrts_lp_ratio(int k, const mrts_real *lower, const mrts_real *upper, const int *row, int *side,
                         const mrts_real *y, const mrts_real *alpha, mrts_real sign, mrts_real excess, int bland,
                         int *passed) {
    mrts_real size = 0, slope = excess, scale = 0;
    for (int j = 0; j < k; ++j) {
        size = mrts_larger(MRTS_ABS(alpha[j]), size);
        scale = mrts_larger(MRTS_ABS(y[j]), scale);
        passed[j] = 0;
    }
    const mrts_real smallest = MRTS_PIVOT * size;
    for (;;) {
        mrts_real least = MRTS_INFINITY, best = 0;
        int leaving = -1;
        for (int j = 0; j < k; ++j) { /* y_j + sign t alpha_j keeps its sign until t reaches this ratio */
            const mrts_real rate = sign * alpha[j];
            if (passed[j] || MRTS_ABS(rate) <= smallest) continue;
            if (side[j] == MRTS_AT_LOWER ? rate > 0 : side[j] == MRTS_AT_UPPER ? rate < 0 : 0) continue;
            const mrts_real reach = side[j] == MRTS_FREE ? 0 : MRTS_ABS(y[j] / rate);
            if (reach < least) least = reach;
        }
        if (least >= MRTS_INFINITY) break;
        const mrts_real tie = least + MRTS_ZERO * (least + scale / (size > 0 ? size : 1));
        for (int j = 0; j < k; ++j) { /* of those that tie, the largest pivot */
            const mrts_real rate = sign * alpha[j];
            if (passed[j] || MRTS_ABS(rate) <= smallest) continue;
            if (side[j] == MRTS_AT_LOWER ? rate > 0 : side[j] == MRTS_AT_UPPER ? rate < 0 : 0) continue;
            const mrts_real reach = side[j] == MRTS_FREE ? 0 : MRTS_ABS(y[j] / rate);
            if (reach <= tie && (bland ? leaving < 0 || row[j] < row[leaving] : MRTS_ABS(rate) > best)) {
                best = MRTS_ABS(rate);
                leaving = j;
            }
        }
        if (leaving < 0) break; /* a tie that is no number */
        const mrts_real low = lower[row[leaving]], high = upper[row[leaving]];
        if (side[leaving] == MRTS_FREE || low <= -MRTS_INFINITY || high >= MRTS_INFINITY) return leaving;
        if (bland) return leaving;
        slope -= best * (high - low);
        if (slope <= MRTS_SEPARATED * (1 + excess)) return leaving; /* rounding must not pass the last one */
        passed[leaving] = 1;
    }
    return -1; /* with every basis row at its better end the entering row stays beyond its limit */
}

/* How far the objective may be off: what multipliers of the wrong sign could still gain, and what rounding of the rows
 * moves, relative to the objective. */
static mrts_real mrts_lp_doubt(int k, int rows, const mrts_real *lower, const mrts_real *upper, const mrts_real *g,
                               const int *row, const int *side, const mrts_real *x, const mrts_real *y) {
    mrts_real doubt = 0, value = mrts_dot(k, g, x);
    for (int j = 0; j < k; ++j) {
        const mrts_real size = MRTS_ABS(y[j]);
        const int wrong = side[j] == MRTS_AT_LOWER ? y[j] < 0 : side[j] == MRTS_AT_UPPER ? y[j] > 0 : 0;
        if (wrong && lower[row[j]] > -MRTS_INFINITY && upper[row[j]] < MRTS_INFINITY) {
            doubt += size * (upper[row[j]] - lower[row[j]]);
        }
        if (row[j] < rows) doubt += size * MRTS_ROUNDING * (1 + MRTS_ABS(mrts_limit(lower, upper, row[j], side[j])));
    }
    return doubt / mrts_larger(MRTS_ABS(value), MRTS_SMALL);
}

/* Whether the entering row and the basis rows that make it up exclude each other: the row's own limit against the
 * best that the limits of the others allow. Leaves the certificate's multipliers in y. */
static int mrts_lp_certificate(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                               const int *row, mrts_real *alpha, int entering, mrts_real sign, mrts_real *y) {
    mrts_real size = 0, weight = 1, gap = sign > 0 ? -upper[entering] : lower[entering];
    for (int j = 0; j < k; ++j) size = mrts_larger(MRTS_ABS(alpha[j]), size);
    for (int j = 0; j < k; ++j) {
        const mrts_real limit = sign * alpha[j] > 0 ? lower[row[j]] : upper[row[j]];
        const int absent = MRTS_ABS(limit) >= MRTS_INFINITY;
        y[j] = absent && MRTS_ABS(alpha[j]) <= MRTS_PIVOT * size ? 0 : sign * alpha[j];
        if (y[j] != 0) gap += y[j] * limit;
        weight += MRTS_ABS(y[j]);
    }
    if (!(gap > MRTS_SEPARATED * weight)) return gap <= MRTS_SEPARATED * weight ? MRTS_MARGINAL : MRTS_STOPPED;
    return mrts_lp_stationarity(k, rows, A, 0, row, y, entering, -sign, alpha) <= MRTS_SEPARATED ? MRTS_INFEASIBLE
                                                                                                 : MRTS_STOPPED;
}

/* Linear program by the bounded dual simplex method with bound flipping.
 * basis[k]: rows that determine x, -1 - row if at its lower, 1 + row at its upper limit; a free one is 1 + row too.
 *           basis[0] == 0 starts cold; otherwise the method starts from the rows that it holds. On return the last one.
 * x[k]:     the minimiser.
 * y[k]:     multipliers of the basis, g = sum_j y_j a_(basis j), >= 0 at a lower and <= 0 at an upper limit. If
 *           infeasible, a certificate: with g = 0 the same sum over the basis and the row *entering, coded as a basis
 *           row, whose multiplier is -1 at its upper and 1 at its lower limit; then sum_i y_i limit_i > 0.
 * An unknown with a cost needs the limit that its cost pushes it against. Returns one of the statuses above. `work`
 * starts with the columns of the basis' inverse. */
static inline int mrts_lp(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                          const mrts_real *g, int *basis, mrts_real *x, mrts_real *y, int *entering, mrts_real *work,
                          int *iwork) {
    mrts_real *C = work, *alpha = C + k * k;
    int *in_basis = iwork, *passed = in_basis + rows + k, *row = passed + k, *side = row + k, *wanted = side + k;
    const int bland_from = 10 + 2 * (k + rows), limit = 2 * bland_from;
    int cold = basis[0] == 0, status = MRTS_STOPPED, updates = 0, tried_again = 0, turns = 0;

    *entering = 0;
start:
    for (int j = 0; j < k; ++j) {
        row[j] = cold ? rows + j : mrts_abs(basis[j]) - 1;
        side[j] = cold ? MRTS_FREE : basis[j] < 0 ? MRTS_AT_LOWER : MRTS_AT_UPPER;
    }
restart:
    mrts_lp_factor(k, rows, A, row, side, C, alpha, wanted, passed);
    updates = 0;
    for (int j = 0; j < k; ++j) y[j] = mrts_dot(k, g, C + j * k);
    if (mrts_lp_choose_sides(k, lower, upper, row, side, y, MRTS_ZERO) < 0) {
    start_cold:
        if (cold) goto done;
        cold = 1;
        goto start;
    }
    for (int i = 0; i < rows + k; ++i) in_basis[i] = 0;
    for (int j = 0; j < k; ++j) in_basis[row[j]] = 1;
    mrts_lp_place(k, lower, upper, row, side, C, x);

    for (int iteration = 0; iteration < limit; ++iteration) {
        mrts_real excess;
        const int bland = iteration >= bland_from;
        const int found = mrts_lp_price(k, rows, A, lower, upper, x, in_basis, bland, &excess);
        if (found == 0) {
            mrts_real uneven = mrts_lp_stationarity(k, rows, A, g, row, y, 0, 0, alpha);
            if (!(uneven <= MRTS_FEASIBLE / 100)) { /* multipliers are refined once against the cost */
                for (int j = 0; j < k; ++j) y[j] += mrts_dot(k, alpha, C + j * k);
                uneven = mrts_lp_stationarity(k, rows, A, g, row, y, 0, 0, alpha);
            }
            /* pivots too small to count may have left a multiplier with the wrong sign; it may be of either sign for ever */
            int changed = turns < k ? mrts_lp_choose_sides(k, lower, upper, row, side, y, MRTS_SEPARATED) : 0;
            if (changed < 0) goto start_cold;
            if (changed == 0) {
                mrts_real before;
                const mrts_real left = mrts_lp_refine(k, rows, A, lower, upper, row, side, C, x, &before);
                /* refined so far that another row may now be overstepped */
                const int astray = !(before <= MRTS_FEASIBLE) &&
                                   mrts_lp_price(k, rows, A, lower, upper, x, in_basis, bland, &excess) != 0;
                if (astray || !(left <= MRTS_FEASIBLE) || !(uneven <= MRTS_FEASIBLE)) { /* try a fresh inverse */
                    if (!updates || ++tried_again > 3) goto done;
                    goto restart;
                }
                if (mrts_lp_doubt(k, rows, lower, upper, g, row, side, x, y) <= MRTS_GAP) {
                    status = MRTS_OPTIMAL;
                } else if (turns < k) { /* a small one of the wrong sign matters */
                    changed = mrts_lp_choose_sides(k, lower, upper, row, side, y, MRTS_ZERO);
                }
                if (changed <= 0) goto done;
            }
            ++turns;
            mrts_lp_place(k, lower, upper, row, side, C, x);
            continue;
        }
        const int p = mrts_abs(found) - 1;
        const mrts_real sign = found > 0 ? 1 : -1;
        mrts_lp_alpha(k, rows, A, p, C, alpha);
        const int q = mrts_lp_ratio(k, lower, upper, row, side, y, alpha, sign, excess, bland, passed);
        if (q < 0) {
            if (updates && tried_again < 3) { /* decide with a fresh inverse */
                ++tried_again;
                goto restart;
            }
            status = mrts_lp_certificate(k, rows, A, lower, upper, row, alpha, p, sign, y);
            *entering = found;
            goto done;
        }
        for (int j = 0; j < k; ++j) {
            if (!passed[j]) continue;
            side[j] = -side[j];
            mrts_lp_move(k, j, (mrts_real)side[j] * (upper[row[j]] - lower[row[j]]), C, x);
        }
        mrts_lp_exchange(k, q, alpha, C);
        ++updates;
        in_basis[row[q]] = 0;
        in_basis[p] = 1;
        row[q] = p;
        side[q] = found > 0 ? MRTS_AT_UPPER : MRTS_AT_LOWER;
        mrts_lp_move(k, q, mrts_limit(lower, upper, p, side[q]) - mrts_lp_value(rows, A, k, p, x), C, x);
        const mrts_real its = y[q] / alpha[q];
        for (int j = 0; j < k; ++j) y[j] -= alpha[j] * its;
        y[q] = its;
    }
done:
    for (int j = 0; j < k; ++j) basis[j] = side[j] == MRTS_AT_LOWER ? -row[j] - 1 : row[j] + 1;
    return status;
}

/* As mrts_lp, and of its answers; where the rows of `basis` still determine the minimiser they are only solved for, and
 * stay what they are, in the order of their pivots. Where a basis leads to no answer, the program starts cold. */
static inline int mrts_lp_again(int k, int rows, const mrts_real *A, const mrts_real *lower, const mrts_real *upper,
                                const mrts_real *g, int *basis, mrts_real *x, mrts_real *y, int *entering, mrts_real *work,
                                int *iwork) {
    const int cold = basis[0] == 0;
    *entering = 0;
    if (!cold && mrts_kept_basis(k, rows, A, lower, upper, g, basis, x, y, work, work + k * k)) return MRTS_OPTIMAL;
    const int status = mrts_lp(k, rows, A, lower, upper, g, basis, x, y, entering, work, iwork);
    if (status == MRTS_OPTIMAL || cold) return status;
    basis[0] = 0;
    return mrts_lp(k, rows, A, lower, upper, g, basis, x, y, entering, work, iwork);
}

#endif

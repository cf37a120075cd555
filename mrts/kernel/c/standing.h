/* SPDX-License-Identifier: MIT
 *
 * The c^2 with which a thing stays where it stands on the object, at one sample and one speed factor.
 */
#ifndef MRTS_STANDING_H
#define MRTS_STANDING_H

#include "numbers.h"

/* Values of c^2 from low to high, high MRTS_INFINITY where nothing bounds it; low is MRTS_INFINITY where there is none. */
typedef struct {
    mrts_real low, high;
} mrts_span;

/* Those >= 0 with slope c^2 + offset <= 0. */
static inline mrts_span mrts_span_below(mrts_real slope, mrts_real offset) {
    mrts_span found = {0, MRTS_INFINITY};
    if (slope > 0) found.high = -offset / slope;
    if (offset > 0) found.low = slope < 0 ? offset / -slope : MRTS_INFINITY;
    return found;
}

/* Those >= 0 with which what a thing takes from the object, s = square c^2 + offset, lies in the cone of its friction:
 * |(s_0, s_1)| <= friction s_2. Of a quadratic a c^4 + 2 b c^2 + d <= 0 that is what lies on the side with s_2 >= 0. */
static inline mrts_span mrts_span_in_cone(const mrts_real *square, const mrts_real *offset, mrts_real friction) {
    const mrts_span nothing = {MRTS_INFINITY, MRTS_INFINITY};
    const mrts_real steep = friction * friction;
    const mrts_real a = mrts_dot(2, square, square) - steep * square[2] * square[2];
    const mrts_real b = mrts_dot(2, square, offset) - steep * square[2] * offset[2];
    const mrts_real d = mrts_dot(2, offset, offset) - steep * offset[2] * offset[2];
    const mrts_real along = square[0] * offset[2] - square[2] * offset[0], across = square[1] * offset[2] - square[2] * offset[1];
    const mrts_real aside = square[0] * offset[1] - square[1] * offset[0];
    const mrts_real lost = MRTS_ZERO * steep * mrts_dot(3, square, square) * mrts_dot(3, offset, offset);
    mrts_real root = steep * (along * along + across * across) - aside * aside; /* b^2 - a d, without cancellation */
    if (root < 0 && root >= -lost) root = 0; /* of a thing that is lifted straight up both are one direction */
    mrts_span found = a == 0 ? mrts_span_below(2 * b, d) : nothing;
    if (a != 0 && root >= 0) {
        const mrts_real sum = b < 0 ? MRTS_SQRT(root) - b : -MRTS_SQRT(root) - b;
        const mrts_real one = sum / a, other = sum != 0 ? d / sum : 0;
        const int rises = a < 0 && square[2] > 0, falls = a < 0 && square[2] < 0;
        found.low = falls ? 0 : rises ? mrts_larger(one, other) : one < other ? one : other;
        found.high = rises ? MRTS_INFINITY : falls ? (one < other ? one : other) : mrts_larger(one, other);
    }
    const mrts_span pressed = mrts_span_below(-square[2], -offset[2]);
    found.low = mrts_larger(mrts_larger(found.low, pressed.low), 0);
    if (pressed.high < found.high) found.high = pressed.high;
    return found.low <= found.high ? found : nothing;
}

#endif

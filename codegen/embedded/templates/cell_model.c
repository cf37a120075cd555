/* @NOTICE@ */
#include "cell_model.h"

#include <math.h>

#define MRTS_NUMBER cell_real
#define MRTS_CONSTANT(value) ((cell_real)(value))
#if CELL_SINGLE
#define MRTS_MATH(function, a) function##f(a)
#else
#define MRTS_MATH(function, a) function(a)
#endif

/* Sine and cosine of a joint's angle by their series around the nearest quarter turn, to rounding: both cost less than
 * one of the C library's. Angles beyond some thousand turns go there. */
static void turn(cell_real angle, cell_real *sines) {
#if CELL_SINGLE
    /* pi / 2 in parts whose products with whole numbers are exact */
    static const cell_real part[3] = {1.5703125f, 4.83751297e-4f, 7.54978995e-8f}, most = 5e3f;
#else
    static const cell_real part[3] = {1.57079632673412561417, 6.0771005065061922e-11, 0.0}, most = 5e5;
#endif
    const cell_real quarters = angle * MRTS_CONSTANT(0.63661977236758134308);
    if (quarters > -most && quarters < most) {
        const int nearest = (int)(quarters + (quarters < 0 ? MRTS_CONSTANT(-0.5) : MRTS_CONSTANT(0.5)));
        const cell_real turned = (cell_real)nearest;
        const cell_real r = ((angle - turned * part[0]) - turned * part[1]) - turned * part[2], z = r * r;
        cell_real sine = MRTS_CONSTANT(1.0 / 362880), cosine = MRTS_CONSTANT(-1.0 / 3628800);
#if CELL_SINGLE
#else
        sine += z * (-1.0 / 39916800 + z * (1.0 / 6227020800 - z / 1307674368000));
        cosine += z * (1.0 / 479001600 + z * (-1.0 / 87178291200 + z / 20922789888000));
#endif
        sine = MRTS_CONSTANT(-1.0 / 6) + z * (MRTS_CONSTANT(1.0 / 120) + z * (MRTS_CONSTANT(-1.0 / 5040) + z * sine));
        cosine = MRTS_CONSTANT(1.0 / 24) +
                 z * (MRTS_CONSTANT(-1.0 / 720) + z * (MRTS_CONSTANT(1.0 / 40320) + z * cosine));
        sine = r + r * z * sine;
        cosine = MRTS_CONSTANT(1) - (z * MRTS_CONSTANT(0.5) - z * z * cosine);
        sines[0] = nearest & 1 ? cosine : sine;
        sines[1] = nearest & 1 ? sine : cosine;
        if (nearest & 2) sines[0] = -sines[0];
        if ((nearest + 1) & 2) sines[1] = -sines[1];
    } else {
        sines[0] = MRTS_MATH(sin, angle);
        sines[1] = MRTS_MATH(cos, angle);
    }
}

#define MRTS_SIN(joint, a) sines[2 * (joint)]
#define MRTS_COS(joint, a) sines[2 * (joint) + 1]
#define MRTS_MODEL(name, signature) \
    static void name##_of(const cell_real *const *arg, const cell_real *sines, cell_real *const *res); \
    void name(const cell_real *const *arg, cell_real *const *res) { \
        cell_real sines[2 * CELL_JOINTS]; \
        for (int joint = 0; joint < CELL_JOINTS; ++joint) turn(arg[0][joint], sines + 2 * joint); \
        name##_of(arg, sines, res); \
    } \
    static void name##_of(const cell_real *const *arg, const cell_real *sines, cell_real *const *res)

@MODEL@

/* @NOTICE@ */
#include "cell_model.h"
#include "kernel/sines.inc"

#define MRTS_NUMBER cell_real
#define MRTS_CONSTANT(value) ((cell_real)(value))

static void turn(cell_real angle, cell_real *sines) {
    if (MRTS_ABS(angle) <= MRTS_MOST_ANGLE) {
        mrts_sine_cosine(angle, sines);
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

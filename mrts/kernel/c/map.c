/* SPDX-License-Identifier: MIT
 *
 * A generated function at all samples in one call from Python.
 */
#include "numbers.h"

typedef void (*mrts_function)(const double *const *arg, double *const *res);

/* Evaluates a generated function at `count` samples; a stride of 0 repeats an input. `in` and `out` move along. */
MRTS_EXPORT void mrts_map(mrts_function function, long long count, int inputs, const double **in, const long long *in_stride,
                          int outputs, double **out, const long long *out_stride) {
    for (long long sample = 0; sample < count; ++sample) {
        function(in, out);
        for (int i = 0; i < inputs; ++i) in[i] += in_stride[i];
        for (int i = 0; i < outputs; ++i) out[i] += out_stride[i];
    }
}

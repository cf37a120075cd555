/* SPDX-License-Identifier: MIT
 * Ranges and torques of samples read from a file, for counting instructions. The cell's library text comes first.
 * The file: samples, rows and numbers of the geometry as doubles, then the eight inputs, then start, column, value, lower, upper, group. */
#include <stdio.h>
#include <stdlib.h>

static double *take(FILE *file, size_t count) {
    double *values = malloc((count + 1) * sizeof(double));
    if (fread(values, sizeof(double), count, file) != count) exit(2);
    return values;
}

static int *take_ints(FILE *file, size_t count) {
    double *values = take(file, count);
    int *integers = malloc((count + 1) * sizeof(int));
    for (size_t i = 0; i < count; ++i) integers[i] = (int)values[i];
    return integers;
}

int main(int arguments, char **argument) {
    FILE *file = fopen(argument[arguments - 1], "rb");
    const double *head = take(file, 3), *in[MRTS_INPUTS];
    const long long n = (long long)head[0], rows = (long long)head[1];
    const int size[MRTS_INPUTS] = {MRTS_JOINTS, MRTS_JOINTS, MRTS_JOINTS, 9, 6, 6, 10, (int)head[2]};
    long long stride[MRTS_INPUTS];
    for (int i = 0; i < MRTS_INPUTS; ++i) {
        const int repeated = i >= MRTS_INPUTS - 2;
        in[i] = take(file, (size_t)(repeated ? size[i] : n * size[i]));
        stride[i] = repeated ? 0 : size[i];
    }
    const int *start = take_ints(file, (size_t)rows + 1), *column = take_ints(file, (size_t)start[rows]);
    const double *value = take(file, (size_t)start[rows]);
    const double *lower = take(file, (size_t)rows), *upper = take(file, (size_t)rows);
    const mrts_terms terms = {0, 0, 0, 0, 0};
    const mrts_limits limits = {(int)rows, start, column, value, lower, upper, take_ints(file, (size_t)rows), 0, 0};
    double *torque = calloc((size_t)n * (MRTS_JOINTS + MRTS_WRENCHES), sizeof(double));
    double *wrench = torque + n * MRTS_JOINTS;
    mrts_range *found = calloc((size_t)n, sizeof(mrts_range));
    unsigned char *status = calloc((size_t)n, 1);
    double weights[MRTS_JOINTS * MRTS_JOINTS] = {0}, c2 = 1;
    double *work = calloc(100000, sizeof(double)), *most = calloc((size_t)n, sizeof(double));
    int *iwork = calloc(10000, sizeof(int));
    for (int i = 0; i < MRTS_JOINTS; ++i) weights[i * (MRTS_JOINTS + 1)] = 1;
    for (long long i = 0; i < n; ++i) most[i] = MRTS_INFINITY;
    mrts_ranges(n, in, stride, &limits, &terms, most, 0, 0, found, work, iwork);
    mrts_torques(n, in, stride, &limits, &terms, &c2, 0, weights, 1e-9, torque, wrench, status, work, iwork);
    printf("%.6g\n", found->end[1]);
    return 0;
}

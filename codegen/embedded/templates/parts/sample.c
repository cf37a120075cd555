/* @NOTICE@ */
/* Whether all values are finite, and their sum too. */
static int all_finite(int count, const mrts_real *values) {
    mrts_real sum = 0;
    for (; count > 0; --count) sum += MRTS_ABS(*values++);
    return sum < MRTS_INFINITY;
}

/* Inputs of the generated functions; matrices there are column after column, hence the rotation `turned`. */
static void point_to(const @NAME@_sample *sample, const mrts_real *load, mrts_real turned[9], const mrts_real **arg) {
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) turned[3 * j + i] = sample->rotation[3 * i + j];
    }
    arg[0] = sample->q;
    arg[1] = sample->dq;
    arg[2] = sample->ddq;
    arg[3] = turned;
    arg[4] = sample->twist;
    arg[5] = sample->acceleration;
    arg[6] = load;
}

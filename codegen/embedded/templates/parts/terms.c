/* @NOTICE@ */
void @NAME@_terms(const @NAME@_sample *sample, const @NAME@_settings *settings, @NAME@_terms_of_sample *terms) {
    mrts_real turned[9];
    const mrts_real *arg[7];
    mrts_real *res[8];
    point_to(sample, settings->load, turned, arg);
    res[0] = terms->E;
    res[1] = terms->A;
    res[2] = terms->G;
    res[3] = terms->J;
    res[4] = terms->B;
    res[5] = terms->P;
    res[6] = terms->S;
    res[7] = terms->Q;
    @NAME@_model_terms(arg, res);@MOTOR_TERMS@
}

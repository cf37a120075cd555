    for (int i = 0; i < JOINTS; ++i) {
        if (!(settings->armature[i] >= 0) || !(settings->coulomb[i] >= 0) || !(settings->viscous[i] >= 0)) {
            return @MACRO@_BAD_ARGUMENT;
        }
    }
    if (!all_finite(JOINTS, settings->armature) || !all_finite(JOINTS, settings->coulomb) ||
        !all_finite(JOINTS, settings->viscous) || !(settings->rest_speed >= 0) || !(settings->rest_acceleration >= 0)) {
        return @MACRO@_BAD_ARGUMENT;
    }

    for (int i = 0; i < LINES; ++i) {
        if (!(settings->slope[i] >= 0) || !all_finite(1, settings->slope + i)) return @MACRO@_BAD_ARGUMENT;
    }

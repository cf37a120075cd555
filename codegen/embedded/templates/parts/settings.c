/* @NOTICE@ */
static const char *const ROW_TEXT[1 + @MACRO@_ROWS + @MACRO@_VELOCITIES] = {
    "c^2 >= 0",
@ROW_TEXT@
};

const char *@NAME@_status_text(@NAME@_status status) {
    switch (status) {
    case @MACRO@_OK: return "ok";
    case @MACRO@_UNBOUNDED: return "unbounded: nothing limits the speed";
    case @MACRO@_INFEASIBLE: return "infeasible: limits conflict at every speed";
    case @MACRO@_EMPTY: return "empty: no c^2 in common";
    case @MACRO@_UNDECIDED: return "undecided at this precision";
    case @MACRO@_BAD_ARGUMENT: return "bad argument";
    default: return "unknown status";
    }
}

const char *@NAME@_row_text(int row) {
    const int place = row < 0 ? -row : row;
    return place <= ROWS + VELOCITIES ? ROW_TEXT[place] : "unknown row";
}

void @NAME@_default_settings(@NAME@_settings *settings) {
    static const @NAME@_settings defaults = {
        {@LOAD@},
        {@LOWER@},
        {@UPPER@},
        {@VELOCITY@},
        {@WEIGHT@},@MOTOR_DEFAULTS@@LINE_DEFAULTS@
    };
    *settings = defaults;
}

@NAME@_status @NAME@_check_settings(const @NAME@_settings *settings) {
    if (!(settings->load[0] > 0) || !all_finite(@MACRO@_LOAD, settings->load) ||
        !all_finite(JOINTS, settings->weight)) {
        return @MACRO@_BAD_ARGUMENT;
    }
    for (int i = 0; i < ROWS; ++i) {
        if (!(settings->lower[i] <= settings->upper[i])) return @MACRO@_BAD_ARGUMENT;
    }
    for (int i = 0; i < VELOCITIES; ++i) {
        if (!(settings->velocity[i] > 0)) return @MACRO@_BAD_ARGUMENT;
    }
    for (int i = 0; i < JOINTS; ++i) {
        if (!(settings->weight[i] > 0)) return @MACRO@_BAD_ARGUMENT;
    }@MOTOR_CHECK@@LINE_CHECK@
    return @MACRO@_OK;
}

void @NAME@_reset(@NAME@_workspace *workspace) {
    for (int j = 0; j < K; ++j) workspace->lower_basis[j] = workspace->upper_basis[j] = 0;@RESET@
}

    for (int j = 0; j < 3 * (K + 1); ++j) workspace->curve_basis[j] = 0;
    workspace->curve_speed = 0;

    if (has_speed_terms(settings, &rows, workspace)) {
        return range_of_speed(&rows, most, fastest, range, workspace);
    }

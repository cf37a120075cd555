    static const int line_row[LINES] = {@LINE_ROWS@}, line_joint[LINES] = {@LINE_JOINTS@};
    for (int line = 0; line < LINES; ++line) {
        workspace->row_speed[line_row[line]] = settings->slope[line] * sample->dq[line_joint[line]];
    }

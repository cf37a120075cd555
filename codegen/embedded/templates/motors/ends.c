    static const int end_joint[ENDS] = {@END_JOINTS@};
    for (int end = 0; end < ENDS; ++end) {
        const mrts_real share = MRTS_ABS(sample->dq[end_joint[end]]) / settings->velocity[JOINTS + 2 + end];
        if (share * share * most <= 1) continue;
        most = 1 / (share * share);
        binding = JOINTS + 2 + end;
    }

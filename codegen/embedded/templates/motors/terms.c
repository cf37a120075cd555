    for (int joint = 0; joint < JOINTS; ++joint) {
        terms->E[joint] += settings->armature[joint] * sample->ddq[joint];
        terms->A[joint] += settings->armature[joint] * sample->dq[joint];
        terms->V[joint] = settings->viscous[joint] * sample->dq[joint];
        terms->C[joint] = dry_friction(sample, settings, joint, &terms->turning[joint]);
    }

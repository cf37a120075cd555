/* @NOTICE@ */
static int sign_beyond(mrts_real value, mrts_real rest) { return value > rest ? 1 : value < -rest ? -1 : 0; }

/* Signs of a joint's velocity just before and just after a sample, 0 where it stands: where q' = 0 it arrives against
 * q'' and leaves along it. */
static void directions(const @NAME@_sample *sample, const @NAME@_settings *settings, int joint, int *before,
                       int *after) {
    const int moving = sign_beyond(sample->dq[joint], settings->rest_speed);
    const int leaving = sign_beyond(sample->ddq[joint], settings->rest_acceleration);
    *before = moving != 0 ? moving : -leaving;
    *after = moving != 0 ? moving : leaving;
    if (sample->place == @MACRO@_START) *before = *after;
    if (sample->place == @MACRO@_END) *after = *before;
}

/* Dry friction of a joint; where it turns back that is 0, and acts in both directions with `turning`. */
static mrts_real dry_friction(const @NAME@_sample *sample, const @NAME@_settings *settings, int joint,
                              mrts_real *turning) {
    int before, after;
    directions(sample, settings, joint, &before, &after);
    *turning = before != after ? settings->coulomb[joint] : 0;
    return before == after ? settings->coulomb[joint] * (mrts_real)after : 0;
}

/* SPDX-License-Identifier: MIT
 *
 * A typical loop: feed a motion, get the speed that it admits, read torques. The samples are those of the test vectors. */
#include <stdio.h>

#include "cell.h"
#include "cell_vectors.h"

int main(void) {
    static cell_workspace workspace; /* static: it starts at zero */
    cell_settings settings;
    cell_horizon horizon;
    cell_range range;
    cell_real torque[CELL_JOINTS], wrench[CELL_WRENCHES];
    const int samples = CELL_PATH_SAMPLES, step = samples > 4 ? samples / 4 : 1;

    cell_default_settings(&settings);
#if CELL_MOTORS
    settings.rest_speed = CELL_REST_SPEED;
    settings.rest_acceleration = CELL_REST_ACCELERATION;
#endif
    cell_horizon_start(&horizon);
    for (int k = 0; k < samples; ++k) {
        cell_range_of_sample(&cell_vectors[k].sample, &settings, &range, &workspace);
        cell_horizon_add(&horizon, &range);
    }
    printf("%s: c^2 in [%.6g, %.6g], set at sample %ld\n", cell_status_text(horizon.status), (double)horizon.lower,
           (double)horizon.upper, horizon.upper_sample);
    if (horizon.status != CELL_OK) return 1;
    for (int k = 0; k < samples; k += step) {
        if (cell_torques(&cell_vectors[k].sample, &settings, horizon.upper, torque, wrench, &workspace) != CELL_OK) {
            return 1;
        }
        printf("sample %3d:", k);
        for (int joint = 0; joint < CELL_JOINTS; ++joint) printf(" %8.3f", (double)torque[joint]);
        printf("\n");
    }
    return 0;
}

/* @NOTICE@
 * A typical loop: feed a motion, get the speed that it admits, read torques. The samples are those of the test vectors. */
#include <stdio.h>

#include "@NAME@.h"
#include "@NAME@_vectors.h"

int main(void) {
    static @NAME@_workspace workspace; /* static: it starts at zero */
    @NAME@_settings settings;
    @NAME@_horizon horizon;
    @NAME@_range range;
    @NAME@_real torque[@MACRO@_JOINTS], wrench[@MACRO@_WRENCHES];
    const int samples = @MACRO@_PATH_SAMPLES, step = samples > 4 ? samples / 4 : 1;

    @NAME@_default_settings(&settings);@SET_REST@
    @NAME@_horizon_start(&horizon);
    for (int k = 0; k < samples; ++k) {
        @NAME@_range_of_sample(&@NAME@_vectors[k].sample, &settings, &range, &workspace);
        @NAME@_horizon_add(&horizon, &range);
    }
    printf("%s: c^2 in [%.6g, %.6g], set at sample %ld\n", @NAME@_status_text(horizon.status), (double)horizon.lower,
           (double)horizon.upper, horizon.upper_sample);
    if (horizon.status != @MACRO@_OK) return 1;
    for (int k = 0; k < samples; k += step) {
        if (@NAME@_torques(&@NAME@_vectors[k].sample, &settings, horizon.upper, torque, wrench, &workspace) != @MACRO@_OK) {
            return 1;
        }
        printf("sample %3d:", k);
        for (int joint = 0; joint < @MACRO@_JOINTS; ++joint) printf(" %8.3f", (double)torque[joint]);
        printf("\n");
    }
    return 0;
}

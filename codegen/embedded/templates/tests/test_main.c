/* @NOTICE@
 * Every vector against this library; exits non-zero on a mismatch. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "@NAME@.h"
#include "@NAME@_vectors.h"

/* Relative, for c^2; of torques 10 times that, against their limits. */
#define TOLERANCE (sizeof(@NAME@_real) > 4 ? 1e-8 : 1e-4)

#define ALLOWED (sizeof(@NAME@_real) > 4 ? 0 : @MACRO@_VECTORS / 4) /* answers left undecided */

static int failures = 0;

static int close_to(double ours, double theirs) {
    return fabs(ours - theirs) <= TOLERANCE * (fabs(theirs) + TOLERANCE);
}

static void demand(int holds, int vector, const char *what, double ours, double theirs) {
    if (holds) return;
    ++failures;
    if (failures <= 10) printf("vector %d: %s is %.10g, expected %.10g\n", vector, what, ours, theirs);
}

/* The larger side of a torque's limit; of the largest torque if it has none or is zero. */
static double unit_of(const @NAME@_settings *settings, int joint) {
    double own = 0, largest = 0;
    for (int i = 0; i < @MACRO@_JOINTS; ++i) {
        const double low = fabs((double)settings->lower[i]), high = fabs((double)settings->upper[i]);
        double size = low < (double)@MACRO@_UNLIMITED ? low : 0;
        if (high < (double)@MACRO@_UNLIMITED && high > size) size = high;
        if (i == joint) own = size;
        if (size > largest) largest = size;
    }
    return own > 0 ? own : largest;
}

static void compare(int k, const char *what, const @NAME@_range *range, int status, double lower, double upper,
                    int *undecided) {
    if (range->status == @MACRO@_UNDECIDED) {
        ++*undecided;
        return;
    }
    demand((int)range->status == status, k, what, range->status, status);
    if ((int)range->status != status || status == @MACRO@_INFEASIBLE) return;
    demand(close_to((double)range->lower, lower), k, "lower end", (double)range->lower, lower);
    if (status != @MACRO@_UNBOUNDED) demand(close_to((double)range->upper, upper), k, "upper end", (double)range->upper, upper);
}

int main(void) {
    static @NAME@_workspace workspace, fresh;
    @NAME@_settings settings;
    @NAME@_range range, again;
    @NAME@_real torque[@MACRO@_JOINTS], wrench[@MACRO@_WRENCHES];
    int undecided = 0, seen[7] = {0};
    @NAME@_default_settings(&settings);@SET_REST@
    demand(@NAME@_check_settings(&settings) == @MACRO@_OK, -1, "settings", 1, 0);
    for (int k = 0; k < @MACRO@_VECTORS; ++k) {
        const @NAME@_vector *vector = &@NAME@_vectors[k];
        settings.load[0] = vector->mass;
        @NAME@_range_of_sample(&vector->sample, &settings, &range, &workspace);
        ++seen[range.status];
        compare(k, "status", &range, vector->status, vector->lower, vector->upper, &undecided);
        memset(&fresh, 0, sizeof fresh);
        @NAME@_range_of_sample(&vector->sample, &settings, &again, &fresh);
        if (again.status != @MACRO@_UNDECIDED && range.status == @MACRO@_OK) {
            demand(close_to((double)again.upper, (double)range.upper), k, "cold start", (double)again.upper,
                   (double)range.upper);
        }
        @NAME@_equal_share_range(&vector->sample, &settings, &range, &workspace);
        compare(k, "equal share", &range, vector->share_status, vector->share_lower, vector->share_upper, &undecided);
        if (vector->c2 <= 0) continue;
        if (@NAME@_torques(&vector->sample, &settings, (@NAME@_real)vector->c2, torque, wrench, &workspace) != @MACRO@_OK) {
            ++undecided;
            continue;
        }
        for (int joint = 0; joint < @MACRO@_JOINTS; ++joint) {
            demand(fabs((double)torque[joint] - vector->torque[joint]) <= 10 * TOLERANCE * unit_of(&settings, joint), k, "torque",
                   (double)torque[joint], vector->torque[joint]);
        }
    }
    printf("%d vectors: %d ok, %d unbounded, %d infeasible, %d undecided; %d mismatches\n", @MACRO@_VECTORS,
           seen[@MACRO@_OK], seen[@MACRO@_UNBOUNDED], seen[@MACRO@_INFEASIBLE], undecided, failures);
    return failures != 0 || undecided > ALLOWED || seen[@MACRO@_OK] == 0;
}

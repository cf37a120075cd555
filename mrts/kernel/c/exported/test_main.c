/* SPDX-License-Identifier: MIT
 *
 * Every vector against this library; exits non-zero on a mismatch. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cell.h"
#include "cell_vectors.h"

/* Relative, for c^2; of torques 10 times that, against their limits. */
#define TOLERANCE (sizeof(cell_real) > 4 ? 1e-8 : 1e-4)

#define ALLOWED (sizeof(cell_real) > 4 ? 0 : CELL_VECTORS / 4) /* answers left undecided */

static int failures = 0;

static int close_to(double ours, double theirs) {
    return fabs(ours - theirs) <= TOLERANCE * (fabs(theirs) + TOLERANCE);
}

static void demand(int holds, int vector, const char *what, double ours, double theirs) {
    if (holds) return;
    ++failures;
    if (failures <= 10) printf("vector %d: %s is %.10g, expected %.10g\n", vector, what, ours, theirs);
}

static void compare(int k, const char *what, const cell_range *range, int status, cell_real lower, cell_real upper,
                    int *undecided) {
    if (range->status == CELL_UNDECIDED) {
        ++*undecided;
        return;
    }
    demand((int)range->status == status, k, what, range->status, status);
    if ((int)range->status != status || status == CELL_INFEASIBLE) return;
    const double ours[] = {(double)range->lower, (double)range->upper}, theirs[] = {(double)lower, (double)upper};
    demand(close_to(ours[0], theirs[0]), k, "lower end", ours[0], theirs[0]);
    if (status != CELL_UNBOUNDED) demand(close_to(ours[1], theirs[1]), k, "upper end", ours[1], theirs[1]);
}
#if CELL_THINGS

/* Python keeps friction by a polygon inside its cone, of 224 sides: its answers lie between those of the cone and of this
 * share of it. */
#define POLYGON (cell_real)0.9999

/* Moves answers onto others that lie between them and those `inside`, whose range is the shorter one. */
static void approach(cell_range *range, const cell_range *inside, int status, cell_real lower, cell_real upper) {
    const int left = inside->status == CELL_OK || inside->status == CELL_UNBOUNDED;
    const double low = (double)(left ? inside->lower : range->upper), high = (double)(left ? inside->upper : range->lower);
    if ((int)inside->status == status) range->status = inside->status;
    if (lower >= range->lower && (double)lower <= low * (1 + TOLERANCE)) range->lower = lower;
    if (upper <= range->upper && (double)upper >= high * (1 - TOLERANCE)) range->upper = upper;
}
#endif

int main(void) {
    static cell_workspace workspace, fresh;
    cell_settings settings;
    cell_range range, again;
    cell_real torque[CELL_JOINTS], wrench[CELL_WRENCHES];
    int undecided = 0, seen[7] = {0};
    cell_default_settings(&settings);
#if CELL_MOTORS
    settings.rest_speed = CELL_REST_SPEED;
    settings.rest_acceleration = CELL_REST_ACCELERATION;
#endif
    demand(cell_check_settings(&settings) == CELL_OK, -1, "settings", 1, 0);
#if CELL_THINGS
    cell_settings narrower = settings;
    cell_range inside;
    for (int i = 0; i < CELL_THINGS; ++i) {
        if (narrower.friction[i] < CELL_UNLIMITED) narrower.friction[i] *= POLYGON;
    }
#endif
    for (int k = 0; k < CELL_VECTORS; ++k) {
        const cell_vector *vector = &cell_vectors[k];
        settings.load[0] = vector->mass;
        cell_range_of_sample(&vector->sample, &settings, &range, &workspace);
        ++seen[range.status];
        memset(&fresh, 0, sizeof fresh);
        cell_range_of_sample(&vector->sample, &settings, &again, &fresh);
        if (again.status != CELL_UNDECIDED && range.status == CELL_OK) {
            demand(close_to((double)again.upper, (double)range.upper), k, "cold start", (double)again.upper,
                   (double)range.upper);
        }
#if CELL_THINGS
        narrower.load[0] = vector->mass;
        cell_range_of_sample(&vector->sample, &narrower, &inside, &workspace);
        approach(&range, &inside, vector->status, vector->lower, vector->upper);
#endif
        compare(k, "status", &range, vector->status, vector->lower, vector->upper, &undecided);
        cell_equal_share_range(&vector->sample, &settings, &range, &workspace);
#if CELL_THINGS
        cell_equal_share_range(&vector->sample, &narrower, &inside, &workspace);
        approach(&range, &inside, vector->share_status, vector->share_lower, vector->share_upper);
#endif
        compare(k, "equal share", &range, vector->share_status, vector->share_lower, vector->share_upper, &undecided);
        if (vector->c2 <= 0) continue;
        if (cell_torques(&vector->sample, &settings, vector->c2, torque, wrench, &workspace) != CELL_OK) {
            ++undecided;
            continue;
        }
        for (int joint = 0; joint < CELL_JOINTS; ++joint) {
            const double found = (double)torque[joint], wanted = (double)vector->torque[joint];
            const double limit = 1 / sqrt((double)settings.weight[joint]);
            demand(fabs(found - wanted) <= 10 * TOLERANCE * limit, k, "torque", found, wanted);
        }
    }
    printf("%d vectors: %d ok, %d unbounded, %d infeasible, %d undecided; %d mismatches\n", CELL_VECTORS,
           seen[CELL_OK], seen[CELL_UNBOUNDED], seen[CELL_INFEASIBLE], undecided, failures);
    printf("workspace %u bytes, settings %u bytes\n", (unsigned)sizeof workspace, (unsigned)sizeof settings);
    return failures != 0 || undecided > ALLOWED || seen[CELL_OK] == 0;
}

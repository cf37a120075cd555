/* SPDX-License-Identifier: MIT
 *
 * What Python asks of a plan that is played, in the C of an export; sizes and the model are macros of the cell. */
#include "../numbers.h"

typedef double cell_real;
typedef enum { CELL_OK = 0, CELL_INFEASIBLE = 2, CELL_BAD_ARGUMENT = 5 } cell_status;
#define CELL_UNLIMITED MRTS_INFINITY

#include "cell_override.c"

/* States at `count` places, inside[k] after node[k], with their speeds and accelerations, signs as they are. */
MRTS_EXPORT void mrts_override_states(const cell_plan *plan, long long count, const int *node, const double *inside,
                                      const double *speed, const double *acceleration, cell_override *states) {
    for (long long k = 0; k < count; ++k) {
        states[k].node = node[k];
        states[k].inside = inside[k];
        states[k].time = plan->nodes[node[k]].time + inside[k];
        states[k].speed = states[k].aim = speed[k];
        states[k].acceleration = acceleration[k];
        states[k].direction = speed[k] < 0 ? -1 : 1;
        states[k].active = states[k].finished = 0;
        play(plan, states + k);
    }
}

/* As many ticks of dt as there are wishes, and the state after each; the status of the last. */
MRTS_EXPORT int mrts_override_play(const cell_plan *plan, long long count, const double *wanted, double dt,
                                   const cell_override *start, cell_override *states) {
    cell_override now = *start;
    int status = CELL_OK;
    for (long long k = 0; k < count && status == CELL_OK; ++k) {
        status = cell_override_step(plan, wanted[k], dt, &now);
        states[k] = now;
    }
    return status;
}

/* Of each state the seconds until it stands still, and where. */
MRTS_EXPORT void mrts_override_stops(const cell_plan *plan, long long count, const cell_override *states, double dt,
                                     double *seconds, double *stands) {
    for (long long k = 0; k < count; ++k) seconds[k] = cell_override_stop_time(plan, states + k, dt, stands + k);
}

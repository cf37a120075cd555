/* SPDX-License-Identifier: MIT
 *
 * A controller at 1 kHz: it plays the plan, stops where half of it is over, waits, and goes on. */
#include <stdio.h>

#include "cell_override.h"

int main(void) {
    const cell_real dt = (cell_real)0.001;
    const cell_plan *plan = &cell_planned;
    const cell_real half = plan->nodes[plan->count - 1].time / 2;
    cell_override state;
    int ticks = 0, waited = 0;
    if (cell_override_start(plan, 0, 0, &state) != CELL_OK) return 1;
    for (; !state.finished && ticks < 1000000; ++ticks) {
        const int stop = state.time > half && waited < 100;
        cell_override_step(plan, stop ? (cell_real)0 : (cell_real)1, dt, &state);
        waited += stop && state.speed == 0; /* q, dq, ddq and torque of this tick go to the drives here */
        if (ticks % 50 == 0) {
            printf("s %.3f, speed %.2f, torque of the first joint %.3f %s\n", (double)state.time, (double)state.speed,
                   (double)state.torque[0], plan->limits[state.active]);
        }
    }
    printf("at rest after %d ticks\n", ticks);
    return state.finished ? 0 : 1;
}

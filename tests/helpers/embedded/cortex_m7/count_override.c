/* SPDX-License-Identifier: MIT
 * Instructions of ticks of a plan that is played, stopped and gone on with; see count_main.c for how they are counted. */
#include <stdint.h>
#include <stdio.h>

#include LIBRARY_HEADER

#define JOIN(a, b) a##b
#define WITH(a, b) JOIN(a, b)
#define C(name) WITH(PREFIX, name)

static volatile uint32_t *const systick = (volatile uint32_t *)0xE000E010;
static uint32_t from;

static void start(void) { from = systick[2]; }
static double instructions(void) { return (double)((from - systick[2]) & 0xFFFFFFu) / 1.6; }

int main(void) {
    static C(_override) state;
    const C(_plan) *plan = &C(_planned);
    const C(_real) dt = (C(_real))0.001, half = plan->nodes[plan->count - 1].time / 2;
    double empty, sum = 0, most = 0, stop;
    int ticks = 0;
    systick[1] = 0xFFFFFF;
    systick[2] = 0;
    systick[0] = 5;
    start();
    empty = instructions();
    C(_override_start)(plan, half, 1, &state);
    start();
    C(_override_stop_time)(plan, &state, dt, 0);
    stop = instructions() - empty;
    C(_override_start)(plan, 0, 0, &state);
    while (!state.finished && ticks < 5000) {
        const C(_real) wanted = ticks % 100 < 60 ? (C(_real))1 : ticks % 100 < 80 ? (C(_real))0 : (C(_real))0.5;
        double count;
        start();
        C(_override_step)(plan, wanted, dt, &state);
        count = instructions() - empty;
        sum += count;
        if (count > most) most = count;
        ++ticks;
    }
    printf("tick %.0f, most %.0f; stop time %.0f; %d nodes of %u bytes\n", sum / ticks, most, stop, plan->count,
           (unsigned)sizeof plan->nodes[0]);
    return state.finished ? 0 : 1;
}

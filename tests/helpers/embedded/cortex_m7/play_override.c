/* SPDX-License-Identifier: MIT
 * States of an exported plan under wishes that a reader can draw too, and after calls with what is no wish.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include LIBRARY_HEADER

#define JOIN(a, b) a##b
#define WITH(a, b) JOIN(a, b)
#define C(name) WITH(PREFIX, name)
#define COUNT(array) ((int)(sizeof(array) / sizeof(array)[0]))

enum { TICKS = 1500, HELD = 25 };

static const C(_plan) *const plan = &C(_planned);

static void print_number(double value) { printf("%.9g ", value); }

/* Whether a state is one that a controller may command. */
static int sound(const C(_override) *state) {
    int fine = state->time >= 0 && state->time <= plan->nodes[plan->count - 1].time && state->node >= 0;
    fine = fine && state->node < plan->count - 1 && isfinite(state->speed) && isfinite(state->acceleration);
    for (int j = 0; j < COUNT(state->torque); ++j) fine = fine && isfinite(state->torque[j]) && isfinite(state->q[j]);
    for (int i = 0; i < COUNT(state->wrench); ++i) fine = fine && isfinite(state->wrench[i]);
    return fine;
}

/* Every function with every pair of numbers that may go wrong; how many states it left unsound or half changed. */
static int wrong_calls(const C(_override) *from) {
    const C(_real) all[] = {0,         (C(_real))-0.0, 1,         -1,        (C(_real))0.5,    (C(_real))1e-30, (C(_real))1e30,
                            (C(_real))-1e30, FLT_MAX,  -FLT_MAX,  FLT_MIN,   (C(_real))1e-44,  (C(_real))NAN,   (C(_real))INFINITY,
                            (C(_real))-INFINITY};
    int wrong = 0;
    for (int a = 0; a < COUNT(all); ++a) {
        for (int b = 0; b < COUNT(all); ++b) {
            C(_override) state = *from;
            C(_real) q[COUNT(state.q)], speed, stands;
            for (int j = 0; j < COUNT(q); ++j) q[j] = all[a] + (j ? from->q[j] : 0);
            for (int call = 0; call < 3; ++call) {
                int status;
                state = *from;
                if (call == 0) status = C(_override_start)(plan, all[a], all[b], &state);
                else if (call == 1) status = C(_override_step)(plan, all[a], all[b], &state);
                else status = C(_override_resume)(plan, q, all[b], &state);
                wrong += status ? memcmp(&state, from, sizeof state) != 0 : !sound(&state);
                if (call == 1 && !status) {
                    wrong += C(_override_step)(plan, all[b] < 1 ? 0 : 1, (C(_real))0.001, &state) || !sound(&state);
                }
            }
            state = *from;
            speed = all[b] > 0 && all[b] < 1 ? 0 : C(_override_speed_for_stop)(plan, from, all[a], all[b]);
            wrong += !(speed >= 0 && speed <= 4);
            if (b < 2) wrong += !(C(_override_stop_time)(plan, from, all[a], b ? &stands : 0) >= 0);
            wrong += memcmp(&state, from, sizeof state) != 0;
        }
    }
    return wrong;
}

int main(void) {
    static C(_override) state;
    unsigned drawn = 1;
    C(_real) wanted = 1;
    int wrong = C(_override_start)(plan, 0, 0, &state);
    for (int k = 0; k < TICKS; ++k) {
        if (k % HELD == 0) {
            drawn = (drawn * 1103515245u + 12345u) & 0x7FFFFFFFu;
            wanted = (C(_real))((drawn >> 16) % 13u) / 10;
        }
        wrong += C(_override_step)(plan, wanted, (C(_real))0.001, &state);
        if (k == 60 || k == 300) wrong += wrong_calls(&state);
        print_number(state.time);
        for (int j = 0; j < COUNT(state.torque); ++j) print_number(state.torque[j]);
        puts("");
    }
    return wrong;
}

/* SPDX-License-Identifier: MIT
 * Instructions and stack of each call, along the path of the test vectors: every instruction takes 64 ns of virtual time
 * (-icount shift=6), and SysTick runs at 25 MHz, so 1.6 ticks are one instruction. */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include LIBRARY_HEADER
#include VECTORS_HEADER

#define JOIN(a, b) a##b
#define WITH(a, b) JOIN(a, b)
#define C(name) WITH(PREFIX, name)
#define M(name) WITH(MACRO, name)

static volatile uint32_t *const systick = (volatile uint32_t *)0xE000E010;
static uint32_t from;

static void start(void) { from = systick[2]; }
static double instructions(void) { return (double)((from - systick[2]) & 0xFFFFFFu) / 1.6; }

enum { PAINTED = 65536 };
static uint8_t *bottom;

__attribute__((noinline)) static void paint(void) {
    volatile uint8_t area[PAINTED];
    bottom = (uint8_t *)(uintptr_t)area;
    for (int i = 0; i < PAINTED; ++i) area[i] = 0xA5;
}

static int used(void) {
    int untouched = 0;
    while (untouched < PAINTED && bottom[untouched] == 0xA5) ++untouched;
    return PAINTED - untouched;
}

static void report(const char *what, double sum, double most, int count, int stack) {
    printf("%-22s %9.0f %9.0f %7d\n", what, sum / count, most, stack);
}

int main(void) {
    static C(_workspace) workspace;
    static C(_terms_of_sample) terms;
    static C(_settings) settings;
    static C(_range) range;
    static C(_real) torque[M(_JOINTS)], wrench[M(_WRENCHES)];
    const char *const name[] = {"terms", "range, warm", "range, cold", "equal share", "torques"};
    double empty, sum[5] = {0}, most[5] = {0};
    int stack[5];
    systick[1] = 0xFFFFFF;
    systick[2] = 0;
    systick[0] = 5;
    C(_default_settings)(&settings);
    start();
    empty = instructions();
    for (int call = 0; call < 5; ++call) {
        paint();
        memset(&workspace, 0, sizeof workspace);
        for (int k = 1; k < M(_PATH_SAMPLES) - 1; ++k) {
            const C(_vector) *vector = &C(_vectors)[k];
            double count;
            if (call == 2) C(_reset)(&workspace);
            start();
            if (call == 0) C(_terms)(&vector->sample, &settings, &terms);
            if (call == 1 || call == 2) C(_range_of_sample)(&vector->sample, &settings, &range, &workspace);
            if (call == 3) C(_equal_share_range)(&vector->sample, &settings, &range, &workspace);
            if (call == 4) C(_torques)(&vector->sample, &settings, (C(_real))vector->c2, torque, wrench, &workspace);
            count = instructions() - empty;
            sum[call] += count;
            if (count > most[call]) most[call] = count;
        }
        stack[call] = used();
    }
    for (int call = 0; call < 5; ++call) report(name[call], sum[call], most[call], M(_PATH_SAMPLES) - 2, stack[call]);
    printf("workspace %u, settings %u bytes\n", (unsigned)sizeof workspace, (unsigned)sizeof settings);
    return 0;
}

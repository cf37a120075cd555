/* SPDX-License-Identifier: MIT
 * Reset of a Cortex-M7 under `qemu-system-arm -M mps2-an500`: vectors, FPU, data, semihosting, main, exit. */
#include <stdint.h>
#include <stdlib.h>

extern uint32_t __stack_top, __data_load, __data_start, __data_end, __bss_start, __bss_end;
extern void initialise_monitor_handles(void);
extern int main(void);

static void stopped(void) { exit(99); }

void reset(void) {
    uint32_t *from = &__data_load;
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; /* CPACR: the FPU is on */
    __asm volatile("dsb\nisb");
    for (uint32_t *to = &__data_start; to < &__data_end;) *to++ = *from++;
    for (uint32_t *to = &__bss_start; to < &__bss_end;) *to++ = 0;
    initialise_monitor_handles();
    exit(main());
}

void _init(void) {}
void _fini(void) {}

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    &__stack_top, (const void *)reset, (const void *)stopped, (const void *)stopped, (const void *)stopped,
    (const void *)stopped, (const void *)stopped,
};

/* Runs generated code along samples on the target and prints the estimates, bit by bit, and their cost.

   The emulator advances its clock by one nanosecond an instruction, and the system timer counts that clock
   in units of TICK instructions. Instructions, not microseconds: the emulator knows no pipeline. */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "brushgrip.h"
#include "samples.h"

#define TIMER ((volatile uint32_t *)0xE000E010)
#define DEEPEST 65536

static brushgrip_state_t state;

static uint32_t now(void) { return 0xFFFFFFu - TIMER[2]; }

static uint32_t since(uint32_t begin) { return (now() - begin) & 0xFFFFFFu; }

static unsigned bits(float value) {
    uint32_t word;
    memcpy(&word, &value, sizeof word);
    return (unsigned)word;
}

/* Paints the stack below, so that what a step touches of it shows. */
static __attribute__((noinline)) void paint(void) {
    volatile uint8_t below[DEEPEST];
    int i;
    for (i = 0; i < DEEPEST; ++i) below[i] = 0xA5;
}

static __attribute__((noinline)) int touched(void) {
    volatile uint8_t below[DEEPEST];
    int i = 0;
    while (i < DEEPEST && below[i] == 0xA5) ++i;
    return DEEPEST - i;
}

static __attribute__((noinline)) uint32_t hundred_thousand(void) {
    uint32_t left = 50000, begin = now();
    __asm volatile("1: subs %0, #1\n\tbne 1b" : "+r"(left) : : "cc");
    return since(begin);
}

int main(void) {
    static brushgrip_estimate_t estimates[COUNT];
    uint32_t spent = 0, begin, most = 0;
    int i, stack;
    TIMER[1] = 0xFFFFFFu, TIMER[2] = 0, TIMER[0] = 5;
    begin = hundred_thousand();
    brushgrip_init(&state);
    paint();
    for (i = 0; i < COUNT; ++i) {
        brushgrip_sample_t sample = {SAMPLES[i][0], SAMPLES[i][1], SAMPLES[i][2], SAMPLES[i][3], SAMPLES[i][4]};
        uint32_t from = now(), took;
        brushgrip_step(&state, &sample);
        took = since(from);
        spent += took;
        if (took > most) most = took;
        brushgrip_estimate(&state, &estimates[i]);
    }
    stack = touched();
    printf("tick %d\nspent %lu\nmost %lu\nstack %d\nstate %d\n", (int)(100000 / begin), (unsigned long)spent,
           (unsigned long)most, stack, (int)sizeof state);
    for (i = 0; i < COUNT; ++i)
        printf("%08x %08x %08x %d %d %08x %08x %08x %08x %d\n", bits(estimates[i].mu), bits(estimates[i].mu_std),
               bits(estimates[i].M_z_predicted), (int)estimates[i].informed, (int)estimates[i].usable, bits(estimates[i].mu_eff),
               bits(estimates[i].mu_eff_std), bits(estimates[i].M_slide), bits(estimates[i].nis), (int)estimates[i].status);
    return 0;
}

/* Starts a program on a Cortex-M in an emulator: vectors, memory as C wants it, the floating-point unit. */
#include <stdint.h>
#include <string.h>

extern uint32_t data_from, data_begin, data_end, bss_begin, bss_end, stack_top;
extern void initialise_monitor_handles(void);
extern void _exit(int status);
extern int main(void);
void start(void);
static void fault(void);

void start(void) {
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20;
    __asm volatile("dsb\n\tisb");
    memcpy(&data_begin, &data_from, (size_t)((char *)&data_end - (char *)&data_begin));
    memset(&bss_begin, 0, (size_t)((char *)&bss_end - (char *)&bss_begin));
    initialise_monitor_handles();
    _exit(main());
}

static void fault(void) { _exit(99); }

__attribute__((section(".vectors"), used)) static void *const vectors[] = {
    &stack_top, (void *)start, (void *)fault, (void *)fault, (void *)fault, (void *)fault, (void *)fault,
};

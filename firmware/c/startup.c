/* From reset to newlib's start-up code, which gets its arguments and files from the host (rdimon.specs). */
#include <stdint.h>

extern uint32_t stack_top;
void _start(void);
void reset(void);
void fault(void);

void reset(void)
{
    volatile uint32_t *coprocessor_access = (volatile uint32_t *)0xE000ED88u;
    *coprocessor_access |= 0xFu << 20; /* the floating-point unit, which hard-float code takes for granted */
    __asm__ volatile("dsb\n\tisb");
    _start();
}

/* Ends the emulation with a status other than 0: SYS_EXIT, a run-time error. */
void fault(void)
{
    __asm__ volatile("mov r0, #0x18\n\tldr r1, =0x20023\n\tbkpt 0xAB");
    for (;;) {
    }
}

struct vectors {
    uint32_t *stack;
    void (*handlers[15])(void);
};

__attribute__((section(".vectors"), used)) static const struct vectors vectors = {
    &stack_top,
    {reset, fault, fault, fault, fault, fault},
};

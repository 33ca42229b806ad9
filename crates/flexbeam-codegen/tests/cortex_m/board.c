/* An ARM MPS2 board as qemu has it: start, a counter of instructions, words to the host by semihosting. */
#include "board.h"

extern uint32_t data_from[], data_start[], data_end[], bss_start[], bss_end[], stack_top[];
extern int main(void);
void reset_handler(void);
static void fault_handler(void);

__attribute__((section(".vectors"), used)) static const void *const vectors[16] = {
    stack_top,     reset_handler, fault_handler, fault_handler, fault_handler, fault_handler, fault_handler, 0, 0, 0, 0,
    fault_handler, fault_handler, 0,             fault_handler, fault_handler,
};

#define SYSTICK_CONTROL (*(volatile uint32_t *)0xE000E010u)
#define SYSTICK_RELOAD (*(volatile uint32_t *)0xE000E014u)
#define SYSTICK_NOW (*(volatile uint32_t *)0xE000E018u)
#define COPROCESSORS (*(volatile uint32_t *)0xE000ED88u)

static int semihosting(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void board_say(const char *text)
{
    semihosting(0x04, text);
}

void board_end(uint32_t status)
{
    const uint32_t reason[2] = {0x20026u, status};
    semihosting(0x20, reason);
    for (;;) {
    }
}

static void fault_handler(void)
{
    board_say("hard fault\n");
    board_end(9);
}

uint32_t board_count(void)
{
    return 0xFFFFFFu - SYSTICK_NOW;
}

enum { PAINTED = 16384 };

#define PAINT 0xA5A5A5A5u

static uint32_t stack_pointer;

/* This function, the next one and board_count use no stack, as the test makes sure. */
void board_paint(void)
{
    __asm__ volatile("mov %0, sp" : "=r"(stack_pointer));
    for (uint32_t at = stack_pointer - PAINTED; at < stack_pointer; at += 4) {
        *(volatile uint32_t *)at = PAINT;
    }
}

uint32_t board_stack_used(void)
{
    uint32_t at = stack_pointer - PAINTED;
    while (at < stack_pointer && *(volatile uint32_t *)at == PAINT) {
        at += 4;
    }
    return stack_pointer - at;
}

void reset_handler(void)
{
    const uint32_t *from = data_from;
    COPROCESSORS |= 0xFu << 20; /* the FPU, where there is one */
    __asm__ volatile("dsb\n isb");
    for (uint32_t *to = data_start; to < data_end; ++to) {
        *to = *from++;
    }
    for (uint32_t *to = bss_start; to < bss_end; ++to) {
        *to = 0;
    }
    SYSTICK_RELOAD = 0xFFFFFFu;
    SYSTICK_NOW = 0;
    SYSTICK_CONTROL = 5; /* on, the processor's clock */
    board_end((uint32_t)main());
}

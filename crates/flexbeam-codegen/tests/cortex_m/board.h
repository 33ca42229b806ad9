#ifndef BOARD_H
#define BOARD_H

#include <stdint.h>

/* Text to the host. */
void board_say(const char *text);

/* Ends the simulation. */
void board_end(uint32_t status);

/* Counts up modulo 2^24 with the processor's clock of 25 MHz. Under -icount shift=0 an instruction takes a nanosecond: 40 to a count. */
uint32_t board_count(void);

/* Paints the stack below its caller. */
void board_paint(void);

/* Bytes that calls from the same caller have used since, down to the lowest word that was written. */
uint32_t board_stack_used(void);

#endif

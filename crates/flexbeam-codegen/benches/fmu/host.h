#ifndef HOST_H
#define HOST_H

#include <stddef.h>

/* Value references of the reference, theta and alpha, and of the voltage. */
static const unsigned int inputs[3] = {1, 2, 3};
static const unsigned int voltage[1] = {4};

/* A unit ready to step; a null pointer when it refuses. */
void *started(const char *token);

/* Sets the inputs, steps, reads the voltage: what is counted. 0 when all three are done. */
__attribute__((noinline)) int counted_tick(void *unit, double time, const double values[3], double *answer);

#endif

/* What both versions of the functional mock-up interface share: variables by their value references, one step, and a memory that
 * can be copied and written as bytes. No global state: as many instances as you like. */
#ifndef UPPER_FMU_H
#define UPPER_FMU_H

#include "NAME.h"

#include <stddef.h>
#include <stdint.h>

/* Value references, as modelDescription.xml has them. The settings stand behind these, in the order of struct NAME_settings. */
enum {
    UPPER_TIME = 0,
    UPPER_FIRST_INPUT = 1,
    UPPER_FIRST_OUTPUT = 4,
    UPPER_FAULT_OUTPUT = 10,
    UPPER_FIRST_SETTING = 11,
    UPPER_LAW_SETTING = 19,
    UPPER_VARIABLES = 32
};

/* How far the host is. */
enum NAME_phase { UPPER_INSTANTIATED, UPPER_INITIALIZING, UPPER_STEPPING, UPPER_TERMINATED };

/* All that one step hands to the next. */
struct NAME_memory {
    enum NAME_phase phase;
    double time_s;
    struct NAME_measured measured;
    struct NAME_commanded commanded;
    struct NAME_settings settings;
    struct NAME_state state;
};

/* As after instantiation: at rest, with the settings of the controller file. */
void NAME_memory_reset(struct NAME_memory *memory);

/* The number under a value reference; a null pointer where there is none. */
const double *NAME_number(const struct NAME_memory *memory, unsigned int variable);

/* The same for a number that the host may set: an input or a setting. */
double *NAME_settable_number(struct NAME_memory *memory, unsigned int variable);

/* The enumeration under a value reference: fault or law. */
bool NAME_get_enumeration(const struct NAME_memory *memory, unsigned int variable, int *value);

/* Sets the law. false: another variable, or no law. */
bool NAME_set_enumeration(struct NAME_memory *memory, unsigned int variable, int64_t value);

/* Whether a step has the length of the sample period, but for what a host's sum of steps rounds away. */
bool NAME_is_period(double step_s);

/* One tick with the inputs as they stand, from time_s on; its answers are the outputs at its end, one period later. */
void NAME_step(struct NAME_memory *memory, double time_s);

/* Bytes of a memory: the same on every machine. */
size_t NAME_memory_size(void);

/* Writes as many bytes as NAME_memory_size() says. */
void NAME_memory_write(const struct NAME_memory *memory, unsigned char *bytes);

/* Reads them back. false: of another controller, of another length, or no memory at all; then nothing is changed. */
bool NAME_memory_read(struct NAME_memory *memory, const unsigned char *bytes, size_t size);

#endif

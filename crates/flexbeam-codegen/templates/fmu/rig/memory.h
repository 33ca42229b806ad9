/* A rig's part of the unit: its variables by their value references, and all that one step hands to the next. */
#ifndef UPPER_MEMORY_H
#define UPPER_MEMORY_H

#include "NAME.h"

/* Value references, as modelDescription.xml has them. The parameters stand behind these, in the order of struct NAME_parameters. */
enum {
    UPPER_TIME = 0,
    UPPER_VOLTAGE = 1,
    UPPER_CONTACT = 9,
    UPPER_SEED = 10,
    UPPER_DELAY = 11,
    UPPER_FIRST_FRICTION = 16,
    UPPER_COUNTS = 19,
    UPPER_VARIABLES = 23
};

/* Most periods by which a voltage is late. */
#define UPPER_LONGEST_DELAY @LONGEST_DELAY@

/* What a host is told to need. */
#define UPPER_SETTABLE_NUMBERS "which is the input, or a parameter that may be set now, and a value of its range"
#define UPPER_WHOLES "contact, seed, delay_periods or encoder.counts_per_turn"
#define UPPER_SETTABLE_WHOLES "seed or delay_periods, before the first step, or encoder.counts_per_turn, and a value of its range"

/* What a host sets. */
struct NAME_given {
    double voltage_v;
    struct NAME_parameters parameters;
    int64_t seed;
    int64_t delay_periods;
};

/* All that one step hands to the next. */
struct NAME_memory {
    enum NAME_phase phase;
    double time_s;
    struct NAME_given given;
    struct NAME_measurement measured;
    struct NAME_truth truth;
    struct NAME_state state;
    double late_v[UPPER_LONGEST_DELAY]; /* on their way to the rig, the next one at late */
    int late;
};

#endif

/* A controller's part of the unit: its variables by their value references, and all that one step hands to the next. */
#ifndef UPPER_MEMORY_H
#define UPPER_MEMORY_H

#include "NAME.h"

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

/* What a host is told to need. */
#define UPPER_SETTABLE_NUMBERS "which is an input or a setting"
#define UPPER_WHOLES "fault or settings.law"
#define UPPER_SETTABLE_WHOLES "settings.law, and a value of 0, 1 or 2"

/* All that one step hands to the next. */
struct NAME_memory {
    enum NAME_phase phase;
    double time_s;
    struct NAME_measured measured;
    struct NAME_commanded commanded;
    struct NAME_settings settings;
    struct NAME_state state;
};

#endif

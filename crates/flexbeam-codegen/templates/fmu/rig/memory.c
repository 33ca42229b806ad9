/* See memory.h and fmu.h. */
#include "fmu.h"

#include <float.h>
#include <math.h> /* INFINITY alone */

/* ---- Variables ---- */

/* Where a number lies, and from which value to which it may be set. */
static const struct {
    size_t place;
    enum { READ_ONLY, FROM_LEAST, ABOVE_LEAST } range;
    double least;
    double most;
} numbers[UPPER_VARIABLES] = {
    [UPPER_TIME] = {offsetof(struct NAME_memory, time_s), READ_ONLY, 0.0, 0.0},
    [UPPER_VOLTAGE] = {offsetof(struct NAME_memory, given.voltage_v), FROM_LEAST, -INFINITY, INFINITY},
    [2] = {offsetof(struct NAME_memory, measured.theta_rad), READ_ONLY, 0.0, 0.0},
    [3] = {offsetof(struct NAME_memory, measured.alpha_rad), READ_ONLY, 0.0, 0.0},
    [4] = {offsetof(struct NAME_memory, truth.theta_rad), READ_ONLY, 0.0, 0.0},
    [5] = {offsetof(struct NAME_memory, truth.alpha_rad), READ_ONLY, 0.0, 0.0},
    [6] = {offsetof(struct NAME_memory, truth.psi_rad), READ_ONLY, 0.0, 0.0},
    [7] = {offsetof(struct NAME_memory, truth.theta_rad_s), READ_ONLY, 0.0, 0.0},
    [8] = {offsetof(struct NAME_memory, truth.alpha_rad_s), READ_ONLY, 0.0, 0.0},
    [12] = {offsetof(struct NAME_memory, given.parameters.actuator.converter_step_v), FROM_LEAST, 0.0, DBL_MAX},
    [13] = {offsetof(struct NAME_memory, given.parameters.actuator.limit_v), ABOVE_LEAST, 0.0, INFINITY},
    [14] = {offsetof(struct NAME_memory, given.parameters.actuator.dead_zone_plus_v), FROM_LEAST, 0.0, DBL_MAX},
    [15] = {offsetof(struct NAME_memory, given.parameters.actuator.dead_zone_minus_v), FROM_LEAST, 0.0, DBL_MAX},
    [16] = {offsetof(struct NAME_memory, given.parameters.friction.coulomb_nm), FROM_LEAST, 0.0, DBL_MAX},
    [17] = {offsetof(struct NAME_memory, given.parameters.friction.stribeck_extra_nm), FROM_LEAST, 0.0, DBL_MAX},
    [18] = {offsetof(struct NAME_memory, given.parameters.friction.stribeck_speed_rad_s), ABOVE_LEAST, 0.0, DBL_MAX},
    [20] = {offsetof(struct NAME_memory, given.parameters.gauge.noise_rad), FROM_LEAST, 0.0, DBL_MAX},
    [21] = {offsetof(struct NAME_memory, given.parameters.gauge.bias_rad), FROM_LEAST, -DBL_MAX, DBL_MAX},
    [22] = {offsetof(struct NAME_memory, given.parameters.gauge.converter_step_rad), FROM_LEAST, 0.0, DBL_MAX},
};

static bool is_whole(unsigned int variable)
{
    return variable == UPPER_CONTACT || variable == UPPER_SEED || variable == UPPER_DELAY || variable == UPPER_COUNTS;
}

const double *NAME_number(const struct NAME_memory *memory, unsigned int variable)
{
    const bool number = variable < UPPER_VARIABLES && !is_whole(variable);
    const void *place = (const unsigned char *)memory + numbers[number ? variable : 0].place;
    return number ? place : NULL;
}

/* At rest, with the noise from its beginning, and the sensors read. */
static void restart(struct NAME_memory *memory)
{
    NAME_reset(&memory->given.parameters, &memory->state, (uint64_t)memory->given.seed);
    memory->measured = NAME_measure(&memory->given.parameters, &memory->state);
    memory->truth = NAME_truth(&memory->state);
}

/* Before the first step a new parameter is one that was there from the beginning. */
static bool has_begun(const struct NAME_memory *memory)
{
    return memory->phase == UPPER_STEPPING || memory->phase == UPPER_TERMINATED;
}

/* For the voltage any number, and what is none: the rig takes that for 0 V. */
static bool may_be(unsigned int variable, double value)
{
    const double least = numbers[variable].least;
    switch (numbers[variable].range) {
    case FROM_LEAST:
        return variable == UPPER_VOLTAGE || (value >= least && value <= numbers[variable].most);
    case ABOVE_LEAST:
        return value > least && value <= numbers[variable].most;
    case READ_ONLY:
    default:
        return false;
    }
}

bool NAME_set_number(struct NAME_memory *memory, unsigned int variable, double value)
{
    const bool friction = variable >= UPPER_FIRST_FRICTION && variable < UPPER_COUNTS;
    if (NAME_number(memory, variable) == NULL || !may_be(variable, value) || (friction && has_begun(memory))) {
        return false;
    }
    void *place = (unsigned char *)memory + numbers[variable].place;
    *(double *)place = value;
    if (variable != UPPER_VOLTAGE && !has_begun(memory)) {
        restart(memory);
    }
    return true;
}

bool NAME_get_whole(const struct NAME_memory *memory, unsigned int variable, int64_t *value)
{
    switch (variable) {
    case UPPER_CONTACT:
        *value = memory->truth.contact;
        return true;
    case UPPER_SEED:
        *value = memory->given.seed;
        return true;
    case UPPER_DELAY:
        *value = memory->given.delay_periods;
        return true;
    case UPPER_COUNTS:
        *value = memory->given.parameters.encoder.counts_per_turn;
        return true;
    default:
        return false;
    }
}

bool NAME_set_whole(struct NAME_memory *memory, unsigned int variable, int64_t value)
{
    if (value < 0 || (variable != UPPER_COUNTS && has_begun(memory))) {
        return false;
    }
    if (variable == UPPER_SEED) {
        memory->given.seed = value;
    } else if (variable == UPPER_DELAY && value <= UPPER_LONGEST_DELAY) {
        memory->given.delay_periods = value;
    } else if (variable == UPPER_COUNTS && value <= INT32_MAX) {
        memory->given.parameters.encoder.counts_per_turn = (uint32_t)value;
    } else {
        return false;
    }
    if (!has_begun(memory)) {
        restart(memory);
    }
    return true;
}

/* ---- Time ---- */

void NAME_memory_reset(struct NAME_memory *memory)
{
    static const struct NAME_memory at_rest = {.phase = UPPER_INSTANTIATED};
    *memory = at_rest;
    memory->given.parameters = NAME_default_parameters;
    memory->given.seed = @SEED@;
    memory->given.delay_periods = @DELAY@;
    restart(memory);
}

/* The voltage that reaches the rig when this one is sent. */
static double late_v(struct NAME_memory *memory, double voltage_v)
{
    if (memory->given.delay_periods == 0) {
        return voltage_v;
    }
    const double arriving = memory->late_v[memory->late];
    memory->late_v[memory->late] = voltage_v;
    memory->late = (memory->late + 1) % (int)memory->given.delay_periods;
    return arriving;
}

void NAME_step(struct NAME_memory *memory, double time_s)
{
    const double voltage_v = late_v(memory, memory->given.voltage_v);
    NAME_apply(&memory->given.parameters, &memory->state, voltage_v);
    memory->measured = NAME_measure(&memory->given.parameters, &memory->state);
    memory->truth = NAME_truth(&memory->state);
    memory->time_s = time_s + UPPER_PERIOD_S;
}

/* ---- Bytes ---- */

static void whole_64(struct NAME_stream *stream, int64_t *value)
{
    uint64_t found = (uint64_t)*value;
    NAME_stream_bits(stream, &found);
    stream->sound = stream->sound && found <= INT64_MAX;
    *value = (int64_t)(found & INT64_MAX);
}

static void noise(struct NAME_stream *stream, struct NAME_noise *noise)
{
    uint64_t drawn = noise->drawn;
    uint64_t seed = noise->seed;
    NAME_stream_bits(stream, &seed);
    NAME_stream_bits(stream, &drawn);
    NAME_noise_recall(noise, seed, drawn);
}

static void state(struct NAME_stream *stream, struct NAME_state *state)
{
    for (int k = 0; k < UPPER_ORDER; ++k) {
        NAME_stream_number(stream, &state->x[k]);
    }
    NAME_stream_number(stream, &state->direction);
    state->contact = (enum NAME_contact)NAME_stream_whole(stream, (int)state->contact, UPPER_CONTACT_SLIDING);
    noise(stream, &state->noise);
}

void NAME_memory_through(struct NAME_stream *stream, struct NAME_memory *memory)
{
    struct NAME_given *given = &memory->given;
    for (unsigned int variable = 0; variable < UPPER_VARIABLES; ++variable) {
        if (!is_whole(variable)) {
            void *place = (unsigned char *)memory + numbers[variable].place;
            NAME_stream_number(stream, place);
        }
    }
    memory->phase = (enum NAME_phase)NAME_stream_whole(stream, (int)memory->phase, UPPER_TERMINATED);
    memory->truth.contact = (enum NAME_contact)NAME_stream_whole(stream, (int)memory->truth.contact, UPPER_CONTACT_SLIDING);
    whole_64(stream, &given->seed);
    given->delay_periods = NAME_stream_whole(stream, (int)given->delay_periods, UPPER_LONGEST_DELAY);
    given->parameters.encoder.counts_per_turn =
        (uint32_t)NAME_stream_whole(stream, (int)given->parameters.encoder.counts_per_turn, INT32_MAX);
    state(stream, &memory->state);
    for (int k = 0; k < UPPER_LONGEST_DELAY; ++k) {
        NAME_stream_number(stream, &memory->late_v[k]);
    }
    memory->late = NAME_stream_whole(stream, memory->late, UPPER_LONGEST_DELAY - 1);
}

/* See fmu.h. */
#include "fmu.h"

#include <string.h>

/* ---- Variables ---- */

static const size_t numbers[UPPER_VARIABLES] = {
    offsetof(struct NAME_memory, time_s),
    offsetof(struct NAME_memory, measured.reference_rad),
    offsetof(struct NAME_memory, measured.theta_rad),
    offsetof(struct NAME_memory, measured.alpha_rad),
    offsetof(struct NAME_memory, commanded.voltage_v),
    offsetof(struct NAME_memory, commanded.u_v),
    offsetof(struct NAME_memory, commanded.reference_rad),
    offsetof(struct NAME_memory, commanded.y_rad),
    offsetof(struct NAME_memory, commanded.y_model_rad),
    offsetof(struct NAME_memory, commanded.error_rad),
    0, /* fault: no number */
    offsetof(struct NAME_memory, settings.theta.scale),
    offsetof(struct NAME_memory, settings.theta.offset_rad),
    offsetof(struct NAME_memory, settings.theta.low_pass),
    offsetof(struct NAME_memory, settings.alpha.scale),
    offsetof(struct NAME_memory, settings.alpha.offset_rad),
    offsetof(struct NAME_memory, settings.alpha.low_pass),
    offsetof(struct NAME_memory, settings.smooth_ticks),
    offsetof(struct NAME_memory, settings.smooth_step_rad),
    0, /* law: no number */
    offsetof(struct NAME_memory, settings.u_p_plus_v),
    offsetof(struct NAME_memory, settings.u_p_minus_v),
    offsetof(struct NAME_memory, settings.eps_u_v),
    offsetof(struct NAME_memory, settings.eps_e_rad),
    offsetof(struct NAME_memory, settings.hysteresis_u),
    offsetof(struct NAME_memory, settings.hysteresis_e),
    offsetof(struct NAME_memory, settings.breakaway_plus_v),
    offsetof(struct NAME_memory, settings.breakaway_minus_v),
    offsetof(struct NAME_memory, settings.voltage_limit_v),
    offsetof(struct NAME_memory, settings.deflection_limit_rad),
    offsetof(struct NAME_memory, settings.theta_limit_rad),
    offsetof(struct NAME_memory, settings.theta_step_limit_rad),
};

static bool is_number(unsigned int variable)
{
    return variable < UPPER_VARIABLES && variable != UPPER_FAULT_OUTPUT && variable != UPPER_LAW_SETTING;
}

const double *NAME_number(const struct NAME_memory *memory, unsigned int variable)
{
    const void *place = (const unsigned char *)memory + numbers[is_number(variable) ? variable : 0];
    return is_number(variable) ? place : NULL;
}

double *NAME_settable_number(struct NAME_memory *memory, unsigned int variable)
{
    const bool input = variable >= UPPER_FIRST_INPUT && variable < UPPER_FIRST_OUTPUT;
    const bool settable = is_number(variable) && (input || variable >= UPPER_FIRST_SETTING);
    void *place = (unsigned char *)memory + numbers[settable ? variable : 0];
    return settable ? place : NULL;
}

bool NAME_get_enumeration(const struct NAME_memory *memory, unsigned int variable, int *value)
{
    if (variable == UPPER_FAULT_OUTPUT) {
        *value = (int)memory->commanded.fault;
        return true;
    }
    if (variable == UPPER_LAW_SETTING) {
        *value = (int)memory->settings.law;
        return true;
    }
    return false;
}

bool NAME_set_enumeration(struct NAME_memory *memory, unsigned int variable, int64_t value)
{
    if (variable != UPPER_LAW_SETTING || value < UPPER_LAW_NONE || value > UPPER_LAW_INVERSE) {
        return false;
    }
    memory->settings.law = (enum NAME_law)value;
    return true;
}

/* ---- Time ---- */

void NAME_memory_reset(struct NAME_memory *memory)
{
    static const struct NAME_memory at_rest = {.phase = UPPER_INSTANTIATED};
    *memory = at_rest;
    memory->settings = NAME_default_settings;
    NAME_reset(&memory->state);
}

bool NAME_is_period(double step_s)
{
    const double off = step_s - UPPER_PERIOD_S;
    return -1e-6 * UPPER_PERIOD_S <= off && off <= 1e-6 * UPPER_PERIOD_S;
}

void NAME_step(struct NAME_memory *memory, double time_s)
{
    memory->commanded = NAME_tick(&memory->settings, &memory->state, memory->measured);
    memory->time_s = time_s + UPPER_PERIOD_S;
}

/* ---- Bytes: every number of eight, the least significant first, behind a head that names the controller ---- */

static const char head[] = "flexbeam FMU memory 1 " UPPER_SHA256;

/* Without bytes it counts. */
struct stream {
    unsigned char *written;
    const unsigned char *read;
    size_t at;
    bool sound;
};

static void bits(struct stream *stream, uint64_t *value)
{
    uint64_t found = 0;
    for (unsigned int k = 0; k < 8; ++k) {
        if (stream->written != NULL) {
            stream->written[stream->at + k] = (unsigned char)(*value >> (8 * k) & 255);
        }
        if (stream->read != NULL) {
            found |= (uint64_t)stream->read[stream->at + k] << (8 * k);
        }
    }
    if (stream->read != NULL) {
        *value = found;
    }
    stream->at += 8;
}

static void number(struct stream *stream, double *value)
{
    uint64_t found;
    memcpy(&found, value, sizeof found);
    bits(stream, &found);
    memcpy(value, &found, sizeof found);
}

static int whole(struct stream *stream, int value, int largest)
{
    uint64_t found = (uint64_t)value;
    bits(stream, &found);
    if (found > (uint64_t)largest) {
        stream->sound = false;
        return 0;
    }
    return (int)found;
}

static void flag(struct stream *stream, bool *value)
{
    *value = whole(stream, *value ? 1 : 0, 1) != 0;
}

static void low_pass(struct stream *stream, struct NAME_low_pass *filter)
{
    number(stream, &filter->y_f);
    flag(stream, &filter->has);
}

static void path(struct stream *stream, struct NAME_path *path)
{
    double *all[] = {&path->target, &path->position, &path->velocity, &path->acceleration, &path->c0,
                     &path->c1,     &path->c2,       &path->gone,     &path->ticks};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; ++k) {
        number(stream, all[k]);
    }
}

static void state(struct stream *stream, struct NAME_state *state)
{
    for (int k = 0; k < UPPER_ORDER + 3; ++k) {
        number(stream, &state->z[k]);
    }
    low_pass(stream, &state->theta);
    low_pass(stream, &state->alpha);
    path(stream, &state->reference);
    flag(stream, &state->error_is_large);
    flag(stream, &state->is_dead);
    state->fault = (enum NAME_fault)whole(stream, (int)state->fault, UPPER_FAULT_NON_FINITE);
}

static void memory_through(struct stream *stream, struct NAME_memory *memory)
{
    for (unsigned int variable = 0; variable < UPPER_VARIABLES; ++variable) {
        if (is_number(variable)) {
            void *place = (unsigned char *)memory + numbers[variable];
            number(stream, place);
        }
    }
    memory->phase = (enum NAME_phase)whole(stream, (int)memory->phase, UPPER_TERMINATED);
    memory->commanded.fault = (enum NAME_fault)whole(stream, (int)memory->commanded.fault, UPPER_FAULT_NON_FINITE);
    memory->settings.law = (enum NAME_law)whole(stream, (int)memory->settings.law, UPPER_LAW_INVERSE);
    state(stream, &memory->state);
}

size_t NAME_memory_size(void)
{
    struct NAME_memory any;
    struct stream stream = {NULL, NULL, sizeof head, true};
    NAME_memory_reset(&any);
    memory_through(&stream, &any);
    return stream.at;
}

void NAME_memory_write(const struct NAME_memory *memory, unsigned char *bytes)
{
    struct NAME_memory copy = *memory;
    struct stream stream = {bytes, NULL, sizeof head, true};
    memcpy(bytes, head, sizeof head);
    memory_through(&stream, &copy);
}

bool NAME_memory_read(struct NAME_memory *memory, const unsigned char *bytes, size_t size)
{
    struct NAME_memory found;
    struct stream stream = {NULL, bytes, sizeof head, true};
    if (size != NAME_memory_size() || memcmp(bytes, head, sizeof head) != 0) {
        return false;
    }
    NAME_memory_reset(&found);
    memory_through(&stream, &found);
    if (stream.sound) {
        *memory = found;
    }
    return stream.sound;
}

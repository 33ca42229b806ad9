/* See memory.h and fmu.h. */
#include "fmu.h"

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

bool NAME_set_number(struct NAME_memory *memory, unsigned int variable, double value)
{
    const bool input = variable >= UPPER_FIRST_INPUT && variable < UPPER_FIRST_OUTPUT;
    if (!is_number(variable) || !(input || variable >= UPPER_FIRST_SETTING)) {
        return false;
    }
    void *place = (unsigned char *)memory + numbers[variable];
    *(double *)place = value;
    return true;
}

bool NAME_get_whole(const struct NAME_memory *memory, unsigned int variable, int64_t *value)
{
    if (variable == UPPER_FAULT_OUTPUT) {
        *value = memory->commanded.fault;
        return true;
    }
    if (variable == UPPER_LAW_SETTING) {
        *value = memory->settings.law;
        return true;
    }
    return false;
}

bool NAME_set_whole(struct NAME_memory *memory, unsigned int variable, int64_t value)
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

void NAME_step(struct NAME_memory *memory, double time_s)
{
    memory->commanded = NAME_tick(&memory->settings, &memory->state, memory->measured);
    memory->time_s = time_s + UPPER_PERIOD_S;
}

/* ---- Bytes ---- */

static void flag(struct NAME_stream *stream, bool *value)
{
    *value = NAME_stream_whole(stream, *value ? 1 : 0, 1) != 0;
}

static void low_pass(struct NAME_stream *stream, struct NAME_low_pass *filter)
{
    NAME_stream_number(stream, &filter->y_f);
    flag(stream, &filter->has);
}

static void path(struct NAME_stream *stream, struct NAME_path *path)
{
    double *all[] = {&path->target, &path->position, &path->velocity, &path->acceleration, &path->c0,
                     &path->c1,     &path->c2,       &path->gone,     &path->ticks};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; ++k) {
        NAME_stream_number(stream, all[k]);
    }
}

static void state(struct NAME_stream *stream, struct NAME_state *state)
{
    for (int k = 0; k < UPPER_ORDER + 3; ++k) {
        NAME_stream_number(stream, &state->z[k]);
    }
    low_pass(stream, &state->theta);
    low_pass(stream, &state->alpha);
    path(stream, &state->reference);
    flag(stream, &state->error_is_large);
    flag(stream, &state->is_dead);
    state->fault = (enum NAME_fault)NAME_stream_whole(stream, (int)state->fault, UPPER_FAULT_NON_FINITE);
}

void NAME_memory_through(struct NAME_stream *stream, struct NAME_memory *memory)
{
    for (unsigned int variable = 0; variable < UPPER_VARIABLES; ++variable) {
        if (is_number(variable)) {
            void *place = (unsigned char *)memory + numbers[variable];
            NAME_stream_number(stream, place);
        }
    }
    memory->phase = (enum NAME_phase)NAME_stream_whole(stream, (int)memory->phase, UPPER_TERMINATED);
    memory->commanded.fault = (enum NAME_fault)NAME_stream_whole(stream, (int)memory->commanded.fault, UPPER_FAULT_NON_FINITE);
    memory->settings.law = (enum NAME_law)NAME_stream_whole(stream, (int)memory->settings.law, UPPER_LAW_INVERSE);
    state(stream, &memory->state);
}

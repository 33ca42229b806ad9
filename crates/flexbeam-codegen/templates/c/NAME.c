/* See NAME.h. The order of every sum and product here is that of flexbeam's kernel: do not rearrange. Small whole numbers in the
 * formulas are exact in every precision. */
#include "NAME.h"

#include <float.h>
#include <math.h> /* INFINITY alone */
#include <stddef.h>

@ARITHMETIC@

typedef NAME_real real;

/* A compiler with another format of numbers stops here. */
typedef char NAME_needs_ieee_754[FLT_RADIX == 2 && @MANTISSA_DIGITS@ == @DIGITS@ ? 1 : -1];

@GAINS@
const struct NAME_settings NAME_default_settings = {
@SETTINGS@
};

/* Without <math.h>: infinity minus infinity is not a number, and that equals nothing. */
static bool is_finite(real x)
{
    return x - x == 0;
}

static real magnitude(real x)
{
    return x < 0 ? -x : x;
}

/* ---- Measurements ---- */

static real scaled(const struct NAME_channel *channel, real measured)
{
    return channel->scale * (measured - channel->offset_rad);
}

/* y_f += a (y - y_f), written so that a = 1 passes y to the last bit; the first measurement passes. */
static real filtered(struct NAME_low_pass *filter, real a, real y)
{
    filter->y_f = filter->has ? y - (1 - a) * (y - filter->y_f) : y;
    filter->has = true;
    return filter->y_f;
}

static real last(const struct NAME_low_pass *filter)
{
    return filter->has ? filter->y_f : 0;
}

struct sensed {
    real theta;
    real alpha;
    real theta_change; /* since the tick before */
    bool finite;       /* all that came in was a number */
};

/* What is not a number leaves the filters as they were. */
static struct sensed sense(const struct NAME_settings *settings, struct NAME_state *state, struct NAME_measured measured)
{
    const real theta = scaled(&settings->theta, measured.theta_rad);
    const real alpha = scaled(&settings->alpha, measured.alpha_rad);
    struct sensed sensed = {0, 0, 0, false};
    sensed.finite = is_finite(theta) && is_finite(alpha) && is_finite(measured.reference_rad);
    if (!sensed.finite) {
        sensed.theta = last(&state->theta);
        sensed.alpha = last(&state->alpha);
        return sensed;
    }
    const bool moved = state->theta.has;
    const real before = state->theta.y_f;
    sensed.theta = filtered(&state->theta, settings->theta.low_pass, theta);
    sensed.alpha = filtered(&state->alpha, settings->alpha.low_pass, alpha);
    sensed.theta_change = sensed.theta - (moved ? before : sensed.theta);
    return sensed;
}

static bool within(real x, real limit)
{
    return -limit <= x && x <= limit;
}

static enum NAME_fault broken(const struct NAME_settings *settings, const struct sensed *sensed)
{
    if (!sensed->finite) {
        return UPPER_FAULT_NON_FINITE;
    }
    if (!within(sensed->alpha, settings->deflection_limit_rad)) {
        return UPPER_FAULT_DEFLECTION;
    }
    if (!within(sensed->theta, settings->theta_limit_rad)) {
        return UPPER_FAULT_ANGLE;
    }
    if (!within(sensed->theta_change, settings->theta_step_limit_rad)) {
        return UPPER_FAULT_SPEED;
    }
    return UPPER_FAULT_NONE;
}

/* ---- Smooth reference: p(t) = target + (1 - t)^3 (c0 + c1 t + c2 t^2), minimum jerk, exact at its end ---- */

static void restart(struct NAME_path *path, real ticks, real largest_step, real target)
{
    const real d = path->position - target;
    const real step = magnitude(d);
    path->target = target;
    path->gone = 0;
    path->ticks = largest_step > 0 && step > largest_step ? ticks * (step / largest_step) : ticks;
    const real w = path->velocity * path->ticks;
    const real g = path->acceleration * path->ticks * path->ticks;
    path->c0 = d;
    path->c1 = w + 3 * d;
    path->c2 = g / 2 + 3 * w + 6 * d;
}

static void evaluate(struct NAME_path *path)
{
    const real n = path->ticks;
    const real t = path->gone / n;
    const real s = 1 - t;
    const real p = path->c0 + t * (path->c1 + t * path->c2);
    const real p1 = path->c1 + 2 * t * path->c2;
    const real p2 = 2 * path->c2;
    path->position = path->target + s * s * s * p;
    path->velocity = s * s * (s * p1 - 3 * p) / n;
    path->acceleration = s * (s * s * p2 - 6 * s * p1 + 6 * p) / (n * n);
}

static real follow(struct NAME_path *path, real ticks, real largest_step, real reference)
{
    if (reference != path->target) {
        restart(path, ticks, largest_step, reference);
    }
    path->gone += 1;
    if (path->gone < path->ticks) {
        evaluate(path);
    } else {
        const struct NAME_path rest = {path->target, path->target, 0, 0, 0, 0, 0, 0, 0};
        *path = rest;
    }
    return path->position;
}

/* ---- Controller: (u, y_model) = [C D] z, x+ = [A B] z ---- */

static void outputs(const real z[UPPER_ORDER + 3], real *u, real *y_model)
{
    real sum_u = CD[0] * z[0];
    real sum_y = CD[1] * z[0];
    for (int j = 1; j < UPPER_ORDER + 2; ++j) {
        sum_u += CD[2 * j] * z[j];
        sum_y += CD[2 * j + 1] * z[j];
    }
    *u = sum_u;
    *y_model = sum_y;
}

static void advance(struct NAME_state *state, real u_applied)
{
    state->z[UPPER_ORDER + 2] = u_applied;
#if UPPER_ORDER > 0
    const real first = state->z[0];
    for (int i = 0; i < UPPER_ORDER; ++i) {
        state->next[i] = AB[0][i] * first;
    }
    for (int j = 1; j < UPPER_ORDER + 3; ++j) {
        const real factor = state->z[j];
        for (int i = 0; i < UPPER_ORDER; ++i) {
            state->next[i] += AB[j][i] * factor;
        }
    }
    for (int i = 0; i < UPPER_ORDER; ++i) {
        state->z[i] = state->next[i];
    }
#endif
}

/* ---- Variable-structure law ---- */

static void update_switches(const struct NAME_settings *settings, struct NAME_state *state, real u, real e)
{
    const real size_u = magnitude(u);
    const real size_e = magnitude(e);
    const real leave_u = settings->eps_u_v * (1 + settings->hysteresis_u);
    const real leave_e = settings->eps_e_rad * (1 - settings->hysteresis_e);
    state->is_dead = size_u < settings->eps_u_v || (state->is_dead && size_u <= leave_u);
    state->error_is_large = size_e > settings->eps_e_rad || (state->error_is_large && size_e >= leave_e);
}

static real switched(const struct NAME_settings *settings, const struct NAME_state *state, real u, real e)
{
    if (!state->is_dead) {
        return u;
    }
    if (!state->error_is_large) {
        return 0;
    }
    return e > 0 ? settings->u_p_plus_v : e < 0 ? -settings->u_p_minus_v : 0;
}

/* f(u) = u + u_p sat(u/eps_u), u_p of u's direction. */
static real inverse(const struct NAME_settings *settings, real u)
{
    const real eps = settings->eps_u_v;
    if (u > 0) {
        return u < eps ? u + settings->u_p_plus_v * (u / eps) : u + settings->u_p_plus_v;
    }
    if (u < 0) {
        return u > -eps ? u + settings->u_p_minus_v * (u / eps) : u - settings->u_p_minus_v;
    }
    return u;
}

static real compensated(const struct NAME_settings *settings, const struct NAME_state *state, real u, real e)
{
    switch (settings->law) {
    case UPPER_LAW_NONE:
        return u;
    case UPPER_LAW_SWITCHED:
        return switched(settings, state, u, e);
    case UPPER_LAW_INVERSE:
        return inverse(settings, u);
    }
    return 0;
}

static real limited(real voltage, real limit)
{
    if (!(limit >= 0)) {
        return 0;
    }
    return voltage > limit ? limit : voltage < -limit ? -limit : voltage;
}

/* One direction of f^-1, voltage > 0. Without a positive threshold f jumps by u_p at zero; what falls into the jump comes
 * from 0. */
static real undone(real voltage, real eps, real u_p)
{
    if (eps > 0 && voltage < eps + u_p) {
        return voltage * (eps / (eps + u_p));
    }
    return voltage > u_p ? voltage - u_p : 0;
}

static real inverse_of_inverse(const struct NAME_settings *settings, real voltage)
{
    if (voltage > 0) {
        return undone(voltage, settings->eps_u_v, settings->u_p_plus_v);
    }
    if (voltage < 0) {
        return -undone(-voltage, settings->eps_u_v, settings->u_p_minus_v);
    }
    return voltage;
}

static real through_dead_zone(const struct NAME_settings *settings, real voltage)
{
    if (voltage > settings->breakaway_plus_v) {
        return voltage - settings->breakaway_plus_v;
    }
    if (voltage < -settings->breakaway_minus_v) {
        return voltage + settings->breakaway_minus_v;
    }
    return 0;
}

/* What the controller's observer hears of the limited voltage, on its own side of the dead zone. */
static real applied(const struct NAME_settings *settings, real u, real u_c, real voltage)
{
    switch (settings->law) {
    case UPPER_LAW_NONE:
        return voltage;
    case UPPER_LAW_SWITCHED:
        return through_dead_zone(settings, voltage);
    case UPPER_LAW_INVERSE:
        return voltage == u_c ? u : inverse_of_inverse(settings, voltage);
    }
    return voltage;
}

/* ---- One period ---- */

/* A stopped loop asks for nothing: its reference and its model stand where the tip is. */
static struct NAME_commanded stopped(real y, enum NAME_fault fault)
{
    struct NAME_commanded commanded = {0, 0, 0, 0, 0, 0, UPPER_FAULT_NONE};
    const real here = is_finite(y) ? y : 0;
    commanded.reference_rad = here;
    commanded.y_rad = here;
    commanded.y_model_rad = here;
    commanded.fault = fault;
    return commanded;
}

static bool all_finite(const struct NAME_commanded *commanded)
{
    return is_finite(commanded->voltage_v) && is_finite(commanded->u_v) && is_finite(commanded->reference_rad) &&
           is_finite(commanded->y_rad) && is_finite(commanded->y_model_rad) && is_finite(commanded->error_rad);
}

void NAME_reset(struct NAME_state *state)
{
    static const struct NAME_state at_rest = {.fault = UPPER_FAULT_NONE};
    *state = at_rest;
}

struct NAME_commanded NAME_tick(const struct NAME_settings *settings, struct NAME_state *state,
                                struct NAME_measured measured)
{
    const struct sensed sensed = sense(settings, state, measured);
    const real y = sensed.theta + sensed.alpha;
    if (state->fault == UPPER_FAULT_NONE) {
        state->fault = broken(settings, &sensed);
    }
    if (state->fault != UPPER_FAULT_NONE) {
        return stopped(y, state->fault);
    }
    struct NAME_commanded commanded;
    commanded.reference_rad =
        follow(&state->reference, settings->smooth_ticks, settings->smooth_step_rad, measured.reference_rad);
    commanded.y_rad = y;
    state->z[UPPER_ORDER] = commanded.reference_rad;
    state->z[UPPER_ORDER + 1] = y;
    outputs(state->z, &commanded.u_v, &commanded.y_model_rad);
    commanded.error_rad = commanded.y_model_rad - y;
    update_switches(settings, state, commanded.u_v, commanded.error_rad);
    const real u_c = compensated(settings, state, commanded.u_v, commanded.error_rad);
    commanded.voltage_v = limited(u_c, settings->voltage_limit_v);
    advance(state, applied(settings, commanded.u_v, u_c, commanded.voltage_v));
    commanded.fault = UPPER_FAULT_NONE;
    if (all_finite(&commanded)) {
        return commanded;
    }
    state->fault = UPPER_FAULT_NON_FINITE;
    return stopped(y, state->fault);
}

/* ---- Self-check ---- */

enum { CHECKED_TICKS = @CHECKED_TICKS@ };

static const struct NAME_settings checked_settings = {
@CHECKED_SETTINGS@
};

/* reference, theta, alpha [rad]. */
static const real checked_inputs[CHECKED_TICKS][3] = {
@CHECKED_INPUTS@
};

/* voltage, u [V], v, y, y_model, e [rad]. */
static const real checked_answers[CHECKED_TICKS][6] = {
@CHECKED_ANSWERS@
};

/* Not by ==: a processor that flushes subnormal numbers takes them for zero there, too. */
static bool same_bits(const real *found, const real *right, size_t count)
{
    const unsigned char *a = (const unsigned char *)found;
    const unsigned char *b = (const unsigned char *)right;
    for (size_t k = 0; k < count * sizeof(real); ++k) {
        if (a[k] != b[k]) {
            return false;
        }
    }
    return true;
}

int NAME_selfcheck(void)
{
    struct NAME_state state;
    NAME_reset(&state);
    for (int k = 0; k < CHECKED_TICKS; ++k) {
        /* Volatile, so that the compiler computes nothing before the machine that is checked does. */
        const volatile real *inputs = checked_inputs[k];
        const struct NAME_measured measured = {inputs[0], inputs[1], inputs[2]};
        const struct NAME_commanded c = NAME_tick(&checked_settings, &state, measured);
        const real found[6] = {c.voltage_v, c.u_v, c.reference_rad, c.y_rad, c.y_model_rad, c.error_rad};
        if (!same_bits(found, checked_answers[k], 6)) {
            return k + 1;
        }
    }
    return 0;
}

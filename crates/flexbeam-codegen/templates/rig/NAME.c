/* See NAME.h. The order of every sum and product here is that of flexbeam's simulated rig: do not rearrange. */
#include "NAME.h"

#include <float.h>
#include <math.h> /* INFINITY alone */
#include <stddef.h>
#include <string.h>

@ARITHMETIC@

/* A compiler with another format of numbers stops here. */
typedef char NAME_needs_ieee_754[FLT_RADIX == 2 && DBL_MANT_DIG == 53 ? 1 : -1];

/* [theta theta' | eta eta'] */
enum { THETA = 0, SPEED = 1, LINK = 2, HELD = UPPER_ORDER - LINK, COORDINATES = HELD / 2 };

enum { SUBSTEPS = @SUBSTEPS@, HALVINGS = @HALVINGS@ };

/* x(t + piece) = Phi x(t) + Gamma torque, column by column, Gamma last; for a substep, half of it, a quarter, .. */
static const double sliding[HALVINGS + 1][UPPER_ORDER + 1][UPPER_ORDER] = {
@SLIDING@
};

/* The same of [eta eta'] with the hub held. */
static const double held[HALVINGS + 1][HELD + 1][HELD] = {
@HELD@
};

/* Torque of the link on the held hub: its product with [eta eta']. */
static const double reaction[HELD] = {@REACTION@};

/* alpha = tip . eta */
static const double tip[COORDINATES] = {@TIP@};

/* What the gauge sees = gauge . eta */
static const double gauge[COORDINATES] = {@GAUGE@};

/* Torque per volt [N m/V]. */
static const double torque_per_volt = @TORQUE_PER_VOLT@;

const struct NAME_parameters NAME_default_parameters = {
@PARAMETERS@
};

/* ---- Numbers ---- */

static double magnitude(double x)
{
    return x < 0 ? -x : x;
}

static bool is_nan(double x)
{
    return x != x;
}

static uint64_t bits_of(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static double of_bits(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* Half away from zero; zero keeps its sign. */
static double rounded(double x)
{
    if (!(magnitude(x) < 4503599627370496.0)) {
        return x; /* 2^52: a whole number, infinite, or no number */
    }
    const double size = magnitude(x);
    const double whole = (double)(int64_t)size;
    const double near = size - whole >= 0.5 ? whole + 1.0 : whole;
    return bits_of(x) >> 63 != 0 ? -near : near;
}

static double dot(const double *a, const double *b, int count)
{
    double sum = a[0] * b[0];
    for (int k = 1; k < count; ++k) {
        sum += a[k] * b[k];
    }
    return sum;
}

/* 1/n!, n = 13, 12, .. 0. */
static const double exp_terms[@EXP_COUNT@] = {
@EXP_TERMS@
};

/* 2/(2k + 1), k = 11, 10, .. 1. */
static const double ln_terms[@LN_COUNT@] = {
@LN_TERMS@
};

/* ln 2 in two parts. */
static const double ln_2_high = @LN_2_HIGH@;
static const double ln_2_low = @LN_2_LOW@;

static double polynomial(const double *terms, int count, double x)
{
    double sum = 0.0;
    for (int k = 0; k < count; ++k) {
        sum = sum * x + terms[k];
    }
    return sum;
}

static double power_of_two(int k)
{
    return of_bits((uint64_t)(1023 + k) << 52);
}

/* For x <= 0. */
static double exponential(double x)
{
    if (!(x >= @EXP_IS_ZERO@)) {
        return is_nan(x) ? x : 0.0;
    }
    const int k = (int)(x * @LOG2_E@ - 0.5);
    const double r = (x - k * ln_2_high) - k * ln_2_low;
    const int half = k / 2;
    return polynomial(exp_terms, @EXP_COUNT@, r) * power_of_two(half) * power_of_two(k - half);
}

/* For normal x > 0. */
static double logarithm(double x)
{
    const int k = (int)((bits_of(x) + @ABOVE_ROOT_2@) >> 52) - 1023;
    const double f = of_bits(bits_of(x) - ((uint64_t)(int64_t)k << 52)) - 1.0;
    const double s = f / (2.0 + f);
    const double square = s * s;
    const double series = polynomial(ln_terms, @LN_COUNT@, square) * square;
    const double half_square = 0.5 * f * f;
    return k * ln_2_high - ((half_square - (s * (half_square + series) + k * ln_2_low)) - f);
}

/* ---- Noise: ChaCha with 8 rounds (Bernstein), its seed drawn out by PCG (O'Neill) ---- */

static uint32_t turned(uint32_t x, unsigned int by)
{
    return x << by | x >> (32 - by);
}

static void quarter_round(uint32_t x[16], int a, int b, int c, int d)
{
    x[a] += x[b], x[d] = turned(x[d] ^ x[a], 16);
    x[c] += x[d], x[b] = turned(x[b] ^ x[c], 12);
    x[a] += x[b], x[d] = turned(x[d] ^ x[a], 8);
    x[c] += x[d], x[b] = turned(x[b] ^ x[c], 7);
}

static uint32_t drawn_out(uint64_t *state)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(11634580027462260723);
    const unsigned int by = (unsigned int)(*state >> 59);
    const uint32_t mixed = (uint32_t)((*state >> 18 ^ *state) >> 27);
    return mixed >> by | mixed << ((32 - by) & 31);
}

static void generate(struct NAME_noise *noise, uint64_t counter)
{
    uint64_t seed = noise->seed;
    uint32_t start[16] = {0x61707865, 0x3320646e, 0x79622d32, 0x6b206574}; /* "expand 32-byte k" */
    for (int k = 4; k < 12; ++k) {
        start[k] = drawn_out(&seed);
    }
    start[12] = (uint32_t)counter;
    start[13] = (uint32_t)(counter >> 32);
    uint32_t *x = noise->block;
    memcpy(x, start, sizeof start);
    for (int round = 0; round < 8; round += 2) {
        for (int k = 0; k < 4; ++k) {
            quarter_round(x, k, 4 + k, 8 + k, 12 + k);
        }
        for (int k = 0; k < 4; ++k) {
            quarter_round(x, k, 4 + (k + 1) % 4, 8 + (k + 2) % 4, 12 + (k + 3) % 4);
        }
    }
    for (int k = 0; k < 16; ++k) {
        x[k] += start[k];
    }
}

void NAME_noise_recall(struct NAME_noise *noise, uint64_t seed, uint64_t drawn)
{
    noise->seed = seed;
    noise->drawn = drawn;
    generate(noise, drawn / 8);
}

static uint64_t next_bits(struct NAME_noise *noise)
{
    const unsigned int at = 2 * (unsigned int)(noise->drawn % 8);
    const uint64_t bits = noise->block[at] | (uint64_t)noise->block[at + 1] << 32;
    noise->drawn += 1;
    if (noise->drawn % 8 == 0) {
        generate(noise, noise->drawn / 8);
    }
    return bits;
}

/* ---- Noise: normal numbers by the ziggurat (Doornik 2005) ---- */

static const double edges[257] = {
@ZIGGURAT_X@
};

static const double heights[257] = {
@ZIGGURAT_F@
};

/* The upper 52 bits behind the point of a number with this exponent. */
static double between(uint64_t bits, uint64_t biased_exponent)
{
    return of_bits(biased_exponent << 52 | bits >> 12);
}

/* In [0, 1). */
static double part(struct NAME_noise *noise)
{
    return (double)(next_bits(noise) >> 11) * (0.5 * DBL_EPSILON);
}

/* In (0, 1). */
static double open_part(struct NAME_noise *noise)
{
    return between(next_bits(noise), 0x3ff) - (1.0 - DBL_EPSILON / 2.0);
}

static double tail(struct NAME_noise *noise, double u)
{
    double x, y;
    do {
        x = logarithm(open_part(noise)) / edges[1];
        y = logarithm(open_part(noise));
    } while (-2.0 * y < x * x);
    return u < 0 ? x - edges[1] : edges[1] - x;
}

static double normal(struct NAME_noise *noise)
{
    for (;;) {
        const uint64_t bits = next_bits(noise);
        const unsigned int i = (unsigned int)(bits & 255);
        const double u = between(bits, 0x400) - 3.0;
        const double x = u * edges[i];
        if (magnitude(x) < edges[i + 1]) {
            return x;
        }
        if (i == 0) {
            return tail(noise, u);
        }
        if (heights[i + 1] + (heights[i] - heights[i + 1]) * part(noise) < exponential(-x * x / 2.0)) {
            return x;
        }
    }
}

/* ---- Sensors, actuator ---- */

struct NAME_measurement NAME_measure(const struct NAME_parameters *parameters, struct NAME_state *state)
{
    const struct NAME_gauge *own = &parameters->gauge;
    struct NAME_measurement read = {state->x[THETA], dot(gauge, &state->x[LINK], COORDINATES) + own->bias_rad};
    if (parameters->encoder.counts_per_turn > 0) {
        const double per_rad = (double)parameters->encoder.counts_per_turn / @TAU@;
        read.theta_rad = rounded(read.theta_rad * per_rad) / per_rad;
    }
    if (own->noise_rad > 0) {
        read.alpha_rad += own->noise_rad * normal(&state->noise);
    }
    if (own->converter_step_rad > 0) {
        read.alpha_rad = rounded(read.alpha_rad / own->converter_step_rad) * own->converter_step_rad;
    }
    return read;
}

static double motor_v(const struct NAME_actuator *actuator, double commanded_v)
{
    if (is_nan(commanded_v)) {
        return 0.0;
    }
    double v = commanded_v;
    if (actuator->converter_step_v > 0) {
        v = rounded(v / actuator->converter_step_v) * actuator->converter_step_v;
    }
    v = v < -actuator->limit_v ? -actuator->limit_v : v;
    v = v > actuator->limit_v ? actuator->limit_v : v;
    if (v > actuator->dead_zone_plus_v) {
        return v - actuator->dead_zone_plus_v;
    }
    return v < -actuator->dead_zone_minus_v ? v + actuator->dead_zone_minus_v : 0.0;
}

/* ---- Friction: set-valued, so that at rest it takes any value up to the breakaway torque ---- */

static double sliding_nm(const struct NAME_friction *friction, double speed_rad_s)
{
    if (!(friction->stribeck_extra_nm > 0)) {
        return friction->coulomb_nm;
    }
    const double ratio = speed_rad_s / friction->stribeck_speed_rad_s;
    return friction->coulomb_nm + friction->stribeck_extra_nm * exponential(-(ratio * ratio));
}

static double breakaway_nm(const struct NAME_friction *friction)
{
    return friction->coulomb_nm + friction->stribeck_extra_nm;
}

static double torque_on_held_hub(const double *x, double torque_nm)
{
    return torque_nm + dot(reaction, &x[LINK], HELD);
}

/* What a hub at rest does under this torque: the one answer for which the friction lies in its set. */
static void contact_at_rest(const struct NAME_friction *friction, struct NAME_state *state, double torque_nm)
{
    const double largest = breakaway_nm(friction);
    state->direction = 0.0;
    if (largest == 0.0) {
        state->contact = UPPER_CONTACT_FREE;
    } else if (magnitude(torque_nm) <= largest) {
        state->contact = UPPER_CONTACT_STUCK;
    } else {
        state->contact = UPPER_CONTACT_SLIDING;
        state->direction = torque_nm > 0 ? 1.0 : is_nan(torque_nm) ? torque_nm : -1.0;
    }
}

/* ---- One period ---- */

/* A piece is 2^-halvings of a substep. */
static void propagate(const double *columns, int order, const double *x, double torque_nm, double *next)
{
    const double *Gamma = columns + order * order;
    for (int i = 0; i < order; ++i) {
        next[i] = Gamma[i] * torque_nm;
    }
    for (int j = 0; j < order; ++j) {
        for (int i = 0; i < order; ++i) {
            next[i] += columns[j * order + i] * x[j];
        }
    }
}

/* The speed behind a piece. */
static double speed_behind(const double piece[UPPER_ORDER + 1][UPPER_ORDER], const double *x, double torque_nm)
{
    double sum = piece[0][SPEED] * x[0];
    for (int j = 1; j < UPPER_ORDER; ++j) {
        sum += piece[j][SPEED] * x[j];
    }
    return piece[UPPER_ORDER][SPEED] * torque_nm + sum;
}

/* Friction torque at the speed that is expected halfway through a piece. */
static double friction_nm(const struct NAME_friction *friction, const struct NAME_state *state, int halvings,
                          double torque_nm)
{
    const double now = sliding_nm(friction, state->x[SPEED]);
    if (!(friction->stribeck_extra_nm > 0) || halvings == HALVINGS) {
        return now;
    }
    return sliding_nm(friction, speed_behind(sliding[halvings + 1], state->x, torque_nm - state->direction * now));
}

static void try_piece(const struct NAME_friction *friction, struct NAME_state *state, int halvings, double torque_nm)
{
    if (state->contact == UPPER_CONTACT_STUCK) {
        state->next[THETA] = state->x[THETA];
        state->next[SPEED] = state->x[SPEED];
        propagate(held[halvings][0], HELD, &state->x[LINK], 0.0, &state->next[LINK]);
        return;
    }
    double net_nm = torque_nm;
    if (state->contact == UPPER_CONTACT_SLIDING) {
        net_nm = torque_nm - state->direction * friction_nm(friction, state, halvings, torque_nm);
    }
    propagate(sliding[halvings][0], UPPER_ORDER, state->x, net_nm, state->next);
}

static bool contact_has_ended(const struct NAME_friction *friction, const struct NAME_state *state, double torque_nm)
{
    switch (state->contact) {
    case UPPER_CONTACT_STUCK:
        return magnitude(torque_on_held_hub(state->next, torque_nm)) > breakaway_nm(friction);
    case UPPER_CONTACT_SLIDING:
        return state->direction * state->next[SPEED] < 0;
    case UPPER_CONTACT_FREE:
    default:
        return false;
    }
}

/* In the largest pieces that end in the contact in which they began; a piece that does not is halved. */
static void advance_substep(const struct NAME_friction *friction, struct NAME_state *state, double torque_nm)
{
    uint32_t left = UINT32_C(1) << HALVINGS;
    int halvings = 0; /* the piece's size is 2^(HALVINGS - halvings) */
    bool searching = false;
    while (left > 0) {
        while (UINT32_C(1) << (HALVINGS - halvings) > left) {
            ++halvings;
        }
        const bool smallest = halvings == HALVINGS;
        try_piece(friction, state, halvings, torque_nm);
        const bool ended = contact_has_ended(friction, state, torque_nm);
        if (ended && !smallest) {
            searching = true;
            ++halvings;
            continue;
        }
        memcpy(state->x, state->next, sizeof state->x);
        left -= UINT32_C(1) << (HALVINGS - halvings);
        if (ended) {
            state->x[SPEED] = 0.0;
            contact_at_rest(friction, state, torque_on_held_hub(state->x, torque_nm));
        }
        /* The event lies in the second half of what was too long, unless the smallest piece has just been taken. */
        searching = searching && !smallest;
        halvings = searching ? halvings + 1 : 0;
    }
}

void NAME_apply(const struct NAME_parameters *parameters, struct NAME_state *state, double commanded_v)
{
    const double torque_nm = torque_per_volt * motor_v(&parameters->actuator, commanded_v);
    if (state->x[SPEED] == 0.0) {
        contact_at_rest(&parameters->friction, state, torque_on_held_hub(state->x, torque_nm));
    }
    for (int k = 0; k < SUBSTEPS; ++k) {
        advance_substep(&parameters->friction, state, torque_nm);
    }
}

void NAME_reset(const struct NAME_parameters *parameters, struct NAME_state *state, uint64_t seed)
{
    static const struct NAME_state at_rest = {.contact = UPPER_CONTACT_FREE};
    *state = at_rest;
    contact_at_rest(&parameters->friction, state, 0.0);
    NAME_noise_recall(&state->noise, seed, 0);
}

struct NAME_truth NAME_truth(const struct NAME_state *state)
{
    struct NAME_truth truth;
    truth.theta_rad = state->x[THETA];
    truth.alpha_rad = dot(tip, &state->x[LINK], COORDINATES);
    truth.psi_rad = truth.theta_rad + truth.alpha_rad;
    truth.theta_rad_s = state->x[SPEED];
    truth.alpha_rad_s = dot(tip, &state->x[LINK + COORDINATES], COORDINATES);
    truth.contact = state->contact;
    return truth;
}

/* ---- Self-check ---- */

enum { CHECKED_PERIODS = @CHECKED_PERIODS@, LINEAR_PERIODS = @LINEAR_PERIODS@ };

/* First with nothing that is not linear, at subnormal voltages, then with all of it. */
static const struct NAME_parameters checked_linear = {
@CHECKED_LINEAR@
};
static const struct NAME_parameters checked_full = {
@CHECKED_FULL@
};

static const double checked_voltages[CHECKED_PERIODS] = {
@CHECKED_VOLTAGES@
};

/* theta, alpha as read, true alpha, theta' behind each period. */
static const double checked_answers[CHECKED_PERIODS][4] = {
@CHECKED_ANSWERS@
};

int NAME_selfcheck(void)
{
    struct NAME_state state;
    for (int k = 0; k < CHECKED_PERIODS; ++k) {
        const struct NAME_parameters *parameters = k < LINEAR_PERIODS ? &checked_linear : &checked_full;
        if (k == 0 || k == LINEAR_PERIODS) {
            NAME_reset(parameters, &state, 1);
        }
        /* Volatile, so that the compiler computes nothing before the machine that is checked does. */
        const volatile double *voltages = checked_voltages;
        NAME_apply(parameters, &state, voltages[k]);
        const struct NAME_measurement read = NAME_measure(parameters, &state);
        const struct NAME_truth truth = NAME_truth(&state);
        const double found[4] = {read.theta_rad, read.alpha_rad, truth.alpha_rad, truth.theta_rad_s};
        /* Not by ==: a processor that flushes subnormal numbers takes them for zero there, too. */
        if (memcmp(found, checked_answers[k], sizeof found) != 0) {
            return k + 1;
        }
    }
    return 0;
}

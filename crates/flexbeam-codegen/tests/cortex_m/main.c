/* The controller in closed loop with the nominal beam: one line with a check sum over every bit that it answers. On a board also
 * instructions a tick and bytes of stack. */
#include "NAME.h"

#include <stdint.h>
#include <string.h>

#ifdef ON_BOARD
#include "board.h"
#else
#include <stdio.h>
#endif

enum { TICKS = 1500, STEPS = 8 };

/* The plant of the paper, (18), by Euler's rule: the same to the last bit wherever doubles are. */
struct beam {
    double theta, alpha, theta_rate, alpha_rate;
};

static void advance(struct beam *beam, double voltage_v)
{
    const double h = 0.001 / STEPS;
    for (int k = 0; k < STEPS; ++k) {
        const double theta_acceleration = 1060.8 * beam->alpha - 57.7 * beam->theta_rate + 107.39 * voltage_v;
        const double alpha_acceleration = -1465.2 * beam->alpha + 57.7 * beam->theta_rate - 107.39 * voltage_v;
        beam->theta += h * beam->theta_rate;
        beam->alpha += h * beam->alpha_rate;
        beam->theta_rate += h * theta_acceleration;
        beam->alpha_rate += h * alpha_acceleration;
    }
}

/* FNV-1a, 64 bits. */
static uint64_t sum = 0xCBF29CE484222325u;

static void add(double number)
{
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    for (int k = 0; k < 8; ++k) {
        sum = (sum ^ (bits >> (8 * k) & 0xFFu)) * 0x100000001B3u;
    }
}

static void add_all(const struct NAME_commanded *c)
{
    const NAME_real numbers[6] = {c->voltage_v, c->u_v, c->reference_rad, c->y_rad, c->y_model_rad, c->error_rad};
    for (int k = 0; k < 6; ++k) {
        add((double)numbers[k]);
    }
    add((double)c->fault);
}

#ifdef ON_BOARD
static uint32_t instructions; /* in counts of 40 */
static uint32_t stack_bytes;

static struct NAME_commanded ticked(const struct NAME_settings *settings, struct NAME_state *state,
                                    struct NAME_measured measured)
{
    board_paint();
    const uint32_t before = board_count();
    const struct NAME_commanded commanded = NAME_tick(settings, state, measured);
    instructions += (board_count() - before) & 0xFFFFFFu;
    const uint32_t used = board_stack_used();
    stack_bytes = used > stack_bytes ? used : stack_bytes;
    return commanded;
}

static void say_number(const char *name, uint64_t number, uint64_t base)
{
    char text[24] = "";
    int at = 23;
    do {
        text[--at] = "0123456789abcdef"[number % base];
        number /= base;
    } while (number > 0);
    board_say(name);
    board_say(&text[at]);
    board_say("\n");
}
#else
static struct NAME_commanded ticked(const struct NAME_settings *settings, struct NAME_state *state,
                                    struct NAME_measured measured)
{
    return NAME_tick(settings, state, measured);
}
#endif

int main(void)
{
    static struct NAME_state state;
    struct NAME_settings settings = NAME_default_settings;
    struct beam beam = {0.0, 0.0, 0.0, 0.0};
    const int wrong = NAME_selfcheck();
    NAME_reset(&state);
    settings.voltage_limit_v = 5;
    for (int k = 0; k < TICKS; ++k) {
        const double reference = k < 500 ? 0.5 : -0.25;
        const struct NAME_measured measured = {(NAME_real)reference, (NAME_real)beam.theta, (NAME_real)beam.alpha};
        settings.law = k < 1000 ? UPPER_LAW_INVERSE : UPPER_LAW_SWITCHED;
        const struct NAME_commanded commanded = ticked(&settings, &state, measured);
        add_all(&commanded);
        advance(&beam, (double)commanded.voltage_v);
    }
    add(beam.theta);
    add(beam.alpha);
#ifdef ON_BOARD
    say_number("sum ", sum, 16);
    say_number("instructions ", (uint64_t)instructions * 40u / TICKS, 10);
    say_number("stack ", stack_bytes, 10);
#else
    printf("sum %llx\n", (unsigned long long)sum);
#endif
    return wrong;
}

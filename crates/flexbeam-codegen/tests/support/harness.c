/* Runs a generated controller through the ticks of a file and compares every answer to the bit.
 *
 *   harness FILE      FILE: how many settings, the settings (21 numbers each), then rows
 *
 * All doubles: a row is which settings, whether a reset comes before, reference, theta, alpha, the six answers, the fault. */
#include "NAME.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_SETTINGS = 256, SETTING = 21, ROW = 12, ROWS = 4096 };

static double rows[ROWS][ROW];
static struct NAME_settings settings[MOST_SETTINGS];
static struct NAME_state state;

static struct NAME_settings from(const double x[SETTING])
{
    struct NAME_settings s = NAME_default_settings;
    const struct NAME_channel theta = {(NAME_real)x[0], (NAME_real)x[1], (NAME_real)x[2]};
    const struct NAME_channel alpha = {(NAME_real)x[3], (NAME_real)x[4], (NAME_real)x[5]};
    s.theta = theta;
    s.alpha = alpha;
    s.smooth_ticks = (NAME_real)x[6];
    s.smooth_step_rad = (NAME_real)x[7];
    s.law = x[8] == 0 ? UPPER_LAW_NONE : x[8] == 1 ? UPPER_LAW_SWITCHED : UPPER_LAW_INVERSE;
    s.u_p_plus_v = (NAME_real)x[9];
    s.u_p_minus_v = (NAME_real)x[10];
    s.eps_u_v = (NAME_real)x[11];
    s.eps_e_rad = (NAME_real)x[12];
    s.hysteresis_u = (NAME_real)x[13];
    s.hysteresis_e = (NAME_real)x[14];
    s.breakaway_plus_v = (NAME_real)x[15];
    s.breakaway_minus_v = (NAME_real)x[16];
    s.voltage_limit_v = (NAME_real)x[17];
    s.deflection_limit_rad = (NAME_real)x[18];
    s.theta_limit_rad = (NAME_real)x[19];
    s.theta_step_limit_rad = (NAME_real)x[20];
    return s;
}

static void check(unsigned long k, const double row[ROW])
{
    if (row[1] != 0) {
        NAME_reset(&state);
    }
    const struct NAME_measured measured = {(NAME_real)row[2], (NAME_real)row[3], (NAME_real)row[4]};
    const struct NAME_commanded c = NAME_tick(&settings[(int)row[0]], &state, measured);
    const double found[7] = {(double)c.voltage_v,   (double)c.u_v,       (double)c.reference_rad, (double)c.y_rad,
                             (double)c.y_model_rad, (double)c.error_rad, (double)c.fault};
    if (memcmp(found, &row[5], sizeof found) != 0) {
        printf("tick %lu differs\n", k);
        for (int j = 0; j < 7; ++j) {
            printf("  %a, needed %a\n", found[j], row[5 + j]);
        }
        exit(1);
    }
}

int main(int count, char **arguments)
{
    FILE *file = count == 2 ? fopen(arguments[1], "rb") : NULL;
    double many = 0.0;
    double numbers[SETTING];
    unsigned long k = 0;
    if (file == NULL || fread(&many, sizeof many, 1, file) != 1 || many > MOST_SETTINGS) {
        return 2;
    }
    for (int j = 0; j < (int)many; ++j) {
        if (fread(numbers, sizeof numbers, 1, file) != 1) {
            return 2;
        }
        settings[j] = from(numbers);
    }
    if (NAME_selfcheck() != 0) {
        printf("selfcheck: tick %d is wrong\n", NAME_selfcheck());
        return 3;
    }
    NAME_reset(&state);
    for (size_t read; (read = fread(rows, sizeof rows[0], ROWS, file)) > 0;) {
        for (size_t j = 0; j < read; ++j) {
            check(k++, rows[j]);
        }
    }
    fclose(file);
    printf("%lu ticks\n", k);
    return 0;
}

/* Runs a generated rig through the periods of a file and compares every answer to the bit.
 *
 *   rig_harness FILE SEED      FILE: rows of doubles: voltage; theta, alpha as read before it; true theta, alpha and their speeds,
 *                              and the contact behind it */
#include "NAME.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROW = 8, ROWS = 4096 };

static double rows[ROWS][ROW];
static struct NAME_state state;

static void check(unsigned long k, const double row[ROW])
{
    const struct NAME_parameters *parameters = &NAME_default_parameters;
    const struct NAME_measurement read = NAME_measure(parameters, &state);
    NAME_apply(parameters, &state, row[0]);
    const struct NAME_truth truth = NAME_truth(&state);
    const double found[7] = {read.theta_rad,    read.alpha_rad,    truth.theta_rad,       truth.alpha_rad,
                             truth.theta_rad_s, truth.alpha_rad_s, (double)truth.contact};
    if (memcmp(found, &row[1], sizeof found) != 0) {
        printf("period %lu differs\n", k);
        for (int j = 0; j < 7; ++j) {
            printf("  %a, needed %a\n", found[j], row[1 + j]);
        }
        exit(1);
    }
}

int main(int count, char **arguments)
{
    FILE *file = count == 3 ? fopen(arguments[1], "rb") : NULL;
    unsigned long k = 0;
    if (file == NULL) {
        return 2;
    }
    if (NAME_selfcheck() != 0) {
        printf("selfcheck: period %d is wrong\n", NAME_selfcheck());
        return 3;
    }
    NAME_reset(&NAME_default_parameters, &state, strtoull(arguments[2], NULL, 10));
    for (size_t read; (read = fread(rows, sizeof rows[0], ROWS, file)) > 0;) {
        for (size_t j = 0; j < read; ++j) {
            check(k++, rows[j]);
        }
    }
    fclose(file);
    printf("%lu periods\n", k);
    return 0;
}

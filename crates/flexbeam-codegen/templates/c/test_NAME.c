/* Holds NAME_tick() against the vectors of flexbeam's own, bit for bit. Exit status 0: all are right. */
#include "NAME.h"
#include "test_vectors.h"

#include <stdio.h>
#include <string.h>

static const char *const names[6] = {"voltage_v", "u_v", "reference_rad", "y_rad", "y_model_rad", "error_rad"};

/* Whether one tick is right; says what is not. */
static bool is_right(int k, const struct NAME_vector *vector, const struct NAME_commanded *found)
{
    const NAME_real answers[6] = {found->voltage_v, found->u_v,         found->reference_rad,
                                  found->y_rad,     found->y_model_rad, found->error_rad};
    if ((int)found->fault != (int)vector->fault) {
        printf("tick %d: fault: found %d, needed %d\n", k, (int)found->fault, (int)vector->fault);
        return false;
    }
    for (int j = 0; j < 6; ++j) {
        if (memcmp(&answers[j], &vector->answers[j], sizeof answers[j]) != 0) {
            printf("tick %d: %s: found %a, needed %a\n", k, names[j], (double)answers[j], (double)vector->answers[j]);
            return false;
        }
    }
    return true;
}

int main(void)
{
    static struct NAME_state state;
    const int wrong = NAME_selfcheck();
    if (wrong != 0) {
        printf("NAME_selfcheck: tick %d is wrong: this build contracts products and sums, or flushes subnormal numbers\n"
               "hint: build with -ffp-contract=off and without -ffast-math\n",
               wrong);
        return 1;
    }
    NAME_reset(&state);
    for (int k = 0; k < UPPER_VECTORS; ++k) {
        const struct NAME_vector *vector = &NAME_vectors[k];
        const struct NAME_measured measured = {vector->inputs[0], vector->inputs[1], vector->inputs[2]};
        if (vector->reset) {
            NAME_reset(&state);
        }
        const struct NAME_commanded found = NAME_tick(&NAME_vector_settings[vector->settings], &state, measured);
        if (!is_right(k, vector, &found)) {
            return 1;
        }
    }
    printf("NAME: %d ticks, every bit as flexbeam computes it\n", UPPER_VECTORS);
    return 0;
}

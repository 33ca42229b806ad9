/* 2000 steps of a unit in a host. */
#include "host.h"

int main(int count, char **words)
{
    void *unit = count < 2 ? NULL : started(words[1]);
    double answer = 0;
    for (int k = 0; k < 2000; ++k) {
        const double reference = k / 500 % 2 == 0 ? 0.5 : -0.5;
        const double values[3] = {reference, 0.3 * reference, 0.01};
        if (unit == NULL || counted_tick(unit, 0.001 * k, values, &answer) != 0) {
            return 1;
        }
    }
    (void)inputs, (void)voltage;
    return answer == 0;
}

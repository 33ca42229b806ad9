/* A host of FMI 2.0 that sets the inputs, steps and reads the voltage, 2000 times. */
#include <stdlib.h>

typedef struct {
    void (*log)(void *, const char *, int, const char *, const char *, ...);
    void *others[4];
} fmi2CallbackFunctions;

void *fmi2Instantiate(const char *, int, const char *, const char *, const fmi2CallbackFunctions *, int, int);
int fmi2SetupExperiment(void *, int, double, double, int, double);
int fmi2EnterInitializationMode(void *);
int fmi2ExitInitializationMode(void *);
int fmi2SetReal(void *, const unsigned int *, size_t, const double *);
int fmi2GetReal(void *, const unsigned int *, size_t, double *);
int fmi2DoStep(void *, double, double, int);

static const unsigned int inputs[3] = {1, 2, 3};
static const unsigned int voltage[1] = {4};

__attribute__((noinline)) int counted_tick(void *unit, double time, const double values[3], double *answer);

int counted_tick(void *unit, double time, const double values[3], double *answer)
{
    return fmi2SetReal(unit, inputs, 3, values) | fmi2DoStep(unit, time, 0.001, 1) | fmi2GetReal(unit, voltage, 1, answer);
}

int main(int count, char **words)
{
    static const fmi2CallbackFunctions callbacks;
    void *unit = count < 2 ? NULL : fmi2Instantiate("one", 1, words[1], "", &callbacks, 0, 0);
    if (unit == NULL || fmi2SetupExperiment(unit, 0, 0, 0, 0, 0) != 0 || fmi2EnterInitializationMode(unit) != 0 ||
        fmi2ExitInitializationMode(unit) != 0) {
        return 1;
    }
    double answer = 0;
    for (int k = 0; k < 2000; ++k) {
        const double reference = k / 500 % 2 == 0 ? 0.5 : -0.5;
        const double values[3] = {reference, 0.3 * reference, 0.01};
        if (counted_tick(unit, 0.001 * k, values, &answer) != 0) {
            return 1;
        }
    }
    return answer == 0;
}

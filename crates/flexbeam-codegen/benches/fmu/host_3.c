/* A host of FMI 3.0 that sets the inputs, steps and reads the voltage, 2000 times. */
#include <stdbool.h>
#include <stdlib.h>

void *fmi3InstantiateCoSimulation(const char *, const char *, const char *, bool, bool, bool, bool, const unsigned int *, size_t,
                                  void *, void (*)(void *, int, const char *, const char *), void (*)(void));
int fmi3EnterInitializationMode(void *, bool, double, double, bool, double);
int fmi3ExitInitializationMode(void *);
int fmi3SetFloat64(void *, const unsigned int *, size_t, const double *, size_t);
int fmi3GetFloat64(void *, const unsigned int *, size_t, double *, size_t);
int fmi3DoStep(void *, double, double, bool, bool *, bool *, bool *, double *);

static const unsigned int inputs[3] = {1, 2, 3};
static const unsigned int voltage[1] = {4};

__attribute__((noinline)) int counted_tick(void *unit, double time, const double values[3], double *answer);

int counted_tick(void *unit, double time, const double values[3], double *answer)
{
    bool event, terminate, early;
    double last;
    return fmi3SetFloat64(unit, inputs, 3, values, 3) | fmi3DoStep(unit, time, 0.001, true, &event, &terminate, &early, &last) |
           fmi3GetFloat64(unit, voltage, 1, answer, 1);
}

int main(int count, char **words)
{
    void *unit = count < 2 ? NULL : fmi3InstantiateCoSimulation("one", words[1], "", false, false, false, false, NULL, 0, NULL, NULL, NULL);
    if (unit == NULL || fmi3EnterInitializationMode(unit, false, 0, 0, false, 0) != 0 || fmi3ExitInitializationMode(unit) != 0) {
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

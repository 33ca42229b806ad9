/* A host of FMI 3.0. */
#include "host.h"

#include <stdbool.h>
#include <stdlib.h>

void *fmi3InstantiateCoSimulation(const char *, const char *, const char *, bool, bool, bool, bool, const unsigned int *, size_t,
                                  void *, void (*)(void *, int, const char *, const char *), void (*)(void));
int fmi3EnterInitializationMode(void *, bool, double, double, bool, double);
int fmi3ExitInitializationMode(void *);
int fmi3SetFloat64(void *, const unsigned int *, size_t, const double *, size_t);
int fmi3GetFloat64(void *, const unsigned int *, size_t, double *, size_t);
int fmi3DoStep(void *, double, double, bool, bool *, bool *, bool *, double *);

int counted_tick(void *unit, double time, const double values[3], double *answer)
{
    bool event, terminate, early;
    double last;
    return fmi3SetFloat64(unit, inputs, 3, values, 3) | fmi3DoStep(unit, time, 0.001, true, &event, &terminate, &early, &last) |
           fmi3GetFloat64(unit, voltage, 1, answer, 1);
}

void *started(const char *token)
{
    void *unit = fmi3InstantiateCoSimulation("one", token, "", false, false, false, false, NULL, 0, NULL, NULL, NULL);
    const bool refused = unit == NULL || fmi3EnterInitializationMode(unit, false, 0, 0, false, 0) != 0 ||
                         fmi3ExitInitializationMode(unit) != 0;
    return refused ? NULL : unit;
}

/* The unit behind the functional mock-up interface 3.0, for co-simulation. The types are those that the standard publishes;
 * what a function must do stands there, too. */
#include "fmu.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A library of its own exports the names as they are. Whoever links several units into one program defines a prefix. */
#if defined FMI3_FUNCTION_PREFIX && !defined FMI3_OVERRIDE_FUNCTION_PREFIX
#define JOINED(prefix, name) prefix##name
#define PREFIXED(prefix, name) JOINED(prefix, name)
#define API(name) PREFIXED(FMI3_FUNCTION_PREFIX, name)
#else
#define API(name) name
#endif

#if defined _WIN32
#define PUBLIC __declspec(dllexport)
#elif defined __GNUC__
#define PUBLIC __attribute__((visibility("default")))
#else
#define PUBLIC
#endif

typedef void *fmi3Instance;
typedef void *fmi3InstanceEnvironment;
typedef void *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef double fmi3Float64;
typedef bool fmi3Boolean;
typedef const char *fmi3String;
typedef uint8_t fmi3Byte;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);
/* Of hosts that may interrupt a step or call from outside of one; never called here. */
typedef void (*fmi3OtherCallback)(void);

struct instance {
    struct NAME_memory memory;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment host;
};

enum { LONGEST_DETAIL = 160, LONGEST_MESSAGE = 256 };

/* Tells the host what was tried, found and needed. */
static fmi3Status tell(fmi3LogMessageCallback log, fmi3InstanceEnvironment host, const char *message)
{
    if (log != NULL) {
        log(host, fmi3Error, "logStatusError", message);
    }
    return fmi3Error;
}

static fmi3Status refused(const struct instance *instance, const char *function, const char *message)
{
    char text[LONGEST_MESSAGE];
    snprintf(text, sizeof text, "%s: %s", function, message);
    return tell(instance->log, instance->host, text);
}

static fmi3Status refused_variable(const struct instance *instance, const char *function, unsigned int variable,
                                   const char *needed)
{
    char text[LONGEST_DETAIL];
    snprintf(text, sizeof text, "found value reference %u, needed %s", variable, needed);
    return refused(instance, function, text);
}

static fmi3Status refused_count(const struct instance *instance, const char *function)
{
    return refused(instance, function, "found another number of values than of variables, needed one for each");
}

static fmi3Status in_phase(struct instance *instance, enum NAME_phase phase, const char *function, const char *needed)
{
    return instance->memory.phase == phase ? fmi3OK : refused(instance, function, needed);
}

/* ---- Versions, instances ---- */

PUBLIC const char *API(fmi3GetVersion)(void)
{
    return "3.0";
}

/* Errors are told whatever the host asks for; there is nothing else to tell. */
PUBLIC fmi3Status API(fmi3SetDebugLogging)(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String categories[])
{
    (void)c, (void)on, (void)count, (void)categories;
    return fmi3OK;
}

static const char *unfit(fmi3String token)
{
    if (token == NULL || strcmp(token, "@GUID@") != 0) {
        return "fmi3InstantiateCoSimulation: found another token, needed that of modelDescription.xml: @GUID@";
    }
    if (NAME_selfcheck() != 0) {
        return "fmi3InstantiateCoSimulation: found arithmetic that is not flexbeam's: this build contracts products and sums, or "
               "the host flushes subnormal numbers; needed -ffp-contract=off and IEEE 754 arithmetic";
    }
    return NULL;
}

PUBLIC fmi3Instance API(fmi3InstantiateCoSimulation)(fmi3String name, fmi3String token, fmi3String resources,
                                                     fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean event_mode,
                                                     fmi3Boolean early_return, const fmi3ValueReference intermediate[],
                                                     size_t intermediate_count, fmi3InstanceEnvironment host,
                                                     fmi3LogMessageCallback log, fmi3OtherCallback intermediate_update)
{
    const char *why = unfit(token);
    (void)name, (void)resources, (void)visible, (void)logging, (void)event_mode, (void)early_return;
    (void)intermediate, (void)intermediate_count, (void)intermediate_update;
    if (why != NULL) {
        tell(log, host, why);
        return NULL;
    }
    struct instance *instance = malloc(sizeof *instance);
    if (instance == NULL) {
        tell(log, host, "fmi3InstantiateCoSimulation: found no memory");
        return NULL;
    }
    instance->log = log;
    instance->host = host;
    NAME_memory_reset(&instance->memory);
    return instance;
}

PUBLIC fmi3Instance API(fmi3InstantiateModelExchange)(fmi3String name, fmi3String token, fmi3String resources,
                                                      fmi3Boolean visible, fmi3Boolean logging, fmi3InstanceEnvironment host,
                                                      fmi3LogMessageCallback log)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    tell(log, host, "fmi3InstantiateModelExchange: found model exchange, needed co-simulation");
    return NULL;
}

PUBLIC fmi3Instance API(fmi3InstantiateScheduledExecution)(fmi3String name, fmi3String token, fmi3String resources,
                                                           fmi3Boolean visible, fmi3Boolean logging,
                                                           fmi3InstanceEnvironment host, fmi3LogMessageCallback log,
                                                           fmi3OtherCallback clock_update, fmi3OtherCallback lock,
                                                           fmi3OtherCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)clock_update, (void)lock, (void)unlock;
    tell(log, host, "fmi3InstantiateScheduledExecution: found scheduled execution, needed co-simulation");
    return NULL;
}

PUBLIC void API(fmi3FreeInstance)(fmi3Instance c)
{
    free(c);
}

PUBLIC fmi3Status API(fmi3EnterInitializationMode)(fmi3Instance c, fmi3Boolean tolerance_defined, fmi3Float64 tolerance,
                                                   fmi3Float64 start_s, fmi3Boolean stop_defined, fmi3Float64 stop_s)
{
    struct instance *instance = c;
    const fmi3Status status = in_phase(instance, UPPER_INSTANTIATED, "fmi3EnterInitializationMode",
                                       "needed once, behind the instantiation or fmi3Reset");
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop_s;
    if (status == fmi3OK) {
        instance->memory.phase = UPPER_INITIALIZING;
        instance->memory.time_s = start_s;
    }
    return status;
}

PUBLIC fmi3Status API(fmi3ExitInitializationMode)(fmi3Instance c)
{
    struct instance *instance = c;
    const fmi3Status status = in_phase(instance, UPPER_INITIALIZING, "fmi3ExitInitializationMode",
                                       "needed behind fmi3EnterInitializationMode");
    if (status == fmi3OK) {
        instance->memory.phase = UPPER_STEPPING;
    }
    return status;
}

PUBLIC fmi3Status API(fmi3Terminate)(fmi3Instance c)
{
    struct instance *instance = c;
    const fmi3Status status =
        in_phase(instance, UPPER_STEPPING, "fmi3Terminate", "needed behind fmi3ExitInitializationMode");
    if (status == fmi3OK) {
        instance->memory.phase = UPPER_TERMINATED;
    }
    return status;
}

PUBLIC fmi3Status API(fmi3Reset)(fmi3Instance c)
{
    struct instance *instance = c;
    NAME_memory_reset(&instance->memory);
    return fmi3OK;
}

/* ---- Variables: all that are named are right, or none is set ---- */

PUBLIC fmi3Status API(fmi3GetFloat64)(fmi3Instance c, const fmi3ValueReference variables[], size_t count,
                                      fmi3Float64 values[], size_t value_count)
{
    const struct instance *instance = c;
    if (value_count != count) {
        return refused_count(instance, "fmi3GetFloat64");
    }
    for (size_t k = 0; k < count; ++k) {
        const double *place = NAME_number(&instance->memory, variables[k]);
        if (place == NULL) {
            return refused_variable(instance, "fmi3GetFloat64", variables[k], "that of a Float64");
        }
        values[k] = *place;
    }
    return fmi3OK;
}

PUBLIC fmi3Status API(fmi3SetFloat64)(fmi3Instance c, const fmi3ValueReference variables[], size_t count,
                                      const fmi3Float64 values[], size_t value_count)
{
    struct instance *instance = c;
    struct NAME_memory tried = instance->memory;
    if (instance->memory.phase == UPPER_TERMINATED) {
        return refused(instance, "fmi3SetFloat64", "found a terminated instance, needed fmi3Reset");
    }
    if (value_count != count) {
        return refused_count(instance, "fmi3SetFloat64");
    }
    for (size_t k = 0; k < count; ++k) {
        if (!NAME_set_number(&tried, variables[k], values[k])) {
            return refused_variable(instance, "fmi3SetFloat64", variables[k], "that of a Float64 " UPPER_SETTABLE_NUMBERS);
        }
    }
    instance->memory = tried;
    return fmi3OK;
}

PUBLIC fmi3Status API(fmi3GetInt64)(fmi3Instance c, const fmi3ValueReference variables[], size_t count,
                                    int64_t values[], size_t value_count)
{
    const struct instance *instance = c;
    if (value_count != count) {
        return refused_count(instance, "fmi3GetInt64");
    }
    for (size_t k = 0; k < count; ++k) {
        if (!NAME_get_whole(&instance->memory, variables[k], &values[k])) {
            return refused_variable(instance, "fmi3GetInt64", variables[k], "that of " UPPER_WHOLES);
        }
    }
    return fmi3OK;
}

PUBLIC fmi3Status API(fmi3SetInt64)(fmi3Instance c, const fmi3ValueReference variables[], size_t count,
                                    const int64_t values[], size_t value_count)
{
    struct instance *instance = c;
    struct NAME_memory tried = instance->memory;
    if (instance->memory.phase == UPPER_TERMINATED) {
        return refused(instance, "fmi3SetInt64", "found a terminated instance, needed fmi3Reset");
    }
    if (value_count != count) {
        return refused_count(instance, "fmi3SetInt64");
    }
    for (size_t k = 0; k < count; ++k) {
        if (!NAME_set_whole(&tried, variables[k], values[k])) {
            return refused_variable(instance, "fmi3SetInt64", variables[k], "that of " UPPER_SETTABLE_WHOLES);
        }
    }
    instance->memory = tried;
    return fmi3OK;
}

/* What there are no variables of. Asked for none, the answer is right. */
static fmi3Status none_of_type(fmi3Instance c, size_t count, const char *function)
{
    return count == 0 ? fmi3OK : refused(c, function, "found a variable, needed none: there are none of this type");
}

#define NONE_OF(type, ctype)                                                                                           \
    PUBLIC fmi3Status API(fmi3Get##type)(fmi3Instance c, const fmi3ValueReference variables[], size_t count,           \
                                         ctype values[], size_t value_count)                                           \
    {                                                                                                                  \
        (void)variables, (void)values, (void)value_count;                                                              \
        return none_of_type(c, count, "fmi3Get" #type);                                                                \
    }                                                                                                                  \
    PUBLIC fmi3Status API(fmi3Set##type)(fmi3Instance c, const fmi3ValueReference variables[], size_t count,           \
                                         const ctype values[], size_t value_count)                                     \
    {                                                                                                                  \
        (void)variables, (void)values, (void)value_count;                                                              \
        return none_of_type(c, count, "fmi3Set" #type);                                                                \
    }

NONE_OF(Float32, float)
NONE_OF(Int8, int8_t)
NONE_OF(UInt8, uint8_t)
NONE_OF(Int16, int16_t)
NONE_OF(UInt16, uint16_t)
NONE_OF(Int32, int32_t)
NONE_OF(UInt32, uint32_t)
NONE_OF(UInt64, uint64_t)
NONE_OF(Boolean, bool)
NONE_OF(String, fmi3String)

PUBLIC fmi3Status API(fmi3GetBinary)(fmi3Instance c, const fmi3ValueReference variables[], size_t count, size_t sizes[],
                                     const fmi3Byte *values[], size_t value_count)
{
    (void)variables, (void)sizes, (void)values, (void)value_count;
    return none_of_type(c, count, "fmi3GetBinary");
}

PUBLIC fmi3Status API(fmi3SetBinary)(fmi3Instance c, const fmi3ValueReference variables[], size_t count,
                                     const size_t sizes[], const fmi3Byte *const values[], size_t value_count)
{
    (void)variables, (void)sizes, (void)values, (void)value_count;
    return none_of_type(c, count, "fmi3SetBinary");
}

PUBLIC fmi3Status API(fmi3GetClock)(fmi3Instance c, const fmi3ValueReference variables[], size_t count, bool values[])
{
    (void)variables, (void)values;
    return none_of_type(c, count, "fmi3GetClock");
}

PUBLIC fmi3Status API(fmi3SetClock)(fmi3Instance c, const fmi3ValueReference variables[], size_t count, const bool values[])
{
    (void)variables, (void)values;
    return none_of_type(c, count, "fmi3SetClock");
}

/* ---- The whole memory ---- */

/* A copy under *state, which is new when that was a null pointer. */
static fmi3Status kept(const struct instance *instance, const struct NAME_memory *memory, fmi3FMUState *state)
{
    struct NAME_memory *copy = *state != NULL ? *state : malloc(sizeof *copy);
    if (copy == NULL) {
        return refused(instance, "fmi3GetFMUState", "found no memory");
    }
    *copy = *memory;
    *state = copy;
    return fmi3OK;
}

PUBLIC fmi3Status API(fmi3GetFMUState)(fmi3Instance c, fmi3FMUState *state)
{
    const struct instance *instance = c;
    return kept(instance, &instance->memory, state);
}

PUBLIC fmi3Status API(fmi3SetFMUState)(fmi3Instance c, fmi3FMUState state)
{
    struct instance *instance = c;
    if (state == NULL) {
        return refused(instance, "fmi3SetFMUState", "found no state, needed one of fmi3GetFMUState");
    }
    instance->memory = *(const struct NAME_memory *)state;
    return fmi3OK;
}

PUBLIC fmi3Status API(fmi3FreeFMUState)(fmi3Instance c, fmi3FMUState *state)
{
    (void)c;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

PUBLIC fmi3Status API(fmi3SerializedFMUStateSize)(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    (void)c, (void)state;
    *size = NAME_memory_size();
    return fmi3OK;
}

PUBLIC fmi3Status API(fmi3SerializeFMUState)(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    if (state == NULL || size < NAME_memory_size()) {
        return refused(c, "fmi3SerializeFMUState", "needed a state, and as many bytes as fmi3SerializedFMUStateSize says");
    }
    NAME_memory_write(state, bytes);
    return fmi3OK;
}

PUBLIC fmi3Status API(fmi3DeserializeFMUState)(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    struct NAME_memory found;
    if (!NAME_memory_read(&found, bytes, size)) {
        return refused(c, "fmi3DeserializeFMUState", "found other bytes, needed those of fmi3SerializeFMUState of this unit");
    }
    return kept(c, &found, state);
}

/* ---- Steps ---- */

PUBLIC fmi3Status API(fmi3DoStep)(fmi3Instance c, fmi3Float64 time_s, fmi3Float64 step_s, fmi3Boolean no_set_before,
                                  fmi3Boolean *event_needed, fmi3Boolean *terminate, fmi3Boolean *early_return,
                                  fmi3Float64 *last_time_s)
{
    struct instance *instance = c;
    const fmi3Status status = in_phase(instance, UPPER_STEPPING, "fmi3DoStep", "needed behind fmi3ExitInitializationMode");
    (void)no_set_before;
    *event_needed = false;
    *terminate = false;
    *early_return = false;
    *last_time_s = instance->memory.time_s;
    if (status == fmi3OK && !NAME_is_period(step_s)) {
        char text[LONGEST_DETAIL];
        snprintf(text, sizeof text, "found a step of %.9g s, needed the sample period of %.9g s", step_s,
                 UPPER_PERIOD_S);
        return refused(instance, "fmi3DoStep", text);
    }
    if (status == fmi3OK) {
        NAME_step(&instance->memory, time_s);
        *last_time_s = instance->memory.time_s;
    }
    return status;
}

/* ---- What this unit does not offer, and modelDescription.xml does not promise ---- */

static fmi3Status not_offered(fmi3Instance c, const char *function)
{
    return refused(c, function, "found a capability that modelDescription.xml does not promise, needed one of those that it does");
}

#define NOT_OFFERED(name)                                                                                              \
    PUBLIC fmi3Status API(name)(fmi3Instance c)                                                                        \
    {                                                                                                                  \
        return not_offered(c, #name);                                                                                  \
    }

NOT_OFFERED(fmi3EnterEventMode)
NOT_OFFERED(fmi3EnterStepMode)
NOT_OFFERED(fmi3EnterConfigurationMode)
NOT_OFFERED(fmi3ExitConfigurationMode)
NOT_OFFERED(fmi3EvaluateDiscreteStates)

PUBLIC fmi3Status API(fmi3ActivateModelPartition)(fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time_s)
{
    (void)clock, (void)time_s;
    return not_offered(c, "fmi3ActivateModelPartition");
}

PUBLIC fmi3Status API(fmi3UpdateDiscreteStates)(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate,
                                                fmi3Boolean *nominals, fmi3Boolean *states, fmi3Boolean *event_defined,
                                                fmi3Float64 *event_s)
{
    (void)again, (void)terminate, (void)nominals, (void)states, (void)event_defined, (void)event_s;
    return not_offered(c, "fmi3UpdateDiscreteStates");
}

PUBLIC fmi3Status API(fmi3GetOutputDerivatives)(fmi3Instance c, const fmi3ValueReference variables[], size_t count,
                                                const int32_t orders[], fmi3Float64 values[], size_t value_count)
{
    (void)variables, (void)count, (void)orders, (void)values, (void)value_count;
    return not_offered(c, "fmi3GetOutputDerivatives");
}

PUBLIC fmi3Status API(fmi3GetNumberOfVariableDependencies)(fmi3Instance c, fmi3ValueReference variable, size_t *count)
{
    (void)variable, (void)count;
    return not_offered(c, "fmi3GetNumberOfVariableDependencies");
}

PUBLIC fmi3Status API(fmi3GetVariableDependencies)(fmi3Instance c, fmi3ValueReference dependent, size_t elements[],
                                                   fmi3ValueReference independents[], size_t independent_elements[],
                                                   int kinds[], size_t count)
{
    (void)dependent, (void)elements, (void)independents, (void)independent_elements, (void)kinds, (void)count;
    return not_offered(c, "fmi3GetVariableDependencies");
}

#define NO_DERIVATIVE(name)                                                                                            \
    PUBLIC fmi3Status API(name)(fmi3Instance c, const fmi3ValueReference unknowns[], size_t unknown_count,             \
                                const fmi3ValueReference knowns[], size_t known_count, const fmi3Float64 seed[],       \
                                size_t seed_count, fmi3Float64 answers[], size_t answer_count)                         \
    {                                                                                                                  \
        (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count;                                          \
        (void)seed, (void)seed_count, (void)answers, (void)answer_count;                                               \
        return not_offered(c, #name);                                                                                  \
    }

NO_DERIVATIVE(fmi3GetDirectionalDerivative)
NO_DERIVATIVE(fmi3GetAdjointDerivative)

/* Of model exchange. An importer may look for all names before it asks what there is. */
NOT_OFFERED(fmi3EnterContinuousTimeMode)

PUBLIC fmi3Status API(fmi3CompletedIntegratorStep)(fmi3Instance c, fmi3Boolean no_set_before, fmi3Boolean *event_mode,
                                                   fmi3Boolean *terminate)
{
    (void)no_set_before, (void)event_mode, (void)terminate;
    return not_offered(c, "fmi3CompletedIntegratorStep");
}

PUBLIC fmi3Status API(fmi3SetTime)(fmi3Instance c, fmi3Float64 time_s)
{
    (void)time_s;
    return not_offered(c, "fmi3SetTime");
}

#define NO_STATES(name, type)                                                                                          \
    PUBLIC fmi3Status API(name)(fmi3Instance c, type values[], size_t count)                                           \
    {                                                                                                                  \
        (void)values, (void)count;                                                                                     \
        return not_offered(c, #name);                                                                                  \
    }

NO_STATES(fmi3SetContinuousStates, const fmi3Float64)
NO_STATES(fmi3GetContinuousStates, fmi3Float64)
NO_STATES(fmi3GetContinuousStateDerivatives, fmi3Float64)
NO_STATES(fmi3GetNominalsOfContinuousStates, fmi3Float64)
NO_STATES(fmi3GetEventIndicators, fmi3Float64)

static fmi3Status zero(size_t *count)
{
    *count = 0;
    return fmi3OK;
}

PUBLIC fmi3Status API(fmi3GetNumberOfContinuousStates)(fmi3Instance c, size_t *count)
{
    (void)c;
    return zero(count);
}

PUBLIC fmi3Status API(fmi3GetNumberOfEventIndicators)(fmi3Instance c, size_t *count)
{
    (void)c;
    return zero(count);
}

/* Clocks: there are none. Each function has one list of values, or two. */
#define CLOCK_1(name, type)                                                                                            \
    PUBLIC fmi3Status API(name)(fmi3Instance c, const fmi3ValueReference clocks[], size_t count, type values[])        \
    {                                                                                                                  \
        (void)clocks, (void)values;                                                                                    \
        return none_of_type(c, count, #name);                                                                          \
    }

#define CLOCK_2(name, type)                                                                                            \
    PUBLIC fmi3Status API(name)(fmi3Instance c, const fmi3ValueReference clocks[], size_t count, type values[],        \
                                type others[])                                                                         \
    {                                                                                                                  \
        (void)clocks, (void)values, (void)others;                                                                      \
        return none_of_type(c, count, #name);                                                                          \
    }

CLOCK_1(fmi3GetShiftDecimal, fmi3Float64)
CLOCK_1(fmi3SetShiftDecimal, const fmi3Float64)
CLOCK_1(fmi3SetIntervalDecimal, const fmi3Float64)
CLOCK_2(fmi3GetShiftFraction, uint64_t)
CLOCK_2(fmi3SetShiftFraction, const uint64_t)
CLOCK_2(fmi3SetIntervalFraction, const uint64_t)

PUBLIC fmi3Status API(fmi3GetIntervalDecimal)(fmi3Instance c, const fmi3ValueReference clocks[], size_t count,
                                              fmi3Float64 intervals[], int qualifiers[])
{
    (void)clocks, (void)intervals, (void)qualifiers;
    return none_of_type(c, count, "fmi3GetIntervalDecimal");
}

PUBLIC fmi3Status API(fmi3GetIntervalFraction)(fmi3Instance c, const fmi3ValueReference clocks[], size_t count,
                                               uint64_t counters[], uint64_t resolutions[], int qualifiers[])
{
    (void)clocks, (void)counters, (void)resolutions, (void)qualifiers;
    return none_of_type(c, count, "fmi3GetIntervalFraction");
}

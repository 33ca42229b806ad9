/* The unit behind the functional mock-up interface 2.0, for co-simulation. The types are those that the standard publishes;
 * what a function must do stands there, too. */
#include "fmu.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A library of its own exports the names as they are. Whoever links several units into one program defines a prefix. */
#if defined FMI2_FUNCTION_PREFIX && !defined FMI2_OVERRIDE_FUNCTION_PREFIX
#define JOINED(prefix, name) prefix##name
#define PREFIXED(prefix, name) JOINED(prefix, name)
#define API(name) PREFIXED(FMI2_FUNCTION_PREFIX, name)
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

typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String instance, fmi2Status, fmi2String category, fmi2String message, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

struct instance {
    struct NAME_memory memory;
    const fmi2CallbackFunctions *host;
    char *name;
};

enum { LONGEST_DETAIL = 160, LONGEST_MESSAGE = 256 };

/* Tells the host what was tried, found and needed. The message is a format to the host, and has no percent sign in it. */
static fmi2Status tell(const fmi2CallbackFunctions *host, const char *instance, const char *message)
{
    if (host != NULL && host->logger != NULL) {
        host->logger(host->componentEnvironment, instance, fmi2Error, "logStatusError", message);
    }
    return fmi2Error;
}

static fmi2Status refused(const struct instance *instance, const char *function, const char *message)
{
    char text[LONGEST_MESSAGE];
    snprintf(text, sizeof text, "%s: %s", function, message);
    return tell(instance->host, instance->name, text);
}

static fmi2Status refused_variable(const struct instance *instance, const char *function, unsigned int variable,
                                   const char *needed)
{
    char text[LONGEST_DETAIL];
    snprintf(text, sizeof text, "found value reference %u, needed %s", variable, needed);
    return refused(instance, function, text);
}

static fmi2Status in_phase(struct instance *instance, enum NAME_phase phase, const char *function, const char *needed)
{
    return instance->memory.phase == phase ? fmi2OK : refused(instance, function, needed);
}

/* ---- Versions, instances ---- */

PUBLIC const char *API(fmi2GetTypesPlatform)(void)
{
    return "default";
}

PUBLIC const char *API(fmi2GetVersion)(void)
{
    return "2.0";
}

/* Errors are told whatever the host asks for; there is nothing else to tell. */
PUBLIC fmi2Status API(fmi2SetDebugLogging)(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    (void)c, (void)on, (void)count, (void)categories;
    return fmi2OK;
}

static const char *unfit(fmi2String name, fmi2Type type, fmi2String guid)
{
    if (type != fmi2CoSimulation) {
        return "fmi2Instantiate: found model exchange, needed co-simulation";
    }
    if (guid == NULL || strcmp(guid, "@GUID@") != 0) {
        return "fmi2Instantiate: found another guid, needed that of modelDescription.xml: @GUID@";
    }
    if (name == NULL || name[0] == 0) {
        return "fmi2Instantiate: found no name of the instance, needed one";
    }
    if (NAME_selfcheck() != 0) {
        return "fmi2Instantiate: found arithmetic that is not flexbeam's: this build contracts products and sums, or the host "
               "flushes subnormal numbers; needed -ffp-contract=off and IEEE 754 arithmetic";
    }
    return NULL;
}

PUBLIC fmi2Component API(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                          const fmi2CallbackFunctions *host, fmi2Boolean visible, fmi2Boolean logging)
{
    const char *why = unfit(name, type, guid);
    (void)resources, (void)visible, (void)logging;
    if (why != NULL) {
        tell(host, name == NULL ? "" : name, why);
        return NULL;
    }
    struct instance *instance = malloc(sizeof *instance);
    char *copy = malloc(strlen(name) + 1);
    if (instance == NULL || copy == NULL) {
        free(instance);
        free(copy);
        tell(host, name, "fmi2Instantiate: found no memory");
        return NULL;
    }
    strcpy(copy, name);
    instance->host = host;
    instance->name = copy;
    NAME_memory_reset(&instance->memory);
    return instance;
}

PUBLIC void API(fmi2FreeInstance)(fmi2Component c)
{
    struct instance *instance = c;
    if (instance != NULL) {
        free(instance->name);
        free(instance);
    }
}

PUBLIC fmi2Status API(fmi2SetupExperiment)(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                                           fmi2Real start_s, fmi2Boolean stop_defined, fmi2Real stop_s)
{
    struct instance *instance = c;
    const fmi2Status status =
        in_phase(instance, UPPER_INSTANTIATED, "fmi2SetupExperiment", "needed before the initialization");
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop_s;
    if (status == fmi2OK) {
        instance->memory.time_s = start_s;
    }
    return status;
}

PUBLIC fmi2Status API(fmi2EnterInitializationMode)(fmi2Component c)
{
    struct instance *instance = c;
    const fmi2Status status =
        in_phase(instance, UPPER_INSTANTIATED, "fmi2EnterInitializationMode", "needed once, behind fmi2Instantiate or fmi2Reset");
    if (status == fmi2OK) {
        instance->memory.phase = UPPER_INITIALIZING;
    }
    return status;
}

PUBLIC fmi2Status API(fmi2ExitInitializationMode)(fmi2Component c)
{
    struct instance *instance = c;
    const fmi2Status status = in_phase(instance, UPPER_INITIALIZING, "fmi2ExitInitializationMode",
                                       "needed behind fmi2EnterInitializationMode");
    if (status == fmi2OK) {
        instance->memory.phase = UPPER_STEPPING;
    }
    return status;
}

PUBLIC fmi2Status API(fmi2Terminate)(fmi2Component c)
{
    struct instance *instance = c;
    const fmi2Status status =
        in_phase(instance, UPPER_STEPPING, "fmi2Terminate", "needed behind fmi2ExitInitializationMode");
    if (status == fmi2OK) {
        instance->memory.phase = UPPER_TERMINATED;
    }
    return status;
}

PUBLIC fmi2Status API(fmi2Reset)(fmi2Component c)
{
    struct instance *instance = c;
    NAME_memory_reset(&instance->memory);
    return fmi2OK;
}

/* ---- Variables: all that are named are right, or none is set ---- */

PUBLIC fmi2Status API(fmi2GetReal)(fmi2Component c, const fmi2ValueReference variables[], size_t count, fmi2Real values[])
{
    const struct instance *instance = c;
    for (size_t k = 0; k < count; ++k) {
        const double *place = NAME_number(&instance->memory, variables[k]);
        if (place == NULL || variables[k] == UPPER_TIME) {
            return refused_variable(instance, "fmi2GetReal", variables[k], "that of a Real");
        }
        values[k] = *place;
    }
    return fmi2OK;
}

PUBLIC fmi2Status API(fmi2SetReal)(fmi2Component c, const fmi2ValueReference variables[], size_t count,
                                   const fmi2Real values[])
{
    struct instance *instance = c;
    struct NAME_memory tried = instance->memory;
    if (instance->memory.phase == UPPER_TERMINATED) {
        return refused(instance, "fmi2SetReal", "found a terminated instance, needed fmi2Reset");
    }
    for (size_t k = 0; k < count; ++k) {
        if (!NAME_set_number(&tried, variables[k], values[k])) {
            return refused_variable(instance, "fmi2SetReal", variables[k], "that of a Real " UPPER_SETTABLE_NUMBERS);
        }
    }
    instance->memory = tried;
    return fmi2OK;
}

PUBLIC fmi2Status API(fmi2GetInteger)(fmi2Component c, const fmi2ValueReference variables[], size_t count,
                                      fmi2Integer values[])
{
    const struct instance *instance = c;
    for (size_t k = 0; k < count; ++k) {
        int64_t value;
        if (!NAME_get_whole(&instance->memory, variables[k], &value)) {
            return refused_variable(instance, "fmi2GetInteger", variables[k], "that of " UPPER_WHOLES);
        }
        values[k] = (fmi2Integer)value; /* none is larger than an Integer */
    }
    return fmi2OK;
}

PUBLIC fmi2Status API(fmi2SetInteger)(fmi2Component c, const fmi2ValueReference variables[], size_t count,
                                      const fmi2Integer values[])
{
    struct instance *instance = c;
    struct NAME_memory tried = instance->memory;
    if (instance->memory.phase == UPPER_TERMINATED) {
        return refused(instance, "fmi2SetInteger", "found a terminated instance, needed fmi2Reset");
    }
    for (size_t k = 0; k < count; ++k) {
        if (!NAME_set_whole(&tried, variables[k], values[k])) {
            return refused_variable(instance, "fmi2SetInteger", variables[k], "that of " UPPER_SETTABLE_WHOLES);
        }
    }
    instance->memory = tried;
    return fmi2OK;
}

static fmi2Status none_of_type(fmi2Component c, size_t count, const char *function)
{
    return count == 0 ? fmi2OK : refused(c, function, "found a variable, needed none: there are none of this type");
}

PUBLIC fmi2Status API(fmi2GetBoolean)(fmi2Component c, const fmi2ValueReference variables[], size_t count,
                                      fmi2Boolean values[])
{
    (void)variables, (void)values;
    return none_of_type(c, count, "fmi2GetBoolean");
}

PUBLIC fmi2Status API(fmi2SetBoolean)(fmi2Component c, const fmi2ValueReference variables[], size_t count,
                                      const fmi2Boolean values[])
{
    (void)variables, (void)values;
    return none_of_type(c, count, "fmi2SetBoolean");
}

PUBLIC fmi2Status API(fmi2GetString)(fmi2Component c, const fmi2ValueReference variables[], size_t count,
                                     fmi2String values[])
{
    (void)variables, (void)values;
    return none_of_type(c, count, "fmi2GetString");
}

PUBLIC fmi2Status API(fmi2SetString)(fmi2Component c, const fmi2ValueReference variables[], size_t count,
                                     const fmi2String values[])
{
    (void)variables, (void)values;
    return none_of_type(c, count, "fmi2SetString");
}

/* ---- The whole memory ---- */

/* A copy under *state, which is new when that was a null pointer. */
static fmi2Status kept(const struct instance *instance, const struct NAME_memory *memory, fmi2FMUstate *state)
{
    struct NAME_memory *copy = *state != NULL ? *state : malloc(sizeof *copy);
    if (copy == NULL) {
        return refused(instance, "fmi2GetFMUstate", "found no memory");
    }
    *copy = *memory;
    *state = copy;
    return fmi2OK;
}

PUBLIC fmi2Status API(fmi2GetFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    const struct instance *instance = c;
    return kept(instance, &instance->memory, state);
}

PUBLIC fmi2Status API(fmi2SetFMUstate)(fmi2Component c, fmi2FMUstate state)
{
    struct instance *instance = c;
    if (state == NULL) {
        return refused(instance, "fmi2SetFMUstate", "found no state, needed one of fmi2GetFMUstate");
    }
    instance->memory = *(const struct NAME_memory *)state;
    return fmi2OK;
}

PUBLIC fmi2Status API(fmi2FreeFMUstate)(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

PUBLIC fmi2Status API(fmi2SerializedFMUstateSize)(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c, (void)state;
    *size = NAME_memory_size();
    return fmi2OK;
}

PUBLIC fmi2Status API(fmi2SerializeFMUstate)(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    if (state == NULL || size < NAME_memory_size()) {
        return refused(c, "fmi2SerializeFMUstate", "needed a state, and as many bytes as fmi2SerializedFMUstateSize says");
    }
    NAME_memory_write(state, (unsigned char *)bytes);
    return fmi2OK;
}

PUBLIC fmi2Status API(fmi2DeSerializeFMUstate)(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    struct NAME_memory found;
    if (!NAME_memory_read(&found, (const unsigned char *)bytes, size)) {
        return refused(c, "fmi2DeSerializeFMUstate", "found other bytes, needed those of fmi2SerializeFMUstate of this unit");
    }
    return kept(c, &found, state);
}

/* ---- Steps ---- */

PUBLIC fmi2Status API(fmi2DoStep)(fmi2Component c, fmi2Real time_s, fmi2Real step_s, fmi2Boolean no_set_before)
{
    struct instance *instance = c;
    const fmi2Status status = in_phase(instance, UPPER_STEPPING, "fmi2DoStep", "needed behind fmi2ExitInitializationMode");
    (void)no_set_before;
    if (status == fmi2OK && !NAME_is_period(step_s)) {
        char text[LONGEST_DETAIL];
        snprintf(text, sizeof text, "found a step of %.9g s, needed the sample period of %.9g s", step_s,
                 UPPER_PERIOD_S);
        return refused(instance, "fmi2DoStep", text);
    }
    if (status == fmi2OK) {
        NAME_step(&instance->memory, time_s);
    }
    return status;
}

PUBLIC fmi2Status API(fmi2CancelStep)(fmi2Component c)
{
    return refused(c, "fmi2CancelStep", "found no step that runs by itself, needed one");
}

static fmi2Status no_status(fmi2Component c, const char *function)
{
    refused(c, function, "found no step that runs by itself, needed one");
    return fmi2Discard;
}

PUBLIC fmi2Status API(fmi2GetStatus)(fmi2Component c, fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    return no_status(c, "fmi2GetStatus");
}

PUBLIC fmi2Status API(fmi2GetRealStatus)(fmi2Component c, fmi2StatusKind kind, fmi2Real *value)
{
    const struct instance *instance = c;
    if (kind != fmi2LastSuccessfulTime) {
        return no_status(c, "fmi2GetRealStatus");
    }
    *value = instance->memory.time_s;
    return fmi2OK;
}

PUBLIC fmi2Status API(fmi2GetIntegerStatus)(fmi2Component c, fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    return no_status(c, "fmi2GetIntegerStatus");
}

PUBLIC fmi2Status API(fmi2GetBooleanStatus)(fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value)
{
    if (kind != fmi2Terminated) {
        return no_status(c, "fmi2GetBooleanStatus");
    }
    *value = 0;
    return fmi2OK;
}

PUBLIC fmi2Status API(fmi2GetStringStatus)(fmi2Component c, fmi2StatusKind kind, fmi2String *value)
{
    (void)kind, (void)value;
    return no_status(c, "fmi2GetStringStatus");
}

/* ---- What this unit does not offer, and modelDescription.xml does not promise ---- */

PUBLIC fmi2Status API(fmi2SetRealInputDerivatives)(fmi2Component c, const fmi2ValueReference variables[], size_t count,
                                                   const fmi2Integer order[], const fmi2Real values[])
{
    (void)variables, (void)count, (void)order, (void)values;
    return refused(c, "fmi2SetRealInputDerivatives", "found derivatives of inputs, needed inputs alone");
}

PUBLIC fmi2Status API(fmi2GetRealOutputDerivatives)(fmi2Component c, const fmi2ValueReference variables[], size_t count,
                                                    const fmi2Integer order[], fmi2Real values[])
{
    (void)variables, (void)count, (void)order, (void)values;
    return refused(c, "fmi2GetRealOutputDerivatives", "found no derivatives: the outputs are constant between ticks");
}

PUBLIC fmi2Status API(fmi2GetDirectionalDerivative)(fmi2Component c, const fmi2ValueReference unknowns[], size_t unknown_count,
                                                    const fmi2ValueReference knowns[], size_t known_count,
                                                    const fmi2Real changes[], fmi2Real answers[])
{
    (void)unknowns, (void)unknown_count, (void)knowns, (void)known_count, (void)changes, (void)answers;
    return refused(c, "fmi2GetDirectionalDerivative", "found no derivatives: the outputs do not follow the inputs at once");
}

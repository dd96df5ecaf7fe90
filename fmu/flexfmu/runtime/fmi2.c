/* FMI 2.0 face: co-simulation and, for a plant, model exchange. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "instance.h"

typedef struct {
    Memory memory;
    fmi2CallbackFunctions callbacks;
    char *name;
} Instance;

static fmi2Status report(Instance *m, fmi2Status status, const char *format, ...) {
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    /* The text holds no '%', so it may be the format itself: importers that do not format show it too. */
    if (m->callbacks.logger)
        m->callbacks.logger(m->callbacks.componentEnvironment, m->name, status, "logStatusError", text);
    return status;
}

static int allowed(Instance *m, int phases, const char *function) {
    if (m->memory.phase & phases) return 1;
    report(m, fmi2Error, "%s is not allowed in this state of the instance.", function);
    return 0;
}
#define REQUIRE(phases)                                         \
    Instance *m = (Instance *)c;                                \
    if (!m || !allowed(m, (phases), __func__)) return fmi2Error

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    REQUIRE(ALWAYS);
    (void)on, (void)n, (void)categories;
    return fmi2OK;
}

/* ---- life cycle ------------------------------------------------------------------------------ */

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    Instance *m;
    (void)resources, (void)visible, (void)logging;
    if (!name || !*name || !callbacks) return NULL;
    if (!token || strcmp(token, MODEL_TOKEN)) {
        if (callbacks->logger)
            callbacks->logger(callbacks->componentEnvironment, name, fmi2Error, "logStatusError",
                              "The GUID does not belong to this binary: the FMU is damaged or mixed up.");
        return NULL;
    }
    m = (Instance *)calloc(1, sizeof *m);
    if (!m) return NULL;
    m->name = (char *)malloc(strlen(name) + 1);
    if (!m->name) {
        free(m);
        return NULL;
    }
    strcpy(m->name, name);
    m->callbacks = *callbacks;
    memory_start(&m->memory, type == fmi2ModelExchange, 1);
    return m;
}

void fmi2FreeInstance(fmi2Component c) {
    Instance *m = (Instance *)c;
    if (!m) return;
    free(m->name);
    free(m);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
    REQUIRE(INSTANTIATED);
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    m->memory.start = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    REQUIRE(INSTANTIATED);
    m->memory.phase = INITIALIZING;
    m->memory.stale = 1;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    char text[256];
    REQUIRE(INITIALIZING);
    if (memory_initialise(&m->memory, text, sizeof text)) return report(m, fmi2Error, "%s", text);
    m->memory.phase = m->memory.model_exchange ? EVENT : STEPPING;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    REQUIRE(RUNNING);
    m->memory.phase = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    REQUIRE(ALWAYS);
    memory_reset(&m->memory);
    return fmi2OK;
}

/* ---- values ---------------------------------------------------------------------------------- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    size_t i;
    REQUIRE(ALWAYS);
    memory_refresh(&m->memory);
    for (i = 0; i < n; ++i) {
        if (vr[i] >= N_VALUES) return report(m, fmi2Error, "There is no variable %u.", vr[i]);
        value[i] = m->memory.model.value[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    char text[256];
    size_t i;
    REQUIRE(INSTANTIATED | INITIALIZING | RUNNING);
    for (i = 0; i < n; ++i)
        if (memory_refuses(&m->memory, vr[i], value[i], text, sizeof text)) return report(m, fmi2Error, "%s", text);
    for (i = 0; i < n; ++i) m->memory.model.value[vr[i]] = value[i];
    m->memory.stale = (m->memory.phase & (INITIALIZING | RUNNING)) != 0;
    return fmi2OK;
}

#define NO_VARIABLES(function, parameters)                                                     \
    fmi2Status function parameters {                                                           \
        REQUIRE(ALWAYS);                                                                       \
        (void)vr, (void)value;                                                                 \
        return n ? report(m, fmi2Error, "There are only Real variables in this FMU.") : fmi2OK; \
    }
NO_VARIABLES(fmi2GetInteger, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]))
NO_VARIABLES(fmi2GetBoolean, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]))
NO_VARIABLES(fmi2GetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]))
NO_VARIABLES(fmi2SetInteger, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]))
NO_VARIABLES(fmi2SetBoolean, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]))
NO_VARIABLES(fmi2SetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]))

/* ---- saved states ---------------------------------------------------------------------------- */

static fmi2Status unless(Instance *m, const char *problem) {
    return problem ? report(m, fmi2Error, "%s", problem) : fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    REQUIRE(ALWAYS);
    return unless(m, memory_save(&m->memory, state));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    REQUIRE(ALWAYS);
    memory_restore(&m->memory, state);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    REQUIRE(ALWAYS);
    memory_forget(state);
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    REQUIRE(ALWAYS);
    (void)state;
    *size = sizeof(Memory);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    REQUIRE(ALWAYS);
    return unless(m, memory_serialise(state, bytes, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    REQUIRE(ALWAYS);
    return unless(m, memory_deserialise(bytes, size, state));
}

/* ---- derivatives ----------------------------------------------------------------------------- */

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real seed[],
                                        fmi2Real sensitivity[]) {
    REQUIRE(INITIALIZING | RUNNING | TERMINATED);
#ifdef MODEL_DERIVATIVES
    {
        double in[N_VALUES] = {0}, out[N_VALUES];
        size_t i;
        for (i = 0; i < n_known; ++i) {
            if (known[i] >= N_VALUES) return report(m, fmi2Error, "There is no variable %u.", known[i]);
            in[known[i]] += seed[i];
        }
        memory_refresh(&m->memory);
        plant_directional(&m->memory.model, in, m->memory.phase & (INITIALIZING | EVENT), out);
        for (i = 0; i < n_unknown; ++i) {
            if (unknown[i] >= N_VALUES) return report(m, fmi2Error, "There is no variable %u.", unknown[i]);
            sensitivity[i] = out[unknown[i]];
        }
    }
    return fmi2OK;
#else
    (void)unknown, (void)n_unknown, (void)known, (void)n_known, (void)seed, (void)sensitivity;
    return report(m, fmi2Error, "This FMU was exported without derivatives.");
#endif
}

/* ---- co-simulation ----------------------------------------------------------------------------- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    size_t i;
    REQUIRE(INITIALIZING | STEPPING);
    for (i = 0; i < n; ++i) {
        if (vr[i] >= N_INPUTS || model_kinds[vr[i]] != KIND_INPUT || order[i] != 1)
            return report(m, fmi2Error, "Only first derivatives of inputs that a controller samples can be set.");
        m->memory.model.input_rate[vr[i]] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) {
    size_t i;
    REQUIRE(STEPPING | TERMINATED);
#ifdef MODEL_PLANT
    memory_refresh(&m->memory);
    for (i = 0; i < n; ++i) {
        if (vr[i] < AT_STATE || vr[i] >= AT_RATE || order[i] != 1)
            return report(m, fmi2Error, "Only first derivatives of coordinates and speeds are provided.");
        value[i] = m->memory.model.value[vr[i] - AT_STATE + AT_RATE];
    }
    return fmi2OK;
#else
    (void)i, (void)vr, (void)order, (void)value;
    return n ? report(m, fmi2Error, "There are no derivatives of outputs.") : fmi2OK;
#endif
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_rollback) {
    REQUIRE(STEPPING);
    (void)no_rollback;
    if (!(step >= 0)) return report(m, fmi2Error, "The communication step %g must be at least 0.", step);
    if (memory_advance(&m->memory, step)) {
        m->memory.phase = BROKEN;
        return report(m, fmi2Error, "The state left the finite numbers before %g s: reduce solver.step or check "
                                    "the parameters.", time + step);
    }
    return fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    REQUIRE(ALWAYS);
    return report(m, fmi2Error, "There is no asynchronous step to cancel.");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    REQUIRE(ALWAYS);
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = m->memory.start + m->memory.model.time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    REQUIRE(ALWAYS);
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

#define NO_STATUS(function, type)                                                    \
    fmi2Status function(fmi2Component c, const fmi2StatusKind kind, type *value) {   \
        REQUIRE(ALWAYS);                                                             \
        (void)kind, (void)value;                                                     \
        return fmi2Discard;                                                          \
    }
NO_STATUS(fmi2GetStatus, fmi2Status)
NO_STATUS(fmi2GetIntegerStatus, fmi2Integer)
NO_STATUS(fmi2GetStringStatus, fmi2String)

/* ---- model exchange ---------------------------------------------------------------------------- */

#ifdef MODEL_PLANT
fmi2Status fmi2EnterEventMode(fmi2Component c) {
    REQUIRE(EVENT | CONTINUOUS);
    m->memory.phase = EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    REQUIRE(EVENT);
    info->valuesOfContinuousStatesChanged = memory_handle_events(&m->memory);
    info->newDiscreteStatesNeeded = fmi2False;
    info->terminateSimulation = fmi2False;
    info->nominalsOfContinuousStatesChanged = fmi2False;
    info->nextEventTime = memory_next_event(&m->memory);
    info->nextEventTimeDefined = isfinite(info->nextEventTime) ? fmi2True : fmi2False;
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) {
    REQUIRE(EVENT);
    m->memory.phase = CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_rollback, fmi2Boolean *event,
                                       fmi2Boolean *terminate) {
    REQUIRE(CONTINUOUS);
    (void)no_rollback;
    *event = fmi2False;
    *terminate = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    REQUIRE(EVENT | CONTINUOUS);
    memory_set_time(&m->memory, time);
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS);
    if (n != N_STATES) return report(m, fmi2Error, "There are %d continuous states.", N_STATES);
    memcpy(m->memory.model.value + AT_STATE, x, N_STATES * sizeof *x);
    m->memory.stale = 1;
    return fmi2OK;
}

static fmi2Status copy(Instance *m, int from, size_t expected, double *to, size_t n) {
    if (n != expected) return report(m, fmi2Error, "The vector must hold %u numbers.", (unsigned)expected);
    memcpy(to, m->memory.model.value + from, n * sizeof *to);
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS | TERMINATED);
    plant_rates(&m->memory.model);
    return copy(m, AT_RATE, N_STATES, derivatives, n);
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS | TERMINATED);
    return copy(m, AT_STATE, N_STATES, x, n);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS | TERMINATED);
    if (n != N_JOINTS) return report(m, fmi2Error, "There are %d event indicators.", N_JOINTS);
    plant_indicators(&m->memory.model, indicators);
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS | TERMINATED);
    if (n != N_STATES) return report(m, fmi2Error, "There are %d continuous states.", N_STATES);
    memcpy(nominals, model_nominals, sizeof model_nominals);
    return fmi2OK;
}
#endif

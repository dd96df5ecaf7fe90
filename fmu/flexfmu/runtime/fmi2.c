/* FMI 2.0 co-simulation face of the plant. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "plant.h"

typedef enum { INSTANTIATED = 1, INITIALIZING = 2, STEPPING = 4, TERMINATED = 8, BROKEN = 16 } Phase;
enum { ALWAYS = INSTANTIATED | INITIALIZING | STEPPING | TERMINATED | BROKEN };

typedef struct {
    Plant plant;
    int outputs_old; /* the state changed since plant_outputs */
    Phase phase;
    fmi2Boolean logging;
    fmi2CallbackFunctions callbacks;
    char *name;
} Instance;

static fmi2Status report(Instance *m, fmi2Status status, const char *format, ...) {
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (m->callbacks.logger)
        m->callbacks.logger(m->callbacks.componentEnvironment, m->name, status,
                            status == fmi2Warning ? "logStatusWarning" : "logStatusError", "%s", text);
    return status;
}

static int allowed(Instance *m, int phases, const char *function) {
    if (m->phase & phases) return 1;
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
    (void)n, (void)categories;
    m->logging = on;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    Instance *m;
    (void)resources, (void)visible;
    if (!name || !*name || !callbacks || type != fmi2CoSimulation) return NULL;
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
    m->logging = logging;
    m->phase = INSTANTIATED;
    plant_reset(&m->plant);
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
    (void)has_tolerance, (void)tolerance, (void)start, (void)has_stop, (void)stop;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    REQUIRE(INSTANTIATED);
    m->phase = INITIALIZING;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    REQUIRE(INITIALIZING);
    if (plant_initialise(&m->plant)) {
        m->phase = BROKEN;
        return report(m, fmi2Error, "No static equilibrium was found at the first reference: "
                                    "check the stiffnesses k, the masses and the reference.");
    }
    m->outputs_old = 1;
    m->phase = STEPPING;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    REQUIRE(STEPPING);
    m->phase = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    REQUIRE(ALWAYS);
    plant_reset(&m->plant);
    m->phase = INSTANTIATED;
    return fmi2OK;
}

/* ---- values ---------------------------------------------------------------------------------- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) {
    size_t i;
    REQUIRE(ALWAYS);
    if (m->outputs_old) plant_outputs(&m->plant);
    m->outputs_old = 0;
    for (i = 0; i < n; ++i) {
        if (vr[i] >= N_VALUES) return report(m, fmi2Error, "There is no variable %u.", vr[i]);
        value[i] = m->plant.value[vr[i]];
    }
    return fmi2OK;
}

static int settable(fmi2ValueReference vr) { return vr < AT_STATE || (vr >= AT_PARAMETER && vr < N_VALUES); }

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    size_t i;
    REQUIRE(INSTANTIATED | INITIALIZING | STEPPING);
    for (i = 0; i < n; ++i) {
        int at = (int)vr[i] - AT_PARAMETER;
        if (!settable(vr[i])) return report(m, fmi2Error, "Variable %u cannot be set.", vr[i]);
        if (!isfinite(value[i])) return report(m, fmi2Error, "Variable %u was set to a value that is not finite.", vr[i]);
        if (at >= 0 && at < N_PARAMETERS && model_nonnegative[at] && value[i] < 0)
            return report(m, fmi2Error, "Parameter %s = %g must be at least 0.", model_parameter_names[at], value[i]);
        if (vr[i] == AT_STEP && value[i] <= 0)
            return report(m, fmi2Error, "Parameter solver.step = %g must be above 0.", value[i]);
    }
    for (i = 0; i < n; ++i) m->plant.value[vr[i]] = value[i];
    if (m->phase == STEPPING) m->outputs_old = 1;
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

/* ---- states: the plant holds no pointers, so a copy is the whole state ------------------------- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    REQUIRE(ALWAYS);
    if (!*state) *state = malloc(sizeof(Plant));
    if (!*state) return report(m, fmi2Error, "Out of memory.");
    memcpy(*state, &m->plant, sizeof(Plant));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    REQUIRE(INSTANTIATED | INITIALIZING | STEPPING | TERMINATED);
    memcpy(&m->plant, state, sizeof(Plant));
    m->outputs_old = m->plant.ticks > 0;
    m->phase = m->plant.ticks > 0 ? STEPPING : m->phase;
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    REQUIRE(ALWAYS);
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    REQUIRE(ALWAYS);
    (void)state;
    *size = sizeof(Plant);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    REQUIRE(ALWAYS);
    if (size < sizeof(Plant)) return report(m, fmi2Error, "The buffer is too small for the state.");
    memcpy(bytes, state, sizeof(Plant));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    REQUIRE(ALWAYS);
    if (size != sizeof(Plant)) return report(m, fmi2Error, "These bytes are not a state of this FMU.");
    if (!*state) *state = malloc(sizeof(Plant));
    if (!*state) return report(m, fmi2Error, "Out of memory.");
    memcpy(*state, bytes, sizeof(Plant));
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real dknown[],
                                        fmi2Real dunknown[]) {
    REQUIRE(ALWAYS);
    (void)unknown, (void)n_unknown, (void)known, (void)n_known, (void)dknown, (void)dunknown;
    return report(m, fmi2Error, "This FMU provides no directional derivatives.");
}

/* ---- stepping -------------------------------------------------------------------------------- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    size_t i;
    REQUIRE(INITIALIZING | STEPPING);
    for (i = 0; i < n; ++i) {
        if (vr[i] >= N_INPUTS || order[i] != 1)
            return report(m, fmi2Error, "Only first derivatives of inputs can be set.");
        m->plant.input_rate[vr[i]] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) {
    REQUIRE(ALWAYS);
    (void)vr, (void)n, (void)order, (void)value;
    return report(m, fmi2Error, "This FMU provides no output derivatives.");
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean no_rollback) {
    REQUIRE(STEPPING);
    (void)time, (void)no_rollback;
    if (!(step >= 0)) return report(m, fmi2Error, "The communication step %g must be at least 0.", step);
    m->outputs_old = 1;
    if (plant_advance(&m->plant, step)) {
        m->phase = BROKEN;
        return report(m, fmi2Error, "The state left the finite numbers before %g s: reduce solver.step or check "
                                    "the parameters.", time + step);
    }
    return fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    REQUIRE(ALWAYS);
    return report(m, fmi2Error, "There is no asynchronous step to cancel.");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    REQUIRE(ALWAYS);
    (void)kind, (void)value;
    return fmi2Discard;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    REQUIRE(ALWAYS);
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = m->plant.time;
    return fmi2OK;
}
fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    REQUIRE(ALWAYS);
    (void)kind, (void)value;
    return fmi2Discard;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    REQUIRE(ALWAYS);
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}
fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    REQUIRE(ALWAYS);
    (void)kind, (void)value;
    return fmi2Discard;
}

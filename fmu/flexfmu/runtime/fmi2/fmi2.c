/* FMI 2.0 face: life cycle, values, saved states. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "face2.h"
#include "model_token.h"

fmi2Status face_report(Instance *m, fmi2Status status, const char *format, ...) {
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    /* The text holds no '%', so it may be the format itself: importers that do not format show it too. */
    if (m->callbacks.logger)
        m->callbacks.logger(m->callbacks.componentEnvironment, m->name, status, status == fmi2OK ? "logEvents" : "logStatusError", text);
    return status;
}

int face_allowed(Instance *m, int phases, const char *function) {
    if (m->memory.phase & phases) return 1;
    face_report(m, fmi2Error, "%s is not allowed in this state of the instance.", function);
    return 0;
}

void face_log_events(Instance *m, const Memory *before) {
#ifdef MODEL_PLANT
    int j;
    if (!m->logs_events) return;
    for (j = 0; j < N_JOINTS; ++j) {
        double mode = m->memory.model.mode[j];
        if (model_sticking[j] && mode != before->model.mode[j])
            face_report(m, fmi2OK, "Joint %d %s at %.9g s.", j + 1, mode ? "slides" : "sticks",
                        m->memory.start + m->memory.model.time);
    }
#else
    (void)m, (void)before;
#endif
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
    REQUIRE(ALWAYS);
    size_t i;
    int events = n == 0;
    for (i = 0; i < n; ++i) {
        if (!categories || !categories[i] || (strcmp(categories[i], "logEvents") && strcmp(categories[i], "logStatusError")))
            return face_report(m, fmi2Error, "There is no log category %s.", categories && categories[i] ? categories[i] : "");
        events |= !strcmp(categories[i], "logEvents");
    }
    if (events) m->logs_events = on;
    return fmi2OK;
}

/* ---- life cycle ------------------------------------------------------------------------------ */

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
    Instance *m;
    (void)resources, (void)visible;
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
    m->logs_events = logging;
    memory_start(&m->memory, type == fmi2ModelExchange, type != fmi2ModelExchange);
    return m;
}

void fmi2FreeInstance(fmi2Component c) {
    Instance *m = (Instance *)c;
    if (!m) return;
    states_free(&m->states);
    free(m->name);
    free(m);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean has_stop, fmi2Real stop) {
    REQUIRE(INSTANTIATED);
    (void)has_stop, (void)stop;
    if (has_tolerance) memory_tolerate(&m->memory, tolerance);
    if (!isfinite(start)) return face_report(m, fmi2Error, "The start time is not finite.");
    m->memory.start = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    REQUIRE(INSTANTIATED);
    m->memory.phase = INITIALIZING;
    memory_changed(&m->memory);
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    char text[256];
    REQUIRE(INITIALIZING);
    if (memory_initialise(&m->memory, text, sizeof text)) return face_report(m, fmi2Error, "%s", text);
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
    int groups = 0;
    REQUIRE(ALWAYS);
    GIVEN(!n || (vr && value));
    for (i = 0; i < n; ++i) groups |= memory_group(vr[i]);
    memory_show(&m->memory, groups);
    for (i = 0; i < n; ++i) {
        if (vr[i] >= N_VALUES) return face_report(m, fmi2Error, "There is no variable %u.", vr[i]);
        value[i] = m->memory.model.value[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) {
    char text[256];
    size_t i;
    REQUIRE(INSTANTIATED | INITIALIZING | RUNNING);
    GIVEN(!n || (vr && value));
    for (i = 0; i < n; ++i)
        if (memory_refuses(&m->memory, vr[i], value[i], text, sizeof text)) return face_report(m, fmi2Error, "%s", text);
    for (i = 0; i < n; ++i) m->memory.model.value[vr[i]] = value[i];
    memory_changed(&m->memory);
    return fmi2OK;
}

#define NO_VARIABLES(function, parameters)                                                     \
    fmi2Status function parameters {                                                           \
        REQUIRE(ALWAYS);                                                                       \
        (void)vr, (void)value;                                                                 \
        return n ? face_report(m, fmi2Error, "There are only Real variables in this FMU.") : fmi2OK; \
    }
NO_VARIABLES(fmi2GetInteger, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[]))
NO_VARIABLES(fmi2GetBoolean, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[]))
NO_VARIABLES(fmi2GetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]))
NO_VARIABLES(fmi2SetInteger, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]))
NO_VARIABLES(fmi2SetBoolean, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]))
NO_VARIABLES(fmi2SetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]))

/* ---- saved states ---------------------------------------------------------------------------- */

static fmi2Status unless(Instance *m, const char *problem) {
    return problem ? face_report(m, fmi2Error, "%s", problem) : fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    REQUIRE(ALWAYS);
    GIVEN(state);
    return unless(m, states_save(&m->states, &m->memory, state));
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    REQUIRE(ALWAYS);
    return unless(m, states_restore(&m->states, &m->memory, state));
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    REQUIRE(ALWAYS);
    GIVEN(state);
    return unless(m, states_forget(&m->states, state));
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    REQUIRE(ALWAYS);
    GIVEN(size);
    (void)state;
    *size = states_size();
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    REQUIRE(ALWAYS);
    GIVEN(bytes);
    return unless(m, states_serialise(&m->states, state, bytes, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    REQUIRE(ALWAYS);
    GIVEN(state && bytes);
    return unless(m, states_deserialise(&m->states, &m->memory, bytes, size, state));
}

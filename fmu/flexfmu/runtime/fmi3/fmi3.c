/* FMI 3.0 face: life cycle and values. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "face3.h"
#include "model_token.h"

fmi3Status face_report(Instance *m, fmi3Status status, const char *format, ...) {
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (m->log) m->log(m->environment, status, status == fmi3OK ? "logEvents" : "logStatusError", text);
    return status;
}

int face_allowed(Instance *m, int phases, const char *function) {
    if (m->memory.phase & phases) return 1;
    face_report(m, fmi3Error, "%s is not allowed in this state of the instance.", function);
    return 0;
}

void face_log_events(Instance *m, const Memory *before) {
    int j;
    if (!m->logs_events) return;
    for (j = 0; j < N_JOINTS; ++j) {
        double mode = m->memory.model.mode[j];
        if (model_sticking[j] && mode != before->model.mode[j])
            face_report(m, fmi3OK, "Joint %d %s at %.9g s.", j + 1, mode ? "slides" : "sticks",
                        m->memory.start + m->memory.model.time);
    }
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    REQUIRE(ALWAYS);
    size_t i;
    int events = n == 0;
    for (i = 0; i < n; ++i) {
        if (!categories || !categories[i] || (strcmp(categories[i], "logEvents") && strcmp(categories[i], "logStatusError")))
            return face_report(m, fmi3Error, "There is no log category %s.", categories && categories[i] ? categories[i] : "");
        events |= !strcmp(categories[i], "logEvents");
    }
    if (events) m->logs_events = on;
    return fmi3OK;
}

/* ---- life cycle ------------------------------------------------------------------------------ */

static Instance *instantiate(fmi3String token, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
    Instance *m;
    if (!token || strcmp(token, MODEL_TOKEN)) {
        if (log)
            log(environment, fmi3Error, "logStatusError",
                "The instantiation token does not belong to this binary: the FMU is damaged or mixed up.");
        return NULL;
    }
    m = (Instance *)calloc(1, sizeof *m);
    if (!m) return NULL;
    m->environment = environment;
    m->log = log;
    return m;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    Instance *m = instantiate(token, environment, log);
    (void)name, (void)resources, (void)visible;
    if (!m) return NULL;
    memory_start(&m->memory, 1, 0);
    m->logs_events = logging;
    return m;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference required[], size_t n_required,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback intermediate) {
    Instance *m = instantiate(token, environment, log);
    (void)name, (void)resources, (void)visible, (void)required, (void)n_required;
    if (!m) return NULL;
    memory_start(&m->memory, 0, !event_mode);
    m->may_return_early = early_return;
    m->logs_events = logging;
    m->intermediate = intermediate;
    return m;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback clock, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)clock, (void)lock, (void)unlock;
    if (log) log(environment, fmi3Error, "logStatusError", "Scheduled execution is not provided.");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance) {
    Instance *m = (Instance *)instance;
    if (!m) return;
    states_free(&m->states);
    free(m);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop) {
    REQUIRE(INSTANTIATED);
    (void)has_stop, (void)stop;
    if (has_tolerance) memory_tolerate(&m->memory, tolerance);
    if (!isfinite(start)) return face_report(m, fmi3Error, "The start time is not finite.");
    m->memory.start = start;
    m->memory.phase = INITIALIZING;
    memory_changed(&m->memory);
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    char text[256];
    REQUIRE(INITIALIZING);
    if (memory_initialise(&m->memory, text, sizeof text)) return face_report(m, fmi3Error, "%s", text);
    m->memory.phase = m->memory.own_events ? STEPPING : EVENT;
    return fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    REQUIRE(EVENT | CONTINUOUS | STEPPING);
    if (m->memory.own_events)
        return face_report(m, fmi3Error, "The instance was made without event mode (eventModeUsed).");
    m->memory.phase = EVENT;
    m->memory.shown = 0;
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    REQUIRE(RUNNING);
    m->memory.phase = TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance) {
    REQUIRE(ALWAYS);
    memory_reset(&m->memory);
    return fmi3OK;
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance) {
    REQUIRE(INSTANTIATED);
    return face_report(m, fmi3Error, "There are no structural parameters to configure.");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) {
    REQUIRE(ALWAYS);
    return face_report(m, fmi3Error, "There is no configuration mode.");
}

/* ---- values ---------------------------------------------------------------------------------- */

static const Span arrays[N_ARRAYS] = {
    {AT_STATE, N_JOINTS}, {AT_TORQUE, N_JOINTS}, {AT_FRICTION, N_JOINTS}, {AT_TIP, 3}};

/* Where the values of a reference lie; size 0 when there is no such variable. */
Span face_span(fmi3ValueReference vr) {
    Span none = {0, 0}, one = {0, 1};
    if (vr < N_VALUES) {
        one.at = (int)vr;
        return one;
    }
    return vr >= VR_ARRAYS && vr < VR_ARRAYS + N_ARRAYS ? arrays[vr - VR_ARRAYS] : none;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 values[],
                          size_t n_values) {
    size_t i, k = 0;
    int j, groups = 0;
    REQUIRE(ALWAYS);
    GIVEN(!n || (vr && values));
    for (i = 0; i < n; ++i) groups |= memory_group((unsigned)face_span(vr[i]).at);
    memory_show(&m->memory, groups);
    for (i = 0; i < n; ++i) {
        Span span = face_span(vr[i]);
        if (vr[i] == VR_TIME && k < n_values) {
            values[k++] = m->memory.start + m->memory.model.time;
            continue;
        }
        if (!span.size) return face_report(m, fmi3Error, "There is no variable %u.", vr[i]);
        if (k + (size_t)span.size > n_values) return face_report(m, fmi3Error, "The vector of values is too short.");
        for (j = 0; j < span.size; ++j) values[k++] = m->memory.model.value[span.at + j];
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 values[],
                          size_t n_values) {
    char text[256];
    size_t i, k = 0;
    int j;
    REQUIRE(INSTANTIATED | INITIALIZING | RUNNING);
    GIVEN(!n || (vr && values));
    for (i = 0; i < n; ++i) {
        Span span = face_span(vr[i]);
        if (!span.size) return face_report(m, fmi3Error, "There is no variable %u that can be set.", vr[i]);
        if (k + (size_t)span.size > n_values) return face_report(m, fmi3Error, "The vector of values is too short.");
        for (j = 0; j < span.size; ++j, ++k)
            if (memory_refuses(&m->memory, (unsigned)(span.at + j), values[k], text, sizeof text))
                return face_report(m, fmi3Error, "%s", text);
    }
    for (i = 0, k = 0; i < n; ++i) {
        Span span = face_span(vr[i]);
        for (j = 0; j < span.size; ++j) m->memory.model.value[span.at + j] = values[k++];
    }
    memory_changed(&m->memory);
    return fmi3OK;
}

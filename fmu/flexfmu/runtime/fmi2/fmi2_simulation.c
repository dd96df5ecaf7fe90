/* FMI 2.0 face: derivatives, co-simulation, model exchange. */
#include <math.h>
#include <string.h>

#include "face2.h"

/* ---- derivatives ----------------------------------------------------------------------------- */

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t n_unknown,
                                        const fmi2ValueReference known[], size_t n_known, const fmi2Real seed[],
                                        fmi2Real sensitivity[]) {
    REQUIRE(INITIALIZING | RUNNING | TERMINATED);
    GIVEN((!n_unknown || (unknown && sensitivity)) && (!n_known || (known && seed)));
#ifdef MODEL_DERIVATIVES
    {
        double in[N_VALUES] = {0}, out[N_VALUES];
        size_t i;
        for (i = 0; i < n_known; ++i) {
            if (known[i] >= N_VALUES) return face_report(m, fmi2Error, "There is no variable %u.", known[i]);
            in[known[i]] += seed[i];
        }
        memory_show(&m->memory, SHOW_RATES);
        plant_directional(&m->memory.model, in, memory_answer(&m->memory), out);
        for (i = 0; i < n_unknown; ++i) {
            if (unknown[i] >= N_VALUES) return face_report(m, fmi2Error, "There is no variable %u.", unknown[i]);
            sensitivity[i] = out[unknown[i]];
        }
    }
    return fmi2OK;
#else
    (void)unknown, (void)n_unknown, (void)known, (void)n_known, (void)seed, (void)sensitivity;
    return face_report(m, fmi2Error, "This FMU was exported without derivatives.");
#endif
}

/* ---- co-simulation ----------------------------------------------------------------------------- */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    size_t i;
    REQUIRE(INITIALIZING | STEPPING);
    GIVEN(!n || (vr && order && value));
    for (i = 0; i < n; ++i) {
        if (!isfinite(value[i])) return face_report(m, fmi2Error, "A derivative of an input is not finite.");
        if (vr[i] >= N_INPUTS || model_kinds[vr[i]] != KIND_INPUT || order[i] != 1)
            return face_report(m, fmi2Error, "Only first derivatives of inputs that a controller samples can be set.");
        m->memory.model.input_rate[vr[i]] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[]) {
    char text[256];
    size_t i;
    REQUIRE(STEPPING | TERMINATED);
    GIVEN(!n || (vr && order && value));
    for (i = 0; i < n; ++i)
        if (memory_slope(&m->memory, vr[i], order[i], &value[i], text, sizeof text))
            return face_report(m, fmi2Error, "%s", text);
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real duration, fmi2Boolean no_rollback) {
    Step step = {NULL, NULL, 0, 0, 0};
    char text[256];
    Memory before;
    REQUIRE(STEPPING);
    (void)no_rollback;
    if (m->logs_events) before = m->memory;
    if (memory_step(&m->memory, time, duration, &step, text, sizeof text)) return face_report(m, fmi2Error, "%s", text);
    if (m->logs_events) face_log_events(m, &before);
    return fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c) {
    REQUIRE(ALWAYS);
    return face_report(m, fmi2Error, "There is no asynchronous step to cancel.");
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    REQUIRE(ALWAYS);
    GIVEN(value);
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = m->memory.start + m->memory.model.time;
    return fmi2OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    REQUIRE(ALWAYS);
    GIVEN(value);
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
    m->memory.shown = 0;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    char text[256];
    Memory before;
    REQUIRE(EVENT);
    GIVEN(info);
    if (memory_indefinite(&m->memory, text, sizeof text)) return face_report(m, fmi2Error, "%s", text);
    before = m->memory;
    info->valuesOfContinuousStatesChanged = memory_handle_events(&m->memory);
    face_log_events(m, &before);
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
    m->memory.shown = 0;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_rollback, fmi2Boolean *event,
                                       fmi2Boolean *terminate) {
    char text[256];
    REQUIRE(CONTINUOUS);
    GIVEN(event && terminate);
    (void)no_rollback;
    if (memory_indefinite(&m->memory, text, sizeof text)) return face_report(m, fmi2Error, "%s", text);
    *event = fmi2False;
    *terminate = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) {
    char text[256];
    REQUIRE(EVENT | CONTINUOUS);
    if (memory_set_time(&m->memory, time, text, sizeof text)) return face_report(m, fmi2Error, "%s", text);
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS);
    GIVEN(x);
    if (n != N_STATES) return face_report(m, fmi2Error, "There are %d continuous states.", N_STATES);
    if (!memory_finite(x, n)) return face_report(m, fmi2Discard, "A continuous state is not finite.");
    memcpy(m->memory.model.value + AT_STATE, x, N_STATES * sizeof *x);
    memory_changed(&m->memory);
    return fmi2OK;
}

static fmi2Status copy(Instance *m, int from, size_t expected, double *to, size_t n) {
    if (n != expected) return face_report(m, fmi2Error, "The vector must hold %u numbers.", (unsigned)expected);
    memcpy(to, m->memory.model.value + from, n * sizeof *to);
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t n) {
    REQUIRE(INITIALIZING | EVENT | CONTINUOUS | TERMINATED);
    GIVEN(derivatives);
    memory_show(&m->memory, SHOW_RATES);
    if (!memory_finite(m->memory.model.value + AT_RATE, N_STATES))
        return face_report(m, fmi2Discard, "A derivative of the states is not finite.");
    return copy(m, AT_RATE, N_STATES, derivatives, n);
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    REQUIRE(INITIALIZING | EVENT | CONTINUOUS | TERMINATED);
    GIVEN(x);
    memory_show(&m->memory, 0);
    return copy(m, AT_STATE, N_STATES, x, n);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicators[], size_t n) {
    REQUIRE(INITIALIZING | EVENT | CONTINUOUS | TERMINATED);
    GIVEN(indicators);
    memory_show(&m->memory, SHOW_RATES | SHOW_LAWS);
    return copy(m, AT_INDICATOR, N_JOINTS, indicators, n);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominals[], size_t n) {
    REQUIRE(ALWAYS & ~BROKEN);
    GIVEN(nominals);
    if (n != N_STATES) return face_report(m, fmi2Error, "There are %d continuous states.", N_STATES);
    memcpy(nominals, model_nominals, sizeof model_nominals);
    return fmi2OK;
}
#endif

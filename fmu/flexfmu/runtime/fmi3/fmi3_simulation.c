/* FMI 3.0 face: events, model exchange, co-simulation. */
#include <math.h>
#include <string.h>

#include "face3.h"

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                                    const fmi3Int32 orders[], fmi3Float64 values[], size_t n_values) {
    char text[256];
    size_t i, k = 0;
    int j;
    REQUIRE(STEPPING | TERMINATED);
    GIVEN(!n || (vr && orders && values));
    for (i = 0; i < n; ++i) {
        Span span = face_span(vr[i]);
        if (!span.size) return face_report(m, fmi3Error, "There is no variable %u.", vr[i]);
        for (j = 0; j < span.size; ++j, ++k) {
            if (k >= n_values) return face_report(m, fmi3Error, "The vector of values is too short.");
            if (memory_slope(&m->memory, (unsigned)(span.at + j), orders[i], &values[k], text, sizeof text))
                return face_report(m, fmi3Error, "%s", text);
        }
    }
    return fmi3OK;
}

/* ---- events ---------------------------------------------------------------------------------- */

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
    REQUIRE(INITIALIZING | EVENT);
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals_changed, fmi3Boolean *states_changed,
                                    fmi3Boolean *next_defined, fmi3Float64 *next) {
    char text[256];
    Memory before;
    REQUIRE(EVENT);
    GIVEN(again && terminate && nominals_changed && states_changed && next_defined && next);
    if (memory_indefinite(&m->memory, text, sizeof text)) return face_report(m, fmi3Error, "%s", text);
    before = m->memory;
    *states_changed = memory_handle_events(&m->memory) != 0;
    face_log_events(m, &before);
    *again = fmi3False;
    *terminate = fmi3False;
    *nominals_changed = fmi3False;
    *next = memory_next_event(&m->memory);
    *next_defined = isfinite(*next) != 0;
    return fmi3OK;
}

/* ---- model exchange -------------------------------------------------------------------------- */

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance) {
    REQUIRE(EVENT);
    m->memory.phase = CONTINUOUS;
    m->memory.shown = 0;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean no_rollback, fmi3Boolean *event,
                                       fmi3Boolean *terminate) {
    char text[256];
    REQUIRE(CONTINUOUS);
    GIVEN(event && terminate);
    (void)no_rollback;
    if (memory_indefinite(&m->memory, text, sizeof text)) return face_report(m, fmi3Error, "%s", text);
    *event = fmi3False;
    *terminate = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
    char text[256];
    REQUIRE(EVENT | CONTINUOUS);
    if (memory_set_time(&m->memory, time, text, sizeof text)) return face_report(m, fmi3Error, "%s", text);
    return fmi3OK;
}

static fmi3Status copy(Instance *m, const double *from, size_t expected, fmi3Float64 *to, size_t n) {
    if (n != expected) return face_report(m, fmi3Error, "The vector must hold %u numbers.", (unsigned)expected);
    memcpy(to, from, n * sizeof *to);
    return fmi3OK;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 x[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS);
    GIVEN(x);
    if (n == N_STATES && !memory_finite(x, n)) return face_report(m, fmi3Discard, "A continuous state is not finite.");
    memory_changed(&m->memory);
    return copy(m, x, N_STATES, m->memory.model.value + AT_STATE, n);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t n) {
    REQUIRE(INITIALIZING | EVENT | CONTINUOUS | TERMINATED);
    GIVEN(derivatives);
    memory_show(&m->memory, SHOW_RATES);
    if (!memory_finite(m->memory.model.value + AT_RATE, N_STATES))
        return face_report(m, fmi3Discard, "A derivative of the states is not finite.");
    return copy(m, m->memory.model.value + AT_RATE, N_STATES, derivatives, n);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 x[], size_t n) {
    REQUIRE(INITIALIZING | EVENT | CONTINUOUS | TERMINATED);
    GIVEN(x);
    memory_show(&m->memory, 0);
    return copy(m, m->memory.model.value + AT_STATE, N_STATES, x, n);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t n) {
    REQUIRE(INITIALIZING | EVENT | CONTINUOUS | STEPPING | TERMINATED);
    GIVEN(nominals);
    return copy(m, model_nominals, N_STATES, nominals, n);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t n) {
    REQUIRE(INITIALIZING | EVENT | CONTINUOUS | TERMINATED);
    GIVEN(indicators);
    memory_show(&m->memory, SHOW_RATES | SHOW_LAWS);
    return copy(m, m->memory.model.value + AT_INDICATOR, N_JOINTS, indicators, n);
}

/* ---- co-simulation --------------------------------------------------------------------------- */

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    REQUIRE(EVENT);
    m->memory.phase = STEPPING;
    m->memory.shown = 0;
    return fmi3OK;
}

/* Tell the importer where the step has got to. 1 when it wants to have control back. */
static int asked_back(void *importer) {
    Instance *m = (Instance *)importer;
    fmi3Boolean wanted = fmi3False;
    fmi3Float64 when = 0;
    m->intermediate(m->environment, m->memory.start + m->memory.model.time, fmi3False, fmi3True, fmi3True,
                    m->may_return_early != 0, &wanted, &when);
    return wanted && m->may_return_early;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 duration, fmi3Boolean no_rollback,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    Step step = {NULL, NULL, 0, 0, 0};
    char text[256];
    Memory before;
    int failed;
    REQUIRE(STEPPING);
    GIVEN(event && terminate && early && reached);
    (void)no_rollback;
    if (m->intermediate) step.asked_back = asked_back;
    step.importer = m;
    step.may_return_early = m->may_return_early;
    if (m->logs_events) before = m->memory;
    failed = memory_step(&m->memory, time, duration, &step, text, sizeof text);
    *event = step.event != 0;
    *early = step.early != 0;
    *terminate = fmi3False;
    *reached = m->memory.start + m->memory.model.time;
    if (failed) return face_report(m, fmi3Error, "%s", text);
    if (m->logs_events) face_log_events(m, &before);
    return fmi3OK;
}

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

/* What happened to the friction modes, where events are logged. */
static void log_events(Instance *m, const Memory *before) {
    int j;
    if (!m->logs_events) return;
    for (j = 0; j < N_JOINTS; ++j) {
        double mode = m->memory.model.mode[j];
        if (model_sticking[j] && mode != before->model.mode[j])
            face_report(m, fmi3OK, "Joint %d %s at %.9g s.", j + 1, mode ? "slides" : "sticks",
                        m->memory.start + m->memory.model.time);
    }
}

/* ---- events ---------------------------------------------------------------------------------- */

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance) {
    REQUIRE(INITIALIZING | EVENT);
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals_changed, fmi3Boolean *states_changed,
                                    fmi3Boolean *next_defined, fmi3Float64 *next) {
    Memory before;
    REQUIRE(EVENT);
    before = m->memory;
    *states_changed = memory_handle_events(&m->memory) != 0;
    log_events(m, &before);
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
    REQUIRE(CONTINUOUS);
    (void)no_rollback;
    *event = fmi3False;
    *terminate = fmi3False;
    return fmi3OK;
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time) {
    REQUIRE(EVENT | CONTINUOUS);
    memory_set_time(&m->memory, time);
    return fmi3OK;
}

static fmi3Status copy(Instance *m, const double *from, size_t expected, fmi3Float64 *to, size_t n) {
    if (n != expected) return face_report(m, fmi3Error, "The vector must hold %u numbers.", (unsigned)expected);
    memcpy(to, from, n * sizeof *to);
    return fmi3OK;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 x[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS);
    memory_changed(&m->memory);
    return copy(m, x, N_STATES, m->memory.model.value + AT_STATE, n);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t n) {
    REQUIRE(INITIALIZING | EVENT | CONTINUOUS | TERMINATED);
    memory_show(&m->memory, SHOW_RATES);
    return copy(m, m->memory.model.value + AT_RATE, N_STATES, derivatives, n);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 x[], size_t n) {
    REQUIRE(INITIALIZING | EVENT | CONTINUOUS | TERMINATED);
    memory_show(&m->memory, 0);
    return copy(m, m->memory.model.value + AT_STATE, N_STATES, x, n);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t n) {
    REQUIRE(INITIALIZING | EVENT | CONTINUOUS | STEPPING | TERMINATED);
    return copy(m, model_nominals, N_STATES, nominals, n);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t n) {
    REQUIRE(INITIALIZING | EVENT | CONTINUOUS | TERMINATED);
    memory_show(&m->memory, SHOW_RATES | SHOW_LAWS);
    return copy(m, m->memory.model.value + AT_INDICATOR, N_JOINTS, indicators, n);
}

/* ---- co-simulation --------------------------------------------------------------------------- */

static const double STEP_END = 1e-8; /* nothing is left of a step that is closer to its end [s] */

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    REQUIRE(EVENT);
    m->memory.phase = STEPPING;
    m->memory.shown = 0;
    return fmi3OK;
}

/* Tell the importer where the step has got to. 1 when it wants to have control back. */
static int asked_back(Instance *m) {
    fmi3Boolean wanted = fmi3False;
    fmi3Float64 when = 0;
    if (!m->intermediate) return 0;
    m->intermediate(m->environment, m->memory.start + m->memory.model.time, fmi3False, fmi3True, fmi3True,
                    m->may_return_early != 0, &wanted, &when);
    return wanted && m->may_return_early;
}

/* With event mode: to the step's end or the next sample, which the importer handles; one that lies inside the step is
   taken here where an early return is not allowed. 0 when the state stayed finite. */
static int run_to_event(Instance *m, double end, fmi3Boolean *event, fmi3Boolean *early) {
    Plant *plant = &m->memory.model;
    double start = plant->time;
    for (;;) {
        double tick = plant_next_sample(plant);
        int inside = plant_sample_before(plant, end), due = plant_sample_due(plant, end);
        if (plant_run(plant, inside ? tick : end)) return 1;
        m->memory.shown = 0;
        if (due && (m->may_return_early || !inside)) {
            *event = fmi3True;
            *early = inside && tick < end - STEP_END;
            return 0;
        }
        if (!inside) return 0;
        plant_sample(plant, tick - start);
        if (asked_back(m)) {
            *early = fmi3True;
            return 0;
        }
    }
}

/* Without event mode: a sample that is due at the end waits for the next step and its inputs. */
static int run_with_samples(Instance *m, double end, fmi3Boolean *early) {
    Plant *plant = &m->memory.model;
    double start = plant->time;
    while (plant_sample_before(plant, end)) {
        double tick = plant_next_sample(plant), late = tick > start ? tick - start : 0;
        int moved = !plant_sample_due(plant, plant->time);
        if (moved && plant_run(plant, tick)) return 1;
        m->memory.shown = 0;
        if (moved && asked_back(m)) {
            *early = fmi3True;
            return 0;
        }
        plant_sample(plant, late);
    }
    return plant_run(plant, end);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_rollback,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    char text[256];
    Memory before;
    double end;
    int failed;
    REQUIRE(STEPPING);
    (void)no_rollback;
    if (!(step >= 0)) return face_report(m, fmi3Error, "The communication step %g must be at least 0.", step);
    if (memory_elsewhere(&m->memory, time, text, sizeof text)) return face_report(m, fmi3Error, "%s", text);
    if (m->logs_events) before = m->memory;
    end = m->memory.model.time + step;
    *event = *terminate = *early = fmi3False;
    failed = m->memory.own_events ? run_with_samples(m, end, early) : run_to_event(m, end, event, early);
    m->memory.shown = 0;
    m->memory.fed = 0;
    *reached = m->memory.start + m->memory.model.time;
    if (failed) {
        m->memory.phase = BROKEN;
        return face_report(m, fmi3Error, "The state left the finite numbers before %g s: reduce solver.step or check "
                                         "the parameters.", time + step);
    }
    if (m->logs_events) log_events(m, &before);
    return fmi3OK;
}

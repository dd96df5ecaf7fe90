/* FMI 3.0 face of the plant: model exchange and co-simulation, the latter with event mode. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"
#include "instance.h"

typedef struct {
    Memory memory;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback intermediate;
    int may_return_early;
} Instance;

static fmi3Status report(Instance *m, fmi3Status status, const char *format, ...) {
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (m->log) m->log(m->environment, status, "logStatusError", text);
    return status;
}

static int allowed(Instance *m, int phases, const char *function) {
    if (m->memory.phase & phases) return 1;
    report(m, fmi3Error, "%s is not allowed in this state of the instance.", function);
    return 0;
}
#define REQUIRE(phases)                                         \
    Instance *m = (Instance *)instance;                         \
    if (!m || !allowed(m, (phases), __func__)) return fmi3Error

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n, const fmi3String categories[]) {
    REQUIRE(ALWAYS);
    (void)on, (void)n, (void)categories;
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
    (void)name, (void)resources, (void)visible, (void)logging;
    if (m) memory_start(&m->memory, 1, 0);
    return m;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference required[], size_t n_required,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback intermediate) {
    Instance *m = instantiate(token, environment, log);
    (void)name, (void)resources, (void)visible, (void)logging, (void)required, (void)n_required;
    if (!m) return NULL;
    memory_start(&m->memory, 0, !event_mode);
    m->may_return_early = early_return;
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

void fmi3FreeInstance(fmi3Instance instance) { free(instance); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean has_tolerance, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean has_stop, fmi3Float64 stop) {
    REQUIRE(INSTANTIATED);
    (void)has_tolerance, (void)tolerance, (void)has_stop, (void)stop;
    m->memory.start = start;
    m->memory.phase = INITIALIZING;
    m->memory.stale = 1;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    char text[256];
    REQUIRE(INITIALIZING);
    if (memory_initialise(&m->memory, text, sizeof text)) return report(m, fmi3Error, "%s", text);
    m->memory.phase = m->memory.own_events ? STEPPING : EVENT;
    return fmi3OK;
}

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    REQUIRE(EVENT | CONTINUOUS | STEPPING);
    m->memory.phase = EVENT;
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
    return report(m, fmi3Error, "There are no structural parameters to configure.");
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance) {
    REQUIRE(ALWAYS);
    return report(m, fmi3Error, "There is no configuration mode.");
}

/* ---- values: scalars by place, then the time, then arrays that view several places --------------- */

enum { VR_TIME = N_VALUES, VR_ARRAYS };
typedef struct {
    int at, size;
} Span;
static const Span arrays[] = {{AT_STATE, N_JOINTS}, {AT_TORQUE, N_JOINTS}, {AT_FRICTION, N_JOINTS}, {AT_TIP, 3}};
enum { N_ARRAYS = sizeof arrays / sizeof arrays[0] };

/* Where the values of a reference lie; size 0 when there is no such variable. */
static Span span_of(fmi3ValueReference vr) {
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
    int j;
    REQUIRE(ALWAYS);
    memory_refresh(&m->memory);
    for (i = 0; i < n; ++i) {
        Span span = span_of(vr[i]);
        if (vr[i] == VR_TIME && k < n_values) {
            values[k++] = m->memory.start + m->memory.model.time;
            continue;
        }
        if (!span.size) return report(m, fmi3Error, "There is no variable %u.", vr[i]);
        if (k + (size_t)span.size > n_values) return report(m, fmi3Error, "The vector of values is too short.");
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
    for (i = 0; i < n; ++i) {
        Span span = span_of(vr[i]);
        if (!span.size) return report(m, fmi3Error, "There is no variable %u that can be set.", vr[i]);
        if (k + (size_t)span.size > n_values) return report(m, fmi3Error, "The vector of values is too short.");
        for (j = 0; j < span.size; ++j, ++k)
            if (memory_refuses(&m->memory, (unsigned)(span.at + j), values[k], text, sizeof text))
                return report(m, fmi3Error, "%s", text);
    }
    for (i = 0, k = 0; i < n; ++i) {
        Span span = span_of(vr[i]);
        for (j = 0; j < span.size; ++j) m->memory.model.value[span.at + j] = values[k++];
    }
    m->memory.stale = (m->memory.phase & (INITIALIZING | RUNNING)) != 0;
    return fmi3OK;
}

#define ONLY_FLOAT64(function, type)                                                                                \
    fmi3Status function(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, type values[], size_t nv) { \
        REQUIRE(ALWAYS);                                                                                            \
        (void)vr, (void)values, (void)nv;                                                                           \
        return n ? report(m, fmi3Error, "There are only Float64 variables in this FMU.") : fmi3OK;                  \
    }
ONLY_FLOAT64(fmi3GetFloat32, fmi3Float32)
ONLY_FLOAT64(fmi3GetInt8, fmi3Int8)
ONLY_FLOAT64(fmi3GetUInt8, fmi3UInt8)
ONLY_FLOAT64(fmi3GetInt16, fmi3Int16)
ONLY_FLOAT64(fmi3GetUInt16, fmi3UInt16)
ONLY_FLOAT64(fmi3GetInt32, fmi3Int32)
ONLY_FLOAT64(fmi3GetUInt32, fmi3UInt32)
ONLY_FLOAT64(fmi3GetInt64, fmi3Int64)
ONLY_FLOAT64(fmi3GetUInt64, fmi3UInt64)
ONLY_FLOAT64(fmi3GetBoolean, fmi3Boolean)
ONLY_FLOAT64(fmi3GetString, fmi3String)
ONLY_FLOAT64(fmi3SetFloat32, const fmi3Float32)
ONLY_FLOAT64(fmi3SetInt8, const fmi3Int8)
ONLY_FLOAT64(fmi3SetUInt8, const fmi3UInt8)
ONLY_FLOAT64(fmi3SetInt16, const fmi3Int16)
ONLY_FLOAT64(fmi3SetUInt16, const fmi3UInt16)
ONLY_FLOAT64(fmi3SetInt32, const fmi3Int32)
ONLY_FLOAT64(fmi3SetUInt32, const fmi3UInt32)
ONLY_FLOAT64(fmi3SetInt64, const fmi3Int64)
ONLY_FLOAT64(fmi3SetUInt64, const fmi3UInt64)
ONLY_FLOAT64(fmi3SetBoolean, const fmi3Boolean)
ONLY_FLOAT64(fmi3SetString, const fmi3String)

#define NOT_PROVIDED(function, parameters)                                \
    fmi3Status function parameters {                                      \
        REQUIRE(ALWAYS);                                                  \
        return report(m, fmi3Error, "%s is not provided.", __func__);     \
    }
NOT_PROVIDED(fmi3GetBinary, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, size_t s[], fmi3Binary b[], size_t k))
NOT_PROVIDED(fmi3SetBinary, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, const size_t s[], const fmi3Binary b[], size_t k))
NOT_PROVIDED(fmi3GetClock, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3Clock c[]))
NOT_PROVIDED(fmi3SetClock, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3Clock c[]))
NOT_PROVIDED(fmi3GetIntervalDecimal, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3Float64 i[], fmi3IntervalQualifier q[]))
NOT_PROVIDED(fmi3GetIntervalFraction, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3UInt64 c[], fmi3UInt64 r[], fmi3IntervalQualifier q[]))
NOT_PROVIDED(fmi3GetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3Float64 s[]))
NOT_PROVIDED(fmi3GetShiftFraction, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, fmi3UInt64 c[], fmi3UInt64 r[]))
NOT_PROVIDED(fmi3SetIntervalDecimal, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3Float64 i[]))
NOT_PROVIDED(fmi3SetIntervalFraction, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3UInt64 c[], const fmi3UInt64 r[]))
NOT_PROVIDED(fmi3SetShiftDecimal, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3Float64 s[]))
NOT_PROVIDED(fmi3SetShiftFraction, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, const fmi3UInt64 c[], const fmi3UInt64 r[]))
NOT_PROVIDED(fmi3ActivateModelPartition, (fmi3Instance instance, fmi3ValueReference clock, fmi3Float64 time))

/* ---- structure ------------------------------------------------------------------------------- */

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance, fmi3ValueReference vr, size_t *n) {
    REQUIRE(ALWAYS);
    (void)vr, (void)n;
    return report(m, fmi3Error, "Dependencies are fixed; read them from the model description.");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent, size_t de[],
                                       fmi3ValueReference independents[], size_t ie[], fmi3DependencyKind kinds[],
                                       size_t n) {
    REQUIRE(ALWAYS);
    (void)dependent, (void)de, (void)independents, (void)ie, (void)kinds, (void)n;
    return report(m, fmi3Error, "Dependencies are fixed; read them from the model description.");
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *n) {
    REQUIRE(ALWAYS);
    *n = N_JOINTS;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *n) {
    REQUIRE(ALWAYS);
    *n = N_STATES;
    return fmi3OK;
}

/* ---- saved states ---------------------------------------------------------------------------- */

static fmi3Status unless(Instance *m, const char *problem) {
    return problem ? report(m, fmi3Error, "%s", problem) : fmi3OK;
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
    REQUIRE(ALWAYS);
    return unless(m, memory_save(&m->memory, state));
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    REQUIRE(ALWAYS);
    memory_restore(&m->memory, state);
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) {
    REQUIRE(ALWAYS);
    memory_forget(state);
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size) {
    REQUIRE(ALWAYS);
    (void)state;
    *size = sizeof(Memory);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    REQUIRE(ALWAYS);
    return unless(m, memory_serialise(state, (char *)bytes, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    REQUIRE(ALWAYS);
    return unless(m, memory_deserialise((const char *)bytes, size, state));
}

/* ---- derivatives ------------------------------------------------------------------------------- */

#ifdef MODEL_DERIVATIVES
/* Add seeds to their places. 0 when every reference is known. */
static int scatter(const fmi3ValueReference vr[], size_t n, const fmi3Float64 seed[], double *to) {
    size_t i, k = 0;
    int j;
    for (i = 0; i < n; ++i) {
        Span span = span_of(vr[i]);
        if (!span.size) return 1;
        for (j = 0; j < span.size; ++j) to[span.at + j] += seed[k++];
    }
    return 0;
}

static int gather(const fmi3ValueReference vr[], size_t n, const double *from, fmi3Float64 out[]) {
    size_t i, k = 0;
    int j;
    for (i = 0; i < n; ++i) {
        Span span = span_of(vr[i]);
        if (!span.size) return 1;
        for (j = 0; j < span.size; ++j) out[k++] = from[span.at + j];
    }
    return 0;
}
#define SENSITIVITY(function, from, n_from, to, n_to)                                                     \
    double in[N_VALUES] = {0}, out[N_VALUES];                                                             \
    if (scatter(from, n_from, seed, in)) return report(m, fmi3Error, "A variable is unknown.");           \
    memory_refresh(&m->memory);                                                                           \
    function(&m->memory.model, in, m->memory.phase & (INITIALIZING | EVENT), out);                        \
    return gather(to, n_to, out, sensitivity) ? report(m, fmi3Error, "A variable is unknown.") : fmi3OK
#else
#define SENSITIVITY(function, from, n_from, to, n_to)                                   \
    (void)from, (void)n_from, (void)to, (void)n_to, (void)seed, (void)sensitivity;      \
    return report(m, fmi3Error, "This FMU was exported without derivatives.")
#endif

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                        const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                                        size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity) {
    REQUIRE(INITIALIZING | RUNNING | TERMINATED);
    (void)n_seed, (void)n_sensitivity;
    {
        SENSITIVITY(plant_directional, knowns, n_knowns, unknowns, n_unknowns);
    }
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                    const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                                    size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity) {
    REQUIRE(INITIALIZING | RUNNING | TERMINATED);
    (void)n_seed, (void)n_sensitivity;
    {
        SENSITIVITY(plant_adjoint, unknowns, n_unknowns, knowns, n_knowns);
    }
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance, const fmi3ValueReference vr[], size_t n,
                                    const fmi3Int32 orders[], fmi3Float64 values[], size_t n_values) {
    size_t i;
    REQUIRE(STEPPING | TERMINATED);
    (void)n_values;
    memory_refresh(&m->memory);
    for (i = 0; i < n; ++i) {
        if (vr[i] < AT_STATE || vr[i] >= AT_RATE || orders[i] != 1)
            return report(m, fmi3Error, "Only first derivatives of coordinates and speeds are provided.");
        values[i] = m->memory.model.value[vr[i] - AT_STATE + AT_RATE];
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
    REQUIRE(EVENT);
    *states_changed = memory_handle_events(&m->memory) != 0;
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
    if (n != expected) return report(m, fmi3Error, "The vector must hold %u numbers.", (unsigned)expected);
    memcpy(to, from, n * sizeof *to);
    return fmi3OK;
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 x[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS);
    m->memory.stale = 1;
    return copy(m, x, N_STATES, m->memory.model.value + AT_STATE, n);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS | TERMINATED);
    plant_rates(&m->memory.model);
    return copy(m, m->memory.model.value + AT_RATE, N_STATES, derivatives, n);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 x[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS | TERMINATED);
    return copy(m, m->memory.model.value + AT_STATE, N_STATES, x, n);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS | TERMINATED);
    return copy(m, model_nominals, N_STATES, nominals, n);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicators[], size_t n) {
    REQUIRE(EVENT | CONTINUOUS | TERMINATED);
    if (n != N_JOINTS) return report(m, fmi3Error, "There are %d event indicators.", N_JOINTS);
    plant_indicators(&m->memory.model, indicators);
    return fmi3OK;
}

/* ---- co-simulation --------------------------------------------------------------------------- */

static const double STEP_END = 1e-8; /* nothing is left of a step that is closer to its end [s] */

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    REQUIRE(EVENT);
    m->memory.phase = STEPPING;
    return fmi3OK;
}

/* Tell the importer where the step has got to. 1 when it wants to have control back. */
static int asked_back(Instance *m) {
    fmi3Boolean wanted = fmi3False;
    fmi3Float64 when = 0;
    if (!m->intermediate) return 0;
    memory_refresh(&m->memory);
    m->intermediate(m->environment, m->memory.start + m->memory.model.time, fmi3False, fmi3True, fmi3True,
                    m->may_return_early != 0, &wanted, &when);
    return wanted && m->may_return_early;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 step, fmi3Boolean no_rollback,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    Plant *plant;
    double end;
    int failed = 0;
    REQUIRE(STEPPING);
    (void)no_rollback;
    if (!(step >= 0)) return report(m, fmi3Error, "The communication step %g must be at least 0.", step);
    plant = &m->memory.model;
    end = plant->time + step;
    *event = *terminate = *early = fmi3False;
    plant_settle(plant);
    while (!failed && !*event && !*early) {
        double tick = plant_next_sample(plant), start = plant->time;
        int sample = plant_sample_due(plant, end), last = !sample || tick >= end - STEP_END;
        failed = plant_run(plant, sample ? tick : end);
        m->memory.stale = 1;
        if (sample && !m->memory.own_events && (m->may_return_early || last)) {
            *event = fmi3True;
            *early = !last;
        } else if (sample) {
            plant_sample(plant, tick - start);
        }
        if (!sample) break;
        if (!*event && asked_back(m)) *early = !last;
    }
    *reached = m->memory.start + plant->time;
    if (!failed) return fmi3OK;
    m->memory.phase = BROKEN;
    return report(m, fmi3Error, "The state left the finite numbers before %g s: reduce solver.step or check the "
                                "parameters.", time + step);
}

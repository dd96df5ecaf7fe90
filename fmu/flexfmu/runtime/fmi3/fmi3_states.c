/* FMI 3.0 face: saved states and derivatives. */
#include <string.h>

#include "face3.h"

/* ---- saved states ---------------------------------------------------------------------------- */

static fmi3Status unless(Instance *m, const char *problem) {
    return problem ? face_report(m, fmi3Error, "%s", problem) : fmi3OK;
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
    REQUIRE(ALWAYS);
    GIVEN(state);
    return unless(m, states_save(&m->states, &m->memory, state));
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    REQUIRE(ALWAYS);
    return unless(m, states_restore(&m->states, &m->memory, state));
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) {
    REQUIRE(ALWAYS);
    GIVEN(state);
    return unless(m, states_forget(&m->states, state));
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size) {
    REQUIRE(ALWAYS);
    GIVEN(size);
    (void)state;
    *size = states_size();
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
    REQUIRE(ALWAYS);
    GIVEN(bytes);
    return unless(m, states_serialise(&m->states, state, (char *)bytes, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
    REQUIRE(ALWAYS);
    GIVEN(state && bytes);
    return unless(m, states_deserialise(&m->states, &m->memory, (const char *)bytes, size, state));
}

/* ---- derivatives ------------------------------------------------------------------------------- */

#ifdef MODEL_DERIVATIVES
/* Add seeds to their places. 0 when every reference is known and has its seeds. */
static int scatter(const fmi3ValueReference vr[], size_t n, const fmi3Float64 seed[], size_t n_seed, double *to) {
    size_t i, k = 0;
    int j;
    for (i = 0; i < n; ++i) {
        Span span = face_span(vr[i]);
        if (!span.size) return 1;
        if (k + (size_t)span.size > n_seed) return 1;
        for (j = 0; j < span.size; ++j) to[span.at + j] += seed[k++];
    }
    return 0;
}

static int gather(const fmi3ValueReference vr[], size_t n, const double *from, fmi3Float64 out[], size_t n_out) {
    size_t i, k = 0;
    int j;
    for (i = 0; i < n; ++i) {
        Span span = face_span(vr[i]);
        if (!span.size) return 1;
        if (k + (size_t)span.size > n_out) return 1;
        for (j = 0; j < span.size; ++j) out[k++] = from[span.at + j];
    }
    return 0;
}
#define SENSITIVITY(function, from, n_from, to, n_to)                                                     \
    double in[N_VALUES] = {0}, out[N_VALUES];                                                             \
    if (scatter(from, n_from, seed, n_seed, in)) return face_report(m, fmi3Error, "A variable is unknown, or a vector too short.");           \
    memory_show(&m->memory, SHOW_RATES);                                                                  \
    function(&m->memory.model, in, memory_answer(&m->memory), out);                                       \
    return gather(to, n_to, out, sensitivity, n_sensitivity) ? face_report(m, fmi3Error, "A variable is unknown, or a vector too short.") : fmi3OK
#else
#define SENSITIVITY(function, from, n_from, to, n_to)                                   \
    (void)from, (void)n_from, (void)to, (void)n_to, (void)seed, (void)sensitivity;      \
    return face_report(m, fmi3Error, "This FMU was exported without derivatives.")
#endif

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                        const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                                        size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity) {
    REQUIRE(INITIALIZING | RUNNING | TERMINATED);
    GIVEN((!n_unknowns || (unknowns && sensitivity)) && (!n_knowns || (knowns && seed)));
    (void)n_seed, (void)n_sensitivity;
    {
        SENSITIVITY(plant_directional, knowns, n_knowns, unknowns, n_unknowns);
    }
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t n_unknowns,
                                    const fmi3ValueReference knowns[], size_t n_knowns, const fmi3Float64 seed[],
                                    size_t n_seed, fmi3Float64 sensitivity[], size_t n_sensitivity) {
    REQUIRE(INITIALIZING | RUNNING | TERMINATED);
    GIVEN((!n_unknowns || (unknowns && seed)) && (!n_knowns || (knowns && sensitivity)));
    (void)n_seed, (void)n_sensitivity;
    {
        SENSITIVITY(plant_adjoint, unknowns, n_unknowns, knowns, n_knowns);
    }
}

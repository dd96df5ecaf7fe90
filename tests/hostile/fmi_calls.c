/* Random calls of FMI FACE on one FMU, compiled with its sources under sanitizers: fuzz SEED CALLS.
   Pointers may be missing, numbers wild, states foreign, the order of calls anything. It must not crash or hang, and
   what is refused is said in a sentence. */
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model.h"
#include "model_token.h"
#if FACE == 2
#include "face2.h"
typedef fmi2Status Status;
#define F(name) fmi2##name
#define ERROR fmi2Error
#define fmi2GetFMUState fmi2GetFMUstate
#define fmi2SetFMUState fmi2SetFMUstate
#define fmi2FreeFMUState fmi2FreeFMUstate
#define fmi2SerializedFMUStateSize fmi2SerializedFMUstateSize
#define fmi2SerializeFMUState fmi2SerializeFMUstate
#define fmi2DeserializeFMUState fmi2DeSerializeFMUstate
#else
#include "face3.h"
typedef fmi3Status Status;
#define F(name) fmi3##name
#define ERROR fmi3Error
#endif

static uint64_t seed;
static unsigned draw(unsigned n) {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (unsigned)(seed >> 33) % n;
}

static double number(void) {
    static const double wild[] = {0, -0.0, 1, -1, 1e-3, 4e-3, 0.1, 1e-300, -1e-12, 1e9, 1e200, -1e308, INFINITY, -INFINITY, NAN};
    return draw(3) ? (draw(2) ? 4e-3 : draw(2000) * 1e-3 - 1) : wild[draw(sizeof wild / sizeof *wild)];
}

enum { MOST = 6 };
static unsigned vr[MOST];
static double values[4096];
static int orders[MOST];
static size_t filled(void) {
    size_t i, n = draw(MOST);
    for (i = 0; i < n; ++i) {
        vr[i] = draw(8) ? draw(N_VALUES) : draw(2) ? draw(9) + 1000000000u : 4294967295u - draw(3);
        values[i] = number();
        orders[i] = draw(4) ? 1 : (int)draw(5) - 2;
    }
    return n;
}

static size_t said, refused;
static int listening; /* the instance has a logger */
#define MAYBE(pointer) (draw(20) ? (pointer) : NULL)

static void check(Status status) {
    static size_t before;
    if (status >= ERROR) {
        ++refused;
        if (listening && said == before) fprintf(stderr, "refused without a sentence\n"), abort();
    }
    before = said;
}

#if FACE == 2
static void heard(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...) {
    (void)e, (void)name, (void)status, (void)category;
    if (!text || strlen(text) < 10) abort();
    ++said;
}
static const fmi2CallbackFunctions callbacks = {heard, calloc, free, NULL, NULL};
#else
static void heard(fmi3InstanceEnvironment e, fmi3Status status, fmi3String category, fmi3String text) {
    (void)e, (void)status, (void)category;
    if (!text || strlen(text) < 10) abort();
    ++said;
}
static void updated(fmi3InstanceEnvironment e, fmi3Float64 time, fmi3Boolean set, fmi3Boolean get, fmi3Boolean finished,
                    fmi3Boolean may_return, fmi3Boolean *wanted, fmi3Float64 *when) {
    (void)e, (void)set, (void)get, (void)finished, (void)may_return;
    *wanted = draw(3) == 0;
    *when = time;
}
#endif

static void *made(void) {
#if FACE == 2
    listening = 1;
    return fmi2Instantiate(draw(30) ? "arm" : "", draw(2) ? fmi2ModelExchange : fmi2CoSimulation,
                           draw(30) ? MODEL_TOKEN : draw(2) ? "wrong" : NULL, NULL, draw(30) ? &callbacks : NULL, 0, draw(2));
#else
    const char *token = draw(30) ? MODEL_TOKEN : draw(2) ? "wrong" : NULL;
    listening = draw(30) != 0;
    if (draw(2)) return fmi3InstantiateModelExchange("arm", token, NULL, 0, draw(2), NULL, listening ? heard : NULL);
    return fmi3InstantiateCoSimulation("arm", token, NULL, 0, draw(2), draw(2), draw(2), NULL, 0, NULL,
                                       listening ? heard : NULL, draw(2) ? NULL : updated);
#endif
}

static void *state;
static char bytes[200000];
static size_t held;

static void states(void *c) {
    size_t size = 0;
    switch (draw(6)) {
    case 0: check(F(GetFMUState)(c, MAYBE(&state))); break;
    case 1: check(F(SetFMUState)(c, state)); break;
    case 2: check(F(FreeFMUState)(c, MAYBE(&state))); break;
    case 3:
        check(F(SerializedFMUStateSize)(c, state, MAYBE(&size)));
        if (size && size < sizeof bytes) {
            Status status = F(SerializeFMUState)(c, state, (void *)MAYBE(bytes), size);
            held = status < ERROR ? size : held;
            check(status);
        }
        break;
    case 4: /* foreign: zeroed, flipped, cut */
        if (draw(3) == 0) memset(bytes, 0, sizeof bytes);
        if (held && draw(3) == 0) bytes[draw((unsigned)held)] ^= (char)(1 << draw(8));
        check(F(DeserializeFMUState)(c, (void *)MAYBE(bytes), draw(4) ? held : held / 2, MAYBE(&state)));
        break;
    default: check(F(Reset)(c));
    }
}

static void lifecycle(void *c) {
#if FACE == 2
    switch (draw(6)) {
    case 0: check(fmi2SetupExperiment(c, draw(2), number(), draw(9) ? 0 : number(), draw(2), number())); break;
    case 1: check(fmi2EnterInitializationMode(c)); break;
    case 2: check(fmi2ExitInitializationMode(c)); break;
    case 3: check(draw(10) ? fmi2OK : fmi2Terminate(c)); break;
    case 4: check(fmi2EnterEventMode(c)); break;
    default: check(fmi2EnterContinuousTimeMode(c));
    }
#else
    switch (draw(6)) {
    case 0: check(fmi3EnterInitializationMode(c, draw(2), number(), draw(9) ? 0 : number(), draw(2), number())); break;
    case 1: check(fmi3ExitInitializationMode(c)); break;
    case 2: check(draw(10) ? fmi3OK : fmi3Terminate(c)); break;
    case 3: check(fmi3EnterEventMode(c)); break;
    case 4: check(fmi3EnterStepMode(c)); break;
    default: check(fmi3EnterContinuousTimeMode(c));
    }
#endif
}

static double now;

static void run(void *c) {
    size_t n = filled();
    double time = draw(12) ? now : number(), step = number();
    if (step > 10 && step < 1e100) step = 0.01; /* a long step is no fault, it only takes its time */
#if FACE == 2
    fmi2EventInfo info;
    fmi2Boolean a, b;
    switch (draw(10)) {
    case 0: case 1: case 2: {
        fmi2Status status = fmi2DoStep(c, time, step, 1);
        if (status == fmi2OK) now = time + step;
        check(status);
        fmi2GetRealStatus(c, fmi2LastSuccessfulTime, &now);
        break;
    }
    case 3: check(fmi2NewDiscreteStates(c, MAYBE(&info))); break;
    case 4: check(fmi2CompletedIntegratorStep(c, 1, MAYBE(&a), MAYBE(&b))); break;
    case 5: check(fmi2SetTime(c, time + step)); break;
    case 6: check(fmi2SetContinuousStates(c, MAYBE(values), draw(3) ? N_STATES : n)); break;
    case 7: check(fmi2GetDerivatives(c, MAYBE(values), draw(3) ? N_STATES : n)); break;
    case 8: check(fmi2GetEventIndicators(c, MAYBE(values), draw(3) ? N_JOINTS : n)); break;
    default: check(fmi2GetNominalsOfContinuousStates(c, MAYBE(values), draw(3) ? N_STATES : n));
    }
#else
    fmi3Boolean a, b, d, e, f;
    double next;
    switch (draw(10)) {
    case 0: case 1: case 2: check(fmi3DoStep(c, time, step, 1, MAYBE(&a), MAYBE(&b), MAYBE(&d), MAYBE(&now))); break;
    case 3: check(fmi3UpdateDiscreteStates(c, MAYBE(&a), &b, &d, MAYBE(&e), &f, MAYBE(&next))); break;
    case 4: check(fmi3CompletedIntegratorStep(c, 1, MAYBE(&a), MAYBE(&b))); break;
    case 5: check(fmi3SetTime(c, time + step)); break;
    case 6: check(fmi3SetContinuousStates(c, MAYBE(values), draw(3) ? N_STATES : n)); break;
    case 7: check(fmi3GetContinuousStateDerivatives(c, MAYBE(values), draw(3) ? N_STATES : n)); break;
    case 8: check(fmi3GetEventIndicators(c, MAYBE(values), draw(3) ? N_JOINTS : n)); break;
    default: check(fmi3GetNominalsOfContinuousStates(c, MAYBE(values), draw(3) ? N_STATES : n));
    }
#endif
}

static void variables(void *c) {
    size_t n = filled();
    static double out[4096];
#if FACE == 2
    switch (draw(6)) {
    case 0: case 1: check(fmi2GetReal(c, MAYBE(vr), n, MAYBE(out))); break;
    case 2: case 3: check(fmi2SetReal(c, MAYBE(vr), n, MAYBE(values))); break;
    case 4: check(fmi2GetDirectionalDerivative(c, MAYBE(vr), n, MAYBE(vr), n, MAYBE(values), MAYBE(out))); break;
    default: check(fmi2SetRealInputDerivatives(c, MAYBE(vr), n, MAYBE(orders), MAYBE(values)));
    }
    if (draw(8) == 0) check(fmi2GetRealOutputDerivatives(c, MAYBE(vr), n, MAYBE(orders), MAYBE(out)));
#else
    size_t m = draw(4) ? 64 : draw(8);
    switch (draw(6)) {
    case 0: case 1: check(fmi3GetFloat64(c, MAYBE(vr), n, MAYBE(out), m)); break;
    case 2: case 3: check(fmi3SetFloat64(c, MAYBE(vr), n, MAYBE(values), draw(4) ? n : draw(8))); break;
    case 4: check(fmi3GetDirectionalDerivative(c, MAYBE(vr), n, MAYBE(vr), n, MAYBE(values), draw(4) ? n : 64, MAYBE(out), m)); break;
    default: check(fmi3GetAdjointDerivative(c, MAYBE(vr), n, MAYBE(vr), n, MAYBE(values), draw(4) ? n : 64, MAYBE(out), m));
    }
    if (draw(8) == 0) check(fmi3GetOutputDerivatives(c, MAYBE(vr), n, MAYBE(orders), MAYBE(out), m));
#endif
}

int main(int argc, char **argv) {
    unsigned long calls = strtoul(argc > 2 ? argv[2] : "1000", NULL, 10), i;
    void *c = NULL;
    seed = strtoul(argc > 1 ? argv[1] : "1", NULL, 10) * 2654435761u + 1;
    for (i = 0; i < calls; ++i) {
        if (!c || draw(400) == 0) {
            F(FreeInstance)(c);
            c = made();
            now = 0;
            if (c && draw(4)) { /* well begun, else most calls are out of order */
#if FACE == 2
                fmi2SetupExperiment(c, 0, 0, 0, 0, 0), fmi2EnterInitializationMode(c), fmi2ExitInitializationMode(c);
#else
                fmi3EnterInitializationMode(c, 0, 0, 0, 0, 0), fmi3ExitInitializationMode(c);
                if (draw(2)) fmi3EnterStepMode(c);
#endif
            }
            check(0);
            continue;
        }
        switch (draw(8)) {
        case 0: lifecycle(c); break;
        case 1: states(c); break;
        case 2: case 3: case 4: variables(c); break;
        default: run(c);
        }
    }
    F(FreeInstance)(c);
    printf("%lu calls, %zu refused, %zu sentences\n", calls, refused, said);
    return 0;
}

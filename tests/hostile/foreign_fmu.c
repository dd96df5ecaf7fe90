/* A tiny FMI 2.0 co-simulation FMU of one joint that misbehaves as FAULT says. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FINE, CRASH, HANG, EXIT, NOT_A_NUMBER, INFINITE, NULL_INSTANCE, ERROR_STATUS };

static double value[3]; /* r, tau_ff, e */

#ifdef ABORT_AT_LOAD
__attribute__((constructor)) static void at_load(void) { abort(); }
#endif

const char *fmi2GetTypesPlatform(void) { return "default"; }
const char *fmi2GetVersion(void) { return "2.0"; }
int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const *names) { return 0; }
void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks,
                      int visible, int logging) {
    if (FAULT == NULL_INSTANCE || strcmp(guid, "right")) return 0;
    return value;
}
void fmi2FreeInstance(void *c) {}
int fmi2SetupExperiment(void *c, int a, double b, double d, int e, double f) { return 0; }
int fmi2EnterInitializationMode(void *c) { return 0; }
int fmi2ExitInitializationMode(void *c) { return 0; }
int fmi2Terminate(void *c) { return 0; }
int fmi2Reset(void *c) { return 0; }
int fmi2SetReal(void *c, const unsigned *vr, size_t n, const double *v) {
    for (size_t i = 0; i < n; ++i) value[vr[i]] = v[i];
    return 0;
}
int fmi2GetReal(void *c, const unsigned *vr, size_t n, double *v) {
    for (size_t i = 0; i < n; ++i) v[i] = value[vr[i]];
    return 0;
}
#ifndef WITHOUT_STEP
int fmi2DoStep(void *c, double time, double step, int no_rollback) {
    if (FAULT == CRASH) *(volatile int *)0 = 1;
    if (FAULT == HANG)
        for (;;) {
        }
    if (FAULT == EXIT) exit(0);
    value[2] = value[0];
    if (FAULT == NOT_A_NUMBER) value[2] = NAN;
    if (FAULT == INFINITE) value[2] = INFINITY;
    return FAULT == ERROR_STATUS ? 3 : 0;
}
#endif
#define OTHER(name) int name(void) { return 3; }
OTHER(fmi2GetInteger) OTHER(fmi2GetBoolean) OTHER(fmi2GetString) OTHER(fmi2SetInteger) OTHER(fmi2SetBoolean)
OTHER(fmi2SetString) OTHER(fmi2GetFMUstate) OTHER(fmi2SetFMUstate) OTHER(fmi2FreeFMUstate)
OTHER(fmi2SerializedFMUstateSize) OTHER(fmi2SerializeFMUstate) OTHER(fmi2DeSerializeFMUstate)
OTHER(fmi2GetDirectionalDerivative) OTHER(fmi2SetRealInputDerivatives) OTHER(fmi2GetRealOutputDerivatives)
OTHER(fmi2CancelStep) OTHER(fmi2GetStatus) OTHER(fmi2GetRealStatus) OTHER(fmi2GetIntegerStatus)
OTHER(fmi2GetBooleanStatus) OTHER(fmi2GetStringStatus)

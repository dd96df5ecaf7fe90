/* What the files of the FMI 2.0 face share. */
#ifndef FACE2_H
#define FACE2_H

#include "states.h"
#include "step.h"
#ifndef MODEL_ALONE
#define FMI2_FUNCTION_PREFIX MODEL_PREFIX
#endif
#include "fmi2Functions.h"

typedef struct {
    Memory memory;
    fmi2CallbackFunctions callbacks;
    States states;
    char *name;
    int logs_events; /* debug logging: samples and changes of friction modes */
} Instance;

#define face_report MODEL_PREFIXED(face_report)
#define face_allowed MODEL_PREFIXED(face_allowed)
#define face_log_events MODEL_PREFIXED(face_log_events)

fmi2Status face_report(Instance *m, fmi2Status status, const char *format, ...);
int face_allowed(Instance *m, int phases, const char *function);
/* What happened to the modes since `before` [N_JOINTS], where events are logged. */
void face_log_events(Instance *m, const Memory *before);

#define REQUIRE(phases)                                         \
    Instance *m = (Instance *)c;                                \
    if (!m || !face_allowed(m, (phases), __func__)) return fmi2Error
/* Whether every pointer is there that the call reads or writes. */
#define GIVEN(pointers) \
    if (!(pointers)) return face_report(m, fmi2Error, "A pointer is missing in the call of %s.", __func__)

#endif

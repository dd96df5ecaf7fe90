/* What the files of the FMI 3.0 face share. */
#ifndef FACE3_H
#define FACE3_H

#include "states.h"
#include "step.h"
#ifndef MODEL_ALONE
#define FMI3_FUNCTION_PREFIX MODEL_PREFIX
#endif
#include "fmi3Functions.h"

typedef struct {
    Memory memory;
    States states;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback intermediate;
    int may_return_early;
    int logs_events; /* debug logging: samples and changes of friction modes */
} Instance;

/* Values by reference: scalars by place, then the time, arrays that view several places, the controller's clock. */
enum { VR_TIME = N_VALUES, VR_ARRAYS, N_ARRAYS = 4, VR_CLOCK = VR_ARRAYS + N_ARRAYS };
typedef struct {
    int at, size;
} Span;

#define face_report MODEL_PREFIXED(face_report)
#define face_allowed MODEL_PREFIXED(face_allowed)
#define face_log_events MODEL_PREFIXED(face_log_events)
#define face_span MODEL_PREFIXED(face_span)

fmi3Status face_report(Instance *m, fmi3Status status, const char *format, ...);
int face_allowed(Instance *m, int phases, const char *function);
/* What happened to the modes since `before` [N_JOINTS], where events are logged. */
void face_log_events(Instance *m, const Memory *before);
/* Where the values of a reference lie; size 0 when there is no such variable. */
Span face_span(fmi3ValueReference vr);

#define REQUIRE(phases)                                         \
    Instance *m = (Instance *)instance;                         \
    if (!m || !face_allowed(m, (phases), __func__)) return fmi3Error
/* Whether every pointer is there that the call reads or writes. */
#define GIVEN(pointers) \
    if (!(pointers)) return face_report(m, fmi3Error, "A pointer is missing in the call of %s.", __func__)

#endif

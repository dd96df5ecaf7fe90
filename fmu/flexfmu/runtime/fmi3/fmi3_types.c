/* FMI 3.0 face: what this FMU has none of, and its clock. */
#include <math.h>

#include "face3.h"

#define ONLY_FLOAT64(function, type)                                                                                \
    fmi3Status function(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, type values[], size_t nv) { \
        REQUIRE(ALWAYS);                                                                                            \
        (void)vr, (void)values, (void)nv;                                                                           \
        return n ? face_report(m, fmi3Error, "There are only Float64 variables in this FMU.") : fmi3OK;                  \
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
        return face_report(m, fmi3Error, "%s is not provided.", __func__);     \
    }
NOT_PROVIDED(fmi3GetBinary, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, size_t s[], fmi3Binary b[], size_t k))
NOT_PROVIDED(fmi3SetBinary, (fmi3Instance instance, const fmi3ValueReference v[], size_t n, const size_t s[], const fmi3Binary b[], size_t k))
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
    return face_report(m, fmi3Error, "Dependencies are fixed; read them from the model description.");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent, size_t de[],
                                       fmi3ValueReference independents[], size_t ie[], fmi3DependencyKind kinds[],
                                       size_t n) {
    REQUIRE(ALWAYS);
    (void)dependent, (void)de, (void)independents, (void)ie, (void)kinds, (void)n;
    return face_report(m, fmi3Error, "Dependencies are fixed; read them from the model description.");
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *n) {
    REQUIRE(ALWAYS);
    GIVEN(n);
    *n = N_JOINTS;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *n) {
    REQUIRE(ALWAYS);
    GIVEN(n);
    *n = N_STATES;
    return fmi3OK;
}

/* Ticks while a sample of the controller is due. */
fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Clock ticks[]) {
    size_t i;
    REQUIRE(ALWAYS);
    GIVEN(!n || (vr && ticks));
    for (i = 0; i < n; ++i) {
#ifdef MODEL_SAMPLED
        const Plant *plant = &m->memory.model;
        if (vr[i] == VR_CLOCK) {
            ticks[i] = m->memory.phase == EVENT && plant_sample_due(plant, plant->time);
            continue;
        }
#endif
        (void)ticks;
        return face_report(m, fmi3Error, "There is no clock %u.", vr[i]);
    }
    return fmi3OK;
}

#include "instance.h"

#include "step.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void memory_start(Memory *m, int model_exchange, int own_events) {
    memset(m, 0, sizeof *m);
    m->model_exchange = model_exchange;
    m->own_events = own_events;
    memory_reset(m);
}

void memory_reset(Memory *m) {
    MODEL(reset)(&m->model);
    m->phase = INSTANTIATED;
    m->shown = 0;
    m->unplaced = 0;
    m->start = 0;
}

int memory_initialise(Memory *m, char *text, size_t size) {
    m->unplaced = 0;
    m->fed = 1;
    if (MODEL(initialise)(&m->model)) {
        m->phase = BROKEN;
        snprintf(text, size, "No static equilibrium was found at the first reference: check the stiffnesses k, "
                             "the masses and the reference.");
        return 1;
    }
    m->shown = 0;
    return memory_indefinite(m, text, size);
}

int memory_group(unsigned reference) { return MODEL(group)(reference); }

void memory_changed(Memory *m) {
    m->fed = 1;
    m->shown = 0;
    m->unplaced = m->phase == INITIALIZING;
#ifdef MODEL_PLANT
    m->model.unsettled = 1;
#endif
}

Answer memory_answer(const Memory *m) {
    if (m->phase == INITIALIZING) return STARTING;
    if (m->own_events) return m->fed ? SETTLED : HELD;
    return m->phase == EVENT ? SAMPLED : HELD;
}

void memory_show(Memory *m, int groups) {
    if (m->phase & (INSTANTIATED | BROKEN)) return;
    if (m->unplaced) MODEL(initialise)(&m->model);
    m->unplaced = 0;
    groups &= ~m->shown;
    if (!groups) return;
    MODEL(show)(&m->model, groups, memory_answer(m));
    m->shown |= groups;
}

int memory_indefinite(Memory *m, char *text, size_t size) {
#ifdef MODEL_PLANT
    if (!plant_indefinite(&m->model)) return 0;
    m->phase = BROKEN;
    snprintf(text, size, "The mass matrix is not positive definite at %g s: check masses, first moments and moments of "
                         "inertia.", m->start + m->model.time);
    return 1;
#else
    return (void)m, (void)text, (void)size, 0;
#endif
}

int memory_finite(const double *values, size_t n) {
    size_t i;
    for (i = 0; i < n; ++i)
        if (!isfinite(values[i])) return 0;
    return 1;
}

int memory_sound(const Memory *m) {
    const int phases[] = {INSTANTIATED, INITIALIZING, EVENT, CONTINUOUS, STEPPING, TERMINATED, BROKEN};
    size_t i, known = 0;
    for (i = 0; i < sizeof phases / sizeof *phases; ++i) known |= (int)m->phase == phases[i];
    return known && isfinite(m->start) && MODEL(sound)(&m->model);
}

int memory_elsewhere(const Memory *m, double time, char *text, size_t size) {
    double here = m->start + m->model.time;
    if (fabs(time - here) <= 1e-6 + 1e-9 * fabs(here)) return 0;
    snprintf(text, size, "The step begins at %.9g s, but the instance stands at %.9g s.", time, here);
    return 1;
}

int memory_slope(Memory *m, unsigned vr, int order, double *slope, char *text, size_t size) {
#ifdef MODEL_PLANT
    double *v = m->model.value, shown[N_SHOWN];
    if (order == 1 && vr < N_VALUES) {
        memory_show(m, SHOW_RATES | SHOW_MOTION);
        if (vr >= AT_TORQUE && vr < AT_TIP) return *slope = 0, 0; /* held */
        if (vr >= AT_STATE && vr < AT_RATE) return *slope = v[vr - AT_STATE + AT_RATE], 0;
        if (vr >= AT_TIP && vr < AT_SHOWN) return *slope = v[vr - AT_TIP + AT_SHOWN], 0;
        if (vr >= AT_SHOWN && vr < AT_FRICTION) {
            model_shown_rate(v + AT_STATE, v + AT_RATE, shown);
            return *slope = shown[vr - AT_SHOWN], 0;
        }
    }
#else
    (void)m, (void)order, (void)slope;
#endif
    snprintf(text, size, "Only first derivatives of outputs are provided, not number %d of variable %u.", order, vr);
    return 1;
}

void memory_tolerate(Memory *m, double tolerance) {
#ifdef MODEL_PLANT
    const double finest = 1e-14; /* below it, rounding decides */
    if (tolerance > 0 && tolerance < 1e-6) m->model.refinement = pow(fmax(tolerance, finest) / 1e-6, 0.25);
#else
    (void)m, (void)tolerance;
#endif
}

/* ---- what may be set ------------------------------------------------------------------------- */

int memory_refuses(const Memory *m, unsigned vr, double value, char *text, size_t size) {
    const char *name = vr < N_VALUES ? model_names[vr] : "";
    char kind = vr < N_VALUES ? model_kinds[vr] : 0;
    if (!kind) snprintf(text, size, "There is no variable %u.", vr);
    else if (!isfinite(value)) snprintf(text, size, "Variable %s was set to a value that is not finite.", name);
    else if (kind == KIND_STATE && !(m->model_exchange && m->phase & (EVENT | CONTINUOUS)))
        snprintf(text, size, "State %s is set by the FMU itself here.", name);
    else if (kind == KIND_CALCULATED) snprintf(text, size, "Variable %s cannot be set.", name);
    else if (model_bounds[vr] == BOUND_NOT_NEGATIVE && value < 0)
        snprintf(text, size, "Parameter %s = %g must be at least 0.", name, value);
    else if (model_bounds[vr] == BOUND_POSITIVE && value <= 0)
        snprintf(text, size, "Parameter %s = %g must be above 0.", name, value);
    else if (kind == KIND_FIXED && m->phase & RUNNING && value != m->model.value[vr])
        snprintf(text, size, "Parameter %s is fixed once the simulation runs.", name);
    else return 0;
    return 1;
}

/* ---- events ---------------------------------------------------------------------------------- */

#ifdef MODEL_PLANT
int memory_set_time(Memory *m, double time, char *text, size_t size) {
    double there = time - m->start, sampled = plant_next_sample(&m->model);
    double last = isfinite(sampled) && sampled < m->model.time ? sampled : m->model.time;
    if (!isfinite(time) || (there > last && memory_too_long(m, there - last, text, size))) {
        snprintf(text, size, "The time %g s cannot be reached from %g s.", time, m->start + m->model.time);
        return 1;
    }
    m->model.time = there;
    m->shown = 0;
    return 0;
}

int memory_handle_events(Memory *m) {
    int changed = plant_sample_due(&m->model, m->model.time);
    while (plant_sample_due(&m->model, m->model.time)) plant_sample(&m->model, 0);
    changed |= plant_switch(&m->model);
    m->shown = 0;
    return changed;
}

double memory_next_event(const Memory *m) { return m->start + plant_next_sample(&m->model); }
#endif

#include "instance.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
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
    m->stale = 0;
    m->start = 0;
}

int memory_initialise(Memory *m, char *text, size_t size) {
    if (MODEL(initialise)(&m->model)) {
        m->phase = BROKEN;
        snprintf(text, size, "No static equilibrium was found at the first reference: check the stiffnesses k, "
                             "the masses and the reference.");
        return 1;
    }
    m->stale = 1;
    return 0;
}

void memory_refresh(Memory *m) {
    if (!m->stale) return;
    if (m->phase == INITIALIZING) MODEL(initialise)(&m->model);
    MODEL(outputs)(&m->model);
    m->stale = 0;
}

int memory_advance(Memory *m, double duration) {
    int failed = MODEL(advance)(&m->model, duration);
#ifdef MODEL_PLANT
    m->stale = 1;
#else
    m->stale = 0; /* the torque is held until an input is set */
#endif
    return failed;
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
    else if (kind == KIND_FIXED && m->phase & RUNNING)
        snprintf(text, size, "Parameter %s is fixed once the simulation runs.", name);
    else return 0;
    return 1;
}

/* ---- saved states ---------------------------------------------------------------------------- */

static const char *copy_to(void **state, const void *from) {
    if (!*state) *state = malloc(sizeof(Memory));
    if (!*state) return "Out of memory.";
    memcpy(*state, from, sizeof(Memory));
    return NULL;
}

const char *memory_save(const Memory *m, void **state) { return copy_to(state, m); }

void memory_restore(Memory *m, const void *state) { memcpy(m, state, sizeof *m); }

void memory_forget(void **state) {
    free(*state);
    *state = NULL;
}

const char *memory_serialise(const void *state, char *bytes, size_t size) {
    if (size < sizeof(Memory)) return "The buffer is too small for the state.";
    memcpy(bytes, state, sizeof(Memory));
    return NULL;
}

const char *memory_deserialise(const char *bytes, size_t size, void **state) {
    if (size != sizeof(Memory)) return "These bytes are not a state of this FMU.";
    return copy_to(state, bytes);
}

/* ---- events ---------------------------------------------------------------------------------- */

#ifdef MODEL_PLANT
void memory_set_time(Memory *m, double time) {
    m->model.time = time - m->start;
    m->stale = 1;
}

int memory_handle_events(Memory *m) {
    int changed;
    while (plant_sample_due(&m->model, m->model.time)) plant_sample(&m->model, 0);
    changed = plant_switch(&m->model);
    m->stale = 1;
    return changed;
}

double memory_next_event(const Memory *m) { return m->start + plant_next_sample(&m->model); }
#endif

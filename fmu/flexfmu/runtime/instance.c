#include "instance.h"

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
    plant_reset(&m->plant);
    m->phase = INSTANTIATED;
    m->stale = 0;
    m->start = 0;
}

int memory_initialise(Memory *m, char *text, size_t size) {
    if (plant_initialise(&m->plant)) {
        m->phase = BROKEN;
        snprintf(text, size, "No static equilibrium was found at the first reference: check the stiffnesses k, "
                             "the masses and the reference.");
        return 1;
    }
    m->stale = 1;
    return 0;
}

void memory_refresh(Memory *m) {
    if (m->stale) plant_outputs(&m->plant);
    m->stale = 0;
}

static int is_state(unsigned vr) { return vr >= AT_STATE && vr < AT_RATE; }

int memory_refuses(const Memory *m, unsigned vr, double value, char *text, size_t size) {
    int parameter = vr >= AT_PARAMETER && vr < AT_PARAMETER + N_PARAMETERS;
    if (vr >= N_VALUES) snprintf(text, size, "There is no variable %u.", vr);
    else if (!isfinite(value)) snprintf(text, size, "Variable %u was set to a value that is not finite.", vr);
    else if (is_state(vr) && !(m->model_exchange && m->phase & (EVENT | CONTINUOUS)))
        snprintf(text, size, "State %u is set by the FMU itself here.", vr);
    else if (vr >= AT_RATE && vr < AT_PARAMETER) snprintf(text, size, "Variable %u cannot be set.", vr);
    else if (parameter && model_nonnegative[vr - AT_PARAMETER] && value < 0)
        snprintf(text, size, "Parameter %s = %g must be at least 0.", model_parameter_names[vr - AT_PARAMETER], value);
    else if (vr == AT_STEP && m->phase & RUNNING)
        snprintf(text, size, "Parameter solver.step is fixed once the simulation runs.");
    else if (vr == AT_STEP && value <= 0) snprintf(text, size, "Parameter solver.step = %g must be above 0.", value);
    else return 0;
    return 1;
}

void memory_set_time(Memory *m, double time) {
    m->plant.time = time - m->start;
    m->stale = 1;
}

int memory_handle_events(Memory *m) {
    int changed;
    while (plant_sample_due(&m->plant)) plant_sample(&m->plant, 0);
    changed = plant_switch(&m->plant);
    m->stale = 1;
    return changed;
}

double memory_next_event(const Memory *m) { return m->start + plant_next_sample(&m->plant); }

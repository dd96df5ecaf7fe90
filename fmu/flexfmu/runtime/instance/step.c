#include "step.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double MOST_STEPS = 1e8; /* of the solver and of the controller within one communication step */

int memory_too_long(const Memory *m, double duration, char *text, size_t size) {
    double shortest = HUGE_VAL;
#ifdef MODEL_PLANT
    shortest = m->model.value[AT_STEP] * m->model.refinement;
#endif
#ifdef MODEL_SERVO
    shortest = fmin(shortest, PERIOD);
#elif defined MODEL_CONTROLLER || !defined MODEL_PLANT
    shortest = fmin(shortest, m->model.value[AT_GAIN + PID_PERIOD]);
#endif
    if (duration >= 0 && duration <= MOST_STEPS * shortest) return 0;
    snprintf(text, size, "A step of %g s cannot be taken: it must be from 0 to %g s.", duration, MOST_STEPS * shortest);
    return 1;
}

#ifdef MODEL_PLANT
static const double STEP_END = 1e-8; /* nothing is left of a step that is closer to its end [s] */

static int asked_back(const Step *step) { return step->asked_back && step->asked_back(step->importer); }

/* The importer handles events: to the step's end or the next sample; one that lies inside the step is taken here where
   an early return is not allowed. 0 when the state stayed finite. */
static int run_to_event(Memory *m, double end, Step *step) {
    Plant *plant = &m->model;
    double start = plant->time;
    for (;;) {
        double tick = plant_next_sample(plant);
        int inside = plant_sample_before(plant, end), due = plant_sample_due(plant, end);
        if (plant_run(plant, inside ? tick : end)) return 1;
        m->shown = 0;
        if (due && (step->may_return_early || !inside)) {
            step->event = 1;
            step->early = inside && tick < end - STEP_END;
            return 0;
        }
        if (!inside) return 0;
        plant_sample(plant, tick - start);
        if (asked_back(step)) {
            step->early = 1;
            return 0;
        }
    }
}

/* Every sample before the end is taken here; one that is due at the end waits for the next step and its inputs. */
static int run_with_samples(Memory *m, double end, Step *step) {
    Plant *plant = &m->model;
    double start = plant->time;
    while (plant_sample_before(plant, end)) {
        double tick = plant_next_sample(plant), late = tick > start ? tick - start : 0;
        int moved = !plant_sample_due(plant, plant->time);
        if (moved && plant_run(plant, tick)) return 1;
        m->shown = 0;
        if (moved && asked_back(step)) {
            step->early = 1;
            return 0;
        }
        plant_sample(plant, late);
    }
    if (plant_run(plant, end)) return 1;
    memset(plant->input_rate, 0, sizeof plant->input_rate);
    return 0;
}

static int run(Memory *m, double end, Step *step) {
    return m->own_events ? run_with_samples(m, end, step) : run_to_event(m, end, step);
}
#else
static int run(Memory *m, double end, Step *step) { return (void)step, controller_run(&m->model, end); }
#endif

int memory_step(Memory *m, double time, double duration, Step *step, char *text, size_t size) {
    int lost;
    step->event = step->early = 0;
    if (memory_too_long(m, duration, text, size) || memory_elsewhere(m, time, text, size)) return 1;
    if (memory_indefinite(m, text, size)) return 1;
    lost = run(m, m->model.time + duration, step);
    m->shown = 0;
    m->fed = 0;
    if (!lost) return 0;
    m->phase = BROKEN;
    snprintf(text, size, "The state left the finite numbers before %g s: reduce solver.step or check the parameters.",
             time + duration);
    return 1;
}

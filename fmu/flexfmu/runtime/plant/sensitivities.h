/* What both directions of differentiation share: the results in their order, and the point at which they are taken. */
#ifndef SENSITIVITIES_H
#define SENSITIVITIES_H

#include "plant.h"

/* The results of model_forward, one after the other. */
enum {
    OF_RATE = 0,
    OF_IMBALANCE = OF_RATE + N_STATES,
    OF_FRICTION = OF_IMBALANCE + N_JOINTS,
    OF_UPPER = OF_FRICTION + N_JOINTS,
    OF_LOWER = OF_UPPER + N_JOINTS,
    OF_LAW = OF_LOWER + N_JOINTS,
    OF_TIP = OF_LAW + N_COORDINATES,
    OF_SHOWN = OF_TIP + 3,
    N_OF = OF_SHOWN + N_SHOWN
};

static inline int due(const Plant *s, Answer answer) { return answer != HELD && plant_sample_due(s, s->time); }

/* The plant as a sample that is due, or inputs that are held, would leave it. */
static inline Plant answered(const Plant *s, Answer answer) {
    Plant next = *s;
    if (due(s, answer)) plant_sample(&next, 0);
    else if (answer >= SETTLED) plant_settle(&next);
    else plant_rates(s, s->value + AT_STATE, next.value + AT_RATE, next.imbalance, 0);
    return next;
}

/* Which bound a stuck hinge is closer to: +1 the upper one. */
static inline int closer_bound(const Plant *s, int j) {
    double upper[N_JOINTS], lower[N_JOINTS];
    model_breakaway(s->value + AT_STATE, s->value + AT_TORQUE, s->value + AT_PARAMETER, s->mode, upper, lower);
    return upper[j] - s->imbalance[j] < s->imbalance[j] - lower[j] ? 1 : -1;
}

#ifdef MODEL_CONTROLLER
static inline PidSlopes slopes(const Plant *s, int j) {
    const double *v = s->value;
    double error = v[AT_REFERENCE + j] - v[AT_STATE + j] - s->sensor_error[j];
    return pid_slopes(&s->pid, v + AT_GAIN, j, error, v[AT_FEEDFORWARD + j]);
}
#endif

#endif

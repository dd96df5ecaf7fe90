#include "controller.h"

#include <math.h>
#include <string.h>

/* How the torque changes beside the motion and time at which it was computed. */
static void tell_law(double *v, const Past *past, const double reference[N_JOINTS]) {
    const double *gain = v + AT_GAIN, period = gain[PID_PERIOD], *last = past->reference[0];
    int i;
    for (i = 0; i < N_JOINTS; ++i) {
        int limited = fabs(v[AT_TORQUE + i]) >= gain[PID_LIMIT + i];
        double rise = past->pid.ticks > 1 ? reference[i] - last[i] : 0;
        double bend = past->pid.ticks > 2 ? rise - (last[i] - past->reference[1][i]) : 0;
        v[AT_STIFFNESS + i] = limited ? 0 : gain[PID_KP + i];
        v[AT_DAMPING + i] = limited ? 0 : gain[PID_KD + i];
        v[AT_TORQUE_RATE + i] = limited ? 0 : (gain[PID_KP + i] * rise + gain[PID_KD + i] * bend / period) / period;
    }
}

/* The sample of a time [s], of which the inputs are `late` seconds behind. */
static void sample(Controller *s, Past *past, double time, double late) {
    double input[N_INPUTS], *v = s->value, *reference = input + AT_REFERENCE;
    int i;
    for (i = 0; i < N_INPUTS; ++i) input[i] = v[i] + late * s->input_rate[i];
    pid_sample(&past->pid, v + AT_GAIN, reference, input + AT_FEEDFORWARD, input + AT_POSITION, v + AT_TORQUE);
    memcpy(v + AT_SEEN, input + AT_POSITION, 2 * N_JOINTS * sizeof *v);
    v[AT_SAMPLED] = time;
    tell_law(v, past, reference);
    memcpy(past->reference[1], past->reference[0], sizeof past->reference[0]);
    memcpy(past->reference[0], reference, sizeof past->reference[0]);
}

void controller_reset(Controller *s) {
    memset(s, 0, sizeof *s);
    memcpy(s->value, model_starts, sizeof s->value);
}

int controller_initialise(Controller *s) {
    pid_start(&s->past.pid, s->value + AT_INTEGRAL);
    s->time = 0;
    return 0;
}

int controller_group(unsigned reference) { return reference >= AT_TORQUE && reference < AT_INTEGRAL; }

void controller_show(Controller *s, int groups, Answer answer) {
    Past copy = s->past;
    (void)groups;
    if (answer != HELD && pid_due(&copy.pid, s->value + AT_GAIN, s->time)) sample(s, &copy, s->time, 0);
}

int controller_run(Controller *s, double end) {
    const double *gain = s->value + AT_GAIN, tolerance = pid_tolerance(gain);
    double start = s->time, tick;
    while ((tick = pid_next_sample(&s->past.pid, gain)) < end - tolerance)
        sample(s, &s->past, fmax(tick, start), tick > start + tolerance ? tick - start : 0);
    s->time = end;
    memset(s->input_rate, 0, sizeof s->input_rate);
    return 0;
}

int controller_sound(const Controller *s) {
    const double *gain = s->value + AT_GAIN;
    int i;
    for (i = 0; i < N_VALUES; ++i)
        if (!isfinite(s->value[i])) return 0;
    for (i = 0; i < N_JOINTS; ++i)
        if (!isfinite(s->past.reference[0][i]) || !isfinite(s->past.reference[1][i])) return 0;
    return isfinite(s->time) && gain[PID_PERIOD] > 0 && pid_sound(&s->past.pid);
}

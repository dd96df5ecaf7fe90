#include "controller.h"

#include <math.h>
#include <string.h>

static void sample(Controller *s, Pid *pid, double late) {
    double input[N_INPUTS];
    int i;
    for (i = 0; i < N_INPUTS; ++i) input[i] = s->value[i] + late * s->input_rate[i];
    pid_sample(pid, s->value + AT_GAIN, input + AT_REFERENCE, input + AT_FEEDFORWARD, input + AT_POSITION,
               s->value + AT_TORQUE);
}

void controller_reset(Controller *s) {
    memset(s, 0, sizeof *s);
    memcpy(s->value, model_starts, sizeof s->value);
}

int controller_initialise(Controller *s) {
    pid_start(&s->pid, s->value + AT_INTEGRAL);
    s->time = 0;
    return 0;
}

int controller_group(unsigned reference) { return reference >= AT_TORQUE && reference < AT_INTEGRAL; }

void controller_show(Controller *s, int groups, Answer answer) {
    Pid copy = s->pid;
    (void)groups;
    if (answer != HELD && pid_due(&copy, s->value + AT_GAIN, s->time)) sample(s, &copy, 0);
}

int controller_run(Controller *s, double end) {
    const double *gain = s->value + AT_GAIN, tolerance = pid_tolerance(gain);
    double start = s->time, tick;
    while ((tick = pid_next_sample(&s->pid, gain)) < end - tolerance)
        sample(s, &s->pid, tick > start + tolerance ? tick - start : 0);
    s->time = end;
    memset(s->input_rate, 0, sizeof s->input_rate);
    return 0;
}

int controller_sound(const Controller *s) {
    const double *gain = s->value + AT_GAIN;
    int i;
    for (i = 0; i < N_VALUES; ++i)
        if (!isfinite(s->value[i])) return 0;
    return isfinite(s->time) && gain[PID_PERIOD] > 0 && pid_sound(&s->pid);
}

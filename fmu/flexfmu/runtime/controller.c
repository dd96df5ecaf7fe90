#include "controller.h"

#include <string.h>

static void sample(Controller *s, Pid *pid, double late) {
    double input[N_INPUTS];
    int i;
    for (i = 0; i < N_INPUTS; ++i) input[i] = s->value[i] + late * s->input_rate[i];
    pid_sample(pid, s->value + AT_KP, input + AT_REFERENCE, input + AT_FEEDFORWARD, input + AT_POSITION,
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

void controller_outputs(Controller *s) {
    Pid copy = s->pid;
    if (pid_due(&copy, s->time)) sample(s, &copy, 0);
}

int controller_advance(Controller *s, double duration) {
    double start = s->time, end = start + duration, tick;
    while ((tick = pid_next_sample(&s->pid)) < end - SAMPLE_TOLERANCE)
        sample(s, &s->pid, tick > start + SAMPLE_TOLERANCE ? tick - start : 0);
    s->time = end;
    memset(s->input_rate, 0, sizeof s->input_rate);
    return 0;
}

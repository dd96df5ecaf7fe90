/* The digital controller: a PID per joint with the torque held between its samples. */
#ifndef PID_H
#define PID_H

#include "model.h"

/* Communication points are sums of steps: a sample this close counts as now [s]. */
#define SAMPLE_TOLERANCE (1e-6 * PERIOD)

typedef struct {
    double integral[N_JOINTS]; /* [N m] */
    double error[N_JOINTS];    /* at the last sample [rad] */
    long long ticks;           /* samples so far */
} Pid;

/* Before the first sample, with the torques that hold the plant. */
void pid_start(Pid *pid, const double torque[N_JOINTS]);
/* Time of the next sample [s], and whether it has come. */
double pid_next_sample(const Pid *pid);
int pid_due(const Pid *pid, double time);
/* One sample: `gain` holds Kp, Kd and Ki of every joint, `position` the motor hinges. */
void pid_sample(Pid *pid, const double gain[3 * N_JOINTS], const double reference[N_JOINTS],
                const double feedforward[N_JOINTS], const double position[N_JOINTS], double torque[N_JOINTS]);

#endif

/* The digital controller: a PID per joint with the torque held between its samples. */
#ifndef PID_H
#define PID_H

#include "model.h"

/* Its parameters, in this order: Kp, Kd, Ki and the largest torque of every joint, then the period [s]. */
enum { PID_KP = 0, PID_KD = N_JOINTS, PID_KI = 2 * N_JOINTS, PID_LIMIT = 3 * N_JOINTS, PID_PERIOD = 4 * N_JOINTS };
enum { N_GAINS = 4 * N_JOINTS + 1 };

typedef struct {
    double integral[N_JOINTS]; /* [N m] */
    double error[N_JOINTS];    /* at the last sample [rad] */
    long long ticks;           /* samples so far */
} Pid;

/* Before the first sample, with the torques that hold the plant. */
void pid_start(Pid *pid, const double torque[N_JOINTS]);
/* Time of the next sample [s], and whether it has come: communication points are sums of steps, so one that is closer
   than a millionth of the period counts as now. */
double pid_next_sample(const Pid *pid, const double gain[N_GAINS]);
double pid_tolerance(const double gain[N_GAINS]);
int pid_due(const Pid *pid, const double gain[N_GAINS], double time);
/* Whether it is such as this code leaves behind. */
int pid_sound(const Pid *pid);
/* One sample: `position` of the motor hinges as the sensors see them. */
void pid_sample(Pid *pid, const double gain[N_GAINS], const double reference[N_JOINTS],
                const double feedforward[N_JOINTS], const double position[N_JOINTS], double torque[N_JOINTS]);

/* Derivatives of the torque that a joint's next sample would give. */
typedef struct {
    double error, Kp, Kd, Ki, feedforward, limit, integral;
} PidSlopes;
PidSlopes pid_slopes(const Pid *pid, const double gain[N_GAINS], int joint, double error, double feedforward);

#endif

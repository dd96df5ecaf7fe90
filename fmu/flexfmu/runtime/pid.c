#include "pid.h"

#include <string.h>

void pid_start(Pid *pid, const double torque[N_JOINTS]) {
    memset(pid, 0, sizeof *pid);
    memcpy(pid->integral, torque, sizeof pid->integral);
}

double pid_next_sample(const Pid *pid) { return (double)pid->ticks * PERIOD; }

int pid_due(const Pid *pid, double time) { return pid_next_sample(pid) <= time + SAMPLE_TOLERANCE; }

void pid_sample(Pid *pid, const double gain[3 * N_JOINTS], const double reference[N_JOINTS],
                const double feedforward[N_JOINTS], const double position[N_JOINTS], double torque[N_JOINTS]) {
    const double *Kp = gain, *Kd = gain + N_JOINTS, *Ki = gain + 2 * N_JOINTS;
    int j;
    for (j = 0; j < N_JOINTS; ++j) {
        double error = reference[j] - position[j];
        double slope = pid->ticks ? (error - pid->error[j]) / PERIOD : 0;
        if (pid->ticks) pid->integral[j] += Ki[j] * PERIOD * error;
        torque[j] = Kp[j] * error + Kd[j] * slope + pid->integral[j] + feedforward[j];
        pid->error[j] = error;
    }
    ++pid->ticks;
}

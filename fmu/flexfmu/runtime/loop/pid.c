#include "pid.h"

#include <math.h>
#include <string.h>

void pid_start(Pid *pid, const double torque[N_JOINTS]) {
    memset(pid, 0, sizeof *pid);
    memcpy(pid->integral, torque, sizeof pid->integral);
}

double pid_next_sample(const Pid *pid, const double gain[N_GAINS]) { return (double)pid->ticks * gain[PID_PERIOD]; }

double pid_tolerance(const double gain[N_GAINS]) { return 1e-6 * gain[PID_PERIOD]; }

int pid_due(const Pid *pid, const double gain[N_GAINS], double time) {
    return pid_next_sample(pid, gain) <= time + pid_tolerance(gain);
}

/* The torque of a joint before it is limited; the integral is renewed. */
static double wanted(const Pid *pid, const double *gain, int j, double error, double feedforward, double *integral) {
    double slope = pid->ticks ? (error - pid->error[j]) / gain[PID_PERIOD] : 0;
    *integral = pid->integral[j];
    if (pid->ticks) *integral += gain[PID_KI + j] * gain[PID_PERIOD] * error;
    return gain[PID_KP + j] * error + gain[PID_KD + j] * slope + *integral + feedforward;
}

void pid_sample(Pid *pid, const double gain[N_GAINS], const double reference[N_JOINTS],
                const double feedforward[N_JOINTS], const double position[N_JOINTS], double torque[N_JOINTS]) {
    int j;
    for (j = 0; j < N_JOINTS; ++j) {
        double error = reference[j] - position[j], limit = gain[PID_LIMIT + j];
        torque[j] = wanted(pid, gain, j, error, feedforward[j], &pid->integral[j]);
        torque[j] = fmax(-limit, fmin(limit, torque[j]));
        pid->error[j] = error;
    }
    ++pid->ticks;
}

int pid_sound(const Pid *pid) {
    int j;
    for (j = 0; j < N_JOINTS; ++j)
        if (!isfinite(pid->integral[j]) || !isfinite(pid->error[j])) return 0;
    return pid->ticks >= 0;
}

PidSlopes pid_slopes(const Pid *pid, const double gain[N_GAINS], int j, double error, double feedforward) {
    PidSlopes d = {0, 0, 0, 0, 0, 0, 0};
    double period = gain[PID_PERIOD], integral, torque = wanted(pid, gain, j, error, feedforward, &integral);
    int moving = pid->ticks > 0;
    if (fabs(torque) > gain[PID_LIMIT + j]) {
        d.limit = torque > 0 ? 1 : -1;
        return d;
    }
    d.error = gain[PID_KP + j] + (moving ? gain[PID_KD + j] / period + gain[PID_KI + j] * period : 0);
    d.Kp = error;
    d.Kd = moving ? (error - pid->error[j]) / period : 0;
    d.Ki = moving ? period * error : 0;
    d.feedforward = 1;
    d.integral = 1;
    return d;
}

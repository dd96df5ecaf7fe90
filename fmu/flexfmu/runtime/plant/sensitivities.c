/* Directional derivatives of everything that follows from state, inputs and parameters. */
#include "plant.h"

#ifdef MODEL_DERIVATIVES
#include "equilibrium.h"
#include "sensitivities.h"

#include <string.h>

#ifdef MODEL_CONTROLLER
static double torque_forward(const Plant *s, const double *seed, const double *dx, double dholding, int j) {
    PidSlopes d = slopes(s, j);
    const double *gain = seed + AT_GAIN + j;
    return d.error * (seed[AT_REFERENCE + j] - dx[j]) + d.feedforward * seed[AT_FEEDFORWARD + j] + d.Kp * gain[PID_KP] +
           d.Kd * gain[PID_KD] + d.Ki * gain[PID_KI] + d.limit * gain[PID_LIMIT] + d.integral * dholding;
}
#endif

/* Seeds of the state and of the torques that hold it, through the static equilibrium. */
static void start_forward(const Plant *s, const double *seed, double *dx, double *dholding) {
    double dforce[N_COORDINATES], force[N_COORDINATES], dmemory[N_MEMORIES + 1];
    const double *x = s->value + AT_STATE, *p = s->value + AT_PARAMETER;
    int j;
    memset(dx, 0, N_STATES * sizeof *dx);
    for (j = 0; j < N_JOINTS; ++j) {
        dx[j] = seed[AT_REFERENCE + j];
#ifdef MODEL_CONTROLLER
        dx[j] += seed[AT_START_ERROR + j];
#endif
    }
    equilibrium_forward(p, x, seed + AT_PARAMETER, dx, dforce);
    for (j = 0; j < N_JOINTS; ++j) dx[N_COORDINATES + j] = seed[AT_START_SPEED + j];
    model_balance(x, p, force);
    model_start_forward(x, force, p, dx, dforce, seed + AT_PARAMETER, dmemory);
    memcpy(dx + 2 * N_COORDINATES, dmemory, N_MEMORIES * sizeof *dx);
    memcpy(dholding, dforce, N_JOINTS * sizeof *dholding);
}

static void values_forward(const Plant *s, const double *dx, const double *du, const double *dp, double *out) {
    double y[N_OF];
    int j;
    model_forward(s->value + AT_STATE, s->value + AT_TORQUE, s->value + AT_PARAMETER, s->mode, dx, du, dp, y);
    memcpy(out + AT_RATE, y + OF_RATE, N_STATES * sizeof *y);
    memcpy(out + AT_LAW, y + OF_LAW, N_COORDINATES * sizeof *y);
    memcpy(out + AT_TIP, y + OF_TIP, 3 * sizeof *y);
    memcpy(out + AT_SHOWN, y + OF_SHOWN, N_SHOWN * sizeof *y);
    for (j = 0; j < N_JOINTS; ++j) {
        int stuck = s->mode[j] == 0;
        double *margin = out + AT_INDICATOR + j;
        out[AT_FRICTION + j] = y[OF_FRICTION + j] + (stuck ? y[OF_IMBALANCE + j] : 0);
        if (!model_sticking[j]) *margin = 0;
        else if (!stuck) *margin = s->mode[j] * dx[N_COORDINATES + j];
        else if (closer_bound(s, j) > 0) *margin = y[OF_UPPER + j] - y[OF_IMBALANCE + j];
        else *margin = y[OF_IMBALANCE + j] - y[OF_LOWER + j];
    }
}

void plant_directional(const Plant *before, const double seed[N_VALUES], Answer answer, double out[N_VALUES]) {
    Plant s = answered(before, answer);
    double dx[N_STATES], torque[N_JOINTS], dholding[N_JOINTS] = {0};
    int j;
    memcpy(out, seed, N_VALUES * sizeof *out);
    memcpy(dx, seed + AT_STATE, sizeof dx);
    if (answer == STARTING) start_forward(before, seed, dx, dholding);
    for (j = 0; j < N_JOINTS; ++j) {
        torque[j] = seed[AT_TORQUE + j];
#ifdef MODEL_CONTROLLER
        if (due(before, answer)) torque[j] = torque_forward(before, seed, dx, dholding[j], j);
#else
        if (answer == STARTING) out[AT_FEEDFORWARD + j] = dholding[j];
#endif
    }
    memcpy(out + AT_STATE, dx, sizeof dx);
    memcpy(out + AT_TORQUE, torque, sizeof torque);
    values_forward(&s, dx, torque, seed + AT_PARAMETER, out);
}

#else
typedef int sensitivities_are_left_out;
#endif

/* Adjoint derivatives of everything that follows from state, inputs and parameters; FMI 3.0 has them. */
#include "plant.h"

#ifdef MODEL_DERIVATIVES
#include "sensitivities.h"

#include <string.h>

#ifdef MODEL_CONTROLLER
static void torque_adjoint(const Plant *s, double weight, double *out, int j) {
    PidSlopes d = slopes(s, j);
    double *gain = out + AT_GAIN + j;
    out[AT_REFERENCE + j] += d.error * weight;
    out[AT_STATE + j] -= d.error * weight;
    out[AT_FEEDFORWARD + j] += d.feedforward * weight;
    gain[PID_KP] += d.Kp * weight;
    gain[PID_KD] += d.Kd * weight;
    gain[PID_KI] += d.Ki * weight;
    gain[PID_LIMIT] += d.limit * weight;
}
#endif

/* Before the start is known every derivative goes through the equilibrium: row by row. */
static void initial_adjoint(const Plant *s, const double seed[N_VALUES], double out[N_VALUES]) {
    double unit[N_VALUES], row[N_VALUES];
    int i, k;
    memset(out, 0, N_VALUES * sizeof *out);
    for (i = 0; i < N_VALUES; ++i) {
        if (model_kinds[i] == KIND_CALCULATED || model_kinds[i] == KIND_STATE) continue;
        memset(unit, 0, sizeof unit);
        unit[i] = 1;
        plant_directional(s, unit, STARTING, row);
        for (k = 0; k < N_VALUES; ++k) out[i] += row[k] * seed[k];
    }
}

void plant_adjoint(const Plant *before, const double seed[N_VALUES], Answer answer, double out[N_VALUES]) {
    Plant s;
    double y[N_OF] = {0}, by_state[N_STATES], by_torque[N_JOINTS], by_parameter[N_PARAMETERS];
    int i, j;
    if (answer == STARTING) {
        initial_adjoint(before, seed, out);
        return;
    }
    s = answered(before, answer);
    memcpy(out, seed, N_VALUES * sizeof *out);
    memset(out + AT_RATE, 0, (AT_PARAMETER - AT_RATE) * sizeof *out);
    memcpy(y + OF_RATE, seed + AT_RATE, N_STATES * sizeof *y);
    memcpy(y + OF_LAW, seed + AT_LAW, N_COORDINATES * sizeof *y);
    memcpy(y + OF_TIP, seed + AT_TIP, 3 * sizeof *y);
    memcpy(y + OF_SHOWN, seed + AT_SHOWN, N_SHOWN * sizeof *y);
    for (j = 0; j < N_JOINTS; ++j) {
        double margin = seed[AT_INDICATOR + j], friction = seed[AT_FRICTION + j];
        y[OF_FRICTION + j] = friction;
        if (s.mode[j] != 0) {
            if (model_sticking[j]) out[AT_STATE + N_COORDINATES + j] += s.mode[j] * margin;
            continue;
        }
        y[OF_IMBALANCE + j] = friction;
        if (closer_bound(&s, j) > 0) y[OF_UPPER + j] = margin, y[OF_IMBALANCE + j] -= margin;
        else y[OF_LOWER + j] = -margin, y[OF_IMBALANCE + j] += margin;
    }
    model_adjoint(s.value + AT_STATE, s.value + AT_TORQUE, s.value + AT_PARAMETER, s.mode, y, by_state, by_torque,
                  by_parameter);
    for (i = 0; i < N_STATES; ++i) out[AT_STATE + i] += by_state[i];
    for (i = 0; i < N_PARAMETERS; ++i) out[AT_PARAMETER + i] += by_parameter[i];
    for (j = 0; j < N_JOINTS; ++j) {
        double weight = by_torque[j] + seed[AT_TORQUE + j];
#ifdef MODEL_CONTROLLER
        if (due(before, answer)) {
            torque_adjoint(before, weight, out, j);
            continue;
        }
#endif
        out[AT_TORQUE + j] += weight;
    }
}
#else
typedef int adjoint_is_left_out;
#endif

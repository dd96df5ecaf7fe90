/* Directional and adjoint derivatives of everything that follows from state, inputs and parameters. */
#include "plant.h"

#ifdef MODEL_DERIVATIVES
#include "equilibrium.h"

#include <math.h>
#include <string.h>

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

static int due(const Plant *s, Answer answer) { return answer != HELD && plant_sample_due(s, s->time); }

/* The plant as a sample that is due, or inputs that are held, would leave it. */
static Plant answered(const Plant *s, Answer answer) {
    Plant next = *s;
    if (due(s, answer)) plant_sample(&next, 0);
    else if (answer >= SETTLED) plant_settle(&next);
    else plant_rates(s, s->value + AT_STATE, next.value + AT_RATE, next.imbalance, 0);
    return next;
}

/* Which bound a stuck hinge is closer to: +1 the upper one. */
static int closer_bound(const Plant *s, int j) {
    double upper[N_JOINTS], lower[N_JOINTS];
    model_breakaway(s->value + AT_STATE, s->value + AT_TORQUE, s->value + AT_PARAMETER, upper, lower);
    return upper[j] - s->imbalance[j] < s->imbalance[j] - lower[j] ? 1 : -1;
}

#ifdef MODEL_CONTROLLER
static PidSlopes slopes(const Plant *s, int j) {
    const double *v = s->value;
    double error = v[AT_REFERENCE + j] - v[AT_STATE + j] - s->sensor_error[j];
    return pid_slopes(&s->pid, v + AT_GAIN, j, error, v[AT_FEEDFORWARD + j]);
}

static double torque_forward(const Plant *s, const double *seed, const double *dx, double dholding, int j) {
    PidSlopes d = slopes(s, j);
    const double *gain = seed + AT_GAIN + j;
    return d.error * (seed[AT_REFERENCE + j] - dx[j]) + d.feedforward * seed[AT_FEEDFORWARD + j] + d.Kp * gain[PID_KP] +
           d.Kd * gain[PID_KD] + d.Ki * gain[PID_KI] + d.limit * gain[PID_LIMIT] + d.integral * dholding;
}

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
typedef int sensitivities_are_left_out;
#endif

#include "plant.h"

#include "equilibrium.h"
#include "fused.h"

#include <math.h>
#include <string.h>

/* ---- mechanics ------------------------------------------------------------------------------- */

void plant_rates(const Plant *s, const double *x, double *dx, double *imbalance, double *friction) {
    const double *u = s->value + AT_TORQUE, *p = s->value + AT_PARAMETER;
#ifdef HAS_FUSED
    if (fused_here()) {
        fused_rates(x, u, p, s->mode, dx, imbalance, friction);
        return;
    }
#endif
    model_rates(x, u, p, s->mode, dx, imbalance, friction);
}

/* How far each hinge is from leaving its mode; negative when it has left it. */
void plant_margins(const Plant *s, const double *x, const double *imbalance, double margin[N_JOINTS]) {
    double upper[N_JOINTS], lower[N_JOINTS];
    int j, stuck = 0;
    for (j = 0; j < N_JOINTS; ++j) stuck |= s->mode[j] == 0;
    if (stuck) model_breakaway(x, s->value + AT_TORQUE, s->value + AT_PARAMETER, s->mode, upper, lower);
    for (j = 0; j < N_JOINTS; ++j) {
        if (!model_sticking[j]) margin[j] = HUGE_VAL;
        else if (s->mode[j] != 0) margin[j] = s->mode[j] * x[N_COORDINATES + j];
        else margin[j] = fmin(upper[j] - imbalance[j], imbalance[j] - lower[j]);
    }
}

double plant_tolerance(const Plant *s, int j) { return s->mode[j] != 0 ? 1e-9 : 1e-6; }

/* Hinges without dry friction slide as they move. */
static void follow_speeds(Plant *s) {
    int j;
    for (j = 0; j < N_JOINTS; ++j)
        if (!model_sticking[j]) s->mode[j] = s->value[AT_STATE + N_COORDINATES + j] < 0 ? -1 : 1;
}

/* Stuck hinges are released, the most overloaded first. */
void plant_settle(Plant *s) {
    double *x = s->value + AT_STATE, margin[N_JOINTS];
    int j, round;
    follow_speeds(s);
    s->unsettled = 0;
    for (round = 0; round <= N_JOINTS; ++round) {
        int worst = -1;
        plant_rates(s, x, s->value + AT_RATE, s->imbalance, 0);
        plant_margins(s, x, s->imbalance, margin);
        for (j = 0; j < N_JOINTS; ++j)
            if (s->mode[j] == 0 && margin[j] < 0 && (worst < 0 || margin[j] < margin[worst])) worst = j;
        if (worst < 0) return;
        s->mode[worst] = s->imbalance[worst] > 0 ? 1 : -1;
    }
}

int plant_switch(Plant *s) {
    double *x = s->value + AT_STATE, before[N_JOINTS], margin[N_JOINTS];
    int j, changed = 0;
    memcpy(before, s->mode, sizeof before);
    plant_rates(s, x, s->value + AT_RATE, s->imbalance, 0);
    plant_margins(s, x, s->imbalance, margin);
    for (j = 0; j < N_JOINTS; ++j)
        if (model_sticking[j] && s->mode[j] != 0 && margin[j] + plant_tolerance(s, j) <= 0) {
            s->mode[j] = 0;
            x[N_COORDINATES + j] = 0;
        }
    plant_settle(s);
    for (j = 0; j < N_JOINTS; ++j) changed |= s->mode[j] != before[j];
    return changed;
}

/* ---- controller ------------------------------------------------------------------------------ */

#ifdef MODEL_CONTROLLER
double plant_next_sample(const Plant *s) { return pid_next_sample(&s->pid, s->value + AT_GAIN); }

int plant_sample_due(const Plant *s, double time) { return pid_due(&s->pid, s->value + AT_GAIN, time); }

int plant_sample_before(const Plant *s, double time) {
    return plant_next_sample(s) < time - pid_tolerance(s->value + AT_GAIN);
}

void plant_command(Plant *s, double late) {
    double *v = s->value, input[N_INPUTS], seen[N_JOINTS];
    int i;
    for (i = 0; i < N_INPUTS; ++i) input[i] = v[i] + late * s->input_rate[i];
    for (i = 0; i < N_JOINTS; ++i) seen[i] = v[AT_STATE + i] + s->sensor_error[i];
    pid_sample(&s->pid, v + AT_GAIN, input + AT_REFERENCE, input + AT_FEEDFORWARD, seen, v + AT_TORQUE);
    s->unsettled = 1;
}

static void start_position(const Plant *s, double *x) {
    int j;
    for (j = 0; j < N_JOINTS; ++j) x[j] = s->value[AT_REFERENCE + j] + s->value[AT_START_ERROR + j];
}

static void start_torque(Plant *s, const double *holding) {
    pid_start(&s->pid, holding);
    memcpy(s->value + AT_TORQUE, holding, N_JOINTS * sizeof *holding);
}
#elif defined MODEL_SERVO
double plant_next_sample(const Plant *s) { return servo_next_sample(&s->servo); }

int plant_sample_due(const Plant *s, double time) { return servo_due(&s->servo, time); }

int plant_sample_before(const Plant *s, double time) { return plant_next_sample(s) < time - SAMPLE_TOLERANCE; }

void plant_command(Plant *s, double late) {
    double *v = s->value, input[N_INPUTS], seen[N_JOINTS];
    int i;
    for (i = 0; i < N_INPUTS; ++i) input[i] = v[i] + late * s->input_rate[i];
    for (i = 0; i < N_JOINTS; ++i) seen[i] = v[AT_STATE + i] + s->sensor_error[i];
    servo_sample(&s->servo, v + AT_SERVO, input, seen, v + AT_STATE + N_COORDINATES, v + AT_TORQUE);
    s->unsettled = 1;
}

static void start_position(const Plant *s, double *x) { memcpy(x, s->value + AT_START, N_JOINTS * sizeof *x); }

static void start_torque(Plant *s, const double *holding) {
    servo_start(&s->servo);
    memcpy(s->value + AT_TORQUE, holding, N_JOINTS * sizeof *holding);
}
#else
static void start_position(const Plant *s, double *x) { memcpy(x, s->value + AT_REFERENCE, N_JOINTS * sizeof *x); }

#ifdef MODEL_DRIVE
static Motion motion(const Plant *s) {
    const double *x = s->value + AT_STATE;
    Motion now = {s->time, x, x + N_COORDINATES};
    return now;
}

/* What the drives receive is sampled where it changes. */
double plant_next_sample(const Plant *s) { return plant_sample_due(s, s->time) ? s->time : HUGE_VAL; }

int plant_sample_due(const Plant *s, double time) {
    return (void)time, drive_due(&s->drive, s->value + AT_COMMAND, s->value + AT_TORQUE);
}

int plant_sample_before(const Plant *s, double time) { return plant_next_sample(s) < time; }

void plant_command(Plant *s, double late) {
    const Motion now = motion(s);
    (void)late;
    drive_take(&s->drive, s->value + AT_COMMAND, &now, s->value + AT_TORQUE);
    s->unsettled = 1;
}

static void start_torque(Plant *s, const double *holding) {
    const Motion now = motion(s);
    memcpy(s->value + AT_FEEDFORWARD, holding, N_JOINTS * sizeof *holding);
    drive_start(&s->drive, s->value + AT_COMMAND, &now, s->value + AT_TORQUE);
}
#else
/* The torque is an input: nothing is sampled. */
double plant_next_sample(const Plant *s) { return (void)s, HUGE_VAL; }

int plant_sample_due(const Plant *s, double time) { return (void)s, (void)time, 0; }

int plant_sample_before(const Plant *s, double time) { return (void)s, (void)time, 0; }

void plant_command(Plant *s, double late) { (void)s, (void)late; }

static void start_torque(Plant *s, const double *holding) {
    memcpy(s->value + AT_FEEDFORWARD, holding, N_JOINTS * sizeof *holding);
}
#endif
#endif

void plant_sample(Plant *s, double late) {
    plant_command(s, late);
    plant_settle(s);
}

/* ---- life cycle ------------------------------------------------------------------------------ */

void plant_reset(Plant *s) {
    memset(s, 0, sizeof *s);
    memcpy(s->value, model_starts, sizeof s->value);
    s->refinement = 1;
}

static int all_finite(const double *values, int n) {
    int i;
    for (i = 0; i < n; ++i)
        if (!isfinite(values[i])) return 0;
    return 1;
}

int plant_indefinite(const Plant *s) {
    double pivot[N_COORDINATES];
    int i;
    model_pivots(s->value + AT_STATE, s->value + AT_PARAMETER, pivot);
    for (i = 0; i < N_COORDINATES; ++i)
        if (!(pivot[i] > 0)) return 1;
    return 0;
}

int plant_sound(const Plant *s) {
    int j;
    for (j = 0; j < N_JOINTS; ++j)
        if (s->mode[j] != 0 && fabs(s->mode[j]) != 1) return 0;
#ifdef MODEL_CONTROLLER
    if (!(s->value[AT_GAIN + PID_PERIOD] > 0) || !pid_sound(&s->pid)) return 0;
#elif defined MODEL_SERVO
    if (s->servo.ticks < 0 || !all_finite(s->servo.integral, N_JOINTS)) return 0;
    if (!all_finite(s->servo.command[0], SERVO_HISTORY * N_JOINTS)) return 0;
#elif defined MODEL_DRIVE
    if (!all_finite(s->drive.law, N_COMMAND) || !all_finite(s->drive.torque, N_JOINTS)) return 0;
#endif
    return all_finite(s->value, N_VALUES) && all_finite(s->input_rate, N_INPUTS) && isfinite(s->time) &&
           s->value[AT_STEP] > 0 && s->refinement > 0 && s->refinement <= 1 && s->trials >= 0;
}

int plant_initialise(Plant *s) {
    double *x = s->value + AT_STATE, *v = x + N_COORDINATES, force[N_COORDINATES];
    int j, lost;
    memset(x, 0, N_STATES * sizeof *x);
    start_position(s, x);
    lost = equilibrium(s->value + AT_PARAMETER, x, force);
    model_start(x, force, s->value + AT_PARAMETER, v + N_COORDINATES);
    for (j = 0; j < N_JOINTS; ++j) {
        v[j] = s->value[AT_START_SPEED + j];
        s->mode[j] = v[j] > 0 ? 1 : v[j] < 0 ? -1 : 0;
    }
    s->time = 0;
    start_torque(s, force);
    plant_settle(s);
    return lost || !all_finite(x, N_STATES) || !all_finite(force, N_COORDINATES);
}

/* ---- values on demand ------------------------------------------------------------------------ */

int plant_group(unsigned reference) {
    if (reference < AT_RATE) return 0;
    if (reference < AT_TIP) return SHOW_RATES;
    if (reference < AT_SHOWN) return SHOW_TIP;
    if (reference < AT_FRICTION) return SHOW_MOTION;
    if (reference < AT_PARAMETER) return SHOW_RATES | SHOW_LAWS;
    return 0;
}

/* What follows from state, torque and modes. */
static void show(Plant *s, int groups) {
    double *v = s->value, *x = v + AT_STATE;
    int j;
    if (groups & SHOW_TIP) model_tip(x, v + AT_TIP);
    if (groups & SHOW_MOTION) model_shown(x, v + AT_SHOWN);
    if (groups & SHOW_RATES) plant_rates(s, x, v + AT_RATE, s->imbalance, v + AT_FRICTION);
    if (!(groups & SHOW_LAWS)) return;
    for (j = 0; j < N_JOINTS; ++j)
        if (s->mode[j] == 0) v[AT_FRICTION + j] += s->imbalance[j];
    model_laws(x, v + AT_TORQUE, v + AT_PARAMETER, s->mode, v + AT_RATE, v + AT_LAW);
    plant_margins(s, x, s->imbalance, v + AT_INDICATOR);
    for (j = 0; j < N_JOINTS; ++j)
        v[AT_INDICATOR + j] = model_sticking[j] ? v[AT_INDICATOR + j] + plant_tolerance(s, j) : 1;
}

void plant_show(Plant *s, int groups, Answer answer) {
    int due = answer != HELD && plant_sample_due(s, s->time);
    follow_speeds(s);
    if (groups & SHOW_LAWS && answer != HELD) groups |= SHOW_RATES;
    if (groups & SHOW_RATES && (due || (answer >= SETTLED && s->unsettled))) {
        Plant next = *s;
        if (due) plant_sample(&next, 0);
        else plant_settle(&next);
        show(&next, groups);
        memcpy(s->value + AT_RATE, next.value + AT_RATE, (AT_PARAMETER - AT_RATE) * sizeof *s->value);
        s->unsettled = 1; /* the rates shown are not those of the modes that still hold */
        return;
    }
    show(s, groups);
}

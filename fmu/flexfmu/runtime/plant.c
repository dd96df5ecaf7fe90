#include "plant.h"

#include "equilibrium.h"

#include <math.h>
#include <string.h>

enum { MAX_EVENTS = 64, MAX_BISECTIONS = 60 };
static const double TIME_TOLERANCE = 1e-12; /* a shorter step is none [s] */

/* ---- mechanics ------------------------------------------------------------------------------- */

static void rates(const Plant *s, const double *x, double *dx, double *imbalance, double *friction) {
    const double *arg[MODEL_SZ_ARG] = {x, s->value + AT_TORQUE, s->value + AT_PARAMETER, s->mode};
    double *res[MODEL_SZ_RES] = {dx, imbalance, friction};
    double w[MODEL_SZ_W];
    model_rates(arg, res, 0, w, 0);
}

static void breakaway(const Plant *s, const double *x, double *upper, double *lower) {
    const double *arg[MODEL_SZ_ARG] = {x, s->value + AT_TORQUE, s->value + AT_PARAMETER};
    double *res[MODEL_SZ_RES] = {upper, lower};
    double w[MODEL_SZ_W];
    model_breakaway(arg, res, 0, w, 0);
}

static void laws(const Plant *s, const double *x, const double *dx, double *force) {
    const double *arg[MODEL_SZ_ARG] = {x, s->value + AT_TORQUE, s->value + AT_PARAMETER, s->mode, dx};
    double *res[MODEL_SZ_RES] = {force};
    double w[MODEL_SZ_W];
    model_laws(arg, res, 0, w, 0);
}

/* The laws' own states at rest under the torques that hold the arm. */
static void start(const Plant *s, const double *holding, double *x) {
    const double *arg[MODEL_SZ_ARG] = {x, holding, s->value + AT_PARAMETER};
    double *res[MODEL_SZ_RES] = {x + 2 * N_COORDINATES};
    double w[MODEL_SZ_W];
    model_start(arg, res, 0, w, 0);
}

static void tip(const double *x, double *position) {
    const double *arg[MODEL_SZ_ARG] = {x};
    double *res[MODEL_SZ_RES] = {position};
    double w[MODEL_SZ_W];
    model_tip(arg, res, 0, w, 0);
}

/* ---- friction: which hinges stick ------------------------------------------------------------ */

/* How far each hinge is from leaving its mode; negative when it has left it. */
static void margins(const Plant *s, const double *x, const double *imbalance, double *margin) {
    double upper[N_JOINTS], lower[N_JOINTS];
    int j, stuck = 0;
    for (j = 0; j < N_JOINTS; ++j) stuck |= s->mode[j] == 0;
    if (stuck) breakaway(s, x, upper, lower);
    for (j = 0; j < N_JOINTS; ++j) {
        if (!model_sticking[j]) margin[j] = HUGE_VAL;
        else if (s->mode[j] != 0) margin[j] = s->mode[j] * x[N_COORDINATES + j];
        else margin[j] = fmin(upper[j] - imbalance[j], imbalance[j] - lower[j]);
    }
}

/* Stuck hinges are released, the most overloaded first. */
void plant_settle(Plant *s) {
    double *x = s->value + AT_STATE, margin[N_JOINTS];
    int j, round;
    for (j = 0; j < N_JOINTS; ++j)
        if (!model_sticking[j]) s->mode[j] = x[N_COORDINATES + j] < 0 ? -1 : 1;
    for (round = 0; round <= N_JOINTS; ++round) {
        int worst = -1;
        rates(s, x, s->value + AT_RATE, s->imbalance, 0);
        margins(s, x, s->imbalance, margin);
        for (j = 0; j < N_JOINTS; ++j)
            if (s->mode[j] == 0 && margin[j] < 0 && (worst < 0 || margin[j] < margin[worst])) worst = j;
        if (worst < 0) return;
        s->mode[worst] = s->imbalance[worst] > 0 ? 1 : -1;
    }
}

/* ---- time integration ------------------------------------------------------------------------ */

/* One step of the classical Runge-Kutta method with the modes as they are. */
static void runge_kutta(const Plant *s, double h, double *x1) {
    const double *x0 = s->value + AT_STATE, *k1 = s->value + AT_RATE;
    double k2[N_STATES], k3[N_STATES], k4[N_STATES], x[N_STATES];
    int i;
    for (i = 0; i < N_STATES; ++i) x[i] = x0[i] + h / 2 * k1[i];
    rates(s, x, k2, 0, 0);
    for (i = 0; i < N_STATES; ++i) x[i] = x0[i] + h / 2 * k2[i];
    rates(s, x, k3, 0, 0);
    for (i = 0; i < N_STATES; ++i) x[i] = x0[i] + h * k3[i];
    rates(s, x, k4, 0, 0);
    for (i = 0; i < N_STATES; ++i) x1[i] = x0[i] + h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
}

typedef struct {
    double x[N_STATES], rate[N_STATES], imbalance[N_JOINTS], margin[N_JOINTS];
} Trial;

/* A step of length h and the smallest margin at its end. */
static double try_step(const Plant *s, double h, Trial *t) {
    double least = HUGE_VAL;
    int j;
    runge_kutta(s, h, t->x);
    rates(s, t->x, t->rate, t->imbalance, 0);
    margins(s, t->x, t->imbalance, t->margin);
    for (j = 0; j < N_JOINTS; ++j) least = fmin(least, t->margin[j]);
    return least;
}

/* Shorten a step at whose end a margin is negative to just behind the first crossing (Illinois). */
static double locate(const Plant *s, double h, double end, Trial *t) {
    const double close_enough = 1e-13 * end;
    double a = 0, b = h, fa = -end, fb = end, start[N_JOINTS];
    int j, i, kept = 0;
    margins(s, s->value + AT_STATE, s->imbalance, start);
    for (j = 0; j < N_JOINTS; ++j)
        if (start[j] > 0) fa = fmin(fa, start[j]);
    for (i = 0; i < MAX_BISECTIONS && b - a > 1e-14 * h && fb < close_enough; ++i) {
        double c = i % 8 == 7 ? (a + b) / 2 : (a * fb - b * fa) / (fb - fa);
        double fc = try_step(s, c, t);
        if (fc < 0) {
            b = c, fb = fc;
            if (kept == -1) fa /= 2; /* the same end moved twice: pull the other one in */
            kept = -1;
        } else {
            a = c, fa = fc;
            if (kept == 1) fb /= 2;
            kept = 1;
        }
    }
    try_step(s, b, t);
    return b;
}

/* Hinges that came to rest stick; hinges whose reaction exceeds the level are released by plant_settle. */
static void switch_modes(Plant *s, const Trial *t) {
    double *x = s->value + AT_STATE;
    int j;
    for (j = 0; j < N_JOINTS; ++j)
        if (model_sticking[j] && s->mode[j] != 0 && t->margin[j] < 0) {
            s->mode[j] = 0;
            x[N_COORDINATES + j] = 0;
        }
    plant_settle(s);
}

/* Forward by h with the torque held; friction events inside are located and stepped over exactly. */
static void substep(Plant *s, double h) {
    double *x = s->value + AT_STATE;
    Trial t;
    int events;
    for (events = 0; h > 0; ++events) {
        double end = try_step(s, h, &t), done = h;
        if (end < 0 && events < MAX_EVENTS) done = locate(s, h, end, &t);
        memcpy(x, t.x, sizeof t.x);
        memcpy(s->value + AT_RATE, t.rate, sizeof t.rate);
        memcpy(s->imbalance, t.imbalance, sizeof t.imbalance);
        if (end < 0) switch_modes(s, &t);
        h -= done;
    }
}

static void integrate(Plant *s, double duration) {
    double h_max = s->value[AT_STEP];
    int i, n = (int)ceil(duration / h_max - 1e-6);
    if (n < 1) n = 1;
    for (i = 0; i < n; ++i) substep(s, duration / n);
}

/* ---- controller ------------------------------------------------------------------------------ */

#ifdef MODEL_CONTROLLER
double plant_next_sample(const Plant *s) { return pid_next_sample(&s->pid); }

int plant_sample_due(const Plant *s, double time) { return pid_due(&s->pid, time); }

void plant_sample(Plant *s, double late) {
    double *v = s->value, input[N_INPUTS];
    int i;
    for (i = 0; i < N_INPUTS; ++i) input[i] = v[i] + late * s->input_rate[i];
    pid_sample(&s->pid, v + AT_KP, input + AT_REFERENCE, input + AT_FEEDFORWARD, v + AT_STATE, v + AT_TORQUE);
    plant_settle(s);
}

static void start_torque(Plant *s, const double *holding) {
    pid_start(&s->pid, holding);
    plant_sample(s, 0);
}
#elif defined MODEL_SERVO
double plant_next_sample(const Plant *s) { return servo_next_sample(&s->servo); }

int plant_sample_due(const Plant *s, double time) { return servo_due(&s->servo, time); }

void plant_sample(Plant *s, double late) {
    double *v = s->value, input[N_INPUTS];
    int i;
    for (i = 0; i < N_INPUTS; ++i) input[i] = v[i] + late * s->input_rate[i];
    servo_sample(&s->servo, v + AT_SERVO, input, v + AT_STATE, v + AT_STATE + N_COORDINATES, v + AT_TORQUE);
    plant_settle(s);
}

static void start_torque(Plant *s, const double *holding) {
    (void)holding;
    servo_start(&s->servo);
    plant_sample(s, 0);
}
#else
/* The torque is an input: nothing is sampled. */
double plant_next_sample(const Plant *s) { return (void)s, HUGE_VAL; }

int plant_sample_due(const Plant *s, double time) { return (void)s, (void)time, 0; }

void plant_sample(Plant *s, double late) { (void)s, (void)late; }

static void start_torque(Plant *s, const double *holding) {
    memcpy(s->value + AT_FEEDFORWARD, holding, N_JOINTS * sizeof *holding);
    plant_settle(s);
}
#endif

/* ---- life cycle ------------------------------------------------------------------------------ */

void plant_reset(Plant *s) {
    memset(s, 0, sizeof *s);
    memcpy(s->value, model_starts, sizeof s->value);
}

int plant_initialise(Plant *s) {
    double *x = s->value + AT_STATE, force[N_COORDINATES];
    int lost;
    memset(x, 0, N_STATES * sizeof *x);
#ifdef MODEL_SERVO
    memcpy(x, s->value + AT_START, N_JOINTS * sizeof *x);
#else
    memcpy(x, s->value + AT_REFERENCE, N_JOINTS * sizeof *x);
#endif
    lost = equilibrium(s->value + AT_PARAMETER, x, force);
    memset(s->mode, 0, sizeof s->mode);
    start(s, force, x);
    s->time = 0;
    start_torque(s, force);
    return lost;
}

int plant_run(Plant *s, double until) {
    int i;
    if (until > s->time + TIME_TOLERANCE) integrate(s, until - s->time);
    if (until > s->time) s->time = until;
    for (i = 0; i < N_STATES; ++i)
        if (!isfinite(s->value[AT_STATE + i])) return 1;
    return 0;
}

int plant_advance(Plant *s, double duration) {
    double end = s->time + duration, start = s->time;
    plant_settle(s);
    while (plant_sample_due(s, end)) {
        double tick = plant_next_sample(s);
        if (plant_run(s, tick)) return 1;
        s->time = tick;
        plant_sample(s, tick - start);
    }
    if (plant_run(s, end)) return 1;
    memset(s->input_rate, 0, sizeof s->input_rate);
    return 0;
}

/* ---- model exchange -------------------------------------------------------------------------- */

void plant_rates(Plant *s) {
    int j;
    for (j = 0; j < N_JOINTS; ++j)
        if (!model_sticking[j]) s->mode[j] = s->value[AT_STATE + N_COORDINATES + j] < 0 ? -1 : 1;
    rates(s, s->value + AT_STATE, s->value + AT_RATE, s->imbalance, 0);
}

/* A root is accepted with this tolerance: rad/s while sliding, N m while stuck. */
static double tolerance(const Plant *s, int j) { return s->mode[j] != 0 ? 1e-9 : 1e-6; }

/* Indicators from the imbalance at the present state. */
static void indicators(const Plant *s, const double *imbalance, double indicator[N_JOINTS]) {
    int j;
    margins(s, s->value + AT_STATE, imbalance, indicator);
    for (j = 0; j < N_JOINTS; ++j)
        indicator[j] = model_sticking[j] ? indicator[j] + tolerance(s, j) : 1;
}

void plant_indicators(const Plant *s, double indicator[N_JOINTS]) {
    double dx[N_STATES], imbalance[N_JOINTS];
    rates(s, s->value + AT_STATE, dx, imbalance, 0);
    indicators(s, imbalance, indicator);
}

int plant_switch(Plant *s) {
    double *x = s->value + AT_STATE, before[N_JOINTS], indicator[N_JOINTS];
    int j, changed = 0;
    memcpy(before, s->mode, sizeof before);
    plant_indicators(s, indicator);
    for (j = 0; j < N_JOINTS; ++j)
        if (model_sticking[j] && s->mode[j] != 0 && indicator[j] <= 0) {
            s->mode[j] = 0;
            x[N_COORDINATES + j] = 0;
            changed = 1;
        }
    plant_settle(s);
    for (j = 0; j < N_JOINTS; ++j) changed |= s->mode[j] != before[j];
    return changed;
}

void plant_outputs(Plant *s) {
    const double *x = s->value + AT_STATE;
    double *friction = s->value + AT_FRICTION;
    int j;
    tip(x, s->value + AT_TIP);
    rates(s, x, s->value + AT_RATE, s->imbalance, friction);
    for (j = 0; j < N_JOINTS; ++j)
        if (s->mode[j] == 0) friction[j] += s->imbalance[j];
    laws(s, x, s->value + AT_RATE, s->value + AT_LAW);
    indicators(s, s->imbalance, s->value + AT_INDICATOR);
}

/* ---- sensitivities --------------------------------------------------------------------------- */

#ifdef MODEL_DERIVATIVES
/* d(torque of joint j)/d(error) at a sample of the controller. */
static double loop_gain(const Plant *s, int j) {
#ifdef MODEL_CONTROLLER
    const double *v = s->value + j;
    return v[AT_KP] + v[AT_KD] / PERIOD + v[AT_KI] * PERIOD;
#else
    return (void)s, (void)j, 0;
#endif
}

void plant_directional(const Plant *s, const double seed[N_VALUES], int sampling, double out[N_VALUES]) {
    const double *x = s->value + AT_STATE;
    double w[MODEL_SZ_W], y[N_STATES + N_JOINTS], torque[N_JOINTS];
    int j;
    memcpy(out, seed, N_VALUES * sizeof *out);
    for (j = 0; j < N_JOINTS; ++j)
        torque[j] = sampling ? loop_gain(s, j) * (seed[AT_REFERENCE + j] - seed[AT_STATE + j]) + seed[AT_FEEDFORWARD + j]
                             : seed[AT_TORQUE + j];
    {
        const double *arg[MODEL_SZ_ARG] = {x, s->value + AT_TORQUE, s->value + AT_PARAMETER, s->mode,
                                           seed + AT_STATE, torque, seed + AT_PARAMETER};
        double *res[MODEL_SZ_RES] = {y};
        model_rates_forward(arg, res, 0, w, 0);
    }
    memcpy(out + AT_RATE, y, N_STATES * sizeof *y);
    memcpy(out + AT_FRICTION, y + N_STATES, N_JOINTS * sizeof *y);
    memcpy(out + AT_TORQUE, torque, sizeof torque);
    {
        const double *arg[MODEL_SZ_ARG] = {x, seed + AT_STATE};
        double *res[MODEL_SZ_RES] = {out + AT_TIP};
        model_tip_forward(arg, res, 0, w, 0);
    }
}

void plant_adjoint(const Plant *s, const double seed[N_VALUES], int sampling, double out[N_VALUES]) {
    const double *x = s->value + AT_STATE;
    double w[MODEL_SZ_W], y[N_STATES + N_JOINTS], by_state[N_STATES], by_torque[N_JOINTS], by_parameter[N_PARAMETERS];
    double from_tip[N_STATES];
    int i, j;
    memcpy(out, seed, N_VALUES * sizeof *out);
    memset(out + AT_RATE, 0, (AT_PARAMETER - AT_RATE) * sizeof *out);
    memcpy(y, seed + AT_RATE, N_STATES * sizeof *y);
    memcpy(y + N_STATES, seed + AT_FRICTION, N_JOINTS * sizeof *y);
    {
        const double *arg[MODEL_SZ_ARG] = {x, s->value + AT_TORQUE, s->value + AT_PARAMETER, s->mode, y};
        double *res[MODEL_SZ_RES] = {by_state, by_torque, by_parameter};
        model_rates_adjoint(arg, res, 0, w, 0);
    }
    {
        const double *arg[MODEL_SZ_ARG] = {x, seed + AT_TIP};
        double *res[MODEL_SZ_RES] = {from_tip};
        model_tip_adjoint(arg, res, 0, w, 0);
    }
    for (i = 0; i < N_STATES; ++i) out[AT_STATE + i] += by_state[i] + from_tip[i];
    for (i = 0; i < N_PARAMETERS; ++i) out[AT_PARAMETER + i] += by_parameter[i];
    for (j = 0; j < N_JOINTS; ++j) {
        double torque = by_torque[j] + seed[AT_TORQUE + j];
        if (sampling) {
            out[AT_REFERENCE + j] += loop_gain(s, j) * torque;
            out[AT_STATE + j] -= loop_gain(s, j) * torque;
            out[AT_FEEDFORWARD + j] += torque;
        } else {
            out[AT_TORQUE + j] += torque;
        }
    }
}
#endif

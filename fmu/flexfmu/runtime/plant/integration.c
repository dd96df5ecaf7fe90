/* Time integration: the classical Runge-Kutta method; friction events are located and stepped over exactly. */
#include "plant.h"

#include <math.h>
#include <string.h>

enum { MAX_EVENTS = 64, SMOOTH = 8 }; /* trials that suffice where margins have slopes */
static const double TIME_TOLERANCE = 1e-12; /* a shorter step is none [s] */

/* One step with the modes as they are. */
static void runge_kutta(const Plant *s, double h, double *x1) {
    const double *x0 = s->value + AT_STATE, *k1 = s->value + AT_RATE;
    double k2[N_STATES], k3[N_STATES], k4[N_STATES], x[N_STATES];
    int i;
    for (i = 0; i < N_STATES; ++i) x[i] = x0[i] + h / 2 * k1[i];
    plant_rates(s, x, k2, 0, 0);
    for (i = 0; i < N_STATES; ++i) x[i] = x0[i] + h / 2 * k2[i];
    plant_rates(s, x, k3, 0, 0);
    for (i = 0; i < N_STATES; ++i) x[i] = x0[i] + h * k3[i];
    plant_rates(s, x, k4, 0, 0);
    for (i = 0; i < N_STATES; ++i) x1[i] = x0[i] + h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
}

typedef struct {
    double x[N_STATES], rate[N_STATES], imbalance[N_JOINTS], margin[N_JOINTS];
    double taken; /* its length [s] */
} Trial;

/* A step of length h and the smallest margin at its end. */
static double try_step(Plant *s, double h, Trial *t) {
    double least = HUGE_VAL;
    int j;
    ++s->trials;
    t->taken = h;
    runge_kutta(s, h, t->x);
    plant_rates(s, t->x, t->rate, t->imbalance, 0);
    plant_margins(s, t->x, t->imbalance, t->margin);
    for (j = 0; j < N_JOINTS; ++j) least = fmin(least, t->margin[j]);
    return least;
}

/* Where in (0, h) a cubic with end values f0 > 0 > f1 and slopes d0, d1 is zero. */
static double cubic_root(double f0, double d0, double f1, double d1, double h) {
    double a = 0, b = 1;
    int i;
    for (i = 0; i < 40; ++i) {
        double u = (a + b) / 2, v = 1 - u;
        double f = f0 * v * v * (1 + 2 * u) + f1 * u * u * (3 - 2 * u) + h * u * v * (d0 * v - d1 * u);
        if (f > 0) a = u;
        else b = u;
    }
    return b * h;
}

/* The first crossing as far as both ends of the step tell. */
static double first_guess(const Plant *s, double h, const Trial *t) {
    double start[N_JOINTS], c = h;
    int j;
    plant_margins(s, s->value + AT_STATE, s->imbalance, start);
    for (j = 0; j < N_JOINTS; ++j) {
        double mode = s->mode[j], root = 0, f0 = start[j], f1 = t->margin[j];
        if (!(f1 < 0)) continue;
        if (f0 > 0 && mode != 0) {
            const double *a0 = s->value + AT_RATE + N_COORDINATES, *a1 = t->rate + N_COORDINATES;
            root = cubic_root(f0, mode * a0[j], f1, mode * a1[j], h);
        } else if (f0 > 0) root = h * f0 / (f0 - f1);
        c = fmin(c, root);
    }
    return fmax(c, 1e-14 * h);
}

/* Shorten a step at whose end a margin is negative to just behind the first crossing: the guess, then regula falsi
   (Illinois) aimed a little behind the root. A margin that falls at once, as where a stiff hinge runs away, has no
   slope: there the interval is halved, to a width whose square, the error of the position, is nothing. */
static double locate(Plant *s, double h, double end, Trial *t) {
    const double close_enough = 1e-10 * end;
    double a = 0, b = h, fa = -end, fb = end, start[N_JOINTS], c = first_guess(s, h, t);
    int j, i, kept = 0;
    plant_margins(s, s->value + AT_STATE, s->imbalance, start);
    for (j = 0; j < N_JOINTS; ++j)
        if (start[j] > 0) fa = fmin(fa, start[j]);
    for (i = 0; b - a > (i < SMOOTH ? 1e-14 : 1e-5) * h && fb < close_enough; ++i) {
        double fc = try_step(s, c, t), slope = (fb - fa) / (b - a);
        if (fc < 0) {
            b = c, fb = fc;
            if (kept == -1) fa /= 2; /* the same end moved twice: pull the other one in */
            kept = -1;
        } else {
            a = c, fa = fc;
            if (kept == 1) fb /= 2;
            kept = 1;
        }
        for (j = 0; j < N_JOINTS; ++j)
            if (t->margin[j] == fc && s->mode[j] != 0) slope = s->mode[j] * t->rate[N_COORDINATES + j];
        c -= (fc - close_enough / 2) / slope;
        if (i > 3 || !(c > a && c < b)) c = i + 1 >= SMOOTH ? (a + b) / 2 : (a * fb - b * fa) / (fb - fa);
    }
    if (t->taken != b) try_step(s, b, t);
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

/* Forward by h with the torque held. */
void plant_substep(Plant *s, double h) {
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

int plant_steps(const Plant *s, double duration) {
    int n = (int)ceil(duration / (s->refinement * s->value[AT_STEP]) - 1e-6);
    return n < 1 ? 1 : n;
}

int plant_run(Plant *s, double until) {
    double duration = until - s->time;
    int i, n;
    if (duration > TIME_TOLERANCE) {
        if (s->unsettled) plant_settle(s);
        n = plant_steps(s, duration);
        for (i = 0; i < n; ++i) plant_substep(s, duration / n);
    }
    if (until > s->time) s->time = until;
    for (i = 0; i < N_STATES; ++i)
        if (!isfinite(s->value[AT_STATE + i])) return 1;
    return 0;
}

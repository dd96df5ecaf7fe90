/* The solver for a vector of runs. Where a hinge sticks or slides within a step, that run takes the step by itself. */
#include "batch.h"

#include <math.h>
#include <string.h>

#include "lanes.h"
#define NAME(f) MODEL_PASTE(MODEL_PREFIX, MODEL_PASTE(LANES_NAME, f))
#define PIECE(f) lanes_##f
#include "model_rates.h"

/* Scalar code after vector code: without this the processor joins both register halves, several times slower. */
LANE_FUNCTION void leave_vectors(void) { __builtin_ia32_vzeroupper(); }

typedef struct {
    real x[N_STATES], rate[N_STATES], imbalance[N_JOINTS], mode[N_JOINTS], u[N_JOINTS], p[N_PARAMETERS];
} Group;

static void load(Group *g, const Plant *s, int lane) {
    int i;
    for (i = 0; i < N_STATES; ++i) g->x[i][lane] = s->value[AT_STATE + i], g->rate[i][lane] = s->value[AT_RATE + i];
    for (i = 0; i < N_JOINTS; ++i) {
        g->imbalance[i][lane] = s->imbalance[i];
        g->mode[i][lane] = s->mode[i];
        g->u[i][lane] = s->value[AT_TORQUE + i];
    }
}

static void store(const Group *g, Plant *s, int lane) {
    int i;
    for (i = 0; i < N_STATES; ++i) s->value[AT_STATE + i] = g->x[i][lane], s->value[AT_RATE + i] = g->rate[i][lane];
    for (i = 0; i < N_JOINTS; ++i) s->imbalance[i] = g->imbalance[i][lane], s->mode[i] = g->mode[i][lane];
}

/* The least margin of every run at a state; see plant_margins. */
static real least_margin(const Group *g, const real *x, const real *imbalance) {
    real least = REAL(HUGE_VAL), upper[N_JOINTS], lower[N_JOINTS], zero = REAL(0.0);
    int j, l, stuck = 0;
    for (j = 0; j < N_JOINTS; ++j)
        for (l = 0; l < LANES; ++l) stuck |= g->mode[j][l] == 0;
    if (stuck) NAME(breakaway)(x, g->u, g->p, g->mode, upper, lower);
    for (j = 0; j < N_JOINTS; ++j) {
        real margin = g->mode[j] * x[N_COORDINATES + j];
        if (!model_sticking[j]) continue;
        if (stuck) {
            real up = upper[j] - imbalance[j], down = imbalance[j] - lower[j];
            margin = lanes_where(g->mode[j] == zero, R_FMIN(up, down), margin);
        }
        least = R_FMIN(least, margin);
    }
    return least;
}

static void rates(const Group *g, const real *x, real *dx, real *imbalance) {
    NAME(rates)(x, g->u, g->p, g->mode, dx, imbalance, 0);
}

/* Rates and modes under new torques. */
static void settle(Group *g, Plant *const *plants) {
    real least;
    int j, l;
    for (j = 0; j < N_JOINTS; ++j)
        if (!model_sticking[j])
            g->mode[j] = lanes_where(g->x[N_COORDINATES + j] < REAL(0.0), REAL(-1.0), REAL(1.0));
    rates(g, g->x, g->rate, g->imbalance);
    least = least_margin(g, g->x, g->imbalance);
    for (l = 0; l < LANES; ++l) {
        if (!(least[l] < 0)) continue; /* a stuck hinge gives way, or a sliding one stands exactly at its turn */
        store(g, plants[l], l);
        leave_vectors();
        plant_settle(plants[l]);
        load(g, plants[l], l);
    }
}

static void step(Group *g, Plant *const *plants, double h) {
    real k2[N_STATES], k3[N_STATES], k4[N_STATES], x[N_STATES], imbalance[N_JOINTS], least;
    const real half = REAL(h / 2), whole = REAL(h), sixth = REAL(h / 6), two = REAL(2.0);
    int i, l;
    for (i = 0; i < N_STATES; ++i) x[i] = g->x[i] + half * g->rate[i];
    rates(g, x, k2, 0);
    for (i = 0; i < N_STATES; ++i) x[i] = g->x[i] + half * k2[i];
    rates(g, x, k3, 0);
    for (i = 0; i < N_STATES; ++i) x[i] = g->x[i] + whole * k3[i];
    rates(g, x, k4, 0);
    for (i = 0; i < N_STATES; ++i) x[i] = g->x[i] + sixth * (g->rate[i] + two * k2[i] + two * k3[i] + k4[i]);
    rates(g, x, k2, imbalance);
    least = least_margin(g, x, imbalance);
    for (l = 0; l < LANES; ++l) {
        if (!(least[l] < 0)) continue;
        store(g, plants[l], l);
        leave_vectors();
        plant_substep(plants[l], h);
        load(g, plants[l], l);
        for (i = 0; i < N_STATES; ++i) x[i][l] = g->x[i][l], k2[i][l] = g->rate[i][l];
        for (i = 0; i < N_JOINTS; ++i) imbalance[i][l] = g->imbalance[i][l];
    }
    memcpy(g->x, x, sizeof x);
    memcpy(g->rate, k2, sizeof k2);
    memcpy(g->imbalance, imbalance, sizeof imbalance);
}

void LANES_ADVANCE(Plant *const *plants, double duration) {
    Group g;
    int i, l, n, unsettled = 0;
    if (!(duration > 1e-12)) return;
    for (l = 0; l < LANES; ++l) {
        load(&g, plants[l], l);
        for (i = 0; i < N_PARAMETERS; ++i) g.p[i][l] = plants[l]->value[AT_PARAMETER + i];
        unsettled |= plants[l]->unsettled;
    }
    if (unsettled) settle(&g, plants);
    n = plant_steps(plants[0], duration);
    for (i = 0; i < n; ++i) step(&g, plants, duration / n);
    for (l = 0; l < LANES; ++l) {
        store(&g, plants[l], l);
        plants[l]->unsettled = 0;
    }
    leave_vectors();
}

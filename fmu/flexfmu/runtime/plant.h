/* The simulated arm: its state, its digital controller, its solver. No globals, no allocation. */
#ifndef PLANT_H
#define PLANT_H

#include "model.h"

/* Every variable has a fixed place in `value`; the place is its FMI value reference. */
enum {
    AT_REFERENCE = 0,
    AT_FEEDFORWARD = AT_REFERENCE + N_JOINTS,
    AT_STATE = AT_FEEDFORWARD + N_JOINTS, /* q, then v */
    AT_TORQUE = AT_STATE + 2 * N_COORDINATES,
    AT_TIP = AT_TORQUE + N_JOINTS,
    AT_FRICTION = AT_TIP + 3,
    AT_PARAMETER = AT_FRICTION + N_JOINTS,
    AT_KP = AT_PARAMETER + N_PARAMETERS,
    AT_KD = AT_KP + N_JOINTS,
    AT_KI = AT_KD + N_JOINTS,
    AT_STEP = AT_KI + N_JOINTS,
    N_VALUES
};

enum { N_INPUTS = 2 * N_JOINTS, N_STATES = 2 * N_COORDINATES };

typedef struct {
    double value[N_VALUES];
    double input_rate[N_INPUTS]; /* slopes of the inputs over the coming communication step */
    double mode[N_JOINTS];       /* +1 slides forward, -1 backward, 0 stuck */
    double rate[N_STATES];       /* dx of the present state and modes */
    double imbalance[N_JOINTS];  /* torque that a brake takes at each motor hinge */
    double integral[N_JOINTS];   /* of the PID [N m] */
    double error[N_JOINTS];      /* of the PID at its last sample [rad] */
    double time;                 /* since the start of the experiment [s] */
    long long ticks;             /* samples of the controller so far */
} Plant;

void plant_reset(Plant *plant);
/* Static equilibrium at the first reference, first sample of the controller. 0 when it was found. */
int plant_initialise(Plant *plant);
/* Forward by `duration` >= 0 seconds. 0 when the state stayed finite. */
int plant_advance(Plant *plant, double duration);
/* Bring the values that follow from the state up to date. */
void plant_outputs(Plant *plant);

#endif

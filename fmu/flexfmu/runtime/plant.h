/* The simulated arm: its state, its digital controller if it has one, its solver. No globals, no allocation. */
#ifndef PLANT_H
#define PLANT_H

#include "model.h"
#ifdef MODEL_CONTROLLER
#include "pid.h"
#endif
#ifdef MODEL_SERVO
#include "servo.h"
#endif

/* Every variable has a fixed place in `value`; the place is its FMI value reference. */
enum {
    AT_REFERENCE = 0,                         /* without a controller the positions at the start */
    AT_FEEDFORWARD = AT_REFERENCE + N_JOINTS, /* without a controller the torques that hold these */
#ifdef MODEL_SERVO
    AT_ON = AT_FEEDFORWARD + N_JOINTS, /* 1 while a servo drives, 0 while its motor turns freely */
    AT_START = AT_ON + N_JOINTS,       /* positions at the start */
    AT_STATE = AT_START + N_JOINTS,
#else
    AT_STATE = AT_FEEDFORWARD + N_JOINTS,     /* q, then v, then the laws' own */
#endif
    AT_RATE = AT_STATE + N_STATES,
    AT_TORQUE = AT_RATE + N_STATES,
    AT_TIP = AT_TORQUE + N_JOINTS,
    AT_FRICTION = AT_TIP + 3,
    AT_INDICATOR = AT_FRICTION + N_JOINTS, /* event indicators */
    AT_LAW = AT_INDICATOR + N_JOINTS,      /* what the laws take at each coordinate */
    AT_PARAMETER = AT_LAW + N_COORDINATES,
#ifdef MODEL_CONTROLLER
    AT_KP = AT_PARAMETER + N_PARAMETERS,
    AT_KD = AT_KP + N_JOINTS,
    AT_KI = AT_KD + N_JOINTS,
    AT_STEP = AT_KI + N_JOINTS,
#elif defined MODEL_SERVO
    AT_SERVO = AT_PARAMETER + N_PARAMETERS,
    AT_STEP = AT_SERVO + N_SERVO,
#else
    AT_STEP = AT_PARAMETER + N_PARAMETERS,
#endif
    N_VALUES
};

#ifdef MODEL_SERVO
enum { N_INPUTS = 3 * N_JOINTS };
#else
enum { N_INPUTS = 2 * N_JOINTS };
#endif

typedef struct {
    double value[N_VALUES];
    double input_rate[N_INPUTS]; /* slopes of the inputs over the coming communication step */
    double mode[N_JOINTS];       /* +1 slides forward, -1 backward, 0 stuck */
    double imbalance[N_JOINTS];  /* torque that a brake takes at each motor hinge */
#ifdef MODEL_CONTROLLER
    Pid pid;
#endif
#ifdef MODEL_SERVO
    Servo servo;
#endif
    double time; /* since the start of the experiment [s] */
} Plant;

void plant_reset(Plant *plant);
/* Static equilibrium at the first reference, first sample of a controller. 0 when it was found. */
int plant_initialise(Plant *plant);
/* Release stuck hinges until every reaction is within its level; the rates of the state are then up to date. To be
   called before a run when inputs or parameters may have changed. */
void plant_settle(Plant *plant);
/* Bring the values that follow from the state up to date. */
void plant_outputs(Plant *plant);
/* Time of the controller's next sample [s], and whether it is due by `time`. */
double plant_next_sample(const Plant *plant);
int plant_sample_due(const Plant *plant, double time);
/* The controller reads the inputs, extrapolated by `late` seconds, and renews the torques. */
void plant_sample(Plant *plant, double late);

/* Co-simulation, 0 when the state stayed finite: to a time [s] with the torque held, */
int plant_run(Plant *plant, double until);
/* and by `duration` >= 0 seconds with every sample of the controller on the way. */
int plant_advance(Plant *plant, double duration);

/* Model exchange: rates of the state as it is. */
void plant_rates(Plant *plant);
/* One indicator per motor hinge: positive while its friction mode holds. */
void plant_indicators(const Plant *plant, double indicator[N_JOINTS]);
/* Switch the modes whose indicators have crossed. 1 when a mode, and with it a state, has changed. */
int plant_switch(Plant *plant);

#ifdef MODEL_DERIVATIVES
/* Sensitivities by value reference: out = d(values)/d(values) seed, and its transpose. With `sampling` the
   controller's torque answers to its inputs (an event), else it is held. */
void plant_directional(const Plant *plant, const double seed[N_VALUES], int sampling, double out[N_VALUES]);
void plant_adjoint(const Plant *plant, const double seed[N_VALUES], int sampling, double out[N_VALUES]);
#endif

#endif

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
#ifdef MODEL_DRIVE
#include "drive.h"
#endif

/* Every variable has a fixed place in `value`; the place is its FMI value reference. */
enum {
    AT_REFERENCE = 0,                         /* without a controller the positions at the start */
    AT_FEEDFORWARD = AT_REFERENCE + N_JOINTS, /* without a controller the torques that hold these */
#ifdef MODEL_SERVO
    AT_ON = AT_FEEDFORWARD + N_JOINTS, /* 1 while a servo drives, 0 while its motor turns freely */
    AT_START = AT_ON + N_JOINTS,       /* positions at the start */
    AT_START_SPEED = AT_START + N_JOINTS,
#else
    AT_START_SPEED = AT_FEEDFORWARD + N_JOINTS,
#endif
#ifdef MODEL_CONTROLLER
    AT_START_ERROR = AT_START_SPEED + N_JOINTS, /* position at the start, from the first reference */
    AT_STATE = AT_START_ERROR + N_JOINTS,       /* q, then v, then the laws' own */
#else
    AT_STATE = AT_START_SPEED + N_JOINTS,
#endif
    AT_RATE = AT_STATE + N_STATES,
    AT_TORQUE = AT_RATE + N_STATES,
    AT_TIP = AT_TORQUE + N_JOINTS,
    AT_SHOWN = AT_TIP + 3, /* motion of the tip and of the links */
    AT_FRICTION = AT_SHOWN + N_SHOWN,
    AT_INDICATOR = AT_FRICTION + N_JOINTS, /* event indicators */
    AT_LAW = AT_INDICATOR + N_JOINTS,      /* what the laws take at each coordinate */
    AT_PARAMETER = AT_LAW + N_COORDINATES,
#ifdef MODEL_CONTROLLER
    AT_GAIN = AT_PARAMETER + N_PARAMETERS, /* as in pid.h */
    AT_STEP = AT_GAIN + N_GAINS,
#elif defined MODEL_SERVO
    AT_SERVO = AT_PARAMETER + N_PARAMETERS,
    AT_STEP = AT_SERVO + N_SERVO,
#else
    AT_STEP = AT_PARAMETER + N_PARAMETERS,
#endif
#ifdef MODEL_DRIVE
    AT_COMMAND = AT_STEP + 1, /* as in drive.h */
    N_VALUES = AT_COMMAND + N_COMMAND
#else
    N_VALUES = AT_STEP + 1
#endif
};

#ifdef MODEL_SERVO
enum { N_INPUTS = 3 * N_JOINTS };
#else
enum { N_INPUTS = 2 * N_JOINTS };
#endif

typedef struct {
    double value[N_VALUES];
    double input_rate[N_INPUTS];   /* slopes of the inputs over the coming communication step */
    double sensor_error[N_JOINTS]; /* what the controller's sensors add to the motor hinges */
    double mode[N_JOINTS];         /* +1 slides forward, -1 backward, 0 stuck */
    double imbalance[N_JOINTS];    /* torque that a brake takes at each motor hinge */
#ifdef MODEL_CONTROLLER
    Pid pid;
#endif
#ifdef MODEL_SERVO
    Servo servo;
#endif
#ifdef MODEL_DRIVE
    Drive drive;
#endif
    double time;       /* since the start of the experiment [s] */
    double refinement; /* the solver's step is multiplied by it */
    long long trials;  /* steps of the solver, those to locate an event included */
    int unsettled;     /* inputs or parameters changed since the rates and modes were computed */
} Plant;

/* Groups of values that are computed together, on demand. */
enum { SHOW_RATES = 1, SHOW_TIP = 2, SHOW_MOTION = 4, SHOW_LAWS = 8 };
int plant_group(unsigned reference);

void plant_reset(Plant *plant);
/* Static equilibrium at the start; a sample of the controller is then due. 0 when it was found. */
int plant_initialise(Plant *plant);
/* 1 when the mass matrix at the state is not positive definite. */
int plant_indefinite(const Plant *plant);
/* Whether numbers, modes and counts are such as this code leaves behind. */
int plant_sound(const Plant *plant);
/* Release stuck hinges until every reaction is within its level; the rates of the state are then up to date. */
void plant_settle(Plant *plant);
/* How values answer to inputs: the torque is held (continuous time); a sample that is due answers, without being taken
   (events); the friction modes answer too (communication points); all follow from the start (initialisation). */
typedef enum { HELD, SAMPLED, SETTLED, STARTING } Answer;
/* Bring groups of values up to date. */
void plant_show(Plant *plant, int groups, Answer answer);
/* Time of the controller's next sample [s], whether it is due by `time`, and whether it comes before `time`. */
double plant_next_sample(const Plant *plant);
int plant_sample_due(const Plant *plant, double time);
int plant_sample_before(const Plant *plant, double time);
/* The controller reads the inputs, extrapolated by `late` seconds, and renews the torques. */
void plant_sample(Plant *plant, double late);
/* The same without looking what the torques set free: the plant is then unsettled. */
void plant_command(Plant *plant, double late);

/* Co-simulation to a time [s] with the torque held. 0 when the state stayed finite. */
int plant_run(Plant *plant, double until);
/* One step of the solver with the torque held, friction events inside it included; how many a duration takes. */
void plant_substep(Plant *plant, double h);
int plant_steps(const Plant *plant, double duration);

/* Switch the modes whose indicators have crossed. 1 when a mode, and with it a rate, has changed. */
int plant_switch(Plant *plant);

/* Mechanics at a state x: rates, torques that brakes take, and how far each hinge is from leaving its mode. */
void plant_rates(const Plant *plant, const double *x, double *dx, double *imbalance, double *friction);
void plant_margins(const Plant *plant, const double *x, const double *imbalance, double margin[N_JOINTS]);
/* A root is accepted with this tolerance: rad/s while sliding, N m while stuck. */
double plant_tolerance(const Plant *plant, int joint);

#ifdef MODEL_DERIVATIVES
/* Sensitivities by value reference, out = d(values)/d(values) seed, and its transpose. */
void plant_directional(const Plant *plant, const double seed[N_VALUES], Answer answer, double out[N_VALUES]);
void plant_adjoint(const Plant *plant, const double seed[N_VALUES], Answer answer, double out[N_VALUES]);
#endif

#endif

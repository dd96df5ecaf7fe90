/* The digital controller alone: a discrete block that takes a sample whenever one is due. */
#ifndef CONTROLLER_H
#define CONTROLLER_H

#include "pid.h"

/* Every variable has a fixed place in `value`; the place is its FMI value reference. */
enum {
    AT_REFERENCE = 0,
    AT_FEEDFORWARD = AT_REFERENCE + N_JOINTS,
    AT_POSITION = AT_FEEDFORWARD + N_JOINTS,
    AT_SPEED = AT_POSITION + N_JOINTS,
    AT_TORQUE = AT_SPEED + N_JOINTS,
    AT_SEEN = AT_TORQUE + N_JOINTS,        /* positions and speeds at the sample */
    AT_STIFFNESS = AT_SEEN + 2 * N_JOINTS, /* how the torque falls beside them */
    AT_DAMPING = AT_STIFFNESS + N_JOINTS,
    AT_TORQUE_RATE = AT_DAMPING + N_JOINTS, /* how it rises with the references, extrapolated */
    AT_SAMPLED = AT_TORQUE_RATE + N_JOINTS, /* time of the sample [s] */
    AT_INTEGRAL = AT_SAMPLED + 1,           /* at the start */
    AT_GAIN = AT_INTEGRAL + N_JOINTS, /* as in pid.h */
    N_VALUES = AT_GAIN + N_GAINS
};

enum { N_INPUTS = 4 * N_JOINTS };

typedef struct {
    Pid pid;
    double reference[2][N_JOINTS]; /* of the last sample and of the one before */
} Past;

typedef struct {
    double value[N_VALUES];
    double input_rate[N_INPUTS]; /* slopes of the inputs over the coming communication step */
    Past past;
    double time; /* since the start of the experiment [s] */
} Controller;

void controller_reset(Controller *controller);
int controller_initialise(Controller *controller);
/* The torque that a sample due now would give with the present inputs; the sample is taken by the next step. */
typedef enum { HELD, SAMPLED, SETTLED, STARTING } Answer;
void controller_show(Controller *controller, int groups, Answer answer);
int controller_group(unsigned reference);
/* To a time [s] with every sample before it; one that is due then waits for its inputs. */
int controller_run(Controller *controller, double until);
/* Whether its numbers and counts are such as this code leaves behind. */
int controller_sound(const Controller *controller);

#endif

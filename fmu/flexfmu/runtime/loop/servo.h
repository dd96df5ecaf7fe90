/* A servo per joint: a digital position loop on the voltage of a DC motor, the torque held between its samples. */
#ifndef SERVO_H
#define SERVO_H

#include "model.h"

/* Communication points are sums of steps: a sample this close counts as now [s]. */
#define SAMPLE_TOLERANCE (1e-6 * PERIOD)
enum { SERVO_HISTORY = 256 }; /* samples that a command may be late, and a few more */

/* Places of a joint's numbers among the parameters, and of those that all joints share behind them. */
enum {
    SERVO_KP = 0,
    SERVO_KI = SERVO_KP + N_JOINTS,
    SERVO_KD = SERVO_KI + N_JOINTS,
    SERVO_GAIN = SERVO_KD + N_JOINTS,
    SERVO_LIMIT = SERVO_GAIN + N_JOINTS,
    SERVO_DEAD_BAND = SERVO_LIMIT + N_JOINTS,
    SERVO_KT = SERVO_DEAD_BAND + N_JOINTS,
    SERVO_R = SERVO_KT + N_JOINTS,
    SERVO_SATURATION = SERVO_R + N_JOINTS,
    SERVO_SUPPLY = SERVO_SATURATION + N_JOINTS,
    SERVO_DELAY,
    N_SERVO
};

typedef struct {
    double command[SERVO_HISTORY][N_JOINTS]; /* the last references, a ring */
    double integral[N_JOINTS];               /* of the error [rad s] */
    long long ticks;                         /* samples so far */
} Servo;

void servo_start(Servo *servo);
/* Time of the next sample [s], and whether it has come. */
double servo_next_sample(const Servo *servo);
int servo_due(const Servo *servo, double time);
/* One sample: `input` holds reference, added torque and on/off of every joint; positions and speeds of the motors. */
void servo_sample(Servo *servo, const double parameter[N_SERVO], const double input[3 * N_JOINTS],
                  const double position[N_JOINTS], const double speed[N_JOINTS], double torque[N_JOINTS]);

#endif

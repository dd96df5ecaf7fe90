/* A drive per joint: it receives a torque with the time and motion at which it was computed and how it changes beside
   them, and holds what this law says where it arrives. A law that arrives late, from a master that steps plant and
   controller side by side, then still answers to the motion of now: the loop is without the delay. */
#ifndef DRIVE_H
#define DRIVE_H

#include "model.h"

/* What is received: the torque, position and speed at which it was computed, its fall per position and per speed, its
   rise per time, and when it was computed [s]. */
enum {
    DRIVE_TORQUE = 0,
    DRIVE_POSITION = N_JOINTS,
    DRIVE_SPEED = 2 * N_JOINTS,
    DRIVE_STIFFNESS = 3 * N_JOINTS,
    DRIVE_DAMPING = 4 * N_JOINTS,
    DRIVE_RATE = 5 * N_JOINTS,
    DRIVE_SAMPLED = 6 * N_JOINTS,
    N_COMMAND = DRIVE_SAMPLED + 1
};

typedef struct {
    double law[N_COMMAND];   /* the last that was taken */
    double torque[N_JOINTS]; /* held */
} Drive;

/* Motion of the motor hinges at a time [s]. */
typedef struct {
    double time;
    const double *position, *speed;
} Motion;

/* At the start: whatever is received counts as new. */
void drive_start(Drive *drive, const double command[N_COMMAND], const Motion *now, double torque[N_JOINTS]);
/* Whether `torque` is not yet what the drives hold of the command. */
int drive_due(const Drive *drive, const double command[N_COMMAND], const double torque[N_JOINTS]);
/* Joints whose law is new take it at the motion of now; the others hold their torque. */
void drive_take(Drive *drive, const double command[N_COMMAND], const Motion *now, double torque[N_JOINTS]);

#endif

#include "drive.h"

#include <string.h>

static const double AT_ONCE = 1e-9; /* a law that is not later than this is not late [s] */

static int is_new(const Drive *drive, const double *command, int joint) {
    int i;
    for (i = joint; i < DRIVE_SAMPLED; i += N_JOINTS)
        if (command[i] != drive->law[i]) return 1;
    return 0;
}

static double asked(const double *command, const Motion *now, int joint) {
    const double *law = command + joint, late = now->time - command[DRIVE_SAMPLED];
    return law[DRIVE_TORQUE] - law[DRIVE_STIFFNESS] * (now->position[joint] - law[DRIVE_POSITION]) -
           law[DRIVE_DAMPING] * (now->speed[joint] - law[DRIVE_SPEED]) + law[DRIVE_RATE] * (late > AT_ONCE ? late : 0);
}

void drive_start(Drive *drive, const double command[N_COMMAND], const Motion *now, double torque[N_JOINTS]) {
    int j;
    memcpy(drive->law, command, sizeof drive->law);
    for (j = 0; j < N_JOINTS; ++j) torque[j] = drive->torque[j] = asked(command, now, j);
}

int drive_due(const Drive *drive, const double command[N_COMMAND], const double torque[N_JOINTS]) {
    int j;
    for (j = 0; j < N_JOINTS; ++j)
        if (torque[j] != drive->torque[j] || is_new(drive, command, j)) return 1;
    return 0;
}

void drive_take(Drive *drive, const double command[N_COMMAND], const Motion *now, double torque[N_JOINTS]) {
    int j;
    for (j = 0; j < N_JOINTS; ++j) {
        if (is_new(drive, command, j)) drive->torque[j] = asked(command, now, j);
        torque[j] = drive->torque[j];
    }
    memcpy(drive->law, command, sizeof drive->law);
}

#include "servo.h"

#include <math.h>
#include <string.h>

void servo_start(Servo *servo) { memset(servo, 0, sizeof *servo); }

double servo_next_sample(const Servo *servo) { return (double)servo->ticks * PERIOD; }

int servo_due(const Servo *servo, double time) { return servo_next_sample(servo) <= time + SAMPLE_TOLERANCE; }

/* The reference as it was `delay` seconds ago, linear between samples; the first one before the start. */
static double late(const Servo *servo, int joint, double delay) {
    double ago = fmin(fmax(delay / PERIOD, 0), SERVO_HISTORY - 2), whole = floor(ago), share = ago - whole;
    long long now = servo->ticks, first = now - (long long)whole, second = first - 1;
    double a = servo->command[(first < 0 ? 0 : first) % SERVO_HISTORY][joint];
    double b = servo->command[(second < 0 ? 0 : second) % SERVO_HISTORY][joint];
    return a + share * (b - a);
}

void servo_sample(Servo *servo, const double parameter[N_SERVO], const double input[3 * N_JOINTS],
                  const double position[N_JOINTS], const double speed[N_JOINTS], double torque[N_JOINTS]) {
    const double *reference = input, *added = input + N_JOINTS, *on = input + 2 * N_JOINTS;
    const double supply = parameter[SERVO_SUPPLY], delay = parameter[SERVO_DELAY];
    int j;
    memcpy(servo->command[servo->ticks % SERVO_HISTORY], reference, N_JOINTS * sizeof *reference);
    for (j = 0; j < N_JOINTS; ++j) {
        const double *p = parameter + j;
        double error = late(servo, j, delay) - position[j], duty, current;
        torque[j] = added[j];
        if (on[j] < 0.5) {
            servo->integral[j] = 0;
            continue;
        }
        if (fabs(error) < p[SERVO_DEAD_BAND]) error = 0;
        if (servo->ticks) servo->integral[j] += PERIOD * error;
        duty = p[SERVO_GAIN] * (p[SERVO_KP] * error + p[SERVO_KI] * servo->integral[j] - p[SERVO_KD] * speed[j]);
        duty = fmin(fmax(duty, -p[SERVO_LIMIT]), p[SERVO_LIMIT]);
        current = (supply * duty - p[SERVO_KT] * speed[j]) / p[SERVO_R];
        torque[j] += p[SERVO_KT] * current / (1 + p[SERVO_SATURATION] * fabs(current));
    }
    ++servo->ticks;
}

/* The ladder of friction laws M1 to M6 (Duclusaud et al. 2024) in closed loop with a servo, by its own explicit scheme. */
#include <math.h>

enum { KT, R, J, OFFSET, DELAY, COULOMB, VISCOUS, STRIBECK, SPEED, CURVE, EXTERNAL, MOTOR, EXTERNAL_SLOW, MOTOR_SLOW,
       EXTERNAL_SQUARE, MOTOR_SQUARE, N_P };

static double sign(double x) { return (x > 0) - (x < 0); }

/* p: N_P parameters.
   inertia [kg m2] and weight [N m] of the pendulum; gain: duty per rad; r, on: n samples, h [s] apart; q: result. */
void ladder(const double *p, double inertia, double weight, double gain, const double *supply, const double *r,
            const double *on, int n, double h, int sub, double start, double *q_out) {
    double q = start + p[OFFSET], v = 0, total = inertia + p[J], dt = h / sub;
    int i, k;
    for (i = 0; i < n; ++i) {
        double x = i - p[DELAY] / h, w, target;
        int a;
        q_out[i] = q - p[OFFSET];
        if (x < 0) x = 0;
        a = (int)x, w = x - a;
        target = r[a] + (a + 1 < n ? w * (r[a + 1] - r[a]) : 0);
        for (k = 0; k < sub; ++k) {
            double duty = fmin(fmax(gain * (target - (q - p[OFFSET])), -1), 1);
            double motor = on[i] > 0.5 ? p[KT] / p[R] * (supply[i] * duty - p[KT] * v) : 0;
            double external = -weight * sin(q), net = motor + external;
            double slow = exp(-pow(fabs(v / p[SPEED]), p[CURVE]));
            double level = p[COULOMB] + slow * p[STRIBECK] + fabs(external * p[EXTERNAL] - motor * p[MOTOR]) +
                           slow * fabs(external * p[EXTERNAL_SLOW] - motor * p[MOTOR_SLOW]);
            double stop, limit;
            if (sign(external) != sign(motor)) {
                if (fabs(external) < fabs(motor)) level += slow * p[EXTERNAL_SQUARE] * external * external;
                if (fabs(external) > fabs(motor)) level += slow * p[MOTOR_SQUARE] * motor * motor;
            }
            stop = total / dt * v + net;
            limit = fmin(fabs(stop), level + p[VISCOUS] * fabs(v));
            v += dt * (net - sign(stop) * limit) / total;
            q += dt * v;
        }
    }
}

/* Pseudo-transient continuation (Kelley and Keyes 1998): Newton's method with stiffness added to the slopes,
   less of it as the residual shrinks. It crosses a gap, where nothing resists, and settles on stiffness that
   grows or couples. */
#include "equilibrium.h"

#include <math.h>
#include <string.h>

enum { N_DEFORMATIONS = N_COORDINATES - N_JOINTS, MAX_ROUNDS = 1000 };
static const double STEP = 1e-8; /* of the differences [rad] */

typedef double Matrix[N_COORDINATES][N_COORDINATES];

static void balance(const double *parameters, const double *x, double *force) {
    model_balance(x, parameters, force);
}

/* Solve A y = b in place of b by elimination with pivots. */
static void solve(Matrix A, double *b) {
    int i, j, c;
    for (c = 0; c < N_DEFORMATIONS; ++c) {
        int pivot = c;
        for (i = c + 1; i < N_DEFORMATIONS; ++i)
            if (fabs(A[i][c]) > fabs(A[pivot][c])) pivot = i;
        for (j = 0; j < N_DEFORMATIONS; ++j) {
            double swap = A[c][j];
            A[c][j] = A[pivot][j], A[pivot][j] = swap;
        }
        {
            double swap = b[c];
            b[c] = b[pivot], b[pivot] = swap;
        }
        for (i = c + 1; i < N_DEFORMATIONS; ++i) {
            double factor = A[i][c] / A[c][c];
            for (j = c; j < N_DEFORMATIONS; ++j) A[i][j] -= factor * A[c][j];
            b[i] -= factor * b[c];
        }
    }
    for (i = N_DEFORMATIONS - 1; i >= 0; --i) {
        for (j = i + 1; j < N_DEFORMATIONS; ++j) b[i] -= A[i][j] * b[j];
        b[i] /= A[i][i];
    }
}

/* d(force)/d(deformation) by differences. */
static void slopes(const double *parameters, const double *x, const double *force, Matrix A) {
    double y[N_STATES], there[N_COORDINATES];
    int i, j;
    memcpy(y, x, sizeof y);
    for (j = 0; j < N_DEFORMATIONS; ++j) {
        y[N_JOINTS + j] += STEP;
        balance(parameters, y, there);
        y[N_JOINTS + j] = x[N_JOINTS + j];
        for (i = 0; i < N_DEFORMATIONS; ++i) A[i][j] = (there[N_JOINTS + i] - force[N_JOINTS + i]) / STEP;
    }
}

int equilibrium(const double *parameters, double x[N_STATES], double force[N_COORDINATES]) {
    double left = HUGE_VAL, added = 1;
    int i, round;
    for (round = 0; round < MAX_ROUNDS; ++round) {
        double step[N_COORDINATES], largest = 0;
        Matrix A;
        balance(parameters, x, force);
        for (i = 0; i < N_DEFORMATIONS; ++i) {
            step[i] = force[N_JOINTS + i];
            largest = fmax(largest, fabs(step[i] / parameters[model_stiffness[i]]));
        }
        if (largest < 1e-16 || (left < 1e-13 && largest >= left)) return 0; /* to rounding */
        added = fmin(1, round ? added * largest / left : 1);
        left = largest;
        slopes(parameters, x, force, A);
        for (i = 0; i < N_DEFORMATIONS; ++i) A[i][i] += added * parameters[model_stiffness[i]];
        solve(A, step);
        for (i = 0; i < N_DEFORMATIONS; ++i) x[N_JOINTS + i] -= step[i];
    }
    return 1;
}

#ifdef MODEL_DERIVATIVES
void equilibrium_forward(const double *parameters, const double *x, const double *dp, double dx[N_STATES],
                         double dforce[N_COORDINATES]) {
    double right[N_COORDINATES];
    Matrix A;
    int i, j;
    model_balance_forward(x, parameters, dx, dp, dforce);
    for (j = 0; j < N_DEFORMATIONS; ++j) {
        double unit[N_STATES] = {0}, none[N_PARAMETERS] = {0}, slope[N_COORDINATES];
        unit[N_JOINTS + j] = 1;
        model_balance_forward(x, parameters, unit, none, slope);
        for (i = 0; i < N_DEFORMATIONS; ++i) A[i][j] = slope[N_JOINTS + i];
    }
    for (i = 0; i < N_DEFORMATIONS; ++i) right[i] = dforce[N_JOINTS + i];
    solve(A, right);
    for (i = 0; i < N_DEFORMATIONS; ++i) dx[N_JOINTS + i] -= right[i];
    model_balance_forward(x, parameters, dx, dp, dforce);
}
#endif

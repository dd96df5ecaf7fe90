/* Where the arm hangs still. */
#ifndef EQUILIBRIUM_H
#define EQUILIBRIUM_H

#include "model.h"

/* Deformations (in the state x) under which the laws carry the weight; force: what each coordinate then needs.
   0 when they were found. */
int equilibrium(const double *parameters, double x[N_STATES], double force[N_COORDINATES]);

#ifdef MODEL_DERIVATIVES
/* How both follow the parameters and the motor hinges: dx holds the motor hinges' seeds and gets the deformations'. */
void equilibrium_forward(const double *parameters, const double *x, const double *dp, double dx[N_STATES],
                         double dforce[N_COORDINATES]);
#endif

#endif

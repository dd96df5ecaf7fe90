/* Where the arm hangs still. */
#ifndef EQUILIBRIUM_H
#define EQUILIBRIUM_H

#include "model.h"

/* Deformations (in the state x) under which the laws carry the weight; force: what each coordinate then needs.
   0 when they were found. */
int equilibrium(const double *parameters, double x[N_STATES], double force[N_COORDINATES]);

#endif

/* Many runs over the same times in one call: other inputs, other parameters, other noise of the sensors. */
#ifndef BATCH_H
#define BATCH_H

#include "instance.h"

#define batch_advance_avx2 MODEL_PREFIXED(batch_advance_avx2)
#define batch_advance_avx512 MODEL_PREFIXED(batch_advance_avx512)

#ifdef MODEL_SAMPLED
enum { N_FED = N_INPUTS, AT_FED = AT_REFERENCE }; /* references, feed-forward torques, switches of servos */
#else
enum { N_FED = N_JOINTS, AT_FED = AT_TORQUE };
#endif

/* What is asked; flexfmu.batch knows this layout. */
typedef struct {
    long long runs, samples, parameters, outputs;
    const double *time;        /* [samples] [s] */
    const double *inputs;      /* [experiments][samples][N_FED] */
    const long long *experiment; /* [runs] which of these a run is fed */
    const unsigned *parameter; /* [parameters] value references */
    const double *value;       /* [runs][parameters] */
    const double *noise;       /* [runs][samples][N_JOINTS] of the controller's sensors, or NULL */
    const unsigned *output;    /* [outputs] value references */
    double *row;               /* [runs][samples][outputs] */
    int *lost;                 /* [runs] why all runs ended at a sample of this one, see Lost; else 0 */
    /* Told that so many runs side by side, from the first on, have so many samples; not 0: end now. May be NULL. */
    int (*stop)(long long first, long long runs, long long samples);
    char *text;                /* why it was refused */
    long long text_size;
    long long scalar;          /* not 0: one run after the other even where vectors of runs are possible */
} Batch;

/* The state left the finite numbers; friction chatters: the run takes far more trials than steps. */
typedef enum { INFINITE = 1, CHATTERING = 2 } Lost;

/* Forward by `duration` with the torques held, as many plants together as the vector is wide: they agree in time and
   in the solver's step. */
typedef void (*Advance)(Plant *const *plants, double duration);
void batch_advance_avx2(Plant *const *plants, double duration);
void batch_advance_avx512(Plant *const *plants, double duration);

#endif

/* Several samples at once: what surrounds the generated function `point`, which works on vectors of LANES
   samples. It is given N_Q coordinates and N_PHI entries of Phi. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#define LANES 8
typedef double lanes __attribute__((vector_size(LANES * sizeof(double))));

static inline lanes each(double value) { return value - (lanes){0}; }

#define OF_EACH(name)                                    \
    static inline lanes name##_of(lanes x)               \
    {                                                    \
        for (int i = 0; i < LANES; i++) x[i] = name(x[i]); \
        return x;                                        \
    }
OF_EACH(sqrt)
OF_EACH(sin)
OF_EACH(cos)

static void point(const lanes *q, const lanes *dq, const lanes *ddq, lanes *Phi);

static void load(lanes *x, const double *rows, ptrdiff_t samples)
{
    for (int lane = 0; lane < LANES; lane++) {
        const double *row = rows + N_Q * (lane < samples ? lane : samples - 1);
        for (int i = 0; i < N_Q; i++) x[i][lane] = row[i];
    }
}

/* Phi of `samples` rows of q, dq, ddq: entry e of sample s goes to Phi[place[e] + s * stride]. */
#ifdef _WIN32
__declspec(dllexport)
#endif
void fill(ptrdiff_t samples, const double *q, const double *dq, const double *ddq,
          double *Phi, const ptrdiff_t *place, ptrdiff_t stride)
{
    lanes x[N_Q], dx[N_Q], ddx[N_Q], value[N_PHI];
    for (ptrdiff_t s = 0; s < samples; s += LANES) {
        ptrdiff_t left = samples - s;
        load(x, q + s * N_Q, left);
        load(dx, dq + s * N_Q, left);
        load(ddx, ddq + s * N_Q, left);
        point(x, dx, ddx, value);
        if (stride == 1 && left >= LANES) {
            for (int e = 0; e < N_PHI; e++) memcpy(Phi + place[e] + s, &value[e], sizeof(lanes));
        } else {
            for (int lane = 0; lane < LANES && lane < left; lane++) {
                double *at = Phi + (s + lane) * stride;
                for (int e = 0; e < N_PHI; e++) at[place[e]] = value[e][lane];
            }
        }
    }
}

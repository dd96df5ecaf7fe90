#include "batch.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define BATCH_EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define BATCH_EXPORT __attribute__((visibility("default")))
#else
#define BATCH_EXPORT
#endif

enum { MOST_LANES = 8, SILENT = 64 }; /* samples between two reports */
enum { MOST_TRIALS = 50, EASY = 1000 }; /* trials per step on average, and steps whose trials are free at the start */

typedef struct {
    Advance advance;
    int lanes;
} Together;

static void advance_one(Plant *const *plants, double duration) { (void)plant_run(plants[0], plants[0]->time + duration); }

/* Whether all runs give a parameter the same value. */
static int alike(const Batch *b, unsigned reference) {
    long long i, run;
    for (i = 0; i < b->parameters; ++i)
        for (run = 1; b->parameter[i] == reference && run < b->runs; ++run)
            if (b->value[run * b->parameters + i] != b->value[i]) return 0;
    return 1;
}

/* The widest vector of runs that this processor has and this binary was built for. */
static Together together(const Batch *b) {
    Together one = {advance_one, 1};
    if (b->scalar || b->runs < 2 || !alike(b, AT_STEP)) return one;
#ifdef MODEL_CONTROLLER
    if (!alike(b, AT_GAIN + PID_PERIOD)) return one;
#endif
#if defined(__x86_64__) && defined(__GNUC__)
#ifdef MODEL_AVX512
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
        Together eight = {batch_advance_avx512, 8};
        return eight;
    }
#endif
#ifdef MODEL_AVX2
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
        Together four = {batch_advance_avx2, 4};
        return four;
    }
#endif
#endif
    return one;
}

/* What a run is fed at a sample: N_FED values, those of the next sample behind them. */
static const double *fed(const Batch *b, long long run, long long i) {
    return b->inputs + (b->experiment[run] * b->samples + i) * N_FED;
}

/* A run at its start. 0 when it may begin. */
static int begin(const Batch *b, long long run, Memory *m) {
    double *value = m->model.value;
    long long i;
    memory_start(m, 0, 1);
    for (i = 0; i < b->parameters; ++i) {
        unsigned vr = b->parameter[i];
        double wanted = b->value[run * b->parameters + i];
        if (memory_refuses(m, vr, wanted, b->text, (size_t)b->text_size)) return 1;
        value[vr] = wanted;
    }
    memcpy(value + AT_FED, fed(b, run, 0), N_FED * sizeof *value);
    if (memory_initialise(m, b->text, (size_t)b->text_size)) return 1;
    m->phase = STEPPING;
    return 0;
}

/* Inputs of a sample, their slopes to the next one, and the sample of the controller if it is due. */
static void feed(const Batch *b, long long run, long long i, Plant *s) {
    const double *u = fed(b, run, i);
    memcpy(s->value + AT_FED, u, N_FED * sizeof *u);
#ifdef MODEL_SAMPLED
    {
        int j, last = i + 1 == b->samples;
        for (j = 0; j < N_FED; ++j)
            s->input_rate[j] = last ? 0 : (u[N_FED + j] - u[j]) / (b->time[i + 1] - b->time[i]);
        for (j = 0; j < N_JOINTS; ++j)
            s->sensor_error[j] = b->noise ? b->noise[(run * b->samples + i) * N_JOINTS + j] : 0;
        if (plant_sample_due(s, s->time)) plant_command(s, 0);
    }
#else
    s->unsettled = 1;
#endif
}

static void record(const Batch *b, long long run, long long i, int groups, Memory *m) {
    double *row = b->row + (run * b->samples + i) * b->outputs;
    long long k;
    m->shown = 0;
    memory_show(m, groups);
    for (k = 0; k < b->outputs; ++k) row[k] = m->model.value[b->output[k]];
    if (m->model.trials > MOST_TRIALS * ((long long)plant_steps(&m->model, m->model.time) + EASY)) b->lost[run] = CHATTERING;
    for (k = 0; k < N_STATES; ++k)
        if (!isfinite(m->model.value[AT_STATE + k])) b->lost[run] = INFINITE;
}

/* To the next sample of the experiment, with every sample of the controller on the way. */
static void advance(const Batch *b, long long i, Plant *const *plants, Together t) {
    Plant *first = plants[0];
    double start = first->time, end = b->time[i + 1] - b->time[0];
    int k;
    while (plant_sample_before(first, end)) {
        double tick = plant_next_sample(first);
        t.advance(plants, tick - first->time);
        for (k = 0; k < t.lanes; ++k) {
            plants[k]->time = tick;
            plant_command(plants[k], tick - start);
        }
    }
    t.advance(plants, end - first->time);
    for (k = 0; k < t.lanes; ++k) plants[k]->time = end;
}

/* Runs first ... first + lanes - 1 side by side; those beyond the last one repeat it. 1 with a sentence in
   `text`, -1 where a run is lost, which ends all. */
static int side_by_side(const Batch *b, long long first, int groups, Together t, Memory *memory) {
    Plant *plants[MOST_LANES];
    long long i, run;
    int k, lost = 0;
    for (k = 0; k < t.lanes; ++k) {
        run = first + k < b->runs ? first + k : b->runs - 1;
        if (begin(b, run, &memory[k])) return 1;
        plants[k] = &memory[k].model;
    }
    for (i = 0; i < b->samples; ++i) {
        for (k = 0; k < t.lanes; ++k) {
            run = first + k < b->runs ? first + k : b->runs - 1;
            feed(b, run, i, plants[k]);
            if (first + k < b->runs) record(b, run, i, groups, &memory[k]);
            lost |= b->lost[run];
        }
        if (lost) return -1; /* what is not a number takes its time */
        if (i + 1 < b->samples) advance(b, i, plants, t);
        run = b->runs - first < t.lanes ? b->runs - first : t.lanes;
        if (b->stop && i % SILENT == 0 && b->stop(first, run, i + 1)) {
            snprintf(b->text, (size_t)b->text_size, "The runs were stopped.");
            return 1;
        }
    }
    return 0;
}

BATCH_EXPORT int flexident_batch(const Batch *b);
BATCH_EXPORT int flexident_batch_sizes(int sizes[3]);

/* 0, or 1 with a sentence in `text`; all ends where a run is lost. */
int flexident_batch(const Batch *b) {
    Together t = together(b);
    Memory *memory = (Memory *)calloc(MOST_LANES, sizeof *memory);
    long long i, first;
    int groups = 0, bad = 0;
    if (!memory) {
        snprintf(b->text, (size_t)b->text_size, "Out of memory.");
        return 1;
    }
    for (i = 0; i < b->outputs; ++i) /* the torque is renewed by the sample itself */
        if (b->output[i] < AT_TORQUE || b->output[i] >= AT_TIP) groups |= memory_group(b->output[i]);
    for (first = 0; !bad && first < b->runs; first += t.lanes) bad = side_by_side(b, first, groups, t, memory);
    free(memory);
    return bad > 0;
}

/* Numbers of inputs and joints, and how many runs go side by side here. */
int flexident_batch_sizes(int sizes[3]) {
    Batch two = {2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    sizes[0] = N_FED;
    sizes[1] = N_JOINTS;
    sizes[2] = together(&two).lanes;
    return 0;
}

/* What the faces of an FMU share: an instance's memory, its phases, checked access to variables, saved states. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stddef.h>

#include "model.h"
#ifdef MODEL_PLANT
#include "plant.h"
typedef Plant Model;
#define MODEL(function) plant_##function
#else
#include "controller.h"
typedef Controller Model;
#define MODEL(function) controller_##function
#endif

typedef enum {
    INSTANTIATED = 1,
    INITIALIZING = 2,
    EVENT = 4,      /* event mode */
    CONTINUOUS = 8, /* continuous-time mode (model exchange) */
    STEPPING = 16,  /* step mode (co-simulation) */
    TERMINATED = 32,
    BROKEN = 64
} Phase;
enum { RUNNING = EVENT | CONTINUOUS | STEPPING, ALWAYS = 127 };

/* All that a saved state must hold: no pointers. */
typedef struct {
    Model model;
    Phase phase;
    int model_exchange;
    int own_events; /* co-simulation: the importer does not handle events, doStep does */
    int shown;      /* groups of values that are up to date */
    int fed;        /* inputs were set since the last step: a sample that is due answers to them */
    int unplaced;   /* in initialisation: values changed since the start was computed */
    double start;   /* start time of the experiment [s] */
} Memory;

void memory_start(Memory *memory, int model_exchange, int own_events);
void memory_reset(Memory *memory);
/* Static equilibrium and first sample. 0 when it was found; else `text` says why not. */
int memory_initialise(Memory *memory, char *text, size_t size);
/* Bring groups of values up to date, in initialisation too. */
void memory_show(Memory *memory, int groups);
/* After inputs, parameters or states were set, or time went on. */
void memory_changed(Memory *memory);
/* How values answer to inputs in the present phase. */
Answer memory_answer(const Memory *memory);
/* Groups that a reference belongs to. */
int memory_group(unsigned reference);
/* 0 when `time` is where the instance stands; else `text` says where that is. */
int memory_elsewhere(const Memory *memory, double time, char *text, size_t size);
/* First derivative of an output by time. 0 when there is one; else `text` says why not. */
int memory_slope(Memory *memory, unsigned reference, int order, double *slope, char *text, size_t size);
/* A tolerance below 1e-6 shortens the solver's step, as its fourth root. */
void memory_tolerate(Memory *memory, double tolerance);
/* 0 when the mass matrix is positive definite; else `text` says that it is not, and the instance is BROKEN. */
int memory_indefinite(Memory *memory, char *text, size_t size);
int memory_finite(const double *values, size_t n);
/* Whether it is one that this code can have reached: foreign bytes may hold anything. */
int memory_sound(const Memory *memory);
/* 0 when the variable may take the value; else `text` says why not. */
int memory_refuses(const Memory *memory, unsigned reference, double value, char *text, size_t size);

#ifdef MODEL_PLANT
/* 0 when the time can be reached; else `text` says why not. */
int memory_set_time(Memory *memory, double time, char *text, size_t size);
/* Event mode: due samples and crossed modes. 1 when a state, a mode or a torque changed. */
int memory_handle_events(Memory *memory);
double memory_next_event(const Memory *memory);
#endif

#endif

/* What both faces of the FMU share: an instance's memory, its phases, checked access to variables. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stddef.h>

#include "plant.h"

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
    Plant plant;
    Phase phase;
    int model_exchange;
    int own_events; /* co-simulation: the importer does not handle events, doStep does */
    int stale;      /* the state changed since plant_outputs */
    double start;   /* start time of the experiment [s] */
} Memory;

void memory_start(Memory *memory, int model_exchange, int own_events);
void memory_reset(Memory *memory);
/* Static equilibrium and first sample. 0 when it was found; else `text` says why not. */
int memory_initialise(Memory *memory, char *text, size_t size);
void memory_refresh(Memory *memory);
/* 0 when the variable may take the value; else `text` says why not. */
int memory_refuses(const Memory *memory, unsigned reference, double value, char *text, size_t size);
void memory_set_time(Memory *memory, double time);
/* Event mode: due samples and crossed modes. 1 when states changed. */
int memory_handle_events(Memory *memory);
double memory_next_event(const Memory *memory);

#endif

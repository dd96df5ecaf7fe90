/* One communication step of co-simulation, the same for every version of the standard. */
#ifndef STEP_H
#define STEP_H

#include "instance.h"

typedef struct {
    int (*asked_back)(void *importer); /* behind a sample inside the step: 1 when the importer wants control; or NULL */
    void *importer;
    int may_return_early;
    int event, early; /* result: a sample is due that the importer handles; the step ended before its time */
} Step;

/* From `time` by `duration` >= 0 seconds. 0 when it was taken; else `text` says why not, and the instance is BROKEN if
   its state was lost. */
int memory_step(Memory *memory, double time, double duration, Step *step, char *text, size_t size);
/* 0 when a duration is one that can be taken; else `text` says why not. */
int memory_too_long(const Memory *memory, double duration, char *text, size_t size);

#endif

/* Saved states of an instance, and their bytes. Each belongs to the instance that saved or read it; another one takes
   its bytes. Results are NULL, or why it failed. */
#ifndef STATES_H
#define STATES_H

#include "instance.h"

typedef struct Saved Saved;
typedef struct {
    Saved *first;
} States;

void states_free(States *states);
const char *states_save(States *states, const Memory *memory, void **state);
const char *states_restore(const States *states, Memory *memory, const void *state);
const char *states_forget(States *states, void **state);
size_t states_size(void);
const char *states_serialise(const States *states, const void *state, char *bytes, size_t size);
/* What is not a whole state of this FMU, of an instance made as this one, is refused. */
const char *states_deserialise(States *states, const Memory *memory, const char *bytes, size_t size, void **state);

#endif

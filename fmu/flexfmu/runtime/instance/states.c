#include "states.h"

#include "model_token.h"

#include <stdlib.h>
#include <string.h>

struct Saved {
    Saved *next;
    Memory memory;
};

/* The bytes say whose state they are, and whether it is whole. */
typedef struct {
    char token[sizeof MODEL_TOKEN];
    unsigned long long check;
    Memory memory;
} Bytes;

static const char NOT_OURS[] = "This is not a state that this instance saved, or it was freed.";
static const char NOT_WHOLE[] = "These bytes are not a whole state of this FMU.";
static const char OTHER_KIND[] = "The state is that of an instance for another kind of simulation.";

/* Fowler, Noll and Vo's hash, 64 bits. */
static unsigned long long checksum(const Memory *m) {
    const unsigned char *byte = (const unsigned char *)m;
    unsigned long long sum = 14695981039346656037ull;
    size_t i;
    for (i = 0; i < sizeof *m; ++i) sum = (sum ^ byte[i]) * 1099511628211ull;
    return sum;
}

static Saved *saved(const States *states, const void *state) {
    Saved *s = states->first;
    while (s && s != state) s = s->next;
    return s;
}

static const char *keep(States *states, const Memory *m, void **state) {
    Saved *s = *state ? saved(states, *state) : (Saved *)malloc(sizeof *s);
    if (!s) return *state ? NOT_OURS : "Out of memory.";
    if (!*state) {
        s->next = states->first;
        states->first = s;
        *state = s;
    }
    memcpy(&s->memory, m, sizeof *m);
    return NULL;
}

void states_free(States *states) {
    while (states->first) {
        Saved *next = states->first->next;
        free(states->first);
        states->first = next;
    }
}

const char *states_save(States *states, const Memory *m, void **state) { return keep(states, m, state); }

const char *states_restore(const States *states, Memory *m, const void *state) {
    const Saved *s = saved(states, state);
    if (!s) return NOT_OURS;
    memcpy(m, &s->memory, sizeof *m);
    return NULL;
}

const char *states_forget(States *states, void **state) {
    Saved **at = &states->first, *s;
    if (!*state) return NULL;
    while (*at && *at != *state) at = &(*at)->next;
    if (!*at) return NOT_OURS;
    s = *at;
    *at = s->next;
    free(s);
    *state = NULL;
    return NULL;
}

size_t states_size(void) { return sizeof(Bytes); }

const char *states_serialise(const States *states, const void *state, char *bytes, size_t size) {
    const Saved *s = saved(states, state);
    Bytes out;
    if (!s) return NOT_OURS;
    if (size < sizeof out) return "The buffer is too small for the state.";
    memset(&out, 0, sizeof out);
    memcpy(out.token, MODEL_TOKEN, sizeof out.token);
    memcpy(&out.memory, &s->memory, sizeof out.memory);
    out.check = checksum(&out.memory);
    memcpy(bytes, &out, sizeof out);
    return NULL;
}

const char *states_deserialise(States *states, const Memory *m, const char *bytes, size_t size, void **state) {
    Bytes in;
    if (size != sizeof in) return NOT_WHOLE;
    memcpy(&in, bytes, sizeof in);
    if (memcmp(in.token, MODEL_TOKEN, sizeof in.token) || in.check != checksum(&in.memory)) return NOT_WHOLE;
    if (!memory_sound(&in.memory)) return NOT_WHOLE;
    if (in.memory.model_exchange != m->model_exchange || in.memory.own_events != m->own_events) return OTHER_KIND;
    return keep(states, &in.memory, state);
}

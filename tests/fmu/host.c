/* Lives of an FMI 2.0 co-simulation instance, for the sanitizers. */
#include <stdio.h>
#include <stdlib.h>

#include "fmi2Functions.h"

static void log_message(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category,
                        fmi2String message, ...) {
    (void)e, (void)name, (void)status, (void)category, (void)message;
}

int main(void) {
    const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    int life, step;
    for (life = 0; life < 1000; ++life) {
        fmi2Component c = fmi2Instantiate("rail", fmi2CoSimulation, TOKEN, "", &callbacks, fmi2False, fmi2False);
        fmi2FMUstate state = NULL;
        fmi2ValueReference reference = 0, position = 4, nowhere = 1000000;
        fmi2Real r = 0.1, x = 0;
        if (!c) return 1;
        fmi2SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0);
        fmi2EnterInitializationMode(c);
        if (fmi2ExitInitializationMode(c) != fmi2OK) return 2;
        fmi2SetReal(c, &reference, 1, &r);
        if (fmi2SetReal(c, &nowhere, 1, &r) != fmi2Error) return 3;
        for (step = 0; step < 30; ++step) {
            if (fmi2DoStep(c, 0.01 * step, 0.01, fmi2True) != fmi2OK) return 4;
            if (step == 10) fmi2GetFMUstate(c, &state);
        }
        fmi2SetFMUstate(c, state);
        fmi2FreeFMUstate(c, &state);
        if (fmi2GetReal(c, &position, 1, &x) != fmi2OK || !(x > 0)) return 5;
        if (life % 2) fmi2Terminate(c); /* an importer may also free at once */
        fmi2FreeInstance(c);
    }
    printf("%d lives\n", life);
    return 0;
}

/* SmibPlant and PmuChannel co-simulated by one program, linked from their sources (with FMI2_FUNCTION_PREFIX), or
   SmibPlant alone, from its shared library (PLANT_ONLY). Prints the outputs at the end. */

#include <stdio.h>
#include <stdlib.h>

#include "fmi2FunctionTypes.h"

#ifdef PLANT_ONLY
#define OF_PLANT(function) function
#else
#define OF_PLANT(function) SmibPlant_##function
#endif
#define OF_CHANNEL(function) PmuChannel_##function

#define DECLARE(OF)                                                                                       \
    extern fmi2InstantiateTYPE OF(fmi2Instantiate);                                                       \
    extern fmi2SetupExperimentTYPE OF(fmi2SetupExperiment);                                               \
    extern fmi2EnterInitializationModeTYPE OF(fmi2EnterInitializationMode);                               \
    extern fmi2ExitInitializationModeTYPE OF(fmi2ExitInitializationMode);                                 \
    extern fmi2GetRealTYPE OF(fmi2GetReal);                                                               \
    extern fmi2SetRealTYPE OF(fmi2SetReal);                                                               \
    extern fmi2DoStepTYPE OF(fmi2DoStep);                                                                 \
    extern fmi2FreeInstanceTYPE OF(fmi2FreeInstance);

DECLARE(OF_PLANT)
#ifndef PLANT_ONLY
DECLARE(OF_CHANNEL)
#endif

static void log_message(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status, fmi2String category,
                        fmi2String message, ...) {
    (void)environment, (void)status, (void)category;
    fprintf(stderr, "%s: %s\n", name, message);
}

static const fmi2CallbackFunctions CALLBACKS = {log_message, calloc, free, NULL, NULL};

static const fmi2ValueReference TERMINAL[] = {PLANT_TERMINAL};
#ifndef PLANT_ONLY
static const fmi2ValueReference TRUE_VALUES[] = {CHANNEL_INPUTS}, FRAME[] = {CHANNEL_OUTPUTS};
#endif

#define OK(call)                                                 \
    do {                                                         \
        if ((call) != fmi2OK) return fprintf(stderr, #call), 1;  \
    } while (0)

int main(void) {
    const double h = 1.0 / 64;
    double values[4];
    fmi2Component plant = OF_PLANT(fmi2Instantiate)("plant", fmi2CoSimulation, PLANT_GUID, NULL, &CALLBACKS, 0, 0);
#ifndef PLANT_ONLY
    fmi2Component channel = OF_CHANNEL(fmi2Instantiate)("channel", fmi2CoSimulation, CHANNEL_GUID, NULL, &CALLBACKS, 0,
                                                        0);
#endif
    OK(OF_PLANT(fmi2SetupExperiment)(plant, 0, 0, 0, 0, 0));
    OK(OF_PLANT(fmi2EnterInitializationMode)(plant));
    OK(OF_PLANT(fmi2ExitInitializationMode)(plant));
#ifndef PLANT_ONLY
    OK(OF_CHANNEL(fmi2SetupExperiment)(channel, 0, 0, 0, 0, 0));
    OK(OF_CHANNEL(fmi2EnterInitializationMode)(channel));
    OK(OF_CHANNEL(fmi2ExitInitializationMode)(channel));
#endif
    for (int k = 0; k <= 64; k++) {
        OK(OF_PLANT(fmi2GetReal)(plant, TERMINAL, 4, values));
#ifndef PLANT_ONLY
        OK(OF_CHANNEL(fmi2SetReal)(channel, TRUE_VALUES, 4, values));
#endif
        if (k == 64) break;
        OK(OF_PLANT(fmi2DoStep)(plant, k * h, h, 0));
#ifndef PLANT_ONLY
        OK(OF_CHANNEL(fmi2DoStep)(channel, k * h, h, 0));
#endif
    }
    for (int i = 0; i < 4; i++) printf("%.17g ", values[i]);
#ifndef PLANT_ONLY
    OK(OF_CHANNEL(fmi2GetReal)(channel, FRAME, 4, values));
    for (int i = 0; i < 4; i++) printf("%.17g ", values[i]);
    OF_CHANNEL(fmi2FreeInstance)(channel);
#endif
    OF_PLANT(fmi2FreeInstance)(plant);
    return 0;
}

/* A host for Windows: windows_host DLL GUID N_VARIABLES INPUT...: a run of 100 steps, and the Real variables at its end. */

#include <stdio.h>
#include <stdlib.h>
#include <windows.h>

#include "fmi2FunctionTypes.h"

#define BIND(name) name##TYPE *name = (name##TYPE *)(void *)GetProcAddress(library, #name)

static void log_message(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                        fmi2String category, fmi2String form, ...) {
    (void)environment, (void)status, (void)form;
    fprintf(stderr, "%s: %s\n", instance, category);
}

int main(int count, char **arguments) {
    const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    HMODULE library = LoadLibraryA(arguments[1]);
    BIND(fmi2Instantiate);
    BIND(fmi2SetupExperiment);
    BIND(fmi2EnterInitializationMode);
    BIND(fmi2ExitInitializationMode);
    BIND(fmi2SetReal);
    BIND(fmi2GetReal);
    BIND(fmi2DoStep);
    BIND(fmi2Terminate);
    BIND(fmi2FreeInstance);
    fmi2Component slave = fmi2Instantiate("slave", fmi2CoSimulation, arguments[2], NULL, &callbacks, 0, 0);
    fmi2Status status = slave ? fmi2OK : fmi2Error;
    if (slave) status |= fmi2SetupExperiment(slave, 0, 0, 0, 0, 0) | fmi2EnterInitializationMode(slave);
    for (int i = 4; slave && i < count; i++) {
        const fmi2ValueReference reference = (fmi2ValueReference)(i - 4);
        const fmi2Real value = atof(arguments[i]);
        status |= fmi2SetReal(slave, &reference, 1, &value);
    }
    if (slave) status |= fmi2ExitInitializationMode(slave);
    for (int k = 0; slave && k < 100; k++) status |= fmi2DoStep(slave, k / 64.0, 1 / 64.0, 1);
    if (status != fmi2OK) return 1;
    for (fmi2ValueReference i = 0; i < (fmi2ValueReference)atoi(arguments[3]); i++) {
        fmi2Real value;
        if (fmi2GetReal(slave, &i, 1, &value) == fmi2OK) printf("%u %.17g\n", i, value);
    }
    fmi2Terminate(slave);
    fmi2FreeInstance(slave);
    return 0;
}

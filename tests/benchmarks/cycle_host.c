/* A host in C: the time of one cycle (set inputs, doStep, get outputs) of a slave, in nanoseconds.

   cycle_host LIBRARY GUID RESOURCES CYCLES H REFERENCE=INTEGER|- OUTPUTS INPUT...

   INPUT... are the values of the Real variables with references 0, 1, ...; OUTPUTS is FIRST:COUNT, the Real variables
   that are got. */

#define _POSIX_C_SOURCE 200809L

#include <dlfcn.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "fmi2FunctionTypes.h"

#define BIND(name) name##TYPE *name = (name##TYPE *)dlsym(library, #name)

static void log_message(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                        fmi2String category, fmi2String message, ...) {
    va_list arguments;
    (void)environment, (void)status;
    fprintf(stderr, "%s %s: ", instance, category);
    va_start(arguments, message);
    vfprintf(stderr, message, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void check(fmi2Status status, const char *what) {
    if (status == fmi2OK) return;
    fprintf(stderr, "%s: status %d\n", what, status);
    exit(1);
}

int main(int count, char **text) {
    enum { FIRST_INPUT = 8, MOST = 1000 };
    const fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    const int n_inputs = count - FIRST_INPUT;
    void *library = count > FIRST_INPUT ? dlopen(text[1], RTLD_NOW) : NULL;
    fmi2ValueReference in[MOST], out[MOST];
    fmi2Real inputs[MOST], outputs[MOST], h, t = 0;
    unsigned first_output, n_outputs;
    struct timespec begin, end;
    fmi2Component slave;
    long cycles;

    if (!library) {
        fprintf(stderr, "%s\n", count > FIRST_INPUT ? dlerror() : "too few arguments");
        return 1;
    }
    BIND(fmi2Instantiate);
    BIND(fmi2SetupExperiment);
    BIND(fmi2EnterInitializationMode);
    BIND(fmi2ExitInitializationMode);
    BIND(fmi2SetReal);
    BIND(fmi2SetInteger);
    BIND(fmi2GetReal);
    BIND(fmi2DoStep);
    BIND(fmi2Terminate);
    BIND(fmi2FreeInstance);

    cycles = atol(text[4]);
    h = atof(text[5]);
    sscanf(text[7], "%u:%u", &first_output, &n_outputs);
    for (int i = 0; i < n_inputs; i++) in[i] = (fmi2ValueReference)i, inputs[i] = atof(text[FIRST_INPUT + i]);
    for (unsigned i = 0; i < n_outputs; i++) out[i] = first_output + i;

    slave = fmi2Instantiate("slave", fmi2CoSimulation, text[2], text[3], &callbacks, fmi2False, fmi2False);
    if (!slave) return 1;
    if (strcmp(text[6], "-") != 0) {
        fmi2ValueReference reference;
        fmi2Integer value;
        sscanf(text[6], "%u=%d", &reference, &value);
        check(fmi2SetInteger(slave, &reference, 1, &value), "fmi2SetInteger");
    }
    check(fmi2SetupExperiment(slave, fmi2False, 0, 0, fmi2False, 0), "fmi2SetupExperiment");
    check(fmi2EnterInitializationMode(slave), "fmi2EnterInitializationMode");
    check(fmi2SetReal(slave, in, (size_t)n_inputs, inputs), "fmi2SetReal");
    check(fmi2ExitInitializationMode(slave), "fmi2ExitInitializationMode");

    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &begin);
    for (long k = 0; k < cycles; k++) {
        check(fmi2SetReal(slave, in, (size_t)n_inputs, inputs), "fmi2SetReal");
        check(fmi2DoStep(slave, t, h, fmi2True), "fmi2DoStep");
        check(fmi2GetReal(slave, out, n_outputs, outputs), "fmi2GetReal");
        t += h;
    }
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &end);
    printf("%.1f\n", ((double)(end.tv_sec - begin.tv_sec) * 1e9 + (double)(end.tv_nsec - begin.tv_nsec)) / (double)cycles);
    check(fmi2Terminate(slave), "fmi2Terminate");
    fmi2FreeInstance(slave);
    return 0;
}

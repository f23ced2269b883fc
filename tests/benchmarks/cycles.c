/* A host in C: cycles of a slave (set inputs, doStep, get outputs) with nothing in between. */

#include "fmi2FunctionTypes.h"

int cycles(fmi2Component slave, fmi2SetRealTYPE *set, fmi2DoStepTYPE *step, fmi2GetRealTYPE *get,
           const fmi2ValueReference *inputs, size_t n_inputs, const fmi2Real *values,
           const fmi2ValueReference *outputs, size_t n_outputs, fmi2Real *results, double h, int count) {
    double t = 0;
    for (int k = 0; k < count; k++) {
        if (set(slave, inputs, n_inputs, values) != fmi2OK) return k;
        if (step(slave, t, h, fmi2True) != fmi2OK) return k;
        if (get(slave, outputs, n_outputs, results) != fmi2OK) return k;
        t += h;
    }
    return count;
}

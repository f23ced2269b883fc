/* One FMI 2.0 co-simulation slave, in C99, for every model.

   What the model is stands in model.h, generated from its declaration: the table of its variables, and its equations as
   functions of plain arrays. An instance is one block of memory; its values are

       inputs | parameters | outputs | state

   so that a value reference is an index, and the equations read in place. Nothing static is writable: instances do not
   know of each other, on any threads. Memory is allocated by fmi2Instantiate and for FMU states, nowhere else.

   A call that fails changes nothing, and leaves the instance usable; only a step that fails ends the run, until an FMU
   state is set or the slave is reset. */

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

typedef enum { REAL, INTEGER, BOOLEAN } Type;

typedef enum { INPUT, FIXED_PARAMETER, TUNABLE_PARAMETER, OUTPUT } Role;

typedef struct {
    const char *name;
    Type type;
    Role role;
    double start, min, max;
    const char *allowed; /* min and max in words */
} Variable;

typedef struct {
    void (*start)(const double *inputs, const double *parameters, double t, double *outputs, double *state);
    void (*step)(const double *inputs, const double *parameters, const double *state, double t, double h,
                 double *outputs, double *next_state); /* both at t + h */
    void (*output)(const double *inputs, const double *parameters, const double *state, double t,
                   double *outputs); /* where they depend on inputs directly, else NULL */
    int states;
} Program;

#include "model.h"

/* Of a communication step: a master that adds up its steps, or counts in nanoseconds, may begin one this much off the
   end of the last one, and end this much after stopTime. What is wrong is wrong by whole steps. */
#define ON_TIME 1e-2

enum {
    PARAMETERS = N_INPUTS,
    OUTPUTS = PARAMETERS + N_PARAMETERS,
    STATES = OUTPUTS + N_OUTPUTS,
    N_VARIABLES = STATES,
    N_VALUES = STATES + N_STATES,
    MAX_DIVISIONS = 1000000 /* of a communication step: a longer one would hang the host */
};

/* States of the call sequence (FMI 2.0.4, section 4.2.4), as bits: a function names all those it is allowed in. */
enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEP_COMPLETE = 4,
    STEP_FAILED = 8,
    TERMINATED = 16,
    INITIALIZED = STEP_COMPLETE | STEP_FAILED | TERMINATED,
    ANY = INSTANTIATED | INITIALIZATION | INITIALIZED
};

static const char GUID[40] = MODEL_GUID;

/* All that fmi2SetFMUstate brings back. */
typedef struct {
    int64_t phase;
    int64_t outdated; /* 1 where an input or a parameter has been set since the outputs were calculated */
    double time;
    double stop_time;
    double values[N_VALUES];
} Situation;

/* An FMU state. It has no padding: its bytes are the serialized form. */
typedef struct {
    uint64_t magic; /* tells the byte order too */
    uint64_t checksum;
    char guid[sizeof GUID];
    Situation situation;
} Snapshot;

#define MAGIC UINT64_C(0x31304c4156455350)

typedef struct {
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    const char *name;
    unsigned categories;
} Log;

typedef struct {
    Log log;
    Situation now;
    double results[2][N_OUTPUTS + N_STATES]; /* of the step that is being done */
    char name[]; /* of the instance */
} Instance;

/* Messages --------------------------------------------------------------------------------------------------------- */

static const char *const CATEGORIES[] = {"logStatusDiscard", "logStatusError", "logAll"};

enum { DISCARDS = 1, ERRORS = 2, ALL = 4, N_CATEGORIES = 3 };

/* Logs the message of a status (fmi2Discard or fmi2Error), and returns the status. */
static fmi2Status report(const Log *log, fmi2Status status, const char *format, ...) {
    const int category = status == fmi2Discard ? 0 : 1;
    char message[1024];
    va_list values;
    if (log->logger && log->categories & (1u << category | ALL)) {
        va_start(values, format);
        vsnprintf(message, sizeof message, format, values);
        va_end(values);
        log->logger(log->environment, log->name, status, CATEGORIES[category], "%s", message);
    }
    return status;
}

static const char *phase_name(int64_t phase) {
    switch (phase) {
    case INSTANTIATED: return "instantiated";
    case INITIALIZATION: return "in initialization mode";
    case STEP_COMPLETE: return "in step mode";
    case STEP_FAILED: return "in step mode after a step that failed";
    default: return "terminated";
    }
}

/* fmi2Error unless the instance is in one of the phases. */
static fmi2Status expect(const Instance *instance, int phases, const char *function) {
    if (!instance) return fmi2Error;
    if (instance->now.phase & phases) return fmi2OK;
    return report(&instance->log, fmi2Error, "%s is not allowed while the slave is %s", function,
                  phase_name(instance->now.phase));
}

static fmi2Status null_pointer(const Instance *instance, const char *function) {
    return report(&instance->log, fmi2Error, "%s: a pointer is NULL", function);
}

static fmi2Status not_supported(const Instance *instance, const char *function) {
    return instance ? report(&instance->log, fmi2Error, "%s is not supported: see the capabilities in "
                             "modelDescription.xml", function) : fmi2Error;
}

/* The model -------------------------------------------------------------------------------------------------------- */

static int all_finite(const double *values, int count) {
    int finite = 1;
    for (int i = 0; i < count; i++) finite &= fabs(values[i]) <= DBL_MAX;
    return finite;
}

static int in_range(int variable, double value) {
    return isfinite(value) && value >= VARIABLES[variable].min && value <= VARIABLES[variable].max;
}

static fmi2Status out_of_range(const Instance *instance, fmi2Status status, int variable, double value) {
    return report(&instance->log, status, "%s = %.12g is not allowed; it must be in %s", VARIABLES[variable].name,
                  value, VARIABLES[variable].allowed);
}

/* fmi2Error or fmi2Discard, and the inputs, for equations whose result is not finite. */
static fmi2Status not_finite(const Instance *instance, fmi2Status status, const char *what) {
    char inputs[768] = "";
    size_t length = 0;
    for (int i = 0; i < N_INPUTS && length < sizeof inputs; i++) {
        length += (size_t)snprintf(inputs + length, sizeof inputs - length, "%s%s = %.9g", i == 0 ? "" : ", ",
                                   VARIABLES[i].name, instance->now.values[i]);
    }
    return report(&instance->log, status, "%s is not done: its result is not finite; inputs %s", what, inputs);
}

/* An input may be set to anything, NaN too; the equations see it only within the range it has, if it has one. */
static fmi2Status check_inputs(const Instance *instance, fmi2Status failure) {
    for (int i = 0; i < N_INPUTS; i++) {
        const double value = instance->now.values[i];
        if (value < VARIABLES[i].min || value > VARIABLES[i].max) return out_of_range(instance, failure, i, value);
    }
    return fmi2OK;
}

static const Program *program(const Instance *instance) {
#ifdef SELECTOR
    const double *values = instance->now.values;
    int place = (int)(values[SELECTOR_NUMBER] > 0 ? values[SELECTOR_NUMBER] : values[SELECTOR]) - 1;
#ifdef VARIANT
    place += SELECTED * ((int)(values[VARIANT_NUMBER] > 0 ? values[VARIANT_NUMBER] : values[VARIANT]) - 1);
#endif
    return &PROGRAMS[place];
#else
    (void)instance;
    return &PROGRAMS[0];
#endif
}

static void set_start_values(Instance *instance) {
    Situation *now = &instance->now;
    memset(now, 0, sizeof *now);
    now->phase = INSTANTIATED;
    now->outdated = 1;
    now->stop_time = INFINITY;
    for (int i = 0; i < N_VARIABLES; i++) now->values[i] = VARIABLES[i].start;
}

/* Outputs and state at the start, or fmi2Error and the reasons why there are none. */
static fmi2Status initialize(Instance *instance) {
    Situation *now = &instance->now;
    double holds[N_RULES + 1], *results = instance->results[0];
    fmi2Status status = check_inputs(instance, fmi2Error);

    rules(now->values, now->values + PARAMETERS, holds);
    for (int i = 0; i < N_RULES; i++) {
        char message[512];
        if (holds[i] != 0) continue;
        rule_message(i, now->values, message, sizeof message);
        status = report(&instance->log, fmi2Error, "%s", message);
    }
    if (status != fmi2OK) return status;

    program(instance)->start(now->values, now->values + PARAMETERS, now->time, results, results + N_OUTPUTS);
    if (!all_finite(results, N_OUTPUTS + program(instance)->states)) {
        return not_finite(instance, fmi2Error, "the initialization");
    }
    memset(now->values + STATES, 0, N_STATES * sizeof(double)); /* another program may have had more of them */
    memcpy(now->values + OUTPUTS, results, (N_OUTPUTS + program(instance)->states) * sizeof(double));
    now->outdated = 0;
    return fmi2OK;
}

/* The outputs after an input has changed, where they depend on one directly. fmi2Discard if they cannot be calculated. */
static fmi2Status recalculate(Instance *instance) {
    Situation *now = &instance->now;
    double *outputs = instance->results[0];
    if (program(instance)->output) {
        if (check_inputs(instance, fmi2Discard) != fmi2OK) return fmi2Discard;
        program(instance)->output(now->values, now->values + PARAMETERS, now->values + STATES, now->time, outputs);
        if (!all_finite(outputs, N_OUTPUTS)) return not_finite(instance, fmi2Discard, "the calculation of the outputs");
        memcpy(now->values + OUTPUTS, outputs, N_OUTPUTS * sizeof(double));
    }
    now->outdated = 0;
    return fmi2OK;
}

/* One communication step, divided where the model needs shorter ones. fmi2Discard if its result is not finite. */
static fmi2Status advance(Instance *instance, double t, double h) {
    Situation *now = &instance->now;
    const Program *equations = program(instance);
    const double *outputs = now->values + OUTPUTS;
    const int divisions = (int)fmax(1, ceil(h / MAX_STEP - 1e-9));
    const double step = h / divisions;

    for (int i = 0; i < divisions; i++) {
        double *next = instance->results[i % 2];
        equations->step(now->values, now->values + PARAMETERS, outputs + N_OUTPUTS, t + i * step, step, next,
                        next + N_OUTPUTS);
        outputs = next;
    }
    if (!all_finite(outputs, N_OUTPUTS + equations->states)) {
        return not_finite(instance, fmi2Discard, "the step");
    }
    memcpy(now->values + OUTPUTS, outputs, (N_OUTPUTS + equations->states) * sizeof(double));
    now->time = t + h;
    now->outdated = 0;
    return fmi2OK;
}

/* Life of an instance ---------------------------------------------------------------------------------------------- */

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

/* The model needs no resources: their location is not looked at. */
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging_on) {
    Instance *instance;
    Log log = {NULL, NULL, name ? name : "", DISCARDS | ERRORS};
    (void)resources, (void)visible, (void)logging_on; /* there are no messages but those of failures */

    if (!functions) return NULL;
    log.logger = functions->logger;
    log.environment = functions->componentEnvironment;
    if (!name || !*name) {
        report(&log, fmi2Error, "fmi2Instantiate: the instance has no name");
        return NULL;
    }
    if (type != fmi2CoSimulation) {
        report(&log, fmi2Error, "fmi2Instantiate: the FMU is for co-simulation only");
        return NULL;
    }
    if (!guid || strcmp(guid, GUID) != 0) {
        report(&log, fmi2Error, "fmi2Instantiate: guid = %s is not allowed; the binary is of %s", guid ? guid : "NULL",
               GUID);
        return NULL;
    }
    instance = calloc(1, sizeof *instance + strlen(name) + 1);
    if (!instance) {
        report(&log, fmi2Error, "fmi2Instantiate: there is no memory");
        return NULL;
    }
    strcpy(instance->name, name);
    log.name = instance->name;
    instance->log = log;
    set_start_values(instance);
    return instance;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[]) {
    Instance *instance = c;
    unsigned named = 0;
    if (expect(instance, ANY, "fmi2SetDebugLogging") != fmi2OK) return fmi2Error;
    if (count > 0 && !categories) return null_pointer(instance, "fmi2SetDebugLogging");
    for (size_t i = 0; i < count; i++) {
        int k = 0;
        if (!categories[i]) return null_pointer(instance, "fmi2SetDebugLogging");
        while (k < N_CATEGORIES && strcmp(categories[i], CATEGORIES[k]) != 0) k++;
        if (k == N_CATEGORIES) {
            return report(&instance->log, fmi2Error, "fmi2SetDebugLogging: there is no category %s", categories[i]);
        }
        named |= 1u << k;
    }
    if (count == 0) named = DISCARDS | ERRORS | ALL;
    instance->log.categories = on ? named : instance->log.categories & ~named;
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start_time,
                               fmi2Boolean stop_time_defined, fmi2Real stop_time) {
    Instance *instance = c;
    (void)tolerance_defined, (void)tolerance; /* the step sizes are fixed */
    if (expect(instance, INSTANTIATED, "fmi2SetupExperiment") != fmi2OK) return fmi2Error;
    if (!isfinite(start_time)) {
        return report(&instance->log, fmi2Error, "startTime = %.12g s is not allowed; it must be finite", start_time);
    }
    if (stop_time_defined && !(stop_time >= start_time)) {
        return report(&instance->log, fmi2Error, "stopTime = %.12g s is not allowed; it must be in [startTime = %.12g, "
                      "inf] s", stop_time, start_time);
    }
    instance->now.time = start_time;
    instance->now.stop_time = stop_time_defined ? stop_time : INFINITY;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Instance *instance = c;
    if (expect(instance, INSTANTIATED, "fmi2EnterInitializationMode") != fmi2OK) return fmi2Error;
    instance->now.phase = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    Instance *instance = c;
    if (expect(instance, INITIALIZATION, "fmi2ExitInitializationMode") != fmi2OK) return fmi2Error;
    if (instance->now.outdated && initialize(instance) != fmi2OK) return fmi2Error;
    instance->now.phase = STEP_COMPLETE;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c) {
    Instance *instance = c;
    if (expect(instance, STEP_COMPLETE | STEP_FAILED, "fmi2Terminate") != fmi2OK) return fmi2Error;
    instance->now.phase = TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c) {
    Instance *instance = c;
    if (expect(instance, ANY, "fmi2Reset") != fmi2OK) return fmi2Error;
    set_start_values(instance);
    return fmi2OK;
}

/* Steps ------------------------------------------------------------------------------------------------------------ */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_set_fmu_state_prior) {
    Instance *instance = c;
    double tolerance;
    fmi2Status status;
    (void)no_set_fmu_state_prior;
    if (expect(instance, STEP_COMPLETE, "fmi2DoStep") != fmi2OK) return fmi2Error;
    if (!(h > 0 && isfinite(h))) {
        return report(&instance->log, fmi2Error, "communicationStepSize = %.12g s is not allowed; it must be above 0 s",
                      h);
    }
    tolerance = fmax(ON_TIME * h, 8 * DBL_EPSILON * fabs(t));
    if (!(fabs(t - instance->now.time) <= tolerance)) {
        return report(&instance->log, fmi2Error, "currentCommunicationPoint = %.12g s is not allowed; the last step "
                      "ended at %.12g s", t, instance->now.time);
    }
    if (t + h > instance->now.stop_time + tolerance) {
        return report(&instance->log, fmi2Error, "a step to %.12g s is not allowed; stopTime = %.12g s", t + h,
                      instance->now.stop_time);
    }
    if (h / MAX_STEP > MAX_DIVISIONS) {
        status = report(&instance->log, fmi2Discard, "communicationStepSize = %.12g s is not allowed; it must be in "
                        "(0, %.12g] s", h, MAX_STEP * MAX_DIVISIONS);
    } else {
        status = check_inputs(instance, fmi2Discard);
    }
    if (status == fmi2OK) status = advance(instance, t, h);
    if (status != fmi2OK) instance->now.phase = STEP_FAILED;
    return status;
}

fmi2Status fmi2CancelStep(fmi2Component c) { return expect(c, 0, "fmi2CancelStep"); } /* no step is ever in progress */

/* fmi2Discard for what only a step in progress could tell. */
static fmi2Status status_of(fmi2Component c, const char *function, int known, const void *value) {
    const Instance *instance = c;
    if (expect(instance, INITIALIZED, function) != fmi2OK) return fmi2Error;
    if (!value) return null_pointer(instance, function);
    if (!known) return report(&instance->log, fmi2Discard, "%s: the slave has no status of this kind", function);
    return fmi2OK;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)kind;
    return status_of(c, "fmi2GetStatus", 0, value);
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    const fmi2Status status = status_of(c, "fmi2GetRealStatus", kind == fmi2LastSuccessfulTime, value);
    if (status == fmi2OK) *value = ((Instance *)c)->now.time;
    return status;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)kind;
    return status_of(c, "fmi2GetIntegerStatus", 0, value);
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    const fmi2Status status = status_of(c, "fmi2GetBooleanStatus", kind == fmi2Terminated, value);
    if (status == fmi2OK) *value = fmi2False; /* the slave never asks to end the run */
    return status;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)kind;
    return status_of(c, "fmi2GetStringStatus", 0, value);
}

/* Getting and setting ---------------------------------------------------------------------------------------------- */

/* fmi2Error unless every reference is that of a variable of the type. Some importers set and read all as Reals. */
static fmi2Status check_references(const Instance *instance, const char *function, Type type,
                                   const fmi2ValueReference references[], size_t count, const void *values) {
    if (count > 0 && (!references || !values)) return null_pointer(instance, function);
    for (size_t i = 0; i < count; i++) {
        if (references[i] >= N_VARIABLES || (VARIABLES[references[i]].type != type && type != REAL)) {
            return report(&instance->log, fmi2Error, "%s: there is no such variable with value reference %u", function,
                          references[i]);
        }
    }
    return fmi2OK;
}

/* A forged FMU state may hold any number. */
static int whole(double value) { return value >= INT_MIN && value <= INT_MAX ? (int)value : 0; }

static fmi2Status get(fmi2Component c, const char *function, Type type, const fmi2ValueReference references[],
                      size_t count, void *values) {
    Instance *instance = c;
    if (expect(instance, INITIALIZATION | INITIALIZED, function) != fmi2OK) return fmi2Error;
    if (check_references(instance, function, type, references, count, values) != fmi2OK) return fmi2Error;
    for (size_t i = 0; i < count; i++) {
        if (VARIABLES[references[i]].role == OUTPUT && instance->now.outdated) {
            fmi2Status status = fmi2OK;
            if (instance->now.phase == INITIALIZATION) status = initialize(instance);
            if (instance->now.phase == STEP_COMPLETE) status = recalculate(instance);
            if (status != fmi2OK) return status;
        }
        if (type == REAL) {
            ((fmi2Real *)values)[i] = instance->now.values[references[i]];
        } else {
            ((fmi2Integer *)values)[i] = whole(instance->now.values[references[i]]); /* or fmi2Boolean, an int too */
        }
    }
    return fmi2OK;
}

static double value_at(Type type, const void *values, size_t i) {
    if (type == REAL) return ((const fmi2Real *)values)[i];
    return type == INTEGER ? ((const fmi2Integer *)values)[i] : ((const fmi2Boolean *)values)[i] != fmi2False;
}

static fmi2Status set(fmi2Component c, const char *function, Type type, const fmi2ValueReference references[],
                      size_t count, const void *values) {
    Instance *instance = c;
    if (expect(instance, INSTANTIATED | INITIALIZATION | STEP_COMPLETE, function) != fmi2OK) return fmi2Error;
    if (check_references(instance, function, type, references, count, values) != fmi2OK) return fmi2Error;
    for (size_t i = 0; i < count; i++) {
        const fmi2ValueReference k = references[i];
        const double value = value_at(type, values, i);
        const Role role = VARIABLES[k].role;
        if (role == OUTPUT || (role == FIXED_PARAMETER && instance->now.phase == STEP_COMPLETE)) {
            return report(&instance->log, fmi2Error, "%s: %s, %s, cannot be set while the slave is %s", function,
                          VARIABLES[k].name, role == OUTPUT ? "an output" : "a fixed parameter",
                          phase_name(instance->now.phase));
        }
        if (role == INPUT && VARIABLES[k].type == REAL) continue;
        if (!in_range(k, value) || (VARIABLES[k].type != REAL && floor(value) != value)) {
            return out_of_range(instance, fmi2Discard, k, value);
        }
    }
    for (size_t i = 0; i < count; i++) instance->now.values[references[i]] = value_at(type, values, i);
    if (count > 0) instance->now.outdated = 1;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Real values[]) {
    return get(c, "fmi2GetReal", REAL, references, count, values);
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Integer values[]) {
    return get(c, "fmi2GetInteger", INTEGER, references, count, values);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Boolean values[]) {
    return get(c, "fmi2GetBoolean", BOOLEAN, references, count, values);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, const fmi2Real values[]) {
    return set(c, "fmi2SetReal", REAL, references, count, values);
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count,
                          const fmi2Integer values[]) {
    return set(c, "fmi2SetInteger", INTEGER, references, count, values);
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference references[], size_t count,
                          const fmi2Boolean values[]) {
    return set(c, "fmi2SetBoolean", BOOLEAN, references, count, values);
}

static fmi2Status no_strings(fmi2Component c, int phases, const char *function, size_t count) {
    const Instance *instance = c;
    if (expect(instance, phases, function) != fmi2OK) return fmi2Error;
    return count == 0 ? fmi2OK : report(&instance->log, fmi2Error, "%s: there are no String variables", function);
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2String values[]) {
    (void)references, (void)values;
    return no_strings(c, INITIALIZATION | INITIALIZED, "fmi2GetString", count);
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference references[], size_t count,
                         const fmi2String values[]) {
    (void)references, (void)values;
    return no_strings(c, INSTANTIATED | INITIALIZATION | STEP_COMPLETE, "fmi2SetString", count);
}

/* FMU states ------------------------------------------------------------------------------------------------------- */

/* FNV-1a, 64 bit. */
static uint64_t checksum_of(const Situation *situation) {
    const unsigned char *bytes = (const unsigned char *)situation;
    uint64_t hash = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < sizeof *situation; i++) hash = (hash ^ bytes[i]) * UINT64_C(1099511628211);
    return hash;
}

/* What is wrong with a snapshot that may come from anywhere, or NULL. Its numbers are looked at as well: an instance
   relies on its parameters being in range. */
static const char *flaw(const Snapshot *snapshot) {
    const Situation *situation = &snapshot->situation;
    if (snapshot->magic != MAGIC) return "is not one of an FMU of this kind";
    if (memcmp(snapshot->guid, GUID, sizeof GUID) != 0) return "is that of another FMU";
    if (snapshot->checksum != checksum_of(situation)) return "is damaged";
    if (situation->phase < INSTANTIATED || situation->phase > TERMINATED || situation->phase & (situation->phase - 1)) {
        return "is damaged";
    }
    for (int i = PARAMETERS; i < OUTPUTS; i++) {
        const double value = situation->values[i];
        if (!in_range(i, value) || (VARIABLES[i].type != REAL && floor(value) != value)) return "is damaged";
    }
    return all_finite(situation->values + OUTPUTS, N_OUTPUTS + N_STATES) && isfinite(situation->time) ? NULL
                                                                                                    : "is damaged";
}

static fmi2Status refuse(const Instance *instance, const char *function, const char *reason) {
    return report(&instance->log, fmi2Error, "%s: the FMU state %s", function, reason);
}

/* The snapshot that *state points to, or a new one. */
static Snapshot *snapshot_for(fmi2FMUstate *state) {
    if (!*state) *state = calloc(1, sizeof(Snapshot));
    return *state;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    const Instance *instance = c;
    Snapshot *snapshot;
    if (expect(instance, ANY, "fmi2GetFMUstate") != fmi2OK) return fmi2Error;
    if (!state) return null_pointer(instance, "fmi2GetFMUstate");
    snapshot = snapshot_for(state);
    if (!snapshot) return refuse(instance, "fmi2GetFMUstate", "has no memory");
    snapshot->magic = MAGIC;
    memcpy(snapshot->guid, GUID, sizeof GUID);
    snapshot->situation = instance->now;
    snapshot->checksum = checksum_of(&snapshot->situation);
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    Instance *instance = c;
    const Snapshot *snapshot = state;
    const char *reason;
    if (expect(instance, ANY, "fmi2SetFMUstate") != fmi2OK) return fmi2Error;
    if (!snapshot) return null_pointer(instance, "fmi2SetFMUstate");
    reason = flaw(snapshot);
    if (reason) return refuse(instance, "fmi2SetFMUstate", reason);
    instance->now = snapshot->situation;
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    const Instance *instance = c;
    if (expect(instance, ANY, "fmi2FreeFMUstate") != fmi2OK) return fmi2Error;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    const Instance *instance = c;
    if (expect(instance, ANY, "fmi2SerializedFMUstateSize") != fmi2OK) return fmi2Error;
    if (!state || !size) return null_pointer(instance, "fmi2SerializedFMUstateSize");
    *size = sizeof(Snapshot);
    return fmi2OK;
}

static fmi2Status check_size(const Instance *instance, const char *function, size_t size) {
    if (size == sizeof(Snapshot)) return fmi2OK;
    return report(&instance->log, fmi2Error, "%s: size = %lu is not allowed; it must be %lu", function,
                  (unsigned long)size, (unsigned long)sizeof(Snapshot));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
    const Instance *instance = c;
    if (expect(instance, ANY, "fmi2SerializeFMUstate") != fmi2OK) return fmi2Error;
    if (!state || !bytes) return null_pointer(instance, "fmi2SerializeFMUstate");
    if (check_size(instance, "fmi2SerializeFMUstate", size) != fmi2OK) return fmi2Error;
    memcpy(bytes, state, size);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
    const Instance *instance = c;
    Snapshot snapshot;
    const char *reason;
    if (expect(instance, ANY, "fmi2DeSerializeFMUstate") != fmi2OK) return fmi2Error;
    if (!bytes || !state) return null_pointer(instance, "fmi2DeSerializeFMUstate");
    if (check_size(instance, "fmi2DeSerializeFMUstate", size) != fmi2OK) return fmi2Error;
    memcpy(&snapshot, bytes, sizeof snapshot);
    reason = flaw(&snapshot);
    if (reason) return refuse(instance, "fmi2DeSerializeFMUstate", reason);
    if (!snapshot_for(state)) return refuse(instance, "fmi2DeSerializeFMUstate", "has no memory");
    *(Snapshot *)*state = snapshot;
    return fmi2OK;
}

/* What modelDescription.xml says the slave cannot do; exported because some importers bind every name of FMI 2.0. ---- */

#define NOT_SUPPORTED(function, unused, ...) \
    fmi2Status function(fmi2Component c, __VA_ARGS__) { \
        unused; \
        return not_supported(c, #function); \
    }

NOT_SUPPORTED(fmi2GetDirectionalDerivative,
              ((void)unknowns, (void)n_unknowns, (void)knowns, (void)n_knowns, (void)seed, (void)sensitivity),
              const fmi2ValueReference unknowns[], size_t n_unknowns, const fmi2ValueReference knowns[],
              size_t n_knowns, const fmi2Real seed[], fmi2Real sensitivity[])
NOT_SUPPORTED(fmi2SetRealInputDerivatives, ((void)references, (void)count, (void)order, (void)values),
              const fmi2ValueReference references[], size_t count, const fmi2Integer order[], const fmi2Real values[])
NOT_SUPPORTED(fmi2GetRealOutputDerivatives, ((void)references, (void)count, (void)order, (void)values),
              const fmi2ValueReference references[], size_t count, const fmi2Integer order[], fmi2Real values[])
NOT_SUPPORTED(fmi2NewDiscreteStates, (void)info, fmi2EventInfo *info)
NOT_SUPPORTED(fmi2CompletedIntegratorStep, ((void)no_set_fmu_state_prior, (void)enter_event_mode, (void)terminate),
              fmi2Boolean no_set_fmu_state_prior, fmi2Boolean *enter_event_mode, fmi2Boolean *terminate)
NOT_SUPPORTED(fmi2SetTime, (void)time, fmi2Real time)
NOT_SUPPORTED(fmi2SetContinuousStates, ((void)states, (void)count), const fmi2Real states[], size_t count)
NOT_SUPPORTED(fmi2GetDerivatives, ((void)derivatives, (void)count), fmi2Real derivatives[], size_t count)
NOT_SUPPORTED(fmi2GetEventIndicators, ((void)indicators, (void)count), fmi2Real indicators[], size_t count)
NOT_SUPPORTED(fmi2GetContinuousStates, ((void)states, (void)count), fmi2Real states[], size_t count)
NOT_SUPPORTED(fmi2GetNominalsOfContinuousStates, ((void)nominals, (void)count), fmi2Real nominals[], size_t count)

fmi2Status fmi2EnterEventMode(fmi2Component c) { return not_supported(c, "fmi2EnterEventMode"); }

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return not_supported(c, "fmi2EnterContinuousTimeMode"); }

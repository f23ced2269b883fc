/* A hostile host, compiled together with the slave of one model so that a sanitizer sees both.

   hardening fuzz SEED CALLS     random calls with random arguments; what has to hold after each of them is checked
   hardening instances COUNT     as many instances made, stepped and freed; LeakSanitizer has the last word
   hardening threads COUNT       as many threads with an instance each: results as of one thread, to the bit
   hardening allocations STEPS   steps with malloc and its kind counted (linked with --wrap) */

#include "fmi2_slave.c"

#include <pthread.h>

/* Random numbers (xorshift64*) ------------------------------------------------------------------------------------- */

static uint64_t seed;

static uint64_t random_bits(void) {
    seed ^= seed >> 12, seed ^= seed << 25, seed ^= seed >> 27;
    return seed * UINT64_C(2685821657736338717);
}

static unsigned any_below(unsigned n) { return (unsigned)(random_bits() >> 33) % n; }

static int one_in(unsigned n) { return any_below(n) == 0; }

static double any_real(void) {
    static const double SPECIAL[] = {0, -0.0, 1, -1, 5e-324, 1e-300, 1e300, -1e300, INT_MAX, INT_MIN, 0.1};
    union {
        uint64_t bits;
        double value;
    } any = {random_bits()};
    switch (any_below(8)) {
    case 0: return NAN;
    case 1: return one_in(2) ? INFINITY : -INFINITY;
    case 2: return SPECIAL[any_below(sizeof SPECIAL / sizeof *SPECIAL)];
    case 3: return any.value;
    default: return 4.0 * any_below(1000000) / 1e6 - 2;
    }
}

/* What is expected of the slave ------------------------------------------------------------------------------------ */

static __thread const char *last_call = "";

static void fail(const char *what) {
    fprintf(stderr, "%s: %s\n", last_call, what);
    exit(1);
}

static fmi2Status expect_status(fmi2Status status) {
    if (status != fmi2OK && status != fmi2Discard && status != fmi2Error) fail("a status that is not OK, Discard or Error");
    return status;
}

#define CALL(function, ...) (last_call = #function, expect_status(function(__VA_ARGS__)))

static long messages, steps;

static void log_message(fmi2ComponentEnvironment environment, fmi2String instance, fmi2Status status,
                        fmi2String category, fmi2String form, ...) {
    va_list arguments;
    (void)environment, (void)status;
    if (!instance || !category || strcmp(form, "%s") != 0) fail("a message without a name, a category or a form");
    va_start(arguments, form);
    messages += (long)strlen(va_arg(arguments, const char *));
    va_end(arguments);
}

static const fmi2CallbackFunctions CALLBACKS = {log_message, calloc, free, NULL, NULL};

static fmi2Component good_instance(void) {
    fmi2Component c = fmi2Instantiate("slave", fmi2CoSimulation, MODEL_GUID, "file:///", &CALLBACKS, fmi2False, fmi2True);
    if (!c) fail("no instance");
    return c;
}

static void initialized(fmi2Component c) {
    if (CALL(fmi2SetupExperiment, c, fmi2False, 0, 0, fmi2False, 0) != fmi2OK) fail("not set up");
    if (CALL(fmi2EnterInitializationMode, c) != fmi2OK) fail("not in initialization mode");
    if (CALL(fmi2ExitInitializationMode, c) != fmi2OK) fail("not initialized");
}

/* Inputs that a machine could have. */
static void set_plausible_inputs(fmi2Component c, double t) {
    for (fmi2ValueReference i = 0; i < N_INPUTS; i++) {
        const double value = VARIABLES[i].start + 0.5 + 0.01 * sin(6 * t + (double)i);
        if (VARIABLES[i].type == REAL) CALL(fmi2SetReal, c, &i, 1, &value);
    }
}

static void plausible_step(fmi2Component c, int k) {
    const double h = 1.0 / 64;
    set_plausible_inputs(c, k * h);
    if (CALL(fmi2DoStep, c, k * h, h, fmi2True) != fmi2OK) fail("a step that is not done");
}

/* Fuzzing ---------------------------------------------------------------------------------------------------------- */

enum { SLOTS = 4, MOST = 12 };

static fmi2Component instances[SLOTS];
static fmi2FMUstate states[SLOTS];
static fmi2Byte blob[sizeof(Snapshot) + 8];

static const char *any_text(void) {
    static const char *const TEXTS[] = {NULL, "", "a", "100 %s %n %", "file:///a%20b", "file://%", "\xff\xfe", MODEL_GUID,
                                        "{00000000-0000-0000-0000-000000000000}", "logStatusError", "logAll", "log"};
    static char noise[300];
    if (!one_in(4)) return TEXTS[any_below(sizeof TEXTS / sizeof *TEXTS)];
    for (size_t i = 0; i + 1 < sizeof noise; i++) noise[i] = (char)(1 + any_below(255));
    noise[any_below(sizeof noise)] = 0;
    return noise;
}

static void fuzz_instantiate(unsigned slot) {
    const fmi2CallbackFunctions silent = {one_in(2) ? log_message : NULL, NULL, NULL, NULL, NULL};
    const int good = !one_in(3);
    last_call = "fmi2Instantiate";
    fmi2FreeInstance(instances[slot]);
    instances[slot] = fmi2Instantiate(good ? "slave" : any_text(), good ? fmi2CoSimulation : (fmi2Type)any_below(3),
                                      good ? MODEL_GUID : any_text(), any_text(), one_in(20) ? NULL : &silent,
                                      (fmi2Boolean)any_below(2), (fmi2Boolean)any_below(2));
}

static void fuzz_values(fmi2Component c) {
    fmi2ValueReference references[MOST];
    fmi2Real reals[MOST];
    fmi2Integer integers[MOST];
    fmi2String strings[MOST] = {0};
    const size_t count = one_in(10) ? 0 : 1 + any_below(one_in(4) ? MOST : 1);
    const int set = one_in(2);
    for (size_t i = 0; i < count; i++) {
        references[i] = one_in(20) ? (fmi2ValueReference)random_bits() : any_below(N_VARIABLES + 2);
        reals[i] = references[i] >= N_VARIABLES || one_in(3)
                       ? any_real()
                       : VARIABLES[references[i]].start + one_in(2) * 0.1 * any_below(10);
        integers[i] = one_in(4) ? (fmi2Integer)random_bits() : (fmi2Integer)any_below(8);
    }
    switch (one_in(3) ? any_below(4) : 0) {
    case 0:
        if (set) {
            CALL(fmi2SetReal, c, one_in(50) ? NULL : references, count, one_in(50) ? NULL : reals);
        } else if (CALL(fmi2GetReal, c, references, count, reals) == fmi2OK) {
            for (size_t i = 0; i < count; i++) {
                if (VARIABLES[references[i]].role != INPUT && !isfinite(reals[i])) fail("a value that is not finite");
            }
        }
        return;
    case 1: set ? CALL(fmi2SetInteger, c, references, count, integers) : CALL(fmi2GetInteger, c, references, count, integers); return;
    case 2: set ? CALL(fmi2SetBoolean, c, references, count, integers) : CALL(fmi2GetBoolean, c, references, count, integers); return;
    default: set ? CALL(fmi2SetString, c, references, count, strings) : CALL(fmi2GetString, c, references, count, strings);
    }
}

static void fuzz_step(fmi2Component c) {
    const Instance *instance = c;
    const double h = one_in(10) ? any_real() : one_in(4) ? 0.1 * any_below(1000) / 1e3 : 1.0 / 60;
    const double t = one_in(20) ? any_real() : instance->now.time;
    if (h / MAX_STEP > 1e2 && h / MAX_STEP <= MAX_DIVISIONS) return; /* legal, and slow */
    if (!one_in(4)) set_plausible_inputs(c, t);
    if (CALL(fmi2DoStep, c, t, h, (fmi2Boolean)any_below(2)) == fmi2OK) steps++;
}

static void fuzz_state(fmi2Component c) {
    fmi2FMUstate *state = &states[any_below(SLOTS)];
    size_t size;
    switch (any_below(7)) {
    case 0: CALL(fmi2GetFMUstate, c, state); return;
    case 1: CALL(fmi2SetFMUstate, c, *state); return;
    case 2: CALL(fmi2FreeFMUstate, c, one_in(10) ? NULL : state); return;
    case 3: CALL(fmi2SerializedFMUstateSize, c, *state, one_in(10) ? NULL : &size); return;
    case 4: CALL(fmi2SerializeFMUstate, c, *state, blob, one_in(4) ? any_below(sizeof blob) : sizeof(Snapshot)); return;
    case 5: { /* some bytes changed, and perhaps signed anew */
        Snapshot forged;
        for (unsigned n = any_below(4); n > 0; n--) blob[any_below(sizeof(Snapshot))] = (fmi2Byte)random_bits();
        memcpy(&forged, blob, sizeof forged);
        if (one_in(2)) forged.situation.values[any_below(N_VALUES)] = any_real();
        forged.checksum = checksum_of(&forged.situation);
        if (one_in(2)) memcpy(blob, &forged, sizeof forged);
        return;
    }
    default: CALL(fmi2DeSerializeFMUstate, c, blob, one_in(4) ? any_below(sizeof blob) : sizeof(Snapshot), state);
    }
}

static void fuzz_others(fmi2Component c) {
    fmi2String categories[3], text;
    fmi2Status status;
    fmi2Integer integer = 0;
    fmi2Real real = 0;
    fmi2ValueReference reference = any_below(N_VARIABLES + 2);
    const fmi2StatusKind kind = (fmi2StatusKind)any_below(5);
    for (int i = 0; i < 3; i++) categories[i] = any_text();
    switch (any_below(14)) {
    case 0: CALL(fmi2SetDebugLogging, c, (fmi2Boolean)any_below(2), any_below(4), categories); return;
    case 1: CALL(fmi2GetStatus, c, kind, one_in(9) ? NULL : &status); return;
    case 2: CALL(fmi2GetRealStatus, c, kind, one_in(9) ? NULL : &real); return;
    case 3: CALL(fmi2GetIntegerStatus, c, kind, &integer); return;
    case 4: CALL(fmi2GetBooleanStatus, c, kind, one_in(9) ? NULL : &integer); return;
    case 5: CALL(fmi2GetStringStatus, c, kind, &text); return;
    case 6: CALL(fmi2CancelStep, c); return;
    case 7: CALL(fmi2GetDirectionalDerivative, c, &reference, 1, &reference, 1, &real, &real); return;
    case 8: CALL(fmi2SetRealInputDerivatives, c, &reference, 1, &integer, &real); return;
    case 9: CALL(fmi2GetRealOutputDerivatives, c, &reference, 1, &integer, &real); return;
    case 10: CALL(fmi2SetTime, c, real); return;
    case 11: CALL(fmi2GetContinuousStates, c, &real, 1); return;
    case 12: CALL(fmi2NewDiscreteStates, c, NULL); return;
    default: CALL(fmi2EnterEventMode, c);
    }
}

static void choose_program(fmi2Component c) {
#ifdef SELECTOR
    const fmi2ValueReference selector = SELECTOR;
    const fmi2Integer item = 1 + (fmi2Integer)any_below(SELECTED);
    CALL(fmi2SetInteger, c, &selector, 1, &item);
#ifdef VARIANT
    const fmi2ValueReference variant = VARIANT;
    const fmi2Integer of_it = 1 + (fmi2Integer)any_below(sizeof PROGRAMS / sizeof *PROGRAMS / SELECTED);
    CALL(fmi2SetInteger, c, &variant, 1, &of_it);
#endif
#else
    (void)c;
#endif
}

static void fuzz_phase(fmi2Component c) {
    switch (any_below(50)) {
    case 0: CALL(fmi2SetupExperiment, c, one_in(2), any_real(), any_real(), one_in(4), any_real()); return;
    case 1: CALL(fmi2Reset, c); return;
    case 2: CALL(fmi2Terminate, c); return;
    default: /* on with the run */
        switch (((const Instance *)c)->now.phase) {
        case INSTANTIATED: choose_program(c), CALL(fmi2EnterInitializationMode, c); return;
        case INITIALIZATION: if (CALL(fmi2ExitInitializationMode, c) != fmi2OK) CALL(fmi2Reset, c); return;
        case STEP_COMPLETE: CALL(fmi2ExitInitializationMode, c); return;
        default: CALL(fmi2Reset, c);
        }
    }
}

static void fuzz(uint64_t first, long calls) {
    seed = first * 2 + 1;
    for (long i = 0; i < calls; i++) {
        const unsigned slot = any_below(SLOTS), what = any_below(100);
        fmi2Component c = instances[slot];
        if (!c || one_in(2000)) {
            fuzz_instantiate(slot);
        } else if (one_in(500)) {
            CALL(fmi2DoStep, NULL, 0, 1, fmi2True), CALL(fmi2Reset, NULL), CALL(fmi2SetFMUstate, NULL, NULL);
        } else if (what < 45) {
            fuzz_step(c);
        } else if (what < 80) {
            fuzz_values(c);
        } else if (what < 88) {
            fuzz_state(c);
        } else if (what < 92) {
            fuzz_others(c);
        } else {
            fuzz_phase(c);
        }
    }
    for (int i = 0; i < SLOTS; i++) {
        fmi2Component c = good_instance();
        CALL(fmi2FreeFMUstate, c, &states[i]);
        fmi2FreeInstance(c);
        fmi2FreeInstance(instances[i]);
    }
    printf("%ld calls, %ld steps done, %ld characters of messages\n", calls, steps, messages);
}

/* Instances and threads -------------------------------------------------------------------------------------------- */

static void many_instances(int count) {
    for (int i = 0; i < count; i++) {
        fmi2Component c = good_instance();
        fmi2FMUstate state = NULL;
        initialized(c);
        plausible_step(c, 0);
        CALL(fmi2GetFMUstate, c, &state);
        CALL(fmi2FreeFMUstate, c, &state);
        fmi2FreeInstance(c);
    }
    printf("%d instances made, stepped and freed\n", count);
}

static void *run_one(void *result) {
    fmi2Component c = good_instance();
    initialized(c);
    for (int k = 0; k < 500; k++) plausible_step(c, k);
    memcpy(result, ((Instance *)c)->now.values, N_VALUES * sizeof(double));
    fmi2FreeInstance(c);
    return NULL;
}

static void many_threads(int count) {
    static double alone[N_VALUES], together[64][N_VALUES];
    pthread_t threads[64];
    run_one(alone);
    for (int i = 0; i < count; i++) pthread_create(&threads[i], NULL, run_one, together[i]);
    for (int i = 0; i < count; i++) {
        pthread_join(threads[i], NULL);
        if (memcmp(alone, together[i], sizeof alone) != 0) fail("another result than alone");
    }
    printf("%d threads with the results of one\n", count);
}

/* Allocations ------------------------------------------------------------------------------------------------------ */

#ifdef COUNT_ALLOCATIONS

static long allocations;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t size);

void *__wrap_malloc(size_t size) { return allocations++, __real_malloc(size); }

void *__wrap_calloc(size_t count, size_t size) { return allocations++, __real_calloc(count, size); }

void *__wrap_realloc(void *memory, size_t size) { return allocations++, __real_realloc(memory, size); }

static void count_allocations(int steps) {
    fmi2Component c = good_instance();
    long before;
    if (allocations != 1) fail("an instance is not one allocation");
    initialized(c);
    before = allocations;
    for (int k = 0; k < steps; k++) plausible_step(c, k);
    CALL(fmi2DoStep, c, -1, 1, fmi2True); /* refused, with a message */
    if (allocations != before) fail("an allocation in a step");
    fmi2FreeInstance(c);
    printf("%d steps without an allocation\n", steps);
}

#endif

int main(int count, char **arguments) {
    const long number = count > 2 ? atol(arguments[2]) : 0;
    const char *what = count > 2 ? arguments[1] : "";
    if (strcmp(what, "fuzz") == 0 && count > 3) {
        fuzz((uint64_t)number, atol(arguments[3]));
    } else if (strcmp(what, "instances") == 0) {
        many_instances((int)number);
    } else if (strcmp(what, "threads") == 0) {
        many_threads((int)number);
#ifdef COUNT_ALLOCATIONS
    } else if (strcmp(what, "allocations") == 0) {
        count_allocations((int)number);
#endif
    } else {
        fprintf(stderr, "hardening fuzz SEED CALLS | instances COUNT | threads COUNT | allocations STEPS\n");
        return 2;
    }
    return 0;
}

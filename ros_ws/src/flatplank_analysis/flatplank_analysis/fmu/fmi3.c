/* SPDX-License-Identifier: Apache-2.0
   FMI 3.0 for co-simulation, of a tire whose equations are in tire.c. Inputs hold over a step. */
#include "tire.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#define API __declspec(dllexport)
#else
#define API __attribute__((visibility("default")))
#endif

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;
typedef enum { INSTANTIATED, INITIALIZATION, STEP, TERMINATED } Phase;
typedef uint32_t Ref;
typedef const char *String;
typedef const uint8_t *Binary;
typedef void (*Log)(void *environment, Status status, String category, String message);

typedef struct {
    double value[N_VALUES];
    double state[N_STATES];
    Phase phase;
} Content;

typedef struct {
    Content now;
    void *environment;
    Log log;
} Instance;

static Status failed(Instance *self, String message) {
    if (self->log) self->log(self->environment, ERROR, "logStatusError", message);
    return ERROR;
}

static void reset(Instance *self) {
    memcpy(self->now.value, START_VALUES, sizeof self->now.value);
    memset(self->now.state, 0, sizeof self->now.state);
    self->now.phase = INSTANTIATED;
}

static void begin(Instance *self) {
    double *v = self->now.value;
    tire_start(v + FIRST_INPUT, self->now.state, v + FIRST_OUTPUT);
}

API String fmi3GetVersion(void) { return "3.0"; }

API Status fmi3SetDebugLogging(void *self, bool on, size_t n, const String categories[]) {
    (void)self, (void)on, (void)n, (void)categories;
    return OK;
}

API void *fmi3InstantiateCoSimulation(
    String name, String token, String resources, bool visible, bool logging, bool events,
    bool early, const Ref intermediate[], size_t n, void *environment, Log log, void *update) {
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
    (void)intermediate, (void)n, (void)update;
    Instance *self = calloc(1, sizeof *self);
    if (!self) return NULL;
    self->environment = environment;
    self->log = log;
    reset(self);
    if (strcmp(token, TOKEN) != 0) {
        failed(self, "the instantiation token is not that of this model description");
        free(self);
        return NULL;
    }
    return self;
}

API void *fmi3InstantiateModelExchange(
    String name, String token, String resources, bool visible, bool logging, void *environment,
    Log log) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment;
    (void)log;
    return NULL;
}

API void *fmi3InstantiateScheduledExecution(
    String name, String token, String resources, bool visible, bool logging, void *environment,
    Log log, void *clock, void *lock, void *unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment;
    (void)log, (void)clock, (void)lock, (void)unlock;
    return NULL;
}

API void fmi3FreeInstance(void *instance) { free(instance); }

API Status fmi3EnterInitializationMode(
    void *instance, bool tolerant, double tolerance, double start, bool ends, double stop) {
    Instance *self = instance;
    (void)tolerant, (void)tolerance, (void)ends, (void)stop;
    if (self->now.phase != INSTANTIATED) return failed(self, "initialized already: reset first");
    self->now.value[0] = start;
    self->now.phase = INITIALIZATION;
    return OK;
}

API Status fmi3ExitInitializationMode(void *instance) {
    Instance *self = instance;
    if (self->now.phase != INITIALIZATION) return failed(self, "not in initialization mode");
    begin(self);
    self->now.phase = STEP;
    return OK;
}

API Status fmi3Terminate(void *instance) {
    ((Instance *)instance)->now.phase = TERMINATED;
    return OK;
}

API Status fmi3Reset(void *instance) {
    reset(instance);
    return OK;
}

API Status fmi3GetFloat64(void *instance, const Ref ref[], size_t n, double value[], size_t m) {
    Instance *self = instance;
    if (n != m) return failed(self, "every variable is a scalar");
    if (self->now.phase == INITIALIZATION) begin(self);
    for (size_t i = 0; i < n; i++) {
        if (ref[i] >= N_VALUES) return failed(self, "no variable has this value reference");
        value[i] = self->now.value[ref[i]];
    }
    return OK;
}

API Status fmi3SetFloat64(
    void *instance, const Ref ref[], size_t n, const double value[], size_t m) {
    Instance *self = instance;
    if (n != m) return failed(self, "every variable is a scalar");
    for (size_t i = 0; i < n; i++) {
        const bool fixed = ref[i] >= FIRST_FIXED && ref[i] < FIRST_TUNABLE;
        if (ref[i] < FIRST_INPUT || ref[i] >= FIRST_OUTPUT)
            return failed(self, "only inputs and parameters can be set");
        if (fixed && self->now.phase > INITIALIZATION)
            return failed(self, "a fixed parameter can be set before the first step only");
        if (!isfinite(value[i])) return failed(self, "inputs and parameters are finite numbers");
        self->now.value[ref[i]] = value[i];
    }
    return OK;
}

API Status fmi3EnterStepMode(void *instance) {
    (void)instance;
    return OK;
}

API Status fmi3DoStep(
    void *instance, double time, double h, bool no_set_before, bool *event, bool *terminate,
    bool *early, double *last) {
    Instance *self = instance;
    double *v = self->now.value;
    (void)no_set_before;
    *event = *terminate = *early = false;
    *last = time;
    if (self->now.phase != STEP) return failed(self, "initialize before the first step");
    if (!(h >= 0.0)) return failed(self, "the communication step size is negative");
    tire_step(v + FIRST_INPUT, h, self->now.state, v + FIRST_OUTPUT);
    v[0] = *last = time + h;
    for (size_t i = FIRST_OUTPUT; i < N_VALUES; i++)
        if (!isfinite(v[i])) return failed(self, "an output is not finite at these inputs");
    return OK;
}

API Status fmi3GetFMUState(void *instance, void **state) {
    if (!*state) *state = malloc(sizeof(Content));
    if (!*state) return failed(instance, "not enough memory");
    memcpy(*state, &((Instance *)instance)->now, sizeof(Content));
    return OK;
}

API Status fmi3SetFMUState(void *instance, void *state) {
    memcpy(&((Instance *)instance)->now, state, sizeof(Content));
    return OK;
}

API Status fmi3FreeFMUState(void *instance, void **state) {
    (void)instance;
    free(*state);
    *state = NULL;
    return OK;
}

API Status fmi3SerializedFMUStateSize(void *instance, void *state, size_t *size) {
    (void)instance, (void)state;
    *size = sizeof(Content);
    return OK;
}

API Status fmi3SerializeFMUState(void *instance, void *state, uint8_t bytes[], size_t size) {
    if (size != sizeof(Content)) return failed(instance, "the size of the state is another");
    memcpy(bytes, state, size);
    return OK;
}

API Status fmi3DeserializeFMUState(
    void *instance, const uint8_t bytes[], size_t size, void **state) {
    if (size != sizeof(Content)) return failed(instance, "the size of the state is another");
    if (!*state) *state = malloc(size);
    if (!*state) return failed(instance, "not enough memory");
    memcpy(*state, bytes, size);
    return OK;
}

/* What the tire does not have: other types than Float64, events, clocks, derivatives. */

#define UNSUPPORTED(name, ...)                              \
    API Status name(void *instance, __VA_ARGS__) {          \
        return failed(instance, #name " is not supported"); \
    }
#define UNSUPPORTED_ALONE(name)                             \
    API Status name(void *instance) {                       \
        return failed(instance, #name " is not supported"); \
    }
#define NO_VALUES(type, c)                                                      \
    UNSUPPORTED(fmi3Get##type, const Ref r[], size_t n, c value[], size_t m)    \
    UNSUPPORTED(fmi3Set##type, const Ref r[], size_t n, const c value[], size_t m)

NO_VALUES(Float32, float)
NO_VALUES(Int8, int8_t)
NO_VALUES(UInt8, uint8_t)
NO_VALUES(Int16, int16_t)
NO_VALUES(UInt16, uint16_t)
NO_VALUES(Int32, int32_t)
NO_VALUES(UInt32, uint32_t)
NO_VALUES(Int64, int64_t)
NO_VALUES(UInt64, uint64_t)
NO_VALUES(Boolean, bool)
NO_VALUES(String, String)
UNSUPPORTED(fmi3GetBinary, const Ref r[], size_t n, size_t size[], Binary value[], size_t m)
UNSUPPORTED(
    fmi3SetBinary, const Ref r[], size_t n, const size_t size[], const Binary value[], size_t m)
UNSUPPORTED(fmi3GetClock, const Ref r[], size_t n, bool value[])
UNSUPPORTED(fmi3SetClock, const Ref r[], size_t n, const bool value[])
UNSUPPORTED(fmi3GetNumberOfVariableDependencies, Ref r, size_t *n)
UNSUPPORTED(
    fmi3GetVariableDependencies, Ref r, size_t of[], Ref on[], size_t places[], int kind[],
    size_t n)
UNSUPPORTED(
    fmi3GetDirectionalDerivative, const Ref u[], size_t nu, const Ref k[], size_t nk,
    const double seed[], size_t ns, double value[], size_t n)
UNSUPPORTED(
    fmi3GetAdjointDerivative, const Ref u[], size_t nu, const Ref k[], size_t nk,
    const double seed[], size_t ns, double value[], size_t n)
UNSUPPORTED_ALONE(fmi3EnterConfigurationMode)
UNSUPPORTED_ALONE(fmi3ExitConfigurationMode)
UNSUPPORTED_ALONE(fmi3EnterEventMode)
UNSUPPORTED_ALONE(fmi3EvaluateDiscreteStates)
UNSUPPORTED_ALONE(fmi3EnterContinuousTimeMode)
UNSUPPORTED(fmi3GetIntervalDecimal, const Ref r[], size_t n, double interval[], int kind[])
UNSUPPORTED(
    fmi3GetIntervalFraction, const Ref r[], size_t n, uint64_t count[], uint64_t resolution[],
    int kind[])
UNSUPPORTED(fmi3GetShiftDecimal, const Ref r[], size_t n, double shift[])
UNSUPPORTED(
    fmi3GetShiftFraction, const Ref r[], size_t n, uint64_t count[], uint64_t resolution[])
UNSUPPORTED(fmi3SetIntervalDecimal, const Ref r[], size_t n, const double interval[])
UNSUPPORTED(
    fmi3SetIntervalFraction, const Ref r[], size_t n, const uint64_t count[],
    const uint64_t resolution[])
UNSUPPORTED(fmi3SetShiftDecimal, const Ref r[], size_t n, const double shift[])
UNSUPPORTED(
    fmi3SetShiftFraction, const Ref r[], size_t n, const uint64_t count[],
    const uint64_t resolution[])
UNSUPPORTED(
    fmi3UpdateDiscreteStates, bool *update, bool *terminate, bool *nominals, bool *states,
    bool *defined, double *next)
UNSUPPORTED(fmi3CompletedIntegratorStep, bool no_set_before, bool *event, bool *terminate)
UNSUPPORTED(fmi3SetTime, double time)
UNSUPPORTED(fmi3SetContinuousStates, const double x[], size_t n)
UNSUPPORTED(fmi3GetContinuousStateDerivatives, double x[], size_t n)
UNSUPPORTED(fmi3GetEventIndicators, double z[], size_t n)
UNSUPPORTED(fmi3GetContinuousStates, double x[], size_t n)
UNSUPPORTED(fmi3GetNominalsOfContinuousStates, double x[], size_t n)
UNSUPPORTED(fmi3GetNumberOfEventIndicators, size_t *n)
UNSUPPORTED(fmi3GetNumberOfContinuousStates, size_t *n)
UNSUPPORTED(
    fmi3GetOutputDerivatives, const Ref r[], size_t n, const int32_t order[], double value[],
    size_t m)
UNSUPPORTED(fmi3ActivateModelPartition, Ref clock, double time)

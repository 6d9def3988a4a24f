/*
@HEADER@
*/
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define NAME "@NAME@"
#define TOKEN "@TOKEN@"
#define POINTS @POINTS@
#define LONGEST_STEP_S 0.01

#if defined(_WIN32)
#define FMI __declspec(dllexport)
#else
#define FMI __attribute__((visibility("default")))
#endif

/* Value references, in the order of modelDescription.xml. */
enum {
  TIME_S, RUDDER_COMMAND_RAD, THRUST,
  NORTH_M, EAST_M, HEADING_RAD, SPEED_M_S, YAW_RATE_RAD_S, RUDDER_RAD,
  INITIAL_HEADING_RAD,
  RUDDER_LIMIT_RAD, RUDDER_LAG_S, RUDDER_DELAY_S, RUDDER_RATE_LIMIT_RAD_S,
  SURGE_TIME_CONSTANT_S, DRAG_LENGTH_M, TURNING_DRAG_M,
  SCALARS
};
enum { AT_THRUST, AT_SPEED, A22, B2, C0, TABLES };
enum { STATES = 6 };
enum { OK, WARNING, DISCARD, ERROR };

typedef struct {
  double acts_s;
  double rudder_rad;
} Command;

typedef void Log(void *environment, int status, const char *category, const char *message);

typedef struct {
  double scalar[SCALARS];
  double table[TABLES][POINTS];
  double acting_rad;
  bool runs;
  Command *underway; /* commands within the dead time, oldest first */
  size_t count, room;
  Log *log;
  void *environment;
} Vehicle;

static const double SCALAR[SCALARS] = {
  [RUDDER_COMMAND_RAD] = 0.0, [THRUST] = @FASTEST@,
  [RUDDER_LIMIT_RAD] = @LIMIT@, [RUDDER_LAG_S] = @LAG@, [RUDDER_DELAY_S] = @DELAY@,
  [RUDDER_RATE_LIMIT_RAD_S] = @RATE@, [SURGE_TIME_CONSTANT_S] = @SURGE_T@,
  [DRAG_LENGTH_M] = @DRAG@, [TURNING_DRAG_M] = @TURNING@,
};
static const double TABLE[TABLES][POINTS] = {
  [AT_THRUST] = {@THRUST@},
  [AT_SPEED] = {@SPEED@},
  [A22] = {@A22@},
  [B2] = {@B2@},
  [C0] = {@C0@},
};

/* Linear between the points; beyond them the nearest one times a power of the ratio. */
static double scaled(double x, const double *at, const double *values, int power) {
  double nearest = fmin(fmax(x, at[0]), at[POINTS - 1]);
  int below = 0;
  while (below + 2 < POINTS && at[below + 1] <= nearest) below++;
  double y = values[below];
  if (POINTS > 1) {
    int above = (below + 1) % POINTS;
    y += (nearest - at[below]) / (at[above] - at[below]) * (values[above] - values[below]);
  }
  return y * pow(x / nearest, power);
}

static double of_speed(const Vehicle *v, int table, double speed, int power) {
  return scaled(speed, v->table[AT_SPEED], v->table[table], power);
}

/* b2 is linear in the square of the speed, as the force of a fin. */
static double authority(const Vehicle *v, double speed) {
  double squares[POINTS];
  for (int k = 0; k < POINTS; k++) squares[k] = v->table[AT_SPEED][k] * v->table[AT_SPEED][k];
  return scaled(speed * speed, squares, v->table[B2], 1);
}

static double steady_speed(const Vehicle *v) {
  return scaled(v->scalar[THRUST], v->table[AT_THRUST], v->table[AT_SPEED], 1);
}

static double limited(double x, double limit) {
  return fmin(fmax(x, -limit), limit);
}

static void derivative(const Vehicle *v, const double x[STATES], double dx[STATES]) {
  double heading = x[2], speed = x[3], rate = x[4], rudder = x[5];
  double command = limited(v->acting_rad, v->scalar[RUDDER_LIMIT_RAD]);
  double lag = v->scalar[RUDDER_LAG_S], rate_limit = v->scalar[RUDDER_RATE_LIMIT_RAD_S];
  double rudder_rate = 0.0;
  if (lag > 0.0) {
    rudder_rate = (command - rudder) / lag;
    if (rate_limit > 0.0) rudder_rate = limited(rudder_rate, rate_limit);
  } else {
    rudder = command;
  }
  double target = steady_speed(v), drag = v->scalar[DRAG_LENGTH_M];
  double acceleration = (target - speed) / v->scalar[SURGE_TIME_CONSTANT_S];
  if (drag > 0.0) {
    double sign = (speed > 0.0) - (speed < 0.0);
    acceleration = (target * fabs(target) - speed * fabs(speed)) / drag
                 - v->scalar[TURNING_DRAG_M] * rate * rate * sign;
  }
  dx[0] = speed * cos(heading);
  dx[1] = speed * sin(heading);
  dx[2] = rate;
  dx[3] = acceleration;
  dx[4] = of_speed(v, A22, speed, 1) * rate + authority(v, speed) * rudder + of_speed(v, C0, speed, 2);
  dx[5] = rudder_rate;
}

/* Straight ahead at the thrust. */
static void start(Vehicle *v) {
  double speed = steady_speed(v), b2 = authority(v, speed);
  v->acting_rad = b2 == 0.0 ? 0.0 : -of_speed(v, C0, speed, 2) / b2;
  double state[STATES] = {0.0, 0.0, v->scalar[INITIAL_HEADING_RAD], speed, 0.0, v->acting_rad};
  memcpy(v->scalar + NORTH_M, state, sizeof state);
  v->count = 0;
}

/* Runge and Kutta's fourth order. */
static void advance(Vehicle *v, double h) {
  double *x = v->scalar + NORTH_M, k[4][STATES], at[STATES];
  const double share[4] = {0.0, 0.5, 0.5, 1.0};
  for (int stage = 0; stage < 4; stage++) {
    for (int i = 0; i < STATES; i++) at[i] = x[i] + (stage ? share[stage] * h * k[stage - 1][i] : 0.0);
    derivative(v, at, k[stage]);
  }
  for (int i = 0; i < STATES; i++) x[i] += h / 6.0 * (k[0][i] + 2.0 * k[1][i] + 2.0 * k[2][i] + k[3][i]);
  if (v->scalar[RUDDER_LAG_S] <= 0.0) v->scalar[RUDDER_RAD] = limited(v->acting_rad, v->scalar[RUDDER_LIMIT_RAD]);
}

/* The command acts once the dead time is over. */
static bool send(Vehicle *v) {
  if (v->count == v->room) {
    size_t room = v->room ? 2 * v->room : 64;
    Command *more = realloc(v->underway, room * sizeof *more);
    if (!more) return false;
    v->underway = more;
    v->room = room;
  }
  Command command = {v->scalar[TIME_S] + v->scalar[RUDDER_DELAY_S], v->scalar[RUDDER_COMMAND_RAD]};
  v->underway[v->count++] = command;
  return true;
}

static void take_command(Vehicle *v, double time_s) {
  size_t due = 0;
  while (due < v->count && v->underway[due].acts_s <= time_s) v->acting_rad = v->underway[due++].rudder_rad;
  v->count -= due;
  if (due) memmove(v->underway, v->underway + due, v->count * sizeof *v->underway);
}

static double *variable(Vehicle *v, uint32_t reference, size_t *size) {
  *size = reference < SCALARS ? 1 : POINTS;
  if (reference < SCALARS) return v->scalar + reference;
  return reference < SCALARS + TABLES ? v->table[reference - SCALARS] : NULL;
}

/* May the variable be set now: inputs always, parameters until the simulation runs. */
static bool settable(const Vehicle *v, uint32_t reference) {
  if (reference == RUDDER_COMMAND_RAD || reference == THRUST) return true;
  return !v->runs && reference >= INITIAL_HEADING_RAD;
}

FMI const char *fmi3GetVersion(void) { return "3.0"; }

FMI int fmi3SetDebugLogging(void *v, bool on, size_t count, const char *const categories[]) {
  (void)v, (void)on, (void)count, (void)categories;
  return OK;
}

FMI int fmi3Reset(void *instance) {
  Vehicle *v = instance;
  memcpy(v->scalar, SCALAR, sizeof SCALAR);
  memcpy(v->table, TABLE, sizeof TABLE);
  v->runs = false;
  start(v);
  return OK;
}

FMI void *fmi3InstantiateCoSimulation(
    const char *name, const char *token, const char *resources, bool visible, bool logging, bool events, bool early_return,
    const uint32_t intermediate[], size_t count, void *environment, Log *log, void *update) {
  (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early_return;
  (void)intermediate, (void)count, (void)update;
  if (!token || strcmp(token, TOKEN) != 0) return NULL;
  Vehicle *v = calloc(1, sizeof *v);
  if (!v) return NULL;
  v->log = log;
  v->environment = environment;
  fmi3Reset(v);
  return v;
}

FMI void fmi3FreeInstance(void *instance) {
  Vehicle *v = instance;
  if (v) free(v->underway);
  free(v);
}

FMI int fmi3EnterInitializationMode(
    void *instance, bool tolerance_defined, double tolerance, double start_s, bool stop_defined, double stop_s) {
  (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop_s;
  ((Vehicle *)instance)->scalar[TIME_S] = start_s;
  return OK;
}

/* What is wrong with the parameters, or NULL. */
static const char *fault(const Vehicle *v) {
  if (v->scalar[RUDDER_LIMIT_RAD] <= 0.0) return "rudder_limit_rad must be above 0";
  if (v->scalar[RUDDER_DELAY_S] < 0.0) return "rudder_delay_s must not be below 0";
  if (v->scalar[SURGE_TIME_CONSTANT_S] <= 0.0) return "surge_time_constant_s must be above 0";
  for (int table = AT_THRUST; table <= AT_SPEED; table++)
    for (int i = 0; i < POINTS; i++)
      if (v->table[table][i] <= (i ? v->table[table][i - 1] : 0.0)) return "thrust and steady_speed_m_s must rise from above 0";
  return NULL;
}

FMI int fmi3ExitInitializationMode(void *instance) {
  Vehicle *v = instance;
  const char *wrong = fault(v);
  if (wrong && v->log) v->log(v->environment, ERROR, "logStatusError", wrong);
  v->runs = !wrong;
  return wrong ? ERROR : OK;
}

FMI int fmi3Terminate(void *instance) {
  (void)instance;
  return OK;
}

FMI int fmi3GetFloat64(void *instance, const uint32_t references[], size_t count, double values[], size_t room) {
  for (size_t i = 0, n, at = 0; i < count; i++, at += n) {
    const double *of = variable(instance, references[i], &n);
    if (!of || at + n > room) return ERROR;
    memcpy(values + at, of, n * sizeof *of);
  }
  return OK;
}

FMI int fmi3SetFloat64(void *instance, const uint32_t references[], size_t count, const double values[], size_t given) {
  Vehicle *v = instance;
  for (size_t i = 0, n, at = 0; i < count; i++, at += n) {
    double *of = variable(v, references[i], &n);
    if (!of || at + n > given || !settable(v, references[i])) return ERROR;
    for (size_t k = 0; k < n; k++)
      if (!isfinite(values[at + k])) return ERROR;
    memcpy(of, values + at, n * sizeof *of);
  }
  if (!v->runs) start(v);
  return OK;
}

FMI int fmi3DoStep(
    void *instance, double time_s, double interval_s, bool no_state_before, bool *event, bool *terminate, bool *early_return,
    double *last_s) {
  Vehicle *v = instance;
  (void)no_state_before;
  *event = *terminate = *early_return = false;
  *last_s = time_s;
  if (!(interval_s >= 0.0) || !isfinite(interval_s)) return ERROR;
  v->scalar[TIME_S] = time_s;
  if (!send(v)) return ERROR;
  double count = fmax(1.0, ceil(interval_s / LONGEST_STEP_S)), h = interval_s / count;
  for (double k = 0.0; k < count; k++) {
    take_command(v, time_s + (k + 0.5) * h);
    advance(v, h);
  }
  v->scalar[TIME_S] = *last_s = time_s + interval_s;
  return OK;
}

static bool copy(Vehicle *to, const Vehicle *from) {
  Command *underway = malloc((from->count + 1) * sizeof *underway);
  if (!underway) return false;
  if (from->count) memcpy(underway, from->underway, from->count * sizeof *underway);
  free(to->underway);
  *to = *from;
  to->underway = underway;
  to->room = from->count + 1;
  return true;
}

FMI int fmi3GetFMUState(void *instance, void **state) {
  if (!*state) *state = calloc(1, sizeof(Vehicle));
  return *state && copy(*state, instance) ? OK : ERROR;
}

FMI int fmi3SetFMUState(void *instance, void *state) { return copy(instance, state) ? OK : ERROR; }

FMI int fmi3FreeFMUState(void *instance, void **state) {
  (void)instance;
  fmi3FreeInstance(*state);
  *state = NULL;
  return OK;
}

/* What FMI 3.0 has besides, which this model has no use for. */
#define NOT_OF_TYPE(TYPE, NUMBER)                                                                              \
  FMI int fmi3Get##TYPE(void *v, const uint32_t r[], size_t n, NUMBER x[], size_t m) {                         \
    (void)v, (void)r, (void)x, (void)m;                                                                        \
    return n ? ERROR : OK;                                                                                     \
  }                                                                                                            \
  FMI int fmi3Set##TYPE(void *v, const uint32_t r[], size_t n, const NUMBER x[], size_t m) {                   \
    (void)v, (void)r, (void)x, (void)m;                                                                        \
    return n ? ERROR : OK;                                                                                     \
  }
NOT_OF_TYPE(Float32, float)
NOT_OF_TYPE(Int8, int8_t)
NOT_OF_TYPE(UInt8, uint8_t)
NOT_OF_TYPE(Int16, int16_t)
NOT_OF_TYPE(UInt16, uint16_t)
NOT_OF_TYPE(Int32, int32_t)
NOT_OF_TYPE(UInt32, uint32_t)
NOT_OF_TYPE(Int64, int64_t)
NOT_OF_TYPE(UInt64, uint64_t)
NOT_OF_TYPE(Boolean, bool)
typedef const char *String;
NOT_OF_TYPE(String, String)

#define NOT_SUPPORTED(NAME, ...)                                                                               \
  FMI int fmi3##NAME(void *v, __VA_ARGS__) {                                                                   \
    (void)v;                                                                                                   \
    return ERROR;                                                                                              \
  }
#define REFERENCES const uint32_t r[], size_t n
NOT_SUPPORTED(GetBinary, REFERENCES, size_t sizes[], const uint8_t *x[], size_t m)
NOT_SUPPORTED(SetBinary, REFERENCES, const size_t sizes[], const uint8_t *const x[], size_t m)
NOT_SUPPORTED(GetClock, REFERENCES, bool x[])
NOT_SUPPORTED(SetClock, REFERENCES, const bool x[])
NOT_SUPPORTED(GetNumberOfVariableDependencies, uint32_t r, size_t *n)
NOT_SUPPORTED(GetVariableDependencies, uint32_t of, size_t i[], uint32_t on[], size_t j[], int kinds[], size_t n)
NOT_SUPPORTED(SerializedFMUStateSize, void *state, size_t *size)
NOT_SUPPORTED(SerializeFMUState, void *state, uint8_t bytes[], size_t size)
NOT_SUPPORTED(DeserializeFMUState, const uint8_t bytes[], size_t size, void **state)
NOT_SUPPORTED(GetDirectionalDerivative, const uint32_t u[], size_t nu, const uint32_t k[], size_t nk, const double s[],
              size_t ns, double x[], size_t nx)
NOT_SUPPORTED(GetAdjointDerivative, const uint32_t u[], size_t nu, const uint32_t k[], size_t nk, const double s[], size_t ns,
              double x[], size_t nx)
NOT_SUPPORTED(GetOutputDerivatives, REFERENCES, const int32_t orders[], double x[], size_t m)
NOT_SUPPORTED(GetIntervalDecimal, REFERENCES, double x[], int kinds[])
NOT_SUPPORTED(GetIntervalFraction, REFERENCES, uint64_t counters[], uint64_t resolutions[], int kinds[])
NOT_SUPPORTED(GetShiftDecimal, REFERENCES, double x[])
NOT_SUPPORTED(GetShiftFraction, REFERENCES, uint64_t counters[], uint64_t resolutions[])
NOT_SUPPORTED(SetIntervalDecimal, REFERENCES, const double x[])
NOT_SUPPORTED(SetIntervalFraction, REFERENCES, const uint64_t counters[], const uint64_t resolutions[])
NOT_SUPPORTED(SetShiftDecimal, REFERENCES, const double x[])
NOT_SUPPORTED(SetShiftFraction, REFERENCES, const uint64_t counters[], const uint64_t resolutions[])
#define NUMBERS double x[], size_t n
NOT_SUPPORTED(CompletedIntegratorStep, bool no_state_before, bool *event, bool *terminate)
NOT_SUPPORTED(SetTime, double time_s)
NOT_SUPPORTED(SetContinuousStates, const NUMBERS)
NOT_SUPPORTED(GetContinuousStates, NUMBERS)
NOT_SUPPORTED(GetContinuousStateDerivatives, NUMBERS)
NOT_SUPPORTED(GetNominalsOfContinuousStates, NUMBERS)
NOT_SUPPORTED(GetEventIndicators, NUMBERS)
NOT_SUPPORTED(GetNumberOfContinuousStates, size_t *n)
NOT_SUPPORTED(GetNumberOfEventIndicators, size_t *n)
NOT_SUPPORTED(ActivateModelPartition, uint32_t clock, double time_s)
NOT_SUPPORTED(UpdateDiscreteStates, bool *again, bool *terminate, bool *nominals, bool *values, bool *next, double *next_s)

#define NOT_A_MODE(NAME)                                                                                       \
  FMI int fmi3##NAME(void *v) {                                                                                \
    (void)v;                                                                                                   \
    return ERROR;                                                                                              \
  }
NOT_A_MODE(EnterEventMode)
NOT_A_MODE(EnterStepMode)
NOT_A_MODE(EnterConfigurationMode)
NOT_A_MODE(ExitConfigurationMode)
NOT_A_MODE(EvaluateDiscreteStates)
NOT_A_MODE(EnterContinuousTimeMode)

FMI void *fmi3InstantiateModelExchange(
    const char *name, const char *token, const char *resources, bool visible, bool logging, void *environment, void *log) {
  (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment, (void)log;
  return NULL;
}

FMI void *fmi3InstantiateScheduledExecution(
    const char *name, const char *token, const char *resources, bool visible, bool logging, void *environment, void *log,
    void *update, void *lock, void *unlock) {
  (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment, (void)log;
  (void)update, (void)lock, (void)unlock;
  return NULL;
}

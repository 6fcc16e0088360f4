/* FMI 3.0 for co-simulation and model exchange around the exported step. */
#include "fmi3.h"

#include "core.h"

typedef struct
{
    erc_memory memory;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
    uint32_t exchange; /* 1 for model exchange */
} instance;

static fmi3Status fail(const instance *in, const char *message)
{
    if (in->log != NULL)
    {
        in->log(in->environment, fmi3Error, "logStatusError", message);
    }
    return fmi3Error;
}

const char *fmi3GetVersion(void)
{
    return "3.0";
}

fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t count, const fmi3String categories[])
{
    (void)c;
    (void)on;
    (void)count;
    (void)categories;
    return fmi3OK;
}

static fmi3Instance made(fmi3String token, uint32_t exchange, fmi3InstanceEnvironment environment,
                         fmi3LogMessageCallback log)
{
    instance *in = (instance *)calloc(1u, sizeof *in);
    if (in == NULL)
    {
        return NULL;
    }
    in->log = log;
    in->environment = environment;
    in->exchange = exchange;
    if (token == NULL || strcmp(token, ERC_TOKEN) != 0)
    {
        (void)fail(in, "the instantiation token is not that of modelDescription.xml");
        free(in);
        return NULL;
    }
    erc_clear(&in->memory);
    return in;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log)
{
    (void)name;
    (void)resources;
    (void)visible;
    (void)logging;
    return made(token, 1u, environment, log);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference intermediate[], size_t count,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update)
{
    (void)name;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)events;
    (void)early;
    (void)intermediate;
    (void)count;
    (void)update;
    return made(token, 0u, environment, log);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                               fmi3Boolean visible, fmi3Boolean logging,
                                               fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                               fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                               fmi3UnlockPreemptionCallback unlock)
{
    (void)name;
    (void)token;
    (void)resources;
    (void)visible;
    (void)logging;
    (void)update;
    (void)lock;
    (void)unlock;
    if (log != NULL)
    {
        log(environment, fmi3Error, "logStatusError", "there is no scheduled execution");
    }
    return NULL;
}

void fmi3FreeInstance(fmi3Instance c)
{
    free(c);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean tolerance_given, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stop_given, fmi3Float64 stop)
{
    instance *in = (instance *)c;
    (void)tolerance_given;
    (void)tolerance;
    (void)stop_given;
    (void)stop;
    if (!(start - start == 0.0))
    {
        return fail(in, "the start time is not finite");
    }
    in->memory.start = start;
    in->memory.time = start;
    return fmi3OK;
}

static fmi3Status fine(fmi3Instance c)
{
    (void)c;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    return fine(c);
}

fmi3Status fmi3EnterEventMode(fmi3Instance c)
{
    return fine(c);
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c)
{
    return fine(c);
}

fmi3Status fmi3EnterStepMode(fmi3Instance c)
{
    return fine(c);
}

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c)
{
    return fine(c);
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c)
{
    return fine(c);
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c)
{
    return fine(c);
}

fmi3Status fmi3Terminate(fmi3Instance c)
{
    return fine(c);
}

fmi3Status fmi3Reset(fmi3Instance c)
{
    erc_clear(&((instance *)c)->memory);
    return fmi3OK;
}

/* --- values ------------------------------------------------------------------------------------------------------ */

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t count, fmi3Float64 values[],
                          size_t values_count)
{
    instance *in = (instance *)c;
    size_t i;
    for (i = 0u; i < count; i++)
    {
        if (values_count != count || !erc_get(&in->memory, references[i], &values[i]))
        {
            return fail(in, "fmi3GetFloat64: no such variable, or not as many values as variables");
        }
    }
    return fmi3OK;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference references[], size_t count,
                          const fmi3Float64 values[], size_t values_count)
{
    instance *in = (instance *)c;
    size_t i;
    for (i = 0u; i < count; i++)
    {
        if (values_count != count || !erc_set(&in->memory, references[i], values[i]))
        {
            return fail(in, "fmi3SetFloat64: no such input, or not as many values as variables");
        }
    }
    return fmi3OK;
}

fmi3Status fmi3GetUInt32(fmi3Instance c, const fmi3ValueReference references[], size_t count, fmi3UInt32 values[],
                         size_t values_count)
{
    instance *in = (instance *)c;
    size_t i;
    for (i = 0u; i < count; i++)
    {
        if (values_count != count || references[i] != REF_FLAGS)
        {
            return fail(in, "fmi3GetUInt32: no such variable, or not as many values as variables");
        }
        erc_refresh(&in->memory);
        values[i] = in->memory.flags;
    }
    return fmi3OK;
}

fmi3Status fmi3SetUInt32(fmi3Instance c, const fmi3ValueReference references[], size_t count,
                         const fmi3UInt32 values[], size_t values_count)
{
    (void)references;
    (void)values;
    (void)values_count;
    return (count == 0u) ? fmi3OK : fail((instance *)c, "there are no UInt32 inputs");
}

/* The types of which there are no variables. */
#define NO_VARIABLES(name)                                                                                             \
    fmi3Status fmi3Get##name(fmi3Instance c, const fmi3ValueReference references[], size_t count,                      \
                             fmi3##name values[], size_t values_count)                                                 \
    {                                                                                                                  \
        (void)references;                                                                                              \
        (void)values;                                                                                                  \
        (void)values_count;                                                                                            \
        return (count == 0u) ? fmi3OK : fail((instance *)c, "there are no " #name " variables");                       \
    }                                                                                                                  \
    fmi3Status fmi3Set##name(fmi3Instance c, const fmi3ValueReference references[], size_t count,                      \
                             const fmi3##name values[], size_t values_count)                                           \
    {                                                                                                                  \
        (void)references;                                                                                              \
        (void)values;                                                                                                  \
        (void)values_count;                                                                                            \
        return (count == 0u) ? fmi3OK : fail((instance *)c, "there are no " #name " variables");                       \
    }
NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(Int32)
NO_VARIABLES(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference references[], size_t count, size_t sizes[],
                         fmi3Binary values[], size_t values_count)
{
    (void)references;
    (void)sizes;
    (void)values;
    (void)values_count;
    return (count == 0u) ? fmi3OK : fail((instance *)c, "there are no Binary variables");
}

fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference references[], size_t count, const size_t sizes[],
                         const fmi3Binary values[], size_t values_count)
{
    (void)references;
    (void)sizes;
    (void)values;
    (void)values_count;
    return (count == 0u) ? fmi3OK : fail((instance *)c, "there are no Binary variables");
}

/* --- saved states ------------------------------------------------------------------------------------------------ */

fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state)
{
    if (*state == NULL)
    {
        *state = malloc(sizeof(erc_memory));
    }
    if (*state == NULL)
    {
        return fail((instance *)c, "no memory for a state");
    }
    memcpy(*state, &((instance *)c)->memory, sizeof(erc_memory));
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state)
{
    memcpy(&((instance *)c)->memory, state, sizeof(erc_memory));
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state)
{
    (void)c;
    if (state != NULL)
    {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState state, size_t *size)
{
    (void)c;
    (void)state;
    *size = sizeof(erc_memory);
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    if (size < sizeof(erc_memory))
    {
        return fail((instance *)c, "too few bytes for a state");
    }
    memcpy(bytes, state, sizeof(erc_memory));
    return fmi3OK;
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    if (size != sizeof(erc_memory))
    {
        return fail((instance *)c, "these bytes are no state");
    }
    if (*state == NULL)
    {
        *state = malloc(sizeof(erc_memory));
    }
    if (*state == NULL)
    {
        return fail((instance *)c, "no memory for a state");
    }
    memcpy(*state, bytes, sizeof(erc_memory));
    return fmi3OK;
}

/* --- co-simulation ----------------------------------------------------------------------------------------------- */

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean final, fmi3Boolean *event,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached)
{
    instance *in = (instance *)c;
    (void)final;
    *event = false;
    *terminate = false;
    *early = false;
    if (!(step > 0.0) || !erc_advance(&in->memory, time + step, 1.0))
    {
        *reached = in->memory.time;
        return fail(in, "fmi3DoStep: the step must be positive and finite, at most 1e9 periods");
    }
    *reached = in->memory.time;
    return fmi3OK;
}

/* --- model exchange: no continuous states, a time event every period --------------------------------------------- */

fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 time)
{
    instance *in = (instance *)c;
    if (!(time - time == 0.0))
    {
        return fail(in, "fmi3SetTime: the time is not finite");
    }
    in->memory.time = time;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals_changed, fmi3Boolean *values_changed,
                                    fmi3Boolean *next_defined, fmi3Float64 *next)
{
    instance *in = (instance *)c;
    *again = false;
    *terminate = false;
    *nominals_changed = false;
    *values_changed = false;
    *next_defined = false;
    if (in->exchange != 0u && ERC_SAMPLED)
    {
        if (!erc_advance(&in->memory, in->memory.time, 0.0))
        {
            return fail(in, "fmi3UpdateDiscreteStates: more than 1e9 periods since the start");
        }
        *next_defined = true;
        *next = in->memory.start + (double)in->memory.samples * ERC_PERIOD;
    }
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_return, fmi3Boolean *event,
                                       fmi3Boolean *terminate)
{
    (void)c;
    (void)no_return;
    *event = false;
    *terminate = false;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *count)
{
    *count = 0u;
    return fine(c);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *count)
{
    *count = 0u;
    return fine(c);
}

static fmi3Status none(fmi3Instance c, size_t count)
{
    return (count == 0u) ? fmi3OK : fail((instance *)c, "there are no continuous states and no event indicators");
}

fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 states[], size_t count)
{
    (void)states;
    return none(c, count);
}

fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 states[], size_t count)
{
    (void)states;
    return none(c, count);
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 derivatives[], size_t count)
{
    (void)derivatives;
    return none(c, count);
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 nominals[], size_t count)
{
    (void)nominals;
    return none(c, count);
}

fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 indicators[], size_t count)
{
    (void)indicators;
    return none(c, count);
}

/* --- what this FMU does not offer, as its modelDescription.xml says ---------------------------------------------- */

#define NOT_OFFERED(name, ...)                                                                                         \
    fmi3Status fmi3##name(fmi3Instance c, __VA_ARGS__)                                                                 \
    {                                                                                                                  \
        return fail((instance *)c, "fmi3" #name " is not offered");                                                    \
    }
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
NOT_OFFERED(GetClock, const fmi3ValueReference r[], size_t n, fmi3Clock values[])
NOT_OFFERED(SetClock, const fmi3ValueReference r[], size_t n, const fmi3Clock values[])
NOT_OFFERED(GetNumberOfVariableDependencies, fmi3ValueReference r, size_t *count)
NOT_OFFERED(GetVariableDependencies, fmi3ValueReference r, size_t of[], fmi3ValueReference on[], size_t at[],
            fmi3DependencyKind kinds[], size_t n)
NOT_OFFERED(GetDirectionalDerivative, const fmi3ValueReference u[], size_t nu, const fmi3ValueReference k[], size_t nk,
            const fmi3Float64 seed[], size_t ns, fmi3Float64 found[], size_t nf)
NOT_OFFERED(GetAdjointDerivative, const fmi3ValueReference u[], size_t nu, const fmi3ValueReference k[], size_t nk,
            const fmi3Float64 seed[], size_t ns, fmi3Float64 found[], size_t nf)
NOT_OFFERED(GetIntervalDecimal, const fmi3ValueReference r[], size_t n, fmi3Float64 v[], fmi3IntervalQualifier q[])
NOT_OFFERED(GetIntervalFraction, const fmi3ValueReference r[], size_t n, fmi3UInt64 v[], fmi3UInt64 w[],
            fmi3IntervalQualifier q[])
NOT_OFFERED(GetShiftDecimal, const fmi3ValueReference r[], size_t n, fmi3Float64 v[])
NOT_OFFERED(GetShiftFraction, const fmi3ValueReference r[], size_t n, fmi3UInt64 v[], fmi3UInt64 w[])
NOT_OFFERED(SetIntervalDecimal, const fmi3ValueReference r[], size_t n, const fmi3Float64 v[])
NOT_OFFERED(SetIntervalFraction, const fmi3ValueReference r[], size_t n, const fmi3UInt64 v[], const fmi3UInt64 w[])
NOT_OFFERED(SetShiftDecimal, const fmi3ValueReference r[], size_t n, const fmi3Float64 v[])
NOT_OFFERED(SetShiftFraction, const fmi3ValueReference r[], size_t n, const fmi3UInt64 v[], const fmi3UInt64 w[])
NOT_OFFERED(GetOutputDerivatives, const fmi3ValueReference r[], size_t n, const fmi3Int32 orders[], fmi3Float64 v[],
            size_t nv)
NOT_OFFERED(ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)

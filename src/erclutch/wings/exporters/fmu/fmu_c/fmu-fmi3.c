/* FMI 3.0 for co-simulation and model exchange around the exported step. */
#include "fmu-fmi3.h"

#include "fmu-core.h"

typedef struct
{
    erc_memory memory;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
    uint32_t exchange; /* 1 for model exchange */
} instance;

static fmi3Status fail(fmi3Instance c, const char *message)
{
    const instance *in = (const instance *)c;
    if (in->log != NULL)
    {
        in->log(in->environment, fmi3Error, "logStatusError", message);
    }
    return fmi3Error;
}

#define FMI(name) fmi3##name
#define HANDLE fmi3Instance
#define SAVED fmi3FMUState
#define STATE_(verb, what) verb##FMUState##what
#define STATE(verb, what) STATE_(verb, what)
#define DESERIALIZE Deserialize
#define REAL Float64
#define WHOLE UInt32
#define EXTRA_PARAMETERS , size_t values_count
#define ALLOWED values_count == count
#define EXTRA_REASON ", or not as many values as variables"
#include "fmu-common.h"

EXPORT const char *fmi3GetVersion(void)
{
    return "3.0";
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
    if (erc_clear(&in->memory) != 0u)
    {
        (void)fail(in, ERC_INEXACT);
        free(in);
        return NULL;
    }
    return in;
}

#define INSTANTIATE(name) EXPORT fmi3Instance fmi3Instantiate##name
#define COMMON fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging

INSTANTIATE(ModelExchange)(COMMON, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    return made(token, 1u, environment, log);
}

INSTANTIATE(CoSimulation)(COMMON, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference intermediate[],
                          size_t count, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                          fmi3IntermediateUpdateCallback update)
{
    return made(token, 0u, environment, log);
}

INSTANTIATE(ScheduledExecution)(COMMON, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                fmi3UnlockPreemptionCallback unlock)
{
    if (log != NULL)
    {
        log(environment, fmi3Error, "logStatusError", "there is no scheduled execution");
    }
    return NULL;
}

CALL(EnterInitializationMode)(fmi3Instance c, fmi3Boolean tolerance_given, fmi3Float64 tolerance, fmi3Float64 start,
                              fmi3Boolean stop_given, fmi3Float64 stop)
{
    return started(c, start);
}

ACCEPTED(EnterEventMode, (fmi3Instance c))
ACCEPTED(EnterContinuousTimeMode, (fmi3Instance c))
ACCEPTED(EnterStepMode, (fmi3Instance c))
ACCEPTED(EnterConfigurationMode, (fmi3Instance c))
ACCEPTED(ExitConfigurationMode, (fmi3Instance c))
ACCEPTED(EvaluateDiscreteStates, (fmi3Instance c))

NO_INPUTS(UInt32)
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

/* --- co-simulation ----------------------------------------------------------------------------------------------- */

CALL(DoStep)(fmi3Instance c, fmi3Float64 time, fmi3Float64 step, fmi3Boolean final, fmi3Boolean *event,
             fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached)
{
    const int taken = step > 0.0 && erc_advance(MEMORY(c), time + step, 1.0);
    *event = *terminate = *early = false;
    *reached = MEMORY(c)->time;
    return taken ? fmi3OK : fail(c, "fmi3DoStep: the step must be positive and finite, at most 1e9 periods");
}

/* --- model exchange: no continuous states, a time event every period --------------------------------------------- */

CALL(SetTime)(fmi3Instance c, fmi3Float64 time)
{
    if (!(time - time == 0.0))
    {
        return fail(c, "fmi3SetTime: the time is not finite");
    }
    MEMORY(c)->time = time;
    return fmi3OK;
}

CALL(UpdateDiscreteStates)(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals_changed,
                           fmi3Boolean *values_changed, fmi3Boolean *next_defined, fmi3Float64 *next)
{
    erc_memory *m = MEMORY(c);
    *again = *terminate = *nominals_changed = *values_changed = *next_defined = false;
    if (((instance *)c)->exchange != 0u && ERC_SAMPLED)
    {
        if (!erc_advance(m, m->time, 0.0))
        {
            return fail(c, "fmi3UpdateDiscreteStates: more than 1e9 periods since the start");
        }
        *next_defined = true;
        *next = m->start + (double)m->samples * ERC_PERIOD;
    }
    return fmi3OK;
}

CALL(CompletedIntegratorStep)(fmi3Instance c, fmi3Boolean no_return, fmi3Boolean *event, fmi3Boolean *terminate)
{
    *event = *terminate = false;
    return fmi3OK;
}

static fmi3Status zero(size_t *count)
{
    *count = 0u;
    return fmi3OK;
}

CALL(GetNumberOfEventIndicators)(fmi3Instance c, size_t *count)
{
    return zero(count);
}

CALL(GetNumberOfContinuousStates)(fmi3Instance c, size_t *count)
{
    return zero(count);
}

#define NO_STATES(name, given)                                                                                         \
    NO_VALUES(name, "there are no continuous states and no event indicators",                                          \
         (fmi3Instance c, given fmi3Float64 values[], size_t count))
NO_STATES(SetContinuousStates, const)
NO_STATES(GetContinuousStates, )
NO_STATES(GetContinuousStateDerivatives, )
NO_STATES(GetNominalsOfContinuousStates, )
NO_STATES(GetEventIndicators, )

/* --- what this FMU does not offer, as its modelDescription.xml says ---------------------------------------------- */

#define OF fmi3Instance c, const fmi3ValueReference references[], size_t count
#define DERIVATIVE                                                                                                     \
    (OF, const fmi3ValueReference known[], size_t knowns, const fmi3Float64 seed[], size_t seeds, fmi3Float64 found[], \
     size_t founds)
NO_VALUES(GetBinary, "there are no Binary variables", (OF, size_t sizes[], fmi3Binary values[], size_t values_count))
NO_VALUES(SetBinary, "there are no Binary variables",
     (OF, const size_t sizes[], const fmi3Binary values[], size_t values_count))
NOT_OFFERED(GetClock, (OF, fmi3Clock values[]))
NOT_OFFERED(SetClock, (OF, const fmi3Clock values[]))
NOT_OFFERED(GetNumberOfVariableDependencies, (fmi3Instance c, fmi3ValueReference reference, size_t *count))
NOT_OFFERED(GetVariableDependencies, (fmi3Instance c, fmi3ValueReference of, size_t at[], fmi3ValueReference on[],
                                      size_t places[], fmi3DependencyKind kinds[], size_t count))
NOT_OFFERED(GetDirectionalDerivative, DERIVATIVE)
NOT_OFFERED(GetAdjointDerivative, DERIVATIVE)
NOT_OFFERED(GetIntervalDecimal, (OF, fmi3Float64 values[], fmi3IntervalQualifier qualifiers[]))
NOT_OFFERED(GetIntervalFraction, (OF, fmi3UInt64 over[], fmi3UInt64 under[], fmi3IntervalQualifier qualifiers[]))
NOT_OFFERED(GetShiftDecimal, (OF, fmi3Float64 values[]))
NOT_OFFERED(GetShiftFraction, (OF, fmi3UInt64 over[], fmi3UInt64 under[]))
NOT_OFFERED(SetIntervalDecimal, (OF, const fmi3Float64 values[]))
NOT_OFFERED(SetIntervalFraction, (OF, const fmi3UInt64 over[], const fmi3UInt64 under[]))
NOT_OFFERED(SetShiftDecimal, (OF, const fmi3Float64 values[]))
NOT_OFFERED(SetShiftFraction, (OF, const fmi3UInt64 over[], const fmi3UInt64 under[]))
NOT_OFFERED(GetOutputDerivatives, (OF, const fmi3Int32 orders[], fmi3Float64 values[], size_t values_count))
NOT_OFFERED(ActivateModelPartition, (fmi3Instance c, fmi3ValueReference clock, fmi3Float64 time))

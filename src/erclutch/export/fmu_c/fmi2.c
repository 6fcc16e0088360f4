/* FMI 2.0 for co-simulation around the exported step. */
#include "fmi2.h"

#include "core.h"

typedef struct
{
    erc_memory memory;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char name[64];
} instance;

static fmi2Status fail(const instance *in, const char *message)
{
    if (in->logger != NULL)
    {
        in->logger(in->environment, in->name, fmi2Error, "logStatusError", "%s", message);
    }
    return fmi2Error;
}

const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

const char *fmi2GetVersion(void)
{
    return "2.0";
}

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t count, const fmi2String categories[])
{
    (void)c;
    (void)on;
    (void)count;
    (void)categories;
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    instance *in = (instance *)calloc(1u, sizeof *in);
    (void)resources;
    (void)visible;
    (void)logging;
    if (in == NULL)
    {
        return NULL;
    }
    if (functions != NULL)
    {
        in->logger = functions->logger;
        in->environment = functions->componentEnvironment;
    }
    strncpy(in->name, (name != NULL) ? name : "", sizeof in->name - 1u);
    if (type != fmi2CoSimulation || guid == NULL || strcmp(guid, ERC_TOKEN) != 0)
    {
        (void)fail(in, "only co-simulation, and only with the GUID of modelDescription.xml");
        free(in);
        return NULL;
    }
    erc_clear(&in->memory);
    return in;
}

void fmi2FreeInstance(fmi2Component c)
{
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_given, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stop_given, fmi2Real stop)
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
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    erc_clear(&((instance *)c)->memory);
    return fmi2OK;
}

/* --- values ------------------------------------------------------------------------------------------------------ */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Real values[])
{
    instance *in = (instance *)c;
    size_t i;
    for (i = 0u; i < count; i++)
    {
        if (references[i] == REF_TIME || !erc_get(&in->memory, references[i], &values[i]))
        {
            return fail(in, "fmi2GetReal: no such variable");
        }
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference references[], size_t count, const fmi2Real values[])
{
    instance *in = (instance *)c;
    size_t i;
    for (i = 0u; i < count; i++)
    {
        if (!erc_set(&in->memory, references[i], values[i]))
        {
            return fail(in, "fmi2SetReal: no such input");
        }
    }
    return fmi2OK;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Integer values[])
{
    instance *in = (instance *)c;
    size_t i;
    for (i = 0u; i < count; i++)
    {
        if (references[i] != REF_FLAGS)
        {
            return fail(in, "fmi2GetInteger: no such variable");
        }
        erc_refresh(&in->memory);
        values[i] = (fmi2Integer)in->memory.flags;
    }
    return fmi2OK;
}

static fmi2Status none(fmi2Component c, size_t count, const char *message)
{
    return (count == 0u) ? fmi2OK : fail((instance *)c, message);
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2Boolean values[])
{
    (void)references;
    (void)values;
    return none(c, count, "there are no Boolean variables");
}

fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference references[], size_t count, fmi2String values[])
{
    (void)references;
    (void)values;
    return none(c, count, "there are no String variables");
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference references[], size_t count,
                          const fmi2Integer values[])
{
    (void)references;
    (void)values;
    return none(c, count, "there are no Integer inputs");
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference references[], size_t count,
                          const fmi2Boolean values[])
{
    (void)references;
    (void)values;
    return none(c, count, "there are no Boolean variables");
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference references[], size_t count,
                         const fmi2String values[])
{
    (void)references;
    (void)values;
    return none(c, count, "there are no String variables");
}

/* --- saved states ------------------------------------------------------------------------------------------------ */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
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
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    memcpy(&((instance *)c)->memory, state, sizeof(erc_memory));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    if (state != NULL)
    {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c;
    (void)state;
    *size = sizeof(erc_memory);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    if (size < sizeof(erc_memory))
    {
        return fail((instance *)c, "too few bytes for a state");
    }
    memcpy(bytes, state, sizeof(erc_memory));
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
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
    return fmi2OK;
}

/* --- derivatives: none ------------------------------------------------------------------------------------------- */

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns,
                                        const fmi2ValueReference known[], size_t knowns, const fmi2Real seed[],
                                        fmi2Real sensitivity[])
{
    (void)unknown;
    (void)unknowns;
    (void)known;
    (void)knowns;
    (void)seed;
    (void)sensitivity;
    return fail((instance *)c, "there are no directional derivatives");
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                       const fmi2Integer orders[], const fmi2Real values[])
{
    (void)references;
    (void)orders;
    (void)values;
    return none(c, count, "inputs are not interpolated");
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference references[], size_t count,
                                        const fmi2Integer orders[], fmi2Real values[])
{
    (void)references;
    (void)orders;
    (void)values;
    return none(c, count, "there are no output derivatives");
}

/* --- steps ------------------------------------------------------------------------------------------------------- */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean final)
{
    instance *in = (instance *)c;
    (void)final;
    if (!(step > 0.0) || !erc_advance(&in->memory, time + step, 1.0))
    {
        return fail(in, "fmi2DoStep: the step must be positive and finite, at most 1e9 periods");
    }
    return fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    return fail((instance *)c, "no step is ever pending");
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)c;
    (void)kind;
    (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    if (kind != fmi2LastSuccessfulTime)
    {
        return fmi2Discard;
    }
    *value = ((instance *)c)->memory.time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)c;
    (void)kind;
    (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    (void)c;
    (void)kind;
    *value = fmi2False;
    return (kind == fmi2Terminated) ? fmi2OK : fmi2Discard;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)c;
    (void)kind;
    (void)value;
    return fmi2Discard;
}

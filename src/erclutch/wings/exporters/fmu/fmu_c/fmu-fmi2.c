/* FMI 2.0 for co-simulation around the exported step. */
#include "fmu-fmi2.h"

#include "fmu-core.h"

typedef struct
{
    erc_memory memory;
    fmi2CallbackLogger logger;
    fmi2ComponentEnvironment environment;
    char name[64];
} instance;

static fmi2Status fail(fmi2Component c, const char *message)
{
    const instance *in = (const instance *)c;
    if (in->logger != NULL)
    {
        in->logger(in->environment, in->name, fmi2Error, "logStatusError", "%s", message);
    }
    return fmi2Error;
}

#define FMI(name) fmi2##name
#define HANDLE fmi2Component
#define SAVED fmi2FMUstate
#define STATE_(verb, what) verb##FMUstate##what
#define STATE(verb, what) STATE_(verb, what)
#define DESERIALIZE DeSerialize
#define REAL Real
#define WHOLE Integer
#define EXTRA_PARAMETERS
#define ALLOWED references[i] != REF_TIME
#define EXTRA_REASON
#include "fmu-common.h"

EXPORT const char *fmi2GetTypesPlatform(void)
{
    return "default";
}

EXPORT const char *fmi2GetVersion(void)
{
    return "2.0";
}

EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                     const fmi2CallbackFunctions *functions, fmi2Boolean visible, fmi2Boolean logging)
{
    instance *in = (instance *)calloc(1u, sizeof *in);
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
    if (erc_clear(&in->memory) != 0u)
    {
        (void)fail(in, ERC_INEXACT);
        free(in);
        return NULL;
    }
    return in;
}

CALL(SetupExperiment)(fmi2Component c, fmi2Boolean tolerance_given, fmi2Real tolerance, fmi2Real start,
                      fmi2Boolean stop_given, fmi2Real stop)
{
    return started(c, start);
}

ACCEPTED(EnterInitializationMode, (fmi2Component c))

NO_INPUTS(Integer)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

/* --- derivatives: none ------------------------------------------------------------------------------------------- */

#define ORDERS(given)                                                                                                  \
    (fmi2Component c, const fmi2ValueReference references[], size_t count, const fmi2Integer orders[],                 \
     given fmi2Real values[])
NO_VALUES(SetRealInputDerivatives, "inputs are not interpolated", ORDERS(const))
NO_VALUES(GetRealOutputDerivatives, "there are no output derivatives", ORDERS())
NOT_OFFERED(GetDirectionalDerivative,
            (fmi2Component c, const fmi2ValueReference unknown[], size_t unknowns, const fmi2ValueReference known[],
             size_t knowns, const fmi2Real seed[], fmi2Real sensitivity[]))

/* --- steps ------------------------------------------------------------------------------------------------------- */

CALL(DoStep)(fmi2Component c, fmi2Real time, fmi2Real step, fmi2Boolean final)
{
    if (!(step > 0.0) || !erc_advance(MEMORY(c), time + step, 1.0))
    {
        return fail(c, "fmi2DoStep: the step must be positive and finite, at most 1e9 periods");
    }
    return fmi2OK;
}

CALL(CancelStep)(fmi2Component c)
{
    return fail(c, "no step is ever pending");
}

#define STATUS(name, type, known, found)                                                                               \
    CALL(name)(fmi2Component c, const fmi2StatusKind kind, type *value)                                                \
    {                                                                                                                  \
        if (kind != (known))                                                                                           \
        {                                                                                                              \
            return fmi2Discard;                                                                                        \
        }                                                                                                              \
        *value = (found);                                                                                              \
        return fmi2OK;                                                                                                 \
    }
#define NO_STATUS(name, type)                                                                                          \
    CALL(name)(fmi2Component c, const fmi2StatusKind kind, type *value)                                                \
    {                                                                                                                  \
        return fmi2Discard;                                                                                            \
    }
STATUS(GetRealStatus, fmi2Real, fmi2LastSuccessfulTime, MEMORY(c)->time)
STATUS(GetBooleanStatus, fmi2Boolean, fmi2Terminated, fmi2False)
NO_STATUS(GetStatus, fmi2Status)
NO_STATUS(GetIntegerStatus, fmi2Integer)
NO_STATUS(GetStringStatus, fmi2String)

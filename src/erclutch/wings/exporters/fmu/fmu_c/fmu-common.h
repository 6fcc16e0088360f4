/* What FMI 2.0 and FMI 3.0 say alike, but for names. Ahead of it stand, for the version:
   instance              the data of an instance, with its `memory`
   fail                  logs a message and returns the status of an error
   FMI(name)             a function's or a type's name
   HANDLE, SAVED         types of an instance and of a saved state
   STATE(verb, what)     name of a function of a saved state
   REAL, WHOLE           types of the inputs and the effort, and of the flags
   EXTRA_PARAMETERS      what else a function of values takes
   ALLOWED, EXTRA_REASON whether it may read or write value i, and what else its message says where it may not */
#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

#define TEXT_(name) #name
#define TEXT(name) TEXT_(name)
#define CALL(name) EXPORT FMI(Status) FMI(name)
#define MEMORY(c) (&((instance *)(c))->memory)
#define ERC_INEXACT "the options of this binary's compiler changed the model's arithmetic"

/* A function that has nothing to do; one that is not offered, as modelDescription.xml says; one of things of which there
   are none. */
#define ACCEPTED(name, parameters)                                                                                     \
    CALL(name) parameters                                                                                              \
    {                                                                                                                  \
        return FMI(OK);                                                                                                \
    }
#define NOT_OFFERED(name, parameters)                                                                                  \
    CALL(name) parameters                                                                                              \
    {                                                                                                                  \
        return fail(c, TEXT(FMI(name)) " is not offered");                                                             \
    }
#define NO_VALUES(name, message, parameters)                                                                           \
    CALL(name) parameters                                                                                              \
    {                                                                                                                  \
        return (count == 0u) ? FMI(OK) : fail(c, message);                                                             \
    }

/* Functions of many values: those that do one value at a time, and those of types of which there are no variables. */
#define VALUES(type, given)                                                                                            \
    (HANDLE c, const FMI(ValueReference) references[], size_t count, given FMI(type) values[] EXTRA_PARAMETERS)
#define EACH_(verb, type, given, one, message)                                                                         \
    CALL(verb##type) VALUES(type, given)                                                                               \
    {                                                                                                                  \
        size_t i;                                                                                                      \
        for (i = 0u; i < count; i++)                                                                                   \
        {                                                                                                              \
            if (!(ALLOWED) || !(one))                                                                                  \
            {                                                                                                          \
                return fail(c, TEXT(FMI(verb##type)) ": " message);                                                    \
            }                                                                                                          \
        }                                                                                                              \
        return FMI(OK);                                                                                                \
    }
#define EACH(verb, type, given, one, message) EACH_(verb, type, given, one, message)
#define NO_INPUTS(type) NO_VALUES(Set##type, "there are no " #type " inputs", VALUES(type, const))
#define NO_VARIABLES(type)                                                                                             \
    NO_VALUES(Get##type, "there are no " #type " variables", VALUES(type, ))                                           \
    NO_INPUTS(type)

EACH(Get, REAL, , erc_get(MEMORY(c), references[i], &values[i]), "no such variable" EXTRA_REASON)
EACH(Set, REAL, const, erc_set(MEMORY(c), references[i], values[i]), "no such input" EXTRA_REASON)
EACH(Get, WHOLE, , erc_get_flags(MEMORY(c), references[i], (uint32_t *)&values[i]), "no such variable" EXTRA_REASON)

ACCEPTED(SetDebugLogging, (HANDLE c, FMI(Boolean) on, size_t count, const FMI(String) categories[]))
ACCEPTED(ExitInitializationMode, (HANDLE c))
ACCEPTED(Terminate, (HANDLE c))

EXPORT void FMI(FreeInstance)(HANDLE c)
{
    free(c);
}

static FMI(Status) started(HANDLE c, double start)
{
    if (!(start - start == 0.0))
    {
        return fail(c, "the start time is not finite");
    }
    MEMORY(c)->start = start;
    MEMORY(c)->time = start;
    return FMI(OK);
}

CALL(Reset)(HANDLE c)
{
    return (erc_clear(MEMORY(c)) == 0u) ? FMI(OK) : fail(c, ERC_INEXACT);
}

/* --- saved states ------------------------------------------------------------------------------------------------ */

static FMI(Status) kept(HANDLE c, const void *bytes, SAVED *state)
{
    if (*state == NULL)
    {
        *state = malloc(sizeof(erc_memory));
    }
    if (*state == NULL)
    {
        return fail(c, "no memory for a state");
    }
    memcpy(*state, bytes, sizeof(erc_memory));
    return FMI(OK);
}

CALL(STATE(Get, ))(HANDLE c, SAVED *state)
{
    return kept(c, MEMORY(c), state);
}

CALL(STATE(Set, ))(HANDLE c, SAVED state)
{
    memcpy(MEMORY(c), state, sizeof(erc_memory));
    return FMI(OK);
}

CALL(STATE(Free, ))(HANDLE c, SAVED *state)
{
    if (state != NULL)
    {
        free(*state);
        *state = NULL;
    }
    return FMI(OK);
}

CALL(STATE(Serialized, Size))(HANDLE c, SAVED state, size_t *size)
{
    *size = SEALED;
    return FMI(OK);
}

CALL(STATE(Serialize, ))(HANDLE c, SAVED state, FMI(Byte) bytes[], size_t size)
{
    const uint64_t seal = erc_seal(state);
    if (size < SEALED)
    {
        return fail(c, "too few bytes for a state");
    }
    memcpy(bytes, state, sizeof(erc_memory));
    memcpy(bytes + sizeof(erc_memory), &seal, sizeof seal);
    return FMI(OK);
}

CALL(STATE(DESERIALIZE, ))(HANDLE c, const FMI(Byte) bytes[], size_t size, SAVED *state)
{
    uint64_t seal = 0u;
    if (size == SEALED)
    {
        memcpy(&seal, bytes + sizeof(erc_memory), sizeof seal);
    }
    if (size != SEALED || seal != erc_seal(bytes))
    {
        return fail(c, "these bytes are no state of this model, or they are damaged");
    }
    return kept(c, bytes, state);
}

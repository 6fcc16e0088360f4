/* What an instance holds and does, for all FMI versions. fmu-model.h binds the model.

   A model without memory is computed whenever an output is asked for, from the inputs of that moment. One with memory is
   sampled: in co-simulation at the end of each period, with the inputs that held through it; in model exchange by a time
   event at its start. */
#ifndef ERC_FMU_CORE_HEADER
#define ERC_FMU_CORE_HEADER

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "fmu-model.h"

/* Value references: 0 the time, then the inputs, the outputs, the flags, the parameters. */
#define REF_TIME 0u
#define REF_OUTPUT (ERC_INPUTS + 1u)
#define REF_FLAGS (REF_OUTPUT + ERC_OUTPUTS)
#define REF_PARAMETER (REF_FLAGS + 1u)

/* More periods than this in one communication step are a mistake. */
#define MOST_SAMPLES 1e9

/* Everything that a saved state holds. */
typedef struct
{
    erc_state state;
    double input[ERC_INPUTS];
    double output[ERC_OUTPUTS];
    double parameter[ERC_PARAMETERS + 1u];
    double time;
    double start;
    uint64_t samples;
    uint32_t flags;
    uint32_t stale;
} erc_memory;

/* Serialized, a state is followed by its seal. */
#define SEALED (sizeof(erc_memory) + sizeof(uint64_t))

/* FNV-1a of the token and the bytes of a state: other models' states and damaged bytes have another seal. */
static uint64_t erc_seal(const void *bytes)
{
    const unsigned char *byte = (const unsigned char *)bytes;
    const char *letter;
    uint64_t seal = UINT64_C(0xcbf29ce484222325);
    size_t i;
    for (letter = ERC_TOKEN; *letter != '\0'; letter++)
    {
        seal = (seal ^ (unsigned char)*letter) * UINT64_C(0x100000001b3);
    }
    for (i = 0u; i < sizeof(erc_memory); i++)
    {
        seal = (seal ^ byte[i]) * UINT64_C(0x100000001b3);
    }
    return seal;
}

/* 0, or not where the compiler of this binary changed the arithmetic of the model. */
static uint32_t erc_clear(erc_memory *m)
{
    static const double defaults[ERC_PARAMETERS + 1u] = {ERC_DEFAULTS};
    uint32_t inexact;
    memset(m, 0, sizeof *m);
    memcpy(m->parameter, defaults, sizeof defaults);
    inexact = erc_reset(&m->state);
    erc_use(&m->state, m->parameter);
    m->stale = 1u;
    return inexact;
}

static void erc_sample(erc_memory *m, erc_state *state)
{
    erc_real in[ERC_INPUTS];
    erc_real out[ERC_OUTPUTS];
    uint32_t i;
    for (i = 0u; i < ERC_INPUTS; i++)
    {
        in[i] = (erc_real)m->input[i];
    }
    m->flags = erc_step(state, in, out);
    for (i = 0u; i < ERC_OUTPUTS; i++)
    {
        m->output[i] = (double)out[i];
    }
    m->stale = 0u;
}

/* Brings the outputs up to date before they are read. Ahead of the first sample they are what it will give. */
static void erc_refresh(erc_memory *m)
{
    if (m->stale != 0u && (!ERC_SAMPLED || m->samples == 0u))
    {
        erc_state ahead = m->state;
        erc_sample(m, ERC_SAMPLED ? &ahead : &m->state);
    }
}

/* Takes all samples that are due at a time; the first is due `lead` periods after the start. 0 if there are too many. */
static int erc_advance(erc_memory *m, double time, double lead)
{
    if (!(time - m->start < MOST_SAMPLES * (ERC_SAMPLED ? ERC_PERIOD : 1e300)))
    {
        return 0;
    }
    m->time = time;
    /* A millionth of a period is rounding of the time. */
    while (ERC_SAMPLED && (double)m->samples + lead <= (time - m->start) / ERC_PERIOD + 1e-6)
    {
        erc_sample(m, &m->state);
        m->samples++;
    }
    return 1;
}

static int erc_get(erc_memory *m, uint32_t reference, double *value)
{
    erc_refresh(m);
    *value = m->time;
    if (reference - 1u < ERC_INPUTS)
    {
        *value = m->input[reference - 1u];
    }
    if (reference - REF_OUTPUT < ERC_OUTPUTS)
    {
        *value = m->output[reference - REF_OUTPUT];
    }
    if (reference >= REF_PARAMETER && reference - REF_PARAMETER < ERC_PARAMETERS)
    {
        *value = m->parameter[reference - REF_PARAMETER];
    }
    return reference < REF_PARAMETER + ERC_PARAMETERS && reference != REF_FLAGS;
}

static int erc_get_flags(erc_memory *m, uint32_t reference, uint32_t *value)
{
    erc_refresh(m);
    *value = m->flags;
    return reference == REF_FLAGS;
}

static int erc_set(erc_memory *m, uint32_t reference, double value)
{
    const int parameter = reference >= REF_PARAMETER && reference - REF_PARAMETER < ERC_PARAMETERS;
    if (parameter)
    {
        m->parameter[reference - REF_PARAMETER] = value;
        erc_use(&m->state, m->parameter);
    }
    else if (reference - 1u < ERC_INPUTS)
    {
        m->input[reference - 1u] = value;
    }
    else
    {
        return 0;
    }
    m->stale = 1u;
    return 1;
}

#endif

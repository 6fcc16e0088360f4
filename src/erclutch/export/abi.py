"""The model ABI: a thin C wrapper with fixed names and float64, for programs that load a compiled model at run time."""

from __future__ import annotations

from erclutch.export.program import Program

VERSION = 1

_DECLARED = """EXPORT const char *erc_model_digest(void);
EXPORT const char *erc_model_name(void);
EXPORT uint32_t erc_model_abi(void);
EXPORT uint32_t erc_model_inputs(void);
EXPORT uint32_t erc_model_state_size(void);
EXPORT void erc_model_reset(void *state);
EXPORT uint32_t erc_model_step(void *state, const double *in, double *effort);
EXPORT uint32_t erc_model_steady(const double *in, double *effort);
EXPORT uint32_t erc_model_inverse(const double *in, double wanted, double *field);
EXPORT void erc_model_run(void *state, size_t rows, const double *in, double *effort, uint32_t *flags);
"""


def wrapper(program: Program) -> str:
    """NAME_abi.c: erc_model_* around the step."""
    n = program.name
    return f"""/* The model ABI, version {VERSION}: {n} behind names that are the same for every model. */
#include <stddef.h>

#include "{n}.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

{_DECLARED}
{_about(n)}
{_calls(n, len(program.inputs))}"""


def _about(n: str) -> str:
    return f"""const char *erc_model_digest(void)
{{
    return {n.upper()}_DIGEST;
}}

const char *erc_model_name(void)
{{
    return {n.upper()}_MODEL;
}}

uint32_t erc_model_abi(void)
{{
    return {VERSION}u;
}}

uint32_t erc_model_inputs(void)
{{
    return {n.upper()}_INPUTS;
}}

uint32_t erc_model_state_size(void)
{{
    return (uint32_t)sizeof({n}_state);
}}

void erc_model_reset(void *state)
{{
    {n}_reset(({n}_state *)state);
}}
"""


def _calls(n: str, count: int) -> str:
    return f"""static void convert(const double *in, {n}_real values[{n.upper()}_INPUTS])
{{
    uint32_t i;
    for (i = 0u; i < {n.upper()}_INPUTS; i++)
    {{
        values[i] = ({n}_real)in[i];
    }}
}}

uint32_t erc_model_step(void *state, const double *in, double *effort)
{{
    {n}_real values[{n.upper()}_INPUTS];
    {n}_real found;
    uint32_t flags;
    convert(in, values);
    flags = {n}_step(({n}_state *)state, values, &found);
    *effort = (double)found;
    return flags;
}}

uint32_t erc_model_steady(const double *in, double *effort)
{{
    {n}_real values[{n.upper()}_INPUTS];
    {n}_real found;
    uint32_t flags;
    convert(in, values);
    flags = {n}_steady(values, &found);
    *effort = (double)found;
    return flags;
}}

uint32_t erc_model_inverse(const double *in, double wanted, double *field)
{{
    {n}_real values[{n.upper()}_INPUTS];
    {n}_real found;
    uint32_t flags;
    convert(in, values);
    flags = {n}_inverse(values, ({n}_real)wanted, &found);
    *field = (double)found;
    return flags;
}}

/* Many steps in one call: rows of {count} numbers. */
void erc_model_run(void *state, size_t rows, const double *in, double *effort, uint32_t *flags)
{{
    size_t i;
    for (i = 0u; i < rows; i++)
    {{
        flags[i] = erc_model_step(state, &in[i * {n.upper()}_INPUTS], &effort[i]);
    }}
}}
"""

"""A thin C wrapper has fixed names and float64, for programs that load a compiled model at run time: the model ABI."""

from __future__ import annotations

from erclutch.export.exported_step import ExportedStep

VERSION = 1

_ASKED = {
    "const char *erc_model_digest": "{N}_DIGEST",
    "const char *erc_model_name": "{N}_MODEL",
    "uint32_t erc_model_abi": f"{VERSION}u",
    "uint32_t erc_model_inputs": "{N}_INPUTS",
    "uint32_t erc_model_state_size": "(uint32_t)sizeof({n}_state)",
}
_EXACT = "uint32_t erc_model_exact(void)"
_RESET = "void erc_model_reset(void *state)"
_SWITCH = "void erc_model_use_residual(void *state, uint32_t on)"
_BAND = "void erc_model_band(const void *state, double band[2])"
_RUN = "void erc_model_run(void *state, size_t rows, const double *in, double *effort, uint32_t *flags)"
_CALLED = {
    "uint32_t erc_model_step(void *state, const double *in, double *effort)": "step(({n}_state *)state, values",
    "uint32_t erc_model_steady(const double *in, double *effort)": "steady(values",
    "uint32_t erc_model_inverse(const double *in, double wanted, double *field)": "inverse(values, ({n}_real)wanted",
    "uint32_t erc_model_inverse_now(const void *state, const double *in, double wanted, double *field)": (
        "inverse_now((const {n}_state *)state, values, ({n}_real)wanted"
    ),
}


def wrapper(step: ExportedStep) -> str:
    """NAME_abi.c: erc_model_* around the step."""
    n = step.name
    N = n.upper()
    asked = [f"{function}(void)" for function in _ASKED]
    declared = [*asked, _EXACT, _RESET, *_CALLED, _RUN]
    further = ""  # functions that not every model has
    if step.model.correction is not None:
        declared.append(_SWITCH)
        further += f"\n{_SWITCH}\n{{\n    {n}_use_residual(({n}_state *)state, on);\n}}\n"
    if step.alarms:
        declared.append(_BAND)
        of_state = f"((const {n}_state *)state)"
        ends = f"    band[0] = (double){of_state}->low;\n    band[1] = (double){of_state}->high;\n"
        further += f"\n{_BAND}\n{{\n{ends}}}\n"
    declarations = "".join(f"EXPORT {function};\n" for function in declared)
    answers = "\n".join(
        f"""{function}(void)
{{
    return {answer.format(n=n, N=N)};
}}
"""
        for function, answer in _ASKED.items()
    )
    calls = "\n".join(
        f"""{function}
{{
    {n}_real values[{N}_INPUTS];
    {n}_real found;
    uint32_t flags;
    convert(in, values);
    flags = {n}_{call.format(n=n)}, &found);
    *{"field" if "field" in function else "effort"} = (double)found;
    return flags;
}}
"""
        for function, call in _CALLED.items()
    )
    return f"""/* The model ABI, version {VERSION}: {n} behind names that are the same for every model. */
#include <stddef.h>

#include "{n}.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

{declarations}
{answers}
/* 1 where the compiler kept the arithmetic; else every effort and field is 0. */
{_EXACT}
{{
    {n}_state state;
    return ({n}_reset(&state) == 0u) ? 1u : 0u;
}}

{_RESET}
{{
    (void){n}_reset(({n}_state *)state);
}}

static void convert(const double *in, {n}_real values[{N}_INPUTS])
{{
    uint32_t i;
    for (i = 0u; i < {N}_INPUTS; i++)
    {{
        values[i] = ({n}_real)in[i];
    }}
}}

{calls}
/* Many steps in one call: rows of {len(step.inputs)} numbers. */
{_RUN}
{{
    size_t i;
    for (i = 0u; i < rows; i++)
    {{
        flags[i] = erc_model_step(state, &in[i * {N}_INPUTS], &effort[i]);
    }}
}}
{further}"""

"""The C99 file and its header as text."""

from __future__ import annotations

from erclutch._version import __version__
from erclutch.export import c_effort, c_parts
from erclutch.export.c_code import functions_used
from erclutch.export.cost import cost_text
from erclutch.export.program import Program, Window
from erclutch.export.rounding import measured
from erclutch.model import TorqueModel

FLAGS = {
    "OUTSIDE_RANGE": "an input lies more than 1 % outside the training range: the effort is a guess",
    "NON_FINITE": "an input is not finite (or an angle beyond 1e6): the last good row is used, effort 0 before one",
    "BOTH_FIELDS": "both fields are on, above 1 % of the largest",
    "LIMITED": "the effort was held at its limit, or at the one before where it was not finite",
    "OUT_OF_REACH": "no field gives the wanted effort (inverse only)",
}


_WITH_BITS = {"exp", "exp_held", "expm1", "power"}
_ORDER = ("absolute", "exp", "exp_hold", "exp_held", "expm1", "tanh", "tanh_hold", "tanh_held", "power")


def source(program: Program) -> str:
    """The .c file."""
    n, p = f"{program.name}_", program.precision
    graphs = [program.command, *([program.law] if program.law else [])]
    used = functions_used(graphs)
    if not isinstance(program.model, TorqueModel):
        name = "exp" if program.model.structure.kind == "rbfn" else "tanh"
        used |= {f"{name}_hold", f"{name}_held"}
    parts = [c_parts.bits(n, p)]
    if used & _WITH_BITS or (p.width == 64 and used & {"tanh", "tanh_held"}):
        parts.append(c_parts.real_of_bits(n, p))
    parts += [c_parts.function(n, name, p) for name in _ORDER if name in used]
    parts += [c_parts.limits(n, "field_limits", program.field, p), c_parts.limits(n, "slip_limits", program.slip, p)]
    parts += [c_parts.limits(n, f"extra{k}_limits", window, p) for k, window in enumerate(program.extras)]
    parts += [c_parts.windows(n), c_parts.fields(program, n), c_parts.slips(program, n)]
    parts += [c_parts.speeds(program, n), c_parts.accept(program, n)]
    parts += [c_effort.command(program, n), c_parts.respond(program, n)]
    parts += [_comment(c_effort.equation(program)) + c_effort.effort(program, n), c_effort.present(program, n)]
    parts += [c_parts.limited(program, n), c_parts.inverse(program, n), _public(program, n)]
    return _preamble(program) + "\n".join(part for part in parts if part)


def _comment(lines: list[str]) -> str:
    body = "\n".join(f"   {line}".rstrip() for line in lines)
    return f"/*\n{body}\n*/\n"


def _preamble(program: Program) -> str:
    n = program.name
    return f"""/* {program.model.title} ({program.model.name}). Written by erclutch {__version__}; see {n}.h.
   Model {program.digest}

   Compile with -std=c99 -ffp-contract=off (and never with -ffast-math): then every compiler and processor with IEEE
   arithmetic gives the same bits. Brackets fix the order of each sum. */

#include "{n}.h"

#if defined(__FAST_MATH__)
#error "-ffast-math changes the numbers of this file"
#endif
#if defined(__FLT_EVAL_METHOD__) && (__FLT_EVAL_METHOD__ != 0) && (__FLT_EVAL_METHOD__ != 16)
#error "this processor computes with more digits than it stores: use SSE on x86 (-msse2 -mfpmath=sse)"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

"""


def _public(program: Program, n: str) -> str:
    return "\n".join([_reset(program, n), _step(program, n), _steady(program, n), _inverse(program, n)])


def _commands(program: Program, n: str) -> str:
    return "\n".join(f"        x[{i}] = {n}command(x[{i}]);" for i in range(program.elements))


def _step(program: Program, n: str) -> str:
    e, w, N = program.elements, program.elements + len(program.extras), n.upper()
    lag = f"        {n}respond(state, x);\n" if program.lag else ""
    effort = f"{n}present(state, x, w)" if program.past else f"{n}rest(x, w)"
    settled = "        state->settled = 1u;\n" if program.lag or program.past else ""
    return f"""uint32_t {n}step({n}state *state, const {n}real input[{N}INPUTS], {n}real *effort)
{{
    uint32_t flags = {n}accept(state, input);
    if (state->started != 0u)
    {{
        {n}real x[{e}];
        {n}real w[{w}];
        flags |= {n}fields(state->last, x);
        flags |= {n}slips(state->last, w);
{_commands(program, n)}
{lag}        flags |= {n}limited({effort}, &state->effort);
{settled}    }}
    *effort = state->effort;
    return flags;
}}
"""


def _steady(program: Program, n: str) -> str:
    e, w, N = program.elements, program.elements + len(program.extras), n.upper()
    zero = f"0.0{program.precision.suffix}"
    return f"""uint32_t {n}steady(const {n}real input[{N}INPUTS], {n}real *effort)
{{
    uint32_t flags = {N}NON_FINITE;
    uint32_t good = 1u;
    uint32_t i;
    for (i = 0u; i < {N}INPUTS; i++)
    {{
        good &= {n}finite(input[i]);
    }}
    *effort = {zero};
    if (good != 0u)
    {{
        {n}real x[{e}];
        {n}real w[{w}];
        flags = {n}fields(input, x);
        flags |= {n}slips(input, w);
{_commands(program, n)}
        flags |= {n}limited({n}rest(x, w), effort);
    }}
    return flags;
}}
"""


def _inverse(program: Program, n: str) -> str:
    e, w, N = program.elements, program.elements + len(program.extras), n.upper()
    zero = f"0.0{program.precision.suffix}"
    return f"""uint32_t {n}inverse(const {n}real input[{N}INPUTS], {n}real wanted, {n}real *field)
{{
    uint32_t flags = {N}NON_FINITE;
    uint32_t good = {n}finite(wanted);
    uint32_t i;
    for (i = {e}u; i < {N}INPUTS; i++)
    {{
        good &= {n}finite(input[i]);
    }}
    *field = {zero};
    if (good != 0u)
    {{
        {n}real w[{w}];
        flags = {n}slips(input, w);
        flags |= {n}search(w, wanted, field);
    }}
    return flags;
}}
"""


def _reset(program: Program, n: str) -> str:
    e, zero = program.elements, f"0.0{program.precision.suffix}"
    lines = ["state->started = 0u;", f"state->effort = {zero};"]
    loops = [f"    for (i = 0u; i < {n.upper()}INPUTS; i++)\n    {{\n        state->last[i] = {zero};\n    }}"]
    if program.filter:
        inner = f"state->position[i] = {zero};\n        state->speed[i] = {zero};"
        loops.append(f"    for (i = 0u; i < {e}u; i++)\n    {{\n        {inner}\n    }}")
    if program.lag:
        lines.append("state->at = 0u;")
        loops.append(f"""    for (i = 0u; i < {e}u; i++)
    {{
        uint32_t j;
        state->lag[i] = {zero};
        for (j = 0u; j < {program.lag.rows}u; j++)
        {{
            state->history[i][j] = {zero};
            state->slope[i][j] = {zero};
        }}
    }}""")
    if program.past:
        lines.append("state->past_at = 0u;")
        loops.append(f"""    for (i = 0u; i < {program.rows_back}u; i++)
    {{
        uint32_t j;
        for (j = 0u; j < {len(program.base)}u; j++)
        {{
            state->past[i][j] = {zero};
        }}
    }}""")
    if program.lag or program.past:
        lines.append("state->settled = 0u;")
    body = "\n".join([*(f"    {line}" for line in lines), *loops])
    return f"""void {n}reset({n}state *state)
{{
    uint32_t i;
{body}
}}
"""


# --- header ----------------------------------------------------------------------------------------------------------


def header(program: Program) -> str:
    """The .h file."""
    n, N, p = f"{program.name}_", f"{program.name}_".upper(), program.precision
    flags = "\n".join(
        f"#define {N}{name} ((uint32_t){1 << i}u) /* {text} */" for i, (name, text) in enumerate(FLAGS.items())
    )
    places = "\n".join(f"#define {N}IN_{_macro(name, i)} {i}u" for i, name in enumerate(program.inputs))
    signed = "signed field, E1 - E2," if program.elements == 2 else "field"
    return f"""{_header_comment(program)}
#ifndef {N}H
#define {N}H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {{
#endif

typedef {p.c_type} {n}real;

#define {N}DIGEST "{program.digest}"
#define {N}VERSION "{__version__}"
#define {N}MODEL "{program.model.name}"
#define {N}INPUTS {len(program.inputs)}u
{places}

/* Flags, by bits. */
{flags}

{_state(program, n)}

/* Before the first step, and whenever the input was interrupted. */
void {n}reset({n}state *state);

/* One sample. Writes the effort, always finite; returns flags. */
uint32_t {n}step({n}state *state, const {n}real input[{N}INPUTS], {n}real *effort);

/* The effort once the fluid has settled; no state. Takes speeds. */
uint32_t {n}steady(const {n}real input[{N}INPUTS], {n}real *effort);

/* The {signed} whose settled effort is the wanted one; no state.
   Takes speeds; what the input says of fields is not looked at. Out of reach: the end of the range that comes nearest.
   At most {_evaluations(program)} evaluations of the model. {_monotone(program)} */
uint32_t {n}inverse(const {n}real input[{N}INPUTS], {n}real wanted, {n}real *field);

#ifdef __cplusplus
}}
#endif

#endif
"""


def _macro(name: str, index: int) -> str:
    kept = "".join(c if c.isascii() and c.isalnum() else "_" for c in name).upper().strip("_")
    return kept if index < 4 and kept else f"FURTHER_{index}"


def _evaluations(program: Program) -> int:
    s = program.search
    return 1 + s.segments * (1 if s.minus == s.origin else 2) + s.most


def _monotone(program: Program) -> str:
    s = program.search
    if s.segments == 1:
        return (
            "Checked: the effort is monotone on each side of zero field,\n   so there is one such field a side; "
            "the one nearest to zero is given."
        )
    return (
        f"Checked: the effort turns along {100 * (1 - s.monotone_share):.3g} % of the lines\n   of growing field, so "
        f"the range is searched in {s.segments} parts a side and the field nearest to zero is given."
    )


def _state(program: Program, n: str) -> str:
    e = program.elements
    members = [f"{n}real last[{len(program.inputs)}]; /* last good row */", f"{n}real effort;"]
    if program.filter:
        members += [f"{n}real position[{e}];", f"{n}real speed[{e}];"]
    if program.lag:
        members += [f"{n}real lag[{e}];", f"{n}real history[{e}][{program.lag.rows}];"]
        members += [f"{n}real slope[{e}][{program.lag.rows}];", "uint32_t at;"]
    if program.past:
        members += [f"{n}real past[{program.rows_back}][{len(program.base)}];", "uint32_t past_at;"]
    if program.lag or program.past:
        members += ["uint32_t settled;"]
    members += ["uint32_t started;"]
    body = "\n".join(f"    {m}" for m in members)
    return f"/* Everything that a step remembers; one for each device. */\ntypedef struct\n{{\n{body}\n}} {n}state;"


def _header_comment(program: Program) -> str:
    model, p = program.model, program.precision
    rows = ["input            unit       trained on                    held within"]
    for i, (name, unit) in enumerate(zip(program.inputs, program.units, strict=True)):
        rows.append(f"[{i}] {name:<12.12} {unit:<11.11}{_ranges(program, i)}")
    if program.elements == 2:
        rows.append(f"slips w1 = theta_dot - alpha_dot and w2 = -theta_dot - alpha_dot: {_window(program.slip)}")
    low, high = program.limits
    unit = model.units.effort or "1"
    trained = model.trained_on.effort
    period = "None of it depends on the sampling period."
    if program.lag or program.filter:
        period = f"Call the step every {program.period:.9g} s: lag, delay and filter are made for it."
    elif program.past:
        period = f"Call the step every {program.period:.9g} s, the period of the training data: past rows are inputs."
    difference, limit = measured(program)
    angles: list[str] = []
    if program.filter:
        angles = ["", f"Positions are differentiated inside (filter {program.filter.name})."]
        if program.filter.turn:
            angles += ["Angles may wrap at a turn, and should: a float32 angle of many turns has few digits left."]
    lines = [
        f"{model.title}: {model.name}, device {model.structure.device}. Written by erclutch {__version__}.",
        f"Model {program.digest}",
        "",
        *rows,
        "Units are those of the training data; 1 is none, ? unknown.",
        *angles,
        "",
        f"effort in {unit}: trained on {trained[0]:.6g} .. {trained[1]:.6g}, limited to {low:.6g} .. {high:.6g}.",
        period,
        "",
        f"{p.name}, no libm, no allocation, no globals; one state a device, so it is re-entrant.",
        *cost_text(program),
        f"Rounding: {difference:.2g} {unit} off the model in float64 at most on random rows of the training range;",
        f"error analysis allows {limit:.2g} {unit}, {100 * limit / program.scale:.2g} % of the largest effort.",
        "An input far outside its training range is held a tenth of that range outside it (see the table).",
    ]
    return _comment(lines).rstrip("\n")


def _ranges(program: Program, i: int) -> str:
    e = program.elements
    if i < e:
        return _window(program.field)
    if i < 2 * e:
        return "see the slips below" if e == 2 else ("see slip" if program.filter else _window(program.slip))
    return _window(program.extras[i - 2 * e])


def _window(window: Window) -> str:
    trained = f"{window.range[0]:.6g} .. {window.range[1]:.6g}"
    return f"{trained:<30}{window.hold[0]:.6g} .. {window.hold[1]:.6g}"

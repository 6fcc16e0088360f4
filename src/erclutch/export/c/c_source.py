"""This module writes the C99 file as text; its header is `c_header`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from erclutch._version import __version__
from erclutch.arithmetic.record import Record
from erclutch.export.c import c_inverse, c_network
from erclutch.export.c.c_functions import functions
from erclutch.export.c.c_printer import Printer, function, functions_used, indented, rings_of
from erclutch.export.c.c_self_check import COMPILE_TIME, exact_function
from erclutch.export.encode import comment
from erclutch.export.exported_step import LARGEST_ANGLE, ExportedStep
from erclutch.export.recording.recorded_step import StepRecord
from erclutch.export.recording.step_recording import SWITCHED_OFF
from erclutch.export.step_record import feels_state, rest_record, settled_record, step_record

FLAGS = {
    "OUTSIDE_RANGE": "no training row is near the input, or it lies outside the training range: the effort is a guess",
    "NON_FINITE": "an input is not finite (or an angle beyond 1e6): the last good row is used, effort 0 before one",
    "BOTH_FIELDS": "both fields are on, above 1 % of the largest",
    "LIMITED": "the effort was held at its limit, or at the one before where it was not finite",
    "OUT_OF_REACH": "no field gives the wanted effort (inverses only)",
    "WIDE_BAND": "the effort's band is wider than a quarter of the largest training effort, or there is none",
    "DRIFT": "the measured effort has lain outside the band or to one side of the estimate for too long",
    "ADAPTED": "the effort is the model's with the gain and offset that follow the measured effort",
}
FLAG_NAMES = {1 << i: name for i, name in enumerate(FLAGS)}


@lru_cache(maxsize=4)
def source(step: ExportedStep, further: frozenset[str] = frozenset()) -> str:
    """The .c file; with further elementary functions for what another target adds to it."""
    n = f"{step.name}_"
    p = step.precision
    network = step.network
    record = step_record(step).record
    used = functions_used([record, rest_record(step).record]) | further
    if network is not None:
        name = "exp" if network.structure.kind == "rbfn" else "tanh"
        used |= {f"{name}_hold", f"{name}_held"}
    parts = [*functions(n, used, p), exact_function(n, p)]

    def add(name: str, calls: Mapping[str, Record], before: str = "") -> None:
        """A function that a record calls, where it does."""
        if name in calls:
            text = function(n, p, name, calls[name], _ABOUT[name])
            parts.append(before + text)

    for name in ("kept", "held", "turned", "limited"):
        add(name, record.calls)
    at_rest = settled_record(step).calls
    add("command", at_rest)
    equation = comment_block(step.model.equation())
    if network is not None:
        parts.append(equation + c_network.network(network, n, p))
        equation = ""  # it stands once, above what it is about
    add("rest", at_rest, equation)
    if "away" in at_rest:
        add("both", at_rest["away"].calls)
        add("away", at_rest)
    add("residual", at_rest)
    parts.append(c_inverse.inverse(step, n))

    # The functions of the header.
    parameters = f"const {n}real input[{n.upper()}INPUTS], {n}real *effort"
    of_step = f"uint32_t {n}step({n}state *state, {parameters})"
    of_rest = f"uint32_t {n}steady({parameters})"
    rings = rings_of(record)
    zero = f"0.0{p.suffix}"
    forget: list[str] = []  # numbers of the state, then the rings of earlier signals
    for name, node in record.after.items():
        forget.append(f"state->{name} = {'0u' if node.kind == 'truth' else zero};")
    for length in rings:
        forget.append(f"state->at{length} = 0u;")
    for length, count in rings.items():
        forget.append(f"for (i = 0u; i < {length}u; i++)")
        forget.append("{")
        forget += [f"    state->ring{length}[i][{signal}] = {zero};" for signal in range(count)]
        forget.append("}")
    forget.append(f"state->exact = {n}exact();")
    forget.append(f"return (state->exact != 0u) ? (uint32_t)0u : {n.upper()}INEXACT;")
    counter = "    uint32_t i;\n" if rings else ""
    parts.append(f"uint32_t {n}reset({n}state *state)\n{{\n{counter}{indented(forget)}\n}}\n")
    if SWITCHED_OFF in record.after:
        parts.append(f"{switching(n)}\n{{\n    state->{SWITCHED_OFF} = (on == 0u) ? 1u : 0u;\n}}\n")
    parts.append(_body(step, n, step_record(step), of_step, "state->exact"))
    parts.append(_body(step, n, rest_record(step), of_rest, f"{n}exact()"))

    # Both inverses; where the state makes no difference, the inverse of the next step calls the inverse at rest.
    asked = f"const {n}real input[{n.upper()}INPUTS], {n}real wanted, {n}real *field"
    no_state = "NULL, " if feels_state(step) else ""
    search_at_rest = [
        f"{n}real w[{c_inverse.held_count(step)}];",
        f"flags = {n}slips(input, w);",
        f"flags |= {n}search({no_state}w, wanted, field);",
    ]
    parts.append(_guarded(step, n, f"uint32_t {n}inverse({asked})", search_at_rest))
    of_next = f"uint32_t {n}inverse_now(const {n}state *state, {asked})"
    if feels_state(step):
        search = [f"flags = {n}search(state, input, wanted, field);"]
        parts.append(_guarded(step, n, of_next, search, now=True))
    else:
        at_once = f"    (void)state;\n    return {n}inverse(input, wanted, field);"
        parts.append(f"{of_next}\n{{\n{at_once}\n}}\n")
    text = "\n".join(parts)
    return f"""/* {step.headline}. Written by erclutch {__version__}; see {step.name}.h.
   Model {step.digest}
   {LICENCE}

   Compile with -std=c99 -ffp-contract=off (and never with -ffast-math): then every compiler and processor with IEEE
   arithmetic gives the same bits. Brackets fix the order of each sum. */

{_NULL if feels_state(step) else ""}#include "{step.name}.h"

{COMPILE_TIME}
{text}"""


#: The text below is erclutch's; what the log made of it is not.
LICENCE = """SPDX-License-Identifier: Apache-2.0
   This is the licence of the text, which erclutch wrote. The model's numbers belong to whoever owns the log."""
_NULL = "#include <stddef.h> /* NULL */\n\n"
#: What the functions of the records are, said above each.
_ABOUT = {
    "kept": "A number of the state; 0 where it is not finite, so that no row can spoil the rows after it",
    "held": "A value within two limits",
    "turned": "An angle less whole turns, within half a turn of zero",
    "limited": "A value within two limits; the one before where it is not finite",
    "command": "What the stages work on, from the field",
    "rest": "Effort at rest, or without a memory",
    "both": "The network, and the law for what is left of its share",
    "away": "Effort where training rows were not near on all sides: the law beyond them, or both",
    "residual": "What the network adds to the law",
}


def comment_block(lines: list[str]) -> str:
    """Lines as a comment of C; what a log or a package brought cannot end it."""
    body = "\n".join(f"   {comment(line)}".rstrip() for line in lines)
    return f"/*\n{body}\n*/\n"


def _body(
    step: ExportedStep,
    n: str,
    record: StepRecord,
    signature: str,
    exact: str,
) -> str:
    """A function that gives effort and flags; no row is good where the compiler changed the arithmetic."""
    N = n.upper()
    names = {name: f"input[{place}]" for place, name in enumerate(record.inputs)}
    printer = Printer(n, step.precision, record.record, names, conditions={"row_good": exact})
    lines = list(printer.lines())
    effort, *truths = printer.results()
    flags = [
        f"(({truth}) * {N}{FLAG_NAMES[bit]})"
        for bit, truth in zip(record.flags, truths, strict=True)
    ]
    lines += printer.kept()
    lines.append(f"*effort = {effort};")
    lines.append(f"return {' | '.join(flags)};")
    return f"{signature}\n{{\n{indented(lines)}\n}}\n"


def _guarded(
    step: ExportedStep,
    n: str,
    signature: str,
    body: list[str],
    *,
    now: bool = False,
) -> str:
    """An inverse whose body runs where all is finite; the inputs of the next step may be angles."""
    N = n.upper()
    first = step.elements  # place of the first input after the fields
    exact = "state->exact" if now else f"{n}exact()"
    angles = ""
    if now and step.filter:
        largest = step.precision.constant(LARGEST_ANGLE)
        places = range(first, first + step.elements)
        within = [
            f"((-{largest} < input[{place}]) && (input[{place}] < {largest}))" for place in places
        ]
        angles = f"\n    good &= ({' && '.join(within)}) ? (uint32_t)1u : (uint32_t)0u;"
    # The last input of a step that measures is the effort, which no field depends on.
    inputs = f"{N}INPUTS{' - 1u' if step.measures else ''}"
    return f"""{signature}
{{
    uint32_t flags = {N}NON_FINITE;
    uint32_t good = {n}finite(wanted) & {exact};
    uint32_t i;
    for (i = {first}u; i < {inputs}; i++)
    {{
        good &= {n}finite(input[i]);
    }}{angles}
    *field = 0.0{step.precision.suffix};
    if (good != 0u)
    {{
{indented(f"    {line}" for line in body)}
    }}
    return flags;
}}
"""


def switching(n: str) -> str:
    """The function that takes the network on a law in and out."""
    return f"void {n}use_residual({n}state *state, uint32_t on)"

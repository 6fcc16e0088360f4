"""This module writes the C99 file and its header as text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache

import numpy as np

from erclutch._version import __version__
from erclutch.arithmetic.precision import Precision
from erclutch.arithmetic.record import Record
from erclutch.export.c import c_inverse, c_network
from erclutch.export.c.c_functions import functions
from erclutch.export.c.c_printer import Printer, function, functions_used, indented, rings_of
from erclutch.export.c.c_self_check import COMPILE_TIME, exact_function
from erclutch.export.c.include_guard import once
from erclutch.export.cost import cost_text
from erclutch.export.encode import c_string, comment
from erclutch.export.exported_step import LARGEST_ANGLE, ExportedStep, Window
from erclutch.export.rounding import measured
from erclutch.export.step_numbers import run
from erclutch.export.step_record import feels_next_field, feels_state, rest_record, settled_record, step_record
from erclutch.export.step_recording import SWITCHED_OFF, StepRecord
from erclutch.export.step_vectors import ordinary
from erclutch.models.alarms import LONG
from erclutch.models.gain_tracking import REACH

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
    n, p = f"{step.name}_", step.precision
    record, network = step_record(step).record, step.network
    used = functions_used([record, rest_record(step).record]) | further
    if network is not None:
        name = "exp" if network.structure.kind == "rbfn" else "tanh"
        used |= {f"{name}_hold", f"{name}_held"}
    parts = [*functions(n, used, p), exact_function(n, p)]
    for name, about in _ABOUT.items():
        if name in record.calls:
            parts.append(function(n, p, name, record.calls[name], about))
    called = settled_record(step).calls
    if "command" in called:
        parts.append(function(n, p, "command", called["command"], "What the stages work on, from the field"))
    equation = _comment(step.model.equation())
    if network is not None:
        parts.append(equation + c_network.network(network, n, p))
    rest = function(n, p, "rest", called["rest"], "Effort at rest, or without a memory")
    parts += [rest if network is not None else equation + rest]
    if "away" in called:
        inner = called["away"].calls
        if "both" in inner:
            parts.append(
                function(n, p, "both", inner["both"], "The network, and the law for what is left of its share")
            )
        about = "Effort where training rows were not near on all sides: the law beyond them, or both"
        parts.append(function(n, p, "away", called["away"], about))
    if "residual" in called:
        parts.append(function(n, p, "residual", called["residual"], "What the network adds to the law"))
    parts += [c_inverse.inverse(step, n), _public(step, n)]
    return _preamble(step) + "\n".join(parts)


#: The text below is erclutch's; what the log made of it is not.
LICENCE = """SPDX-License-Identifier: Apache-2.0
   This is the licence of the text, which erclutch wrote. The model's numbers belong to whoever owns the log."""
_NULL = "#include <stddef.h> /* NULL */\n\n"
_ABOUT = {
    "kept": "A number of the state; 0 where it is not finite, so that no row can spoil the rows after it",
    "held": "A value within two limits",
    "turned": "An angle less whole turns, within half a turn of zero",
    "limited": "A value within two limits; the one before where it is not finite",
}


def _comment(lines: list[str]) -> str:
    body = "\n".join(f"   {comment(line)}".rstrip() for line in lines)
    return f"/*\n{body}\n*/\n"


def _preamble(step: ExportedStep) -> str:
    n = step.name
    return f"""/* {step.headline}. Written by erclutch {__version__}; see {n}.h.
   Model {step.digest}
   {LICENCE}

   Compile with -std=c99 -ffp-contract=off (and never with -ffast-math): then every compiler and processor with IEEE
   arithmetic gives the same bits. Brackets fix the order of each sum. */

{_NULL if feels_state(step) else ""}#include "{n}.h"

{COMPILE_TIME}
"""


def _public(step: ExportedStep, n: str) -> str:
    """The functions of the header."""
    record, N = step_record(step), n.upper()
    signature = f"uint32_t {n}step({n}state *state, const {n}real input[{N}INPUTS], {n}real *effort)"
    at_rest = f"uint32_t {n}steady(const {n}real input[{N}INPUTS], {n}real *effort)"
    parts = [_reset(record.record, n, step.precision)]
    if SWITCHED_OFF in record.record.after:
        parts.append(f"{_switching(n)}\n{{\n    state->{SWITCHED_OFF} = (on == 0u) ? 1u : 0u;\n}}\n")
    parts.append(_body(step, n, record, signature, "state->exact"))
    at_rest_body = _body(step, n, rest_record(step), at_rest, f"{n}exact()")
    return "\n".join([*parts, at_rest_body, _inverse(step, n)])


def _body(step: ExportedStep, n: str, record: StepRecord, signature: str, exact: str) -> str:
    """A function that gives effort and flags; no row is good where the compiler changed the arithmetic."""
    names = {name: f"input[{i}]" for i, name in enumerate(record.inputs)}
    printer = Printer(n, step.precision, record.record, names, conditions={"row_good": exact})
    lines = list(printer.lines())
    effort, *truths = printer.results()
    flags = [f"(({text}) * {n.upper()}{FLAG_NAMES[bit]})" for bit, text in zip(record.flags, truths, strict=True)]
    lines += [*printer.kept(), f"*effort = {effort};", f"return {' | '.join(flags)};"]
    return f"{signature}\n{{\n{indented(lines)}\n}}\n"


def _inverse(step: ExportedStep, n: str) -> str:
    """Both inverses; where the state makes no difference, that of the next step is that at rest."""
    parameters = f"const {n}real input[{n.upper()}INPUTS], {n}real wanted, {n}real *field"
    no_state = "NULL, " if feels_state(step) else ""
    search_at_rest = [
        f"{n}real w[{c_inverse.held_count(step)}];",
        f"flags = {n}slips(input, w);",
        f"flags |= {n}search({no_state}w, wanted, field);",
    ]
    at_rest = _guarded(step, n, f"uint32_t {n}inverse({parameters})", search_at_rest)
    signature = f"uint32_t {n}inverse_now(const {n}state *state, {parameters})"
    if feels_state(step):
        search = [f"flags = {n}search(state, input, wanted, field);"]
        return f"{at_rest}\n{_guarded(step, n, signature, search, now=True)}"
    return f"{at_rest}\n{signature}\n{{\n    (void)state;\n    return {n}inverse(input, wanted, field);\n}}\n"


def _guarded(step: ExportedStep, n: str, signature: str, body: list[str], *, now: bool = False) -> str:
    """An inverse whose body runs where all is finite; the inputs of the next step may be angles."""
    p, e, N = step.precision, step.elements, n.upper()
    exact = "state->exact" if now else f"{n}exact()"
    zero, largest = f"0.0{p.suffix}", p.constant(LARGEST_ANGLE)
    angles = ""
    if now and step.filter:
        within = [f"((-{largest} < input[{i}]) && (input[{i}] < {largest}))" for i in range(e, 2 * e)]
        angles = f"\n    good &= ({' && '.join(within)}) ? (uint32_t)1u : (uint32_t)0u;"
    # The last input of a step that measures is the effort, which no field depends on.
    inputs = f"{N}INPUTS{' - 1u' if step.measures else ''}"
    return f"""{signature}
{{
    uint32_t flags = {N}NON_FINITE;
    uint32_t good = {n}finite(wanted) & {exact};
    uint32_t i;
    for (i = {e}u; i < {inputs}; i++)
    {{
        good &= {n}finite(input[i]);
    }}{angles}
    *field = {zero};
    if (good != 0u)
    {{
{indented(f"    {line}" for line in body)}
    }}
    return flags;
}}
"""


def _reset(record: Record, n: str, p: Precision) -> str:
    """The function that forgets all rows: numbers of the state, then the rings of earlier signals."""
    zero = f"0.0{p.suffix}"
    rings = rings_of(record)
    lines = [f"state->{name} = {'0u' if node.kind == 'truth' else zero};" for name, node in record.after.items()]
    lines += [f"state->at{length} = 0u;" for length in rings]
    for length, count in rings.items():
        lines += [f"for (i = 0u; i < {length}u; i++)", "{"]
        lines += [f"    state->ring{length}[i][{k}] = {zero};" for k in range(count)]
        lines += ["}"]
    declared = "    uint32_t i;\n" if rings else ""
    lines += [f"state->exact = {n}exact();", f"return (state->exact != 0u) ? (uint32_t)0u : {n.upper()}INEXACT;"]
    return f"uint32_t {n}reset({n}state *state)\n{{\n{declared}{indented(lines)}\n}}\n"


def _switching(n: str) -> str:
    return f"void {n}use_residual({n}state *state, uint32_t on)"


# --- header ----------------------------------------------------------------------------------------------------------


def header(step: ExportedStep) -> str:
    """The .h file."""
    n, N, p = f"{step.name}_", f"{step.name}_".upper(), step.precision
    left_out = {*(() if step.alarms else ("WIDE_BAND", "DRIFT")), *(() if step.tracking else ("ADAPTED",))}
    raised = [(i, name) for i, name in FLAG_NAMES.items() if name not in left_out]
    flags = "\n".join(f"#define {N}{name} ((uint32_t){i}u) /* {FLAGS[name]} */" for i, name in raised)
    places = "\n".join(f"#define {N}IN_{name} {i}u" for i, name in enumerate(_macros(step.inputs)))
    signed = "signed field, E1 - E2," if step.elements == 2 else "field"
    search = step.search
    sides = 1 if search.minus == search.origin else 2
    evaluations = 1 + search.segments * sides + search.most
    declared = f"""#include <stdint.h>

#ifdef __cplusplus
extern "C" {{
#endif

typedef {p.c_type} {n}real;

#define {N}DIGEST "{step.digest}"
#define {N}VERSION "{__version__}"
#define {N}MODEL {c_string(step.model.name)}
#define {N}INPUTS {len(step.inputs)}u
{places}

/* Flags, by bits. */
{flags}

/* What a reset returns where the compiler's options changed the arithmetic: no flag of a step. */
#define {N}INEXACT ((uint32_t){2 * max(FLAG_NAMES)}u)

{_state(step, n)}

/* Before the first step, and whenever the input was interrupted. Returns 0; or {N}INEXACT, where the compiler's options
   changed the arithmetic: every row then counts as not finite, so all efforts and fields are 0. */
uint32_t {n}reset({n}state *state);
{_declared_switch(step, n)}
/* One sample. Writes the effort, always finite; returns flags.{_about_alarms(step)}{_about_tracking(step)} */
uint32_t {n}step({n}state *state, const {n}real input[{N}INPUTS], {n}real *effort);

/* The effort once the fluid has settled; no state. Takes speeds. */
uint32_t {n}steady(const {n}real input[{N}INPUTS], {n}real *effort);

/* The {signed} whose settled effort is the wanted one; no state.
   Takes speeds; what the input says of fields is not looked at. Out of reach: the end of the range that comes nearest.
   At most {evaluations} evaluations of the model. {_monotone(step)} */
uint32_t {n}inverse(const {n}real input[{N}INPUTS], {n}real wanted, {n}real *field);

{_now(step)}
uint32_t {n}inverse_now(const {n}state *state, const {n}real input[{N}INPUTS], {n}real wanted, {n}real *field);

#ifdef __cplusplus
}}
#endif
"""
    return f"{_header_comment(step)}\n{once(f'{N}H', declared)}"


def _now(step: ExportedStep) -> str:
    """What the header says of the inverse of the next step."""
    if not feels_state(step):
        return "/* The same as the inverse: the effort of this model does not depend on earlier samples. */"
    signed = "signed field, E1 - E2," if step.elements == 2 else "field"
    lines = [
        f"/* The {signed} that makes the effort of the next step the wanted one, with the state as it is: ask, then",
        "   take the step with this field and the same other inputs. The state stays as it is. What the input says of",
        "   fields is not looked at. Out of reach: the end of the range that comes nearest.",
    ]
    if not feels_next_field(step):
        lines += [
            "   This model has a dead time of a sample or more: no field changes the effort of the next step, so the",
            "   answer is the field nearest to zero, out of reach. Command the inverse at rest instead.",
        ]
    return "\n".join(lines) + " */"


def _declared_switch(step: ExportedStep, n: str) -> str:
    if step.model.correction is None:
        return ""
    return f"""
/* 0: from the next step on the effort is that of the law alone. 1, as after a reset: the network adds to it.
   For the step and the inverse of the next step: the two functions without a state have the network. */
{_switching(n)};
"""


def _about_alarms(step: ExportedStep) -> str:
    if step.alarms is None:
        return ""
    a, unit = step.alarms, comment(step.model.units.effort or "1")
    following = ""
    if a.part is not None:
        following = (
            f",\n   or too many blocks of {LONG * a.block} rows one of {100 * a.part:.3g} % of the effort or more"
        )
    return f"""
   state->low and state->high are the ends of its band, made to hold {100 * a.band.level:g} % of all measured
   efforts; above {a.wide:.6g} {unit} the band is wide. {_MEASURED}
   DRIFT: too many blocks of {a.block} rows had more than {100 * a.missing:.3g} % outside the band, or a mean residual
   beyond {a.lean:g} half widths of it on one side{following}; by chance once in {1.0 / a.false_alarms:.2g} blocks."""


_MEASURED = "The last input is the measured effort, NaN where there is none."


def _about_tracking(step: ExportedStep) -> str:
    if step.tracking is None:
        return ""
    unit = comment(step.model.units.effort or "1")
    return f"""
   state->track_gain, within {1 - REACH:g} and {1 + REACH:g}, and state->track_offset, within +-{REACH:g} in parts
   of {step.tracking.limit:.6g} {unit}, follow the measured effort. What is written is the adapted effort while it costs
   at most 2 % of RMSE in all since the reset, errors above {step.tracking.limit:.6g} {unit} counted as this much,
   else the model's own. A reset restores the model. The other functions answer for the model as it is. {_MEASURED}"""


def _macros(inputs: Sequence[str]) -> Iterator[str]:
    """What the input's places are called: by their name the first four, where no other has it."""
    kept = ["".join(c if c.isascii() and c.isalnum() else "_" for c in name).upper().strip("_") for name in inputs]
    for i, name in enumerate(kept):
        yield name if i < 4 and name and kept.index(name) == i else f"FURTHER_{i}"


def _monotone(step: ExportedStep) -> str:
    """What the header says of how sure the inverse is."""
    s = step.search
    if s.segments == 1:
        return (
            "Checked: the effort is monotone on each side of zero field,\n   so there is one such field a side; "
            "the one nearest to zero is given."
        )
    return (
        f"Checked: the effort turns along {100 * (1 - s.monotone_share):.3g} % of the lines\n   of growing field, so "
        f"the range is searched in {s.segments} parts a side and the field nearest to zero is given."
    )


def _state(step: ExportedStep, n: str) -> str:
    record = step_record(step).record
    reals = [name for name, node in record.after.items() if node.kind == "real"]
    members = [f"{n}real {name};" for name in reals]
    for length, count in rings_of(record).items():
        members += [f"{n}real ring{length}[{length}][{count}]; /* signals of earlier rows */"]
    members += [f"uint32_t {name};" for name in record.after if name not in reals]
    members += [f"uint32_t at{length};" for length in rings_of(record)]
    members += ["uint32_t exact; /* 1: the compiler kept the arithmetic */"]
    about = "/* Everything that a step remembers; one for each device. */"
    return f"{about}\ntypedef struct\n{{\n{indented(members)}\n}} {n}state;"


def _header_comment(step: ExportedStep) -> str:
    model, p = step.model, step.precision
    rows = ["input            unit       trained on                    held within"]
    for i, (name, unit) in enumerate(zip(step.inputs, step.units, strict=True)):
        rows.append(f"[{i}] {name:<12.12} {unit:<11.11}{_ranges(step, i)}")
    if step.elements == 2:
        rows.append(f"slips w1 = theta_dot - alpha_dot and w2 = -theta_dot - alpha_dot: {_window(step.slip)}")
    low, high = step.limits
    unit = model.units.effort or "1"
    trained = model.trained_on.effort
    period = "None of it depends on the sampling period."
    if step.stages or step.filter:
        period = f"Call the step every {step.period:.9g} s: stages and filter are made for it."
    elif step.model.past:
        period = f"Call the step every {step.period:.9g} s, the period of the training data: past rows are inputs."
    difference, limit = measured(step)
    angles: list[str] = []
    if step.filter:
        angles = ["", f"Positions are differentiated inside (filter {step.filter.name})."]
        if step.filter.turn:
            angles += ["Angles may wrap at a turn, and should: a float32 angle of many turns has few digits left."]
    lines = [
        f"{step.headline}, device {model.structure.device}. Written by erclutch {__version__}.",
        f"Its specification is {model.name}",
        f"Model {step.digest}",
        *map(str.strip, LICENCE.splitlines()),
        "",
        *_example(step, f"{step.name}_"),
        "",
        *rows,
        "Units are those of the training data; 1 is none, ? unknown.",
        *angles,
        "",
        f"effort in {unit}: trained on {trained[0]:.6g} .. {trained[1]:.6g}, limited to {low:.6g} .. {high:.6g}.",
        period,
        "",
        f"{p.name}, no libm, no allocation, no globals; one state a device, so it is re-entrant.",
        *cost_text(step),
        f"Rounding: {difference:.2g} {unit} off the model in float64 at most on random rows of the training range;",
        f"error analysis allows {limit:.2g} {unit}, {100 * limit / step.scale:.2g} % of the largest effort."
        if limit < step.scale
        else "error analysis has no bound for this model.",
        "An input far outside its training range is held a tenth of that range outside it (see the table).",
    ]
    return _comment(lines).rstrip("\n")


def _example(step: ExportedStep, n: str) -> list[str]:
    """Lines of C that call the step."""
    N = n.upper()
    given = [(place, value) for place, value in zip(_macros(step.inputs), _example_row(step), strict=True) if value]
    return [
        "Example: declare a state, reset it once, then call the step for each sample and look at the flags.",
        f"    {n}state state;",
        f"    {n}real effort, input[{N}INPUTS] = {{0}};",
        "    uint32_t flags;",
        f"    {n}reset(&state);",
        *(f"    input[{N}IN_{place}] = ({n}real){value:.6g};" for place, value in given),
        f"    flags = {n}step(&state, input, &effort);",
    ]


def _example_row(step: ExportedStep) -> list[float]:
    """Inputs that raise no flag: the largest field and a slip of 1 where the model knows them, else random ones."""
    rows = np.round(ordinary(step, np.random.default_rng(0), 64), 4)
    rows[:, step.model_inputs :] = rows[0] = 0.0
    rows[0, [0, step.elements]] = step.field.range[1], 1.0
    return next((row for row in rows if not run(step, row[None])[1][0]), rows[0]).tolist()


def _ranges(step: ExportedStep, i: int) -> str:
    elements = step.elements
    if i < elements:
        return _window(step.field)
    if i >= step.model_inputs:
        return "NaN where it is not measured"
    if i >= 2 * elements:
        return _window(step.extras[i - 2 * elements])
    if elements == 2:
        return "see the slips below"
    return "see slip" if step.filter else _window(step.slip)


def _window(window: Window) -> str:
    trained = f"{window.range[0]:.6g} .. {window.range[1]:.6g}"
    return f"{trained:<30}{window.hold[0]:.6g} .. {window.hold[1]:.6g}"

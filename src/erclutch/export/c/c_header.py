"""This module writes the header of the exported C as text: what a caller has to know of the model and its functions."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

import numpy as np

from erclutch._version import __version__
from erclutch.export.c.c_printer import indented, rings_of
from erclutch.export.c.c_source import FLAG_NAMES, FLAGS, LICENCE, comment_block, switching
from erclutch.export.c.include_guard import once
from erclutch.export.cost import cost_text
from erclutch.export.encode import c_string, comment
from erclutch.export.exported_step import ExportedStep, Window
from erclutch.export.rounding import measured
from erclutch.export.step_numbers import run
from erclutch.export.step_record import feels_next_field, feels_state, step_record
from erclutch.export.step_vectors import ordinary
from erclutch.models.alarms import LONG
from erclutch.models.gain_tracking import REACH


def header(step: ExportedStep) -> str:
    """The .h file."""
    n = f"{step.name}_"
    N = n.upper()
    p = step.precision
    never_raised: list[str] = []
    if not step.alarms:
        never_raised += ["WIDE_BAND", "DRIFT"]
    if not step.tracking:
        never_raised.append("ADAPTED")
    raised = [(bit, name) for bit, name in FLAG_NAMES.items() if name not in never_raised]
    flags = "\n".join(
        f"#define {N}{name} ((uint32_t){bit}u) /* {FLAGS[name]} */" for bit, name in raised
    )
    places = "\n".join(
        f"#define {N}IN_{name} {place}u" for place, name in enumerate(_macros(step.inputs))
    )
    switch = ""
    if step.model.correction is not None:
        switch = f"""
/* 0: from the next step on the effort is that of the law alone. 1, as after a reset: the network adds to it.
   For the step and the inverse of the next step: the two functions without a state have the network. */
{switching(n)};
"""
    search = step.search
    sides = 1 if search.minus == search.origin else 2
    evaluations = 1 + search.segments * sides + search.most
    sure = (
        "Checked: the effort is monotone on each side of zero field,\n   so there is one such field a side; "
        "the one nearest to zero is given."
    )
    if search.segments > 1:
        turning = 100 * (1 - search.monotone_share)  # %
        sure = (
            f"Checked: the effort turns along {turning:.3g} % of the lines\n   of growing field, so "
            f"the range is searched in {search.segments} parts a side and the field nearest to zero is given."
        )
    # What an inverse answers: of a pair both fields as one number.
    signed = "signed field, E1 - E2," if step.elements == 2 else "field"
    about_next = "/* The same as the inverse: the effort of this model does not depend on earlier samples. */"
    if feels_state(step):
        dead_time = ""
        if not feels_next_field(step):
            dead_time = """
   This model has a dead time of a sample or more: no field changes the effort of the next step, so the
   answer is the field nearest to zero, out of reach. Command the inverse at rest instead."""
        about_next = f"""\
/* The {signed} that makes the effort of the next step the wanted one, with the state as it is: ask, then
   take the step with this field and the same other inputs. The state stays as it is. What the input says of
   fields is not looked at. Out of reach: the end of the range that comes nearest.{dead_time} */"""
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
{switch}
/* One sample. Writes the effort, always finite; returns flags.{_about_alarms(step)}{_about_tracking(step)} */
uint32_t {n}step({n}state *state, const {n}real input[{N}INPUTS], {n}real *effort);

/* The effort once the fluid has settled; no state. Takes speeds. */
uint32_t {n}steady(const {n}real input[{N}INPUTS], {n}real *effort);

/* The {signed} whose settled effort is the wanted one; no state.
   Takes speeds; what the input says of fields is not looked at. Out of reach: the end of the range that comes nearest.
   At most {evaluations} evaluations of the model. {sure} */
uint32_t {n}inverse(const {n}real input[{N}INPUTS], {n}real wanted, {n}real *field);

{about_next}
uint32_t {n}inverse_now(const {n}state *state, const {n}real input[{N}INPUTS], {n}real wanted, {n}real *field);

#ifdef __cplusplus
}}
#endif
"""
    return f"{_header_comment(step)}\n{once(f'{N}H', declared)}"


def _about_alarms(step: ExportedStep) -> str:
    if step.alarms is None:
        return ""
    a = step.alarms
    unit = comment(step.model.units.effort or "1")
    following = ""
    if a.part is not None:
        blocks = f"blocks of {LONG * a.block} rows"
        following = f",\n   or too many {blocks} one of {100 * a.part:.3g} % of the effort or more"
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
    seen: set[str] = set()
    for place, name in enumerate(inputs):
        # One underscore at a time: C++ keeps names with two of them in a row for itself.
        macro = re.sub("[^A-Za-z0-9]+", "_", name).upper().strip("_")
        if place < 4 and macro and macro not in seen:
            yield macro
        else:
            yield f"FURTHER_{place}"
        seen.add(macro)


def _state(step: ExportedStep, n: str) -> str:
    record = step_record(step).record
    rings = rings_of(record)
    numbers = [name for name, node in record.after.items() if node.kind == "real"]
    truths = [name for name in record.after if name not in numbers]
    members = [f"{n}real {name};" for name in numbers]
    for length, count in rings.items():
        members.append(f"{n}real ring{length}[{length}][{count}]; /* signals of earlier rows */")
    members += [f"uint32_t {name};" for name in truths]
    members += [f"uint32_t at{length};" for length in rings]
    members.append("uint32_t exact; /* 1: the compiler kept the arithmetic */")
    about = "/* Everything that a step remembers; one for each device. */"
    return f"{about}\ntypedef struct\n{{\n{indented(members)}\n}} {n}state;"


def _header_comment(step: ExportedStep) -> str:
    model = step.model
    inputs = ["input            unit       trained on                    held within"]
    first_further = 2 * step.elements  # place of the first further input, behind fields and speeds
    for place, (name, unit) in enumerate(zip(step.inputs, step.units, strict=True)):
        if place < step.elements:
            has_field = step.field.range != (0.0, 0.0)
            ranges = _window(step.field) if has_field else "no field in the log: leave it 0"
        elif place >= step.model_inputs:
            ranges = "NaN where it is not measured"
        elif place >= first_further:
            ranges = _window(step.extras[place - first_further])
        elif step.elements == 2:
            ranges = "see the slips below"
        else:
            ranges = "see slip" if step.filter else _window(step.slip)
        inputs.append(f"[{place}] {name:<12.32} {unit:<11.11}{ranges}")
    if step.elements == 2:
        inputs.append(
            f"slips w1 = theta_dot - alpha_dot and w2 = -theta_dot - alpha_dot: {_window(step.slip)}"
        )
    angles: list[str] = []
    if step.filter:
        angles = ["", f"Positions are differentiated inside (filter {step.filter.name})."]
        if step.filter.turn:
            angles.append(
                "Angles may wrap at a turn, and should: a float32 angle of many turns has few digits left."
            )
    low, high = step.limits
    unit = model.units.effort or "1"
    trained = model.trained_on.effort
    period = "None of it depends on the sampling period."
    if step.stages or step.filter:
        period = f"Call the step every {step.period:.6g} s: stages and filter are made for it."
    elif model.past:
        period = f"Call the step every {step.period:.6g} s, the period of the training data: past rows are inputs."
    difference, limit = measured(step)
    allowed = "error analysis has no bound for this model."
    if limit < step.scale:
        allowed = f"error analysis allows {limit:.2g} {unit}, {100 * limit / step.scale:.2g} % of the largest effort."
    lines = [
        f"{step.headline}, device {model.structure.device}. Written by erclutch {__version__}.",
        f"Its specification is {model.name}",
        f"Model {step.digest}",
        *map(str.strip, LICENCE.splitlines()),
        "",
        *_example(step, f"{step.name}_"),
        "",
        *inputs,
        "Units are those of the training data; 1 is none, ? unknown.",
        *angles,
        "",
        f"effort in {unit}: trained on {trained[0]:.6g} .. {trained[1]:.6g}, limited to {low:.6g} .. {high:.6g}.",
        period,
        "",
        f"{step.precision.name}, no libm, no allocation, no globals; one state a device, so it is re-entrant.",
        *cost_text(step),
        f"Rounding: {difference:.2g} {unit} off the model in float64 at most on random rows of the training range;",
        allowed,
        "An input far outside its training range is held a tenth of that range outside it (see the table).",
    ]
    return comment_block(lines).rstrip("\n")


def _example(step: ExportedStep, n: str) -> list[str]:
    """Lines of C that call the step."""
    N = n.upper()

    # Inputs that raise no flag: the largest field and a slip of 1 where the model knows them, else random ones.
    drawn = ordinary(step, np.random.default_rng(0), 64)
    rows = np.round(drawn, 4)
    rows[:, step.model_inputs :] = 0.0
    rows[0] = 0.0
    rows[0, 0] = step.field.range[1]
    rows[0, step.elements] = 1.0
    example = rows[0]
    for row in rows:
        _, flags = run(step, row[None])
        if not flags[0]:
            example = row
            break

    values: list[str] = []
    for place, value in zip(_macros(step.inputs), example.tolist(), strict=True):
        if value:
            values.append(f"    input[{N}IN_{place}] = ({n}real){value:.6g};")
    return [
        "Example: declare a state, reset it once, then call the step for each sample and look at the flags.",
        f"    {n}state state;",
        f"    {n}real effort, input[{N}INPUTS] = {{0}};",
        "    uint32_t flags;",
        f"    {n}reset(&state);",
        *values,
        f"    flags = {n}step(&state, input, &effort);",
    ]


def _window(window: Window) -> str:
    trained = f"{window.range[0]:.6g} .. {window.range[1]:.6g}"
    return f"{trained:<30}{window.hold[0]:.6g} .. {window.hold[1]:.6g}"

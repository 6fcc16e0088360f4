"""A plan is saved as a mapping file (`erclutch.logs.mapping`), with its reasons and questions as comments."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

from erclutch.errors import MappingError
from erclutch.files import unwritable, whole_file
from erclutch.files.places import nothing
from erclutch.logs.mapping import NONE
from erclutch.logs.plan import Plan


def mapping_text(plan: Plan) -> str:
    """The text of the mapping file by which a log is read as the plan says."""
    told = plan.told
    keys = "All keys: documentation of erclutch.logs.mapping"
    lines = [f"# How {_plain(plan.log)} is read ({plan.device} device). {keys}."]
    if told.rate is not None:
        lines.append(f"rate = {told.rate!r}  # Hz")
    elif plan.clock is not None and plan.clock.kind == "column":
        time = _choice(plan.clock.column, plan.clock.unit, plan.clock.scale)
        lines.append(f"time = {time}  # {_plain(plan.clock.reason)}")
    elif told.declines("time"):
        lines.append(f"time = {_text(NONE)}  # the rows are points")
    if told.lead is not None:
        lines.append(f"lead = {told.lead!r}")
    for key in ("name_pattern", "variable", "decimal", "values", "invalid"):
        if getattr(told, key) is not None:
            lines.append(f"{key} = {_text(getattr(told, key))}")
    if told.inputs:
        inputs = [_text(str(choice.column)) for choice in told.inputs]
        lines.append(f"inputs = [{', '.join(inputs)}]")
    apart = ("time", "lead", "input", "variable")
    for question in plan.questions:
        if question.signal in apart:
            lines += [f"# missing: {_plain(question.short)}", f'# {question.signal} = "..."']

    lines += ["", "[columns]", *_column_lines(plan, apart)]
    tables = {"scales": told.scales, "zeros": told.zeros, "constants": told.constants}
    for head, values in tables.items():
        if values:
            lines += ["", f"[{head}]"]
            lines += [f"{_text(name)} = {_text(text)}" for name, text in values.items()]
    return "\n".join([*lines, ""])


def save_plan(plan: Plan, path: Path) -> None:
    """Write a plan as a mapping file; see `save_mapping`."""
    save_mapping(mapping_text(plan), path)


def save_mapping(text: str, path: Path) -> None:
    """Write a mapping file, whole or not at all.

    Raises:
        MappingError: the file is there already, or cannot be written.
    """
    if path.exists():
        problem = "there is such a file, and it may be your own mapping"
        remedy = "Give another name, or delete the file first"
        raise MappingError(problem, where=str(path), remedy=remedy)
    remedy = "Give a file in a folder that you may write to"
    refused = partial(unwritable, remedy=remedy, kind=MappingError)
    with whole_file(path, refused, nothing) as whole:
        whole.write_text(text, encoding="utf-8")


def _column_lines(plan: Plan, apart: tuple[str, ...]) -> list[str]:
    """A line for each signal, and two for each that is asked about."""
    lines: list[str] = []
    for each in plan.signals:
        if each.column:
            line = f"{each.signal} = {_choice(each.column, each.unit, each.scale)}  # {_plain(each.reason)}"
            # A position that is named beside the slip is an input of the models; a guessed one is not.
            beside_the_slip = each.signal == "position" and plan.signal("slip") is not None
            is_guessed = "position" not in plan.told.columns
            lines.append(f"# {line}" if beside_the_slip and is_guessed else line)
        elif each.signal == "field" and each.signal in plan.told.columns:
            lines.append(f"field = {_text(NONE)}  # {_plain(each.reason)}")
    for signal in plan.told.columns:
        if plan.told.declines(signal) and plan.signal(signal) is None:
            lines.append(f"{signal} = {_text(NONE)}")
    taken = {each.column for each in plan.signals}
    left = [label for name, label in plan.labels.items() if name not in taken]
    free = _plain(", ".join(left))
    for question in sorted(plan.questions, key=lambda each: each.signal):
        if question.signal not in apart:
            lines.append(f"# missing: {_plain(question.short)}")
            lines.append(f'# {question.signal} = "COLUMN [unit]"  # columns left: {free}')
    return lines


def _choice(column: str, unit: str | None, scale: float) -> str:
    """A column as the value of a key in a mapping file."""
    parts = [f"column = {_text(column)}"]
    if unit:
        parts.append(f"unit = {_text(unit)}")
    if scale != 1.0:
        parts.append(f"scale = {scale!r}")
    return f"{{{', '.join(parts)}}}"


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _plain(text: str) -> str:
    """A text for a comment: one line without control characters."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)

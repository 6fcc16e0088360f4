"""The mapping that a log was read by becomes a TOML file: guesses are written down, what is missing is named."""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from erclutch.errors import MappingError
from erclutch.files import unwritable, whole_file
from erclutch.logs.assemble import understood
from erclutch.logs.mapping import ColumnChoice, ColumnMap
from erclutch.logs.table import Table
from erclutch.places import nothing
from erclutch.signals.device import DeviceName


def mapping_text(
    table: Table, chosen: ColumnMap, device: DeviceName = "single"
) -> tuple[str, tuple[str, ...], Mapping[str, ColumnChoice]]:
    """A mapping file for a log, what is missing in it, one sentence each, and the column of each signal.

    Args:
        table: the log's columns.
        chosen: what the user said; the rest is guessed, as in a reading.
        device: "single" or "coaxial".
    """
    draft = understood(table, chosen, device)
    missing = {name: error.problem.split("; the file has: ")[0] for name, error in draft.asked.items()}
    lines = [f"# How {_plain(table.name)} is read ({device} device). All keys: documentation of erclutch.logs.mapping."]
    if chosen.rate is not None:
        lines.append(f"rate = {chosen.rate!r}  # Hz")
    elif "time" in draft.choices:
        lines.append(_line("time", draft.choices["time"]))
    lines += [f"{key} = {value!r}" for key, value in (("lead", chosen.lead),) if value is not None]
    texts = (("name_pattern", chosen.name_pattern), ("variable", chosen.variable), ("invalid", chosen.invalid))
    lines += [f"{key} = {_text(value)}" for key, value in texts if value is not None]
    if chosen.inputs:
        lines.append(f"inputs = [{', '.join(_text(str(choice.column)) for choice in chosen.inputs)}]")
    free = [
        label for name, label in zip(table.columns, table.labels, strict=True) if name not in draft.columns.values()
    ]
    for signal in ("time", "lead", "input"):
        if signal in missing:
            lines += [f"# missing: {_plain(missing[signal])}", f'# {signal} = "..."']
    lines += ["", "[columns]"]
    lines += [_line(name, choice) for name, choice in draft.choices.items() if name != "time"]
    for signal in sorted(missing.keys() - {"time", "lead", "input"}):
        lines += [
            f"# missing: {_plain(missing[signal])}",
            f'# {signal} = "COLUMN [unit]"  # columns left: {_plain(", ".join(free))}',
        ]
    for head, values in (("scales", chosen.scales), ("constants", chosen.constants)):
        if values:
            lines += ["", f"[{head}]", *(f"{_text(name)} = {_text(text)}" for name, text in values.items())]
    return "\n".join([*lines, ""]), tuple(missing.values()), draft.choices


def write_mapping(path: Path, text: str) -> None:
    """Write a mapping file, whole or not at all.

    Raises:
        MappingError: the file is there already, or cannot be written.
    """
    if path.exists():
        remedy = "Give another name, or delete the file first"
        raise MappingError("there is such a file, and it may be your own mapping", where=str(path), remedy=remedy)
    remedy = "Give a file in a folder that you may write to"
    with whole_file(path, partial(unwritable, remedy=remedy, kind=MappingError), nothing) as whole:
        whole.write_text(text, encoding="utf-8")


def _line(signal: str, choice: ColumnChoice) -> str:
    parts = [f"column = {_text(str(choice.column))}"]
    parts += [f"unit = {_text(choice.unit)}"] if choice.unit else []
    parts += [f"scale = {choice.scale!r}"] if choice.scale != 1.0 else []
    return f"{signal} = {{{', '.join(parts)}}}" + f"  # {_plain(choice.source)}"


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _plain(text: str) -> str:
    """A text for a comment: one line without control characters."""
    return "".join(letter if letter.isprintable() else "?" for letter in text)

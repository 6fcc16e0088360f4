"""Scopes and recorders say what each channel is in lines with a key in front, above rows whose first cell is empty.

Yokogawa writes ``"TraceName","I","n"``, ``"VUnit","A","rpm"`` and ``"HResolution","2.0E-02","2.0E-02"`` so, FAMOS
``Kanal``, ``Einheit`` and ``Delta-X``. They become a line of names with units, and a sampling interval.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from erclutch.logs.columns.labels import split_label
from erclutch.logs.readers.cells import cells_of, is_numeric, line_of
from erclutch.logs.readers.dialect import lines_of

_HEAD = 1 << 15  # characters that hold all such lines
_FEWEST_ROWS = 2
_NAMES = (
    "tracename",
    "kanal",
    "kanalname",
    "channel",
    "channelname",
    "signal",
    "signalname",
    "name",
)
_UNITS = ("vunit", "unit", "units", "einheit", "yunit", "yeinheit", "yunitlabel")
_STEPS = (
    "hresolution",
    "deltax",
    "dx",
    "sampleinterval",
    "samplinginterval",
    "xincrement",
    "xdelta",
    "abtastzeit",
    "dt",
)
_STEP_UNITS = ("hunit", "xunit", "xeinheit")
#: How a line begins whose key may be one of the names: most lines of a log are rows, which begin otherwise.
_MAY_NAME = re.compile(rf"[\W_]*[{''.join({name[0] for name in _NAMES})}]", re.IGNORECASE)


def with_keyed_heads(text: str) -> tuple[str, str]:
    """The text with a line of names in place of such lines, and a note; the text and "" where there are none."""
    head = lines_of(text[:_HEAD])
    if len(text) > _HEAD:
        head.pop()
    if not any(map(_MAY_NAME.match, head)):
        return text, ""
    for delimiter in ("\t", ";", ","):
        heads = _lines_in(head, delimiter)
        if heads is None:
            continue
        first_line, first_row, cells_of_key = heads
        names = _cells_by(cells_of_key, _NAMES)
        own_units = _cells_by(cells_of_key, _UNITS) or [""] * len(names)
        steps = _cells_by(cells_of_key, _STEPS)
        units_of_steps = {*_cells_by(cells_of_key, _STEP_UNITS)} or {"s"}
        if len({*steps}) > 1 or len(units_of_steps) > 1:
            continue  # channels of several rates are no columns of one table
        labels: list[str] = []
        for name, unit in zip(names, own_units, strict=True):
            bare = unit.strip("[]() ")
            has_unit = split_label(name)[1] is not None
            labels.append(f"{name} [{bare}]" if bare and not has_unit else name)
        lines = lines_of(text)
        above = [*lines[:first_line]]
        if steps:
            above.append(f"Sampling interval: {steps[0].replace(',', '.')} {units_of_steps.pop()}")
        rows = [line.strip(" ").removeprefix(delimiter) for line in lines[first_row:]]
        keys = ", ".join(cells_of_key)[:80]
        note = f"lines with a key in front say what the {len(names)} channels are: {keys}"
        return "\n".join([*above, line_of(labels, delimiter), *rows]), note
    return text, ""


def _lines_in(lines: Sequence[str], delimiter: str) -> tuple[int, int, dict[str, list[str]]] | None:
    """The first such line, the first row, and the cells of the lines by their keys; None where there are none.

    Each line from that of the names on has a key and a cell for each channel, or says something of the whole file.
    """
    start = 0
    cells_of_key: dict[str, list[str]] = {}
    for place, line in enumerate(lines):
        if not cells_of_key and not _MAY_NAME.match(line):
            continue
        cells = cells_of(line.rstrip(delimiter), delimiter)
        key = re.sub(r"[\W_]", "", cells[0].lower()) if cells else ""
        if not cells_of_key:
            has_a_number = any(is_numeric(cell, delimiter) for cell in cells)
            are_names = len(cells) > 2 and all(cells[1:]) and not has_a_number
            if key in _NAMES and are_names:
                start = place
                cells_of_key[key] = cells[1:]
            continue
        width = len(next(iter(cells_of_key.values()))) + 1
        if key and len(cells) <= width and not is_numeric(cells[0], delimiter):
            if len(cells) == width:
                cells_of_key.setdefault(key, cells[1:])
            continue
        if not line.strip():
            continue
        first_rows = lines[place : place + _FEWEST_ROWS]
        below = [cells_of(row.rstrip(delimiter), delimiter) for row in first_rows]
        tells_units_or_steps = any(_cells_by(cells_of_key, keys) for keys in (_UNITS, _STEPS))
        if len(below) < _FEWEST_ROWS or not tells_units_or_steps:
            return None
        for first, *numbers in below:
            if first and len(numbers) == width - 2:  # rows without an empty cell below the keys
                numbers = [first, *numbers]
            elif first or len(numbers) != width - 1:
                return None
            if not all(is_numeric(cell, delimiter) for cell in numbers):
                return None
        return start, place, cells_of_key
    return None


def _cells_by(cells_of_key: dict[str, list[str]], keys: Sequence[str]) -> list[str]:
    """The cells of the first of some keys that a line has; none where no line has one."""
    return next((cells_of_key[key] for key in keys if key in cells_of_key), list[str]())

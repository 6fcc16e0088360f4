"""Lines above the rows may give the start and the step of all channels: of LabVIEW, SignalExpress and Rigol's scopes.

They become the sampling interval and the names with units that the text reader knows.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from erclutch.logs.readers.cells import cells_of, is_number
from erclutch.logs.readers.dialect import lines_of
from erclutch.signals import units

_HEAD = 1 << 13  # characters that hold all such lines
_MOST_LINES = 30
_STEP = re.compile(r"(?:delta t|dt)\s*:?", re.IGNORECASE)
_NO_TABLE = re.compile(r"(?:waveform|t0|start times?|channel names|data)\s*:?", re.IGNORECASE)
_COUNTED = re.compile(r"\s*\[\d+\]$")  # behind the name of a channel
_WORDS = {"volt": "V", "volts": "V", "amp": "A", "ampere": "A", "amps": "A"}


def with_steps_above(text: str) -> tuple[str, str]:
    """The text with a line for the step of its rows, and a note; the text and "" where no such lines are."""
    head = text[:_HEAD]
    if "ncrement" not in head:
        has_steps = re.search(r"^(?:delta t|dt)\b", head, re.IGNORECASE | re.MULTILINE)
        return _of_waveforms(text) if has_steps else (text, "")

    # Rigol's scopes write X,CH1,CH2,Start,Increment above Sequence,Volt,Volt,-4.0,2e-3.
    first, second, *rows = [*lines_of(text), "", ""]
    names = cells_of(first, ",")
    second_cells = cells_of(second, ",")
    places = {name.lower(): place for place, name in enumerate(names)}
    place_of_step = places.get("increment")
    start = places.get("start")
    if place_of_step is None or start is None or len(second_cells) <= max(place_of_step, start):
        return text, ""
    step = second_cells[place_of_step]
    if not is_number(step, ".") or not float(step) > 0.0:
        return text, ""
    channels = min(place_of_step, start)
    labels: list[str] = []
    for name, word in zip(names[1:channels], second_cells[1:channels], strict=True):
        unit = _WORDS.get(word.lower(), word)
        labels.append(f"{name} [{unit}]" if unit and units.is_unit(unit) else name)
    lines = [f"Sample interval: {step} s", ",".join([second_cells[0], *labels])]
    lines += [re.sub(r"[,\s]+$", "", row) for row in rows]
    note = f"the second line says the step of the rows, {step} s, and the units of the channels"
    return "\n".join(lines), note


def _of_waveforms(text: str) -> tuple[str, str]:
    """Lines for names, starts and steps of each channel, with what they say in the same line or in the line below."""
    lines = lines_of(text)
    above: list[str] = []
    step = ""
    names: Sequence[str] = ()
    place = 0
    last = 0  # line of what is said of the waveforms
    while place < min(len(lines), _MOST_LINES):
        key, *of_channels = cells_of(lines[place], "\t")
        is_step = _STEP.fullmatch(key) is not None
        is_known = is_step or _NO_TABLE.fullmatch(key) is not None
        if not is_known:
            above.append(lines[place])
            place += 1
            continue
        heads_data = key.lower().startswith("data")
        is_below = not any(of_channels) and not heads_data and place + 1 < len(lines)
        if is_below:
            place += 1
            of_channels = cells_of(lines[place], "\t")
        steps = {cell.replace(",", ".") for cell in of_channels if cell}
        if is_step:
            if len(steps) != 1 or not is_number(min(steps), "."):
                return text, ""  # channels of several rates are no columns of one table
            step = min(steps)
        elif key.lower().startswith("channel"):
            names = of_channels
        place += 1
        last = place
        above = [] if not names else above
    if not step:
        return text, ""
    rows = lines[last:]
    if names:
        rows = ["\t".join(names), *rows]
    else:
        first = next((number for number, line in enumerate(rows) if line.strip()), 0)
        rows[first] = "\t".join(_COUNTED.sub("", cell) for cell in cells_of(rows[first], "\t"))
    note = f"lines above say that the rows are {step} s apart"
    return "\n".join([f"Sampling interval: {step} s", *rows]), note

"""Oscilloscopes write ``Source,CH1,CH2`` above ``Second,Volt,Volt``: the names of channels, and words for their units.

Keysight writes ``x-axis,1,2``. Lines of settings stand above, of which a line of labels may name the channels.
"""

from __future__ import annotations

import re

from erclutch.logs.readers.cells import cells_of, is_number, line_of
from erclutch.logs.readers.dialect import lines_of

_HEAD = 1 << 13  # characters that hold all such lines
_FIRST = frozenset({"source", "x-axis", "xaxis", "x axis"})
#: Words that scopes write for units, in small letters.
_UNITS = {
    **dict.fromkeys(("second", "seconds", "s", "sec"), "s"),
    **dict.fromkeys(("volt", "volts", "v"), "V"),
    **dict.fromkeys(("millivolt", "mv"), "mV"),
    **dict.fromkeys(("ampere", "amperes", "amp", "amps", "a"), "A"),
    **dict.fromkeys(("milliampere", "ma"), "mA"),
    **dict.fromkeys(("watt", "w"), "W"),
}
_SETTINGS = re.compile(
    r"(?:vertical|horizontal|record|model|serial|software|firmware|waveform|point|probe|trigger|label)\b",
    re.IGNORECASE,
)


def with_scope_heads(text: str) -> tuple[str, str]:
    """The text with names and units of a scope's channels in one line, and a note; the text and "" for others."""
    head = lines_of(text[:_HEAD])
    for place, line in enumerate(head[:-2]):
        names = cells_of(line, ",")
        if names[0].lower() not in _FIRST or len(names) < 2:
            continue
        words = cells_of(head[place + 1], ",")
        row = cells_of(head[place + 2], ",")
        while names and len(names) > len(row) and not names[-1]:
            names.pop()
        units = [_UNITS.get(word.lower().strip("()[] "), "") for word in words[: len(names)]]
        are_units = len(units) == len(names) <= len(row) and units[0] == "s" and all(units)
        if not are_units or not all(is_number(cell, ".") for cell in row[: len(names)]):
            continue
        channels = [f"CH{name}" if name.isdecimal() else name for name in names[1:]]
        for above in head[:place]:
            key, *labels = cells_of(above, ",")
            if key.lower() in ("label", "labels") and any(labels):
                channels = [
                    label or channel for label, channel in zip(labels, channels, strict=False)
                ] + channels[len(labels) :]
        labelled = [f"{name} [{unit}]" for name, unit in zip(channels, units[1:], strict=True)]
        lines = lines_of(text)
        kept = [each for each in lines[:place] if not _SETTINGS.match(each.lstrip('"'))]
        note = f"laid out as a scope's file: {len(channels)} channels over seconds"
        below = lines[place + 2 :]
        return "\n".join([*kept, line_of(["Time [s]", *labelled], ","), *below]), note
    return text, ""

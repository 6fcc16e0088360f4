"""Lines above the rows may say something of each channel: a key over its time, and what is said over its values.

TwinCAT's scope writes a name, a unit and a sample time so. Oscilloscopes write the labels of their channels into a line
of their own, above names such as CH1.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from erclutch.logs.readers.cells import Marks

_DIGIT = re.compile(r"\d")
_NAMES = ("name", "signal", "symbolname", "variable", "channel", "kanal")
_UNITS = ("unit", "units", "einheit")
_LABELS = frozenset({"label", "labels", "channel label", "channel labels", "channel name", "channel names"})


def keyed_channels(above: Sequence[str], marks: Marks, width: int) -> tuple[dict[str, list[str]], int]:
    """What the lines right above the rows say of each channel, by their keys, and how many such lines there are.

    Args:
        above: lines above the first row, without empty lines.
        marks: delimiter and decimal mark.
        width: cells of a row: a time and a value for each channel.

    Returns: for each key, in small letters, a cell for each channel; nothing where the lines are others.
    """
    said: dict[str, list[str]] = {}
    count = 0
    if width < 4 or width % 2:
        return {}, 0
    for line in reversed(above):
        cells = marks.cells(line)
        cells += [""] * (width - len(cells))
        keys = {*cells[::2]}
        if len(cells) != width or len(keys) != 1 or "" in keys or marks.is_number(cells[0]):
            break
        said[cells[0].lower()] = cells[1::2]
        count += 1
    return (said, count) if any(all(said.get(key, [""])) for key in _NAMES) else ({}, 0)


def labels_and_units(said: dict[str, list[str]]) -> tuple[list[str], list[str | None]]:
    """Labels and units of pairs of columns, a time and a value, by what `keyed_channels` found."""
    names = next(said[key] for key in _NAMES if all(said.get(key, [""])))
    own = next((said[key] for key in _UNITS if key in said), [""] * len(names))
    labels: list[str] = []
    units: list[str | None] = []
    for name, unit in zip(names, own, strict=True):
        labels += ["time", name]
        units += [None, unit.strip("[]() ") or None]
    return labels, units


def with_channel_labels(labels: Sequence[str], above: Sequence[str], marks: Marks) -> list[str]:
    """Labels with what a line above them calls the channels: ``CH1 Torque`` for CH1.

    Args:
        labels: of the columns.
        above: lines above those of the labels.
        marks: delimiter and decimal mark.
    """
    for line in above:
        first, *said = marks.cells(line)
        if first.lower() in _LABELS and len(said) == len(labels) - 1 and any(said):
            pairs = zip(labels[1:], said, strict=True)
            return [labels[0], *(f"{label} {own}".strip() for label, own in pairs)]
    return [*labels]


def with_groups(labels: Sequence[str], over: Sequence[str]) -> list[str]:
    """Labels with the group that stands over them, for names that several groups have: ``Motor Current``.

    A group stands over its first column. A column without a name is called what stands over it.

    Args:
        labels: of the columns.
        over: cells of the line above them.
    """
    filled = [cell for cell in over if cell]
    if len(over) != len(labels) or len(filled) < 2 or any(map(_DIGIT.search, filled)):  # 50 mT heads a table
        return [*labels]
    groups: list[str] = []
    group = ""
    for label, cell in zip(labels, over, strict=True):
        group = cell or group
        groups.append(group if label else "")
    grouped = [(label, each) for label, each in zip(labels, groups, strict=True) if label]
    if len({*grouped}) < len(grouped):  # groups that do not tell them apart
        return [*labels]
    named: list[str] = []
    for label, each, cell in zip(labels, groups, over, strict=True):
        is_repeated = bool(label) and list(labels).count(label) > 1
        named.append(f"{each} {label}".strip() if is_repeated else label or cell)
    return named

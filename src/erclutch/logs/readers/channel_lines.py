"""Lines above the rows may say something of each channel: a key over its time, and what is said over its values.

TwinCAT's scope writes a name, a unit and a sample time so. Oscilloscopes write the labels of their channels into a line
of their own, above names such as CH1.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

from erclutch.logs.readers.cells import Marks

_DIGIT = re.compile(r"\d")
_NAMES = ("name", "signal", "symbolname", "variable", "channel", "kanal")
_UNITS = ("unit", "units", "einheit")
#: What is said of each channel below the names.
_PROPERTIES = frozenset(
    (
        "unit",
        "units",
        "einheit",
        "interp",
        "interpolation",
        "type",
        "datatype",
        "data type",
        "description",
        "path",
        "block path",
        "blockpath",
        "source",
        "port",
        "portindex",
        "port index",
        "signal name",
        "color",
        "sample time",
    )
)
_CHANNEL_UNITS = frozenset(
    {"vertical units", "vertical unit", "y units", "y unit", "channel units", "vert units"}
)
#: Units that are no names.
_UNITS_ALONE = frozenset(("s sec ms us µs min Nm kN rpm mm mA mV kV 1/min U/min").split())
_LABELS = frozenset(
    {"label", "labels", "channel label", "channel labels", "channel name", "channel names"}
)


def keyed_channels(
    above: Sequence[str], marks: Marks, width: int
) -> tuple[dict[str, list[str]], int]:
    """What the lines right above the rows say of each channel, by their keys, and how many such lines there are.

    Args:
        above: lines above the first row, without empty lines.
        marks: delimiter and decimal mark.
        width: cells of a row: a time and a value for each channel.

    Returns: for each key, in small letters, a cell for each channel; nothing where the lines are others.
    """
    if width < 4 or width % 2:
        return {}, 0
    cells_of_key: dict[str, list[str]] = {}
    count = 0
    for line in reversed(above):
        cells = marks.cells(line)
        cells += [""] * (width - len(cells))
        key, *others = cells[::2]
        is_key = bool(key) and not marks.is_number(key)
        is_over_each_time = all(other == key for other in others)
        if len(cells) != width or not is_key or not is_over_each_time:
            break
        cells_of_key[key.lower()] = cells[1::2]
        count += 1
    return (cells_of_key, count) if _names_in(cells_of_key) else ({}, 0)


def labels_and_units(cells_of_key: dict[str, list[str]]) -> tuple[list[str], list[str | None]]:
    """Labels and units of pairs of columns, a time and a value, by what `keyed_channels` found."""
    names = _names_in(cells_of_key)
    own_units = [""] * len(names)
    for key in _UNITS:
        if key in cells_of_key:
            own_units = cells_of_key[key]
            break
    labels: list[str] = []
    units: list[str | None] = []
    for name, unit in zip(names, own_units, strict=True):
        labels += ["time", name]
        units += [None, unit.strip("[]() ") or None]
    return labels, units


def _names_in(cells_of_key: dict[str, list[str]]) -> list[str]:
    """The names of all channels among the cells of the lines; none where a channel has no name."""
    for key in _NAMES:
        names = cells_of_key.get(key, [])
        if names and all(names):
            return names
    return []


def with_channel_labels(labels: Sequence[str], above: Sequence[str], marks: Marks) -> list[str]:
    """Labels with what a line above them calls the channels: ``CH1 Torque`` for CH1.

    Args:
        labels: of the columns.
        above: lines above those of the labels.
        marks: delimiter and decimal mark.
    """
    first_label, *channels = labels
    for line in above:
        first, *own_labels = marks.cells(line)
        if first.lower() in _LABELS and len(own_labels) == len(channels) and any(own_labels):
            pairs = zip(channels, own_labels, strict=True)
            named = [f"{channel} {own_label}".strip() for channel, own_label in pairs]
            return [first_label, *named]
    return [*labels]


def channel_units(
    labels: Sequence[str], above: Sequence[str], marks: Marks
) -> list[str | None] | None:
    """Units of the channels in a line such as ``Vertical Units,V,V``, behind none for the time; None without it.

    Args:
        labels: of the columns, the time first.
        above: lines above those of the labels.
        marks: delimiter and decimal mark.
    """
    for line in above:
        first, *own_units = marks.cells(line)
        if first.lower() not in _CHANNEL_UNITS:
            continue
        while len(own_units) > len(labels) - 1 and not own_units[-1]:
            own_units.pop()
        if len(own_units) == len(labels) - 1 and any(own_units):
            return [None, *(unit or None for unit in own_units)]
    return None


def said_below_names(
    above: Sequence[str], marks: Marks, width: int
) -> tuple[list[str | None], int]:
    """What lines between the names and the rows say of each column: ``Unit:``, ``Interp:``; the units, and how many.

    The word stands in the first cell, or before what is said in each cell, as Simulink's Data Inspector writes it.

    Args:
        above: lines above the first row, without empty lines.
        marks: delimiter and decimal mark.
        width: cells of a row.
    """
    units: list[str | None] = []
    count = 0
    for line in reversed(above):
        cells = marks.cells(line)
        cells += [""] * (width - len(cells))
        first, *others = cells
        word, colon, _ = first.partition(":")
        if colon and first.endswith(":") and word.strip().lower() in _PROPERTIES:
            told = others
        else:
            words = {cell.partition(":")[0].strip().lower() for cell in cells if cell}
            have_a_colon = all(":" in cell for cell in cells if cell)
            if len(words) != 1 or not words <= _PROPERTIES or not have_a_colon:
                break
            (word,) = words
            told = [cell.partition(":")[2].strip() for cell in others]
        if len(cells) != width:
            break
        count += 1
        if word.strip().lower() in _UNITS:
            units = [None, *(unit.strip("[]() ") or None for unit in told)]
    return units, count


def with_groups(labels: Sequence[str], over: Sequence[str]) -> list[str]:
    """Labels with the group that stands over them, for names that several groups have: ``Motor Current``.

    A group stands over its first column. A column without a name is called what stands over it; so is a column that has
    its unit alone below.

    Args:
        labels: of the columns.
        over: cells of the line above them.
    """
    if not any(over[len(labels) :]):  # empty cells may end a line
        over = [*over, *[""] * len(labels)][: len(labels)]
    filled = [cell for cell in over if cell]
    heads_tables = any(_DIGIT.search(cell) for cell in filled)  # 50 mT
    if len(over) != len(labels) or len(filled) < 2 or heads_tables:
        return [*labels]
    group = ""
    of_groups: list[str] = []  # the label behind its group
    for label, cell in zip(labels, over, strict=True):
        group = cell or group
        of_groups.append(f"{group} {label}".strip() if label else "")
    in_groups = [*zip(labels, of_groups, strict=True)]
    with_a_name = [pair for pair in in_groups if pair[0]]
    if len({*with_a_name}) < len(with_a_name):  # groups that do not tell them apart
        return [*labels]

    counts = Counter(labels)
    named: list[str] = []
    for (label, of_group), cell in zip(in_groups, over, strict=True):
        if not label:
            named.append(cell)
        elif cell and label in _UNITS_ALONE:
            # A name over its unit, beside groups over their names.
            named.append(f"{cell} [{label}]")
        elif counts[label] > 1:
            named.append(of_group)
        else:
            named.append(label)
    return named

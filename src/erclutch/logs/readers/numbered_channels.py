"""Lines above the rows name columns by their numbers, as heads of loggers in the manner of INI files do.

``1=Time,s`` in a section ``[Channels]``, ``Ch1Name=Time`` beside ``Ch1Unit=s``, or a section ``[Channel 1]`` for each.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from erclutch.logs.columns.labels import split_label
from erclutch.signals import units

_SECTION = re.compile(r"\[\s*([^\W\d]*)[\s._#-]*(\d{1,3})?\s*\]")
_KEY_AND_VALUE = re.compile(r'"?([^=:"]{1,40}?)"?\s*[=:]\s*(\S.*)')
_NUMBERED_KEY = re.compile(r"([^\W\d_]*)[\s._#-]*\[?(\d{1,3})\]?[\s._#-]*([^\W\d_]*)")
_UNITS = frozenset("unit units einheit unite unité unidad dim dimension eu".split())
_NAMES = frozenset("name names label title signal signalname description desc titel".split())
#: What a column is called in a key, which says nothing of what its value is.
_COLUMNS = frozenset(
    "ch chan channel channels kanal kanaele col column columns spalte voie canal canale colonne columna field var "
    "variable sensor input signal".split()
)


def numbered_channels(
    above: Sequence[str], width: int
) -> tuple[list[str], list[str | None]] | None:
    """Names and units of columns that lines above the rows give by their numbers, from 0 or from 1; None elsewhere.

    Args:
        above: lines above the first row, without empty lines.
        width: cells of a row.
    """
    names: dict[int, str] = {}
    units_of: dict[int, str] = {}
    of_section: int | None = None  # the column that a section is about
    for line in above:
        text = line.strip().rstrip(",;\t")
        section = _SECTION.fullmatch(text)
        if section:
            word, number = section.groups()
            of_section = int(number) if number and word.lower() in _COLUMNS else None
            continue
        match = _KEY_AND_VALUE.fullmatch(text)
        if match is None:
            continue
        key, value = match[1].strip(), match[2].strip(' "')
        numbered = _NUMBERED_KEY.fullmatch(key)
        words = {key.lower()}
        place = of_section
        if numbered is not None:
            before, number, behind = numbered.groups()
            place = int(number)
            words = {before.lower(), behind.lower()} - {""}
        if place is None:
            continue
        if words & _UNITS:
            units_of.setdefault(place, value.strip("[]()"))
        elif words & _NAMES or (numbered is not None and words <= _COLUMNS):
            names.setdefault(place, value)

    first = min(names, default=0)
    numbers = [*range(first, first + width)]
    if width < 2 or first not in (0, 1) or sorted(names) != numbers:
        return None
    named = [_name_and_unit(names[number]) for number in numbers]
    labels = [name for name, _ in named]
    if len({*labels}) < width or not all(re.search(r"[^\W\d]", name) for name in labels):
        return None  # settings of the channels, such as their gains
    own = [units_of.get(n) or unit for n, (_, unit) in zip(numbers, named, strict=True)]
    return labels, own


def _name_and_unit(text: str) -> tuple[str, str | None]:
    """A name and a unit of ``Force,N``; the text and None, where its unit stands in brackets or nowhere."""
    for mark in (";", ",", "\t", "|"):
        name, parted, unit = (part.strip(' "') for part in text.partition(mark))
        unit = unit.strip("[]()")
        if parted and unit and split_label(name)[1] is None and units.is_unit(unit):
            return name, unit
    return text, None

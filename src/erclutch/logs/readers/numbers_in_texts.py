"""Numbers that a DataFrame, Parquet or JSON holds as texts are read as those of a text file: ``0,5``, ``0.5 A``.

Such a column was left out with a note, and a log without its field went on as one without any.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogSource
from erclutch.logs.readers.switches import switched
from erclutch.logs.readers.text_table import read_text
from erclutch.signals.array import Array

if TYPE_CHECKING:
    import pandas as pd

_LIKE_A_NUMBER = re.compile(r"\s*[-+−]?[.,]?\d")
_LOOKED_AT = 50  # cells of a column that tell whether it may hold numbers
_PLACE = "row"  # a first column, so that a text of one column has marks between its cells


@dataclass
class NumbersInTexts:
    """What columns of texts hold.

    Attributes:
        columns: numbers of those that hold some, by the name of the column; NaN where a cell is empty.
        units: of these, where the cells have one: ``0.5 A``.
        notes: what was assumed.
        unreadable: what stands against the others.
    """

    columns: dict[str, Array] = field(default_factory=dict[str, "Array"])
    units: dict[str, str] = field(default_factory=dict[str, str])
    notes: list[str] = field(default_factory=list[str])
    unreadable: dict[str, str] = field(default_factory=dict[str, str])


def numbers_in_texts(
    texts: Mapping[str, pd.Series[Any]], decimal: str | None = None
) -> NumbersInTexts:
    """Read columns of texts.

    Args:
        texts: the cells of each column, by its name.
        decimal: the decimal mark, where the user named it.
    """
    found = NumbersInTexts()
    like_numbers: dict[str, list[str]] = {}
    for name, cells in texts.items():
        ones_and_zeros = switched(name, cells)
        if ones_and_zeros is not None:
            found.columns[name], note = ones_and_zeros
            found.notes.append(note)
            continue
        written = [
            "" if missing else str(cell) for cell, missing in zip(cells, cells.isna(), strict=True)
        ]
        filled = [cell for cell in written if cell.strip()]
        if any(map(_LIKE_A_NUMBER.match, filled[:_LOOKED_AT])):
            like_numbers[name] = written
        else:
            first = filled[0].strip()[:30] if filled else ""
            found.unreadable[name] = (
                f"column {name} holds text ({first!r}) in {len(filled)} of {len(written)} rows"
            )

    # One decimal mark holds for all columns that one program wrote; where they tell no mark, each is asked alone.
    try:
        _read(like_numbers, decimal, found)
    except LogError:
        for name, cells in like_numbers.items():
            try:
                _read({name: cells}, decimal, found)
            except LogError as error:
                found.unreadable[name] = f"column {name}: {error.problem}"
    return found


def _read(
    like_numbers: Mapping[str, list[str]], decimal: str | None, found: NumbersInTexts
) -> None:
    """Read cells as a text with tabs between them.

    Raises:
        LogError: two decimal marks, or none that tells.
    """
    if not like_numbers:
        return
    places = [f"column {number}" for number in range(1, 1 + len(like_numbers))]
    rows = zip(*like_numbers.values(), strict=True)
    lines = ["\t".join((_PLACE, *places))]
    for number, cells in enumerate(rows, start=1):
        plain = (re.sub(r"\s", " ", cell) for cell in cells)
        lines.append("\t".join((str(number), *plain)))
    source = LogSource(Path("texts"), "\n".join([*lines, ""]).encode(), "", decimal=decimal)
    table = read_text(source)
    for place, name in zip(places, like_numbers, strict=True):
        if place in table.columns:
            found.columns[name] = table.columns[place]
            unit = table.units.get(place)
            if unit:
                found.units[name] = unit
            found.notes.append(
                f"column {name} holds numbers as texts: they are read as those of a text file"
            )
        else:
            problem = table.unreadable.get(place, f"{place} holds no numbers")
            found.unreadable[name] = problem.replace(place, name)

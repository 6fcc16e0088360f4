"""Some instruments write the unit of a quantity once, above all tables: ``Shear Stress Unit: Dyne/cm^2``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from erclutch.logs.table import Table

_KEY = re.compile(
    r"(?P<quantity>.*\w)[\s_]*\b(?:units?|einheit|unit[eé]s?|unidad(?:es)?)", re.IGNORECASE
)
_LABEL = re.compile(r"([^\[\](),;|\t]*[^\[\](),;|\t\s])\s*[\[(]([^\[\]()]+)[\])][,;|\t ]*")
_WORD = re.compile(r"[^\W_]+")


def units_of_a_comment(lines: Iterable[str], names: Sequence[str]) -> dict[str, str]:
    """Units that a line such as ``# t [s], x [mm], F [N]`` states of all columns, as pairs for `with_stated_units`.

    A line that names other columns than the table has, or not all of them, speaks for something else.
    """
    wanted = {name.lower() for name in names}
    for line in lines:
        _, _, labels = line.rpartition(":")  # Columns: t [s], ...
        stated = {name.strip().lower(): unit.strip() for name, unit in _LABEL.findall(labels)}
        if stated.keys() == wanted and not _LABEL.sub("", labels).strip(" ,;|\t"):
            return {f"{name} unit": stated[name.lower()] for name in names}
    return {}


def with_stated_units(table: Table, pairs: Mapping[str, str]) -> Table:
    """The table with the units that ``Key: value`` lines above it state, for columns that have none of their own.

    A line speaks for the columns whose names have all words of its quantity: ``Rate Unit`` for ``Shear Rate``.
    """
    stated: dict[str, str] = {}
    for key, unit in pairs.items():
        match = _KEY.fullmatch(key)
        if match is None:
            continue
        quantity = _words(match["quantity"])
        for name in table.columns:
            words = _words(name)
            # One word stands in full, the others may be cut: ``S. Rate`` is a shear rate.
            has_all_words = not quantity.isdisjoint(words) and all(
                any(word.startswith(short) for short in words) for word in quantity
            )
            if has_all_words and not table.units.get(name):
                stated[name] = unit
    if not stated:
        return table
    listed_units = ", ".join(f"{name} [{unit}]" for name, unit in stated.items())
    return replace(
        table,
        units={**table.units, **stated},
        notes=(*table.notes, f"units that lines above the table state: {listed_units}"),
    )


def _words(name: str) -> set[str]:
    return {word.lower() for word in _WORD.findall(name)}

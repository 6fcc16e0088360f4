"""Some instruments write the unit of a quantity once, above all tables: ``Shear Stress Unit: Dyne/cm^2``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, cast

from erclutch.logs.table import Table
from erclutch.signals.units import is_unit

_UNITS = r"(?:units?|einheit(?:en)?|unit[eé]s?|unidad(?:es)?)"
#: ``Shear Stress Unit``, ``force_unit``; ``units.force``, ``unit_force``.
_KEY = re.compile(
    rf"(?P<before>.*[^\W_])[\W_]+{_UNITS}|{_UNITS}[._](?P<behind>\w.*)", re.IGNORECASE
)
#: ``t: s, v: mm/s`` behind the word units.
_PAIR = re.compile(r"(?<![^\s:=,;])([^\s:=,;]++)\s*+[:=]\s*+([^\s,;]+)")
#: ``Force in kN``, ``all velocities in mm/s``.
_IN_UNIT = re.compile(r"(?<![^\W\d_])([^\W\d_]++)\s++in\s++([^\s,;]+)")
_LABEL = re.compile(r"([^\[\](),;|\t]*[^\[\](),;|\t\s])\s*[\[(]([^\[\]()]+)[\])][,;|\t ]*")
#: ``name: v`` in a line or between braces, as YAML writes it.
_MEMBER = re.compile(r"""(?:^[-\s]*|[{,]\s*)(name|units?):\s+["']?([^,{}"']+)""")
_LONGEST = 1000  # letters of a line
_WORD = re.compile(r"[^\W_]+")


def column_of_unit(key: str) -> str:
    """The name of the column whose unit a key such as ``force_unit`` or ``units.force`` gives; "" for other keys."""
    match = _KEY.fullmatch(key)
    return "" if match is None else (match["behind"] or match["before"]).rpartition(".")[2]


def with_units(labels: Sequence[str], units: Any) -> list[str]:
    """Names of columns with the units that a list of as many texts gives; the names alone for anything else."""
    if not isinstance(units, list) or len(cast("list[Any]", units)) != len(labels):
        return [*labels]
    texts = cast("list[Any]", units)
    if not all(isinstance(text, str) for text in texts):
        return [*labels]
    return [
        f"{label} [{text}]" if text else label for label, text in zip(labels, texts, strict=True)
    ]


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


def units_of_a_list(lines: Iterable[str]) -> dict[str, str]:
    """Units of a list of columns as YAML writes it: ``- {name: v, unit: mm/s}``; as pairs for `with_stated_units`.

    The name and the unit may stand in lines of their own.
    """
    pairs: dict[str, str] = {}
    name = ""
    for line in lines:
        said = dict(_MEMBER.findall(line[:_LONGEST]))
        name = said.get("name", name)
        unit = said.get("unit") or said.get("units")
        if name and unit:
            pairs[f"{name} unit"] = unit.strip()
            name = ""
    return pairs


def with_stated_units(table: Table, pairs: Mapping[str, str]) -> Table:
    """The table with the units that ``Key: value`` lines above it state, for columns that have none of their own.

    A line speaks for the columns whose names have all words of its quantity: ``Rate Unit`` for ``Shear Rate``.
    """
    stated: dict[str, str] = {}
    for quantity, unit in _quantities(pairs):
        spoken = _words(quantity)
        for name in table.columns:
            words = _words(name)
            # One word stands in full, the others may be cut: ``S. Rate`` is a shear rate.
            has_all_words = not spoken.isdisjoint(words) and all(
                any(word.startswith(short) for short in words) for word in spoken
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


def _quantities(pairs: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Quantities with the units that pairs above a table give them."""
    for key, text in pairs.items():
        quantity = column_of_unit(key)
        if quantity:
            yield quantity, text
        elif re.fullmatch(_UNITS, key, re.IGNORECASE):
            yield from dict.fromkeys(_PAIR.findall(text))
        else:
            for plural, unit in dict.fromkeys(_IN_UNIT.findall(f"{key}, {text}")):
                if is_unit(unit):
                    singular = re.sub(r"ies$", "y", plural, flags=re.IGNORECASE).removesuffix("s")
                    yield singular, unit


def _words(name: str) -> set[str]:
    return {word.lower() for word in _WORD.findall(name)}

"""Tests of a file that nobody measured: a regression below the points that it was made of, told by title or by gaps."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.names import words_of
from erclutch.logs.table import Table

_REGRESSION = re.compile(
    r"(?:(?:non-?)?linear |power[- ]law |curve |data )?"
    r"(?:regressions?|r[eé]gression|regresi[oó]n|regress[aã]o|regressionskurve|ausgleichskurve|"
    r"fits?|fitted(?: curve| data| values)?|interpolation|interpolated(?: data| values)?|回归|拟合|回帰)"
    r"(?: curve| line| data| results?)?\s*[:.]?",
    re.IGNORECASE,
)
#: Words for what an instrument writes of each point beside its rate and its stress.
_OF_AN_INSTRUMENT = frozenset(
    "torque temperature status gap deflection drehmoment temperatur couple".split()
)
_FEWEST_EMPTY = 2  # columns of an instrument: one may be left out by chance


def computed_tests(tests: Mapping[str, Table]) -> dict[str, str]:
    """Which tests hold what was computed, each with why; none where nothing else would be left.

    A title says so (``Regression:``), or the columns of an instrument, which another table of the sheet fills, are
    empty in this one.

    Args:
        tests: their tables, by the names that the file gives them: ``Sheet1, table 2``.
    """
    computed: dict[str, str] = {}
    for name, table in tests.items():
        sheet, _, title = name.rpartition(", ")
        if _REGRESSION.fullmatch(title.strip()):
            computed[name] = "a regression by its title"
            continue
        filled_beside: set[str] = set()
        for other, beside in tests.items():
            if other != name and other.rpartition(", ")[0] == sheet:
                filled_beside |= _of_an_instrument([*beside.columns, *beside.unreadable])
        empty = _of_an_instrument(table.hollow) & filled_beside
        if len(empty) >= _FEWEST_EMPTY and not _of_an_instrument(table.columns):
            computed[name] = f"no instrument wrote it: {' and '.join(sorted(empty))} are empty"
    return computed if len(computed) < len(tests) else {}


def require_measured(name: str, computed: Mapping[str, str]) -> None:
    """Refuse a test that nobody measured.

    Raises:
        MappingError: it is one of those that were computed.
    """
    if name in computed:
        problem = f"{computed[name]}; --sheet {shell_word(name)} takes it"
        raise MappingError(problem, remedy="Give a test that was measured")


def _of_an_instrument(columns: Iterable[str]) -> set[str]:
    """Those of some columns that an instrument fills, in small letters."""
    names: set[str] = set()
    for column in columns:
        if not _OF_AN_INSTRUMENT.isdisjoint(words_of(column)):
            names.add(" ".join(words_of(column)))
    return names

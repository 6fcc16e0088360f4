"""A row of units stands below or above the names of columns, and is told from names by its words."""

from __future__ import annotations

import re
from collections.abc import Sequence

from erclutch.logs.columns.unit_behind_word import bears_out
from erclutch.signals import units

#: Units that are no names; t, V, F may be names.
_CLEAR_UNITS = frozenset(
    (
        "s sec Sec SEC ms us µs min Nm kN lbf rpm mm cm kV mV mA kPa MPa bar deg rad "
        "seconds Seconds newton Newton newtons Newtons "
        "millimeter Millimeter millimeters Millimeters millimetres Millimetres"
    ).split()
)
#: Clear units as old loggers write them; S and MIN may be names, and MA is no mA for sure.
_CAPITALS = {
    unit.upper(): unit
    for unit in ("Nm", "kN", "lbf", "rpm", "mm", "cm", "kV", "kPa", "MPa", "deg", "rad")
}
# Units, but no plain factor to the SI; that of a consistency has an exponent n. Russian ones behind.
_NO_FACTOR = re.compile(
    r"(?:°|deg) ?[CF]|[℃℉]|dB\w*|bits?|counts?|psi[ag]?|[\w.*·/^-]*s(?:ec)?\^n'?[\w.*·/^-]*"
    r"|град\w*(?: ?[CС])?|[см]П|м?Па[·*]с|с\^-1|дин/см[2²]|об/мин|м?[НH]/м[2²]",
    re.IGNORECASE,
)


def bare_units(cells: Sequence[str]) -> list[str]:
    """Cells without the brackets around units, or the slashes: ``/ms/``."""
    bare = [cell.strip("[](){}<> ") for cell in cells]
    return [cell.strip("/ ") if re.fullmatch(r"/.+/", cell) else cell for cell in bare]


def units_of_row(cells: Sequence[str]) -> list[str | None]:
    """The units of a row, in the letters of today; None of an empty cell."""
    units_of = [_CAPITALS.get(unit, unit) for unit in bare_units(cells)]
    return [unit or None for unit in units_of]


def are_units(cells: Sequence[str]) -> bool:
    """Whether the cells of a line are units: a clear one among them, and at most one in four that is none we know."""
    filled = [_CAPITALS.get(cell, cell) for cell in cells if cell]
    # Names alone are common, and whether a name is a unit takes long to say: no clear unit, no such question.
    clear = [cell for cell in filled if cell in _CLEAR_UNITS or re.search(r"[/^°%*.⁻¹²³·]", cell)]
    if not any(map(is_written_unit, clear)):
        return False
    unknown = sum(not is_written_unit(cell) for cell in filled)
    return unknown <= len(filled) / 4


def repeat_a_unit(cells: Sequence[str], names: Sequence[str]) -> bool:
    """Whether a line below distinct names has a clear unit, and all other words in it several times: so do units."""
    words = [cell for cell in bare_units(cells) if cell]
    named = [name for name in names if name]
    if len({*named}) < len(named) or not any(word in _CLEAR_UNITS for word in words):
        return False
    return all(is_written_unit(word) or words.count(word) > 1 for word in words)


def are_borne_out(cells: Sequence[str], names: Sequence[str]) -> bool:
    """Whether all words of a line are units, and two or more of them such as the names above speak of."""
    units_of = bare_units(cells)
    borne_out = [bears_out(name, unit) for name, unit in zip(names, units_of, strict=True) if unit]
    return sum(borne_out) > 1 and all(map(is_written_unit, filter(None, units_of)))


def is_written_unit(cell: str) -> bool:
    """Whether a cell is a unit, of those without a factor to the SI too."""
    return bool(_NO_FACTOR.fullmatch(cell)) or units.is_unit(cell)

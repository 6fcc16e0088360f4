"""A power of ten beside a name (``torque x 10^3 [Nm]``) may multiply what was measured, or what is written."""

from __future__ import annotations

import re

from erclutch.errors import shell_word
from erclutch.signals.unit_spellings import RAISED

_BRACKETS = re.compile(r"[\[(][^\[\]()]*[\])]")  # what stands within is of the unit
_BESIDE = re.compile(
    r"(?:[×x*·]\s*|(?<!\w))10\s*(?:(?:\^|\*\*)\s*(?P<power>[+-]?\d)(?!\d)|(?P<raised>[⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹])(?!\w))"
    r"|(?<!\w)[×x*·]\s*(?P<behind>1000|100)(?!\w)|(?<!\w)(?P<front>1000|100)\s*[×*·]\s*\w"
)


def power_beside(name: str) -> float | None:
    """The power of ten that stands beside the words of a name, outside of brackets; None where there is none."""
    match = _BESIDE.search(_BRACKETS.sub("", name))
    if match is None:
        return None
    plain = match["behind"] or match["front"]
    if plain:
        return float(plain)
    return 10.0 ** int((match["power"] or match["raised"]).translate(RAISED))


def both_ways(option: str, name: str, unit: str, factor: float) -> tuple[str, str]:
    """The option that reads numbers which a factor multiplied, and the option that multiplies them by it."""

    def in_units_of(size: float) -> str:
        plain = f"{size:.9f}".rstrip("0").rstrip(".")  # an e would be a charge
        return f"{option} {shell_word(f'{name} [{plain} {unit}]')}"

    return in_units_of(1.0 / factor), in_units_of(factor)

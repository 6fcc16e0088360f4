"""Options that take a quantity take it in any unit of its kind: ``--period 1ms``, ``--seconds 2min``, ``--share 70%``.

A plain number has the unit that the help names. All of them are read by `erclutch.signals.units.in_unit`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cyclopts import Parameter, Token

from erclutch.errors import SettingError

#: Memory is no quantity of physics, so no table of units has it: GB in one of each.
_BYTES = {"GB": 1.0, "MB": 1e-3, "TB": 1e3}


def quantity(unit: str, example: str = "") -> Parameter:
    """What makes a number an option with a unit; numbers below zero need no ``=`` before them.

    Args:
        unit: that the command computes in: s, Hz, N*m, rad, GB, "" for a share, ...
        example: for the message; 2 of the unit by default.
    """

    def converted(_kind: object, tokens: Sequence[Token]) -> Any:
        numbers = tuple(
            quantity_in(token.keyword or "", token.value, unit, example) for token in tokens
        )
        return numbers[0] if len(numbers) == 1 else numbers

    return Parameter(converter=converted, allow_leading_hyphen=True)


def quantity_in(
    option: str,
    text: str,
    unit: str,
    example: str,
) -> float:
    """What a text says in a unit; the option and the example are for the message.

    Raises:
        SettingError: the text is no such quantity.
    """
    from erclutch.errors import UnitError
    from erclutch.signals import units

    try:
        if unit != "GB":
            return units.in_unit(text, unit)
        number, written_unit = units.quantity(text)
        if written_unit is None:
            return number
        if written_unit in _BYTES:
            return number * _BYTES[written_unit]
    except UnitError:
        pass
    written = example or f"2{unit or ''}"
    kind = f"quantity in {unit}" if unit else "number or share in %"
    raise SettingError(
        f"{option} {text!r} is no {kind}", remedy=f"Write it like {option} {written}"
    )


SECONDS = quantity("s")
HERTZ = quantity("Hz")
TORQUE = quantity("N*m", "0.2")
ANGLE = quantity("rad", "360deg")
SHARE = quantity("", "70%")
MEMORY = quantity("GB")

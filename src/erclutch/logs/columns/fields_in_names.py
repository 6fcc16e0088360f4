"""A name may hold a field: of an effort (``F_0.5A``), of a recording (``1 A``), of a column of a bench sheet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from erclutch.logs.columns.name_pattern import FIELD_IN_A_NAME, FIELD_UNITS, number_of


class StatedField(NamedTuple):
    """A number that may be the field.

    Attributes:
        name: what it is called.
        number: as written.
        unit: as written; None where nobody says it.
    """

    name: str
    number: float
    unit: str | None

    def __str__(self) -> str:
        number = f"{self.number:g} {self.unit}" if self.unit else f"{self.number:g}"
        return f"{self.name} = {number}"


def stated_in(name: str) -> StatedField | None:
    """The field that a name such as ``F_0.5A`` or ``1 A`` holds; None for no or several numbers with such a unit."""
    numbers = FIELD_IN_A_NAME.findall(name)
    if len(numbers) != 1:
        return None
    (number, _, letters), *_ = numbers
    return StatedField(name, number_of(number), FIELD_UNITS[letters])


def without_field(name: str) -> str:
    """A name without the number that may be the field: of logs that differ in the field alone all are the same."""
    return FIELD_IN_A_NAME.sub("", name)


def differ_by_field(names: Sequence[str]) -> bool:
    """Whether names are the same but for the field that each of them holds."""
    fields = {each.number for each in map(stated_in, names) if each is not None}
    return 1 < len(fields) == len(names) and len({*map(without_field, names)}) == 1

"""A slip and a position of one log are held against each other: one is the rate of the other, in their units."""

from __future__ import annotations

from erclutch.errors import shell_word
from erclutch.logs import columns
from erclutch.logs.mapping import ColumnChoice
from erclutch.logs.plan import ClockPlan, SignalPlan
from erclutch.logs.shapes import is_rate_of, is_usual_ratio, over_rate
from erclutch.logs.table import Table

_SAME = 0.5  # of one: a ratio that no mixed units make
_RATES = (("m/s", "m"), ("rad/s", "rad"))


def another_motion(table: Table, guess: ColumnChoice, slip: str) -> str:
    """Why a position that its unit alone tells is none of the device: a gap, a travel of something else; "" for none.

    Args:
        table: the log.
        guess: the column that may be the position, with what speaks for it.
        slip: the column of the slip, whose rate it is not.
    """
    name = str(guess.column)
    if " name" in guess.source or is_rate_of(table.columns[slip], table.columns[name], columns.stamps_of(table)):
        return ""
    option = f"--position {shell_word(table.label(name))}"
    return f"column {name} has the unit of a position, and column {slip} is not its rate: left out ({option} takes it)"


def odd_rate(table: Table, slip: SignalPlan | None, position: SignalPlan | None, clock: ClockPlan | None) -> str:
    """What is odd where a slip goes with the rate of the position and is another number; "" for nothing."""
    stamps = columns.stamps_of(table)
    if slip is None or position is None or clock is None or stamps is None or not slip.column or not position.column:
        return ""
    if (slip.si, position.si) not in _RATES:
        return ""
    speed, place = table.columns[slip.column] * slip.factor, table.columns[position.column] * position.factor
    ratio = over_rate(speed, place, stamps * clock.factor if clock.kind == "column" else stamps)
    if ratio is None or not is_usual_ratio(ratio) or abs(abs(ratio) - 1.0) < _SAME:
        return ""
    return (
        f"the slip, column {slip.column}, is {abs(ratio):.3g} times the rate of the position, column "
        f"{position.column}: the unit of one of them, or of the time, is another"
    )

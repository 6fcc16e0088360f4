"""The current of a motor under test is no field: by the numbers its power makes the efficiency beside it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from erclutch.logs.columns.seen_columns import NO_UNITS, SeenColumn
from erclutch.logs.columns.shapes import FEW, known_rows
from erclutch.logs.columns.two_courses import go_straight
from erclutch.logs.columns.vocabulary import VOLTAGES
from erclutch.logs.planning.draft import Draft
from erclutch.logs.planning.field_doubts import leave_out_field
from erclutch.logs.planning.guesses import OF_A_SUPPLY
from erclutch.signals.array import Array

_EFFICIENCIES = frozenset(
    {"efficiency", "wirkungsgrad", "rendement", "rendimento", "eficiencia", "efficienza"}
)
#: What drives the motor of a propeller, and what the propeller gives: no brake or clutch stands in such a stand.
_OF_DRIVERS = frozenset({"esc", "throttle"})
_OF_PROPELLERS = frozenset({"propeller", "thrust"})
_WHOLES = (1.0, 100.0)  # of an efficiency as a share and in percent
_DIGITS = 5e-3  # of a number, by which it is off as it is written with some digits
_MOST_POWERS = 6
_MOST = 0.95  # share of the rows in which it holds: some rows are logged while others are computed


class _Powers(NamedTuple):
    """An efficiency, the power that a machine gives and the power that it draws."""

    efficiency: SeenColumn
    gives: SeenColumn
    draws: SeenColumn


def leave_out_what_feeds_a_motor_under_test(draft: Draft) -> None:
    """Take a guessed current back whose power is that which a motor draws, by the efficiency beside it.

    A coil draws a power too, but no other power over it is an efficiency. Where the motor turns a propeller, what it
    gives goes into the air: no column is the field of a brake or clutch.
    """
    field = draft.guessed("field")
    if field is None or field.si not in OF_A_SUPPLY:
        return
    current = draft.seen.columns[field.column]
    if current.fits(("A",)) is False:
        return
    powers = _powers(draft)
    if powers is None:
        return
    voltage = _voltage(draft, current, powers.draws)
    if not voltage:
        # No column is the voltage: it is the one number with which the current makes the power in all rows.
        drawn, power = (np.abs(each) for each in known_rows(current.values, powers.draws.values))
        flows = drawn > 0.0
        if np.count_nonzero(flows) < FEW or np.ptp(drawn) == 0.0:
            return
        volts = float(np.median(power[flows] / drawn[flows]))
        if not _are_alike(power, volts * drawn):
            return
        draft.supply = volts
    why = f"makes {powers.draws.name}, and {powers.gives.name} over it is {powers.efficiency.name}"
    leave_out_field(draft, f"{why}: taken for the current of a motor under test, left out")
    draft.no_signals += [powers.efficiency.name, powers.gives.name, powers.draws.name]
    if voltage:
        draft.no_signals.append(voltage)
    for other in draft.seen.without(draft.taken):  # the same current in other numbers, as a score
        if other.fits(("A",)) and go_straight(other.values, current.values):
            draft.no_signals.append(other.name)
    of_drivers = [each for each in draft.seen.columns.values() if each.spoken.says(_OF_DRIVERS)]
    of_air = [each for each in draft.seen.columns.values() if each.spoken.says(_OF_PROPELLERS)]
    if of_drivers and of_air:
        draft.missing.remove("field")
        del draft.questions["field"]
        draft.take_no_field([f"{of_drivers[0].name} and {of_air[0].name} are those of a propeller"])


def _powers(draft: Draft) -> _Powers | None:
    """An efficiency of the table with the two powers whose quotient it is; None where none is."""
    columns = [*draft.seen.columns.values()]
    powers = [each for each in columns if each.written_unit and each.fits(("W",))]
    if not 2 <= len(powers) <= _MOST_POWERS:
        return None
    for column in columns:
        if not column.spoken.says(_EFFICIENCIES) or column.unit not in (None, *NO_UNITS):
            continue
        for gives in powers:
            for draws in powers:
                if gives is not draws and _is_efficiency(column.values, gives.values, draws.values):
                    return _Powers(column, gives, draws)
    return None


def _is_efficiency(share: Array, gives: Array, draws: Array) -> bool:
    e, out, into = (np.abs(each) for each in known_rows(share, gives, draws))
    drawn = into > 0.0
    e, out, into = e[drawn], out[drawn], into[drawn]
    if e.size < FEW or np.ptp(e) == 0.0:
        return False
    return any(_are_alike(e * into, whole * out) for whole in _WHOLES)


def _voltage(draft: Draft, current: SeenColumn, power: SeenColumn) -> str:
    """The column of the voltage with which a current makes a power; "" where it makes another one."""
    for other in draft.seen.without([current.name]):
        is_a_voltage = other.fits(("V",)) or (not other.unit and other.spoken.says(VOLTAGES))
        if not is_a_voltage:
            continue
        v, i, p = (np.abs(each) for each in known_rows(other.values, current.values, power.values))
        if p.size >= FEW and np.ptp(p) > 0.0 and _are_alike(p, v * i):
            return other.name
    return ""


def _are_alike(first: Array, second: Array) -> bool:
    """Whether two courses are the same numbers, each as it is written, in nearly all rows; zeros alone tell nothing."""
    larger = np.maximum(first, second)
    tells = larger > _DIGITS * float(larger.max(initial=0.0))
    if np.count_nonzero(tells) < FEW:
        return False
    off = np.abs(first[tells] - second[tells]) <= 2.0 * _DIGITS * larger[tells]
    return bool(np.mean(off) >= _MOST)

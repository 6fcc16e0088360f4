"""Signals of a log are held against each other: a slip is the rate of its position, slip times effort is a power."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.two_courses import is_usual_ratio, over_rate
from erclutch.logs.plan import ClockPlan
from erclutch.logs.planning.draft import Draft
from erclutch.signals import units
from erclutch.signals.array import Array
from erclutch.signals.recording import SignalKind

_SAME = 0.5  # of one: a ratio that no mixed units make
_SAME_CLOCK = 0.1  # of one: a filter of the speed makes no more
_QUICK, _SLOW = 1e-5, 0.05  # s: steps of most loggers
_TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}
_EDGE = 0.02  # of a turn, by which an angle goes beyond its ends
_JUMP = 0.8  # of a turn
_STEP = 0.1  # of a turn, from row to row elsewhere
_RATES = (("m/s", "m"), ("rad/s", "rad"))
_POWERS = (("rad/s", "N*m"), ("m/s", "N"))
_STEADY = 0.02  # share by which slip times effort over a power varies at most, or it is a power of something else
_LARGE = 0.1  # share of the largest power from which on its digits tell
_FEWEST = 20  # rows with such a power


def turn_screw(draft: Draft) -> None:
    """Alpha = alpha_raw 2 pi / lead, equation 4 of Huang and Ishikawa, in place of alpha_raw."""
    raw = draft.signals.get("alpha_raw")
    if raw is None:
        return
    lead = draft.told.lead
    if lead is None:
        problem = "alpha_raw is the position on a screw whose lead is not given"
        draft.ask("lead", MappingError(problem, remedy='Give the lead, such as --lead "10 mm"'))
    elif "alpha" in draft.signals:
        del draft.signals["alpha_raw"]
        draft.notes.append(f"column {raw.column} (alpha_raw) not used: alpha itself is logged")
    else:
        draft.signals["alpha_raw"] = replace(raw, lead=lead)
        draft.notes.append(f"alpha = alpha_raw * 2 pi / lead with a lead of {lead:g} m")


def hold_slip_against_position(draft: Draft) -> None:
    """Ask about a slip that is some times the rate of its position; where the user gave the slip, only say so.

    Where another unit of the time, or another column of it, makes them agree, that is proposed.
    """
    slip = draft.signals.get("slip")
    position = draft.signals.get("position")
    clock = draft.clock
    if slip is None or position is None or clock is None or not slip.column or not position.column:
        return
    if (slip.si, position.si) not in _RATES:
        return
    stamps = (
        draft.table.columns[clock.column] * clock.factor
        if clock.kind == "column"
        else draft.seen.stamps
    )
    if stamps is None:
        return
    speed = draft.table.columns[slip.column] * slip.factor
    place = draft.table.columns[position.column] * position.factor
    ratio = over_rate(speed, place, stamps)
    if ratio is None:
        return
    is_unit = is_usual_ratio(ratio) and abs(abs(ratio) - 1.0) >= _SAME
    answer = ""
    if clock.kind == "column" and draft.told.time is None and not _is_one(ratio):
        answer = _other_clock(draft, clock, ratio, speed, place)
    if not is_unit and not answer:
        return
    if clock.doubt and answer.endswith(f"[{clock.likely}]"):
        return  # the doubt on the time proposes that unit

    times = f"{abs(ratio):.3g} times the rate of the position, column {position.column}"
    odd = f"the slip, column {slip.column}, is {times}: the unit of one of them, or of the time, is another"
    if slip.sureness == "given":
        draft.notes.append(odd)
        return
    option = f"--slip {shell_word(draft.table.label(slip.column))}"
    if answer:
        odd += "; by another clock they agree"
        option = f"--time {shell_word(answer)}"
    draft.ask("slip", MappingError(odd, remedy=f"Say which is right, such as {option}"), option)


def _is_one(ratio: float) -> bool:
    return abs(abs(ratio) - 1.0) < _SAME_CLOCK


def _other_clock(draft: Draft, clock: ClockPlan, ratio: float, speed: Array, place: Array) -> str:
    """The label of a time by which a slip is the rate of its position; "" where none is.

    Args:
        draft: the plan so far.
        clock: by which it is not.
        ratio: of the slip to the rate of the position by that clock.
        speed: in SI units, shape (n,).
        place: in SI units, shape (n,).
    """
    table = draft.table
    taken = [each.column for each in draft.signals.values()]
    for column in draft.seen.without([*taken, clock.column]):
        unit = column.unit_for(("s",)) or column.written_unit
        seconds = units.fits(unit, ("s",)) if unit and units.is_unit(unit) else None
        if seconds is None or not column.shape.rises:
            continue
        own = over_rate(speed, place, column.values * seconds[0])
        if own is not None and _is_one(own):
            return table.label(column.name)
    # Steps of no logger may be those of its milliseconds, whatever unit stands above them.
    step = float(np.median(np.diff(table.columns[clock.column])))
    if _QUICK <= step * clock.factor <= _SLOW:
        return ""
    for unit, size in _TIMES.items():
        if _is_one(ratio * size / clock.factor):
            return f"{clock.column} [{unit}]"
    return ""


def ask_about_a_wrapped_angle(draft: Draft) -> None:
    """Ask about a position without a unit that jumps by a full turn: the rate of such jumps is no speed."""
    position = draft.signals.get("position")
    if position is None or not position.column or "slip" in draft.signals:
        return
    if position.unit or position.scale != 1.0:
        return
    place = draft.table.columns[position.column]
    place = place[np.isfinite(place)]
    if place.size < _FEWEST:
        return
    jumps = np.abs(np.diff(place))
    for unit, turn in (("deg", 360.0), ("rad", 2.0 * np.pi)):
        begins_at_zero = -_EDGE * turn <= place.min() and place.max() <= (1.0 + _EDGE) * turn
        is_about_zero = float(np.abs(place).max()) <= (0.5 + _EDGE) * turn
        wraps = np.count_nonzero(jumps > _JUMP * turn)
        steady = float(np.median(jumps)) < _STEP * turn
        if wraps and steady and (begins_at_zero or is_about_zero) and np.ptp(place) > _JUMP * turn:
            label = shell_word(f"{position.column} [{unit}]")
            problem = f"column {position.column} has no unit and jumps by a full turn {wraps} times, as an angle in"
            remedy = f"Give its unit, such as --position {label}"
            draft.ask(
                "position",
                MappingError(f"{problem} {unit} does", remedy=remedy),
                f"--position {label}",
            )
            return


def hold_power(draft: Draft) -> None:
    """Ask where slip times effort is some times a logged power, all through the log: a unit is another than it says.

    An electric power, or a power behind a gear with losses, has no steady ratio and tells nothing.
    """
    slip = draft.signals.get("slip")
    effort = draft.signals.get("effort")
    if slip is None or effort is None or not slip.column or not effort.column:
        return
    if (slip.si, effort.si) not in _POWERS:
        return
    columns = draft.table.columns
    made = columns[slip.column] * slip.factor * columns[effort.column] * effort.factor  # [W]
    for column in draft.seen.without(draft.taken):
        if not column.unit or not units.is_unit(column.unit) or not column.fits(("W",)):
            continue
        kind = SignalKind("power", "power of the device", ("W",))
        to_watt, _ = units.conversion(column.unit, kind, column.name)
        power = column.values * to_watt
        # What one is of the other in nearly all rows where the power is large.
        known = np.isfinite(made) & np.isfinite(power)
        size = np.abs(power)
        largest = size[known].max(initial=0.0)
        large = known & (size >= _LARGE * largest) & (power != 0.0)
        if np.count_nonzero(large) < _FEWEST:
            continue
        low, middle, high = np.quantile(made[large] / power[large], (0.1, 0.5, 0.9))
        ratio = float(middle)
        is_steady = high - low <= _STEADY * abs(ratio)
        if not is_steady or not is_usual_ratio(ratio) or abs(abs(ratio) - 1.0) < _SAME:
            continue
        times = f"{abs(ratio):.3g} times the power, column {column.name}"
        of_one = f"the unit of one of the columns {slip.column}, {effort.column} and {column.name} is another"
        odd = f"slip times effort is {times}: {of_one}"
        if slip.sureness == "given" or "slip" in draft.questions:
            draft.notes.append(odd)
        else:
            remedy = (
                f"Say which is right, such as --slip {shell_word(draft.table.label(slip.column))}"
            )
            draft.ask("slip", MappingError(odd, remedy=remedy))
        return


def refuse_the_effort_twice(draft: Draft) -> None:
    """Refuse a column that is the effort and another signal: a model that is given its effort would find just that.

    The time is no signal at all: what a column of stamps is called so would be fitted as one.

    Raises:
        MappingError: there is such a column.
    """
    stamps = draft.clock.column if draft.clock is not None and draft.clock.kind == "column" else ""
    for chosen in draft.signals.values():
        if chosen.column and chosen.column == stamps:
            problem = f"column {stamps} is both time and {chosen.signal}"
            remedy = f"Name another column with --{chosen.signal} or --time"
            raise MappingError(problem, remedy=remedy)
    effort = draft.signals.get("T" if draft.device == "coaxial" else "effort")
    if effort is None or not effort.column:
        return
    for other in (*draft.signals.values(), *draft.inputs):
        if other.column == effort.column and other is not effort:
            problem = f"column {effort.column} is both {other.signal} and {effort.signal}"
            remedy = f"Name another column with --{effort.signal} or --{other.signal}"
            raise MappingError(problem, remedy=remedy)

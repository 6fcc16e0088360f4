"""A motion tells the unit of stamps without one, and the rate of rows without stamps.

A speed is the rate of its position in one unit of the time alone.
"""

from __future__ import annotations

import re
from collections import Counter
from math import floor, inf, log10

import numpy as np

from erclutch.logs.columns.seen_columns import SeenColumn, SeenColumns
from erclutch.logs.columns.two_courses import over_rate
from erclutch.logs.columns.vocabulary import TOLD
from erclutch.signals import units
from erclutch.signals.array import Array

#: How many times the rate by the stamps a speed is, where these are no seconds.
_RATIOS = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
_CLOSE = 0.05
_NONE = ""  # what a pair in other units tells
_MANY = 12  # pairs of a speed and a position: more are not looked at
#: Rates that loggers are set to, but for powers of ten; numbers without units tell no other.
_ROUND = (1.0, 1.25, 2.0, 2.5, 4.0, 5.0, 6.0, 8.0, 10.0)
_NEAR = 0.02
# Numbers without units may be m/s beside mm, a thousand times apart: such a step or rate is no logger's.
_USUAL_STEPS = (2e-4, 0.2)  # s a row
_USUAL_RATES = (5.0, 2e4)  # Hz
_JOINT = re.compile(r"\D*(\d+)\D*")


def unit_by_motion(seen: SeenColumns, stamps: Array) -> str | None:
    """The unit in which speeds are the rates of their positions; None where no pair tells one, or pairs tell several.

    A pair in units of its own, such as a gripper's, tells none: most of the pairs have to tell the one.

    Args:
        seen: the columns of the log.
        stamps: as logged, shape (n,).
    """
    step = float(np.median(np.diff(stamps)))
    told: Counter[str] = Counter()
    for speed, position in _pairs(seen):
        ratio = over_rate(speed.values, position.values, stamps)
        if ratio is None:
            continue
        times = _in_one_kind(speed, position)
        told_by_pair = _NONE
        for unit, larger in _RATIOS.items():
            is_usual = times is not None or (unit != "s" and _lies_in(step / larger, _USUAL_STEPS))
            if is_usual and abs(ratio * (times or 1.0) / larger - 1.0) < _CLOSE:
                told_by_pair = unit
        told[told_by_pair] += 1
    several = {*told} - {_NONE}
    if len(several) != 1:
        return None
    unit = several.pop()
    return unit if told[unit] > told[_NONE] else None


def rate_by_motion(seen: SeenColumns) -> float | None:
    """The rate in Hz at which the speeds of a log without a clock are the rates of their positions; None for no such.

    Units tell it of themselves. Numbers without units have to tell a rate that loggers are set to.
    """
    rates: list[float] = []
    others = 0
    rows = np.arange(float(seen.table.rows))
    for speed, position in _pairs(seen):
        ratio = over_rate(speed.values, position.values, rows)
        if ratio is None:
            continue
        times = _in_one_kind(speed, position)
        rate = ratio * (times or 1.0)
        is_told = 0.0 < rate < inf and (
            times is not None or (_lies_in(rate, _USUAL_RATES) and usual_rate(rate) is not None)
        )
        if is_told:
            rates.append(rate)
        else:
            others += 1
    if not rates or len(rates) <= others or max(rates) > (1.0 + _CLOSE) * min(rates):
        return None
    rate = float(np.median(rates))
    return usual_rate(rate) or float(f"{rate:.3g}")


def _in_one_kind(speed: SeenColumn, position: SeenColumn) -> float | None:
    """By what the ratio of a speed and the rate of a position is multiplied, for their units; None without units."""
    for of_speed, of_position in (("rad/s", "rad"), ("m/s", "m")):
        speed_unit = speed.unit_for((of_speed,))
        position_unit = position.unit_for((of_position,))
        if not speed_unit or not position_unit:
            continue
        fast = units.fits(speed_unit, (of_speed,))
        far = units.fits(position_unit, (of_position,))
        if fast is not None and far is not None:
            return fast[0] / far[0]
    return None


def _lies_in(number: float, ends: tuple[float, float]) -> bool:
    low, high = ends
    return low <= number <= high


def usual_rate(rate: float) -> float | None:
    """The round rate beside a rate; None where none is near, and for what is no rate."""
    if not 0.0 < rate < inf:
        return None
    power = 10.0 ** floor(log10(rate))
    nearest = min(_ROUND, key=lambda each: abs(rate / (each * power) - 1.0))
    return nearest * power if abs(rate / (nearest * power) - 1.0) < _NEAR else None


def _pairs(seen: SeenColumns) -> list[tuple[SeenColumn, SeenColumn]]:
    """Speeds beside positions of the same joint, by their names; both without a unit, or both with one."""
    measured = [
        column for column in seen.columns.values() if TOLD.isdisjoint(column.spoken.stem_words)
    ]
    speeds = [column for column in measured if "slip" in column.spoken.may_be]
    positions = [column for column in measured if "position" in column.spoken.may_be]
    pairs: list[tuple[SeenColumn, SeenColumn]] = []
    for speed in speeds:
        for position in positions:
            have_units = bool(speed.written_unit) == bool(position.written_unit)
            if have_units and speed is not position and _joint(speed) == _joint(position):
                pairs.append((speed, position))
    return pairs[:_MANY]


def _joint(column: SeenColumn) -> str:
    """The one number in a name; "" for none and several."""
    number = _JOINT.fullmatch(column.spoken.stem)
    return number.group(1) if number else ""

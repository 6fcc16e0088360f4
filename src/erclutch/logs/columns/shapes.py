"""What the numbers of a column look like: a slip, a position and its rate, an effort that opposes motion, a counter."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from erclutch.signals.array import Array

_SHAPED = frozenset({"field", "slip", "position"})
_MOVES = 0.02  # share of the largest position by which a position changes at least
_KEEPS = 0.2  # share of the rows from which on a field keeps its levels
_RESTS = 0.02  # share of the largest slip below which a device rests
#: Rows of a column that are looked at.
LOOKED_AT = 20_000
#: Rows, below which nothing is said of how two columns go together.
FEW = 10
_LEVELS = 20  # of a switched field at most
_SELDOM = 0.1  # share of the rows in which it is switched at most
_ALIKE = 0.98  # correlation of a position with what its speed adds up to
_BEYOND = 20.0  # upper quartiles: further out are codes for no measurement
_FOLLOWS = 0.3  # correlation of an effort with a motion
_STRAIGHT = 0.99  # correlation of the output of a sensor with what it measures
_GOES_ALONG = 0.9  # correlation of two columns that tell one thing
#: Of a speed over the rate of its position: units of length and angle that loggers mix.
_RATIOS = (1.0, 10.0, 100.0, 1000.0, 180 / pi, 30 / pi, 2 * pi, 6.0, 360.0, 60.0)
_CLOSE = 0.05


@dataclass(frozen=True)
class Shape:
    """How the numbers of one column run.

    Attributes:
        constant: they never change: a radius or a gap is no motion, whatever its unit says.
        counts_rows: they are whole numbers, one more from row to row, as an index has them.
        rises: they rise from row to row, as a time does that each row has.
        keeps_levels: they are a few numbers, each for many rows, as a field that is switched has them.
        like: those of field, slip and position that they look like. A slip turns back or rests, a field keeps or leaves
            levels, a position moves: a gap hardly does.
    """

    constant: bool
    counts_rows: bool
    rises: bool
    keeps_levels: bool
    like: frozenset[str]

    def looks_like(self, signal: str) -> bool:
        """Whether the numbers may be a signal; of those that have no shape of their own they may be any."""
        return signal in self.like or signal not in _SHAPED


def shape_of(values: Array) -> Shape:
    """The shape of a column as logged, shape (n,); what is not finite is passed over."""
    finite = np.isfinite(values)
    whole = bool(finite.all())
    known = values if whole else values[finite]
    if known.size < 2:
        return Shape(
            constant=False,
            counts_rows=False,
            rises=False,
            keeps_levels=False,
            like=_SHAPED,
        )

    with np.errstate(over="ignore", invalid="ignore"):  # numbers at both ends of what a float holds
        steps = np.diff(known)
    low = float(known.min())
    high = float(known.max())
    largest = max(abs(low), abs(high))

    like: set[str] = set()
    still = np.count_nonzero(steps == 0.0)
    if still / steps.size > _KEEPS or np.any(known == 0.0):
        like.add("field")
    if low < 0.0 < high or np.any(np.abs(known) <= _RESTS * largest):
        like.add("slip")
    if high - low > _MOVES * largest:
        like.add("position")

    keeps_levels = False
    changes = np.count_nonzero(steps[: LOOKED_AT - 1])
    if changes <= _SELDOM * known.size:
        # Levels are counted last: to sort the numbers costs more than all the rest.
        levels = np.unique(known[:LOOKED_AT])
        keeps_levels = 2 <= levels.size <= _LEVELS

    return Shape(
        constant=low == high,
        counts_rows=whole and bool(np.all(steps == 1.0)) and float(values[0]).is_integer(),
        rises=whole and bool(np.all(steps >= 0.0)) and low < high,
        keeps_levels=keeps_levels,
        like=frozenset(like),
    )


def spread_of(values: Array) -> float:
    """What 90 % of the values differ by, as a share of their median; infinite about a median of zero."""
    known = values[np.isfinite(values)]
    if not known.size:  # a block of a long log may hold no number of a column
        return float("inf")
    low, middle, high = np.quantile(known, [0.05, 0.5, 0.95])
    if middle == 0.0:
        return float("inf")
    return float((high - low) / abs(middle))


def is_rate_of(speed: Array, position: Array, stamps: Array | None) -> bool:
    """Whether a column is the rate of another one, up to a usual factor between units; see `over_rate`."""
    if stamps is None:
        return False
    ratio = over_rate(speed, position, stamps)
    return ratio is not None and is_usual_ratio(ratio)


def is_usual_ratio(ratio: float) -> bool:
    """Whether a ratio is one that mixed units make: of millimetres to metres, of degrees to radians."""
    usual = [*_RATIOS, *(1.0 / each for each in _RATIOS)]
    return any(abs(ratio * each - 1.0) < _CLOSE for each in usual)


def over_rate(speed: Array, position: Array, stamps: Array) -> float | None:
    """How many times the rate of a position a speed is; None where it does not go with that rate.

    What the speed adds up to is held against the position, since the rate of a noisy position is noise.

    Args:
        speed: shape (n,).
        position: shape (n,).
        stamps: in s, shape (n,).
    """
    v = speed[:LOOKED_AT]
    x = position[:LOOKED_AT]
    t = stamps[:LOOKED_AT]
    known = np.isfinite(v) & np.isfinite(x) & np.isfinite(t)
    v = v[known]
    x = x[known]
    t = t[known]
    if v.size < FEW or np.ptp(v) == 0.0 or np.ptp(x) == 0.0:
        return None
    steps = np.diff(t)
    if np.any(steps < 0) or t[0] == t[-1]:
        return None
    trapezoids = 0.5 * (v[1:] + v[:-1]) * steps
    travel = np.concatenate([[0.0], np.cumsum(trapezoids)])

    # An offset of the speed is none of the motion's: both are compared without a drift.
    drift = np.column_stack([np.ones_like(t), t - t[0]])
    drift_of_travel, *_ = np.linalg.lstsq(drift, travel, rcond=None)
    drift_of_position, *_ = np.linalg.lstsq(drift, x, rcond=None)
    travel = travel - drift @ drift_of_travel
    moved = x - drift @ drift_of_position
    if np.ptp(moved) <= 1e-9 * np.ptp(x) or np.ptp(travel) == 0.0:
        return None
    together = float(travel @ moved)
    square = float(moved @ moved)
    correlation = together / float(np.sqrt((travel @ travel) * square))
    return together / square if abs(correlation) > _ALIKE else None


def follows(effort: Array, motion: Array) -> bool:
    """Whether a column takes both signs and goes with a motion or its rate, as the effort of a brake or damper does."""
    known = np.isfinite(effort) & np.isfinite(motion)
    if known.any():  # codes for no measurement lie far beyond
        usual = np.quantile(np.abs(effort[known]), 0.75)
        known &= np.abs(effort) <= _BEYOND * usual
    f = effort[known][:LOOKED_AT]
    v = motion[known][:LOOKED_AT]
    if f.size < FEW or not (f.min() < 0.0 < f.max()) or np.ptp(v) == 0.0:
        return False
    for course in (v, np.gradient(v)):
        if np.ptp(course) > 0.0:
            correlation = float(np.corrcoef(f, course)[0, 1])
            if abs(correlation) > _FOLLOWS:
                return True
    return False


def takes_both_signs(values: Array) -> bool:
    """Whether some numbers lie above zero and some below."""
    return bool(np.any(values < 0.0) and np.any(values > 0.0))


def goes_along(first: Array, second: Array) -> bool:
    """Whether two columns take both signs, and one is by and large the other one times a number."""
    known = np.isfinite(first) & np.isfinite(second)
    a = first[known][:LOOKED_AT]
    b = second[known][:LOOKED_AT]
    if a.size < FEW or not takes_both_signs(a) or not takes_both_signs(b):
        return False
    a = a / np.abs(a).max()  # no square of a large number overflows
    b = b / np.abs(b).max()
    return bool(abs(np.corrcoef(a, b)[0, 1]) >= _GOES_ALONG)


def go_straight(output: Array, measured: Array) -> bool:
    """Whether one column is the other one times a number plus a number, up to the noise of a sensor."""
    known = np.isfinite(output) & np.isfinite(measured)
    a = output[known][:LOOKED_AT]
    b = measured[known][:LOOKED_AT]
    if a.size < FEW or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return False
    a = a / np.abs(a).max()  # no square of a tiny or a large number is lost
    b = b / np.abs(b).max()
    return bool(abs(np.corrcoef(a, b)[0, 1]) >= _STRAIGHT)

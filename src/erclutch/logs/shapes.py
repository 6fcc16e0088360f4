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
_ROWS = 20_000  # looked at
_FEW = 10
_LEVELS = 20  # of a switched field at most
_SELDOM = 0.1  # share of the rows in which it is switched at most
_ALIKE = 0.98  # correlation of a position with what its speed adds up to
_BEYOND = 20.0  # upper quartiles: further out are codes for no measurement
_FOLLOWS = 0.3  # correlation of an effort with a motion
#: Of a speed over the rate of its position: units of length and angle that loggers mix.
_RATIOS = (1.0, 10.0, 100.0, 1000.0, 180 / pi, 30 / pi, 2 * pi, 6.0, 360.0, 60.0)
_CLOSE = 0.05
_RETURNS = 0.1  # of the range, by which a column comes back that does not only rise or only fall
_SAME_COURSE = 2e-3  # of the range, within which two columns are one course
_SET_ENDS = 0.1  # of the range, by which the ends of a set point and of what follows it differ at most
_FOLLOWS_CLOSELY = 0.996  # correlation of a set point with what follows it some rows later
_DIGITS = 0.05  # of its spread, by which a quotient that was written with some digits is off
_PER_CENT = (1.0, 100.0)
_STEADY = 0.05  # share of its level by which a supply varies at most
_VARIES = 0.5  # and by which a field varies at least
_QUARTERS = (0.25, 0.5, 0.75)
_ABOUT = 0.1  # of a smoothed quotient, by which it differs from the quotient at its quartiles
_ESTIMATES = 0.7  # correlation of the signs of two estimates of one thing


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
        return Shape(constant=False, counts_rows=False, rises=False, keeps_levels=False, like=_SHAPED)

    with np.errstate(over="ignore", invalid="ignore"):  # numbers at both ends of what a float holds
        steps = np.diff(known)
    low, high = float(known.min()), float(known.max())
    largest = max(abs(low), abs(high))
    still = np.count_nonzero(steps == 0.0)

    like: set[str] = set()
    if still / steps.size > _KEEPS or np.any(known == 0.0):
        like.add("field")
    if low < 0.0 < high or np.any(np.abs(known) <= _RESTS * largest):
        like.add("slip")
    if high - low > _MOVES * largest:
        like.add("position")

    changes = np.count_nonzero(steps[: _ROWS - 1])
    seldom = bool(changes <= _SELDOM * known.size)
    return Shape(
        constant=low == high,
        counts_rows=whole and bool(np.all(steps == 1.0)) and float(values[0]).is_integer(),
        rises=whole and bool(np.all(steps >= 0.0)) and low < high,
        # Levels are counted last: to sort the numbers costs more than all the rest.
        keeps_levels=seldom and 2 <= np.unique(known[:_ROWS]).size <= _LEVELS,
        like=frozenset(like),
    )


def same_course(first: Array, second: Array) -> bool:
    """Whether a column is another one times a number plus a number, and both come back: stress and force, say.

    Two columns that only rise, such as two ramps, may go together by chance.
    """
    known = np.isfinite(first) & np.isfinite(second)
    a, b = first[known][:_ROWS], second[known][:_ROWS]
    if a.size < _FEW or np.ptp(a) == 0.0 or not _comes_back(b):
        return False
    scaled = np.column_stack([np.ones_like(b), (b - b.min()) / np.ptp(b)])
    left = a - scaled @ np.linalg.lstsq(scaled, a, rcond=None)[0]
    return bool(np.ptp(left) <= _SAME_COURSE * np.ptp(a))


def is_set_point_of(column: Array, measured: Array) -> bool:
    """Whether a column swings between the same two ends as a measured one, which follows it some rows later."""
    known = np.isfinite(column) & np.isfinite(measured)
    a, b = column[known][:_ROWS], measured[known][:_ROWS]
    if a.size < _FEW or not _comes_back(a) or not _comes_back(b):
        return False
    off = max(abs(a.min() - b.min()), abs(a.max() - b.max()))
    if off > _SET_ENDS * np.ptp(b):
        return False
    size = 2 * a.size
    spectrum = np.conj(np.fft.rfft(a - a.mean(), size)) * np.fft.rfft(b - b.mean(), size)
    lag = int(np.fft.irfft(spectrum, size)[: a.size // 2].argmax())
    return lag > 0 and bool(np.corrcoef(a[:-lag], b[lag:])[0, 1] > _FOLLOWS_CLOSELY)


def is_quotient(column: Array, top: Array, bottom: Array) -> bool:
    """Whether a column is one column over another, as a share or in percent, in each row up to its digits.

    Signs are passed over: a coefficient of friction has none.
    """
    known = np.isfinite(column) & np.isfinite(top) & np.isfinite(bottom) & (bottom != 0.0)
    share, above, below = (np.abs(each[known][:_ROWS]) for each in (column, top, bottom))
    if share.size < _FEW or np.std(share) == 0.0:
        return False
    with np.errstate(over="ignore"):
        off = (float(np.median(np.abs(share - scale * above / below))) for scale in _PER_CENT)
        return bool(min(off) <= _DIGITS * np.std(share))


def is_steady(values: Array) -> bool:
    """Whether a column keeps near one level that is not zero, as the voltage of a supply does."""
    return _spread(values) <= _STEADY


def varies(values: Array) -> bool:
    """Whether a column takes quite different values, as a field that is switched or turned up does."""
    return _spread(values) >= _VARIES


def _spread(values: Array) -> float:
    """What 90 % of the values differ by, as a share of their median; infinite about a median of zero."""
    known = values[np.isfinite(values)]
    if not known.size:  # a block of a long log may hold no number of a column
        return float("inf")
    low, middle, high = np.quantile(known, [0.05, 0.5, 0.95])
    return float((high - low) / abs(middle)) if middle != 0.0 else float("inf")


def is_as_large(column: Array, top: Array, bottom: Array) -> bool:
    """Whether a column is about as large as one column over another: in the median, and where it is large and small."""
    known = np.isfinite(column) & np.isfinite(top) & np.isfinite(bottom) & (bottom != 0.0)
    if np.count_nonzero(known) < _FEW:
        return False
    with np.errstate(over="ignore"):
        share = np.quantile(np.abs(column[known]), _QUARTERS)
        made = np.quantile(np.abs(top[known] / bottom[known]), _QUARTERS)
    return bool(np.all(share > 0.0) and np.all(np.abs(made - share) <= _ABOUT * share))


def _comes_back(values: Array) -> bool:
    """Whether a column both falls and rises by a good part of its range."""
    moved = float(np.ptp(values))
    falls = float((np.maximum.accumulate(values) - values).max())
    climbs = float((values - np.minimum.accumulate(values)).max())
    return moved > 0.0 and min(falls, climbs) > _RETURNS * moved


def are_estimates(first: Array, second: Array) -> bool:
    """Whether two columns that take both signs go together as two estimates of one effort do."""
    known = np.isfinite(first) & np.isfinite(second)
    a, b = np.sign(first[known][:_ROWS]), np.sign(second[known][:_ROWS])
    if a.size < _FEW or min(np.ptp(a), np.ptp(b)) < 2.0:
        return False
    return bool(np.corrcoef(a, b)[0, 1] > _ESTIMATES)


def is_rate_of(speed: Array, position: Array, stamps: Array | None) -> bool:
    """Whether a column is the rate of another one, up to a usual factor between units; see `over_rate`."""
    ratio = None if stamps is None else over_rate(speed, position, stamps)
    return ratio is not None and is_usual_ratio(ratio)


def is_usual_ratio(ratio: float) -> bool:
    """Whether a ratio is one that mixed units make: of millimetres to metres, of degrees to radians."""
    factors = [*_RATIOS, *(1.0 / each for each in _RATIOS)]
    return any(abs(ratio * factor - 1.0) < _CLOSE for factor in factors)


def over_rate(speed: Array, position: Array, stamps: Array) -> float | None:
    """How many times the rate of a position a speed is; None where it does not go with that rate.

    What the speed adds up to is held against the position, since the rate of a noisy position is noise.

    Args:
        speed: shape (n,).
        position: shape (n,).
        stamps: in s, shape (n,).
    """
    v, x, t = speed[:_ROWS], position[:_ROWS], stamps[:_ROWS]
    known = np.isfinite(v) & np.isfinite(x) & np.isfinite(t)
    v, x, t = v[known], x[known], t[known]
    if v.size < _FEW or np.ptp(v) == 0.0 or np.ptp(x) == 0.0:
        return None
    if np.any(np.diff(t) < 0) or t[0] == t[-1]:
        return None
    trapezoids = 0.5 * (v[1:] + v[:-1]) * np.diff(t)
    travel = np.concatenate([[0.0], np.cumsum(trapezoids)])

    # An offset of the speed is none of the motion's: both are compared without a drift.
    drift = np.column_stack([np.ones_like(t), t - t[0]])
    travel = travel - drift @ np.linalg.lstsq(drift, travel, rcond=None)[0]
    moved = x - drift @ np.linalg.lstsq(drift, x, rcond=None)[0]
    if np.ptp(moved) <= 1e-9 * np.ptp(x) or np.ptp(travel) == 0.0:
        return None
    together, square = float(travel @ moved), float(moved @ moved)
    alike = together / float(np.sqrt((travel @ travel) * square))
    return together / square if abs(alike) > _ALIKE else None


def follows(effort: Array, motion: Array) -> bool:
    """Whether a column takes both signs and goes with a motion or its rate, as the effort of a brake or damper does."""
    known = np.isfinite(effort) & np.isfinite(motion)
    if known.any():  # codes for no measurement lie far beyond
        usual = np.quantile(np.abs(effort[known]), 0.75)
        known &= np.abs(effort) <= _BEYOND * usual
    f, v = effort[known][:_ROWS], motion[known][:_ROWS]
    if f.size < _FEW or not (f.min() < 0.0 < f.max()) or np.ptp(v) == 0.0:
        return False
    motions = [each for each in (v, np.gradient(v)) if np.ptp(each) > 0.0]
    return any(abs(float(np.corrcoef(f, each)[0, 1])) > _FOLLOWS for each in motions)

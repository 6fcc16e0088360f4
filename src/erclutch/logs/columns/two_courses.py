"""How the numbers of two columns go together: a speed is the rate of a position, an effort follows a motion."""

from __future__ import annotations

from math import pi

import numpy as np

from erclutch.logs.columns.shapes import FEW, LOOKED_AT, known_rows, takes_both_signs
from erclutch.signals.array import Array

_ALIKE = 0.98  # correlation of a position with what its speed adds up to
#: Of a speed over the rate of its position: units of length and angle that loggers mix.
_RATIOS = (1.0, 10.0, 100.0, 1000.0, 180 / pi, 30 / pi, 2 * pi, 6.0, 360.0, 60.0)
_CLOSE = 0.05
_FEWEST_STEPS = 8  # that add up exactly, which none do by chance
_LAST_DIGITS = 1e-6  # of the longest step
_BEYOND = 20.0  # upper quartiles: further out are codes for no measurement
_FOLLOWS = 0.3  # correlation of an effort with a motion
_STRAIGHT = 0.99  # correlation of the output of a sensor with what it measures
_GOES_ALONG = 0.9  # correlation of two columns that tell one thing
_LEVEL = 0.01  # of the range, by which a number lies at neither end
_ESTIMATES = 0.7  # correlation of the signs of two estimates of one thing
_RETURNS = 0.1  # of the range, by which a column comes back that does not only rise or only fall
_ROUNDED = 1e-5  # of the largest number, as texts round each of three columns
_SAME_COURSE = 2e-3  # of the range, within which two columns are one course
# Of the range, by which the ends of a set point and of what follows it differ at most.
_SET_ENDS = 0.1
_FOLLOWS_CLOSELY = 0.996  # correlation of a set point with what follows it some rows later


def is_rate_of(speed: Array, position: Array, stamps: Array | None) -> bool:
    """Whether a column is the rate of another one, up to a usual factor between units; see `over_rate`."""
    if stamps is None:
        return False
    ratio = over_rate(speed, position, stamps)
    if ratio is not None and is_usual_ratio(ratio):
        return True

    # A spreadsheet computes a position step by step from a speed: a few rows tell.
    known = np.isfinite(speed) & np.isfinite(position) & np.isfinite(stamps)
    v = speed[known][:LOOKED_AT]
    x = position[known][:LOOKED_AT]
    steps = np.diff(stamps[known][:LOOKED_AT])
    if v.size < _FEWEST_STEPS or np.ptp(v) == 0.0 or not bool(np.all(steps > 0.0)):
        return False
    travels = np.diff(x)
    allowed = _LAST_DIGITS * float(np.abs(travels).max())
    if allowed == 0.0:
        return False
    return any(bool(np.all(np.abs(travels - each * steps) <= allowed)) for each in (v[:-1], v[1:]))


def is_usual_ratio(ratio: float) -> bool:
    """Whether a ratio is one that mixed units make: of millimetres to metres, of degrees to radians."""
    usual = [*_RATIOS, *(1.0 / each for each in _RATIOS)]
    return any(abs(ratio * each - 1.0) < _CLOSE for each in usual)


def over_rate(speed: Array, position: Array, stamps: Array) -> float | None:
    """How many times the rate of a position a speed is; None where it does not go with that rate.

    What the speed adds up to is held against the position, since the rate of a noisy position is noise. Where stamps
    begin anew, as at each level of a field, the longest run between two beginnings tells.

    Args:
        speed: shape (n,).
        position: shape (n,).
        stamps: in s, shape (n,).
    """
    v = speed[:LOOKED_AT]
    x = position[:LOOKED_AT]
    t = stamps[:LOOKED_AT]
    known = np.isfinite(v) & np.isfinite(x) & np.isfinite(t)
    begins = 1 + np.flatnonzero(np.diff(t[known]) < 0.0)
    edges = np.concatenate([[0], begins, [np.count_nonzero(known)]])
    longest = int(np.argmax(np.diff(edges)))
    run = slice(int(edges[longest]), int(edges[longest + 1]))
    v = v[known][run]
    x = x[known][run]
    t = t[known][run]
    if v.size < FEW or np.ptp(v) == 0.0 or np.ptp(x) == 0.0:
        return None
    steps = np.diff(t)
    if t[0] == t[-1]:
        return None
    trapezoids = 0.5 * (v[1:] + v[:-1]) * steps
    travel = np.concatenate([[0.0], np.cumsum(trapezoids)])

    # An offset of the speed is none of the motion's: both are compared without a drift.
    line = np.column_stack([np.ones_like(t), t - t[0]])
    drift_of_travel, *_ = np.linalg.lstsq(line, travel, rcond=None)
    drift_of_position, *_ = np.linalg.lstsq(line, x, rcond=None)
    travel = travel - line @ drift_of_travel
    moved = x - line @ drift_of_position
    if np.ptp(moved) <= 1e-9 * np.ptp(x) or np.ptp(travel) == 0.0:
        return None
    product = float(travel @ moved)
    square = float(moved @ moved)
    square_of_travel = float(travel @ travel)
    correlation = product / float(np.sqrt(square_of_travel * square))
    if abs(correlation) <= _ALIKE:
        return None
    return product / square


def follows(effort: Array, motion: Array) -> bool:
    """Whether a column takes both signs and goes with a motion or its rate, as the effort of a brake or damper does."""
    known = np.isfinite(effort) & np.isfinite(motion)
    if known.any():  # codes for no measurement lie far beyond
        usual = np.quantile(np.abs(effort[known]), 0.75)
        known &= np.abs(effort) <= _BEYOND * usual
    f = effort[known][:LOOKED_AT]
    v = motion[known][:LOOKED_AT]
    if f.size < FEW or np.ptp(v) == 0.0:
        return False
    if not f.min() < 0.0 < f.max():
        return False
    for course in (v, np.gradient(v)):
        if np.ptp(course) > 0.0:
            correlation = float(np.corrcoef(f, course)[0, 1])
            if abs(correlation) > _FOLLOWS:
                return True
    return False


def goes_along(first: Array, second: Array) -> bool:
    """Whether two columns take both signs, and one is by and large the other one times a number."""
    a, b = known_rows(first, second)
    if a.size < FEW or not takes_both_signs(a) or not takes_both_signs(b):
        return False
    a = a / np.abs(a).max()  # no square of a large number overflows
    b = b / np.abs(b).max()
    return bool(abs(np.corrcoef(a, b)[0, 1]) >= _GOES_ALONG)


def go_straight(output: Array, measured: Array) -> bool:
    """Whether one column is the other one times a number plus a number, up to the noise of a sensor."""
    return abs(correlation_of(output, measured)) >= _STRAIGHT


def correlation_of(first: Array, second: Array) -> float:
    """How two columns go together, from -1 to 1; 0 where few rows have both, or one of the columns never changes."""
    a, b = known_rows(first, second)
    if a.size < FEW or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return 0.0
    a = a / np.abs(a).max()  # no square of a tiny or a large number is lost
    b = b / np.abs(b).max()
    return float(np.corrcoef(a, b)[0, 1])


def is_same_course(first: Array, second: Array) -> bool:
    """Whether a column is another one times a number plus a number, and both come back: stress and force, say.

    Two columns that only rise, such as two ramps, may go together by chance.
    """
    a, b = known_rows(first, second)
    if a.size < FEW or np.ptp(a) == 0.0 or not _comes_back(b):
        return False
    from_0_to_1 = (b - b.min()) / np.ptp(b)
    scaled = np.column_stack([np.ones_like(b), from_0_to_1])
    line, *_ = np.linalg.lstsq(scaled, a, rcond=None)
    left = a - scaled @ line
    return bool(np.ptp(left) <= _SAME_COURSE * np.ptp(a))


def is_course_times_a_number(column: Array, measured: Array) -> bool:
    """Whether a column is a measured one times a number, as the speed of a rim beside its turns.

    Two levels, or two ramps from zero, may go together by chance.
    """
    a, b = known_rows(column, measured)
    if a.size < FEW or not np.any(b):
        return False
    apart = _LEVEL * float(np.ptp(b))
    if not np.any((b > b.min() + apart) & (b < b.max() - apart)):
        return False  # two levels
    if go_straight(b, np.arange(float(b.size))):
        return False  # a ramp
    return _are_in_proportion(a, b, _SAME_COURSE)


def is_size_of(column: Array, measured: Array) -> bool:
    """Whether a column holds the absolute values of a measured one, but for a few digits."""
    a, b = known_rows(column, measured)
    if a.size < FEW or np.ptp(a) == 0.0:
        return False
    off = np.abs(a - np.abs(b))
    return bool(np.max(off) <= _SAME_COURSE * np.ptp(a))


def is_set_point_of(column: Array, measured: Array) -> bool:
    """Whether a column swings between the same two ends as a measured one, which follows it some rows later."""
    a, b = known_rows(column, measured)
    if a.size < FEW or not _comes_back(a) or not _comes_back(b):
        return False
    off_below = abs(a.min() - b.min())
    off_above = abs(a.max() - b.max())
    if max(off_below, off_above) > _SET_ENDS * np.ptp(b):
        return False

    # The lag at which both correlate most, by their spectra; zeros behind the rows keep the ends apart.
    size = 2 * a.size
    of_column = np.fft.rfft(a - a.mean(), size)
    of_measured = np.fft.rfft(b - b.mean(), size)
    correlations = np.fft.irfft(np.conj(of_column) * of_measured, size)
    lag = int(correlations[: a.size // 2].argmax())  # rows
    if lag == 0:
        return False
    correlation = np.corrcoef(a[:-lag], b[lag:])[0, 1]
    return bool(correlation > _FOLLOWS_CLOSELY)


def _comes_back(values: Array) -> bool:
    """Whether a column both falls and rises by a good part of its range."""
    moved = float(np.ptp(values))
    falls = float((np.maximum.accumulate(values) - values).max())
    climbs = float((values - np.minimum.accumulate(values)).max())
    return moved > 0.0 and min(falls, climbs) > _RETURNS * moved


def are_estimates(first: Array, second: Array) -> bool:
    """Whether two columns that take both signs go together as two estimates of one effort do."""
    a, b = map(np.sign, known_rows(first, second))
    if a.size < FEW or min(np.ptp(a), np.ptp(b)) < 2.0:
        return False
    return bool(np.corrcoef(a, b)[0, 1] > _ESTIMATES)


def is_multiple_of(column: Array, other: Array, digits: float) -> bool:
    """Whether a column is another one times a number, up to its last digits; both take both signs."""
    known = np.isfinite(column) & np.isfinite(other)
    a = column[known]
    b = other[known]
    return goes_along(a, b) and _are_in_proportion(a, b, digits)


def is_sum_of(whole: Array, first: Array, second: Array) -> bool:
    """Whether a column is the sum of two others in each row, but for the rounding of a text."""
    off = np.abs(whole - first - second)
    known = np.isfinite(off)
    largest = float(np.abs(whole[known]).max(initial=0.0))
    return largest > 0.0 and float(off[known].max()) <= _ROUNDED * largest


def _are_in_proportion(a: Array, b: Array, digits: float) -> bool:
    """Whether numbers are others times one factor, up to a share of the largest."""
    factor = float(a @ b) / float(b @ b)
    return bool(np.max(np.abs(a - factor * b)) <= digits * np.max(np.abs(a), initial=0.0))


def move_alike(position: Array, other: Array, digits: float) -> bool:
    """Whether two positions in one unit differ in where they count from, and in nothing else."""
    known = np.isfinite(position) & np.isfinite(other)
    if not known.any():
        return False
    moved = float(np.ptp(position[known]))
    apart = (position - other)[known]
    return bool(moved > 0.0 and np.ptp(apart) <= digits * moved)

"""What the numbers of a column look like: a slip, a position and its rate, an effort that opposes motion, a counter."""

from __future__ import annotations

from math import pi

import numpy as np

from erclutch.signals.array import Array

_MOVES = 0.02  # share of the largest position by which a position changes at least
_KEEPS = 0.2  # share of the rows from which on a field keeps its levels
_ROWS = 20_000  # looked at
_FEW = 10
_LEVELS = 20  # of a switched field at most
_ALIKE = 0.98  # correlation of a position with what its speed adds up to
_BEYOND = 20.0  # upper quartiles: further out are codes for no measurement
_FOLLOWS = 0.3  # correlation of an effort with a motion
#: Of a speed over the rate of its position: units of length and angle that loggers mix.
_RATIOS = (1.0, 10.0, 100.0, 1000.0, 180 / pi, 30 / pi, 2 * pi, 6.0, 360.0, 60.0)
_CLOSE = 0.05


def is_constant(values: Array) -> bool:
    """Whether a column never changes: a radius or a gap is no motion, whatever its unit says."""
    known = values[np.isfinite(values)]
    return bool(known.size > 1 and np.ptp(known) == 0.0)


def is_counter(values: Array) -> bool:
    """Whether a column counts rows by whole numbers, as an index does."""
    steps = np.diff(values)
    return bool(steps.size and np.all(steps == 1.0) and float(values[0]).is_integer())


def rises(values: Array) -> bool:
    """Whether the numbers of a column rise from row to row, as a time does that each row has."""
    steps = np.diff(values)
    return bool(steps.size and np.isfinite(values).all() and np.all(steps >= 0.0) and np.any(steps > 0.0))


def moves_alike(first: Array, second: Array) -> bool:
    """Whether two positions in one unit differ in where they count from, and in nothing else."""
    known = np.isfinite(first) & np.isfinite(second)
    moved = float(np.ptp(first[known])) if known.any() else 0.0
    return bool(moved > 0.0 and np.ptp((first - second)[known]) <= 2e-3 * moved)


def has_shape_of(signal: str, values: Array) -> bool:
    """Whether the numbers of a column look like the signal.

    A slip turns back or rests, a field keeps or leaves levels, a position moves: a gap hardly does.

    Args:
        signal: its name.
        values: the column, shape (n,).
    """
    known = values[np.isfinite(values)]
    if known.size < 2 or signal not in ("field", "slip", "position"):
        return True
    if signal == "position":
        return bool(np.ptp(known) > _MOVES * np.abs(known).max())
    if signal == "slip":
        low, high = float(known.min()), float(known.max())
        return (low < 0.0 < high) or bool(np.any(np.abs(known) <= 0.02 * max(abs(low), abs(high))))
    stays = np.count_nonzero(np.diff(known) == 0.0) / (known.size - 1)
    return bool(stays > _KEEPS) or bool(np.any(known == 0.0))


def keeps_levels(values: Array) -> bool:
    """Whether a column holds a few numbers, each for many rows, as a field that is switched does."""
    known = values[np.isfinite(values)]
    levels = np.unique(known[:_ROWS]).size
    changes = np.count_nonzero(np.diff(known[:_ROWS]))
    return 2 <= levels <= _LEVELS and bool(changes <= 0.1 * known.size)


def is_rate_of(speed: Array, position: Array, stamps: Array | None) -> bool:
    """Whether a column is the rate of another one, up to a usual factor between units; see `over_rate`."""
    ratio = None if stamps is None else over_rate(speed, position, stamps)
    return ratio is not None and is_usual_ratio(ratio)


def is_usual_ratio(ratio: float) -> bool:
    """Whether a ratio is one that mixed units make: of millimetres to metres, of degrees to radians."""
    return any(abs(ratio * factor - 1.0) < _CLOSE for each in _RATIOS for factor in (each, 1.0 / each))


def over_rate(speed: Array, position: Array, stamps: Array) -> float | None:
    """How many times the rate of a position a speed is; None where it does not go with that rate.

    What the speed adds up to is held against the position, since the rate of a noisy position is noise.

    Args:
        speed: shape (n,).
        position: shape (n,).
        stamps: in s, shape (n,).
    """
    v, x, t = (each[:_ROWS] for each in (speed, position, stamps))
    known = np.isfinite(v) & np.isfinite(x) & np.isfinite(t)
    v, x, t = v[known], x[known], t[known]
    if v.size < _FEW or np.ptp(v) == 0.0 or np.ptp(x) == 0.0 or np.any(np.diff(t) < 0) or t[0] == t[-1]:
        return None
    travel = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
    drift = np.column_stack([np.ones_like(t), t - t[0]])  # an offset of the speed is none of the motion's
    travel, moved = (each - drift @ np.linalg.lstsq(drift, each, rcond=None)[0] for each in (travel, x))
    if np.ptp(moved) <= 1e-9 * np.ptp(x) or np.ptp(travel) == 0.0:
        return None
    alike = float(travel @ moved / np.sqrt((travel @ travel) * (moved @ moved)))
    ratio = float(travel @ moved / (moved @ moved))
    return ratio if abs(alike) > _ALIKE else None


def follows(effort: Array, motion: Array) -> bool:
    """Whether a column takes both signs and goes with a motion or its rate, as the effort of a brake or damper does."""
    known = np.isfinite(effort) & np.isfinite(motion)
    known &= np.abs(effort) <= _BEYOND * np.quantile(np.abs(effort[known]), 0.75) if known.any() else known  # no codes
    f, v = effort[known][:_ROWS], motion[known][:_ROWS]
    if f.size < _FEW or not (f.min() < 0.0 < f.max()) or np.ptp(v) == 0.0:
        return False
    return any(abs(float(np.corrcoef(f, each)[0, 1])) > _FOLLOWS for each in (v, np.gradient(v)) if np.ptp(each) > 0.0)


def same_thing(first: Array, second: Array) -> bool:
    """Whether two columns in one unit are the same numbers, written with some digits."""
    known = np.isfinite(first) & np.isfinite(second)
    size = float(np.abs(first[known]).max(initial=0.0))
    return bool(known.any() and size > 0.0 and np.abs(first - second)[known].max() <= 2e-3 * size)

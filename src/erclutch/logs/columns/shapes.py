"""What the numbers of one column look like: a field that keeps its levels, a slip that turns back, a row counter."""

from __future__ import annotations

from dataclasses import dataclass

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
#: A converter of ten bits or more has its zero at half of its range, 512 or more.
_LEAST_ZERO = 400
_SWING = 0.5  # of the zero
_IN_THE_MIDDLE = 0.25  # of the largest number
_SELDOM = 0.1  # share of the rows in which it is switched at most


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


def are_whole(values: Array) -> bool:
    """Whether all numbers are whole; a missing number is not."""
    return bool(np.all(values == np.round(values)))


def known_rows(*columns: Array) -> list[Array]:
    """The columns in the rows where all of them have a number, of these rows the first that are looked at."""
    known = np.logical_and.reduce([np.isfinite(values) for values in columns])
    return [values[known][:LOOKED_AT] for values in columns]


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


def takes_both_signs(values: Array) -> bool:
    """Whether some numbers lie above zero and some below."""
    return bool(np.any(values < 0.0) and np.any(values > 0.0))


def reads_about_a_zero(values: Array, *, is_of_a_converter: bool) -> bool:
    """Whether large numbers swing about one of them: 2048 is no torque, but no load to a converter.

    Args:
        values: shape (n,).
        is_of_a_converter: whether they surely are of a converter, which gives no negative number: of a load of both
            signs most numbers lie in the middle of their range from 0 on.
    """
    known = values[np.isfinite(values)]
    if not known.size:
        return False
    if is_of_a_converter and known.min() >= 0.0 and np.median(known) > _IN_THE_MIDDLE * known.max():
        return True
    least = float(np.min(np.abs(known)))
    return least >= _LEAST_ZERO and float(np.ptp(known)) < _SWING * least

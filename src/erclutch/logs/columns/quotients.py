"""A column may be made of others: a coefficient of friction of two forces, the slip of an electric machine of a speed.

The coefficient tells which force rubs and which presses. A machine that would turn at n0 and turns at n has the slip
1 - n / n0: the number of a table, and no speed of a fluid.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import permutations

import numpy as np

from erclutch.logs.columns.seen_columns import NO_UNITS, SeenColumn, SeenColumns
from erclutch.logs.columns.shapes import FEW, LOOKED_AT, known_rows
from erclutch.logs.columns.vocabulary import set_of
from erclutch.signals.array import Array

#: Words of a coefficient of friction, and the Chinese, Japanese and Korean ends of its name.
_FRICTION = set_of(
    "cof friction traction mu reibwert reibzahl reibungszahl reibungskoeffizient reibkoeffizient frottement friccion "
    "rozamiento atrito attrito трения tarcia treni wrijving surtunme"
)
_EASTERN_COEFFICIENT = re.compile("摩擦(?:系数|係数|因数|因子)|마찰 ?계수")
_COEFFICIENT = set_of("cof mu coefficient reibwert reibungszahl")
_MOST_PARTS = 12  # columns with a unit, among whose quotients none is by chance a column
_DIGITS = 0.05  # of its spread, by which a quotient that was written with some digits is off
_QUARTERS = (0.25, 0.5, 0.75)
_WHOLE_SLIPS = (1.0, 100.0)  # at rest, as a share and in percent
#: Share of the speed without load by which speeds that are written with some digits are off.
_DIGITS_OF_SPEED = 2e-3
_ABOUT = 0.1  # of a smoothed quotient, by which it differs from the quotient at its quartiles


def rubbing_force(seen: SeenColumns) -> str:
    """The force over the normal force in a column that is called a coefficient of friction; "" where there is none.

    A smoothed coefficient is no quotient row by row, but it is as large as that of one pair of forces, and of no other.
    """
    forces = [column for column in seen.columns.values() if column.unit and column.fits(("N",))]
    for column in seen.columns.values():
        is_called_so = column.spoken.says(_FRICTION) or _EASTERN_COEFFICIENT.search(column.name)
        if not is_called_so or column.unit not in (None, *NO_UNITS):
            continue
        parts = quotient_of(seen, column)
        if parts is not None:
            rubbing, _ = parts
            return rubbing
        if len(forces) > _MOST_PARTS:
            continue
        as_large: list[str] = []
        for rubbing, pressing in permutations(forces, 2):
            top, bottom, values = rubbing.values, pressing.values, column.values
            known = np.isfinite(values) & np.isfinite(top) & np.isfinite(bottom) & (bottom != 0.0)
            if np.count_nonzero(known) < FEW:
                continue
            with np.errstate(over="ignore"):
                quotient = np.abs(top[known] / bottom[known])
            # In the median, and where it is large and small.
            share = np.quantile(np.abs(values[known]), _QUARTERS)
            made = np.quantile(quotient, _QUARTERS)
            if np.all(share > 0.0) and np.all(np.abs(made - share) <= _ABOUT * share):
                as_large.append(rubbing.name)
        if len(as_large) == 1:
            return as_large[0]
    return ""


def pressing_loads(seen: SeenColumns, signal: str) -> list[str]:
    """Loads that press: beside a coefficient of friction they are no effort, but the one that rubs by its numbers."""
    if signal != "effort":
        return []
    has_coefficient = False
    loads: list[str] = []
    for column in seen.columns.values():
        words = column.spoken.stem_words
        if column.unit in (None, *NO_UNITS) and not _COEFFICIENT.isdisjoint(words):
            has_coefficient = True
        if column.unit and column.fits(("N",)) and "load" in words:
            loads.append(column.name)
    if not has_coefficient or not loads:
        return []
    rubbing = rubbing_force(seen)
    return [name for name in loads if name != rubbing]


def quotient_of(seen: SeenColumns, column: SeenColumn) -> tuple[str, str] | None:
    """The two columns of one kind whose quotient a column is, as a coefficient of friction is; None: it is none."""
    if len(seen.measured) > _MOST_PARTS + 1:
        return None
    measured = [other for other in seen.measured if other.name != column.name]
    if len(measured) > _MOST_PARTS:
        return None
    for top, bottom in permutations(measured, 2):
        are_of_one_kind = top.written_unit == bottom.written_unit
        if are_of_one_kind and _is_quotient(column.values, top.values, bottom.values):
            return top.name, bottom.name
    return None


def _is_quotient(column: Array, top: Array, bottom: Array) -> bool:
    """Whether a column is one column over another, as a share or in percent, in each row up to its digits.

    Signs are passed over: a coefficient of friction has none.
    """
    known = np.isfinite(column) & np.isfinite(top) & np.isfinite(bottom) & (bottom != 0.0)
    share = np.abs(column[known][:LOOKED_AT])
    above = np.abs(top[known][:LOOKED_AT])
    below = np.abs(bottom[known][:LOOKED_AT])
    if share.size < FEW or np.std(share) == 0.0:
        return False
    allowed = _DIGITS * np.std(share)
    for whole in (1.0, 100.0):  # a share, or percent
        with np.errstate(over="ignore"):
            off = np.abs(share - whole * above / below)
        if np.median(off) <= allowed:
            return True
    return False


def speeds_of_machine(slip: SeenColumn, columns: Iterable[SeenColumn]) -> list[str]:
    """The columns of speeds whose share a column called slip is; none where it is a speed of its own."""
    if slip.unit not in (None, *NO_UNITS):
        return []
    speeds: list[str] = []
    for column in columns:
        is_called_a_speed = column is not slip and column.spoken.forms["slip"]
        if is_called_a_speed and _is_share_of(slip.values, column.values):
            speeds.append(column.name)
    return speeds


def _is_share_of(slip: Array, speed: Array) -> bool:
    """Whether a slip is what a speed lacks of some speed without load, in every row."""
    share, turns = known_rows(slip, speed)
    if share.size < FEW or np.ptp(share) == 0.0:
        return False
    for whole in _WHOLE_SLIPS:
        left = 1.0 - share / whole  # of the speed without load
        square = float(left @ left)
        if square == 0.0:
            continue
        without_load = float(left @ turns) / square
        if abs(without_load - whole) <= _ABOUT * whole:
            continue  # of a shaft at 100 rad/s a clutch that slips by s turns at 100 - s: share and slip are one number
        digits = _DIGITS_OF_SPEED * abs(without_load)
        if np.ptp(turns) <= 10.0 * digits:
            continue  # a speed that changes by no more than its digits is any share's
        off = np.abs(turns - without_load * left)
        if off.max() <= digits:
            return True
    return False

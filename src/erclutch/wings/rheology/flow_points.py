"""The points of a flow curve: which rows of its table hold one, in SI units, and which of these are noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError
from erclutch.logs.table import Table
from erclutch.signals.array import Array, Mask
from erclutch.signals.percent import percent
from erclutch.wings.rheology.flow_plan import CurvePlan, oscillation

#: What instruments write for a point that they could not measure.
_SENTINELS = (-9999.0, -999.0, -99.0, 9999.0, 99999.0, 999999.0)
FEWEST_RATES = 3  # that tell three parameters
_NEXT_RATE = 0.02  # of log10(rate): two rates further apart are two
_ON_THE_WAY = 0.005  # of the points: fewer at one rate are a motor's way to another
_MOST_ON_THE_WAY = 0.05  # of the points
_LARGEST = 1e100  # of a shear rate in 1/s and of a stress in Pa: beyond any fluid, and its square is a number
_FEW_POINTS = 5  # of which one with a wrong sign is an oversight
_STEADY = 0.1  # of its last stress, by which a step of one rate may begin off it
_FAINT = 0.02  # of the largest stress: a stress of the wrong sign below it is noise
#: ln of the ratio of two stresses at one rate: so far apart two runs of one fluid may be.
ONE_FLUID = 0.15
RESTING = 1e-3  # of the largest rate: a rate below it is noise about a rest


@dataclass
class _Points:
    """Points of one curve, and what was left out on the way.

    Attributes:
        rate: in 1/s, shape (n,).
        stress: in Pa, shape (n,).
        rows: of the table, counted from 0, shape (n,).
        notes: one sentence each.
    """

    rate: Array
    stress: Array
    rows: NDArray[np.intp]
    notes: list[str]

    @property
    def against(self) -> Mask:
        """Points whose stress does not go along with their rate."""
        return np.sign(self.rate) != np.sign(self.stress)

    def leave_out(self, points: Mask) -> None:
        """Keep the other points."""
        self.rate = self.rate[~points]
        self.stress = self.stress[~points]
        self.rows = self.rows[~points]

    def leave_noise_out(self) -> None:
        """Leave out points that are noise about a rest, or below what the instrument resolves."""
        against = self.against
        size = np.abs(self.stress)
        is_faint = against & (size < _FAINT * float(size.max(initial=0.0)))

        speed = np.abs(self.rate)
        usual_sign = np.sign(np.sign(self.rate).sum())
        turns_back = np.sign(self.rate) != usual_sign
        is_about_rest = against & turns_back & (speed < RESTING * speed.max(initial=0.0))
        tells_more = is_about_rest.any() and not is_faint[is_about_rest].all()
        if tells_more and 2 * int(against.sum()) <= against.size:
            # Noise about a rest has both signs, so what has the sign of its stress by chance is noise as well.
            noise = float(speed[is_about_rest].max())  # [1/s]
            is_noise = speed <= noise
            left_out = f"{int(is_noise.sum())} points left out: a rate of {noise:.3g} 1/s or less"
            turned = f"{int(is_about_rest.sum())} have the other sign than their stress, as noise about a rest has"
            self.notes.append(f"{left_out}, where {turned}")
            self.leave_out(is_noise)
            is_faint = is_faint[~is_noise]

        # At the lowest rates a fluid of low viscosity is below what an instrument resolves: the sign is noise.
        if is_faint.any() and 2 * int(self.against.sum()) <= self.rate.size:
            left_out = (
                f"{int(is_faint.sum())} points left out: a stress of the other sign than its rate"
            )
            self.notes.append(
                f"{left_out}, below {percent(_FAINT)} of the largest stress, as noise is"
            )
            self.leave_out(is_faint)

    def way_back_over_way_there(self) -> float:
        """The median ratio of the stresses of a loop at the same rates; 1 where the rates are no way there and back.

        The loop of a thixotropic fluid is wide: a law through both of its ways is none of the fluid's states.
        """
        highest = int(np.argmax(self.rate))
        lowest = int(np.argmin(self.rate))
        for turn, sign in ((highest, 1.0), (lowest, -1.0)):
            there = np.log(self.rate[: turn + 1])
            back = np.log(self.rate[turn:])
            if min(there.size, back.size) < FEWEST_RATES:
                continue
            goes_there = np.all(sign * np.diff(there) >= 0)
            comes_back = np.all(sign * np.diff(back) <= 0)
            if not goes_there or not comes_back:
                continue
            order = np.argsort(there)
            stress_there = np.log(self.stress[: turn + 1])
            stress_back = np.log(self.stress[turn:])
            is_common = (back >= there.min()) & (back <= there.max())
            at_same_rates = np.interp(back[is_common], there[order], stress_there[order])
            return float(np.exp(np.median(stress_back[is_common] - at_same_rates)))
        return 1.0


def points_of(
    curve: CurvePlan,
    table: Table,
    label: str,
) -> tuple[Array, Array, list[str]]:
    """Shear rates in 1/s and stresses in Pa of the points that can be used, each shape (n,), and what was left out.

    Args:
        curve: which columns of the table it is.
        table: as read.
        label: of the curve, for errors.

    Raises:
        LogError: no row holds a point, a number is beyond what fluids have, or a stress goes against its rate by more
            than noise.
    """
    is_point, notes = _rows_that_hold_a_point(curve, table)
    if not is_point.any():
        problem = "no point has a shear rate and a shear stress"
        raise LogError(problem, where=f"{table.name}, {label}", remedy="Check the columns")

    rate = table.columns[curve.rate.name][is_point] * curve.rate.factor  # [1/s]
    # Stresses, or viscosities; in Pa and Pa s, unless nobody says the unit.
    unit = curve.stress_unit
    stress = table.columns[curve.stress.name][is_point] * curve.stress.factor
    if curve.times_rate:
        # Viscosities that are all positive are magnitudes, so their stresses are magnitudes too.
        are_magnitudes = (stress > 0).all()
        stress = stress * (np.abs(rate) if are_magnitudes else rate)  # [unit]
    where = f"{table.name}, {label}"
    # What no fluid has and no fit can square is the mark of a cell that was not measured, or the like.
    beyond = np.flatnonzero(~(np.abs(rate) < _LARGEST) | ~(np.abs(stress) < _LARGEST))
    if beyond.size:
        first = int(beyond[0])
        pair = f"the shear rate {rate[first]:g} 1/s and the stress {stress[first]:g} {unit}"
        problem = f"row {int(np.flatnonzero(is_point)[first]) + 1} of the table has {pair}"
        raise LogError(problem, where=where, remedy="Correct the cell, or remove the row")
    turned = (rate < 0) & (stress < 0)
    if turned.any():
        notes.append(f"{int(turned.sum())} points turn the other way: magnitudes are taken")
        rate = np.where(turned, -rate, rate)
        stress = np.where(turned, -stress, stress)
    if curve.times_rate:
        rate = np.abs(rate)
    points = _Points(rate, stress, np.flatnonzero(is_point), notes)
    points.leave_noise_out()
    against = points.against
    count = points.rate.size
    if count > _FEW_POINTS and 2 * int(against.sum()) > count:
        problem = f"{int(against.sum())} of {count} points have no stress along their rate, as no fluid that flows has"
        raise LogError(problem, where=where, remedy="Give a test in steady rotation")
    if against.any():
        first = int(np.argmax(against))
        pair = f"the shear rate {points.rate[first]:g} 1/s and the stress {points.stress[first]:g} {unit}"
        problem = f"row {int(points.rows[first]) + 1} of the table has {pair}"
        raise LogError(problem, where=where, remedy="Remove the point, or give magnitudes")

    held = rates_held(points.rate)
    if held < FEWEST_RATES:
        notes.append(f"the points have {held} shear rates, which tell no more parameters of a law")
    # How far off its last stress a step of one rate begins, in the median, as a share.
    log_steps = np.abs(np.diff(np.log10(points.rate)))
    starts, ends = parts_between(log_steps > _NEXT_RATE)
    is_held = ends - starts >= _FEW_POINTS
    change = 0.0
    if np.count_nonzero(is_held) >= FEWEST_RATES:
        first_stress = points.stress[starts[is_held]]
        last_stress = points.stress[ends[is_held] - 1]
        change = float(np.median(np.abs(first_stress / last_stress - 1.0)))
    if change > _STEADY:
        notes.append(
            f"the stress changes by {percent(change)} while a rate is held: points before it is steady are fitted too"
        )
    steps = np.diff(points.rate)
    if np.any(steps > 0) and np.any(steps < 0):
        both_ways = "the rate rises and falls: both sweeps are fitted as one curve"
        ratio = points.way_back_over_way_there()
        if abs(np.log(ratio)) > ONE_FLUID:
            both_ways += f", though the way back has {ratio:.2g} times the stress of the way there"
        notes.append(both_ways)
    return points.rate, points.stress, notes


def parts_between(is_gap: Mask) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The first place of each part of values between gaps, and the place behind its last, each shape (parts,).

    Args:
        is_gap: whether a gap stands behind a value, shape (values - 1,).
    """
    starts = np.append(0, np.flatnonzero(is_gap) + 1)
    ends = np.append(starts[1:], is_gap.size + 1)
    return starts, ends


def rates_held(rate: Array) -> int:
    """How many rates above 0 the points have; of very many points those do not count that a motor had on its way."""
    log_rate = np.sort(np.log10(rate))
    starts, ends = parts_between(np.diff(log_rate) > _NEXT_RATE)
    counts = ends - starts
    is_on_the_way = counts <= _ON_THE_WAY * rate.size
    if counts[is_on_the_way].sum() > _MOST_ON_THE_WAY * rate.size:
        is_on_the_way = np.zeros_like(is_on_the_way)  # each point has a rate of its own
    widths = log_rate[ends - 1] - log_rate[starts]
    rates_in_each = 1 + (widths / _NEXT_RATE).astype(np.intp)  # a ramp has no gaps
    return int(rates_in_each[~is_on_the_way].sum())


def _rows_that_hold_a_point(curve: CurvePlan, table: Table) -> tuple[Mask, list[str]]:
    """Rows with a rate and a stress that were measured in rotation, shape (n,), and what is said of the others."""
    rate = table.columns[curve.rate.name]
    stress = table.columns[curve.stress.name]
    is_empty = np.isnan(rate) & np.isnan(stress)
    is_half = np.isnan(rate) ^ np.isnan(stress)
    if is_half.any() and curve.is_labelled and curve.label == f"{rate[0]:g}":
        # The labels of pairs that are numbers stand in the first row, without a stress.
        is_half[0] = False
        is_empty[0] = True
    is_sentinel = np.isin(rate, _SENTINELS) | np.isin(stress, _SENTINELS)
    is_at_rest = (rate == 0) & ~is_sentinel

    swings, marks = oscillation(table)
    if swings.all():  # then the marks tell nothing apart
        swings = np.zeros_like(swings)
    swings = swings & ~is_empty & ~is_half & ~is_sentinel & ~is_at_rest

    notes: list[str] = []
    filled = int((~is_empty).sum())
    for left_out, why in (
        (swings, f"in oscillation ({', '.join(marks[:3])})"),
        (is_half, "without a rate or without a stress"),
        (is_sentinel, "with a number that instruments write where they measured nothing"),
        (is_at_rest & ~is_half, "at rest, which a logarithm has no place for"),
    ):
        if left_out.any():
            notes.append(f"{int(left_out.sum())} of {filled} points left out: {why}")
    return ~(is_empty | is_half | is_sentinel | is_at_rest | swings), notes

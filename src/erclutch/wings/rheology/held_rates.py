"""Tests that are no flow curve since they hold their rate or their stress: holds, creeps, start-ups, steps."""

from __future__ import annotations

import re

import numpy as np

from erclutch.errors import MappingError, shell_word
from erclutch.logs.columns.rheometer_units import unit_or_end
from erclutch.logs.table import Table
from erclutch.signals.array import Array
from erclutch.wings.rheology.flow_plan import FlowPlan
from erclutch.wings.rheology.flow_points import FEWEST_RATES, RESTING, rates_held

_HOLDS = re.compile(
    r"(peak hold|creep(?: recovery)?|stress (?:relaxation|growth))(?: ?-? ?\d+)?", re.IGNORECASE
)
_SECONDS = ("s", "ms", "min", "h")
ONE_RATE = 1.2  # times the lowest rate: what stays below is measured at one rate
#: Times the lowest stress: what stays below was controlled, as no fluid keeps its stress.
_ONE_STRESS = 1.002
_FEWEST_STRESSES = 5  # points
_MOST_OF_A_TEST = 0.95  # of its time: a motor reaches its rate within the rest


def require_no_hold(test: str) -> None:
    """Refuse a test by the name that TRIOS gives a procedure: a peak hold whose sample breaks changes its rate too.

    Raises:
        MappingError: the whole name is that of a hold, but for a number behind it.
    """
    match = _HOLDS.fullmatch(test.strip())
    if match is not None:
        problem = f"the test is a {match[1].lower()}, which holds its rate, stress or strain and is no flow curve"
        this_one = f"--sheet {shell_word(test)}"
        remedy = f"Give a test with several rates, or take this one by {this_one}"
        raise MappingError(problem, remedy=remedy, answers=[this_one])


def require_several_rates(plan: FlowPlan, table: Table) -> None:
    """Refuse a test at one shear rate or stress, or at two rates: a hold, a creep, a start-up, a recovery at rest.

    Raises:
        MappingError: all its curves have points, and all points one rate or one stress, or a motor brought them there;
            or all points have one of two rates, as tests of a structure that recovers have.
    """
    rates = [np.abs(table.columns[curve.rate.name]) for curve in plan.curves]
    turning = [rate[np.isfinite(rate) & (rate > 0)] for rate in rates]
    unit = plan.curves[0].rate.unit
    if all(rate.size > 1 and rate.max() <= ONE_RATE * rate.min() for rate in turning):
        ends = f"{turning[0].min():.4g} to {turning[0].max():.4g} {unit}"
        problem = f"all points have the shear rate {ends}, which is no flow curve"
        raise MappingError(problem, where=table.name, remedy="Give a test with several rates")

    # The time of each row, in any unit; the number of the row where no column rises as a time does.
    times: Array = np.arange(table.rows, dtype=np.float64)
    for name, values in table.columns.items():
        if unit_or_end(table, name) in _SECONDS and np.all(np.diff(values) > 0):
            times = values
            break
    on_the_way = [_points_before_the_hold(rate, times) for rate in rates]
    if all(on_the_way):
        points = "1 point" if on_the_way[0] == 1 else f"{on_the_way[0]} points"
        held_rate = f"{rates[0][-1]:.4g} {unit}"
        what = "a start-up or a step of the rate, which is no flow curve"
        problem = f"after {points} all others have the shear rate {held_rate}: {what}"
        raise MappingError(problem, where=table.name, remedy="Give a test with several rates")

    if all(rate.size and rates_held(rate) < FEWEST_RATES for rate in turning):
        ends = f"{turning[0].min():.4g} and {turning[0].max():.4g} {unit}"
        problem = f"all points have one of two shear rates, {ends}, which is no flow curve"
        raise MappingError(
            problem, where=table.name, remedy="Give a test with three shear rates or more"
        )

    if any(curve.times_rate for curve in plan.curves):
        return
    all_are_held = True
    for curve in plan.curves:
        stress = np.abs(table.columns[curve.stress.name])
        stress = stress[np.isfinite(stress) & (stress > 0)]
        is_held = stress.size > _FEWEST_STRESSES and stress.max() <= _ONE_STRESS * stress.min()
        all_are_held = all_are_held and is_held
    if all_are_held:
        first = plan.curves[0].stress
        stress = np.abs(table.columns[first.name])
        held_stress = stress[np.isfinite(stress) & (stress > 0)][0]
        problem = f"all points have the shear stress {held_stress:.4g} {first.unit}, which is no flow curve"
        raise MappingError(
            problem, where=table.name, remedy="Give a test with several stresses; this is a creep"
        )


def _points_before_the_hold(rate: Array, times: Array) -> int:
    """How many points stand before a hold that takes nearly all of a test's time, up to its end; 0 where none does.

    A sweep that ends in a hold takes a good part of its time; a motor that is switched on does not.
    """
    known = np.isfinite(rate) & np.isfinite(times)
    rate = rate[known]
    times = times[known]
    if rate.size < 2:
        return 0
    held_rate = float(np.median(rate[-(rate.size // 4 + 1) :]))
    if held_rate <= RESTING * rate.max():
        return 0  # a motor that is switched off
    is_off = np.maximum(rate, held_rate) > ONE_RATE * np.minimum(rate, held_rate)
    if not is_off.any() or is_off[-1]:
        return 0
    first_held = int(np.flatnonzero(is_off)[-1]) + 1
    share = (times[-1] - times[first_held]) / (times[-1] - times[0])
    return first_held if share >= _MOST_OF_A_TEST else 0

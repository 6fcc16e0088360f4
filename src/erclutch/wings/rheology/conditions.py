"""A table may hold a flow curve at each of several conditions: fields, temperatures, concentrations.

The condition stands in a column of its own, which keeps a level while the rate runs through its range. The points of
each level are a curve; fitted as one, they would give a curve that no fluid has.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import MappingError, UnitError, listed, shell_word
from erclutch.logs.columns.labels import without_unit
from erclutch.logs.columns.rheometer_names import plain_name, said_by_name
from erclutch.logs.columns.rheometer_units import unit_or_end
from erclutch.logs.log_file import EACH
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array, Mask
from erclutch.signals.recording import SI_UNITS_OF_FIELDS
from erclutch.wings.rheology.flow_plan import FlowPlan
from erclutch.wings.rheology.flow_points import ONE_FLUID, parts_between
from erclutch.wings.rheology.held_rates import ONE_RATE

_TEMPERATURE = re.compile(r"\btemp|温度|온도|температур")
#: What is set before a flow curve is taken, in units that other columns have too.
_SET_BY_HAND = re.compile(
    r"\bgap\b|\bspalt|entrefer|concentrat|konzentration|\bconc\b|fraction|content|dosage"
    r"|loading|\bwt\b|\bvol ?%|\bphi\b|\bage\b|浓度|濃度|含量|концентрац"
)
_MOST_LEVELS = 50  # that are the same number in all their rows
_MOST_GROUPS = 20  # of measured levels
_APART = 0.05  # of the range, by which measured levels are apart at least
_WIDEST = 0.02  # of the range, which a measured level spans at most
#: Share of its level by which a regulated temperature wanders and is one level all the same.
_WOBBLE = 0.01
_STEADY = 0.5  # K: a regulated temperature wanders by less
_WIDEST_IN_KELVIN = 3.0  # which one regulated temperature spans at most
RATES_OF_A_SWEEP = 3  # at least
_ANEW = 0.5  # of the range of ln(rate): a larger step back begins another sweep
_ONE_WAY = 0.8  # mean sign of the steps of a sweep, at least
_FEWEST_STEPS = 10  # of a level, and rows without: for the changes of the stress to be compared
_OFTEN = 0.25  # share of the rows before which a level steps that wobbles, at least
_MOVED = 3.0  # times the usual change of the stress: more where a level tells
_UNMOVED = 1.5  # times the usual change of the stress: at most so much where a level means nothing
_SAME_RATE = 0.02  # ln of the ratio of two rates that are meant to be the same


@dataclass(frozen=True)
class Condition:
    """The points of one condition.

    Attributes:
        label: such as ``Current 0.5 A``; "" where the whole table is one condition.
        table: its points.
        columns: that part the points.
    """

    label: str
    table: Table
    columns: tuple[str, ...] = ()


def conditions_of(table: Table, plan: FlowPlan, *, parted: bool = False) -> list[Condition]:
    """The points of each condition; the table alone where it holds one.

    Args:
        table: of flow curves.
        plan: which of its columns are rates and stresses.
        parted: whether the user said which rows are a curve; then no column of an unknown meaning is asked about.

    Raises:
        MappingError: a column of an unknown meaning parts the points so: the user knows whether each of its numbers is
            a condition. Levels that scatter were measured, so they are conditions.
    """
    parting = _parting(table, plan)
    for name in _of_unknown_meaning(table, parting):
        if parted:
            del parting[name]
            continue
        lowest = table.columns[name][parting[name] == 0][0]
        each = f"--sheet {shell_word(f'{name}={EACH}')}"
        one = f"--sheet {shell_word(f'{name}={lowest:.15g}')}"
        problem = (
            f"column {name} parts the points into {parting[name].max() + 1} sweeps of the rate"
        )
        remedy = f"Take each as a curve: {each}; or one: {one}"
        raise MappingError(problem, where=table.name, remedy=remedy, answers=[each, one])
    if not parting:
        return _sweeps(table, plan)

    names = list(parting)
    # Shape (rows, parting columns).
    levels_of_rows = np.column_stack([parting[name] for name in names])
    known = np.all(levels_of_rows >= 0, axis=1)
    conditions: list[Condition] = []
    for levels in np.unique(levels_of_rows[known], axis=0):
        rows = np.all(levels_of_rows == levels, axis=1)
        words: list[str] = []
        for name in names:
            level = float(np.nanmedian(table.columns[name][rows]))
            unit = table.units.get(name)
            # ``I 500 mA`` for a column I_mA, not ``I_mA 500 mA``.
            words.append(f"{without_unit(name, unit)} {level:.4g} {unit or ''}".rstrip())
        conditions.append(Condition(", ".join(words), _rows_of(table, rows), tuple(names)))
    return conditions


def _sweeps(table: Table, plan: FlowPlan) -> list[Condition]:
    """Sweeps of a table whose rate begins anew, if they are of two fluids or states; else the table alone.

    A way up and a way down are one curve. So are two ways up with the same stresses, unless a blank line parts them.
    """
    whole = [Condition("", table)]
    curve = plan.curves[0]
    rate = np.abs(table.columns[curve.rate.name])
    rows = np.flatnonzero(np.isfinite(rate) & (rate > 0))
    log_rate = np.log(rate[rows])
    steps = np.diff(log_rate)
    if not steps.size:
        return whole
    anew = np.abs(steps) > _ANEW * np.ptp(log_rate)
    turns = np.flatnonzero(anew & (np.sign(steps) != np.sign(np.median(steps)))) + 1
    if not turns.size:
        return whole

    starts = [0, *rows[turns].tolist()]
    sweeps = [np.arange(start, end) for start, end in pairwise([*starts, table.rows])]
    for sweep in sweeps:
        own = rate[sweep]
        own = own[np.isfinite(own) & (own > 0)]
        if np.unique(own).size <= RATES_OF_A_SWEEP:
            return whole
        mean_sign = float(np.sign(np.diff(own)).mean())  # 1 or -1: all steps go up, or down
        if abs(mean_sign) < _ONE_WAY:
            return whole  # such as a course in time, with noise about a rest

    are_parted = all(
        any(before < line <= start for line in table.breaks) for before, start in pairwise(starts)
    )
    differ = any(_differ(table, plan, first, second) for first, second in pairwise(sweeps))
    if not are_parted and not differ:
        return whole
    return [
        Condition(f"sweep {number}", _rows_of(table, sweep))
        for number, sweep in enumerate(sweeps, start=1)
    ]


def _differ(
    table: Table, plan: FlowPlan, first: NDArray[np.intp], second: NDArray[np.intp]
) -> bool:
    """Whether the stresses of two sweeps, as rows, are apart by more than one fluid's are at the same rates."""
    for curve in plan.curves:
        # ln(rate), ln(stress or viscosity), sorted by the rate.
        points: list[tuple[Array, Array]] = []
        for rows in (first, second):
            rate = np.abs(table.columns[curve.rate.name][rows])
            value = np.abs(table.columns[curve.stress.name][rows])
            known = np.isfinite(rate) & np.isfinite(value) & (rate > 0) & (value > 0)
            order = np.argsort(rate[known], kind="stable")
            points.append((np.log(rate[known][order]), np.log(value[known][order])))
        (rate_of_first, first_values), (rate_of_second, second_values) = points
        if not rate_of_first.size or not rate_of_second.size:
            continue
        common = (rate_of_second >= rate_of_first[0]) & (rate_of_second <= rate_of_first[-1])
        if not common.any():
            continue
        at_same_rates = np.interp(rate_of_second[common], rate_of_first, first_values)
        apart = np.abs(second_values[common] - at_same_rates)
        if float(np.median(apart)) > ONE_FLUID:
            return True
    return False


def _rows_of(table: Table, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Table:
    """Some rows of a table."""
    return replace(
        table,
        columns={name: values[rows] for name, values in table.columns.items()},
        clock=None if table.clock is None else table.clock[rows],
        breaks=(),
        words={},
    )


def asked_about(table: Table, plan: FlowPlan) -> list[str]:
    """Columns of an unknown meaning that part the points by set numbers: whether they are conditions is asked."""
    return _of_unknown_meaning(table, _parting(table, plan))


def _of_unknown_meaning(table: Table, parting: Mapping[str, NDArray[np.intp]]) -> list[str]:
    """Columns whose set numbers may be conditions: neither name nor unit tells."""
    asked: list[str] = []
    for name, levels in parting.items():
        if _is_set(table.columns[name], levels) and _meaning(table, name) == "unknown":
            asked.append(name)
    return asked


def _parting(table: Table, plan: FlowPlan) -> dict[str, NDArray[np.intp]]:
    """The columns that part the points into sweeps over the same rates, with the level of each row, shape (n,)."""
    used = {column.name for curve in plan.curves for column in (curve.rate, curve.stress)}
    rates = [table.columns[curve.rate.name] for curve in plan.curves]
    parting: dict[str, NDArray[np.intp]] = {}
    for name, values in table.columns.items():
        meaning = _meaning(table, name)
        if name in used or meaning == "no condition":
            continue
        unit = unit_or_end(table, name)
        is_temperature = meaning == "condition" and unit is not None and units.is_temperature(unit)
        levels = levels_of(values, _STEADY if is_temperature else 0.0)
        if levels is None:
            continue
        if meaning == "condition" and unit is None and not _is_set(values, levels):
            # A measured temperature without a unit may wander, by less than its levels are apart.
            at_levels = [values[levels == level] for level in range(int(levels.max()) + 1)]
            between = [after.min() - before.max() for before, after in pairwise(at_levels)]
            if min(between) <= _WIDEST_IN_KELVIN:
                continue
        if not any(_repeats_the_sweep(levels, rate) for rate in rates):
            continue
        stresses = [table.columns[curve.stress.name] for curve in plan.curves]
        moves_the_stress = any(map(_moves, [levels] * len(rates), rates, stresses))
        if all(_flickers(levels, rate) for rate in rates) and not moves_the_stress:
            continue  # such as 0 and 0.0001 T by turns, where the last digit of a sensor wobbles
        if meaning == "unknown" and all(_wobbles(levels, stress) for stress in stresses):
            continue
        if meaning == "unknown":
            known = values[np.isfinite(values)]
            are_whole = bool(np.all(known == np.round(known)))
            steps = [np.diff(np.abs(rate[np.isfinite(rate)])) for rate in rates]
            goes_one_way = all(
                each.size > 0 and (np.all(each > 0) or np.all(each < 0)) for each in steps
            )
            if goes_one_way and not moves_the_stress:
                continue  # one sweep: such as the number of repetitions of each point
            if are_whole and not _is_set(values, levels):
                continue  # counted and not measured, such as the first row of each step in another table
        parting[name] = levels
    return parting


def conditions_note(conditions: Sequence[Condition]) -> str:
    """What is said of a table that holds several conditions."""
    return f"a curve for each of {len(conditions)} conditions: {listed([each.label for each in conditions], 8)}"


def levels_of(values: Array, steady: float = 0.0) -> NDArray[np.intp] | None:
    """The number of the level of each row, from the lowest on, shape (n,), -1 without a value; None without levels.

    A set value is the same number in all rows of a level. A measured one scatters: its levels are far apart.

    Args:
        values: shape (n,).
        steady: two values less apart than this are of one level.
    """
    known = np.isfinite(values)
    distinct = np.unique(values[known])
    gaps = np.diff(distinct)
    if steady > 0.0 and np.any(gaps < steady):
        lowest, widest = _groups(distinct, gaps >= steady)
        if lowest.size < 2 or widest > _WIDEST_IN_KELVIN:
            return None  # one level, or a temperature that creeps
    elif distinct.size < 2 or np.ptp(distinct) <= _WOBBLE * np.abs(distinct).max():
        return None
    elif distinct.size > _MOST_LEVELS or RATES_OF_A_SWEEP * distinct.size > np.count_nonzero(known):
        span = distinct[-1] - distinct[0]
        lowest, widest = _groups(distinct, gaps > _APART * span)
        if not 1 < lowest.size <= _MOST_GROUPS or widest > _WIDEST * span:
            return None
    else:
        lowest = distinct
    levels = np.searchsorted(lowest, values, side="right") - 1
    return np.where(known, levels, -1)


def _groups(distinct: Array, is_gap: Mask) -> tuple[Array, float]:
    """The lowest value of each group of values, which gaps part, and how far the widest group goes.

    Args:
        distinct: rising, shape (n,).
        is_gap: whether a gap stands behind a value, shape (n - 1,).
    """
    starts, ends = parts_between(is_gap)
    widths = distinct[ends - 1] - distinct[starts]
    return distinct[starts], float(widths.max())


def _is_set(values: Array, levels: NDArray[np.intp]) -> bool:
    """Whether each level is one number: measured levels scatter."""
    return np.unique(values[levels >= 0]).size == levels.max() + 1


def _meaning(table: Table, name: str) -> str:
    """Whether a column is a ``condition`` by its unit, ``unknown``, or surely ``no condition``: a time, a count."""
    unit = unit_or_end(table, name)
    if _SET_BY_HAND.search(plain_name(name)):
        return "unknown"
    try:
        is_set = unit is not None and (
            units.is_temperature(unit) or units.fits(unit, SI_UNITS_OF_FIELDS)
        )
    except UnitError:
        # Such as a pressure in PSIg, which nobody sets: a rheometer measured it.
        return "no condition"
    if is_set:
        return "condition"
    if not unit and _TEMPERATURE.search(plain_name(name)):
        return "condition"
    if not unit and said_by_name(name) == "unknown":
        return "unknown"
    return "no condition"


def _repeats_the_sweep(levels: NDArray[np.intp], rate: Array) -> bool:
    """Whether the rate runs through the same range at several levels, and sweeps at half of all levels or more."""
    sweeps: list[tuple[float, float]] = []
    count = int(levels.max()) + 1
    for level in range(count):
        at_level = np.abs(rate[(levels == level) & np.isfinite(rate)])
        if np.unique(at_level).size < RATES_OF_A_SWEEP:
            continue
        lowest = float(at_level.min())
        highest = float(at_level.max())
        if highest > ONE_RATE * lowest:
            sweeps.append((lowest, highest))
    return overlap(sweeps) and 2 * len(sweeps) >= count


def overlap(ranges: Iterable[tuple[float, float]]) -> bool:
    """Whether two of some ranges, each from its lowest number to its largest, have more than an end in common."""
    return any(low < high_before for (_, high_before), (low, _) in pairwise(sorted(ranges)))


def _flickers(levels: NDArray[np.intp], rate: Array) -> bool:
    """Whether the level changes from row to row, and no rate is measured at two levels: a condition would be."""
    known = (levels >= 0) & np.isfinite(rate) & (rate != 0)
    level = levels[known]
    log_rate = np.log(np.abs(rate[known]))
    if 2 * np.count_nonzero(np.diff(level)) < level.size:
        return False
    nearest: list[float] = []  # ln of the ratio to the nearest rate at another level
    for number, own in zip(level, log_rate, strict=True):
        nearest.append(float(np.abs(log_rate[level != number] - own).min(initial=np.inf)))
    return float(np.median(nearest)) > _SAME_RATE


def _moves(levels: NDArray[np.intp], rate: Array, stress: Array) -> bool:
    """Whether the stress jumps where the level steps, by far more than the rate and than between steps."""
    known = (levels >= 0) & np.isfinite(rate) & np.isfinite(stress) & (rate != 0) & (stress != 0)
    is_step = np.diff(levels[known]) != 0
    if is_step.sum() < _FEWEST_STEPS:
        return False
    changes = np.abs(np.diff(np.log(np.abs(stress[known]))))  # ln of the ratio of two rows
    usual = float(np.median(np.abs(np.diff(np.log(np.abs(rate[known]))))[is_step]))
    if (~is_step).sum() >= _FEWEST_STEPS:
        usual = max(usual, float(np.median(changes[~is_step])))
    return float(np.median(changes[is_step])) > _MOVED * usual


def _wobbles(levels: NDArray[np.intp], stress: Array) -> bool:
    """Whether a column steps to and fro between its levels and the stress takes no note of it: a sensor's last digits.

    A condition parts the stresses: where it changes, they jump.
    """
    known = (levels >= 0) & np.isfinite(stress) & (stress != 0)
    is_step = np.diff(levels[known]) != 0
    changes = np.abs(np.diff(np.log(np.abs(stress[known]))))  # ln of the ratio of two rows
    fewest = max(_FEWEST_STEPS, _OFTEN * is_step.size)
    if is_step.sum() < fewest or (~is_step).sum() < _FEWEST_STEPS:
        return False
    usual = float(np.median(changes[~is_step]))
    return float(np.median(changes[is_step])) <= _UNMOVED * usual

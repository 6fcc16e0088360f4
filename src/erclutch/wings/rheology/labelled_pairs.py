"""Pairs of columns with a label over each pair: shear rates, and the stresses or viscosities beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from erclutch.errors import MappingError, UnitError
from erclutch.logs.columns.labels import is_given_by_place
from erclutch.logs.columns.rheometer_names import said_by_name
from erclutch.logs.columns.rheometer_units import said_by_unit, unit_of
from erclutch.logs.table import Table
from erclutch.signals.array import Array
from erclutch.signals.units import parse

#: In place of a unit that nobody says.
UNKNOWN_UNIT = "?"
#: Decades of the stress in a decade of the rate, at most: a fluid that thins or has a yield stress has below 1.
_STEEPEST = 1.2
_SWEPT = 100.0  # the last shear rate of a sweep over the first, at least, where no name says that they are rates


@dataclass(frozen=True)
class FlowColumn:
    """One column of a flow curve.

    Attributes:
        name: in the table.
        unit: by which it is read.
        factor: from that unit to 1/s, Pa or Pa s; 1 for a viscosity whose unit nobody says.
        reason: why the column is taken for its role, as the end of a sentence.
        unit_is_assumed: whether neither the file nor an option says the unit.
    """

    name: str
    unit: str
    factor: float
    reason: str
    unit_is_assumed: bool = False


@dataclass(frozen=True)
class CurvePlan:
    """Where one curve stands in a table.

    Attributes:
        label: what the curve is called.
        rate: its shear rates.
        stress: its shear stresses, or its viscosities.
        times_rate: whether ``stress`` is a viscosity, which becomes a stress by its rate.
        is_labelled: whether ``label`` stands over the rates in place of their name.
    """

    label: str
    rate: FlowColumn
    stress: FlowColumn
    times_rate: bool = False
    is_labelled: bool = False

    @property
    def stress_unit(self) -> str:
        """Of the curve's stresses: Pa, or ``?`` where nobody says the unit of the viscosities that they are made of."""
        return UNKNOWN_UNIT if self.stress.unit == UNKNOWN_UNIT else "Pa"


def labelled_pairs(table: Table, unit: str = "") -> tuple[CurvePlan, ...]:
    """Curves of a file with a label over the rates of each pair and nothing over the stresses; none for others.

    So is a table of two columns that are called X and Y, as a program writes them that reads points off a picture.

    Args:
        table: of the file.
        unit: of the second columns, a stress's or a viscosity's; "": Pa, if they rise with the rate as stresses do;
            where all of several fall, they are viscosities in a unit that nobody says.

    Raises:
        MappingError: a second column falls as the rate grows, as viscosities do, and not all of several fall; or pairs
            have no names at all, and no option gives their unit.
        UnitError: a unit of neither.
    """
    names = list(table.columns)
    if len(names) % 2 or not names:
        return ()
    has_units = any(table.units.values())
    are_axes = [name.lower() for name in names] == ["x", "y"] and not has_units
    if are_axes and _is_steeper_than_flow(*table.columns.values()):
        return ()
    unnamed: list[bool] = []
    for name in names:
        unnamed.append(is_given_by_place(name) and table.units.get(name) is None)
    if not all(unnamed[1::2]) and not are_axes:
        return ()
    over_rates = names[::2]
    labels: list[str] = []
    if are_axes:
        labels = [names[1]]  # a test's only curve is called after the test
    elif all(unnamed):
        labels = _labels_of_nameless_pairs(table, unit)
        if not labels:
            return ()
    else:
        for number, (name, is_unnamed) in enumerate(
            zip(over_rates, unnamed[::2], strict=True), start=1
        ):
            says_by_name = said_by_name(name) != "unknown"
            says_by_unit = said_by_unit(unit_of(table, name)) != "unknown"
            if says_by_name or says_by_unit:
                return ()  # names of columns, and no labels
            labels.append(f"curve {number}" if is_unnamed else name)
    reason = "a label stands over its pair of columns"
    if are_axes:
        reason = "they are called by their axes alone"
    quantity = said_by_unit(unit or "Pa")
    if quantity not in ("stress", "viscosity"):
        raise UnitError(
            f"{unit!r} is no unit of a stress or a viscosity", remedy="Give such as Pa or mPa*s"
        )
    factor = parse(unit or "Pa").factor / parse("Pa").factor
    pairs: list[CurvePlan] = []
    falling = _which_fall(table, over_rates, names[1::2])
    are_viscosities = not unit and len(falling) > 1 and all(falling)
    for label, falls_all_the_way, rates, stresses in zip(
        labels, falling, over_rates, names[1::2], strict=True
    ):
        rate = FlowColumn(rates, "1/s", 1.0, reason)
        stress = FlowColumn(stresses, unit or "Pa", factor, reason)
        if are_viscosities:
            stress = FlowColumn(stresses, UNKNOWN_UNIT, 1.0, reason, unit_is_assumed=True)
        elif not unit and falls_all_the_way:
            falls = "falls as the first grows, as a viscosity does and no shear stress"
            of_pair = "" if are_axes else f"behind {label!r} "
            problem = f"pairs of columns without units: {of_pair}the second {falls}"
            viscosity = "--stress '[mPa*s]'"
            stress_after_all = "--stress '[Pa]'"
            remedy = f"Say its unit, such as {viscosity}, or {stress_after_all} if it is a stress all the same"
            answers = [viscosity, stress_after_all]
            raise MappingError(problem, where=table.name, remedy=remedy, answers=answers)
        times_rate = are_viscosities or quantity == "viscosity"
        pairs.append(CurvePlan(label, rate, stress, times_rate, is_labelled=not are_axes))
    return tuple(pairs)


def _labels_of_nameless_pairs(table: Table, unit: str) -> list[str]:
    """What curves in pairs of columns without names are called; none for other columns.

    Raises:
        MappingError: nothing but the numbers says that they are curves, and no option says in which unit.
    """
    names = list(table.columns)
    # Labels that are numbers, such as volume fractions, stand in the first row of the table.
    first_row = [table.columns[name][0] for name in names]
    numbers = first_row[::2]
    if np.isfinite(numbers).all() and np.isnan(first_row[1::2]).all():
        return [f"{number:g}" for number in numbers]
    if not _are_swept(table, names[::2]):
        return []
    if not unit:
        answers = ["--stress '[Pa]'", "--stress '[mPa*s]'"]
        raise MappingError(
            "pairs of columns without names: the first of each goes through decades, as shear rates in 1/s do",
            where=table.name,
            remedy=f"If they are, say what the second columns are, such as {answers[0]}, or {answers[1]}",
            answers=answers,
        )
    return [f"curve {number}" for number in range(1, len(numbers) + 1)]


def _are_swept(table: Table, over_rates: Sequence[str]) -> bool:
    """Whether the first columns of two pairs or more go up through decades, as shear rates are swept."""
    if len(over_rates) < 2:
        return False
    for name in over_rates:
        known = table.columns[name][np.isfinite(table.columns[name])]
        rises = known.size > 2 and known[0] > 0.0 and bool(np.all(np.diff(known) > 0.0))
        if not rises or known[-1] < _SWEPT * known[0]:
            return False
    return True


def _which_fall(table: Table, over_rates: Sequence[str], beside: Sequence[str]) -> list[bool]:
    """Of each pair of columns, whether its values fall all the way with the rate, as viscosities do and no stresses."""
    falling: list[bool] = []
    for rates, values in zip(over_rates, beside, strict=True):
        rate = table.columns[rates]
        value = table.columns[values]
        known = np.isfinite(rate) & np.isfinite(value) & (rate > 0)
        by_rate = np.argsort(rate[known], kind="stable")
        falling.append(bool(known.sum() > 2 and np.all(np.diff(value[known][by_rate]) < 0)))
    return falling


def _is_steeper_than_flow(across: Array, up: Array) -> bool:
    """Whether the second column spans more decades than the first: the axes of a flow curve are the other way round."""
    known = np.isfinite(across) & np.isfinite(up) & (across > 0) & (up > 0)
    if not known.any():
        return True
    return float(np.ptp(np.log(up[known]))) > _STEEPEST * float(np.ptp(np.log(across[known])))

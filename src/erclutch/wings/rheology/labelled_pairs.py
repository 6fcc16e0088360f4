"""Pairs of columns with a label over each pair: shear rates, and the stresses or viscosities beside them."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from erclutch.errors import MappingError, UnitError
from erclutch.logs.columns.rheometer_names import said_by_name
from erclutch.logs.table import Table
from erclutch.signals.array import Array
from erclutch.signals.units import parse
from erclutch.wings.rheology.flow_units import said_by_unit, unit_of


@dataclass(frozen=True)
class FlowColumn:
    """One column of a flow curve.

    Attributes:
        name: in the table.
        unit: by which it is read.
        factor: from that unit to 1/s, Pa or Pa s.
        reason: why the column is taken for its role, as the end of a sentence.
    """

    name: str
    unit: str
    factor: float
    reason: str


@dataclass(frozen=True)
class CurvePlan:
    """Where one curve stands in a table.

    Attributes:
        label: what the curve is called.
        rate: its shear rates.
        stress: its shear stresses, or its viscosities.
        times_rate: whether ``stress`` is a viscosity, which becomes a stress by its rate.
    """

    label: str
    rate: FlowColumn
    stress: FlowColumn
    times_rate: bool = False


def labelled_pairs(table: Table, unit: str = "") -> tuple[CurvePlan, ...]:
    """Curves of a file with a label over the rates of each pair and nothing over the stresses; none for others.

    Args:
        table: of the file.
        unit: of the second columns, a stress's or a viscosity's; "": Pa, if they rise with the rate as stresses do.

    Raises:
        MappingError: a second column falls as the rate grows, as viscosities do. UnitError: a unit of neither.
    """
    names = list(table.columns)
    if len(names) % 2 or not names:
        return ()
    unnamed: list[bool] = []
    for name in names:
        is_numbered = re.fullmatch(r"c\d+", name) is not None
        unnamed.append(is_numbered and table.units.get(name) is None)
    if not all(unnamed[1::2]):
        return ()
    labels: list[str] = []
    if all(unnamed):
        # Labels that are numbers, such as volume fractions, stand in the first row of the table.
        first_row = [table.columns[name][0] for name in names]
        over_rates = np.isfinite(first_row[::2])
        none_over_stresses = np.isnan(first_row[1::2])
        if not over_rates.all() or not none_over_stresses.all():
            return ()
        labels = [f"{label:g}" for label in first_row[::2]]
    else:
        if any(
            said_by_name(name) != "unknown" or said_by_unit(unit_of(table, name)) != "unknown" for name in names[::2]
        ):
            return ()
        for number, place in enumerate(range(0, len(names), 2), start=1):
            labels.append(f"curve {number}" if unnamed[place] else names[place])
    reason = "a label stands over its pair of columns"
    quantity = said_by_unit(unit or "Pa")
    if quantity not in ("stress", "viscosity"):
        raise UnitError(f"{unit!r} is no unit of a stress or a viscosity", remedy="Give such as Pa or mPa*s")
    factor = parse(unit or "Pa").factor / parse("Pa").factor
    pairs: list[CurvePlan] = []
    for label, rates, stresses in zip(labels, names[::2], names[1::2], strict=True):
        rate = FlowColumn(rates, "1/s", 1.0, reason)
        stress = FlowColumn(stresses, unit or "Pa", factor, reason)
        if not unit and _falls(table.columns[rates], table.columns[stresses]):
            raise MappingError(
                f"pairs of columns without units: behind {label!r} the second falls as the first grows, as a viscosity "
                "does and no shear stress",
                where=table.name,
                remedy="Say its unit, such as --stress '[mPa*s]', or --stress '[Pa]' if it is a stress all the same",
            )
        pairs.append(CurvePlan(label, rate, stress, times_rate=quantity == "viscosity"))
    return tuple(pairs)


def _falls(rates: Array, values: Array) -> bool:
    """Whether values fall all the way as the rate grows."""
    known = np.isfinite(rates) & np.isfinite(values) & (rates > 0)
    order = np.argsort(rates[known], kind="stable")
    return int(known.sum()) > 2 and bool(np.all(np.diff(values[known][order]) < 0))

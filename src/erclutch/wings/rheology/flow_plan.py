"""A flow plan says which columns of a table are shear rate and shear stress, in which units, and why.

A column is recognised by its name, in the languages that instruments write, and by its unit; where both speak, both
must agree. A viscosity times its rate is a stress, so a table without stresses is read by its viscosities. What cannot
be told is asked about.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs.columns.labels import split_label
from erclutch.logs.columns.levels_in_names import differ_by_field
from erclutch.logs.columns.names import without_numbers
from erclutch.logs.columns.rheometer_names import (
    Quantity,
    Role,
    of_oscillation,
    plain_name,
    said_by_name,
)
from erclutch.logs.columns.rheometer_units import SI, in_plain_units, said_by_unit, unit_of
from erclutch.logs.table import Table
from erclutch.signals.array import Mask
from erclutch.signals.units import parse
from erclutch.wings.rheology.flow_law import flow_laws
from erclutch.wings.rheology.flow_questions import (
    compare_with_viscosity,
    missing_column,
    require_fitting_units,
    require_no_logarithms,
    require_no_unit_above,
    require_one_unit,
    require_plain_heads,
)
from erclutch.wings.rheology.labelled_pairs import (
    UNKNOWN_UNIT,
    CurvePlan,
    FlowColumn,
    labelled_pairs,
)

_CALLED: Mapping[Quantity, str] = {
    "rate": "shear rate",
    "stress": "shear stress",
    "viscosity": "viscosity",
}
_PASCAL = parse("Pa").factor
_MEANING = {
    "rate": "a shear rate",
    "stress": "a shear stress",
    "viscosity": "a viscosity",
    "other": "neither",
}

#: What was wanted, or what a law gives, beside what was measured.
_NOT_MEASURED = re.compile(
    r"\b(?:target|set|setpoint|nominal|command(?:ed)?|requested|soll|consigne)\b|目标|设定|設定|目標"
    r"|\b(?:fit(?:ted)?|model(?:l?ed)?|predicted|prediction|residuals?|calc(?:ulated)?|theor\w*|regression)\b"
    r"|\b(?:power law|berechnet|ajust\w*|calcul\w*)\b|拟合|计算|計算|理论|理論"
    # The first name that each of our laws has: ``Casson``, ``Herschel (fit)``.
    rf"|\b(?:{'|'.join(law.partition('-')[0] for law in flow_laws())})\b"
)
#: A difference of normal stresses, by its sign; samples may be called so too.
_NORMAL_STRESS = re.compile(r"n ?[12]\b.*")


@dataclass(frozen=True)
class FlowPlan:
    """What a table of flow curves is taken for.

    Attributes:
        curves: one or several.
        notes: what was chosen, one sentence each.
        unused: columns that are neither.
    """

    curves: tuple[CurvePlan, ...]
    notes: tuple[str, ...]
    unused: tuple[str, ...] = ()


def plan_of(
    table: Table,
    rate: str | None = None,
    stress: Sequence[str] = (),
) -> FlowPlan:
    """Choose the columns of the flow curves in a table.

    Args:
        table: as a reader gives it.
        rate: the column of shear rates, such as ``D [1/min]``; None: the columns are looked for.
        stress: the columns of shear stresses or viscosities, such as ``tau [kPa]`` or ``eta [mPa s]``.

    Raises:
        MappingError: no column or several could be meant (UnitError: a unit is unknown, or does not fit the name).
    """
    pairs = _plan_of_pairs(table, rate, stress)
    if pairs is not None:
        return pairs

    # What the options say of a column, by its name.
    asked = {_column(table, label): label for label in (rate, *stress) if label}
    of_a_swing = of_oscillation(table.columns)
    roles: dict[str, Role] = {}
    for name in table.columns:
        if name not in asked:
            roles[name] = "other" if name in of_a_swing else _role(table, name)

    def of_role(wanted_role: Role) -> list[str]:
        """Columns that nobody asked for and that have the role; what was not measured only where nothing else is."""
        named = [name for name, role in roles.items() if role == wanted_role]
        return [name for name in named if not _NOT_MEASURED.search(plain_name(name))] or named

    rates = [_column(table, rate)] if rate else of_role("rate")
    if len(rates) > 1:  # a speed of a rotor in 1/min has the unit of a rate, and not its name
        rates = [name for name in rates if name in asked or said_by_name(name) == "rate"] or rates
    stresses = [_column(table, label) for label in stress]
    if not stresses:
        stresses = of_role("stress")
        if len(rates) == 1:
            stresses = _measured_once(table, stresses)
    viscosities = of_role("viscosity")
    guessed: list[str] = []
    if not stresses and not viscosities and rates:
        # Columns named after the field or the sample alone, beside a column that is surely the rate.
        guessed = _taken_for_stresses(table, rates[0], of_role("unknown"))
        stresses = guessed
    if not rates or not (stresses or viscosities):
        raise missing_column(table, roles, rates)

    values = stresses or viscosities
    if len(rates) not in (1, len(values)):
        of_values = f"for {len(values)} columns of stresses"
        first = f"--shear-rate {shell_word(table.label(rates[0]))}"
        raise MappingError(
            f"{len(rates)} columns could be the shear rate ({', '.join(rates)}) {of_values}",
            where=table.name,
            remedy=f"Name one: {first}",
            answers=[first],
        )
    rate_of_each = rates if len(rates) > 1 else rates * len(values)
    curves: list[CurvePlan] = []
    for rate_name, value_name in zip(rate_of_each, values, strict=True):
        # A column that was asked for as a stress may be a viscosity, by its unit, or by its name without one.
        unit = _unit_asked(value_name, asked) or unit_of(table, value_name)
        measured = said_by_unit(unit)
        role = measured if measured in SI else said_by_name(value_name)  # the unit may be misspelt
        quantity: Quantity = "viscosity" if not stresses or role == "viscosity" else "stress"
        curves.append(
            CurvePlan(
                label=value_name,
                rate=_flow_column(table, rate_name, "rate", asked),
                stress=_flow_column(table, value_name, quantity, asked),
                times_rate=quantity == "viscosity",
            )
        )
    require_no_logarithms(table, curves, asked)
    require_plain_heads(table, curves, asked)
    require_one_unit(table, curves, [name for name in roles if roles[name] == "viscosity"])
    used = {column.name for curve in curves for column in (curve.rate, curve.stress)}
    unused = tuple(name for name in roles if name not in used)
    plan = FlowPlan(tuple(curves), _notes(curves, guessed), unused)
    curve = curves[0]
    if len(curves) == 1 and not asked and not curve.times_rate and len(viscosities) == 1:
        # The only viscosity beside the stress: their units tell a wrong one, or their numbers a missing one.
        (viscosity,) = viscosities
        if unit_of(table, viscosity):
            compare_with_viscosity(table, curve, _flow_column(table, viscosity, "viscosity", {}))
        elif curve.stress.unit_is_assumed:
            require_fitting_units(table, curve, viscosity)
    return plan


def _plan_of_pairs(table: Table, rate: str | None, stress: Sequence[str]) -> FlowPlan | None:
    """The plan of a table of labelled pairs of columns, in a unit that was given for all of them; None for others.

    Raises:
        MappingError: the whole table is an oscillation, or the pairs leave open what they are.
    """
    if rate is not None or len(stress) > 1:
        return None
    given = re.fullmatch(r"\[([^\[\]]+)\]", stress[0]) if stress else None
    if stress and given is None:
        return None
    swings, marks = oscillation(table)
    if swings.any() and swings.all():
        problem = f"the test is an oscillation ({', '.join(marks[:3])}), which has no flow curve"
        remedy = "Give a test in rotation, or name columns: --shear-rate, --stress"
        raise MappingError(problem, where=table.name, remedy=remedy)
    unit = given[1] if given else ""
    pairs = labelled_pairs(table, unit)
    if not pairs:
        return None
    taken_for = "taken for shear rate [1/s] and shear stress [Pa]"
    if unit:
        taken_for = f"in {unit}"
    elif pairs[0].stress.unit == UNKNOWN_UNIT:
        # As a viscosity falls with the rate, and no stress.
        taken_for = (
            "taken for shear rate [1/s] and a viscosity in an unknown unit, since each falls all the way: "
            "--stress '[mPa*s]' gives the unit, --stress '[Pa]' says that they are stresses"
        )
    return FlowPlan(pairs, (f"{len(pairs)} pairs of columns, {taken_for}",))


def oscillation(table: Table) -> tuple[Mask, list[str]]:
    """Rows of a table that were measured in oscillation, shape (n,), and the columns that say so.

    An oscillation that stands beside a flow curve, as a table of its own, says nothing of the flow curve's rows: both
    begin in one row, and the oscillation goes on without a rate. Where a row is one measurement, an instrument gives
    each row of one test the same columns.
    """
    marks = of_oscillation(table.columns)
    rates = [name for name in table.columns if name not in marks and said_by_name(name) == "rate"]
    longest = {"marks": 0, "rates": 0}  # rows
    begin_in_one_row = True
    for kind, names in (("marks", marks), ("rates", rates)):
        for name in names:
            is_filled = np.isfinite(table.columns[name])
            length = int(is_filled.sum())
            begin_in_one_row = begin_in_one_row and bool(is_filled[:length].all())
            longest[kind] = max(longest[kind], length)

    swings = np.zeros(table.rows, np.bool_)
    if begin_in_one_row and 0 < longest["rates"] < longest["marks"]:
        return swings, []
    for name in marks:
        values = table.columns[name]
        swings |= np.isfinite(values) & (values != 0)
    return swings, marks


def _column(table: Table, label: str) -> str:
    """The column that an option names, with or without a unit behind it."""
    name, _ = split_label(label)
    for candidate in (label, name):
        if candidate in table.columns:
            return candidate
    remedy = f"Choose from {', '.join(map(repr, table.labels))}"
    raise MappingError(f"there is no column {name!r}", where=table.name, remedy=remedy)


def _role(table: Table, name: str) -> Role:
    """The role of a column by name and unit.

    Raises:
        UnitError: the name and the unit of a column speak of two roles.
    """
    unit = unit_of(table, name)
    named = said_by_name(name)
    measured = said_by_unit(unit)
    if named == "unknown":
        return (
            "other"
            if measured == "stress" and _NORMAL_STRESS.fullmatch(plain_name(name))
            else measured
        )
    if measured in ("unknown", named):
        return named
    if "other" in (named, measured):
        return "other"
    a_rate = f"--shear-rate {shell_word(f'{name} [1/s]')}"
    a_stress = f"--stress {shell_word(f'{name} [Pa]')}"
    raise UnitError(
        f"the column {name!r} is {_MEANING[named]} by its name and {_MEANING[measured]} by its unit [{unit}]",
        where=table.name,
        remedy=f"Say which it is: {a_rate} or {a_stress}",
        answers=[a_rate, a_stress],
    )


def _unit_asked(name: str, asked: dict[str, str]) -> str | None:
    """The unit that an option gives a column."""
    if name not in asked:
        return None
    _, unit = split_label(asked[name])
    return in_plain_units(said_by_name(name), unit) if unit else None


def _measured_once(table: Table, names: Sequence[str]) -> list[str]:
    """Columns of stresses that are runs of their own.

    Left out are those that repeat an earlier one in name and numbers, as "Stress (step)" repeats "Stress", and the mean
    of all others, which somebody wrote beside the runs.
    """

    def repeats(name: str, other: str) -> bool:
        if not name.startswith(other) or unit_of(table, name) != unit_of(table, other):
            return False
        return np.allclose(
            table.columns[name],
            table.columns[other],
            rtol=1e-6,
            atol=0.0,
            equal_nan=True,
        )

    distinct: list[str] = []
    for place, name in enumerate(names):
        if not any(repeats(name, other) for other in names[:place]):
            distinct.append(name)
    # Where the stress grows evenly with the field, the curve of a middle field is no mean.
    if differ_by_field(distinct):
        return distinct
    for name in distinct:
        others = [other for other in distinct if other != name]
        if len(others) < 2:
            continue
        mean = np.mean([table.columns[other] for other in others], axis=0)
        if np.allclose(table.columns[name], mean, rtol=2e-3, atol=0.0):
            return others
    return distinct


def _taken_for_stresses(table: Table, rate: str, unknown: Sequence[str]) -> list[str]:
    """Columns without a known name that grow with the rate, and those whose names differ from theirs in a number alone.

    In a strong field the stress hardly grows with the rate, and a column of a series is no less a stress for that.
    """
    alike: dict[str, str] = {}  # names without their numbers
    rising: set[str] = set()  # such names
    for name in unknown:
        counts = np.array_equal(np.diff(table.columns[name]), np.ones(table.rows - 1))
        if counts or "%" in table.label(name):
            continue
        alike[name] = without_numbers(plain_name(name))
        rates = np.abs(table.columns[rate])
        values = np.abs(table.columns[name])
        known = np.isfinite(rates) & np.isfinite(values)
        rises = True  # where nothing speaks against it
        if known.sum() > 2 and np.ptp(values[known]) > 0:
            rate_ranks = np.argsort(np.argsort(rates[known]))
            value_ranks = np.argsort(np.argsort(values[known]))
            rises = bool(np.corrcoef(rate_ranks, value_ranks)[0, 1] > 0.5)
        if rises and not unit_of(table, name):
            rising.add(alike[name])
    return [name for name, without_number in alike.items() if without_number in rising]


def _flow_column(
    table: Table,
    name: str,
    role: Quantity,
    asked: dict[str, str],
) -> FlowColumn:
    """A column with the unit by which it is read.

    Raises:
        UnitError: the unit is unknown, or of another quantity.
    """
    unit_asked = _unit_asked(name, asked)
    unit = unit_asked or unit_of(table, name)
    if unit is None:
        require_no_unit_above(table, name, role)
    if unit is None and role == "viscosity":
        # Written in Pa s, and as often in mPa s: no unit is better than a wrong one.
        return FlowColumn(name, UNKNOWN_UNIT, 1.0, "no unit", unit_is_assumed=True)
    if unit is None:
        reason = f"no unit, taken for {SI[role]}"
        return FlowColumn(name, SI[role], 1.0, reason, unit_is_assumed=True)
    if said_by_unit(unit) != role:
        option = "--shear-rate" if role == "rate" else "--stress"
        units = ["mPa*s", SI[role]] if role == "viscosity" else [SI[role]]
        named = [f"{option} {shell_word(f'{name} [{each}]')}" for each in units]
        raise UnitError(
            f"the column {name!r} has the unit {unit!r}, which is no unit of {_MEANING[role]}",
            where=table.name,
            remedy=f"Name its unit: {', or '.join(named)}",
            answers=named,
        )
    base = 1.0 if role == "rate" else _PASCAL
    reason = "asked for" if unit_asked else f"named, in {unit}"
    return FlowColumn(name, unit, parse(unit).factor / base, reason)


def _notes(curves: Sequence[CurvePlan], guessed: Sequence[str]) -> tuple[str, ...]:
    """What each column was taken for, one sentence each."""
    notes: list[str] = []
    columns: dict[FlowColumn, Quantity] = {curve.rate: "rate" for curve in curves}
    for curve in curves:
        columns[curve.stress] = "viscosity" if curve.times_rate else "stress"
    for column, quantity in columns.items():
        sentence = f"{_CALLED[quantity]}: column {column.name!r} [{column.unit}]"
        if column.name in guessed:
            sentence += ", without unit or a known name: taken for a stress in Pa because it grows with the rate"
        elif column.unit_is_assumed:
            sentence += f", {column.reason}"
        elif column.factor != 1.0:
            sentence += f", x {column.factor:g} to {SI[quantity]}"
        notes.append(sentence)
    if any(curve.times_rate for curve in curves):
        notes.append("stress = viscosity x shear rate")
    open_ones = [curve.stress.name for curve in curves if curve.stress.unit == UNKNOWN_UNIT]
    if open_ones:
        named = " ".join(shell_word(f"{name} [mPa*s]") for name in open_ones)
        notes.append(
            f"stresses are in an unknown unit: --stress {named} says it, or Pa*s in its place"
        )
    return tuple(notes)

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
from erclutch.logs.labels import split_end, split_label
from erclutch.logs.table import Table
from erclutch.signals.array import Mask
from erclutch.signals.units import parse
from erclutch.wings.rheology.flow_names import Quantity, Role, plain_name, said_by_name

_SI: Mapping[Quantity, str] = {"rate": "1/s", "stress": "Pa", "viscosity": "Pa*s"}
_CALLED: Mapping[Quantity, str] = {"rate": "shear rate", "stress": "shear stress", "viscosity": "viscosity"}
_PASCAL = parse("Pa").factor
_MEANING = {"rate": "a shear rate", "stress": "a shear stress", "viscosity": "a viscosity", "other": "neither"}

#: Columns that only an oscillation fills: what is stored and lost in a turn there and back.
_OSCILLATION = re.compile(
    r"(?:storage|loss|complex) (?:shear )?modul|\b(?:g|eta)\*|η\*|\bg'|\(elastic component\)|speichermodul|verlustmodul"
    r"|complex viscosity|komplexe viskos"
    r"|module de (?:conservation|perte)|modulo de (?:almacen|perdida)|储能模量|贮存弾性率"
)
#: A shear rate counts no events: 1 Hz of an oscillation is 2 pi rad/s of nothing sheared.
_NO_RATE = re.compile(r"hz|cps|rpm", re.IGNORECASE)
#: A stress and a viscosity of one row that differ by more than this share have a wrong unit.
_AGREE = 0.2
_HELD = 1.2  # times the lowest rate: what stays below is measured at one rate


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


@dataclass(frozen=True)
class FlowPlan:
    """What a table of flow curves is taken for.

    Attributes:
        curves: one or several.
        notes: what was chosen and left out, one sentence each.
    """

    curves: tuple[CurvePlan, ...]
    notes: tuple[str, ...]


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
    swings, marks = oscillation(table)
    if rate is None and not stress:
        if swings.any() and swings.all():
            problem = f"the test is an oscillation ({', '.join(marks[:3])}), which has no flow curve"
            remedy = "Give a test in rotation, or name columns: --shear-rate, --stress"
            raise MappingError(problem, where=table.name, remedy=remedy)
        pairs = _labelled_pairs(table)
        if pairs:
            note = f"{len(pairs)} pairs of columns, taken for shear rate [1/s] and shear stress [Pa]"
            return FlowPlan(pairs, (note,))

    asked: dict[str, str] = {}  # what the options say of a column, by its name
    for label in [rate, *stress]:
        if label:
            asked[_column(table, label)] = label
    roles: dict[str, Role] = {name: _role(table, name) for name in table.columns if name not in asked}

    def of_role(wanted_role: Role) -> list[str]:
        """Columns that nobody asked for and that have the role."""
        return [name for name, role in roles.items() if role == wanted_role]

    rates = [_column(table, rate)] if rate else of_role("rate")
    stresses = [_column(table, label) for label in stress]
    if not stresses:
        stresses = of_role("stress")
        if len(rates) == 1:
            stresses = _distinct(table, stresses)
    viscosities = of_role("viscosity")
    guessed: list[str] = []
    if not stresses and not viscosities and rates:
        # Columns named after the field or the sample alone, beside a column that is surely the rate.
        guessed = [name for name in of_role("unknown") if _rises(table, rates[0], name)]
        stresses = guessed
    if not rates or not (stresses or viscosities):
        raise _missing(table, roles, rates)

    curves: list[CurvePlan] = []
    for rate_name, value_name in _grouped(table, rates, stresses or viscosities):
        quantity: Quantity = "stress"
        if not stresses or _is_viscosity(table, value_name, asked):
            quantity = "viscosity"
        curves.append(
            CurvePlan(
                label=value_name,
                rate=_flow_column(table, rate_name, "rate", asked),
                stress=_flow_column(table, value_name, quantity, asked),
                times_rate=quantity == "viscosity",
            )
        )
    plan = FlowPlan(tuple(curves), _notes(table, curves, guessed, roles))
    if (
        len(curves) == 1
        and len(viscosities) == 1
        and not curves[0].times_rate
        and not asked
        and _unit(table, viscosities[0])
    ):
        _compare(table, curves[0], _flow_column(table, viscosities[0], "viscosity", asked))
    return plan


def require_several_rates(plan: FlowPlan, table: Table) -> None:
    """Refuse a test at one shear rate: a hold, a ramp of temperature.

    Raises:
        MappingError: all its curves have points, and all points one rate.
    """
    rates = [np.abs(table.columns[curve.rate.name]) for curve in plan.curves]
    turning = [rate[np.isfinite(rate) & (rate > 0)] for rate in rates]
    if all(rate.size > 1 and rate.max() <= _HELD * rate.min() for rate in turning):
        ends = f"{turning[0].min():.4g} to {turning[0].max():.4g} {plan.curves[0].rate.unit}"
        problem = f"all points have the shear rate {ends}, which is no flow curve"
        raise MappingError(problem, where=table.name, remedy="Give a test with several rates")


def oscillation(table: Table) -> tuple[Mask, list[str]]:
    """Rows of a table that were measured in oscillation, shape (n,), and the columns that say so."""
    marks = [name for name in table.columns if _OSCILLATION.search(plain_name(name))]
    swings = np.zeros(table.rows, np.bool_)
    for name in marks:
        values = table.columns[name]
        swings |= np.isfinite(values) & (values != 0)
    return swings, marks


def _labelled_pairs(table: Table) -> tuple[CurvePlan, ...]:
    """Curves of a file with a label over the rates of each pair and nothing over the stresses; none for others."""
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
        if any(_role(table, name) != "unknown" for name in names[::2]):
            return ()
        for number, place in enumerate(range(0, len(names), 2), start=1):
            labels.append(f"curve {number}" if unnamed[place] else names[place])
    reason = "a label stands over its pair of columns"
    pairs: list[CurvePlan] = []
    for label, rates, stresses in zip(labels, names[::2], names[1::2], strict=True):
        rate = FlowColumn(rates, "1/s", 1.0, reason)
        stress = FlowColumn(stresses, "Pa", 1.0, reason)
        pairs.append(CurvePlan(label, rate, stress))
    return tuple(pairs)


def _column(table: Table, label: str) -> str:
    """The column that an option names, with or without a unit behind it."""
    name, _ = split_label(label)
    for candidate in (label, name):
        if candidate in table.columns:
            return candidate
    remedy = f"Choose from {', '.join(map(repr, table.labels))}"
    raise MappingError(f"there is no column {name!r}", where=table.name, remedy=remedy)


def _said_by_unit(unit: str | None) -> Role:
    """What a unit alone says: a rate, a stress, a viscosity, another quantity, or nothing."""
    if not unit:
        return "unknown"
    try:
        dimension = parse(unit).dimension
    except UnitError:
        return "unknown"
    for role, si in _SI.items():
        if dimension == parse(si).dimension:
            counted = role == "rate" and _NO_RATE.search(unit)
            return "other" if counted else role
    return "other"


def _unit(table: Table, name: str) -> str | None:
    """The unit of a column in its file, or the end of its name (``Viscosity_cP``) where that measures a flow curve."""
    unit = table.units.get(name)
    if unit:
        return unit
    _, end = split_end(name)
    return end if end and _said_by_unit(end) in _SI else None


def _role(table: Table, name: str) -> Role:
    """The role of a column by name and unit.

    Raises:
        UnitError: the name and the unit of a column speak of two roles.
    """
    unit = _unit(table, name)
    named = said_by_name(name)
    measured = _said_by_unit(unit)
    if named == "unknown":
        return measured
    if measured in ("unknown", named):
        return named
    if "other" in (named, measured):
        return "other"
    raise UnitError(
        f"the column {name!r} is {_MEANING[named]} by its name and {_MEANING[measured]} by its unit [{unit}]",
        where=table.name,
        remedy=f"Say which it is: --shear-rate {shell_word(f'{name} [1/s]')} or --stress {shell_word(f'{name} [Pa]')}",
    )


def _is_viscosity(table: Table, name: str, asked: dict[str, str]) -> bool:
    """Whether a column that was asked for as a stress is a viscosity by its unit, or by its name without one."""
    unit = _unit_asked(name, asked) or _unit(table, name)
    said = _said_by_unit(unit) if unit else said_by_name(name)
    return said == "viscosity"


def _unit_asked(name: str, asked: dict[str, str]) -> str | None:
    """The unit that an option gives a column."""
    if name not in asked:
        return None
    _, unit = split_label(asked[name])
    return unit


def _distinct(table: Table, names: Sequence[str]) -> list[str]:
    """Columns without those that repeat an earlier one in name and numbers, as "Stress (step)" repeats "Stress"."""

    def repeats(name: str, other: str) -> bool:
        if not name.startswith(other) or _unit(table, name) != _unit(table, other):
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
    return distinct


def _rises(table: Table, rate: str, name: str) -> bool:
    """Whether a column without a known name grows with the rate, as every stress of a flow curve does."""
    if _unit(table, name):
        return False
    rates = np.abs(table.columns[rate])
    values = np.abs(table.columns[name])
    known = np.isfinite(rates) & np.isfinite(values)
    if known.sum() < 3 or not np.ptp(values[known]) > 0:
        return True  # nothing speaks against it
    rate_ranks = np.argsort(np.argsort(rates[known]))
    value_ranks = np.argsort(np.argsort(values[known]))
    return bool(np.corrcoef(rate_ranks, value_ranks)[0, 1] > 0.5)


def _grouped(
    table: Table,
    rates: Sequence[str],
    values: Sequence[str],
) -> list[tuple[str, str]]:
    """Pairs of a column of rates and a column of stresses or viscosities."""
    if len(rates) == 1:
        return [(rates[0], value) for value in values]
    if len(rates) == len(values):
        return list(zip(rates, values, strict=True))
    raise MappingError(
        f"{len(rates)} columns could be the shear rate ({', '.join(rates)}) for {len(values)} columns of stresses",
        where=table.name,
        remedy=f"Name one: --shear-rate {shell_word(table.label(rates[0]))}",
    )


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
    unit = unit_asked or _unit(table, name)
    if unit is None and role == "viscosity" and name not in asked:
        raise UnitError(
            f"the column {name!r} has no unit: viscosities are written in Pa s, and as often in mPa s or cP",
            where=table.name,
            remedy=f"Say which: --stress {shell_word(f'{name} [mPa*s]')}, or --stress {shell_word(f'{name} [Pa*s]')}",
        )
    if unit is None:
        return FlowColumn(name, _SI[role], 1.0, f"no unit, taken for {_SI[role]}")
    if _said_by_unit(unit) != role:
        option = "--shear-rate" if role == "rate" else "--stress"
        raise UnitError(
            f"the column {name!r} has the unit {unit!r}, which is no unit of {_MEANING[role]}",
            where=table.name,
            remedy=f"Name its unit: {option} {shell_word(f'{name} [{_SI[role]}]')}",
        )
    base = 1.0 if role == "rate" else _PASCAL
    reason = "asked for" if unit_asked else f"named, in {unit}"
    return FlowColumn(name, unit, parse(unit).factor / base, reason)


def _notes(
    table: Table, curves: Sequence[CurvePlan], guessed: Sequence[str], roles: dict[str, Role]
) -> tuple[str, ...]:
    """What each column was taken for, and which columns were not used, one sentence each."""
    notes: list[str] = []
    columns: dict[FlowColumn, Quantity] = {curve.rate: "rate" for curve in curves}
    for curve in curves:
        columns[curve.stress] = "viscosity" if curve.times_rate else "stress"
    for column, quantity in columns.items():
        said = f"{_CALLED[quantity]}: column {column.name!r} [{column.unit}]"
        if column.name in guessed:
            said += ", without unit or a known name: taken for a stress in Pa because it grows with the rate"
        elif column.reason.startswith("no unit"):
            said += f", {column.reason}"
        elif column.factor != 1.0:
            said += f", x {column.factor:g} to {_SI[quantity]}"
        notes.append(said)
    if any(curve.times_rate for curve in curves):
        notes.append("stress = viscosity x shear rate")
    used = {column.name for column in columns}
    unused = [name for name in roles if name not in used]
    if unused:
        notes.append(f"not used: {', '.join(unused)}")
    return tuple(notes)


def _compare(table: Table, curve: CurvePlan, viscosity: FlowColumn) -> None:
    """Stress over rate is the viscosity: a wrong unit of either shows.

    Raises:
        UnitError: they disagree.
    """
    rate = table.columns[curve.rate.name] * curve.rate.factor
    stress = np.abs(table.columns[curve.stress.name] * curve.stress.factor)
    apparent = np.abs(rate * table.columns[viscosity.name] * viscosity.factor)
    known = np.isfinite(stress) & np.isfinite(apparent) & (apparent > 0) & (stress > 0)
    if not known.any():
        return
    ratio = float(np.median(stress[known] / apparent[known]))
    if abs(np.log(ratio)) <= np.log1p(_AGREE):
        return
    shear_rate = curve.rate
    shear_stress = curve.stress
    product = f"{viscosity.name!r} [{viscosity.unit}] x {shear_rate.name!r} [{shear_rate.unit}]"
    options = (
        f"--shear-rate {shell_word(f'{shear_rate.name} [1/s]')} --stress {shell_word(f'{shear_stress.name} [Pa]')}"
    )
    raise UnitError(
        f"{shear_stress.name!r} [{shear_stress.unit}] is {ratio:.4g} times {product}: one of these units is wrong",
        where=table.name,
        remedy=f"Name the columns with their units: {options}",
    )


def _missing(table: Table, roles: dict[str, Role], rates: Sequence[str]) -> MappingError:
    """The error where no column is surely the rate, or the stress beside one."""
    what = "shear rate"
    option = "--shear-rate"
    unit = "1/s"
    if rates:
        what = "shear stress"
        option = "--stress"
        unit = "Pa"
    candidates = [name for name, role in roles.items() if role == "unknown"] or list(roles) or ["NAME"]
    # A gamma beside a tau is a rate or a strain: only the user knows, and no other column is more likely.
    likely = [name for name in candidates if plain_name(name) in ("gamma", "gamma point", "shear")]
    example = [*likely, *candidates][0]
    return MappingError(
        f"no column is surely the {what} (there are: {', '.join(table.labels)})",
        where=table.name,
        remedy=f"Name it with its unit, such as {option} {shell_word(f'{example} [{unit}]')}",
    )

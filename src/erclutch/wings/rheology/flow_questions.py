"""What is asked where a table leaves open which columns are rates and stresses, or in which units they are."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np

from erclutch.errors import MappingError, UnitError, shell_word
from erclutch.logs.columns.powers_of_ten import both_ways, power_beside
from erclutch.logs.columns.rheometer_names import (
    Quantity,
    Role,
    is_a_logarithm,
    of_oscillation,
    plain_name,
    said_by_name,
)
from erclutch.logs.columns.rheometer_units import (
    SI,
    said_by_unit,
    unit_of,
    unit_or_end,
    units_above,
    without_a_unit,
)
from erclutch.logs.table import Table
from erclutch.signals.units import is_temperature, parse
from erclutch.wings.rheology.labelled_pairs import UNKNOWN_UNIT, CurvePlan, FlowColumn
from erclutch.wings.rheology.rotor_speeds import speed_in_place_of_rate

_WANTED: Mapping[str, Sequence[Role]] = {
    "shear rate": ("rate",),
    "shear stress": ("stress", "viscosity"),
}
#: A stress and a viscosity of one row that differ by more than this share have a wrong unit.
_AGREE = 0.2
#: Units that a stress without a unit may have in place of Pa, and a viscosity beside it.
_OTHER_STRESSES = ("dyn/cm^2", "lbf/(100*ft^2)", "mPa", "MPa")
_VISCOSITIES = ("mPa*s", "Pa*s")
#: What only a unit has within brackets, whether the whole is a unit that we know or not.
_OF_A_UNIT = re.compile(
    r"(?<![^\W\d_])(?:[kKMmµu]?Pa|m?N|dyne?s?|lb[fs]?|psi|bar|poise|[mc]P|sec|min)(?![^\W\d_])"
    r"|Па|кгс|дин|^[^\W\d_]{1,5}/[^\W\d_]{1,5}[\d²³^]*$"
    r"|\bs ?\^?[-⁻]|10 ?[\^⁰-⁹¹²³]|\bunits?\b|\barb|\ba\.?u\b|\bskt\b|skalen|\bdiv|\bcounts?\b|°|\bdeg|%"
)
_IN_BRACKETS = re.compile(r"[\[(]([^\[\]()]+)[\])]")
#: A number in front of a unit; 10 and 100 are taken for factors there.
_NUMBER_IN_FRONT = re.compile(r"\s*(\d{1,6}(?:\.\d+)?)\s*(?=[^\W\d_])(?![eE]\d)")


def missing_column(table: Table, roles: dict[str, Role], rates: Sequence[str]) -> MappingError:
    """The error where no column is surely the rate, or the stress beside one."""
    what = "shear rate"
    option = "--shear-rate"
    asked_in = "1/s"
    if rates:
        what = "shear stress"
        option = "--stress"
        asked_in = "Pa"
    there = f"(there are: {', '.join(table.labels)})"
    if marks := of_oscillation(table.columns):
        swings = f"the test is an oscillation ({', '.join(marks[:3])}), which has no flow curve"
        problem = f"no column is surely the {what}: {swings}"
        remedy = "Give a test in rotation, or name columns: --shear-rate, --stress"
        return MappingError(problem, where=table.name, remedy=remedy)
    if not rates and (turning := speed_in_place_of_rate(table)):
        return turning
    candidates: list[str] = []
    for name, role in roles.items():
        counts = np.array_equal(np.diff(table.columns[name]), np.ones(table.rows - 1))
        unit = unit_or_end(table, name)
        is_other = is_temperature(unit) or said_by_unit(unit) == "other"
        if role == "unknown" and "%" not in table.label(name) and not counts and not is_other:
            candidates.append(name)
    unreadable = [
        problem for name, problem in table.unreadable.items() if said_by_name(name) in _WANTED[what]
    ]
    if unreadable:
        return MappingError(
            f"no column is surely the {what}: {unreadable[0]}",
            where=table.name,
            remedy="Give a number in each of its cells, with what it scatters by in a column of its own",
        )
    if not candidates:  # all are of other quantities, such as a time: none of them may be named
        return MappingError(
            f"no flow curve: no column is surely the {what}, and each is of another quantity {there}",
            where=table.name,
            remedy="Give a table with shear rates and shear stresses or viscosities",
        )
    if rates and (spoken := [*units_above(table, "stress"), *units_above(table, "viscosity")]):
        named = " ".join(shell_word(f"{name} [{spoken[0]}]") for name in candidates)
        with_their_unit = f"{option} {named}"
        return MappingError(
            f"no column is surely the {what} {there}, and the lines above the table speak of {spoken[0]}",
            where=table.name,
            remedy=f"Name such columns with their unit: {with_their_unit}",
            answers=[with_their_unit],
        )
    # A gamma beside a tau is a rate or a strain: only the user knows, and no other column is more likely.
    likely = [name for name in candidates if plain_name(name) in ("gamma", "gamma point", "shear")]
    example = [*likely, *candidates][0]
    return MappingError(
        f"no column is surely the {what} {there}",
        where=table.name,
        remedy=f"Name it with its unit, such as {option} {shell_word(f'{example} [{asked_in}]')}",
    )


def require_one_unit(table: Table, curves: Sequence[CurvePlan], viscosities: Sequence[str]) -> None:
    """Ask about viscosities without a unit beside curves in Pa, or beside columns of laws that are no curves.

    The remedy names all columns without a unit, so that one answer is enough.

    Args:
        table: as read.
        curves: that were found.
        viscosities: all columns called so that no option names, measured or by a law.

    Raises:
        UnitError: there are such columns.
    """
    unknown = [curve.stress.name for curve in curves if curve.stress.unit == UNKNOWN_UNIT]
    are_in_one_unit = len({curve.stress_unit for curve in curves}) == 1
    others = [name for name in viscosities if name not in unknown and not unit_of(table, name)]
    if not unknown or (are_in_one_unit and not others):
        return
    named = [name for name in table.columns if name in (*unknown, *others)]
    answers: list[str] = []
    for unit in ("mPa*s", "Pa*s"):
        answers.append("--stress " + " ".join(shell_word(f"{name} [{unit}]") for name in named))
    raise UnitError(
        without_a_unit(named),
        where=table.name,
        remedy=f"Say which: {', or '.join(answers)}",
        answers=answers,
    )


def require_no_unit_above(table: Table, name: str, role: Quantity) -> None:
    """Ask about a column without a unit where the lines above the table speak of another unit than Pa or 1/s.

    Raises:
        UnitError: they do.
    """
    spoken = units_above(table, role)
    if not spoken:
        return
    option = "--shear-rate" if role == "rate" else "--stress"
    answers = [f"{option} {shell_word(f'{name} [{unit}]')}" for unit in (spoken[0], SI[role])]
    raise UnitError(
        f"the column {name!r} has no unit, and the lines above the table speak of {spoken[0]}",
        where=table.name,
        remedy=f"Say which: {', or '.join(answers)}",
        answers=answers,
    )


def require_no_logarithms(
    table: Table, curves: Sequence[CurvePlan], asked: Mapping[str, str]
) -> None:
    """Refuse columns that hold logarithms or roots by their names.

    Raises:
        MappingError: such a column, which no option names.
    """
    for curve in curves:
        for column, option in ((curve.rate, "--shear-rate"), (curve.stress, "--stress")):
            if column.name in asked or not is_a_logarithm(column.name):
                continue
            unit = column.unit if column.unit != UNKNOWN_UNIT else "Pa*s"
            raise MappingError(
                f"column {column.name!r} holds logarithms or roots, by its name",
                where=table.name,
                remedy="Write the numbers themselves, or where the column holds them give "
                f"{option} {shell_word(f'{column.name} [{unit}]')}",
            )


def require_plain_heads(
    table: Table, curves: Sequence[CurvePlan], asked: Mapping[str, str]
) -> None:
    """Ask about a column whose head has a power of ten beside its name, or a unit in brackets that nobody knows.

    Raises:
        UnitError: such a column, which no option names.
    """
    for curve in curves:
        for column, option, si in (
            (curve.rate, "--shear-rate", "1/s"),
            (curve.stress, "--stress", "Pa"),
        ):
            if column.name in asked:
                continue
            name = column.name
            unit = "Pa*s" if curve.times_rate and column is curve.stress else si
            factor = power_beside(name)
            if factor is not None:
                multiplied, over = both_ways(option, name, unit, factor)
                raise UnitError(
                    f"the name of column {name!r} has a power of ten: its numbers may be times it, or over it",
                    where=table.name,
                    remedy=f"Say which: {multiplied} if they were multiplied by it, or {over}",
                    answers=[multiplied, over],
                )
            number = _NUMBER_IN_FRONT.match(column.unit)
            if number and float(number[1]) > 1.0 and number[1].rstrip("0") != "1":
                bare = column.unit[number.end() :].strip()
                answers = [
                    f"{option} {shell_word(f'{name} [{each}]')}" for each in (bare, column.unit)
                ]
                may_be = f"{bare} with a level or a range in front, or steps of it"
                raise UnitError(
                    f"the unit of column {name!r} is {column.unit}: {may_be}",
                    where=table.name,
                    remedy=f"Say which: {', or '.join(answers)}",
                    answers=answers,
                )
            inside = _IN_BRACKETS.search(name)
            if column.unit_is_assumed and inside and _OF_A_UNIT.search(inside[1]):
                raise UnitError(
                    f"the column {name!r} has {inside[1]!r} behind its name, which is no unit that erclutch knows",
                    where=table.name,
                    remedy=f"Say what 1 in it stands for: {option} {shell_word(f'{name} [FACTOR {unit}]')}",
                )


def require_fitting_units(table: Table, curve: CurvePlan, viscosity: str) -> None:
    """Ask about a stress without a unit beside a viscosity without one that neither Pa s nor mPa s fits.

    The stress over the rate is the viscosity, so their numbers tell one unit by the other.

    Raises:
        UnitError: they fit other units, such as dyn/cm^2 and cP, or none that is known.
    """
    rate = np.abs(table.columns[curve.rate.name] * curve.rate.factor)  # [1/s]
    stress = np.abs(table.columns[curve.stress.name])
    shown = np.abs(table.columns[viscosity])
    known = np.isfinite(rate) & np.isfinite(stress) & np.isfinite(shown)
    known &= (rate > 0) & (stress > 0) & (shown > 0)
    if not known.any():
        return
    # Viscosity at a stress and a rate of 1, in the file's units.
    of_one = shown[known] * rate[known] / stress[known]
    usual = np.median(of_one)
    scatter = np.median(np.abs(np.log(of_one / usual)))
    if scatter > np.log1p(_AGREE):
        return  # no viscosity of these points

    def fits(stress_unit: str, viscosity_unit: str) -> bool:
        """Whether the numbers are about those of a stress and a viscosity in these units."""
        expected = parse(stress_unit).factor / parse(viscosity_unit).factor
        return abs(float(np.log(usual / expected))) <= np.log1p(_AGREE)

    if fits("Pa", "Pa*s") or fits("Pa", "mPa*s"):
        return
    pairs = product(_OTHER_STRESSES, _VISCOSITIES)
    fitting = [pair for pair in pairs if fits(*pair)]
    beside = f"{curve.stress.name!r} and {viscosity!r} have no units"
    rate_option = f"--shear-rate {shell_word(f'{curve.rate.name} [{curve.rate.unit}]')}"
    if not fitting:
        problem = f"{beside}, and their numbers are not of Pa beside Pa s or mPa s"
        options = f"{rate_option} --stress {shell_word(f'{curve.stress.name} [Pa]')}"
        raise UnitError(
            problem, where=table.name, remedy=f"Name the stress with its unit, such as {options}"
        )
    stress_unit, viscosity_unit = fitting[0]
    are_of = f"{stress_unit} beside {viscosity_unit}, not of Pa beside Pa s or mPa s"
    options = f"{rate_option} --stress {shell_word(f'{curve.stress.name} [{stress_unit}]')}"
    raise UnitError(
        f"{beside}, and their numbers are of {are_of}",
        where=table.name,
        remedy=f"Name the stress with its unit: {options}",
        answers=[options],
    )


def compare_with_viscosity(table: Table, curve: CurvePlan, viscosity: FlowColumn) -> None:
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
        f"--shear-rate {shell_word(f'{shear_rate.name} [1/s]')} --stress "
        f"{shell_word(f'{shear_stress.name} [Pa]')}"
    )
    raise UnitError(
        f"{shear_stress.name!r} [{shear_stress.unit}] is {ratio:.4g} times {product}: one of these units is wrong",
        where=table.name,
        remedy=f"Name the columns with their units: {options}",
        answers=[options],
    )

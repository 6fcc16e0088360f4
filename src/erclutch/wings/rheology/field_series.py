"""Flow curves of one fluid at several fields: which field each curve has, and how the yield stress grows with it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from erclutch.errors import UnitError
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.columns.name_pattern import FIELD_UNITS, NUMBER, number_of
from erclutch.logs.table import Table
from erclutch.signals import units
from erclutch.signals.array import Array
from erclutch.signals.recording import SI_UNITS_OF_FIELDS
from erclutch.wings.rheology.flow_curve import NEAR, FlowCurve, FlowFit

#: What flows through a fluid in a field, and what a sensor or an amplifier has, is set by nobody.
_NO_FIELD = re.compile(r"leak|leck|fuite|fuga|density.*\ba\b|sensor|offset|漏", re.IGNORECASE)
#: A name whose end is a unit for sure: an A behind another word may be a sample's.
_SAYS_A_FIELD = re.compile(
    r"(?:current|voltage|field|strom|spannung|flux|e_?field|[IUBHE])(?:_|$)", re.IGNORECASE
)
_IN_A_LABEL = re.compile(
    rf"(?<![A-Za-z\d.])({NUMBER}) ?([kM]?V/mm|kV/cm|[kM]?V/m|k?A/m|kOe|Oe|G|{'|'.join(FIELD_UNITS)})(?![A-Za-z0-9/])"
)
_FAINT = 0.01  # of the strongest field: what stays below is no field
_FEWEST_FIELDS = 3  # above 0, that tell an exponent


@dataclass(frozen=True)
class Level:
    """A field that rows of a table have.

    Attributes:
        number: in its unit.
        unit: as written.
        is_set: whether all rows have the same number; a measured one scatters.
    """

    number: float
    unit: str
    is_set: bool


@dataclass(frozen=True)
class Growth:
    """How the yield stress grows with the field: ``factor * field**exponent``.

    Attributes:
        factor: in the unit of the curves' stresses, at a field of 1 in the curves' unit.
        exponent: its value.
        low, high: the exponent's 95 % interval, by how the yield stresses scatter about the power law.
        fields: how many fields tell it.
    """

    factor: float
    exponent: float
    low: float
    high: float
    fields: int


@dataclass(frozen=True)
class FieldSeries:
    """Curves of one file at several fields, by one law for all: yield stresses of different laws do not compare.

    Attributes:
        law: its name.
        unit: of the fields.
        curves: with the fit of that law, from the weakest field to the strongest.
        growth: None where fewer than three fields show a yield stress.
    """

    law: str
    unit: str
    curves: tuple[tuple[FlowCurve, FlowFit], ...]
    growth: Growth | None


def levels_in(table: Table) -> dict[str, Level]:
    """Columns that hold one field in all rows, by name."""
    levels: dict[str, Level] = {}
    for name, values in table.columns.items():
        unit = table.units.get(name) or (split_end(name)[1] if _SAYS_A_FIELD.match(name) else None)
        known = values[np.isfinite(values)]
        if not unit or not known.size or _NO_FIELD.search(name):
            continue
        try:
            is_field = units.fits(unit, SI_UNITS_OF_FIELDS)
        except UnitError:
            continue
        if is_field:
            levels[name] = Level(float(np.median(known)), unit, is_set=bool(np.ptp(known) == 0.0))
    return levels


def with_fields(
    curves: Sequence[FlowCurve],
    levels: Sequence[Mapping[str, Level]],
) -> tuple[list[FlowCurve], list[str]]:
    """Curves with the field of each, where a column or the labels tell it and the fields differ, and what told it.

    Args:
        curves: of a file.
        levels: of each curve, see `levels_in`.
    """
    # The column that tells the curves apart best: a set column before a measured one.
    best: tuple[bool, int] = (False, 1)  # whether it was set, and the number of different fields
    source = "their names"
    told: list[Level] = []  # of each curve
    for name in levels[0] if levels else ():
        if not all(name in of_curve for of_curve in levels):
            continue
        of_curves = [of_curve[name] for of_curve in levels]
        different = {f"{level.number:.3g}" for level in of_curves}
        rank = all(level.is_set for level in of_curves), len(different)
        if len(different) > 1 and rank > best:
            best = rank
            source = f"column {name!r}"
            told = of_curves
    # Labels such as ``tau_1kV`` or ``0.5 A`` hold the fields, if each of them holds one.
    in_labels = [_IN_A_LABEL.findall(curve.label) for curve in curves]
    if not told and all(len(fields) == 1 for fields in in_labels):
        for ((number, unit),) in in_labels:
            told.append(Level(number_of(number), FIELD_UNITS.get(unit) or unit, is_set=True))
    if len({level.number for level in told}) < 2 or len({level.unit for level in told}) > 1:
        return [*curves], []
    strongest = max(abs(level.number) for level in told)
    with_field: list[FlowCurve] = []
    for curve, level in zip(curves, told, strict=True):
        field = level.number if level.is_set or abs(level.number) > _FAINT * strongest else 0.0
        with_field.append(replace(curve, field=field, field_unit=level.unit))
    return with_field, [f"fields of the curves: by {source} [{told[0].unit}]"]


def series_of(fitted: Sequence[tuple[FlowCurve, Sequence[FlowFit]]]) -> FieldSeries | None:
    """The yield stress against the field; None for curves without fields.

    Args:
        fitted: the curves of a file, each with the fits of the same laws.
    """
    from scipy.special import stdtrit

    if not fitted or not all(curve.field_unit for curve, _ in fitted):
        return None
    by_law: dict[str, list[FlowFit]] = {}
    for _, fits in fitted:
        for fit in fits:
            by_law.setdefault(fit.law, []).append(fit)
    # Over all curves at once: in one curve alone an end that is left out and tells an exponent would decide.
    # Standard deviation of log10(stress) about the law, over all curves.
    errors: dict[str, float] = {}
    for law, fits in by_law.items():
        squares = sum(
            curve.rate.size * fit.log_rmse**2 for (curve, _), fit in zip(fitted, fits, strict=True)
        )
        spare = sum(
            curve.rate.size - len(fit.estimates)
            for (curve, _), fit in zip(fitted, fits, strict=True)
        )
        errors[law] = float(np.sqrt(squares / spare)) if spare > 0 else np.inf
    near = [law for law in by_law if errors[law] <= NEAR * min(errors.values())]

    def hidden(name: str) -> int:
        """In how many curves the law shows no yield stress: where another law shows one, the law does not fit."""
        return sum(not fit.yield_shown for fit in by_law[name])

    law = min(near, key=lambda name: (hidden(name), len(by_law[name][0].estimates), errors[name]))

    curves = [curve for curve, _ in fitted]
    by_field = sorted(zip(curves, by_law[law], strict=True), key=lambda pair: pair[0].field)

    # The power law through the yield stresses above no field, by least squares of logarithms.
    growth = None
    shown = [(curve.field, fit.yield_stress.value) for curve, fit in by_field if fit.yield_shown]
    points: Array = np.array([pair for pair in shown if pair[0] > 0.0]).reshape(-1, 2)
    fields = int(np.unique(points[:, 0]).size)
    if fields >= _FEWEST_FIELDS:
        log_field: Array = np.log(points[:, 0])
        log_stress: Array = np.log(points[:, 1])
        away = log_field - log_field.mean()
        square = away @ away
        exponent = float(away @ log_stress / square)
        offset = float(log_stress.mean() - exponent * log_field.mean())
        residual = log_stress - offset - exponent * log_field
        spare = residual.size - 2
        error = float(np.sqrt(residual @ residual / spare / square))
        half_width = float(np.asarray(stdtrit(spare, 0.975))) * error
        growth = Growth(
            factor=float(np.exp(offset)),
            exponent=exponent,
            low=exponent - half_width,
            high=exponent + half_width,
            fields=fields,
        )
    return FieldSeries(law, curves[0].field_unit, tuple(by_field), growth)

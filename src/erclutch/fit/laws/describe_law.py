"""A law's solution becomes its outcome: the model, each parameter with its interval, the published form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from erclutch.fit.intervals import Uncertainty
from erclutch.fit.laws.variable_projection import Projection, Separable, parameters
from erclutch.fit.levenberg_marquardt import Minimum
from erclutch.fit.outcome import Estimate, FitOutcome
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import ShapeParameter
from erclutch.models.model import Range
from erclutch.models.parameter_units import gain_in_user_units, in_user_units, unit_of_gain, unit_text
from erclutch.models.structure import Reference, Structure
from erclutch.signals.array import Array
from erclutch.signals.device import Units


@dataclass(frozen=True)
class Seen:
    """What a fit saw of its rows.

    Attributes:
        reference: what normalises the model.
        units: of the rows.
        covered: their range.
        rows: how many.
        cost: sum of squared residuals over all of them.
        extras: their further inputs that are the law's too.
    """

    reference: Reference
    units: Units
    covered: Range
    rows: int
    cost: float
    extras: Mapping[str, Array] = field(default_factory=dict[str, Array])


def described(
    structure: Structure,
    seen: Seen,
    problem: Separable,
    found: Minimum,
    projection: Projection,
    spread: Uncertainty,
    ends: tuple[Array, Array],
) -> FitOutcome[TorqueModel]:
    """The outcome of a law's fit.

    Args:
        structure: what was fitted.
        seen: the rows that it was fitted to.
        problem: for its shapes and gains alone.
        found: the minimum over the coordinates.
        projection: the gains there.
        spread: of the free parameters.
        ends: of the intervals of all parameters, those of the coordinates first, (k + p,) each.
    """
    q = parameters(problem.shapes, found.point)
    low, high = ends
    model = TorqueModel(
        structure=structure,
        reference=seen.reference,
        shape=dict(zip((s.name for s in problem.shapes), q, strict=True)),
        gains=dict(zip((g.name for g in problem.gains), projection.gains.tolist(), strict=True)),
        units=seen.units,
        trained_on=seen.covered,
        extra_ranges=tuple((float(x.min()), float(x.max())) for x in seen.extras.values()),
    )
    estimates = (
        *_shape_estimates(model, problem.shapes, found, (low[: len(q)], high[: len(q)])),
        *_gain_estimates(model, problem, projection, (low[len(q) :], high[len(q) :])),
    )
    return FitOutcome(
        model=model,
        stop=found.stop,
        iterations=found.iterations,
        estimates=estimates,
        paper_form=paper_form(model, estimates),
        rank=spread.rank,
        unknowns=spread.errors.size,
        condition=spread.condition,
        bandwidth=spread.bandwidth,
        train_cost=seen.cost,
        train_rows=seen.rows,
    )


def _shape_estimates(
    model: TorqueModel, shapes: tuple[ShapeParameter, ...], found: Minimum, ends: tuple[Array, Array]
) -> list[Estimate]:
    estimates: list[Estimate] = []
    for i, shape in enumerate(shapes):
        reach = [float(end[i]) for end in ends]
        if shape.scale == "log":
            reach = [np.exp(u) if np.isfinite(u) else u for u in reach]
        value, low, high = (
            in_user_units(v, shape.dimension, model.reference) for v in (model.shape[shape.name], *reach)
        )
        bound = "lower" if found.at_lower[i] else "upper" if found.at_upper[i] else None
        unit = unit_text(shape.dimension, model.units)
        estimates.append(Estimate(shape.name, shape.meaning, unit, value, float(low), float(high), bound))
    return estimates


def _gain_estimates(
    model: TorqueModel, full: Separable, projection: Projection, ends: tuple[Array, Array]
) -> list[Estimate]:
    estimates: list[Estimate] = []
    for i, gain in enumerate(full.gains):
        reach = (projection.gains[i], ends[0][i], ends[1][i])
        value, low, high = (gain_in_user_units(float(v), gain, model.reference) for v in reach)
        unit = unit_of_gain(gain, model.structure.extras, model.units)
        bound = "lower" if projection.held[i] and not projection.dead[i] else None
        estimates.append(Estimate(gain.name, gain.meaning, unit, value, low, high, bound))
    return estimates


def paper_form(model: TorqueModel, estimates: Sequence[Estimate]) -> dict[str, float]:
    """Published symbols in the data's units, an element at a time."""
    if model.structure.law.paper_form is None:
        return {}
    values = {e.name: e.value for e in estimates}
    names = [gain.name for gain in model.structure.law.gains]
    published: dict[str, float] = {}
    for i in range(model.structure.elements):
        tail = f"_{i + 1}" if model.structure.elements > 1 else ""
        gains = {name: values[f"{name}{tail}"] for name in names}
        for symbol, value in model.structure.law.paper_form(values, gains, model.reference.field).items():
            published[f"{symbol}{tail}"] = value
    return _shared_once(published, model.structure.elements)


def _shared_once(published: dict[str, float], elements: int) -> dict[str, float]:
    """A symbol that is the same for all elements is shared: it goes without their numbers."""
    shared = {
        name.removesuffix("_1"): value
        for name, value in published.items()
        if elements > 1 and name.endswith("_1") and published.get(f"{name.removesuffix('_1')}_2") == value
    }
    own = {name: value for name, value in published.items() if name.rpartition("_")[0] not in shared}
    return {**own, **shared}

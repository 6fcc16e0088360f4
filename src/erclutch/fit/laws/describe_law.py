"""A law's solution becomes its outcome: the model, each parameter with its interval, the published form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from erclutch.fit.intervals import Uncertainty
from erclutch.fit.laws.variable_projection import Projection, Separable, parameters
from erclutch.fit.levenberg_marquardt import Minimum
from erclutch.fit.outcome import Estimate, FitOutcome
from erclutch.models.law_model import Range, Reference, Structure, TorqueModel, in_user_units, unit_text
from erclutch.models.laws import ShapeParameter
from erclutch.signals.array import Array, Mask
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
    moving: Mask,
) -> FitOutcome[TorqueModel]:
    """The outcome of a law's fit.

    Args:
        structure: what was fitted.
        seen: the rows that it was fitted to.
        problem: for its shapes and gains alone.
        found: the minimum over the coordinates.
        projection: the gains there.
        spread: standard errors of the free parameters, those of the coordinates first.
        moving: which coordinates are free, shape (k,).
    """
    q = parameters(problem.shapes, found.point)
    widths = spread.quantile * spread.errors
    shape_widths, gain_widths = np.full(len(q), np.nan), np.full(projection.gains.size, np.nan)
    shape_widths[moving] = widths[: int(moving.sum())]
    gain_widths[~projection.held] = widths[int(moving.sum()) :]
    gain_widths[projection.dead] = np.inf
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
        *_shape_estimates(model, problem.shapes, found, shape_widths),
        *_gain_estimates(model, problem, projection, gain_widths),
    )
    return FitOutcome(
        model=model,
        stop=found.stop,
        iterations=found.iterations,
        estimates=estimates,
        paper_form=_paper_form(model, estimates),
        rank=spread.rank,
        unknowns=widths.size,
        condition=spread.condition,
        bandwidth=spread.bandwidth,
        train_cost=seen.cost,
        train_rows=seen.rows,
    )


def _shape_estimates(
    model: TorqueModel, shapes: tuple[ShapeParameter, ...], found: Minimum, widths: Array
) -> list[Estimate]:
    estimates: list[Estimate] = []
    for i, shape in enumerate(shapes):
        u, width = float(found.point[i]), float(widths[i])
        with np.errstate(over="ignore"):
            ends = (np.exp(u - width), np.exp(u + width)) if shape.scale == "log" else (u - width, u + width)
        if np.isfinite(width) and shape.lower == 0.0:
            ends = (max(ends[0], 0.0), ends[1])
        value, low, high = (
            in_user_units(v, shape.dimension, model.reference) for v in (model.shape[shape.name], *ends)
        )
        bound = "lower" if found.at_lower[i] else "upper" if found.at_upper[i] else None
        unit = unit_text(shape.dimension, model.units)
        estimates.append(Estimate(shape.name, shape.meaning, unit, value, float(low), float(high), bound))
    return estimates


def _gain_estimates(model: TorqueModel, full: Separable, projection: Projection, widths: Array) -> list[Estimate]:
    estimates: list[Estimate] = []
    for i, gain in enumerate(full.gains):
        c, width = float(projection.gains[i]), float(widths[i])
        least = max(c - width, 0.0) if gain.nonnegative and np.isfinite(width) else c - width
        scale = 1.0 if gain.extra is None else model.reference.extras[gain.extra]
        value, low, high = (in_user_units(v, gain.dimension, model.reference) / scale for v in (c, least, c + width))
        bound = "lower" if projection.held[i] and not projection.dead[i] else None
        estimates.append(
            Estimate(gain.name, gain.meaning, unit_text(gain.dimension, model.units), value, low, high, bound)
        )
    return estimates


def _paper_form(model: TorqueModel, estimates: Sequence[Estimate]) -> dict[str, float]:
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

"""A law's solution becomes its outcome: the model, each parameter with its interval, the published form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from erclutch.fit.solver.intervals import Uncertainty
from erclutch.fit.solver.levenberg_marquardt import Minimum
from erclutch.fit.solver.outcome import Estimate, FitOutcome
from erclutch.fit.solver.variable_projection import Projection, Separable, parameters
from erclutch.models.law_model import TorqueModel
from erclutch.models.model import Range
from erclutch.models.parameter_units import (
    gain_in_user_units,
    in_user_units,
    unit_of_gain,
    unit_text,
)
from erclutch.models.structure import Reference, Structure
from erclutch.signals.array import Array
from erclutch.signals.device import Units
from erclutch.signals.units import UNKNOWN


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
        extra_units: of these inputs, as far as somebody gave them.
    """

    reference: Reference
    units: Units
    covered: Range
    rows: int
    cost: float
    extras: Mapping[str, Array] = field(default_factory=dict[str, Array])
    extra_units: Mapping[str, str] = field(default_factory=dict[str, str])


def described(
    structure: Structure,
    seen: Seen,
    problem: Separable,
    minimum: Minimum,
    projection: Projection,
    spread: Uncertainty,
    ends: tuple[Array, Array],
) -> FitOutcome[TorqueModel]:
    """The outcome of a law's fit.

    Args:
        structure: what was fitted.
        seen: the rows that it was fitted to.
        problem: for its shapes and gains alone.
        minimum: the minimum over the coordinates.
        projection: the gains there.
        spread: of the free parameters.
        ends: of the intervals of all parameters, those of the coordinates first, (k + p,) each.
    """
    q = parameters(problem.shapes, minimum.point)
    shape_names = [shape.name for shape in problem.shapes]
    gain_names = [gain.name for gain in problem.gains]
    ranges = [(float(values.min()), float(values.max())) for values in seen.extras.values()]
    model = TorqueModel(
        structure=structure,
        reference=seen.reference,
        shape=dict(zip(shape_names, q, strict=True)),
        gains=dict(zip(gain_names, projection.gains.tolist(), strict=True)),
        units=seen.units,
        trained_on=seen.covered,
        extra_ranges=tuple(ranges),
        units_as_logged=tuple(seen.extra_units.get(name, UNKNOWN) for name in seen.extras),
    )

    # Nonlinear parameters: the ends of their intervals are the solver's coordinates.
    low, high = ends
    estimates: list[Estimate] = []
    for i, shape in enumerate(problem.shapes):
        numbers = [model.shape[shape.name]]
        for end in (float(low[i]), float(high[i])):
            logarithm = shape.scale == "log" and np.isfinite(end)  # an infinite end stays
            numbers.append(np.exp(end) if logarithm else end)
        value, from_, to = (
            in_user_units(number, shape.dimension, model.reference) for number in numbers
        )
        bound = None
        if minimum.at_upper[i]:
            bound = "upper"
        if minimum.at_lower[i]:
            bound = "lower"
        estimate = Estimate(
            name=shape.name,
            meaning=shape.meaning,
            unit=unit_text(shape.dimension, model.units),
            value=value,
            low=float(from_),
            high=float(to),
            at_bound=bound,
        )
        estimates.append(estimate)

    # Gains: the ends of their intervals are normalised.
    k = len(q)
    for i, gain in enumerate(problem.gains):
        numbers = [projection.gains[i], low[k + i], high[k + i]]
        value, from_, to = (
            gain_in_user_units(float(number), gain, model.reference) for number in numbers
        )
        # A gain that nothing excites is zero for another reason than its bound; one that was left out is known.
        left_out = i in problem.pinned
        if left_out:
            value = from_ = to = 0.0
        at_bound = left_out or (projection.held[i] and not projection.dead[i])
        estimate = Estimate(
            name=gain.name,
            meaning=gain.meaning,
            unit=unit_of_gain(gain, model.units, model.extra_units),
            value=value,
            low=from_,
            high=to,
            at_bound="lower" if at_bound else None,
        )
        estimates.append(estimate)
    return FitOutcome(
        model=model,
        stop=minimum.stop,
        iterations=minimum.iterations,
        estimates=tuple(estimates),
        paper_form=paper_form(model, estimates),
        rank=spread.rank,
        unknowns=spread.errors.size,
        condition=spread.condition,
        bandwidth=spread.bandwidth,
        train_cost=seen.cost,
        train_rows=seen.rows,
    )


def paper_form(model: TorqueModel, estimates: Sequence[Estimate]) -> dict[str, float]:
    """Published symbols in the data's units, an element at a time."""
    law = model.structure.law
    if law.paper_form is None:
        return {}
    values = {estimate.name: estimate.value for estimate in estimates}
    elements = model.structure.elements
    names_of = model.structure.names_of
    published: dict[str, float] = {}
    for element in range(elements):
        gains = {gain.name: values[names_of(gain.name)[element]] for gain in law.gains}
        paper_numbers = law.paper_form(values, gains, model.reference.field)
        for symbol, value in paper_numbers.items():
            published[names_of(symbol)[element]] = value
    if elements == 1:
        return published

    # A symbol that is the same for all elements is shared: it goes without their numbers, behind the others.
    shared: dict[str, float] = {}
    for name, value in published.items():
        symbol = name.removesuffix("_1")
        if symbol != name and published.get(f"{symbol}_2") == value:
            shared[symbol] = value
    own: dict[str, float] = {}
    for name, value in published.items():
        symbol, _, _ = name.rpartition("_")
        if symbol not in shared:
            own[name] = value
    return own | shared

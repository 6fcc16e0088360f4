"""A law's least-squares problem on rows: all at once, or without dynamics in slices that stay in the cache."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.laws.twin_gains import twin_gains
from erclutch.fit.solver.levenberg_marquardt import Minimum
from erclutch.fit.solver.variable_projection import (
    Projection,
    Separable,
    corrected,
    gains_of,
    linearised,
    no_gains,
    parameters,
    triangle_over,
)
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import ShapeParameter
from erclutch.models.structure import Reference, Structure
from erclutch.signals.array import Array, Mask

_SLICE = 16_384  # rows that stay in the cache


def separable(
    data: Dataset,
    structure: Structure,
    reference: Reference,
    shapes: tuple[ShapeParameter, ...],
    rows: slice | NDArray[np.intp],
    without: Collection[str] = (),
) -> Separable:
    """The problem on some rows. The dynamics run over all rows of their spans: the fluid feels the whole command.

    Gains whose names are in ``without`` stay at zero, as one of two whose columns are the same.
    """
    if not isinstance(rows, slice):
        # Each span begins anew: those without any of the rows can go.
        wanted = np.zeros(data.rows, np.bool_)
        wanted[rows] = True
        touched = np.zeros(data.rows, np.bool_)
        for span in data.clock.spans:
            within = slice(span.start, span.stop)
            touched[within] = wanted[within].any()
        kept = data.with_neighbours(touched)
        if not data.in_no_time and not kept.all() and kept[rows].all():
            place = np.cumsum(kept) - 1  # of a row among those that are kept
            rows = place[rows]
            data = data.take(kept)

    def columns(q: Sequence[Any]) -> Sequence[Any]:
        return structure.columns(
            data.elements, data.clock, reference, q, rows, extras=data.extras, ahead=True
        )

    def behind(effort: Any, q: Sequence[Any]) -> Any:
        return structure.behind(effort, data.clock, q, rows)

    slow = any(stage.place == "effort" for stage in structure.stages)
    gains = structure.gains()
    zero = twin_gains(structure).union(without)
    return Separable(
        columns,
        data.effort[rows],
        shapes,
        gains,
        behind if slow else None,
        pinned={place: 0.0 for place, gain in enumerate(gains) if gain.name in zero},
    )


def closed_in_slices(
    data: Dataset,
    structure: Structure,
    reference: Reference,
    shapes: tuple[ShapeParameter, ...],
    minimum: Minimum,
) -> tuple[Projection, Array, float]:
    """The gains at a minimum over the nonlinear parameters, for a law without dynamics.

    Returns:
        The gains, the triangle of free columns and derivatives, and the sum of squared residuals.
    """
    with np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"):
        problems: list[Separable] = []  # of each slice
        for at in range(0, data.rows, _SLICE):
            some = data.picked(slice(at, at + _SLICE))
            problems.append(separable(some, structure, reference, shapes, slice(None)))
        q = parameters(shapes, minimum.point)
        r = triangle_over(problem.values(problem.columns(q), q) for problem in problems)
        signs = [gain.nonnegative for gain in structure.gains()]
        nonnegative: Mask = np.array(signs, np.bool_)
        p = nonnegative.size
        finite = np.isfinite(r).all()
        projection = gains_of(r, nonnegative) if finite else no_gains(p)
        moving = ~(minimum.at_lower | minimum.at_upper)
        products: list[list[Array]] = []  # of each free column with the residual, slice by slice
        cost = 0.0

        def matrices() -> Iterator[Array]:
            nonlocal cost
            for problem in problems:
                stacked, slopes, _ = linearised(problem, minimum.point, projection)
                columns = stacked[:, :-1]
                target = stacked[:, -1]
                residual = target - columns @ projection.gains
                free = columns.T[~projection.held]
                products.append([column * residual for column in free])
                cost += float(residual @ residual)
                yield np.vstack([free, slopes.T[moving]]).T

        triangle = triangle_over(matrices())
    of_columns = [np.concatenate(slices) for slices in zip(*products, strict=True)]
    slope = np.array([float(np.sum(product)) for product in of_columns])
    better = corrected(projection, triangle, slope)
    # The cost after a step d of the gains: cost + |R d|^2 - 2 d' slope, without another pass over the rows.
    step = (better.gains - projection.gains)[~projection.held]
    moved = triangle[:, : step.size] @ step
    cost += float(np.sum(moved**2)) - 2.0 * float(step @ slope)
    return better, triangle, cost

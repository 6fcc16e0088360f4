"""A law's problem over all rows, range by range: each pass gives the triangle of each range, joined in their order.

A law with a memory runs over the rows in their order: its states, and their derivatives, go from range to range.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial, reduce
from typing import Any

import numpy as np

from erclutch.fit.laws.variable_projection import (
    Projection,
    Separable,
    beside,
    coordinates,
    corrected,
    gains_of,
    linearised,
    local_model,
    parameters,
    triangle_of,
    triangle_over,
)
from erclutch.fit.levenberg_marquardt import Linearisation, Minimum, Problem
from erclutch.logs.dataset import Dataset
from erclutch.logs.disk_rows import RANGE, DiskRows, Stretch
from erclutch.models.law_model import Reference, Structure
from erclutch.models.laws import ShapeParameter
from erclutch.signals.array import Array, Mask


def separable(
    data: Dataset, structure: Structure, reference: Reference, shapes: tuple[ShapeParameter, ...], rows: slice
) -> Separable:
    """The problem on some rows. The dynamics run over all of them: the fluid feels the whole command."""

    def columns(q: Sequence[Any]) -> Sequence[Any]:
        return structure.columns(data.elements, data.clock, reference, q, rows, extras=data.extras, ahead=True)

    def behind(effort: Any, q: Sequence[Any]) -> Any:
        return structure.behind(effort, data.clock, q, rows)

    slow = any(stage.place == "effort" for stage in structure.stages)
    return Separable(columns, data.effort[rows], shapes, structure.gains(), behind if slow else None)


@dataclass(frozen=True)
class RowsInSlices:
    """Rows in memory, in slices that stay in the cache, for laws without dynamics."""

    data: Dataset

    def stretches(self, of: Callable[[Iterable[Stretch]], Any], *, past: bool) -> Iterator[Any]:
        """What a function makes of each range of rows, in their order; no range needs its past."""
        rows = self.data.rows
        for start in range(0, rows, RANGE):
            slices = (slice(at, min(at + _SLICE, rows)) for at in range(start, min(start + RANGE, rows), _SLICE))
            yield of((self.data.picked(some), slice(None)) for some in slices)


_SLICE = 16384


@dataclass(frozen=True)
class LawOverRows:
    """The problem over all rows.

    Attributes:
        data: the rows.
        structure, reference, shapes: see `separable`.
    """

    data: DiskRows | RowsInSlices
    structure: Structure
    reference: Reference
    shapes: tuple[ShapeParameter, ...]
    _known: dict[bytes, Projection] = field(default_factory=dict[bytes, Projection], repr=False)

    def projected(self, u: Array) -> Projection:
        """Best gains at some coordinates; those of the last two points are kept."""
        key = u.tobytes()
        if key not in self._known:
            r: Array = reduce(_joined, self._ranges(partial(_triangle, partial(_plain, parameters(self.shapes, u)))))
            p = len(self.structure.gains())
            while len(self._known) > 1:
                del self._known[next(iter(self._known))]
            nonnegative: Mask = np.array([gain.nonnegative for gain in self.structure.gains()], np.bool_)
            unusable = Projection(np.zeros(p), np.ones(p, np.bool_), np.zeros(p, np.bool_), np.inf)
            self._known[key] = gains_of(r, nonnegative) if np.isfinite(r).all() else unusable
        return self._known[key]

    @property
    def outer(self) -> Problem:
        """The problem over the coordinates, for `minimise`."""
        lower, upper = (coordinates(self.shapes, [getattr(s, end) for s in self.shapes]) for end in ("lower", "upper"))

        def linearise(u: Array) -> Linearisation:
            projection = self.projected(u)
            r = reduce(_joined, self._ranges(partial(_triangle, partial(_sloped, u, projection))))
            return local_model(r, projection)

        return Problem(lambda u: self.projected(u).cost, linearise, lower, upper)

    def closed(self, found: Minimum, projection: Projection) -> tuple[Projection, Array, float]:
        """The corrected gains, the triangle of free columns and derivatives, and the sum of squared residuals."""
        moving = ~(found.at_lower | found.at_upper)
        ranges = list(self._ranges(partial(_closing, found.point, moving, projection)))
        triangle = reduce(_joined, (triangle for triangle, _, _ in ranges))
        slope: Array = np.sum([slope for _, slope, _ in ranges], axis=0)
        better, free = corrected(projection, triangle, slope), ~projection.held
        step = (better.gains - projection.gains)[free]
        cost = sum(missed for _, _, missed in ranges)
        cost += float(np.sum((triangle[:, : step.size] @ step) ** 2)) - 2.0 * float(step @ slope)
        return better, triangle, cost

    def _ranges(self, of: Callable[[_Problems], Any]) -> Iterator[Any]:
        past = any(stage.place != "temperature" for stage in self.structure.stages)
        posed = partial(_posed, self.structure, self.reference, self.shapes, of)
        return self.data.stretches(posed, past=past)


#: The problem on the stretches of a range.
_Problems = Iterable[Separable]


def _posed(
    structure: Structure,
    reference: Reference,
    shapes: tuple[ShapeParameter, ...],
    of: Callable[[_Problems], Any],
    stretches: Iterable[Stretch],
) -> Any:
    with np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"):
        return of(separable(data, structure, reference, shapes, rows) for data, rows in stretches)


def _joined(upper: Array, lower: Array) -> Array:
    return triangle_of(np.vstack([upper, lower]))


def _triangle(matrix_of: Callable[[Separable], Array], problems: _Problems) -> Array:
    return triangle_over(map(matrix_of, problems))


def _plain(q: Sequence[float], problem: Separable) -> Array:
    return problem.values(problem.columns(q), q)


def _sloped(u: Array, projection: Projection, problem: Separable) -> Array:
    stacked, slopes, _ = linearised(problem, u, projection)
    return beside(stacked, slopes, projection)


def _closing(u: Array, moving: Mask, projection: Projection, problems: _Problems) -> tuple[Array, Array, float]:
    """Triangle of free columns and derivatives, what is left along each free column, and its square."""
    products: list[list[Array]] = []
    squares: list[float] = []

    def matrices() -> Iterator[Array]:
        for problem in problems:
            stacked, slopes, _ = linearised(problem, u, projection)
            free, left = stacked.T[:-1][~projection.held], stacked[:, -1] - stacked[:, :-1] @ projection.gains
            products.append([column * left for column in free])
            squares.append(float(left @ left))
            yield np.vstack([free, slopes.T[moving]]).T

    triangle = triangle_over(matrices())
    slope = [float(np.sum(np.concatenate(parts))) for parts in zip(*products, strict=True)]
    return triangle, np.array(slope), sum(squares)

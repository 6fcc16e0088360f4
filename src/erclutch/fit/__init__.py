"""Fitting a structure to a data set: scan, then variable projection on few rows, then on all rows.

The scan looks at the whole box of the nonlinear parameters on a few thousand rows; the best points are refined on those
rows and the best of them polished on all rows, so the figures reported are always those of the full data.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.dataset import Dataset
from erclutch.fit.compress import compress
from erclutch.fit.describe import Seen, described
from erclutch.fit.intervals import uncertainty, unknown
from erclutch.fit.law_cells import on_cells, signed_rows, spaced_rows
from erclutch.fit.lm import Minimum, minimise
from erclutch.fit.outcome import Estimate, FitOutcome
from erclutch.fit.ranges import period_of, range_of
from erclutch.fit.starts import scan_points, thinned, windows
from erclutch.fit.varpro import (
    Separable,
    coordinates,
    jacobian,
    outer_problem,
    parameters,
    project,
    refined,
)
from erclutch.laws import Shape
from erclutch.model import Reference, Structure, TorqueModel

Array = NDArray[np.float64]

__all__ = ["Estimate", "FitOutcome", "fit_structure", "reference_of"]

SCAN_ROWS, _ROUGH_ROWS = 1500, 6000
_MIDDLE_ROWS = 40000  # of a long log: the last steps, on all rows, then start next to the minimum
MANY_ROWS = 100_000  # from here on centroids stand for the rows where they can
SCAN_POINTS = 48
_ROUGH_STARTS = 3


def reference_of(data: Dataset) -> Reference:
    """What normalises a model that is trained on this data."""
    field = max(float(np.max(np.abs(e.field))) for e in data.elements)
    slip = float(np.sqrt(np.mean([np.mean(e.slip**2) for e in data.elements])))
    return Reference(field or 1.0, slip or 1.0, period_of(data))


def fit_structure(
    data: Dataset,
    structure: Structure,
    *,
    starts: Sequence[Sequence[float]] = (),
    scan: int = SCAN_POINTS,
    ordered: bool = True,
    intervals: bool = True,
    polish: bool = False,
) -> FitOutcome[TorqueModel]:
    """Fit a structure's parameters by least squares.

    Args:
        data: training rows.
        structure: device, law and dynamics.
        starts: normalised nonlinear parameters to try besides the scan.
        scan: points of the scan for each nonlinear parameter beyond the first two, at least.
        ordered: whether rows follow in time (decides on how intervals are made).
        intervals: whether to make intervals; without they are nan, and a fit takes half the time.
        polish: whether the nonlinear parameters of a memoryless law are refined on all rows of a long log, and not only
            on its centroids. Gains and figures are always of all rows.

    Returns:
        The model with its intervals and how the solver ended. Deterministic for the same data and arguments.
    """
    reference = reference_of(data)
    shapes = structure.shapes(reference.period)
    # A lag needs neighbouring rows, so it is searched in windows; without one, rows from all over tell more.
    full = _separable(data, structure, reference, shapes, slice(None))
    if not shapes:
        return _outcome(data, structure, reference, full, LINEAR, ordered, intervals)
    cells = _on_centroids(data, structure, reference, shapes)
    some = data if structure.dynamics == "none" else data.take(windows(data.rows, 2 * _ROUGH_ROWS))
    few, rough, middle = (
        _separable(some, structure, reference, shapes, thinned(some.rows, most))
        for most in (SCAN_ROWS, _ROUGH_ROWS, _MIDDLE_ROWS)
    )
    # A step's threshold has no slope to follow between the levels of the command: only the scan finds it.
    best = search(few, cells or rough, starts, scan * (4 if structure.law.stimulus_shape else 1))
    if cells is not None and not polish:
        found = minimise(outer_problem(cells), best, tolerance=1e-8, max_iterations=100)
        return _outcome(data, structure, reference, full, found, ordered, intervals)
    if data.rows > 2 * _MIDDLE_ROWS and structure.dynamics == "none":
        best = minimise(outer_problem(middle), best, tolerance=1e-8, max_iterations=100).point
    found = minimise(outer_problem(full), best, tolerance=1e-8, max_iterations=100)
    return _outcome(data, structure, reference, full, found, ordered, intervals)


LINEAR = Minimum(np.zeros(0), np.nan, "converged", 1, np.zeros(0, np.bool_), np.zeros(0, np.bool_))


def _separable(
    data: Dataset, structure: Structure, reference: Reference, shapes: tuple[Shape, ...], rows: slice
) -> Separable:
    """The problem on some rows. The dynamics run over all of them: the fluid feels the whole command."""

    def columns(q: Sequence[Any]) -> Sequence[Any]:
        return structure.columns(data.elements, data.clock, reference, q, rows)

    return Separable(columns, data.effort[rows], shapes, structure.gains())


def _on_centroids(
    data: Dataset, structure: Structure, reference: Reference, shapes: tuple[Shape, ...]
) -> Separable | None:
    """The problem on weighted centroids; None where rows are few, matter in their order, or a law steps in a cell."""
    both = len(data.elements) > 1 and bool(np.any((data.elements[0].field != 0) & (data.elements[1].field != 0)))
    if structure.law.stimulus_shape or structure.dynamics != "none" or both or data.rows < MANY_ROWS:
        return None
    rows = signed_rows(data.elements)
    return on_cells(compress(rows, data.effort, 2, spaced_rows(rows, reference)), structure, reference, shapes)


def search(few: Separable, rough: Separable, starts: Sequence[Sequence[float]], scan: int) -> Array:
    """Coordinates of the best minimum on some of the rows: a scan on few, local solvers from its best on more."""
    lower, upper = few.bounds
    given = [np.clip(coordinates(few.shapes, q), lower, upper) for q in starts]
    low, high = (coordinates(few.shapes, [s.scanned[end] for s in few.shapes]) for end in (0, 1))
    points = [*given, *scan_points(low, high, scan * max(1, lower.size - 1))]
    costs = [project(few, parameters(few.shapes, u)).cost for u in points]
    candidates = given + [points[i] for i in np.argsort(costs, kind="stable")[:_ROUGH_STARTS]]
    minima = [minimise(outer_problem(rough), u, tolerance=1e-6, max_iterations=40) for u in candidates]
    return min(minima, key=lambda m: m.cost).point


def _outcome(
    data: Dataset,
    structure: Structure,
    reference: Reference,
    full: Separable,
    found: Minimum,
    ordered: bool,
    intervals: bool,
) -> FitOutcome[TorqueModel]:
    columns, slopes, projection = jacobian(full, found.point)
    projection = refined(columns, full.target, projection)
    residual = full.target - columns @ projection.gains
    moving = ~(found.at_lower | found.at_upper)
    free = np.column_stack([slopes[:, moving], columns[:, ~projection.held]])
    spread = uncertainty(free, residual, ordered=ordered) if intervals else unknown(free)
    seen = Seen(reference, data.units, range_of(data), data.rows, float(residual @ residual))
    return described(structure, seen, full, found, projection, spread, moving)

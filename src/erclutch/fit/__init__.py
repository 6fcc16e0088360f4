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
from erclutch.device import Element
from erclutch.dynamics import Clock
from erclutch.fit.compress import compress
from erclutch.fit.intervals import uncertainty, unknown
from erclutch.fit.lm import Minimum, minimise
from erclutch.fit.outcome import Estimate, FitOutcome
from erclutch.fit.ranges import range_of
from erclutch.fit.starts import scan_points, thinned, windows
from erclutch.fit.varpro import (
    Projection,
    Separable,
    coordinates,
    jacobian,
    outer_problem,
    parameters,
    project,
    refined,
)
from erclutch.laws import Shape
from erclutch.model import Reference, Structure, TorqueModel, in_user_units, unit_text

Array = NDArray[np.float64]

__all__ = ["Estimate", "FitOutcome", "fit_structure", "reference_of"]

_SCAN_ROWS, _ROUGH_ROWS = 1500, 6000
_MIDDLE_ROWS = 40000  # of a long log: the last steps, on all rows, then start next to the minimum
_MANY_ROWS = 100_000  # from here on centroids stand for the rows where they can
_NARROW = 0.003  # slip, over its root mean square, below which cells are equally wide
_SCAN_POINTS = 48
_ROUGH_STARTS = 3


def reference_of(data: Dataset) -> Reference:
    """What normalises a model that is trained on this data."""
    field = max(float(np.max(np.abs(e.field))) for e in data.elements)
    slip = float(np.sqrt(np.mean([np.mean(e.slip**2) for e in data.elements])))
    steps = [s.period for s in data.clock.spans if s.period is not None]
    period = float(np.median(steps)) if steps else float(np.median(np.diff(data.clock.time)))
    return Reference(field or 1.0, slip or 1.0, period)


def fit_structure(
    data: Dataset,
    structure: Structure,
    *,
    starts: Sequence[Sequence[float]] = (),
    scan: int = _SCAN_POINTS,
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
        return _outcome(data, structure, reference, full, _LINEAR, ordered, intervals)
    cells = _on_centroids(data, structure, reference, shapes)
    some = data if structure.dynamics == "none" else data.take(windows(data.rows, 2 * _ROUGH_ROWS))
    few, rough, middle = (
        _separable(some, structure, reference, shapes, thinned(some.rows, most))
        for most in (_SCAN_ROWS, _ROUGH_ROWS, _MIDDLE_ROWS)
    )
    # A step's threshold has no slope to follow between the levels of the command: only the scan finds it.
    best = _search(few, cells or rough, starts, scan * (4 if structure.law.stimulus_shape else 1))
    if cells is not None and not polish:
        found = minimise(outer_problem(cells), best, tolerance=1e-8, max_iterations=100)
        return _outcome(data, structure, reference, full, found, ordered, intervals)
    if data.rows > 2 * _MIDDLE_ROWS and structure.dynamics == "none":
        best = minimise(outer_problem(middle), best, tolerance=1e-8, max_iterations=100).point
    found = minimise(outer_problem(full), best, tolerance=1e-8, max_iterations=100)
    return _outcome(data, structure, reference, full, found, ordered, intervals)


_LINEAR = Minimum(np.zeros(0), np.nan, "converged", 1, np.zeros(0, np.bool_), np.zeros(0, np.bool_))


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
    fields, slips = [e.field for e in data.elements], [e.slip for e in data.elements]
    both = len(fields) > 1 and bool(np.any((fields[0] != 0) & (fields[1] != 0)))
    if structure.law.stimulus_shape or structure.dynamics != "none" or both or data.rows < _MANY_ROWS:
        return None
    signed = fields[0] - fields[1] if len(fields) > 1 else fields[0]
    # Laws bend most where the slip is small: cells narrow towards zero.
    spread = [np.arcsinh(slip / (_NARROW * reference.slip)) for slip in slips]
    cells = compress(np.array([signed, *slips]), data.effort, 2, np.array([signed, *spread]))
    parts = [np.maximum(cells.x[0], 0.0), np.maximum(-cells.x[0], 0.0)] if len(fields) > 1 else [cells.x[0]]
    elements = [Element(field, slip) for field, slip in zip(parts, cells.x[1:], strict=True)]
    clock, root = Clock(np.arange(float(cells.y.size)), ()), np.sqrt(cells.count)

    def columns(q: Sequence[Any]) -> Sequence[Any]:
        return [column * root for column in structure.columns(elements, clock, reference, q)]

    return Separable(columns, cells.y * root, shapes, structure.gains())


def _search(few: Separable, rough: Separable, starts: Sequence[Sequence[float]], scan: int) -> Array:
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
    q = parameters(full.shapes, found.point)
    widths = spread.quantile * spread.errors
    shape_widths, gain_widths = np.full(len(q), np.nan), np.full(projection.gains.size, np.nan)
    shape_widths[moving] = widths[: int(moving.sum())]
    gain_widths[~projection.held] = widths[int(moving.sum()) :]
    gain_widths[projection.dead] = np.inf
    model = TorqueModel(
        structure=structure,
        reference=reference,
        shape=dict(zip((s.name for s in full.shapes), q, strict=True)),
        gains=dict(zip((g.name for g in full.gains), projection.gains.tolist(), strict=True)),
        units=data.units,
        trained_on=range_of(data),
    )
    estimates = (
        *_shape_estimates(model, full.shapes, found, shape_widths),
        *_gain_estimates(model, full, projection, gain_widths),
    )
    return FitOutcome(
        model=model,
        stop=found.stop,
        iterations=found.iterations,
        estimates=estimates,
        paper_form=_paper_form(model, estimates),
        rank=spread.rank,
        unknowns=free.shape[1],
        condition=spread.condition,
        bandwidth=spread.bandwidth,
        train_cost=float(residual @ residual),
        train_rows=data.rows,
    )


def _shape_estimates(model: TorqueModel, shapes: tuple[Shape, ...], found: Minimum, widths: Array) -> list[Estimate]:
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
        value, low, high = (in_user_units(v, gain.dimension, model.reference) for v in (c, least, c + width))
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

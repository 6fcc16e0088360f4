"""Fits to rows on disk: the same steps as in memory, each a pass over the rows block by block.

Ranges and means first, then the centroids of all levels, the fit on these, and last the gains of a law or the output
weights of an RBFN and the sum of squares, all from all rows. Memory does not grow with the rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.dataset import Dataset
from erclutch.errors import CheckError, SettingError
from erclutch.fit import LINEAR, MANY_ROWS, SCAN_POINTS, SCAN_ROWS, fit_structure, search
from erclutch.fit.compress import Centroids, Grid, Totals, grid_of
from erclutch.fit.describe import Seen, described
from erclutch.fit.intervals import Uncertainty, unknown
from erclutch.fit.law_cells import on_cells, signed_rows, spaced_rows
from erclutch.fit.lm import Minimum, Stop, minimise
from erclutch.fit.network import schedule_for, train_on
from erclutch.fit.networks import (
    Extent,
    centres_on,
    extent_of,
    fnn_tables,
    outcome_of,
    rbfn_levels,
    rbfn_tables_for,
    require_finite,
    require_rows,
    require_varied,
    scaling_for,
    slips_for,
    slips_of,
    spaced_by,
)
from erclutch.fit.outcome import FitOutcome
from erclutch.fit.ranges import range_of
from erclutch.fit.rbfn import weights_over
from erclutch.fit.varpro import (
    Projection,
    Separable,
    gains_of,
    jacobian,
    outer_problem,
    parameters,
    stack,
    triangle_of,
)
from erclutch.model import Range, Reference, Structure, TorqueModel
from erclutch.networks import NetworkStructure
from erclutch.networks.inputs import inputs_of
from erclutch.networks.model import NetworkModel, Scaling
from erclutch.spool import Spool

Array = NDArray[np.float64]

_MOST_CELLS = 4_000_000  # of a grid: 32 bytes each and more


def refuse_structure(structure: Structure | NetworkStructure) -> None:
    """Raise a SettingError for a model that cannot be fitted block by block."""
    name, why = structure.specification, ""
    if structure.dynamics != "none":
        why = f"its dynamics ({structure.dynamics}) need each row's past"
    elif isinstance(structure, Structure):
        if structure.law.stimulus_shape:
            why = "its stimulus steps or saturates inside cells, so centroids cannot stand for the rows"
    elif structure.past:
        why = "past samples need each row's past"
    elif np.prod([float(n) for n in grid_of(len(structure.inputs), 2)]) > _MOST_CELLS:
        why = f"a grid over its {len(structure.inputs)} inputs has more than {_MOST_CELLS:,} cells"
    if why:
        raise SettingError(
            f"{name} cannot be fitted to a log that is larger than memory: {why}",
            remedy="Fit it to a part of the log with erclutch fit, or leave it out",
        )


# --- networks ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Inputs:
    """A network's rows, block by block."""

    spool: Spool
    structure: NetworkStructure

    def of(self, block: Dataset) -> Array:
        return inputs_of(self.structure, block.elements, block.clock, block.extras, {})

    def each(self) -> Iterator[tuple[Dataset, Array]]:
        return ((block, self.of(block)) for block in self.spool.blocks())

    def extent(self) -> tuple[Extent, Range]:
        """Of the inputs, and of the device's signals; refuses what is not finite."""
        extent: Extent | None = None
        covered: Range | None = None
        for block, x in self.each():
            require_finite(x, block.effort, self.structure, self.spool.where)
            own = extent_of(x, block.effort)
            extent = own if extent is None else extent.joined(own)
            covered = _wider(covered, range_of(block))
        assert extent is not None
        assert covered is not None
        return extent, covered

    def means(self) -> tuple[float, dict[int, float]]:
        """Of the effort, and of each slip's square."""

        def of(block: Dataset) -> Sequence[Array]:
            return [block.effort, *(slip**2 for slip in slips_of(self.structure, self.of(block)).values())]

        middle, *squares = self.spool.means(of)
        keys = slips_of(self.structure, self.of(self.spool.like)).keys()
        return middle, dict(zip(keys, squares, strict=True))

    def cells(
        self, levels: Sequence[int], extent: Extent, scaling: Scaling, squares: Mapping[int, float]
    ) -> dict[int, Centroids]:
        """Centroids of normalised rows at some levels."""
        ends = spaced_ends(self, squares)
        return _centroids(
            (
                (scaling.inputs(x), _target(block.effort, scaling), spaced_by(self.structure, x, squares))
                for block, x in self.each()
            ),
            ends,
            levels,
            extent.low.size,
        )


def spaced_ends(rows: _Inputs, squares: Mapping[int, float]) -> tuple[Array, Array]:
    """Smallest and largest of what the grids are over."""
    ends: tuple[Array, Array] | None = None
    for _, x in rows.each():
        spaced = spaced_by(rows.structure, x, squares)
        ends = _reach(ends, spaced)
    assert ends is not None
    return ends


def _reach(ends: tuple[Array, Array] | None, values: Array) -> tuple[Array, Array]:
    low, high = values.min(axis=1), values.max(axis=1)
    return (low, high) if ends is None else (np.minimum(ends[0], low), np.maximum(ends[1], high))


def _wider(one: Range | None, other: Range) -> Range:
    def joined(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
        return min(a[0], b[0]), max(a[1], b[1])

    if one is None:
        return other
    return Range(joined(one.field, other.field), joined(one.slip, other.slip), joined(one.effort, other.effort))


def _target(effort: Array, scaling: Scaling) -> Array:
    return (effort - scaling.effort_offset) / scaling.effort_scale


def _centroids(
    blocks: Iterator[tuple[Array, Array, Array]], ends: tuple[Array, Array], levels: Sequence[int], inputs: int
) -> dict[int, Centroids]:
    """Centroids at some levels of blocks of (inputs, effort, what the grid is over)."""
    grids = {level: Grid(*ends, grid_of(inputs, level)) for level in levels}
    totals = {level: Totals(grid.size, inputs) for level, grid in grids.items()}
    for x, y, by in blocks:
        for level, grid in grids.items():
            totals[level].add(grid.place(by), x, y)
    return {level: t.centroids() for level, t in totals.items()}


def fit_network_streamed(
    spool: Spool, structure: NetworkStructure, *, seed: int = 0, workers: int = 1
) -> FitOutcome[NetworkModel]:
    """Fit a network to rows on disk; the same weights as `fit_network` finds for them in memory.

    Args:
        spool: training rows.
        structure: device, layers, inputs; without dynamics and past samples.
        seed: of the starts.
        workers: starts side by side.

    Raises:
        SettingError: a network that needs each row's past, or has too many inputs for a grid.
        CheckError, MappingError: see `fit_network`.
    """
    refuse_structure(structure)
    require_rows(spool.rows, structure, spool.where)
    rows = _Inputs(spool, structure)
    extent, covered = rows.extent()
    require_varied(extent, structure, spool.where)
    middle, squares = rows.means()
    scaling = scaling_for(extent, middle, structure.kind)
    threadpool_limits: Any = import_module("threadpoolctl").threadpool_limits
    with threadpool_limits(1):
        weights, stop, steps = _learn(rows, extent, scaling, squares, seed, workers)
        span = np.column_stack([extent.low, extent.high])
        about = {"seed": str(seed)}
        model = NetworkModel(structure, scaling, weights, {}, spool.units, covered, span, about, spool.period)
        return outcome_of(model, stop, steps, squared_error(spool.blocks(), model)[0], spool.rows)


def _learn(
    rows: _Inputs, extent: Extent, scaling: Scaling, squares: Mapping[int, float], seed: int, workers: int
) -> tuple[dict[str, Array], Stop, int]:
    structure = rows.structure
    if structure.kind == "fnn":
        schedule = schedule_for(structure.hidden, len(structure.inputs))
        cells = rows.cells(sorted(schedule.levels), extent, scaling, squares)
        slips = slips_for(structure, scaling, squares)
        found = train_on(cells, structure.hidden, seed, schedule, workers, slips)
        return fnn_tables(found, extent.low.size, structure), found.stop, found.steps
    centres = centres_on(rows.cells(rbfn_levels(structure), extent, scaling, squares), structure, seed)
    stretches = ((scaling.inputs(x), _target(block.effort, scaling), None) for block, x in rows.each())
    w, _ = weights_over(stretches, centres.centres, centres.spreads)
    return rbfn_tables_for(centres, w), centres.stop, centres.steps


# --- laws -------------------------------------------------------------------------------------------------------------


def fit_structure_streamed(spool: Spool, structure: Structure) -> FitOutcome[TorqueModel]:
    """Fit a law without dynamics to rows on disk; as `fit_structure` does in memory, without intervals.

    Rank and condition are those of the gains for a law that is linear, and of the centroids for one that is not.

    Raises:
        SettingError: a law with dynamics or with a stimulus of its own.
        CheckError: a pair whose clutches are under field together, which a law's centroids cannot tell apart.
    """
    refuse_structure(structure)
    if spool.rows < MANY_ROWS:
        return fit_structure(spool.thinned(spool.rows), structure, intervals=False)
    reference, covered, both = _surveyed(spool)
    shapes = structure.shapes(reference.period)
    if shapes and both:
        raise CheckError(
            f"both clutches are under field in {both} rows; {structure.specification} is fitted on centroids of one "
            "signed field",
            where=spool.where,
            remedy="Fit networks, or fit it to a part of the log with erclutch fit",
        )
    threadpool_limits: Any = import_module("threadpoolctl").threadpool_limits
    with threadpool_limits(1), np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"):
        found, cells = LINEAR, None
        if shapes:
            cells = on_cells(_law_centroids(spool, reference), structure, reference, shapes)
            few = _few(spool, structure, reference)
            best = search(few, cells, (), SCAN_POINTS)
            found = minimise(outer_problem(cells), best, tolerance=1e-8, max_iterations=100)
        triangle = _gain_triangle(spool, structure, reference, parameters(shapes, found.point))
        problem = Separable(_no_columns, np.zeros(0), shapes, structure.gains())
        projection = gains_of(triangle, problem.nonnegative)
        moving = ~(found.at_lower | found.at_upper)
        spread = _rank(cells, found, moving, projection, triangle, spool.rows)
        seen = Seen(reference, spool.units, covered, spool.rows, float("nan"))
        outcome = described(structure, seen, problem, found, projection, spread, moving)
        cost = squared_error(spool.blocks(), outcome.model)[0]
    return replace(outcome, train_cost=cost)


def _no_columns(q: Sequence[Any]) -> Sequence[Any]:
    raise AssertionError("only shapes and gains are asked for")


def _surveyed(spool: Spool) -> tuple[Reference, Range, int]:
    """Normalisation, range, and how many rows have both fields on."""
    covered: Range | None = None
    both, strongest = 0, 0.0
    for block in spool.blocks():
        covered = _wider(covered, range_of(block))
        strongest = max(strongest, *(float(np.max(np.abs(e.field))) for e in block.elements))
        if len(block.elements) > 1:
            both += int(np.count_nonzero((block.elements[0].field != 0) & (block.elements[1].field != 0)))
    assert covered is not None
    squares = spool.means(lambda block: [e.slip**2 for e in block.elements])
    slip = float(np.sqrt(np.mean(squares)))
    return Reference(strongest or 1.0, slip or 1.0, spool.period), covered, both


def _law_centroids(spool: Spool, reference: Reference) -> Centroids:
    ends: tuple[Array, Array] | None = None
    for block in spool.blocks():
        ends = _reach(ends, spaced_rows(signed_rows(block.elements), reference))
    assert ends is not None
    rows = ((signed_rows(block.elements), block.effort) for block in spool.blocks())
    blocks = ((x, y, spaced_rows(x, reference)) for x, y in rows)
    return _centroids(blocks, ends, (2,), ends[0].size)[2]


def _few(spool: Spool, structure: Structure, reference: Reference) -> Separable:
    """The problem on the rows of the scan."""
    some = spool.thinned(SCAN_ROWS)

    def columns(q: Sequence[Any]) -> Sequence[Any]:
        return structure.columns(some.elements, some.clock, reference, q)

    return Separable(columns, some.effort, structure.shapes(reference.period), structure.gains())


def _gain_triangle(spool: Spool, structure: Structure, reference: Reference, q: Sequence[float]) -> Array:
    """R of the QR decomposition of [columns | effort] over all rows."""
    wide = len(structure.gains()) + 1
    triangle = np.zeros((wide, wide))
    for block in spool.blocks():
        matrix = stack(structure.columns(block.elements, block.clock, reference, q), block.effort)
        if not np.isfinite(matrix.sum()):
            raise CheckError(
                f"{structure.specification} gives values that are not finite at its best parameters",
                where=spool.where,
                remedy="Leave it out, or check the largest slips and fields of the log",
            )
        triangle = triangle_of(np.vstack([triangle, triangle_of(matrix)]))
    return triangle


def _rank(
    cells: Separable | None,
    found: Minimum,
    moving: NDArray[np.bool_],
    projection: Projection,
    triangle: Array,
    rows: int,
) -> Uncertainty:
    free = ~projection.held
    if cells is None:
        return unknown(triangle[:, :-1][:, free], rows)
    columns, slopes, _ = jacobian(cells, found.point)
    return unknown(np.column_stack([slopes[:, moving], columns[:, free]]), rows)


def squared_error(blocks: Iterator[Dataset], model: TorqueModel | NetworkModel) -> tuple[float, int]:
    """Sum of squared errors of a model over blocks of rows, and how many rows there are."""
    return squared_errors(blocks, [model.predict])[0]


def squared_errors(
    blocks: Iterator[Dataset], predictions: Sequence[Callable[[Dataset], Array]]
) -> list[tuple[float, int]]:
    """`squared_error` of several models in one pass."""
    totals, rows = [0.0] * len(predictions), 0
    for block in blocks:
        rows += block.rows
        for i, predict in enumerate(predictions):
            residual = block.effort - predict(block)
            totals[i] += float(residual @ residual)
    return [(total, rows) for total in totals]

"""Fitting a structure to training rows: scan, then variable projection on few rows, then on all rows.

The scan looks at the whole box of the nonlinear parameters on a few thousand rows; the best points are refined on those
rows and the best of them polished on all rows, so the figures reported are always those of the full data. A lag's time
constants and delay are nonlinear parameters like those of the law: one search finds them together.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from erclutch.errors import keywords_checked
from erclutch.fit.laws.curvature import with_curvature
from erclutch.fit.laws.describe_law import Seen, described
from erclutch.fit.laws.law_centroids import on_cells, signed_rows, spaced_rows
from erclutch.fit.laws.law_problem import closed_in_slices, separable
from erclutch.fit.laws.law_starts import scan_points, thinned, windows
from erclutch.fit.laws.other_basins import best_basin
from erclutch.fit.laws.profile_intervals import Optimum, interval_ends, no_intervals
from erclutch.fit.laws.shapes_told import shapes_told
from erclutch.fit.left_out_logs import unseen_errors
from erclutch.fit.solver.centroids import centroids_of
from erclutch.fit.solver.intervals import uncertainty, unknown
from erclutch.fit.solver.kept_heap import keep_heap
from erclutch.fit.solver.levenberg_marquardt import Minimum, minimise
from erclutch.fit.solver.outcome import Estimate, FitOutcome
from erclutch.fit.solver.variable_projection import (
    Separable,
    coordinates,
    jacobian,
    outer_problem,
    parameters,
    project,
    refined,
    triangle_of,
)
from erclutch.fit.training_range import range_of
from erclutch.logs.dataset import Dataset
from erclutch.models.given_rows import further_inputs
from erclutch.models.law_model import TorqueModel
from erclutch.models.laws import ShapeParameter
from erclutch.models.laws.smooth import TRANSITION_SLIP
from erclutch.models.stages import NONE
from erclutch.models.structure import Reference, Structure
from erclutch.signals.array import Array, Mask, largest_size, rms
from erclutch.signals.device import largest_field
from erclutch.signals.recording import TEMPERATURE

__all__ = ["Estimate", "FitOutcome", "fit_structure", "reference_of"]

SCAN_ROWS, _ROUGH_ROWS = 1500, 6000
_REFIT_ROWS = 6000  # that weigh in a refit which only validates
_MIDDLE_ROWS = 40000  # of a long log: the last steps, on all rows, then start next to the minimum
MANY_ROWS = 100_000  # from here on centroids stand for the rows where they can
_FINEST = 2  # level of compression
_SCAN_POINTS = 48
_ROUGH_STARTS = 3
_HELD = 1e-6  # share by which a number that is held may move
_ROUNDING = 1e-9  # share of a cost by which a sum over rows may be off


def reference_of(data: Dataset, extras: Sequence[str] = ()) -> Reference:
    """What normalises a model that is trained on these rows, with these further inputs."""
    further = further_inputs(extras, data.extras)
    field = largest_field(data.elements)
    squares = [float(np.mean(element.slip**2)) for element in data.elements]
    slip = float(np.sqrt(np.mean(squares)))
    scales: dict[str, float] = {}  # root mean square of each further input
    for name in extras:
        values = further[name]
        with np.errstate(over="ignore"):
            square = float(np.mean(values**2))
        scale = float(np.sqrt(square))
        if not np.isfinite(square):  # logs hold columns of models that diverged
            largest = largest_size(values)
            scale = largest * rms(values / largest)
        scales[name] = scale or 1.0
    return Reference(
        field=field or 1.0,
        slip=slip or 1.0,
        period=data.period,
        extras=tuple(scales[name] for name in extras),
        temperature=scales.get(TEMPERATURE, 1.0),
    )


@keywords_checked
def fit_structure(
    data: Dataset,
    structure: Structure,
    *,
    starts: Sequence[Sequence[float]] = (),
    scan: int = _SCAN_POINTS,
    ordered: bool = True,
    intervals: bool = True,
    polish: bool = False,
    without: Collection[str] = (),
    most: float | None = None,
) -> FitOutcome[TorqueModel]:
    """Fit a structure's parameters by least squares.

    Args:
        data: training rows.
        structure: device, law and dynamics.
        starts: normalised nonlinear parameters to try besides the scan.
        scan: points of the scan for each nonlinear parameter beyond the first two, at least.
        ordered: whether rows follow in time (decides on how intervals are made).
        intervals: whether to make intervals; without them they are nan, and a fit takes half the time.
        polish: whether the nonlinear parameters of a memoryless law are refined on all rows of a long log, and not only
            on its centroids. Gains and figures are always of all rows.
        without: names of gains that stay at zero, of a law with dynamics.
        most: the cost that the fit may have to be of use, for which it must be sound too; else no intervals are made.

    Returns:
        The model with its intervals and how the solver ended. Deterministic for the same data and arguments.
    """
    keep_heap()
    reference = reference_of(data, structure.extras)
    shapes = shapes_told(data, structure, reference)
    memoryless = structure.dynamics == NONE
    full = separable(data, structure, reference, shapes, slice(None), without)
    if not shapes:
        return _outcome(data, structure, reference, full, _LINEAR, ordered, intervals, most)

    # Of a long log, weighted centroids stand for rows, unless their order matters or the law steps.
    under_field = [element.field != 0 for element in data.elements]
    under_all_fields = np.logical_and.reduce(under_field)
    under_both_fields = len(data.elements) > 1 and bool(np.any(under_all_fields))
    steps = bool(structure.law.stimulus_shape)
    cells: Separable | None = None
    if memoryless and not steps and data.rows >= MANY_ROWS and not under_both_fields:
        signed = signed_rows(data.elements)
        gridded = signed, data.effort, spaced_rows(signed, reference)
        centroids = centroids_of(gridded, [_FINEST])[_FINEST]
        cells = on_cells(centroids, structure, reference, shapes)

    some = data
    if _in_windows(data, structure):
        stretches = windows(data.rows, 2 * _ROUGH_ROWS, data.period)
        some = data.take(stretches)
    few, rough, middle = (
        separable(some, structure, reference, shapes, thinned(some.rows, most), without)
        for most in (SCAN_ROWS, _ROUGH_ROWS, _MIDDLE_ROWS)
    )
    # A step's threshold has no slope to follow between the levels of the command: only the scan finds it.
    denser = 4 if steps else 1
    best = _search(few, cells or rough, starts, scan * denser, structure.remembers)

    if cells is not None and not polish:
        minimum = minimise(outer_problem(cells), best, tolerance=1e-8, max_iterations=100)
        return _outcome(data, structure, reference, full, minimum, ordered, intervals, most)
    if data.rows > 2 * _MIDDLE_ROWS and memoryless:
        best = minimise(outer_problem(middle), best, tolerance=1e-8, max_iterations=100).point
    if structure.remembers:
        minimum = minimise(
            with_curvature(outer_problem(full)), best, tolerance=1e-7, max_iterations=100
        )
    else:
        minimum = minimise(outer_problem(full), best, tolerance=1e-8, max_iterations=100)

    # Where the slip keeps its sign and the rows are fitted as well so, the sign of the slip is stiff.
    names = [shape.name for shape in shapes]
    if data.one_way and TRANSITION_SLIP.name in names:
        place = names.index(TRANSITION_SLIP.name)
        lower, _ = full.bounds
        point = minimum.point.copy()
        point[place] = lower[place]
        at_lower = minimum.at_lower.copy()
        at_lower[place] = True
        if project(full, parameters(shapes, point)).cost <= (1.0 + _ROUNDING) * minimum.cost:
            minimum = replace(minimum, point=point, at_lower=at_lower)
    return _outcome(data, structure, reference, full, minimum, ordered, intervals, most)


def refit_near(
    data: Dataset,
    model: TorqueModel,
    kept: Mask | None = None,
    held: Collection[str] = (),
    without: Collection[str] = (),
) -> FitOutcome[TorqueModel]:
    """The law of a model fitted to other rows from the model's own numbers on: the nearest minimum, without intervals.

    Few rows weigh, and the dynamics run over all of them. It says what a law would have learned from these rows, at a
    small share of the cost of `fit_structure`.

    Args:
        data: rows with the whole motion, over which states run.
        model: the law, from whose numbers the search starts.
        kept: rows whose effort is known, shape (n,); None: all.
        held: nonlinear parameters that keep the model's numbers, by name.
        without: names of gains that stay at zero.
    """
    structure = model.structure
    reference = model.reference
    shapes: list[ShapeParameter] = []
    for shape in structure.shapes(reference.period):
        if shape.name in held:
            number = model.shape[shape.name]
            lower = (1.0 - _HELD) * number
            upper = (1.0 + _HELD) * number
            shape = replace(shape, lower=lower, upper=upper)
        shapes.append(shape)
    rows = np.arange(data.rows) if kept is None else np.flatnonzero(kept)
    few_rows = rows[thinned(rows.size, _REFIT_ROWS)]
    few = separable(data, structure, reference, tuple(shapes), few_rows, without)
    data = data if kept is None else data.take(kept)
    nearest = _LINEAR
    if shapes:
        start = coordinates(shapes, list(model.shape.values()))
        problem = outer_problem(few)
        tolerance = 1e-5
        # With the curvature, for a dead time beside a lag is a valley in which Gauss and Newton end half-way. A law
        # alone stays near: rows at two fields do not tell its form, and the curvature leads far along what is flat.
        if structure.dynamics != NONE and not data.in_no_time:
            problem = with_curvature(problem)
            tolerance = 1e-6
        nearest = minimise(problem, start, tolerance=tolerance, max_iterations=30)
    return _outcome(data, structure, reference, few, nearest, True, False)


#: Of a law without nonlinear parameters: its gains are all that there is to find.
_LINEAR = Minimum(
    point=np.zeros(0),
    cost=np.nan,
    stop="converged",
    iterations=1,
    at_lower=np.zeros(0, np.bool_),
    at_upper=np.zeros(0, np.bool_),
)


def _in_windows(data: Dataset, structure: Structure) -> bool:
    """Whether few rows that stand for all are windows of neighbours, as a lag needs them.

    Without a stage, and of points of a table, rows from all over tell more; where a stage counts from the start of a
    stretch, whole stretches do.
    """
    return not (structure.dynamics == NONE or structure.counts_from_the_start or data.in_no_time)


def _search(
    few: Separable,
    rough: Separable,
    starts: Sequence[Sequence[float]],
    scan: int,
    remembers: bool = False,
) -> Array:
    """Coordinates of the best minimum on some of the rows: a scan on few, local solvers from its best on more.

    Of a law that remembers, a smaller scan and fewer solvers, then a look for other basins from their best minimum;
    with starts no scan at all.
    """
    shapes = few.shapes
    lower, upper = few.bounds
    given = [np.clip(coordinates(shapes, q), lower, upper) for q in starts]
    low = coordinates(shapes, [shape.scanned[0] for shape in shapes])
    high = coordinates(shapes, [shape.scanned[1] for shape in shapes])
    count = scan * max(1, lower.size - 1)
    solvers = _ROUGH_STARTS
    if remembers:
        # Where numbers are known, other basins are looked for from there alone.
        count = 0 if given else count // 3
        solvers -= 1
    points = [*given, *scan_points(low, high, count)]
    costs = [project(few, parameters(shapes, u)).cost for u in points]
    cheapest = np.argsort(costs, kind="stable")[:solvers]
    candidates = given if remembers and given else given + [points[place] for place in cheapest]
    if remembers:
        return best_basin(few, rough, candidates).point
    of_rough = outer_problem(rough)
    minima = [minimise(of_rough, u, tolerance=1e-6, max_iterations=40) for u in candidates]
    return min(minima, key=lambda minimum: minimum.cost).point


def _outcome(
    data: Dataset,
    structure: Structure,
    reference: Reference,
    full: Separable,
    minimum: Minimum,
    ordered: bool,
    intervals: bool,
    most: float | None = None,
) -> FitOutcome[TorqueModel]:
    """The model at a minimum, its gains refined, and what its slopes say of intervals and rank."""
    further = {name: data.extras[name] for name in structure.extras}
    seen = Seen(reference, data.units, range_of(data), data.rows, np.nan, further, data.extra_units)
    ends = no_intervals(len(full.shapes) + len(full.gains))
    if not intervals and structure.dynamics == NONE:
        # Rows of a memoryless law can go in slices, so that the columns of a long log are never there at once.
        projection, triangle, cost = closed_in_slices(
            data, structure, reference, full.shapes, minimum
        )
        spread = unknown(triangle, data.rows)
        return described(
            structure, replace(seen, cost=cost), full, minimum, projection, spread, ends
        )

    columns, slopes, projection = jacobian(full, minimum.point)  # (n, p), (n, k)
    moving = ~(minimum.at_lower | minimum.at_upper)
    linear = columns.T[~projection.held]
    nonlinear = slopes.T[moving]
    triangle = triangle_of(np.vstack([linear, nonlinear]).T)
    projection = refined(columns, full.target, projection, triangle)
    residual = full.target - columns @ projection.gains

    seen = replace(seen, cost=float(residual @ residual))
    # A shape whose gains are all zero moves nothing: it is idle, not a sign that the others cannot be told.
    still = moving & ~slopes.any(axis=0)
    idle = tuple(full.shapes[k].name for k in np.flatnonzero(still).tolist())
    without = tuple(full.gains[place].name for place in full.pinned)

    spread = unknown(triangle, data.rows)
    outcome = described(structure, seen, full, minimum, projection, spread, ends)
    outcome = replace(outcome, idle=idle, without=without)
    of_use = most is None or (outcome.sound and outcome.train_cost <= most)
    if intervals and of_use:
        free = np.vstack([nonlinear, linear]).T
        spread = uncertainty(free, residual, ordered=ordered)
        unseen = unseen_errors(data, free.__getitem__, residual)
        # Profiles of the cost are made on a few rows that stand for all.
        some = data
        if _in_windows(data, structure):
            some = data.take(windows(data.rows, _ROUGH_ROWS, data.period))
        few = separable(some, structure, reference, full.shapes, thinned(some.rows, SCAN_ROWS))
        few = replace(few, pinned=full.pinned)
        optimum = Optimum(
            point=np.concatenate([minimum.point, projection.gains]),
            slopes=np.vstack([slopes.T, columns.T]).T,
            residual=residual,
            free=np.concatenate([moving, ~projection.held]),
            live=np.concatenate([slopes.any(axis=0), ~projection.dead]),
        )
        ends = interval_ends(few, optimum, spread, ordered=ordered)
        outcome = described(structure, seen, full, minimum, projection, spread, ends)
        outcome = replace(outcome, unseen=unseen, idle=idle, without=without)
    return outcome

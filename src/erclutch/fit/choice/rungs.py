"""A rung of the ladder is a structure with its error on training rows that it was not fitted to.

The training rows are cut into windows, over which all states run through. A structure is fitted to every other window
and scored on those between, then the other way round.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.choice.points_left_out import points_left_out
from erclutch.fit.choice.scoring import independent_rows
from erclutch.fit.laws.fit_law import reference_of
from erclutch.fit.laws.law_problem import separable
from erclutch.fit.laws.shapes_told import shapes_told
from erclutch.fit.laws.twin_gains import twin_gains
from erclutch.fit.log_groups import chessboard, groups_of
from erclutch.fit.solver.levenberg_marquardt import minimise
from erclutch.fit.solver.variable_projection import coordinates, outer_problem, parameters, project
from erclutch.logs.dataset import Dataset
from erclutch.models.laws import ShapeParameter
from erclutch.models.stages import needs_time
from erclutch.models.structure import Structure
from erclutch.signals.array import Mask, rms

#: Windows of a log: many, so that either half has all of its fields, but each with so many rows.
_WINDOWS = 24
_FEWEST_WINDOWS = 4
_FEWEST_ROWS = 50
#: Rows over which states run through: that many, in so many long stretches; of them that many are fitted.
_MOST_ROWS = 24_000
#: The same of a whole log, where a stage that counts from its start shows.
MOST_WHOLE_ROWS = 100_000
_STRETCHES = 4
FITTED_ROWS = 3000
#: Logs from which on each log is a window.
_MANY_LOGS = 12
#: Steps of a solver from each start, and where in the usual range of a new constant its searches start.
_STEPS = 15
_PLACES = (0.15, 0.5, 0.85)
#: The same of the two numbers of a stage without a state: a grid, and from how many of its best the searches start.
_OF_GRID = (0.05, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.75, 0.85, 0.95)
_STARTS_OF_GRID = 2


@dataclass(frozen=True)
class Rung:
    """A structure on the ladder.

    Attributes:
        structure: the law with its stages.
        error: RMSE on rows that it was not fitted to.
        numbers: its nonlinear parameters by name, in normalised units, as found on part of the rows.
        independent: how many independent rows the error is known by; without end where each log is a window.
    """

    structure: Structure
    error: float
    numbers: dict[str, float]
    independent: float

    @property
    def numbers_of_fit(self) -> int:
        """How many numbers a fit of the structure has."""
        return numbers_of_fit(self.structure)


@dataclass(frozen=True)
class Fold:
    """Rows to fit and rows to score, of stretches over which all states run through.

    Attributes:
        data: the stretches, of n rows.
        fitted: places of the rows to fit, few.
        scored: mask of the rows to score, shape (n,).
    """

    data: Dataset
    fitted: NDArray[np.intp]
    scored: Mask


def folds_of(train: Dataset, *, whole: bool = False) -> list[Fold]:
    """Every other window is fitted and those between are scored, then the other way round.

    States run through: a window that began at rest would hide a memory that is longer than it. Of many logs each is a
    window, fields and motions like the squares of a chessboard: both folds have all of either, but no pair twice.
    Points of a table, none after another in time, are scored a few from all over at a time, between those fitted.
    """
    many = len(train.source_rows) >= _MANY_LOGS
    data = train
    most = MOST_WHOLE_ROWS if whole else _MOST_ROWS
    if not many and train.rows > most:
        # A few long stretches, spread evenly over the rows.
        length = most // _STRETCHES
        starts = np.linspace(0, train.rows - length, _STRETCHES)
        kept = np.zeros(train.rows, np.bool_)
        for start in starts.round().astype(int).tolist():
            kept[start : start + length] = True
        data = train.take(kept)

    if data.in_no_time:
        return [_fold(data, scored) for scored in points_left_out(data)]
    window = np.zeros(data.rows, np.intp)  # number of each row's window
    if many:
        logs = groups_of(data)
        for (start, stop), number in zip(logs.rows, chessboard(logs), strict=True):
            window[start:stop] = number
    else:
        filled = [(start, stop) for start, stop in data.source_rows if stop > start]
        for number, (start, stop) in enumerate(filled):
            rows = stop - start
            count = int(np.clip(rows // _FEWEST_ROWS, _FEWEST_WINDOWS, _WINDOWS))
            window[start:stop] = number + np.arange(rows) * count // rows

    odd: Mask = window % 2 == 1
    return [_fold(data, scored) for scored in (~odd, odd)]


def _fold(data: Dataset, scored: Mask) -> Fold:
    """The rows that are not scored are fitted, every so many of them."""
    places = np.flatnonzero(~scored)
    every = max(1, -(-places.size // FITTED_ROWS))  # rounded up
    return Fold(data, places[::every], scored)


def rung_of(folds: Sequence[Fold], structure: Structure, known: dict[str, float]) -> Rung:
    """A structure fitted to each fold and scored on the rows between, from the numbers that are known on."""
    numbers = known
    data = folds[0].data  # of all folds
    residual = np.zeros(data.rows)  # of each row by the fit that did not score it
    scored = np.logical_or.reduce([fold.scored for fold in folds])
    reference = reference_of(data, structure.extras)
    shapes = shapes_told(data, structure, reference)
    for fold in folds:
        problem = separable(data, structure, reference, shapes, fold.fitted)
        starts = starts_of(shapes, numbers)
        if is_of_grid(structure, numbers):
            starts = starts_of(shapes, numbers, grid=True)
            starts.sort(key=lambda start: project(problem, start).cost)
            del starts[_STARTS_OF_GRID:]
        points = [coordinates(shapes, start) for start in starts]
        ended = [
            minimise(outer_problem(problem), u, tolerance=1e-4, max_iterations=_STEPS)
            for u in points
        ]
        best = min(ended, key=lambda minimum: minimum.cost)
        q = parameters(shapes, best.point)
        gains = project(problem, q).gains

        # Over all rows of the fold, so that states run through; then those that were not fitted.
        columns = structure.columns(data.elements, data.clock, reference, q, extras=data.extras)
        estimated = np.column_stack(columns) @ gains
        residual[fold.scored] = (data.effort - estimated)[fold.scored]
        # The next fold starts where this one ended.
        numbers = dict(zip((shape.name for shape in shapes), q, strict=True))
    residual = residual[scored]
    error = rms(residual)
    neighbours = len(data.source_rows) < _MANY_LOGS and np.isfinite(error)
    independent = independent_rows(residual) if neighbours else np.inf
    return Rung(structure, error, numbers, independent)


def is_of_grid(structure: Structure, known: dict[str, float]) -> bool:
    """Whether the new numbers are the two of a stage without a state, whose minimum is sharp in either."""
    new = {shape.name for shape in structure.shapes(1.0)} - known.keys()
    for stage in structure.stages:
        own = {shape.name for shape in stage.parameters(1.0)}
        if own == new and len(own) == 2:
            return not needs_time(stage)
    return False


def starts_of(
    shapes: Sequence[ShapeParameter],
    known: dict[str, float],
    places: Sequence[float] = _PLACES,
    *,
    grid: bool = False,
) -> list[list[float]]:
    """Where the search starts: the numbers that are known, and several places for the new ones, or all on a grid."""
    new = [shape.name for shape in shapes if shape.name not in known]
    corners = [dict.fromkeys(new, place) for place in places]
    if grid:
        corners = [
            dict(zip(new, place, strict=True)) for place in product(_OF_GRID, repeat=len(new))
        ]
    elif len(new) > 1:
        # By turns low and high: static friction well above the sliding one fades over a small slip.
        corners.append(
            {name: places[-1] if turn % 2 else places[0] for turn, name in enumerate(new)}
        )
    starts: list[list[float]] = []
    for corner in corners:
        start: list[float] = []
        for shape in shapes:
            if shape.name in known:
                start.append(known[shape.name])
            else:
                start.append(shape.at(corner[shape.name]))
        starts.append(start)
    return starts if new else starts[:1]


def by_chance(simpler: Rung, richer: Rung) -> float:
    """The share of the error that further numbers take off by chance.

    A number takes the squares of one independent row off the rows that it is fitted to. Noise that swings over more
    rows than a window has is the same in the rows between, so such numbers seem to help there too.
    """
    more = max(richer.numbers_of_fit - simpler.numbers_of_fit, 0)
    return 1.0 - max(1.0 - more / richer.independent, 0.0) ** 0.5


def numbers_of_fit(structure: Structure) -> int:
    """How many numbers a fit has, nonlinear ones and gains."""
    shapes = structure.shapes(1.0)
    gains = structure.gains()
    return len(shapes) + len(gains) - len(twin_gains(structure))

"""A kept model is adapted to a new log of its device or of a sister device: few numbers move, and only on evidence.

A way to adapt is a set of numbers that may move: a common gain, all gains, with or without a constant effort, or all
numbers (`recalibration_ways`). A ridge pulls them towards the base, so that a few rows suffice. Blocks of rows in time
that an adaptation has not seen decide how strong the ridge is, which way is taken, and whether it is better than the
model as it is.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from erclutch.errors import CheckError, SettingError, printable
from erclutch.fit.choice.scoring import correlated_over
from erclutch.fit.recalibration_ways import GAIN, OFFSET, Rows, Way, ways_of
from erclutch.fit.solver.bounded_least_squares import solve_bounded
from erclutch.fit.solver.intervals import correlated_rows, uncertainty
from erclutch.fit.solver.levenberg_marquardt import Linearisation, Problem, minimise
from erclutch.fit.solver.one_thread import one_thread
from erclutch.fit.solver.variable_projection import triangle_of
from erclutch.logs.dataset import Dataset, require_dataset, require_kind
from erclutch.models.model import Model
from erclutch.models.shared_answers import ModelBase
from erclutch.signals.array import Array, Mask
from erclutch.signals.percent import percent

__all__ = ["AS_IT_IS", "GAIN", "OFFSET", "Recalibration", "recalibrate"]

#: Name of the way in which nothing moves.
AS_IT_IS = "as it is"
_NEARLY_ALL = 0.1  # of the squared error, that a gain leaves where it explains the rest
_FEWEST_ROWS = 20
_MOST_ROWS = 20_000
_FEWEST_BLOCKS = 4
_MOST_BLOCKS = 10
_WIDTHS = (0.03, 0.1, 0.4, 2.0)  # of the ridge, in usual changes of each number
#: Share of the error that unseen blocks must lose, and in how many standard errors over blocks, before a number moves.
_WORTH = 0.01
_SURE = 1.5


@dataclass(frozen=True)
class Recalibration:
    """What came out.

    Attributes:
        base: the model as it was.
        model: the adapted model; the base itself where no adaptation is better.
        way: what moved.
        folds: of each way, the base first: RMSE of each block, predicted by an adaptation to the others.
        numbers: those that moved, with the ends of a 95 % interval that these rows give; normalised as in the model.
        reason: why this way, in a sentence.
    """

    base: Model
    model: Model
    way: str
    folds: Mapping[str, tuple[float, ...]]
    numbers: Mapping[str, tuple[float, float, float]]
    reason: str


def recalibrate(model: Model, data: Dataset, seen: Mask | None = None) -> Recalibration:
    """Adapt a model to rows of the same or a sister device.

    Args:
        model: of a run or of a file.
        data: rows of the new log.
        seen: rows whose effort is looked at, shape (n,), at least 20; None: all. Of the others only field and slip are,
            which a model with memory needs.

    Raises:
        CheckError: fewer rows, or a model whose effort is not finite on them.
        SettingError: a model of another package that does not say how its effort is multiplied, or no mask.
        ErclutchError: rows of another device, in other units, or without an input of the model.
    """
    require_kind(model, ModelBase, "a model", "Give read_run(FOLDER).model(), or load_model(FILE)")
    require_dataset(data)
    mask = np.ones(data.rows, np.bool_) if seen is None else np.asarray(seen)
    if mask.shape != (data.rows,) or mask.dtype != np.bool_:
        raise SettingError(
            f"seen is no mask of {data.rows} rows: {mask.dtype} of shape {mask.shape}",
            remedy="Give a truth for each row of the data",
        )
    rows = np.flatnonzero(mask)
    if rows.size < _FEWEST_ROWS:
        problem = f"{rows.size} rows to recalibrate with, at least {_FEWEST_ROWS} are needed"
        raise CheckError(problem, where=data.where, remedy="Give a longer log or a larger --share")
    with (
        one_thread(),
        np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"),
    ):
        every = -(-rows.size // _MOST_ROWS)  # every so many rows, rounded up
        rows = rows[::every]
        predicted = model.predict(data)[rows]
        error = data.effort[rows] - predicted
        if not np.all(np.isfinite(error)):
            remedy = "Fit the log instead"
            raise CheckError(
                f"the effort of {model.name} is not finite on these rows",
                where=data.where,
                remedy=remedy,
            )
        # The rows count for as many as are independent of each other. Where a common gain explains nearly all of the
        # error, it is no noise: with a gain of 20 in it the ridge held all numbers next to those of the base.
        measured = data.effort[rows]
        size = float(predicted @ predicted)
        common_gain = float(measured @ predicted) / size if size > 0.0 else 0.0
        without_gain = measured - common_gain * predicted
        explained = float(without_gain @ without_gain) < _NEARLY_ALL * float(error @ error)
        unexplained = without_gain if explained else error
        noise = float(np.mean(unexplained**2)) * correlated_rows(unexplained)
        trial = _Trial(data, rows, error, noise, blocks_of(error))
        ways = list(ways_of(model, data, rows, predicted))

        # The simplest way that is as good as the best one, for all that the blocks can tell, if it is worth it.
        tried: list[_Tried] = []
        for way in ways:
            settled = trial.settled(way)
            width, squares = trial.validated(settled)
            tried.append(_Tried(settled, width, squares))
        plain = _mean_squares(trial.error[block] for block in trial.blocks)
        folds = {AS_IT_IS: tuple(np.sqrt(plain).tolist())}
        for each in tried:
            of_blocks = np.sqrt(each.squares)
            folds[each.way.name] = tuple(of_blocks.tolist())

        worth = [each for each in tried if _change(each.squares, plain) <= -_WORTH]
        better = [each for each in worth if _surely(plain - each.squares)]
        least = min(better or tried, key=lambda each: float(each.squares.sum())).squares
        if not better:
            change = percent(_change(least, plain), 1, sign=True)
            reason = f"nothing helps for sure, on unseen blocks the best way changes the error by {change}"
            return Recalibration(model, model, AS_IT_IS, folds, {}, reason)

        as_good = [
            each for each in better if each.squares is least or not _surely(each.squares - least)
        ]
        taken = min(as_good, key=lambda each: len(each.way.numbers))
        way = taken.way
        adapted, best, half = trial.adapted(way, taken.width)
        places = (best, best - half, best + half)
        ends = [way.said(coordinates).tolist() for coordinates in places]
        numbers: dict[str, tuple[float, float, float]] = {}
        for number, value, low, high in zip(way.numbers, *ends, strict=True):
            numbers[number.name] = (value, low, high)
        gain = ""
        if GAIN in numbers:
            value, low, high = numbers[GAIN]
            gain = f"gain {value:.4g} ({low:.4g} - {high:.4g}), "
        less = percent(-_change(taken.squares, plain), 1)
        reason = f"{way.name}: {gain}on unseen blocks the error is {less} less than {AS_IT_IS}"
        return Recalibration(
            model, _noted(adapted, data, way.name), way.name, folds, numbers, reason
        )


def blocks_of(error: Array) -> list[slice]:
    """Blocks of rows in time, as long as the error is correlated where there are rows enough."""
    independent = error.size // correlated_over([error])
    count = int(np.clip(independent, _FEWEST_BLOCKS, _MOST_BLOCKS))
    even = np.linspace(0, error.size, count + 1)
    edges = even.round().astype(int).tolist()
    return [slice(start, stop) for start, stop in itertools.pairwise(edges)]


@dataclass(frozen=True)
class _Trial:
    """Rows on which ways are tried.

    Attributes:
        data: the new log.
        rows: those whose effort is looked at, shape (n,).
        error: measured effort minus that of the base there, shape (n,).
        noise: variance of an independent row of the error.
        blocks: of these rows, in time.
    """

    data: Dataset
    rows: Rows
    error: Array
    noise: float
    blocks: Sequence[slice]

    def validated(self, way: Way) -> tuple[float, Array]:
        """The ridge's width that unseen blocks prefer, and the mean squares of these blocks."""
        problem = self._problem(way)
        # The rows of a block count by their triangle alone, so a fit to all others stacks small triangles.
        triangles = [triangle_of(problem[block]) for block in self.blocks]
        folds: list[Array] = []
        for block in range(len(triangles)):
            others = [*triangles[:block], *triangles[block + 1 :]]
            folds.append(np.vstack(others))
        best_width = np.nan
        best_squares = np.full(len(self.blocks), np.inf)
        best_numbers: list[Array] = []
        for width in _WIDTHS:
            numbers = [self._solved(way, fold, width) for fold in folds]
            squares = _mean_squares(
                problem[block, -1] - way.columns[block] @ of_others
                for block, of_others in zip(self.blocks, numbers, strict=True)
            )
            if squares.sum() < best_squares.sum():
                best_width, best_squares, best_numbers = width, squares, numbers
        if way.slopes is None:
            return best_width, best_squares
        # The slopes are those of one model; the figures are of a model a block.
        of_models = _mean_squares(
            self._missed(way.model(of_others))[block]
            for block, of_others in zip(self.blocks, best_numbers, strict=True)
        )
        return best_width, of_models

    def settled(self, way: Way) -> Way:
        """The way with its slopes at the best numbers, where it has slopes that change."""
        slopes = way.slopes
        if slopes is None:
            return way
        pull = self._pull(way, 1.0)
        k = len(way.numbers)

        def left(c: Array) -> Array:
            """What is minimised: the error on the rows, and below it the pull of the ridge."""
            missed = self._missed(way.model(c))
            pulled = pull * (way.start - c)
            return np.concatenate([missed, pulled])

        def linearise(c: Array) -> Linearisation:
            missed = left(c)
            jacobian = np.vstack([slopes(c), np.diag(pull)])
            r = triangle_of(np.column_stack([jacobian, missed]))
            cost = float(missed @ missed)
            return Linearisation(cost, triangle=r[:k, :k], vector=r[:k, k])

        def cost(c: Array) -> float:
            missed = left(c)
            return float(missed @ missed)

        lower = np.array([number.lower for number in way.numbers])
        upper = np.array([number.upper for number in way.numbers])
        problem = Problem(cost, linearise, lower, upper)
        best = minimise(problem, way.start, tolerance=1e-4, max_iterations=10).point
        return replace(way, columns=slopes(best), at=best)

    def adapted(self, way: Way, width: float) -> tuple[Model, Array, Array]:
        """The model of a way on all rows, its numbers, and half their 95 % intervals."""
        numbers = self._solved(way, self._problem(way), width)
        model = way.model(numbers)
        spread = uncertainty(way.columns, self._missed(model), ordered=True)
        return model, numbers, spread.quantile * spread.errors

    def _problem(self, way: Way) -> Array:
        """Columns and what they are to give, side by side, shape (n, k + 1)."""
        missed = self.error
        if way.slopes is not None:
            missed = self._missed(way.model(way.at))
        wanted = missed + way.columns @ way.at
        return np.column_stack([way.columns, wanted])

    def _pull(self, way: Way, width: float) -> Array:
        """Of the ridge on each number, shape (k,)."""
        widths = np.array([width * number.reach for number in way.numbers])
        return self.noise**0.5 / widths

    def _solved(self, way: Way, problem: Array, width: float) -> Array:
        """The best numbers for a problem (n, k + 1) and a ridge, shape (k,); those with a bound at zero keep to it."""
        pull = self._pull(way, width)
        k = pull.size
        ridge = np.column_stack([np.diag(pull), pull * way.start])
        r = triangle_of(np.vstack([problem, ridge]))
        nonnegative = np.array([number.lower == 0.0 for number in way.numbers])
        best, _ = solve_bounded(r[:k, :k], r[:k, k], nonnegative)
        return best

    def _missed(self, model: Model) -> Array:
        """Measured effort minus the effort of a model, shape (n,)."""
        data = self.data
        estimated = model.effort(data.elements, data.clock, data.extras, exactly=False)
        return (data.effort - estimated)[self.rows]


@dataclass(frozen=True)
class _Tried:
    """A way with the ridge that unseen blocks prefer, and the mean squares of these blocks."""

    way: Way
    width: float
    squares: Array


def _mean_squares(errors: Iterable[Array]) -> Array:
    """Mean square of each block, shape (blocks,); infinite where one is not finite."""
    squares = np.array([float(np.mean(error**2)) for error in errors])
    finite = np.isfinite(squares)
    return np.where(finite, squares, np.inf)


def _change(squares: Array, plain: Array) -> float:
    """How much larger an RMSE is than the RMSE of the base, as a share."""
    ratio = squares.sum() / (plain.sum() or 1.0)
    return float(ratio**0.5) - 1.0


def _surely(values: Array) -> bool:
    """Whether the mean over blocks is positive by some standard errors."""
    some_errors = _SURE * np.std(values, ddof=1) / values.size**0.5  # standard errors of the mean
    return bool(np.mean(values) > some_errors)


def _noted(model: Any, data: Dataset, way: str) -> Any:
    """The model with a remark on what it was recalibrated to, and with the new efforts in its range."""
    if model.correction is not None:
        return replace(model, law=_noted(model.law, data, way))
    low, high = model.trained_on.effort
    least = min(low, float(data.effort.min()))
    most = max(high, float(data.effort.max()))
    trained_on = replace(model.trained_on, effort=(least, most))
    remark = printable(f"{way}, on {data.rows} rows of {data.where}")
    about = {**model.about, "recalibrated": remark}
    return replace(model, about=about, trained_on=trained_on)

"""A kept model is adapted to a new log of its device or of a sister device: few numbers move, and only on evidence.

A way to adapt is a set of numbers that may move: a common gain, all gains, with or without a constant effort, or all
numbers. A ridge pulls them towards the base, so that a few rows suffice. Blocks of rows in time that an adaptation has
not seen decide how strong the ridge is, which way is taken, and whether it is better than the model as it is.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeGuard, cast

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.dual import partial_of, value_of
from erclutch.errors import CheckError, printable
from erclutch.fit.intervals import correlated_rows, uncertainty
from erclutch.fit.laws.bounded_least_squares import solve_bounded
from erclutch.fit.laws.variable_projection import coordinates, parameters, seeded, triangle_of
from erclutch.fit.levenberg_marquardt import Linearisation, Problem, minimise
from erclutch.fit.networks.fit_residual import output_times
from erclutch.fit.one_thread import one_thread
from erclutch.fit.scoring import correlated_over
from erclutch.logs.dataset import Dataset, require_dataset, require_kind
from erclutch.models.law_model import TorqueModel
from erclutch.models.model import Model
from erclutch.models.networks.network_inputs import inputs_of
from erclutch.models.networks.network_model import NetworkModel
from erclutch.models.residual_model import ResidualModel
from erclutch.models.stages import stages_at
from erclutch.signals.array import Array, Mask

_AnyModel = TorqueModel | NetworkModel | ResidualModel
Rows = NDArray[np.intp]

#: Name of the way in which nothing moves.
AS_IT_IS = "as it is"
#: Numbers of a whole model: what multiplies its effort, and what is added.
GAIN, OFFSET = "gain", "T_0"
_ALL, _FREE = "all numbers", "gains and offset"
_FEWEST_ROWS, _MOST_ROWS = 20, 20_000
_FEWEST_BLOCKS, _MOST_BLOCKS = 4, 10
_WIDTHS = (0.03, 0.1, 0.4, 2.0)  # of the ridge, in usual changes of each number
#: Share of the error that unseen blocks must lose, and in how many standard errors over blocks, before a number moves.
_WORTH, _SURE = 0.01, 1.5
_SMALL = 0.1  # a gain near zero may change by this share of the largest one
_LEAST_SHARE = 1e-3  # of a network's output on a law's residual: its limit stays above zero


@dataclass(frozen=True)
class _Number:
    """A number that may move: its value in the base, its usual change, and its bounds."""

    name: str
    start: float
    reach: float
    lower: float = -np.inf
    upper: float = np.inf


@dataclass(frozen=True)
class _Way:
    """Numbers that may move, slopes of the effort by them (n, k), and the model for other values of them (k,).

    Where the effort is not linear in them, the slopes are those at the values ``at``, by the function ``slopes``. The
    function ``said`` gives the values (k,) as the model has them, where they are coordinates of a solver.
    """

    name: str
    numbers: Sequence[_Number]
    columns: Array
    model: Callable[[Array], _AnyModel]
    at: Array
    slopes: Callable[[Array], Array] | None = None
    said: Callable[[Array], Array] = np.asarray

    @property
    def start(self) -> Array:
        """Values of the numbers in the base, shape (k,)."""
        return np.array([number.start for number in self.numbers])


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
        ErclutchError: rows of another device, in other units, or without an input of the model.
    """
    require_kind(model, _AnyModel, "a model", "Give read_run(FOLDER).model(), or load_model(FILE)")
    require_dataset(data)
    rows = np.arange(data.rows) if seen is None else np.flatnonzero(seen)
    if rows.size < _FEWEST_ROWS:
        problem = f"{rows.size} rows to recalibrate with, at least {_FEWEST_ROWS} are needed"
        raise CheckError(problem, where=data.where, remedy="Give a longer log or a larger --share")
    with one_thread(), np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"):
        rows = rows[:: -(-rows.size // _MOST_ROWS)]
        predicted = model.predict(data)[rows]
        error = data.effort[rows] - predicted
        if not np.all(np.isfinite(error)):
            remedy = "Fit the log instead"
            raise CheckError(f"the effort of {model.name} is not finite on these rows", where=data.where, remedy=remedy)
        trial = _Trial(data, rows, error, float(np.mean(error**2)) * correlated_rows(error), _blocks(error))
        return _chosen(model, trial, list(_ways(cast(_AnyModel, model), data, rows, predicted)))


def _blocks(error: Array) -> list[slice]:
    """Blocks of rows in time, as long as the error is correlated where there are rows enough."""
    count = int(np.clip(error.size // correlated_over([error]), _FEWEST_BLOCKS, _MOST_BLOCKS))
    edges = np.linspace(0, error.size, count + 1).round().astype(int).tolist()
    return [slice(a, b) for a, b in itertools.pairwise(edges)]


@dataclass(frozen=True)
class _Trial:
    """Rows on which ways are tried: what the base misses, the variance of an independent row of it, blocks of rows."""

    data: Dataset
    rows: Rows
    error: Array
    noise: float
    blocks: Sequence[slice]

    def validated(self, way: _Way) -> tuple[float, Array]:
        """The ridge's width that unseen blocks prefer, and the mean squares of these blocks."""
        problem, best = self._problem(way), (np.nan, np.full(len(self.blocks), np.inf))
        triangles = [triangle_of(problem[block]) for block in self.blocks]
        folds = [np.vstack([t for t in triangles if t is not own]) for own in triangles]
        kept: list[Array] = []
        for width in _WIDTHS:
            found = [self._solved(way, fold, width) for fold in folds]
            pairs = zip(self.blocks, found, strict=True)
            squares = _mean_squares(problem[block, -1] - way.columns[block] @ numbers for block, numbers in pairs)
            if squares.sum() < best[1].sum():
                best, kept = (width, squares), found
        if way.slopes is None:
            return best
        # The slopes are those of one model; the figures are of a model a block.
        pairs = zip(self.blocks, kept, strict=True)
        return best[0], _mean_squares(self._missed(way.model(numbers))[block] for block, numbers in pairs)

    def settled(self, way: _Way) -> _Way:
        """The way with its slopes at the best numbers, where it has slopes that change."""
        slopes = way.slopes
        if slopes is None:
            return way
        pull, k = self._pull(way, 1.0), len(way.numbers)

        def left(c: Array) -> Array:
            return np.concatenate([self._missed(way.model(c)), pull * (way.start - c)])

        def linearise(c: Array) -> Linearisation:
            missed = left(c)
            r = triangle_of(np.column_stack([np.vstack([slopes(c), np.diag(pull)]), missed]))
            return Linearisation(float(missed @ missed), r[:k, :k], r[:k, k])

        ends = (np.array([getattr(number, end) for number in way.numbers]) for end in ("lower", "upper"))
        problem = Problem(lambda c: float(left(c) @ left(c)), linearise, *ends)
        best = minimise(problem, way.start, tolerance=1e-4, max_iterations=10).point
        return replace(way, columns=slopes(best), at=best)

    def adapted(self, way: _Way, width: float) -> tuple[_AnyModel, Array, Array]:
        """The model of a way on all rows, its numbers, and half their 95 % intervals."""
        numbers = self._solved(way, self._problem(way), width)
        model = way.model(numbers)
        spread = uncertainty(way.columns, self._missed(model), ordered=True)
        return model, numbers, spread.quantile * spread.errors

    def _problem(self, way: _Way) -> Array:
        """Columns and what they are to give, side by side, shape (n, k + 1)."""
        missed = self.error if way.slopes is None else self._missed(way.model(way.at))
        return np.column_stack([way.columns, missed + way.columns @ way.at])

    def _pull(self, way: _Way, width: float) -> Array:
        """Of the ridge on each number, shape (k,)."""
        return self.noise**0.5 / np.array([width * number.reach for number in way.numbers])

    def _solved(self, way: _Way, problem: Array, width: float) -> Array:
        pull, nonnegative = self._pull(way, width), np.array([number.lower == 0.0 for number in way.numbers])
        r, k = triangle_of(np.vstack([problem, np.column_stack([np.diag(pull), pull * way.start])])), pull.size
        return solve_bounded(r[:k, :k], r[:k, k], nonnegative)[0]

    def _missed(self, model: _AnyModel) -> Array:
        data = self.data
        return (data.effort - model.effort(data.elements, data.clock, data.extras, exactly=False))[self.rows]


def _chosen(base: Model, trial: _Trial, ways: Sequence[_Way]) -> Recalibration:
    """The simplest way that is as good as the best one, for all that the blocks can tell, if it is worth it."""
    tried = [(*trial.validated(way), way) for way in map(trial.settled, ways)]
    plain = _mean_squares(trial.error[block] for block in trial.blocks)
    folds = {AS_IT_IS: plain} | {way.name: squares for _, squares, way in tried}
    shown = {name: tuple(np.sqrt(squares).tolist()) for name, squares in folds.items()}
    better = [each for each in tried if _change(each[1], plain) <= -_WORTH and _surely(plain - each[1])]
    least = min(better or tried, key=lambda each: float(each[1].sum()))[1]
    good = [each for each in better if each[1] is least or not _surely(each[1] - least)]
    if not good:
        reason = (
            f"nothing helps for sure, on unseen blocks the best way changes the error by {_change(least, plain):+.1%}"
        )
        return Recalibration(base, base, AS_IT_IS, shown, {}, reason)
    width, squares, way = min(good, key=lambda each: len(each[2].numbers))
    model, values, half = trial.adapted(way, width)
    ends = zip(*(way.said(end).tolist() for end in (values, values - half, values + half)), strict=True)
    numbers = {number.name: each for number, each in zip(way.numbers, ends, strict=True)}
    gain = "gain {:.4g} ({:.4g} - {:.4g}), ".format(*numbers[GAIN]) if GAIN in numbers else ""
    reason = f"{way.name}: {gain}on unseen blocks the error is {-_change(squares, plain):.1%} less than {AS_IT_IS}"
    return Recalibration(base, _noted(model, trial.data, way.name), way.name, shown, numbers, reason)


def _mean_squares(errors: Iterable[Array]) -> Array:
    """Mean square of each block, shape (blocks,); infinite where one is not finite."""
    found = np.array([float(np.mean(error**2)) for error in errors])
    return np.where(np.isfinite(found), found, np.inf)


def _change(squares: Array, plain: Array) -> float:
    """How much larger an RMSE is than that of the base, as a share."""
    return float((squares.sum() / (plain.sum() or 1.0)) ** 0.5) - 1.0


def _surely(values: Array) -> bool:
    """Whether the mean over blocks is positive by some standard errors."""
    return bool(np.mean(values) > _SURE * np.std(values, ddof=1) / values.size**0.5)


def _way(name: str, numbers: Sequence[_Number], columns: Sequence[Array], model: Callable[[Array], _AnyModel]) -> _Way:
    """A way in whose numbers the effort is linear."""
    return _Way(name, numbers, np.column_stack(columns), model, np.array([number.start for number in numbers]))


def _ways(model: _AnyModel, data: Dataset, rows: Rows, effort: Array) -> Iterator[_Way]:
    """All ways for a model, whose effort is given on the rows."""
    gain = _Number(GAIN, 1.0, 1.0, lower=0.0)
    offset = _Number(OFFSET, 0.0, float(np.sqrt(np.mean(effort**2))) or 1.0)
    yield _way("common gain", [gain], [effort], lambda c: _scaled(model, c[0], 0.0))
    ones = np.ones(effort.size)
    yield _way("common gain and offset", [gain, offset], [effort, ones], lambda c: _scaled(model, *c))
    if model.correction is not None:
        added = model.added(data.elements, data.clock, data.extras, exactly=False)[rows]
        yield _with_network(_gains("gains", model.law, data, rows), model, added)
        yield _with_network(_gains(_FREE, model.law, data, rows), model, added)
    elif _is_law(model):
        yield _gains("gains", model, data, rows)
        yield _gains(_FREE, model, data, rows)
        # One field tells nothing of an exponent of the field.
        if model.shape and any(np.ptp(e.field[rows]) > 1e-6 * np.abs(e.field).max() for e in data.elements):
            yield _all_numbers(model, data, rows)
    elif not stages_at(model.structure.dynamics, "effort"):
        yield _output_layer(cast(NetworkModel, model), data, rows)


def _is_law(model: _AnyModel) -> TypeGuard[TorqueModel]:
    return isinstance(model, TorqueModel)


def _scaled(model: _AnyModel, factor: float, offset: float) -> _AnyModel:
    """A model with its effort times a factor, and a constant effort more."""
    if model.correction is not None:
        return _joined(model, cast(TorqueModel, _scaled(model.law, factor, offset)), factor)
    if not _is_law(model):
        return output_times(cast(NetworkModel, model), factor, offset)
    gains = {name: factor * gain for name, gain in model.gains.items()}
    return _with_gains(model, gains | ({OFFSET: gains.get(OFFSET, 0.0) + offset} if offset else {}))


def _with_gains(law: TorqueModel, gains: Mapping[str, float]) -> TorqueModel:
    structure = replace(law.structure, offset=law.structure.offset or OFFSET in gains)
    return replace(law, structure=structure, gains={**law.gains, **gains})


def _joined(model: ResidualModel, law: TorqueModel, share: float) -> ResidualModel:
    """The same network on other numbers of the law, its output and its limit times a share."""
    correction, share = model.correction, max(share, _LEAST_SHARE)
    network = output_times(correction.network, share)
    return ResidualModel(law, replace(correction, network=network, limit=share * correction.limit))


def _gains(name: str, law: TorqueModel, data: Dataset, rows: Rows) -> _Way:
    """The linear parameters of a law, the constant effort only where the way is free to have one."""
    structure, q = replace(law.structure, offset=name == _FREE), list(law.shape.values())
    columns = structure.columns(data.elements, data.clock, law.reference, q, extras=data.extras)
    least = _SMALL * max(map(abs, law.gains.values()))
    numbers: list[_Number] = []
    for gain in structure.gains():
        start = law.gains.get(gain.name, 0.0)
        numbers.append(_Number(gain.name, start, max(abs(start), least), 0.0 if gain.nonnegative else -np.inf))
    names = [number.name for number in numbers]

    def model(c: Array) -> TorqueModel:
        return _with_gains(law, dict(zip(names, c.tolist(), strict=True)))

    return _way(name, numbers, [column[rows] for column in columns], model)


def _with_network(way: _Way, base: ResidualModel, added: Array) -> _Way:
    """The gains of a law, and the output of the network on its residual."""
    numbers = [*way.numbers, _Number("network", 1.0, 1.0, lower=0.0)]

    def model(c: Array) -> ResidualModel:
        return _joined(base, cast(TorqueModel, way.model(c[:-1])), float(c[-1]))

    return _way(way.name, numbers, [way.columns, added], model)


def _all_numbers(law: TorqueModel, data: Dataset, rows: Rows) -> _Way:
    """Gains, constant effort and nonlinear parameters of a law, the latter as the solver's coordinates."""
    shapes, gains = law.structure.shapes(law.period), _gains(_FREE, law, data, rows)
    u, low, high = (
        coordinates(shapes, values)
        for values in ([*law.shape.values()], [s.lower for s in shapes], [s.upper for s in shapes])
    )
    reach = [1.0 if s.scale == "log" else 0.5 * (s.scanned[1] - s.scanned[0]) for s in shapes]
    numbers = [_Number(s.name, *each) for s, *each in zip(shapes, u, reach, low, high, strict=True)]

    def model(c: Array) -> TorqueModel:
        moved = dict(zip(law.shape, parameters(shapes, c[: u.size]), strict=True))
        return replace(cast(TorqueModel, gains.model(c[u.size :])), shape=moved)

    def slopes(c: Array) -> Array:
        q = seeded(shapes, c[: u.size])
        structure = replace(law.structure, offset=True)
        columns = structure.columns(data.elements, data.clock, law.reference, q, extras=data.extras)
        effort = sum(gain * column for gain, column in zip(c[u.size :], columns, strict=True))
        by_shape = [np.broadcast_to(partial_of(effort, k), data.rows)[rows] for k in range(u.size)]
        return np.column_stack([*by_shape, *(value_of(column)[rows] for column in columns)])

    def said(c: Array) -> Array:
        return np.concatenate([parameters(shapes, c[: u.size]), c[u.size :]])

    start = np.concatenate([u, gains.start])
    return _Way(_ALL, [*numbers, *gains.numbers], gains.columns, model, start, slopes, said)


def _output_layer(network: NetworkModel, data: Dataset, rows: Rows) -> _Way:
    """The weights of a network's output layer."""
    inputs = inputs_of(network.structure, data.elements, data.clock, data.extras, network.dynamics)[:, rows]
    active = network.last_layer(network.scaling.inputs(inputs))
    columns = network.scaling.effort_scale * np.column_stack([*active, np.ones(active.shape[1])])
    names = list(network.weights)[-2:]
    weights, bias = (network.weights[name] for name in names)
    start = np.concatenate([weights.ravel(), bias])
    reach = np.maximum(np.abs(start), _SMALL * np.abs(start).max())
    numbers = [_Number(f"w_{k}", *each) for k, each in enumerate(zip(start.tolist(), reach.tolist(), strict=True))]

    def model(c: Array) -> NetworkModel:
        tables = dict(zip(names, (c[:-1].reshape(weights.shape), c[-1:]), strict=True))
        return replace(network, weights={**network.weights, **tables})

    return _way(_ALL, numbers, [columns], model)


def _noted(model: _AnyModel, data: Dataset, way: str) -> _AnyModel:
    """The model with a remark on what it was recalibrated to, and with the new efforts in its range."""
    if model.correction is not None:
        return replace(model, law=cast(TorqueModel, _noted(model.law, data, way)))
    low, high = model.trained_on.effort
    effort = min(low, float(data.effort.min())), max(high, float(data.effort.max()))
    about = {**model.about, "recalibrated": printable(f"{way}, on {data.rows} rows of {data.where}")}
    return replace(model, about=about, trained_on=replace(model.trained_on, effort=effort))

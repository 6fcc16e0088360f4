"""A network fitted to a data set: inputs, normalisation, training, and the model with its figures on all rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.dataset import Dataset
from erclutch.errors import CheckError
from erclutch.fit.backprop import tables_of, weights_of
from erclutch.fit.compress import Centroids, compress
from erclutch.fit.first_weights import Slips
from erclutch.fit.geodesic import Trained
from erclutch.fit.lm import Stop
from erclutch.fit.network import schedule_for, train
from erclutch.fit.outcome import FitOutcome
from erclutch.fit.ranges import period_of, range_of
from erclutch.fit.rbfn import Centres, by_forward_selection, by_k_means, refined, weights_for
from erclutch.networks import Kind, NetworkStructure, base_inputs
from erclutch.networks.inputs import inputs_of
from erclutch.networks.model import NetworkModel, Scaling, table_shapes

Array = NDArray[np.float64]


_NARROW = 0.006  # slip, over its root mean square, below which cells are equally wide


def fit_network(
    data: Dataset,
    structure: NetworkStructure,
    *,
    seed: int = 0,
    polish: bool = False,
    workers: int = 1,
    dynamics: Mapping[str, float] | None = None,
) -> FitOutcome[NetworkModel]:
    """Fit a network's weights by least squares.

    Args:
        data: training rows.
        structure: device, layers, inputs.
        seed: of the starts; the same seed gives the same weights, whatever the number of workers.
        polish: whether the last round runs over all rows instead of a fine grid's centroids.
        workers: starts side by side.
        dynamics: delay and time constants of the command in s, for a structure with dynamics.

    Raises:
        CheckError: fewer rows than weights, an input that does not vary, or values that are not finite.
        MappingError: a further input is not in the data.
    """
    x = inputs_of(structure, data.elements, data.clock, data.extras, dynamics or {})
    where = data.sources[0] if len(data.sources) == 1 else f"{len(data.sources)} logs"
    require_rows(data.rows, structure, where)
    require_finite(x, data.effort, structure, where)
    extent = extent_of(x, data.effort)
    require_varied(extent, structure, where)
    span = np.column_stack([extent.low, extent.high])
    scaling = scaling_of(x, data.effort, structure.kind)
    squares = mean_squares(structure, x)
    weights, stop, steps = learn(
        x, data.effort, scaling, structure, seed=seed, polish=polish, workers=workers, squares=squares
    )
    model = NetworkModel(
        structure,
        scaling,
        weights,
        dict(dynamics or {}),
        data.units,
        range_of(data),
        span,
        {"seed": str(seed)},
        period_of(data),
    )
    residual = data.effort - model.of_inputs(x, exactly=False)
    return outcome_of(model, stop, steps, float(residual @ residual), data.rows)


def outcome_of(model: NetworkModel, stop: Stop, steps: int, cost: float, rows: int) -> FitOutcome[NetworkModel]:
    """The outcome of a network's fit with its sum of squares over all rows."""
    return FitOutcome(
        model=model,
        stop=stop,
        iterations=steps,
        estimates=(),
        paper_form={},
        rank=model.parameters,
        unknowns=model.parameters,
        condition=float("nan"),
        bandwidth=1,
        train_cost=cost,
        train_rows=rows,
        weights=model.parameters,
    )


def slips_of(structure: NetworkStructure, x: Array) -> dict[int, Array]:
    """The slips behind the inputs x (inputs, n), by the input in whose place the grid is over them."""
    if structure.device == "single" or structure.kind == "rbfn":
        return {i: x[i] for i in range(1, len(base_inputs(structure.device, structure.kind)))}
    return {1: x[1] - x[2], 2: -x[1] - x[2]}


def mean_squares(structure: NetworkStructure, x: Array) -> dict[int, float]:
    """Mean square of each slip behind the inputs, by input as in `slips_of`."""
    return {i: float(np.mean(slip**2)) for i, slip in slips_of(structure, x).items()}


def spaced_by(structure: NetworkStructure, x: Array, squares: Mapping[int, float]) -> Array:
    """What the grids of compression are over: cells narrow where a slip is small, since effort bends most there.

    ``squares`` holds the mean square of each slip over all rows, of which x may be a part.
    """
    spaced = x.copy()
    for i, slip in slips_of(structure, x).items():
        size = float(np.sqrt(squares[i])) or 1.0
        scaled: Array = slip / (_NARROW * size)
        spaced[i] = np.arcsinh(scaled)
    return spaced


def slips_for(structure: NetworkStructure, scaling: Scaling, squares: Mapping[int, float]) -> Slips:
    """The slips over their root mean square as linear functions of a network's normalised inputs."""
    slope = np.zeros((len(squares), len(structure.inputs)))
    if structure.device == "single":
        slope[0, 1] = 1.0
    else:
        slope[:, 1:3] = (1.0, -1.0), (-1.0, -1.0)
    slope /= np.sqrt([[square or 1.0] for square in squares.values()])
    return Slips(slope * scaling.scale, slope @ scaling.offset)


@dataclass(frozen=True)
class Extent:
    """Smallest and largest values over all rows.

    Attributes:
        low, high: of each input, shape (inputs,).
        effort: of the effort.
    """

    low: Array
    high: Array
    effort: tuple[float, float]

    def joined(self, other: Extent) -> Extent:
        """Of both."""
        (a, b), (c, d) = self.effort, other.effort
        return Extent(np.minimum(self.low, other.low), np.maximum(self.high, other.high), (min(a, c), max(b, d)))


def extent_of(x: Array, y: Array) -> Extent:
    """Extent of inputs (inputs, n) and effort (n,)."""
    return Extent(x.min(axis=1), x.max(axis=1), (float(y.min()), float(y.max())))


def scaling_of(x: Array, y: Array, kind: Kind) -> Scaling:
    """Inputs to [-1, 1] for an FNN and to [0, 1] for an RBFN (section III-E), the effort to [-1, 1] round its mean."""
    return scaling_for(extent_of(x, y), float(np.mean(y)), kind)


def scaling_for(extent: Extent, middle: float, kind: Kind) -> Scaling:
    """`scaling_of` rows of which only the extent and the mean effort are known."""
    low, wide = extent.low, extent.high - extent.low
    wide = np.where(wide > 0, wide, 1.0)
    half = max(abs(end - middle) for end in extent.effort) or 1.0
    return Scaling(low + 0.5 * wide, 0.5 * wide, middle, half) if kind == "fnn" else Scaling(low, wide, middle, half)


def learn(
    x: Array,
    y: Array,
    scaling: Scaling,
    structure: NetworkStructure,
    *,
    seed: int = 0,
    polish: bool = False,
    workers: int = 1,
    squares: Mapping[int, float] | None = None,
) -> tuple[dict[str, Array], Stop, int]:
    """Tables of weights for inputs x (inputs, n) and effort y (n,), how the solver ended, and its steps.

    ``squares`` holds the mean square of each slip, by input, see `spaced_by`; None where inputs are only columns.
    """
    unit, target = scaling.inputs(x), (y - scaling.effort_offset) / scaling.effort_scale
    spaced = None if squares is None else spaced_by(structure, x, squares)
    threadpool_limits: Any = import_module("threadpoolctl").threadpool_limits
    with threadpool_limits(1):  # the matrices are small: more threads would only wait for each other
        if structure.kind == "rbfn":
            return _learn_rbfn(unit, target, structure, seed, spaced)
        schedule = schedule_for(structure.hidden, len(structure.inputs), polish)
        slips = None if squares is None else slips_for(structure, scaling, squares)
        found = train(unit, target, structure.hidden, seed, schedule, workers, spaced, slips)
        return fnn_tables(found, x.shape[0], structure), found.stop, found.steps


def require_rows(rows: int, structure: NetworkStructure, where: str) -> None:
    """Raise a CheckError for fewer rows than weights."""
    count = sum(int(np.prod(shape)) for shape in table_shapes(structure).values())
    if rows < count:
        raise CheckError(
            f"{rows} training rows for the {count} weights of {structure.specification}",
            remedy="Log more, or choose a smaller network",
            where=where,
        )


def require_finite(x: Array, y: Array, structure: NetworkStructure, where: str) -> None:
    """Raise a CheckError for inputs (inputs, n) or efforts (n,) that are not finite."""
    for name, values in zip(structure.inputs, x, strict=True):
        if not np.all(np.isfinite(values)):
            bad = int(np.count_nonzero(~np.isfinite(values)))
            raise CheckError(
                f"input {name} has {bad} values that are not finite", remedy="Drop them: --invalid drop", where=where
            )
    if not np.all(np.isfinite(y)):
        raise _no_effort(where)


def require_varied(extent: Extent, structure: NetworkStructure, where: str) -> None:
    """Raise a CheckError for an input or effort that does not vary."""
    for name, low, high in zip(structure.inputs, extent.low.tolist(), extent.high.tolist(), strict=True):
        if high == low:
            raise CheckError(
                f"input {name} is constant at {low:g} over all training rows",
                remedy="Log with it changing, or leave it out",
                where=where,
            )
    if extent.effort[0] == extent.effort[1]:
        raise _no_effort(where)


def _no_effort(where: str) -> CheckError:
    return CheckError(
        "the effort is constant or not finite over the training rows", remedy="Check its column", where=where
    )


def fnn_tables(found: Trained, inputs: int, structure: NetworkStructure) -> dict[str, Array]:
    """Tables of an FNN from its weight vector."""
    sizes = (inputs, *structure.hidden, 1)
    assert found.theta.size == weights_of(sizes)
    return tables_of(found.theta, sizes)


def _learn_rbfn(
    x: Array, y: Array, structure: NetworkStructure, seed: int, by: Array | None
) -> tuple[dict[str, Array], Stop, int]:
    cells = {level: compress(x, y, level, by) for level in rbfn_levels(structure)}
    found = centres_on(cells, structure, seed)
    return rbfn_tables(x, y, found), found.stop, found.steps


def rbfn_levels(structure: NetworkStructure) -> tuple[int, ...]:
    """Levels of compression that an RBFN's centres need."""
    return (1, 2) if structure.centres in ("refined", "spreads") else (1,)


def centres_on(cells: Mapping[int, Centroids], structure: NetworkStructure, seed: int) -> Centres:
    """Centres and spreads of an RBFN on centroids by level: found on the coarsest, refined on the finest."""
    neurons, how = structure.hidden[0], structure.centres
    search = by_k_means if how == "kmeans" else by_forward_selection
    found = search(cells[min(cells)], neurons, seed)
    return refined(cells[max(cells)], found, one_spread=how == "refined") if len(cells) > 1 else found


def rbfn_tables(x: Array, y: Array, found: Centres) -> dict[str, Array]:
    """Tables of an RBFN with output weights from all rows."""
    return rbfn_tables_for(found, weights_for(x, y, None, found.centres, found.spreads)[0])


def rbfn_tables_for(found: Centres, w: Array) -> dict[str, Array]:
    """Tables of an RBFN from its centres and its output weights, the constant last."""
    return {"centres": found.centres, "spreads": found.spreads, "w": w[:-1], "b": w[-1:]}

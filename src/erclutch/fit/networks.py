"""A network fitted to a data set: inputs, normalisation, training, and the model with its figures on all rows."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.dataset import Dataset
from erclutch.errors import CheckError
from erclutch.fit.backprop import tables_of, weights_of
from erclutch.fit.compress import compress
from erclutch.fit.lm import Stop
from erclutch.fit.network import schedule_for, train
from erclutch.fit.outcome import FitOutcome
from erclutch.fit.ranges import range_of
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
    _checked(x, data, structure)
    span = np.column_stack([x.min(axis=1), x.max(axis=1)])
    scaling = scaling_of(x, data.effort, structure.kind)
    spaced = spacing(structure, x)
    weights, stop, steps = learn(
        x, data.effort, scaling, structure, seed=seed, polish=polish, workers=workers, spaced=spaced
    )
    model = NetworkModel(
        structure, scaling, weights, dict(dynamics or {}), data.units, range_of(data), span, {"seed": str(seed)}
    )
    residual = data.effort - model.predict(data)
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
        train_cost=float(residual @ residual),
        train_rows=data.rows,
        weights=model.parameters,
    )


def spacing(structure: NetworkStructure, x: Array) -> Array:
    """What the grids of compression are over: cells narrow where a slip is small, since effort bends most there."""
    spaced = x.copy()
    if structure.device == "single" or structure.kind == "rbfn":
        slips: dict[int, Array] = {i: x[i] for i in range(1, len(base_inputs(structure.device, structure.kind)))}
    else:
        slips = {1: x[1] - x[2], 2: -x[1] - x[2]}
    for i, slip in slips.items():
        size = float(np.sqrt(np.mean(slip**2))) or 1.0
        scaled: Array = slip / (_NARROW * size)
        spaced[i] = np.arcsinh(scaled)
    return spaced


def scaling_of(x: Array, y: Array, kind: Kind) -> Scaling:
    """Inputs to [-1, 1] for an FNN and to [0, 1] for an RBFN (section III-E), the effort to [-1, 1] round its mean."""
    low = x.min(axis=1)
    wide = x.max(axis=1) - low
    wide = np.where(wide > 0, wide, 1.0)
    middle = float(np.mean(y))
    half = float(np.max(np.abs(y - middle))) or 1.0
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
    spaced: Array | None = None,
) -> tuple[dict[str, Array], Stop, int]:
    """Tables of weights for inputs x (inputs, n) and effort y (n,), how the solver ended, and its steps.

    ``spaced`` is what the grids of compression are over in place of the inputs.
    """
    unit, target = scaling.inputs(x), (y - scaling.effort_offset) / scaling.effort_scale
    chosen = _learn_fnn if structure.kind == "fnn" else _learn_rbfn
    threadpool_limits: Any = import_module("threadpoolctl").threadpool_limits
    with threadpool_limits(1):  # the matrices are small: more threads would only wait for each other
        return chosen(unit, target, structure, seed, polish, workers, spaced)


def _checked(x: Array, data: Dataset, structure: NetworkStructure) -> None:
    where = data.sources[0] if len(data.sources) == 1 else f"{len(data.sources)} logs"
    count = sum(int(np.prod(shape)) for shape in table_shapes(structure).values())
    if data.rows < count:
        raise CheckError(
            f"{data.rows} training rows for the {count} weights of {structure.specification}",
            remedy="Log more, or choose a smaller network",
            where=where,
        )
    for name, values in zip(structure.inputs, x, strict=True):
        if not np.all(np.isfinite(values)):
            bad = int(np.count_nonzero(~np.isfinite(values)))
            raise CheckError(
                f"input {name} has {bad} values that are not finite", remedy="Drop them: --invalid drop", where=where
            )
        if float(np.ptp(values)) == 0.0:
            raise CheckError(
                f"input {name} is constant at {values[0]:g} over all training rows",
                remedy="Log with it changing, or leave it out",
                where=where,
            )
    if not np.all(np.isfinite(data.effort)) or float(np.ptp(data.effort)) == 0.0:
        raise CheckError(
            "the effort is constant or not finite over the training rows", remedy="Check its column", where=where
        )


def _learn_fnn(
    x: Array, y: Array, structure: NetworkStructure, seed: int, polish: bool, workers: int, by: Array | None
) -> tuple[dict[str, Array], Stop, int]:
    found = train(x, y, structure.hidden, seed, schedule_for(structure.hidden, polish), workers, by)
    sizes = (x.shape[0], *structure.hidden, 1)
    assert found.theta.size == weights_of(sizes)
    return tables_of(found.theta, sizes), found.stop, found.steps


def _learn_rbfn(
    x: Array, y: Array, structure: NetworkStructure, seed: int, polish: bool, workers: int, by: Array | None
) -> tuple[dict[str, Array], Stop, int]:
    neurons, how = structure.hidden[0], structure.centres
    cells = compress(x, y, 0, by)
    found = by_k_means(cells, neurons, seed) if how == "kmeans" else by_forward_selection(cells, neurons, seed)
    if how in ("refined", "spreads"):
        finer = compress(x, y, 2 if polish else 1, by)
        found = refined(finer, found, one_spread=how == "refined")
    return rbfn_tables(x, y, found), found.stop, found.steps


def rbfn_tables(x: Array, y: Array, found: Centres) -> dict[str, Array]:
    """Tables of an RBFN with output weights from all rows."""
    w, _ = weights_for(x, y, None, found.centres, found.spreads)
    return {"centres": found.centres, "spreads": found.spreads, "w": w[:-1], "b": w[-1:]}

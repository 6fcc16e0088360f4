"""A network is fitted to training rows: inputs, normalisation, training, and the model with its figures on all rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from erclutch.errors import CheckError
from erclutch.fit.centroids import centroids_of
from erclutch.fit.left_out_logs import unseen_errors
from erclutch.fit.levenberg_marquardt import Stop
from erclutch.fit.networks.backprop import slopes_of, tables_of
from erclutch.fit.networks.first_weights import Slips
from erclutch.fit.networks.fit_fnn import schedule_for, train
from erclutch.fit.networks.fit_rbfn import by_forward_selection, by_k_means, refined, weights_for
from erclutch.fit.one_thread import one_thread
from erclutch.fit.outcome import FitOutcome
from erclutch.fit.training_range import near_cells, range_of
from erclutch.logs.dataset import Dataset
from erclutch.models.networks import NetworkKind, NetworkStructure, base_inputs
from erclutch.models.networks.network_inputs import field_in_fluid, inputs_of
from erclutch.models.networks.network_model import NetworkModel, Scaling, table_shapes
from erclutch.models.stages import stages_at
from erclutch.signals.array import Array, Mask
from erclutch.signals.device import Element

Pair = tuple[Array, Array]  # inputs (inputs, n) and effort (n,) of some rows

_NARROW = 0.006  # slip, over its root mean square, below which cells are equally wide
_ROUNDING = 1e-12  # of an input: it varies by less where it is constant but for its last digits


def fit_network(
    data: Dataset,
    structure: NetworkStructure,
    *,
    seed: int = 0,
    polish: bool = False,
    workers: int = 1,
    dynamics: Mapping[str, float] | None = None,
    kept: Mask | None = None,
) -> FitOutcome[NetworkModel]:
    """Fit a network's weights by least squares.

    Args:
        data: training rows, over which states run.
        structure: device, layers, inputs.
        seed: of the starts; the same seed gives the same weights, whatever the number of workers.
        polish: whether the last round runs over all rows instead of a fine grid's centroids.
        workers: starts side by side.
        dynamics: delay and time constants of the command in s, for a structure with dynamics.
        kept: rows whose effort is known, shape (n,); None: all. A fit to some of them only judges, see `schedule_for`.

    Raises:
        CheckError: fewer rows than weights, an input that does not vary, or values that are not finite.
        MappingError: a further input is not in the data.
    """
    times = dict(dynamics or {})
    inputs, effort = inputs_of(structure, data.elements, data.clock, data.extras, times), data.effort
    fluids = [field_in_fluid(e.field, structure, data.clock, times) for e in data.elements]
    elements = [Element(fluid, e.slip) for e, fluid in zip(data.elements, fluids, strict=True)]
    if kept is not None:
        data, inputs, effort = data.take(kept), inputs[:, kept], effort[kept]
        elements = [Element(e.field[kept], e.slip[kept]) for e in elements]
    rows = inputs, effort
    judges = kept is not None and not kept.all()
    outcome = fit_rows(data, rows, structure, times, seed=seed, polish=polish, workers=workers, judges=judges)
    if not stages_at(structure.dynamics, "command"):
        return outcome
    return replace(outcome, model=replace(outcome.model, near=near_cells(outcome.model.trained_on, elements)))


def fit_rows(
    data: Dataset,
    rows: Pair,
    structure: NetworkStructure,
    times: Mapping[str, float],
    *,
    seed: int = 0,
    polish: bool = False,
    workers: int = 1,
    judges: bool = False,
) -> FitOutcome[NetworkModel]:
    """The same from inputs and effort of all rows; the data give units, ranges and the period.

    Raises:
        CheckError: as for `fit_network`.
    """
    x, y = rows
    _require_usable(x, y, structure, data.where)
    scaling = scaling_of(x, y, structure.kind)
    squares = mean_squares(structure, x)
    with one_thread():
        weights, stop, steps = learn(
            rows, scaling, structure, seed=seed, polish=polish, workers=workers, squares=squares, judges=judges
        )
        span = np.column_stack([x.min(axis=1), x.max(axis=1)])
        about = {"seed": str(seed)}
        model = NetworkModel(
            structure, scaling, weights, dict(times), data.units, range_of(data), span, about, data.period
        )
        residual = y - model.of_inputs(x, exactly=False)
        unseen = _unseen(data, model, rows)
    return replace(_outcome(model, stop, steps, float(residual @ residual), data.rows), unseen=unseen)


def _unseen(data: Dataset, model: NetworkModel, pair: Pair) -> Array | None:
    """Errors without the logs of a row's motion; of an RBFN the centres and spreads stay where they are."""
    x, y = pair

    def slopes(rows: slice) -> Array:
        unit = model.scaling.inputs(x[:, rows])
        if model.structure.kind == "rbfn":
            return np.vstack([model.last_layer(unit), np.ones(unit.shape[1])]).T
        return slopes_of(model.weights, unit).T

    return unseen_errors(data, slopes, y - model.of_inputs(x, exactly=False))


def _outcome(model: NetworkModel, stop: Stop, steps: int, cost: float, rows: int) -> FitOutcome[NetworkModel]:
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


def _slip_inputs(structure: NetworkStructure) -> tuple[int, ...]:
    """The inputs in whose place a grid is over slips."""
    first = 1 if structure.field else 0
    if structure.device == "single" or structure.kind == "rbfn":
        return tuple(range(first, len(base_inputs(structure.device, structure.kind, field=structure.field))))
    return first, first + 1


def slips_of(structure: NetworkStructure, x: Array) -> dict[int, Array]:
    """The slips behind the inputs x (inputs, n), by the input in whose place the grid is over them."""
    if structure.device == "single" or structure.kind == "rbfn":
        return {i: x[i] for i in _slip_inputs(structure)}
    first, second = _slip_inputs(structure)
    return {first: x[first] - x[second], second: -x[first] - x[second]}


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
    first = 1 if structure.field else 0
    if structure.device == "single":
        slope[0, first] = 1.0
    else:
        slope[:, first : first + 2] = (1.0, -1.0), (-1.0, -1.0)
    slope /= np.sqrt([[square or 1.0] for square in squares.values()])
    return Slips(slope * scaling.scale, slope @ scaling.offset, structure.field)


def scaling_of(x: Array, y: Array, kind: NetworkKind) -> Scaling:
    """Inputs to [-1, 1] for an FNN and to [0, 1] for an RBFN (section III-E), the effort to [-1, 1] round its mean."""
    low, wide = x.min(axis=1), x.max(axis=1) - x.min(axis=1)
    wide = np.where(wide > 0, wide, 1.0)
    middle = float(np.mean(y))
    half = max(abs(float(end) - middle) for end in (y.min(), y.max())) or 1.0
    return Scaling(low + 0.5 * wide, 0.5 * wide, middle, half) if kind == "fnn" else Scaling(low, wide, middle, half)


def learn(
    rows: Pair,
    scaling: Scaling,
    structure: NetworkStructure,
    *,
    seed: int = 0,
    polish: bool = False,
    workers: int = 1,
    squares: Mapping[int, float] | None = None,
    judges: bool = False,
) -> tuple[dict[str, Array], Stop, int]:
    """Tables of weights for inputs and effort, how the solver ended, and its steps.

    ``squares`` holds the mean square of each slip, by input, see `spaced_by`; None where inputs are only columns.
    With ``judges`` the schedule is that of a network that only judges.
    """
    unit = scaling.inputs(rows[0])
    target = (rows[1] - scaling.effort_offset) / scaling.effort_scale
    gridded = unit, target, unit if squares is None else spaced_by(structure, rows[0], squares)
    if structure.kind == "rbfn":
        cells = centroids_of(gridded, (1, 2) if structure.centres in ("refined", "spreads") else (1,))
        # Found on the coarsest grid, refined on the finest.
        search = by_k_means if structure.centres == "kmeans" else by_forward_selection
        centres = search(cells[min(cells)], structure.hidden[0], seed)
        if len(cells) > 1:
            centres = refined(cells[max(cells)], centres, one_spread=structure.centres == "refined")
        w, _ = weights_for(unit, target, None, centres.centres, centres.spreads)
        tables = {"centres": centres.centres, "spreads": centres.spreads, "w": w[:-1], "b": w[-1:]}
        return tables, centres.stop, centres.steps
    schedule = schedule_for(structure.hidden, len(structure.inputs), polish, judges)
    slips = None if squares is None else slips_for(structure, scaling, squares)
    trained = train(gridded, structure.hidden, seed, schedule, workers, slips)
    sizes = scaling.offset.size, *structure.hidden, 1
    return tables_of(trained.theta, sizes), trained.stop, trained.steps


def supports(rows: int, structure: NetworkStructure) -> bool:
    """Whether there are at least as many training rows as weights."""
    return rows >= _weights_of(structure)


def _weights_of(structure: NetworkStructure) -> int:
    """Number of weights of a network."""
    return sum(int(np.prod(shape)) for shape in table_shapes(structure).values())


def _require_usable(x: Array, y: Array, structure: NetworkStructure, where: str) -> None:
    """Raise a CheckError for fewer rows than weights, or an input or effort that is not finite or does not vary."""
    if not supports(y.size, structure):
        raise CheckError(
            f"{y.size} training rows for the {_weights_of(structure)} weights of {structure.specification}",
            remedy="Log more, or choose a smaller network",
            where=where,
        )
    for name, values in zip(structure.inputs, x, strict=True):
        low, high = float(values.min()), float(values.max())
        if not np.isfinite(high - low):
            bad = int(np.count_nonzero(~np.isfinite(values)))
            raise CheckError(
                f"input {name} has {bad} values that are not finite", remedy="Drop them: --invalid drop", where=where
            )
        if high - low <= _ROUNDING * max(abs(low), abs(high)):
            raise CheckError(
                f"input {name} is constant at {low:g} over all training rows",
                remedy="Log with it changing, or leave it out",
                where=where,
            )
    least, most = float(y.min()), float(y.max())
    if not np.isfinite([least, most]).all() or least == most:
        raise CheckError(
            "the effort is constant or not finite over the training rows", remedy="Check its column", where=where
        )

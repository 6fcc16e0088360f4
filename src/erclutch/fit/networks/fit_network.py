"""A network is fitted to training rows: inputs, normalisation, training, and the model with its figures on all rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from erclutch.errors import CheckError, keywords_checked
from erclutch.fit.left_out_logs import unseen_errors
from erclutch.fit.networks.backprop import slopes_of, tables_of
from erclutch.fit.networks.first_weights import Slips
from erclutch.fit.networks.fit_fnn import Training, schedule_for, train
from erclutch.fit.networks.fit_rbfn import by_forward_selection, by_k_means, refined, weights_for
from erclutch.fit.solver.centroids import centroids_of
from erclutch.fit.solver.levenberg_marquardt import Stop
from erclutch.fit.solver.one_thread import one_thread
from erclutch.fit.solver.outcome import FitOutcome
from erclutch.fit.training_range import near_cells, range_of
from erclutch.logs.dataset import Dataset
from erclutch.models.networks import NetworkKind, NetworkStructure, base_inputs, table_shapes
from erclutch.models.networks.network_inputs import field_in_fluid, inputs_of
from erclutch.models.networks.network_model import NetworkModel, Scaling
from erclutch.models.stages import stages_at
from erclutch.signals.array import Array, Mask
from erclutch.signals.device import Element

Pair = tuple[Array, Array]  # inputs (inputs, n) and effort (n,) of some rows

_NARROW = 0.006  # slip, over its root mean square, below which cells are equally wide
_ROUNDING = 1e-12  # of an input: it varies by less where it is constant but for its last digits


@keywords_checked
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
    inputs = inputs_of(structure, data.elements, data.clock, data.extras, times)
    effort = data.effort
    in_fluid: list[Element] = []
    for element in data.elements:
        field = field_in_fluid(element.field, structure, data.clock, times)
        in_fluid.append(Element(field, element.slip))

    # States have run over all rows; from here on only those count whose effort is known.
    if kept is not None:
        data = data.take(kept)
        inputs = inputs[:, kept]
        effort = effort[kept]
        in_fluid = [Element(element.field[kept], element.slip[kept]) for element in in_fluid]
    judges = kept is not None and not kept.all()
    training = Training(seed, polish, workers, judges)
    outcome = fit_rows(data, (inputs, effort), structure, times, training)
    if not stages_at(structure.dynamics, "command"):
        return outcome
    near = near_cells(outcome.model.trained_on, in_fluid)
    return replace(outcome, model=replace(outcome.model, near=near))


def fit_rows(
    data: Dataset,
    rows: Pair,
    structure: NetworkStructure,
    times: Mapping[str, float],
    training: Training,
) -> FitOutcome[NetworkModel]:
    """Fit a network to inputs and effort of all rows; the data give units, ranges and the period.

    Raises:
        CheckError: as for `fit_network`.
    """
    x, y = rows
    if not supports(y.size, structure):
        raise CheckError(
            f"{y.size} training rows for the {_weights_of(structure)} weights of {structure.specification}",
            remedy="Log more, or choose a smaller network",
            where=data.where,
        )
    for name, values in zip(structure.inputs, x, strict=True):
        low = float(values.min())
        high = float(values.max())
        if not np.isfinite(high - low):
            bad = int(np.count_nonzero(~np.isfinite(values)))
            problem = f"input {name} has {bad} values that are not finite"
            raise CheckError(problem, remedy="Drop them: --invalid drop", where=data.where)
        if high - low <= _ROUNDING * max(abs(low), abs(high)):
            problem = f"input {name} is constant at {low:g} over all training rows"
            remedy = "Log with it changing, or leave it out"
            raise CheckError(problem, remedy=remedy, where=data.where)
    least = float(y.min())
    most = float(y.max())
    if not np.isfinite([least, most]).all() or least == most:
        problem = "the effort is constant or not finite over the training rows"
        raise CheckError(problem, remedy="Check its column", where=data.where)

    scaling = scaling_of(x, y, structure.kind)
    squares = mean_squares(structure, x)
    with one_thread():
        weights, stop, steps = learn(rows, scaling, structure, training, squares)
        lowest = x.min(axis=1)
        highest = x.max(axis=1)
        model = NetworkModel(
            structure=structure,
            scaling=scaling,
            weights=weights,
            dynamics=dict(times),
            units=data.units,
            trained_on=range_of(data),
            input_range=np.column_stack([lowest, highest]),
            about={"seed": str(training.seed)},
            period=data.period,
        )

        def slopes(rows: slice) -> Array:
            """Slopes of the effort by the weights; of an RBFN the centres and spreads stay where they are."""
            unit = model.scaling.inputs(x[:, rows])
            if structure.kind == "rbfn":
                of_bias = np.ones(unit.shape[1])
                return np.vstack([model.last_layer(unit), of_bias]).T
            return slopes_of(model.weights, unit).T

        residual = y - model.of_inputs(x, exactly=False)
        unseen = unseen_errors(data, slopes, residual)  # without the logs of a row's motion
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
        unseen=unseen,
    )


def slips_of(structure: NetworkStructure, x: Array) -> dict[int, Array]:
    """The slips behind the inputs x (inputs, n), by the input in whose place the grid is over them."""
    first = 1 if structure.field else 0
    if structure.device == "single" or structure.kind == "rbfn":
        base = base_inputs(structure.device, structure.kind, field=structure.field)
        return {place: x[place] for place in range(first, len(base))}
    # An FNN of a pair has the two speeds as inputs; each slip is made of both.
    second = first + 1
    return {first: x[first] - x[second], second: -x[first] - x[second]}


def mean_squares(structure: NetworkStructure, x: Array) -> dict[int, float]:
    """Mean square of each slip behind the inputs, by input as in `slips_of`."""
    slips = slips_of(structure, x)
    return {place: float(np.mean(slip**2)) for place, slip in slips.items()}


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


def slips_for(
    structure: NetworkStructure,
    scaling: Scaling,
    squares: Mapping[int, float],
) -> Slips:
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
    low = x.min(axis=1)
    extent = x.max(axis=1) - low
    wide = np.where(extent > 0, extent, 1.0)
    mean = float(np.mean(y))
    least = float(y.min())
    most = float(y.max())
    largest = max(abs(least - mean), abs(most - mean)) or 1.0
    if kind == "fnn":
        return Scaling(low + 0.5 * wide, 0.5 * wide, mean, largest)
    return Scaling(low, wide, mean, largest)


def learn(
    rows: Pair,
    scaling: Scaling,
    structure: NetworkStructure,
    training: Training,
    squares: Mapping[int, float] | None = None,
) -> tuple[dict[str, Array], Stop, int]:
    """Tables of weights for inputs and effort, how the solver ended, and its steps.

    ``squares`` holds the mean square of each slip, by input, see `spaced_by`; None where inputs are only columns.
    """
    x, y = rows
    unit = scaling.inputs(x)
    target = (y - scaling.effort_offset) / scaling.effort_scale
    spaced = unit if squares is None else spaced_by(structure, x, squares)
    gridded = unit, target, spaced
    if structure.kind == "rbfn":
        # Centres are found on a coarse grid. They are refined, where that is asked for, on a finer one.
        coarse, fine = 1, 2
        refine = structure.centres in ("refined", "spreads")
        cells = centroids_of(gridded, (coarse, fine) if refine else (coarse,))
        search = by_k_means if structure.centres == "kmeans" else by_forward_selection
        centres = search(cells[coarse], structure.hidden[0], training.seed)
        if refine:
            centres = refined(cells[fine], centres, one_spread=structure.centres == "refined")
        w, _ = weights_for(unit, target, None, centres.centres, centres.spreads)
        tables = {
            "centres": centres.centres,
            "spreads": centres.spreads,
            "w": w[:-1],
            "b": w[-1:],
        }
        return tables, centres.stop, centres.steps

    schedule = schedule_for(
        structure.hidden, len(structure.inputs), training.polish, training.judges
    )
    slips = None if squares is None else slips_for(structure, scaling, squares)
    trained = train(gridded, structure.hidden, training.seed, schedule, training.workers, slips)
    sizes = (scaling.offset.size, *structure.hidden, 1)
    return tables_of(trained.theta, sizes), trained.stop, trained.steps


def supports(rows: int, structure: NetworkStructure) -> bool:
    """Whether there are at least as many training rows as weights."""
    return rows >= _weights_of(structure)


def _weights_of(structure: NetworkStructure) -> int:
    """Number of weights of a network."""
    shapes = table_shapes(structure).values()
    return sum(int(np.prod(shape)) for shape in shapes)

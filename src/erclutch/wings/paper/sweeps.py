"""Figures 4 and 5 and the RBFM's kernels show error against spread, neurons and kernels.

Networks are trained on centroids. What counts (the best spread of each size, the best restart) is scored on all rows;
the scan over spreads on centroids, with the scatter inside their cells; each restart on every tenth training row.

Each point is a task. A task gets the recipe of its runs, never their rows; a process that has made them keeps them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np

from erclutch.fit.networks.backprop import WeightedRows, tables_of
from erclutch.fit.networks.first_weights import first_weights, with_best_output
from erclutch.fit.networks.fit_network import mean_squares, scaling_of, slips_for, spaced_by
from erclutch.fit.networks.fit_rbfn import candidates, forward_selection, weights_for
from erclutch.fit.networks.geodesic import Trained, levenberg_marquardt
from erclutch.fit.solver.centroids import Centroids, compress
from erclutch.logs.dataset import Dataset
from erclutch.models.networks import NetworkStructure, network_from_name
from erclutch.models.networks.forward import forward_fnn, forward_rbfn
from erclutch.models.networks.network_inputs import inputs_of
from erclutch.runs.cluster import TaskPool
from erclutch.signals.array import Array
from erclutch.wings.paper.sweep_points import Points
from erclutch.wings.paper.tables import law_fit

Report = Callable[[int, int, str], None]

#: Figure 4: spreads (inputs normalised to [0, 1]) and neurons.
SPREADS = tuple(float(s) for s in np.geomspace(0.03, 3.0, 20))
RBFN_NEURONS: tuple[int, ...] = (1, 2, 3, 5, 7, 10, 15, 20, 30, 40, 50, 70, 100)
#: Figure 5.
FNN_NEURONS = tuple(range(1, 31))
RESTARTS = 10
KERNELS = (2, 3, 4, 5, 6, 8, 10, 12, 15, 20)
#: Steps of Levenberg-Marquardt on coarse and on fine centroids.
_COARSE_STEPS = 60
_FINE_STEPS = 40


@dataclass(frozen=True)
class RunsRecipe:
    """How a training run and a test run are made, anywhere.

    Attributes:
        make: a function at the top of a module; gives both, in this order.
        options: its arguments by name, small and hashable.
    """

    make: Callable[..., dict[str, Dataset]]
    options: tuple[tuple[str, Any], ...]


@dataclass(frozen=True)
class SweepTask:
    """One point of a sweep: the runs, the seed of starts, and what is swept."""

    runs: RunsRecipe
    seed: int
    neurons: int = 0
    spread: float = 0.0
    restarts: int = 0


@lru_cache(maxsize=2)
def made(runs: RunsRecipe) -> tuple[Dataset, Dataset]:
    """The training run and the test run; kept by this process."""
    train, test = runs.make(**dict(runs.options)).values()
    return train, test


class UnitRows:
    """Rows of two runs in a network's normalised units."""

    def __init__(self, structure: NetworkStructure, train: Dataset, test: Dataset) -> None:
        inputs = inputs_of(structure, train.elements, train.clock, train.extras, {})
        test_inputs = inputs_of(structure, test.elements, test.clock, test.extras, {})

        # What is known of the scales comes from the training run alone.
        scaling = scaling_of(inputs, train.effort, structure.kind)
        self.scale = scaling.effort_scale
        self.x = scaling.inputs(inputs)
        self.x_test = scaling.inputs(test_inputs)
        self.y = (train.effort - scaling.effort_offset) / self.scale
        self.y_test = (test.effort - scaling.effort_offset) / self.scale

        squares = mean_squares(structure, inputs)
        self.spaced = spaced_by(structure, inputs, squares)
        self.slips = slips_for(structure, scaling, squares)

    def cells(self, level: int) -> Centroids:
        """Centroids of the training rows."""
        return compress(self.x, self.y, level, self.spaced)

    def errors(self, forward: Callable[[Array], Array]) -> list[float]:
        """Mean squared errors in the data's units, on the training and on the test rows."""
        return [
            self._error(forward, self.x, self.y),
            self._error(forward, self.x_test, self.y_test),
        ]

    def thinned_error(self, forward: Callable[[Array], Array]) -> float:
        """Mean squared error in the data's units, on every tenth training row."""
        few_y = self.y[::10]
        return self._error(forward, self.x[:, ::10], few_y)

    def _error(
        self,
        forward: Callable[[Array], Array],
        x: Array,
        y: Array,
    ) -> float:
        # By blocks that stay in the cache.
        rows = 8192  # of a block
        parts: list[Array] = []
        for first in range(0, x.shape[1], rows):
            block = x[:, first : first + rows]
            parts.append(forward(block))
        off = y - np.concatenate(parts)
        return float(np.mean(off**2)) * self.scale**2


@lru_cache(maxsize=2)
def _unit(runs: RunsRecipe, kind: str) -> tuple[UnitRows, Centroids, Centroids]:
    """The rows as a network of this kind takes them, and their centroids, coarse and fine."""
    train, test = made(runs)
    structure = network_from_name(f"{kind}-1", train.device)
    unit = UnitRows(structure, train, test)
    return unit, unit.cells(1), unit.cells(2)


@lru_cache(maxsize=len(SPREADS))
def _centres(runs: RunsRecipe, seed: int, spread: float) -> Array:
    """Centres that forward selection takes at a spread, the best first."""
    _, coarse, _ = _unit(runs, "rbfn")
    pool = candidates(coarse, seed)
    taken, *_ = forward_selection(coarse, pool, spread, max(RBFN_NEURONS))
    return pool[taken]


def _spread_scan(task: SweepTask) -> list[float]:
    """Training errors on centroids at one spread, by neurons."""
    unit, _, fine = _unit(task.runs, "rbfn")
    centres = _centres(task.runs, task.seed, task.spread)
    rows = float(fine.count.sum())
    errors: list[float] = []
    for neurons in RBFN_NEURONS:
        _, cost = _tables(fine, centres[:neurons], task.spread)
        squares = cost + fine.scatter  # of the centroids, and inside their cells
        errors.append(squares / rows * unit.scale**2)
    return errors


def _rbfn_errors(task: SweepTask) -> list[float]:
    """Errors on all rows of one size at one spread."""
    unit, _, fine = _unit(task.runs, "rbfn")
    centres = _centres(task.runs, task.seed, task.spread)
    tables, _ = _tables(fine, centres[: task.neurons], task.spread)
    return unit.errors(partial(forward_rbfn, tables, exactly=False))


def rbfn_sweep(
    runs: RunsRecipe,
    pool: TaskPool,
    points: Points,
    seed: int,
    report: Report,
) -> dict[str, Any]:
    """Figure 4: errors over spread and neurons.

    Returns:
        ``spreads``; ``neurons``; ``scan``, training errors on centroids, shape (spreads, neurons); and at the best
        spread of each size: ``best_spread``, ``train`` and ``test``, shape (neurons,), on all rows.
    """
    total = len(SPREADS) + len(RBFN_NEURONS)

    # First each spread, on centroids.
    scans: dict[str, SweepTask] = {}
    for spread in SPREADS:
        scans[f"spread {spread!r}"] = SweepTask(runs, seed, spread=spread)
    by_spread = points.fill(pool, _spread_scan, scans, lambda done, key: report(done, total, key))
    scan = np.array(by_spread)  # (spreads, neurons)
    best_spreads = np.array(SPREADS)[np.argmin(scan, axis=0)]  # one a size

    # Then each size at its best spread, on all rows.
    sizes: dict[str, SweepTask] = {}
    for neurons, spread in zip(RBFN_NEURONS, best_spreads.tolist(), strict=True):
        sizes[f"neurons {neurons!r}"] = SweepTask(runs, seed, neurons, spread)
    errors = points.fill(
        pool, _rbfn_errors, sizes, lambda done, key: report(len(SPREADS) + done, total, key)
    )
    train_errors, test_errors = np.array(errors).T
    return {
        "spreads": SPREADS,
        "neurons": RBFN_NEURONS,
        "scan": scan,
        "best_spread": best_spreads,
        "train": train_errors,
        "test": test_errors,
    }


def _tables(
    cells: Centroids,
    centres: Array,
    spread: float,
) -> tuple[dict[str, Array], float]:
    """An RBFN with output weights from centroids, and its weighted sum of squares there."""
    spreads = np.full(len(centres), spread)
    weights, squares = weights_for(cells.x, cells.y, cells.count, centres, spreads)
    tables = {
        "centres": centres,
        "spreads": spreads,
        "w": weights[:-1],
        "b": weights[-1:],  # the offset
    }
    return tables, squares


def fnn_sweep(
    runs: RunsRecipe,
    pool: TaskPool,
    points: Points,
    seed: int,
    report: Report,
    neurons: Sequence[int] = FNN_NEURONS,
    restarts: int = RESTARTS,
) -> dict[str, Any]:
    """Figure 5: errors over neurons, each with restarts.

    Returns:
        ``neurons``, ``train`` and ``test`` of the best restart, and ``restarts`` with shape (neurons, restarts).
    """
    tasks: dict[str, SweepTask] = {}
    for size in neurons:
        tasks[f"neurons {size!r}"] = SweepTask(runs, seed, size, restarts=restarts)
    of_sizes = points.fill(
        pool, _fnn_errors, tasks, lambda done, key: report(done, len(neurons), key)
    )
    train_errors, test_errors = np.array([errors["best"] for errors in of_sizes]).T
    of_restarts = np.array([errors["all"] for errors in of_sizes])
    return {
        "neurons": tuple(neurons),
        "train": train_errors,
        "test": test_errors,
        "restarts": of_restarts,
    }


def _fnn_errors(task: SweepTask) -> dict[str, Any]:
    """Errors on all rows of the best restart, and of all restarts on every tenth training row."""
    unit, coarse, fine = _unit(task.runs, "fnn")
    inputs = unit.x.shape[0]
    sizes = (inputs, task.neurons, 1)  # of the layers

    def forward_of(trained: Trained) -> Callable[[Array], Array]:
        return partial(forward_fnn, tables_of(trained.theta, sizes), exactly=False)

    tries: list[Trained] = []
    for restart in range(task.restarts):
        rows = WeightedRows(coarse.x, coarse.y, coarse.count, sizes, single=True)
        rng = np.random.default_rng([task.seed, task.neurons, restart])
        weights = first_weights(rng, sizes, unit.slips)
        start = with_best_output(rows, weights)
        tries.append(levenberg_marquardt(rows, start, _COARSE_STEPS))

    # The best restart alone goes on, on fine centroids.
    best = min(tries, key=lambda trained: trained.cost)
    fine_rows = WeightedRows(fine.x, fine.y, fine.count, sizes, single=True)
    refined = levenberg_marquardt(fine_rows, best.theta, _FINE_STEPS)
    return {
        "best": unit.errors(forward_of(refined)),
        "all": [unit.thinned_error(forward_of(trained)) for trained in tries],
    }


def kernel_sweep(
    runs: RunsRecipe,
    pool: TaskPool,
    points: Points,
    seed: int,
    report: Report,
) -> dict[str, Any]:
    """RBFM: errors over the number of kernels.

    Returns:
        ``kernels``, ``train``, ``test``.
    """
    tasks: dict[str, SweepTask] = {}
    for kernels in KERNELS:
        tasks[f"kernels {kernels!r}"] = SweepTask(runs, seed, kernels)
    errors = points.fill(
        pool, _kernel_errors, tasks, lambda done, key: report(done, len(KERNELS), key)
    )
    train_errors, test_errors = np.array(errors).T
    return {
        "kernels": KERNELS,
        "train": train_errors,
        "test": test_errors,
    }


def _kernel_errors(task: SweepTask) -> list[float]:
    """Errors of so many kernels on all rows of both runs."""
    train, test = made(task.runs)
    form = "/forward" if train.device == "coaxial" else ""
    model = law_fit(train, f"rbfm-{task.neurons}{form}").model
    errors: list[float] = []
    for run in (train, test):
        off = run.effort - model.predict(run)
        errors.append(float(np.mean(off**2)))
    return errors

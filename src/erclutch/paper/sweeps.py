"""Figures 4 and 5, and the RBFM's kernels: error against spread, neurons and kernels.

Networks are trained on centroids. What counts (the best spread of each size, the best restart) is scored on all rows;
the scan over spreads on centroids, with the scatter inside their cells; each restart on every tenth training row.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.dataset import Dataset
from erclutch.experiments.points import Points
from erclutch.fit import fit_structure
from erclutch.fit.backprop import Rows, tables_of
from erclutch.fit.compress import Centroids, compress
from erclutch.fit.first_weights import Slips, first_weights, with_best_output
from erclutch.fit.geodesic import Trained, levenberg_marquardt
from erclutch.fit.networks import mean_squares, scaling_of, slips_for, spaced_by
from erclutch.fit.rbfn import candidates, forward_selection, weights_for
from erclutch.laws import law_from_name
from erclutch.model import Structure
from erclutch.networks import NetworkStructure, network_from_name
from erclutch.networks.inputs import inputs_of
from erclutch.networks.model import forward_fnn, forward_rbfn

Array = NDArray[np.float64]
Report = Callable[[int, int, str], None]

#: Figure 4: spreads (inputs normalised to [0, 1]) and neurons.
SPREADS = tuple(float(s) for s in np.geomspace(0.03, 3.0, 20))
RBFN_NEURONS = (1, 2, 3, 5, 7, 10, 15, 20, 30, 40, 50, 70, 100)
#: Figure 5.
FNN_NEURONS = tuple(range(1, 31))
RESTARTS = 10
KERNELS = (2, 3, 4, 5, 6, 8, 10, 12, 15, 20)
_COARSE_STEPS, _FINE_STEPS = 60, 40


class UnitRows:
    """Rows of two runs in a network's normalised units."""

    def __init__(self, structure: NetworkStructure, train: Dataset, test: Dataset) -> None:
        x, xt = (inputs_of(structure, d.elements, d.clock, d.extras, {}) for d in (train, test))
        scaling = scaling_of(x, train.effort, structure.kind)
        self.x, self.x_test = scaling.inputs(x), scaling.inputs(xt)
        self.scale = scaling.effort_scale
        self.y, self.y_test = ((d.effort - scaling.effort_offset) / self.scale for d in (train, test))
        squares = mean_squares(structure, x)
        self.spaced, self.slips = spaced_by(structure, x, squares), slips_for(structure, scaling, squares)

    def cells(self, level: int) -> Centroids:
        """Centroids of the training rows."""
        return compress(self.x, self.y, level, self.spaced)

    def errors(self, forward: Callable[[Array], Array]) -> list[float]:
        """Mean squared errors in the data's units, on the training and on the test rows."""
        return [
            float(np.mean((y - _in_blocks(forward, x)) ** 2)) * self.scale**2
            for x, y in ((self.x, self.y), (self.x_test, self.y_test))
        ]

    def thinned_error(self, tables: dict[str, Array]) -> float:
        """Mean squared error of an FNN on every tenth training row."""
        x, y = self.x[:, ::10], self.y[::10]
        return (
            float(np.mean((y - _in_blocks(lambda part: forward_fnn(tables, part, exactly=False), x)) ** 2))
            * self.scale**2
        )


def _in_blocks(forward: Callable[[Array], Array], x: Array) -> Array:
    return np.concatenate([forward(x[:, at : at + 8192]) for at in range(0, x.shape[1], 8192)])


def rbfn_sweep(train: Dataset, test: Dataset, points: Points, seed: int, report: Report) -> dict[str, Any]:
    """Figure 4: errors over spread and neurons.

    Returns:
        ``spreads``; ``neurons``; ``scan``, training errors on centroids, shape (spreads, neurons); and at the best
        spread of each size: ``best_spread``, ``train`` and ``test``, shape (neurons,), on all rows.
    """
    unit = UnitRows(network_from_name("rbfn-1", train.device), train, test)
    cells, fine = unit.cells(1), unit.cells(2)
    pool = candidates(cells, seed)
    chosen_by: dict[float, list[int]] = {}
    total = len(SPREADS) + len(RBFN_NEURONS)

    def centres(spread: float, n: int) -> Array:
        if spread not in chosen_by:
            chosen_by[spread] = forward_selection(cells, pool, spread, max(RBFN_NEURONS))[0]
        return pool[chosen_by[spread][:n]]

    scan: list[Any] = []
    found: list[Any] = []
    with _one_thread():
        for i, spread in enumerate(SPREADS, start=1):

            def make(spread: float = spread) -> list[float]:
                left = [_tables(fine, centres(spread, n), spread)[1] + fine.scatter for n in RBFN_NEURONS]
                return [cost / float(fine.count.sum()) * unit.scale**2 for cost in left]

            scan.append(points.get(f"spread {spread!r}", make))
            report(i, total, f"spread {spread:.3g}")
        best = np.argmin(np.array(scan), axis=0)
        for j, n in enumerate(RBFN_NEURONS):

            def score(n: int = n, spread: float = SPREADS[int(best[j])]) -> list[float]:
                tables, _ = _tables(fine, centres(spread, n), spread)
                return unit.errors(lambda x: forward_rbfn(tables, x, exactly=False))

            found.append(points.get(f"neurons {n}", score))
            report(len(SPREADS) + j + 1, total, f"{n} neurons")
    errors = np.array(found)
    return {
        "spreads": SPREADS,
        "neurons": RBFN_NEURONS,
        "scan": np.array(scan),
        "best_spread": np.array(SPREADS)[best],
        "train": errors[:, 0],
        "test": errors[:, 1],
    }


def _tables(cells: Centroids, centres: Array, spread: float) -> tuple[dict[str, Array], float]:
    """An RBFN with output weights from centroids, and its weighted sum of squares there."""
    spreads = np.full(len(centres), spread)
    w, left = weights_for(cells.x, cells.y, cells.count, centres, spreads)
    return {"centres": centres, "spreads": spreads, "w": w[:-1], "b": w[-1:]}, left


def fnn_sweep(
    train: Dataset,
    test: Dataset,
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
    unit = UnitRows(network_from_name("fnn-1", train.device), train, test)
    coarse, fine = unit.cells(1), unit.cells(2)
    found: list[Any] = []
    with _one_thread():
        for i, n in enumerate(neurons, start=1):

            def make(n: int = n) -> dict[str, Any]:
                sizes = (unit.x.shape[0], n, 1)
                tries = [_trained(coarse, sizes, [seed, n, k], unit.slips) for k in range(restarts)]
                best = min(tries, key=lambda t: t.cost)
                rows = Rows(fine.x, fine.y, fine.count, sizes, single=True)
                best = levenberg_marquardt(rows, best.theta, _FINE_STEPS)
                tables = tables_of(best.theta, sizes)
                each = [unit.thinned_error(tables_of(t.theta, sizes)) for t in tries]
                return {"best": unit.errors(lambda x: forward_fnn(tables, x, exactly=False)), "all": each}

            found.append(points.get(f"neurons {n}", make))
            report(i, len(neurons), f"{n} neurons")
    return {
        "neurons": tuple(neurons),
        "train": np.array([f["best"][0] for f in found]),
        "test": np.array([f["best"][1] for f in found]),
        "restarts": np.array([f["all"] for f in found]),
    }


def _trained(cells: Centroids, sizes: Sequence[int], seed: Sequence[int], slips: Slips) -> Trained:
    """One restart. Rows are weighted by count over mean count, so a cost over m rows is m times the mean error."""
    rows = Rows(cells.x, cells.y, cells.count, sizes, single=True)
    first = first_weights(np.random.default_rng(list(seed)), sizes, slips)
    return levenberg_marquardt(rows, with_best_output(rows, first), _COARSE_STEPS)


def kernel_sweep(train: Dataset, test: Dataset, points: Points, seed: int, report: Report) -> dict[str, Any]:
    """RBFM: errors over the number of kernels.

    Returns:
        ``kernels``, ``train``, ``test``.
    """
    found: list[Any] = []
    with _one_thread():
        for i, n in enumerate(KERNELS, start=1):

            def make(n: int = n) -> list[float]:
                name = f"rbfm-{n}" + ("/forward" if train.device == "coaxial" else "")
                structure = Structure(train.device, name, law_from_name(name, train.device))
                model = fit_structure(train, structure, intervals=False).model
                return [float(np.mean((d.effort - model.predict(d)) ** 2)) for d in (train, test)]

            found.append(points.get(f"kernels {n}", make))
            report(i, len(KERNELS), f"{n} kernels")
    table = np.array(found)
    return {"kernels": KERNELS, "train": table[:, 0], "test": table[:, 1]}


def _one_thread() -> Any:
    return import_module("threadpoolctl").threadpool_limits(1)

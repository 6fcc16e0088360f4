"""Parts of the training of networks, from given numbers: what they compute stays as it is kept beside this file.

`tests/conftest.py` says how to pin anew after a change that is meant.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from erclutch.fit.networks import fit_rbfn
from erclutch.fit.networks.backprop import WeightedRows
from erclutch.fit.networks.exchange import exchanged
from erclutch.fit.networks.first_weights import Slips, first_weights, new_neurons
from erclutch.fit.networks.fit_fnn import schedule_for
from erclutch.fit.networks.geodesic import levenberg_marquardt
from erclutch.fit.networks.pruning import smaller, without_one
from erclutch.fit.solver.centroids import compress, grid_of
from erclutch.signals.array import Array
from tests.support.pinning import Pinned, summed


def inputs(count: int = 400) -> tuple[Array, Array]:
    x = np.random.default_rng(3).uniform(-1.0, 1.0, (2, count))
    return x, np.tanh(3.0 * x[0]) * x[1] + 0.3 * x[0] ** 2


def test_centroids(pinned: Pinned) -> None:
    x, y = inputs(5000)
    found: list[Any] = [[grid_of(n, level) for level in (0, 1, 2)] for n in (1, 2, 3, 4, 5)]
    for level in (0, 1, 2):
        for by in (None, x**3):
            cells = compress(x, y, level, by)
            found.append([summed(cells.x), summed(cells.y), summed(cells.count), cells.scatter])
    pinned(found)


def test_steps_of_training(pinned: Pinned) -> None:
    """From weights that are given: a few steps, neurons that go and come."""
    x, y = inputs()
    rng, found = np.random.default_rng(5), []
    slips = Slips(np.array([[0.0, 3.0]]), np.array([0.1]))
    for sizes, along in (((2, 4, 1), slips), ((2, 3, 3, 1), None)):
        theta = first_weights(rng, sizes, along)
        rows = WeightedRows(x, y, 1.0 + x[0] ** 2, sizes, False)
        now = rows.at(theta)
        trained = levenberg_marquardt(rows, theta, 6)
        found += [
            summed(theta),
            now.cost,
            summed(rows.gram(now)),
            summed(rows.bend(now, 0.1 * theta)),
            trained.cost,
        ]
        found += [
            trained.steps,
            trained.stop,
            trained.damping,
            [summed(t) for t in without_one(rows, trained.theta)],
        ]
        found += [summed(part) for part in new_neurons(rng, sizes, 5, along)]
        found.append(smaller(sizes))
    pinned(found, rel=1e-5)


def test_exchanges(pinned: Pinned) -> None:
    x, y = inputs(200)
    sizes, rng = (2, 3, 1), np.random.default_rng(5)
    rows_of = lambda sizes: WeightedRows(x, y, None, sizes, False)  # noqa: E731
    start = levenberg_marquardt(rows_of(sizes), first_weights(rng, sizes), 5)
    found = exchanged(rows_of, sizes, start, rng, None, 2, 2)
    pinned([found.cost, found.steps, found.stop], rel=0.02)


@pytest.mark.slow
def test_centres(pinned: Pinned) -> None:
    x, y = inputs(900)
    cells = compress(x, y, 0)
    found: list[Any] = []
    for way in (fit_rbfn.by_forward_selection, fit_rbfn.by_k_means):
        first = way(cells, 5, 1)
        found += [summed(first.centres), summed(first.spreads)]
    costs = fit_rbfn.forward_selection(cells, fit_rbfn.candidates(cells, 2), 0.7, 6)
    better = fit_rbfn.refined(cells, fit_rbfn.by_k_means(cells, 3, 1), one_spread=True)
    left = fit_rbfn.weights_for(x, y, None, better.centres, better.spreads)[1]
    # Its last steps are of the size of rounding: which of both ends them differs from processor to processor.
    assert better.stop in ("converged", "iterations")
    pinned([found, costs[0], costs[1], left], rel=1e-3)


def test_schedules(pinned: Pinned) -> None:
    kinds = [
        ((8,), 2),
        ((16,), 3),
        ((12, 6), 3),
        ((16,), 5),
        ((16,), 9),
        ((4, 4), 4),
        ((40,), 2),
        ((2,), 2),
    ]
    pinned(
        [
            str(schedule_for(hidden, count, polish))
            for hidden, count in kinds
            for polish in (False, True)
        ]
    )

"""An RBFN is fitted: centres by orthogonal forward selection, by k-means, or refined by Levenberg-Marquardt.

Forward selection after Chen, Cowan and Grant (1991, doi 10.1109/72.80341): of all candidate centres the one that takes
most of what is left of the effort, again and again, each made orthogonal to those before. The spread is the one with
the lowest error of a scan. The output weights are always those of least squares over all rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.fit.solver.centroids import Centroids
from erclutch.fit.solver.levenberg_marquardt import Linearisation, Problem, Stop, minimise
from erclutch.models.networks.forward import gaussians
from erclutch.signals.array import Array

#: Spreads that are scanned, in units of inputs normalised to [0, 1].
SPREADS: tuple[float, ...] = tuple(float(s) for s in np.geomspace(0.08, 2.0, 10))
_CANDIDATES = 400
_MOST_MOVES = 50  # of all centres, in k-means
_BLOCK = 4096
_RIDGE = 1e-10  # of the largest eigenvalue: what is left of double precision in normal equations


@dataclass(frozen=True)
class CentresAndSpreads:
    """Centres and spreads of an RBFN.

    Attributes:
        centres: shape (n, inputs).
        spreads: shape (n,).
        stop: how their search ended.
        steps: of its solver; 0 for a scan.
    """

    centres: Array
    spreads: Array
    stop: Stop = "converged"
    steps: int = 0


def candidates(cells: Centroids, seed: int) -> Array:
    """Candidate centres out of the centroids, shape (m, inputs)."""
    rng = np.random.default_rng([seed, 1])
    chosen: NDArray[np.int64] = rng.permutation(cells.y.size)[:_CANDIDATES]
    return cells.x[:, np.sort(chosen)].T


def forward_selection(
    cells: Centroids,
    pool: Array,
    spread: float,
    neurons: int,
) -> tuple[list[int], Array]:
    """Indices of the chosen candidates in their order, and the cost left after each, in the cells' weighting."""
    root = np.sqrt(cells.count)
    spreads = np.full(len(pool), spread)
    columns = (gaussians(pool, spreads, cells.x) * root).astype(np.float32)  # (candidates, cells)
    left = (cells.y * root).astype(np.float64)
    # The constant of the output layer is there from the start.
    basis: list[Array] = [root / float(np.linalg.norm(root))]
    left -= basis[0] * (basis[0] @ left)
    first = np.sum(columns.astype(np.float64) ** 2, axis=1)
    # Of what is left of each candidate beside those that are chosen.
    norms = first - (columns @ basis[0]) ** 2
    chosen: list[int] = []
    costs: list[float] = []
    for _ in range(min(neurons, pool.shape[0])):
        # What each candidate would take off the cost; none that those before already make up.
        taken = (columns @ left) ** 2 / np.maximum(norms, 1e-30)
        shares = np.where(norms > 1e-6 * first, taken, -1.0)
        shares[chosen] = -1.0
        best = int(np.argmax(shares))
        direction = columns[best].astype(np.float64)
        for _ in range(2):  # twice is enough for orthogonality to rounding
            for other in basis:
                direction -= other * (other @ direction)
        direction /= float(np.linalg.norm(direction)) or 1.0
        left -= direction * (direction @ left)
        norms -= (columns @ direction) ** 2
        basis.append(direction)
        chosen.append(best)
        costs.append(float(left @ left))
    return chosen, np.array(costs)


def by_forward_selection(
    cells: Centroids,
    neurons: int,
    seed: int,
    spreads: Sequence[float] = SPREADS,
) -> CentresAndSpreads:
    """Centres by forward selection, one spread: that of the scan with the lowest cost."""
    pool = candidates(cells, seed)
    if pool.shape[0] < neurons:
        pool = np.resize(pool, (neurons, pool.shape[1]))
    scans = [forward_selection(cells, pool, spread, neurons) for spread in spreads]
    last_costs = [float(costs[-1]) for _, costs in scans]
    best = min(range(len(scans)), key=last_costs.__getitem__)
    chosen, _ = scans[best]
    return CentresAndSpreads(pool[chosen], np.full(neurons, spreads[best]))


def by_k_means(
    cells: Centroids,
    neurons: int,
    seed: int,
    spreads: Sequence[float] = SPREADS,
) -> CentresAndSpreads:
    """Centres by k-means on the weighted centroids (Lloyd's iteration), one spread: the cheapest of the scan."""
    rng = np.random.default_rng([seed, 2])
    count = cells.y.size
    share = cells.count / cells.count.sum()
    drawn = rng.choice(count, neurons, replace=count < neurons, p=share)
    centres = cells.x[:, drawn].T
    for _ in range(_MOST_MOVES):
        # Squared distances but for |x|^2, which is the same for all centres.
        square = np.sum(centres**2, axis=1)[:, None]
        distance = square - 2.0 * centres @ cells.x
        nearest = np.argmin(distance, axis=0)
        mass = np.bincount(nearest, cells.count, neurons)[:, None]
        of_inputs = [np.bincount(nearest, cells.count * x, neurons) for x in cells.x]
        sums = np.array(of_inputs).T  # (neurons, inputs)
        # A centre without cells stays.
        moved = np.where(mass > 0, sums / np.maximum(mass, 1.0), centres)
        if np.array_equal(moved, centres):
            break
        centres = moved

    costs: list[float] = []
    for spread in spreads:
        same = np.full(neurons, spread)
        _, left = weights_for(cells.x, cells.y, cells.count, centres, same)
        costs.append(left)
    best = spreads[int(np.argmin(costs))]
    return CentresAndSpreads(centres, np.full(neurons, best))


def refined(cells: Centroids, start: CentresAndSpreads, *, one_spread: bool) -> CentresAndSpreads:
    """Centres and spreads by Levenberg-Marquardt, output weights projected out (variable projection)."""
    n, k = start.centres.shape  # neurons, inputs
    root = np.sqrt(cells.count / cells.count.mean())
    target = cells.y * root

    def parts(u: Array) -> tuple[Array, Array]:
        """Centres (n, k) and spreads (n,) of the solver's coordinates: centres, then logarithms of spreads."""
        centres = u[: n * k].reshape(n, k)
        spreads = np.exp(u[n * k :])
        return centres, spreads * np.ones(n) if one_spread else spreads

    def solved(u: Array) -> tuple[Array, Array, Array, Array]:
        """Columns (n + 1, cells), their best weights, what they leave, and the spreads."""
        centres, spreads = parts(u)
        ones = np.ones(cells.y.size)
        columns = np.vstack([gaussians(centres, spreads, cells.x), ones]) * root
        w = _least_squares(columns @ columns.T, columns @ target)
        residual = target - w @ columns
        return columns, w, residual, spreads

    def cost(u: Array) -> float:
        residual = solved(u)[2]
        return float(residual @ residual)

    def linearise(u: Array) -> Linearisation:
        columns, w, residual, spreads = solved(u)
        centres, _ = parts(u)
        scaled = w[:n, None] * columns[:n] / (spreads**2)[:, None]
        away = cells.x[None] - centres[:, :, None]
        weighed = scaled[:, None, :] * away
        by_centre = weighed.reshape(n * k, -1)
        by_spread = scaled * np.sum(away**2, axis=1)
        if one_spread:
            by_spread = by_spread.sum(axis=0)[None]
        slopes = np.vstack([by_centre, by_spread])
        # What the output weights cannot follow: the part across the columns.
        q, _ = np.linalg.qr(columns.T)
        free = slopes.T - q @ (q.T @ slopes.T)
        stacked = np.column_stack([free, residual])
        r: Any = np.linalg.qr(stacked, mode="r")
        return Linearisation(
            cost=float(residual @ residual),
            triangle=r[:-1, :-1],
            vector=r[:-1, -1],
        )

    spreads = np.log(start.spreads[:1] if one_spread else start.spreads)
    u = np.concatenate([start.centres.ravel(), spreads])
    # A centre may leave the inputs, which lie within 0 and 1, by their whole range.
    lower = np.empty(u.size)
    upper = np.empty(u.size)
    lower[: n * k] = -1.0
    upper[: n * k] = 2.0
    lower[n * k :] = np.log(0.02)
    upper[n * k :] = np.log(10.0)
    problem = Problem(cost, linearise, lower, upper)
    minimum = minimise(problem, u, tolerance=1e-5, max_iterations=60, reach=1.0)
    centres, widths = parts(minimum.point)
    return CentresAndSpreads(
        centres=centres.copy(),
        spreads=np.broadcast_to(widths, (n,)).copy(),
        stop=minimum.stop,
        steps=minimum.iterations,
    )


def _least_squares(square: Array, right: Array) -> Array:
    """Solution of normal equations, with a ridge that is small enough to change nothing that can be told."""
    from scipy.linalg import solve

    size = square.shape[0]
    lift = _RIDGE * float(np.trace(square)) / size
    lifted = square + lift * np.eye(size)
    return np.asarray(solve(lifted, right, assume_a="pos"), np.float64)


def weights_for(
    x: Array,
    y: Array,
    count: Array | None,
    centres: Array,
    spreads: Array,
) -> tuple[Array, float]:
    """Output weights (w, b last) by least squares over all rows, and the sum of squares that is left.

    Args:
        x: inputs, shape (inputs, n).
        y: effort, shape (n,).
        count: how many rows each stands for, shape (n,); None is one.
        centres: of the neurons, shape (neurons, inputs).
        spreads: of the neurons, shape (neurons,).
    """
    # The normal equations and the sum of squares of the effort, over blocks of rows.
    size = centres.shape[0] + 1
    square = np.zeros((size, size))
    right = np.zeros(size)
    power = 0.0
    for at in range(0, y.size, _BLOCK):
        rows = slice(at, at + _BLOCK)
        target = y[rows]
        neurons = gaussians(centres, spreads, x[:, rows])
        columns = np.vstack([neurons, np.ones(target.size)])
        if count is not None:
            root = np.sqrt(count[rows])
            columns = columns * root
            target = target * root
        square += columns @ columns.T
        right += columns @ target
        power += float(target @ target)
    w = _least_squares(square, right)
    left = power - 2.0 * float(w @ right) + float(w @ square @ w)
    return w, max(left, 0.0)

"""Other basins are looked for from a minimum: one parameter after the other is put to places all over its range.

A law with states has few basins, and the worse ones are alike: the constant of a state has run to a bound, where the
state does nothing. From there the way down begins with that constant somewhere else and all other parameters as they
are, which is also where a fit with one state less and a new state would begin.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.fit.laws.curvature import with_curvature
from erclutch.fit.solver.levenberg_marquardt import Minimum, minimise
from erclutch.fit.solver.variable_projection import Separable, outer_problem, parameters, project
from erclutch.signals.array import Array

_PLACES = 9  # of each parameter
_INNER = (2, 4, 6)  # of them, where a parameter that does nothing is put
_IDLE = 1e-2  # of the cost: a parameter that costs less at another place does nothing
_STEPS = 4  # down from the best place of each parameter
_STARTS = 2  # places from which a look goes all the way down, each of another parameter
_LOOKS = 4
_BETTER = 1e-4  # of the cost: minima that differ by less are one basin


def best_basin(few: Separable, rough: Separable, starts: Sequence[Array]) -> Minimum:
    """The best minimum that can be reached so.

    Args:
        few: the problem on the rows that places are compared on.
        rough: the problem on the rows whose minimum is looked for.
        starts: coordinates where the search begins.
    """
    basins: list[Minimum] = []
    for minimum in _minima(rough, starts, 40):
        if not any(_same(minimum, basin) for basin in basins):
            basins.append(minimum)

    # From each minimum to the next better one, until no look finds any.
    lowest: list[Minimum] = []
    for minimum in basins:
        for _ in range(_LOOKS):
            other = _minima(rough, _elsewhere(few, minimum.point), 40)[0]
            if other.cost > minimum.cost or _same(other, minimum):
                break
            minimum = other
        lowest.append(minimum)
    return min(lowest, key=lambda minimum: minimum.cost)


def _same(one: Minimum, other: Minimum) -> bool:
    """Whether two minima lie in one basin, as far as their costs tell."""
    return abs(one.cost - other.cost) <= _BETTER * other.cost


def _minima(problem: Separable, starts: Sequence[Array], steps: int) -> list[Minimum]:
    """Where so many steps down from some places end, the lowest first."""
    minima: list[Minimum] = []
    for start in starts:
        bent = with_curvature(outer_problem(problem))
        minima.append(minimise(bent, start, tolerance=1e-5, max_iterations=steps))
    return sorted(minima, key=lambda minimum: minimum.cost)


def _elsewhere(few: Separable, point: Array) -> list[Array]:
    """The best places, each of another parameter, at least the distance of two places away from the point.

    The best place of a parameter is chosen as it stands, the best parameters after a few steps down from there: next to
    a parameter that does nothing, all other ways look bad at first. A parameter that does nothing here is moved with
    each of the others: where a ratio is one, the constant that says how fast it fades may be anywhere.
    """
    low, high = few.bounds
    apart = (high - low) / (_PLACES - 1)
    places = low + np.arange(_PLACES)[:, None] * apart  # (places, parameters)

    def cost(u: Array) -> float:
        return project(few, parameters(few.shapes, u)).cost

    # The point with each parameter in turn at all places that are far enough away.
    moved: list[list[Array]] = []
    for i in range(point.size):
        far = [place for place in places[:, i] if abs(place - point[i]) >= apart[i]]
        moved.append([_moved(point, i, place) for place in far])
    little = (1.0 + _IDLE) * cost(point)
    costs = [[cost(u) for u in points] for points in moved]
    idle = [i for i, of_points in enumerate(costs) if min(of_points) < little]

    starts: list[Array] = []
    for i, points in enumerate(moved):
        tried = list(zip(costs[i], points, strict=True))
        for u in points:
            for k in idle:
                if k != i:
                    both_moved = [_moved(u, k, places[inner, k]) for inner in _INNER]
                    tried += [(cost(each), each) for each in both_moved]
        _, cheapest = min(tried, key=lambda pair: pair[0])
        starts.append(cheapest)
    return [minimum.point for minimum in _minima(few, starts, _STEPS)[:_STARTS]]


def _moved(point: Array, i: int, place: float) -> Array:
    """The point with one coordinate at another place."""
    moved = point.copy()
    moved[i] = place
    return moved

"""Other basins are looked for from a minimum: one parameter after the other is put to places all over its range.

A law with states has few basins, and the worse ones are alike: the constant of a state has run to a bound, where the
state does nothing. From there the way down begins with that constant somewhere else and all other parameters as they
are, which is also where a fit with one state less and a new state would begin.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from erclutch.fit.laws.curvature import with_curvature
from erclutch.fit.laws.variable_projection import Separable, outer_problem, parameters, project
from erclutch.fit.levenberg_marquardt import Minimum, minimise
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
    for found in _minima(rough, starts):
        if not any(_same(found, basin) for basin in basins):
            basins.append(found)
    return min((_followed(few, rough, found) for found in basins), key=lambda m: m.cost)


def _followed(few: Separable, rough: Separable, found: Minimum) -> Minimum:
    """From one minimum to the next better one, until no look finds any."""
    for _ in range(_LOOKS):
        other = _minima(rough, _elsewhere(few, found.point))[0]
        if other.cost > found.cost or _same(other, found):
            break
        found = other
    return found


def _same(one: Minimum, other: Minimum) -> bool:
    return abs(one.cost - other.cost) <= _BETTER * other.cost


def _minima(rough: Separable, starts: Sequence[Array]) -> list[Minimum]:
    """The minima below some places, the best first."""
    minima = [minimise(with_curvature(outer_problem(rough)), u, tolerance=1e-5, max_iterations=40) for u in starts]
    return sorted(minima, key=lambda m: m.cost)


def _elsewhere(few: Separable, point: Array) -> list[Array]:
    """The best places, each of another parameter, at least the distance of two places away from the point.

    The best place of a parameter is chosen as it stands, the best parameters after a few steps down from there: next to
    a parameter that does nothing, all other ways look bad at first. A parameter that does nothing here is moved with
    each of the others: where a ratio is one, the constant that says how fast it fades may be anywhere.
    """
    low, high = few.bounds
    apart = (high - low) / (_PLACES - 1)
    places = low + np.arange(_PLACES)[:, None] * apart
    ways = [[_moved(point, i, x) for x in places[:, i] if abs(x - point[i]) >= apart[i]] for i in range(point.size)]
    little = (1.0 + _IDLE) * _cost(few, point)
    idle = [i for i, points in enumerate(ways) if min(_cost(few, u) for u in points) < little]
    starts: list[Array] = []
    for i, points in enumerate(ways):
        both = [_moved(u, k, places[j, k]) for u in points for k in idle if k != i for j in _INNER]
        starts.append(min([*points, *both], key=lambda u: _cost(few, u)))
    down = [minimise(with_curvature(outer_problem(few)), u, tolerance=1e-5, max_iterations=_STEPS) for u in starts]
    return [m.point for m in sorted(down, key=lambda m: m.cost)[:_STARTS]]


def _cost(few: Separable, point: Array) -> float:
    return project(few, parameters(few.shapes, point)).cost


def _moved(point: Array, i: int, place: float) -> Array:
    moved = point.copy()
    moved[i] = place
    return moved

"""Variable projection solves a separable least-squares problem over its nonlinear parameters alone.

    min over q, c of | y - sum_j c_j a_j(q) |**2,   some c_j >= 0,   bounds on q

For each q the gains c follow from a small bounded linear problem; the outer solver sees the residual with the columns'
space projected out (Golub and Pereyra 1973, doi 10.1137/0710036; in Kaufman's form, doi 10.1007/BF01932995).
Derivatives of the columns are exact, by duals. Everything is done on triangles of QR decompositions, never on normal
equations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, reduce
from operator import add
from typing import Any

import numpy as np

from erclutch.arithmetic.dual import Dual, partial_of, value_of
from erclutch.fit.solver.bounded_least_squares import solve_bounded
from erclutch.fit.solver.levenberg_marquardt import Linearisation, Problem
from erclutch.models.laws import Gain, ShapeParameter
from erclutch.signals.array import Array, Mask

#: ``columns(q)`` gives one column (n,) a gain for nonlinear parameters q, numbers or duals.
ColumnsOf = Callable[[Sequence[Any]], Sequence[Any]]


@dataclass(frozen=True)
class Separable:
    """A separable problem.

    Attributes:
        columns: the columns for given nonlinear parameters.
        target: y, shape (n,).
        shapes: the nonlinear parameters, for bounds and scales.
        gains: the linear parameters, for bounds.
        behind: what becomes of each column, a linear map with the same nonlinear parameters; None: nothing does.
        pinned: gain -> the value that it keeps.
    """

    columns: ColumnsOf
    target: Array
    shapes: tuple[ShapeParameter, ...]
    gains: tuple[Gain, ...]
    behind: Callable[[Any, Sequence[Any]], Any] | None = None
    pinned: Mapping[int, float] = field(default_factory=dict[int, float])

    def values(self, columns: Sequence[Any], q: Sequence[float]) -> Array:
        """What becomes of the columns, and the target, side by side, values only, shape (n, p + 1).

        The column of a pinned gain is taken off the target and is zero itself, so that its own gain is held.
        """
        values = [value_of(column) for column in columns]
        if self.behind is not None:
            values = [self.behind(value, q) for value in values]
        stacked = stack(values, self.target)
        target = stacked[:, -1]
        for j, gain in self.pinned.items():
            target -= gain * stacked[:, j]
            stacked[:, j] = 0.0
        return stacked

    def with_pinned(self, gains: Array) -> Array:
        """All gains, those that are pinned among them."""
        every = gains.copy()
        for j, gain in self.pinned.items():
            every[j] = gain
        return every

    @property
    def nonnegative(self) -> Mask:
        """Which gains are bounded by zero, shape (p,)."""
        return np.array([gain.nonnegative for gain in self.gains], np.bool_)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the coordinates."""
        lower = coordinates(self.shapes, [shape.lower for shape in self.shapes])
        upper = coordinates(self.shapes, [shape.upper for shape in self.shapes])
        return lower, upper


def coordinates(shapes: Sequence[ShapeParameter], q: Sequence[float]) -> Array:
    """The solver's coordinates: logarithms where a parameter spans decades."""
    u: Array = np.empty(len(shapes))
    for k, (shape, value) in enumerate(zip(shapes, q, strict=True)):
        u[k] = np.log(value) if shape.scale == "log" else value
    return u


def parameters(shapes: Sequence[ShapeParameter], u: Sequence[float] | Array) -> list[float]:
    """Back from coordinates; within the bounds, which rounding of the exponential may miss."""
    q: list[float] = []
    for shape, coordinate in zip(shapes, u, strict=True):
        value = np.exp(coordinate) if shape.scale == "log" else coordinate
        number = max(float(value), shape.lower)
        q.append(min(number, shape.upper))
    return q


#: Columns are of order one where they are excited. One whose norm over all rows is less than this share of a single
#: such row is not: its gain would be noise, and blow up wherever a later log does excite it.
_UNEXCITED = 0.01


@dataclass(frozen=True)
class Projection:
    """Best gains for given nonlinear parameters.

    Attributes:
        gains: c, shape (p,).
        held: which gains are held at zero: by their bound, or because nothing excites their column.
        dead: which of them nothing excites.
        cost: sum of squared residuals.
    """

    gains: Array
    held: Mask
    dead: Mask
    cost: float

    @classmethod
    def of_known(cls, gains: Array) -> Projection:
        """Gains that are known already, none of them held."""
        none = np.zeros(gains.size, np.bool_)
        return cls(gains, none, none, 0.0)


def project(separable: Separable, q: Sequence[float]) -> Projection:
    """Best gains and their cost at nonlinear parameters ``q``."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"):
        stacked = separable.values(separable.columns(q), q)
        return _gains(stacked, separable.nonnegative)


def stack(columns: Sequence[Any], target: Array) -> Array:
    """Columns and target side by side, values only, shape (n, p + 1)."""
    matrix: Array = np.empty((target.size, len(columns) + 1), order="F")
    for j, column in enumerate(columns):
        matrix[:, j] = value_of(column)
    matrix[:, -1] = target
    return matrix


def triangle_of(matrix: Array) -> Array:
    """R of a QR decomposition, shape (k, k) also where there are fewer rows than columns.

    A tall matrix goes in slices that stay in the cache, whose triangles are then decomposed together: the same R to
    rounding, two to three times as fast (Demmel, Grigori, Hoemmen and Langou 2012, doi 10.1137/080731992).
    """
    return triangle_over((matrix,))


def triangle_over(matrices: Iterable[Array]) -> Array:
    """`triangle_of` matrices one below the other: to the bit where all but the last have many whole slices of rows."""
    from scipy.linalg.lapack import dgeqrf  # without NumPy's copies

    tops: list[Array] = []  # triangles of whole slices, and the rows that are left of each matrix
    for matrix in matrices:
        rows, wide = matrix.shape
        in_slices = bool(tops) or rows >= 2 * _SLICE
        whole = rows // _SLICE * _SLICE if in_slices else 0
        for at in range(0, whole, _SLICE):
            packed = dgeqrf(matrix[at : at + _SLICE])[0]  # R above the diagonal, reflectors below
            tops.append(_upper(packed[:wide]))
        tops.append(np.array(matrix[whole:]))
    last = tops[0] if len(tops) == 1 else np.vstack(tops)
    wide = last.shape[1]
    if not last.size:
        return np.zeros((wide, wide))  # LAPACK prints a complaint where there are no rows
    packed = dgeqrf(last)[0]
    r = _upper(packed[:wide])
    missing = wide - r.shape[0]  # rows, where there are fewer than columns
    if not missing:
        return r
    return np.vstack([r, np.zeros((missing, wide))])


#: Rows of a slice.
_SLICE = 4096


def _upper(matrix: Array) -> Array:
    """`numpy.triu`, whose mask takes longer to make than a small triangle."""
    return np.where(_below(*matrix.shape), _ZERO, matrix)


@cache
def _below(rows: int, columns: int) -> Mask:
    """Which entries stand below the diagonal."""
    return np.tri(rows, columns, -1, np.bool_)


_ZERO = np.zeros(1)


def _gains(matrix: Array, nonnegative: Mask) -> Projection:
    """Best gains from [columns | target], shape (n, p + 1); columns that are not finite have an infinite cost."""
    if np.isfinite(matrix.sum()):
        return gains_of(triangle_of(matrix), nonnegative)
    return no_gains(int(matrix.shape[1]) - 1)


def no_gains(count: int) -> Projection:
    """What so many columns give that are not finite: all gains are held, the cost is infinite."""
    return Projection(
        gains=np.zeros(count),
        held=np.ones(count, np.bool_),
        dead=np.zeros(count, np.bool_),
        cost=np.inf,
    )


def gains_of(r: Array, nonnegative: Mask) -> Projection:
    """Best gains from the triangle of [columns | target], shape (p + 1, p + 1)."""
    p = int(r.shape[1]) - 1
    columns = r[:p, :p]
    target = r[:p, p]
    squares = np.add.reduce(r[:, :p] ** 2, axis=0)
    norms = np.sqrt(squares)
    dead: Mask = norms < _UNEXCITED
    gains: Array = np.zeros(p)
    held = dead.copy()
    if dead.any():
        live = ~dead
        gains[live], held[live] = solve_bounded(columns[:, live], target, nonnegative[live])
    else:  # in the order that a choice of columns has, which decides about the last bit
        gains, held = solve_bounded(np.asfortranarray(columns), target, nonnegative)
    # The corner is what no gain can reach.
    left = target - columns @ gains
    cost = float(r[p, p] ** 2 + np.add.reduce(left**2))
    return Projection(gains, held, dead, cost)


def seeded(shapes: Sequence[ShapeParameter], u: Array) -> list[Dual]:
    """Nonlinear parameters as duals with derivatives by the solver's coordinates."""
    q: list[Dual] = []
    for place, (shape, value) in enumerate(zip(shapes, parameters(shapes, u), strict=True)):
        slope = value if shape.scale == "log" else 1.0
        q.append(Dual(value, {place: slope}))
    return q


def jacobian(separable: Separable, u: Array) -> tuple[Array, Array, Projection]:
    """Columns (n, p), derivatives of the fitted effort by the coordinates (n, k), and the gains."""
    stacked, slopes, projection = linearised(separable, u)
    return stacked[:, :-1], slopes, projection


def linearised(
    separable: Separable,
    u: Array,
    known: Projection | None = None,
) -> tuple[Array, Array, Projection]:
    """Columns and target (n, p + 1), derivatives of the fitted effort (n, k), and the gains if they are not known."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore", under="ignore"):
        q = seeded(separable.shapes, u)
        columns = separable.columns(q)
        stacked = separable.values(columns, [value_of(x) for x in q])
        projection = known or _gains(stacked, separable.nonnegative)

        # The derivatives of the fitted effort, a sum over the columns; most of them do not depend on most coordinates.
        gains = separable.with_pinned(projection.gains)
        slopes = np.zeros((separable.target.size, u.size), order="F")
        if separable.behind is None:
            for gain, column in zip(gains, columns, strict=True):
                if isinstance(column, Dual):
                    for i, partial in column.partials.items():
                        slopes[:, i] += gain * partial
        else:
            effort = reduce(
                add, [gain * column for gain, column in zip(gains, columns, strict=True)]
            )
            effort = separable.behind(effort, q)
            for i in range(u.size):
                slopes[:, i] += partial_of(effort, i)
    return stacked, slopes, projection


def refined(
    columns: Array,
    target: Array,
    projection: Projection,
    triangle: Array,
) -> Projection:
    """The same gains after a step of iterative refinement: what rounding left in the residual is fitted once more.

    Ill-conditioned columns have gains that cancel each other, and the rounding of the first solution shows in what they
    predict. A step that turns a sign, or raises the residual by more than its own rounding, is not taken.
    ``tests/fit/test_rbfm_qr.py`` holds the result to a QR whose residuals are in extended precision.

    Args:
        columns: shape (n, p).
        target: shape (n,).
        projection: the gains.
        triangle: begins with that of the columns whose gains are not held.
    """
    free = ~projection.held
    if not free.any() or not np.isfinite(projection.cost):
        return projection
    before = target - columns @ projection.gains
    # NumPy adds in pairs: sums that are nearly nought keep digits that a product of matrices would lose.
    slope = np.array([np.sum(column * before) for column in columns.T[free]])
    better = corrected(projection, triangle, slope)
    after = target - columns @ better.gains

    norms = np.linalg.norm(triangle, axis=0)[: int(free.sum())]  # of the free columns
    sizes = np.abs(better.gains[free])
    rounding = np.finfo(float).eps * (norms @ sizes)
    is_worse = np.linalg.norm(after) > np.linalg.norm(before) + rounding
    return projection if is_worse else better


def corrected(projection: Projection, triangle: Array, slope: Array) -> Projection:
    """The gains after a step of the corrected seminormal equations, but for a step that turns a sign.

    See Björck 1996, chapter 2.9, doi 10.1137/1.9781611971484. The triangle begins with that of the free columns.
    """
    solve: Any = np.linalg.lstsq
    eps = np.finfo(float).eps
    p = slope.size
    r = triangle[:p, :p]
    scale = np.linalg.norm(r, axis=0)
    scaled = r / scale
    # R' R step = slope, by two solutions: R' first, then R.
    half = solve(scaled.T, slope / scale, rcond=eps)[0]
    step: Any = solve(scaled, half, rcond=eps)[0]
    gains = projection.gains.copy()
    gains[~projection.held] += step / scale
    signs = np.sign(gains) * np.sign(projection.gains)
    turned = bool(np.any(signs < 0))
    return projection if turned else replace(projection, gains=gains)


def outer_problem(separable: Separable) -> Problem:
    """The problem that `levenberg_marquardt.minimise` solves over the coordinates."""
    lower, upper = separable.bounds
    last: tuple[bytes, Projection] | None = None  # a point is linearised where its cost was good

    def cost(u: Array) -> float:
        nonlocal last
        projection = project(separable, parameters(separable.shapes, u))
        last = u.tobytes(), projection
        return projection.cost

    def linearise(u: Array) -> Linearisation:
        known = last[1] if last and last[0] == u.tobytes() else None
        stacked, slopes, projection = linearised(separable, u, known)
        whole = beside(stacked, slopes, projection)
        return local_model(triangle_of(whole), projection)

    return Problem(cost, linearise, lower, upper)


def beside(stacked: Array, slopes: Array, projection: Projection) -> Array:
    """Free columns, derivatives and target side by side."""
    columns = stacked.T[:-1]
    target = stacked.T[-1:]
    return np.vstack([columns[~projection.held], slopes.T, target]).T


def local_model(r: Array, projection: Projection) -> Linearisation:
    """The model over the coordinates alone, from the triangle of what is `beside` each other."""
    # Below the free columns stands what their gains cannot follow: Kaufman's projection.
    p = int(np.count_nonzero(~projection.held))
    end = r.shape[0] - 1  # place of the target
    below = r[p:end]
    return Linearisation(projection.cost, triangle=below[:, p:end], vector=below[:, end])

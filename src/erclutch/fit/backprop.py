"""What Levenberg-Marquardt asks of an FNN on weighted rows: cost, Gram matrix, and the bend along a step.

Rows go through in blocks that stay in the cache, so memory does not grow with them. Only sums are kept: J'J and J'r
(Hagan and Menhaj 1994, doi 10.1109/72.329697), and J' f_vv with the second derivative f_vv of the output along a step,
made exactly by carrying first and second derivatives forward through the layers.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.quick import tanh_in_place

Array = NDArray[np.float64]
Floats = NDArray[Any]
Layers = Sequence[tuple[Floats, Floats]]

_BLOCK = 2048
_KEPT = 50_000_000  # activations that are kept from one use to the next


def weights_of(sizes: Sequence[int]) -> int:
    """Number of weights of a network with these layers, inputs and output included."""
    return sum(after * (before + 1) for before, after in itertools.pairwise(sizes))


def unpacked(theta: Floats, sizes: Sequence[int]) -> list[tuple[Floats, Floats]]:
    """(W, b) of each layer."""
    layers: list[tuple[Floats, Floats]] = []
    at = 0
    for before, after in itertools.pairwise(sizes):
        middle, end = at + after * before, at + after * (before + 1)
        layers.append((theta[at:middle].reshape(after, before), theta[middle:end]))
        at = end
    return layers


def tables_of(theta: Array, sizes: Sequence[int]) -> dict[str, Array]:
    """Weights as the tables of a NetworkModel."""
    *hidden, (w, b) = unpacked(theta, sizes)
    tables: dict[str, Array] = {}
    for i, (weight, bias) in enumerate(hidden, start=1):
        tables |= {f"W{i}": weight.copy(), f"b{i}": bias.copy()}
    return {**tables, "W_out": w.copy(), "b_out": b.copy()}


def theta_of(tables: Mapping[str, Array]) -> Array:
    """Back from tables."""
    return np.concatenate([table.ravel() for table in tables.values()])


@dataclass(frozen=True)
class Point:
    """A network's weights with what its rows make of them.

    Attributes:
        layers: (W, b) of each layer, in the precision of the rows.
        active: of each block, the inputs and each hidden layer's output; empty where they would take too much memory.
        residual: weighted residuals, shape (n,).
        cost: their sum of squares.
    """

    layers: Layers
    active: Sequence[Sequence[Floats]]
    residual: Floats
    cost: float


class Rows:
    """Weighted rows of one round; they come in the precision of the round, sums over blocks in double."""

    def __init__(self, x: Floats, y: Floats, weight: Floats | None, sizes: Sequence[int], single: bool) -> None:
        kind: Any = np.float32 if single else np.float64
        self.x, self.y = np.ascontiguousarray(x, kind), np.ascontiguousarray(y, kind)
        root = np.ones(self.y.size) if weight is None else np.sqrt(weight / weight.mean())
        self.root = root.astype(kind)
        self.sizes, self.kind = tuple(sizes), kind
        self.count = weights_of(sizes)
        self._store = np.empty((self.count + 1, _BLOCK), kind)
        self._kept = self.y.size * sum(sizes[1:-1]) <= _KEPT

    def at(self, theta: Array) -> Point:
        """Residuals and cost at these weights; what is worked out on the way is kept for `gram` and `bend`."""
        layers = unpacked(theta.astype(self.kind), self.sizes)
        kept: list[Sequence[Floats]] = []
        residual, cost = np.empty_like(self.y), 0.0
        for block in self._blocks():
            active = _activations(layers, self.x[:, block])
            part = residual[block]
            np.subtract(self.y[block], _output(layers[-1], active[-1]), out=part)
            part *= self.root[block]
            cost += float(part @ part)
            if self._kept:
                kept.append(active)
        return Point(layers, kept, residual, cost)

    def gram(self, point: Point) -> Array:
        """J'J with J'r in its last row and column and r'r in the corner, shape (p + 1, p + 1)."""
        total = np.zeros((self.count + 1, self.count + 1))
        for block, active in self._active(point):
            root = self.root[block]
            j = self._store[:, : root.size]
            j[-1] = point.residual[block]
            _slopes(point.layers, active, root, j[:-1])
            total += j @ j.T  # NumPy sees the transpose and does half the work
        return total

    def bend(self, point: Point, step: Array) -> Array:
        """J' f_vv, shape (p,): the slope of the cost that the output's curvature along a step adds."""
        along = unpacked(step.astype(self.kind), self.sizes)
        total = np.zeros(self.count)
        for block, active in self._active(point):
            squared = self.root[block] ** 2
            total += _pulled_back(point.layers, active, _second(point.layers, along, active) * squared)
        return total

    def output_gram(self, point: Point) -> Array:
        """`gram` of the output layer's weights alone, with the weighted effort in place of the residual."""
        size = self.sizes[-2] + 1
        total = np.zeros((size + 1, size + 1))
        for block, active in self._active(point):
            root = self.root[block]
            j = np.vstack([active[-1] * root, root, self.y[block] * root])
            total += j @ j.T
        return total

    def _blocks(self) -> Iterator[slice]:
        for at in range(0, self.y.size, _BLOCK):
            yield slice(at, min(at + _BLOCK, self.y.size))

    def _active(self, point: Point) -> Iterator[tuple[slice, Sequence[Floats]]]:
        for i, block in enumerate(self._blocks()):
            yield block, point.active[i] if point.active else _activations(point.layers, self.x[:, block])


def _activations(layers: Layers, x: Floats) -> list[Floats]:
    """The inputs, and each hidden layer's output, shape (neurons, m)."""
    active = [x]
    for w, b in layers[:-1]:
        z = w @ active[-1]
        z += b[:, None]
        active.append(tanh_in_place(z))
    return active


def _output(last: tuple[Floats, Floats], active: Floats) -> Floats:
    w, b = last
    return (w @ active)[0] + b[0]


def _slopes(layers: Layers, active: Sequence[Floats], root: Floats, j: Floats) -> None:
    """Derivatives of the output by all weights, times the rows' root weights, into the rows of j, shape (p, m)."""
    (last_w, _), end = layers[-1], j.shape[0]
    j[end - 1] = root
    np.multiply(active[-1], root, out=j[end - 1 - last_w.size : end - 1])
    end -= 1 + last_w.size
    delta: Floats = last_w[0][:, None] * root
    for i in range(len(layers) - 2, -1, -1):
        w, _ = layers[i]
        rows, columns = w.shape
        delta = np.multiply(delta, 1.0 - active[i + 1] ** 2, out=j[end - rows : end])
        outer = j[end - rows - w.size : end - rows].reshape(rows, columns, -1)
        np.multiply(delta[:, None, :], active[i][None], out=outer)
        end -= rows + w.size
        if i:
            delta = w.T @ delta


def _second(layers: Layers, along: Layers, active: Sequence[Floats]) -> Floats:
    """Second derivative of the output as all weights move along a direction, shape (m,)."""
    first: Floats = np.zeros((0, 0))  # of the inputs, which do not move
    second: Floats = first
    for i, ((w, _), (dw, db)) in enumerate(zip(layers[:-1], along[:-1], strict=True)):
        z = dw @ active[i]
        z += db[:, None]
        if i:
            z += w @ first
        h = active[i + 1]
        steep = 1.0 - h * h
        moved = steep * z
        bent = -2.0 * h * moved * z
        second = bent + steep * (2.0 * (dw @ first) + w @ second) if i else bent
        first = moved
    return (2.0 * (along[-1][0] @ first) + layers[-1][0] @ second)[0]


def _pulled_back(layers: Layers, active: Sequence[Floats], v: Floats) -> Array:
    """J'v for unweighted derivatives of the output, shape (p,)."""
    parts: list[Floats] = [np.array([v.sum()]), active[-1] @ v]
    delta: Floats = layers[-1][0][0][:, None] * v
    for i in range(len(layers) - 2, -1, -1):
        delta = delta * (1.0 - active[i + 1] ** 2)
        parts += [delta.sum(axis=1), (delta @ active[i].T).ravel()]
        if i:
            delta = layers[i][0].T @ delta
    return np.concatenate(parts[::-1]).astype(np.float64)

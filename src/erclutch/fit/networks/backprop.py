"""Levenberg-Marquardt asks this of an FNN on weighted rows: cost, Gram matrix, and the bend along a step.

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

from erclutch.signals.array import Array

Floats = NDArray[Any]
Layers = Sequence[tuple[Floats, Floats]]

_BLOCK = 2048  # rows
_WHOLE = 4_000_000  # elements of J that are one block: J is then worked out once a step
_KEPT = 50_000_000  # activations that are kept from one use to the next


def weights_of(sizes: Sequence[int]) -> int:
    """Number of weights of a network with these layers, inputs and output included."""
    return sum(after * (before + 1) for before, after in itertools.pairwise(sizes))


def unpacked(theta: Floats, sizes: Sequence[int]) -> list[tuple[Floats, Floats]]:
    """(W, b) of each layer."""
    layers: list[tuple[Floats, Floats]] = []
    start = 0
    for before, after in itertools.pairwise(sizes):
        middle = start + after * before
        end = start + after * (before + 1)
        w = theta[start:middle].reshape(after, before)
        b = theta[middle:end]
        layers.append((w, b))
        start = end
    return layers


def packed(layers: Layers) -> Array:
    """Back from (W, b) of each layer."""
    parts: list[Floats] = []
    for w, b in layers:
        parts += [w.ravel(), b]
    return np.concatenate(parts)


def tables_of(theta: Array, sizes: Sequence[int]) -> dict[str, Array]:
    """Weights as the tables of a NetworkModel."""
    *hidden, last = unpacked(theta, sizes)
    tables: dict[str, Array] = {}
    for number, (w, b) in enumerate(hidden, start=1):
        tables[f"W{number}"] = w.copy()
        tables[f"b{number}"] = b.copy()
    w_out, b_out = last
    tables["W_out"] = w_out.copy()
    tables["b_out"] = b_out.copy()
    return tables


def slopes_of(tables: Mapping[str, Array], x: Array) -> Array:
    """Derivatives of an FNN's output for normalised inputs (inputs, n) by all weights, shape (weights, n)."""
    hidden = len(tables) // 2 - 1
    numbers = (str(number) for number in range(1, hidden + 1))
    names = [*numbers, "_out"]
    layers = [(tables[f"W{name}"], tables[f"b{name}"]) for name in names]
    weights = sum(w.size + b.size for w, b in layers)
    slopes: Array = np.empty((weights, x.shape[1]))
    active = _activations(layers, x)
    _slopes(layers, active, np.ones_like(x[0]), slopes)
    return slopes


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


class WeightedRows:
    """Weighted rows of one round; they come in the precision of the round, sums over blocks in double."""

    def __init__(
        self,
        x: Floats,
        y: Floats,
        weight: Floats | None,
        sizes: Sequence[int],
        single: bool,
    ) -> None:
        kind: Any = np.float32 if single else np.float64
        self.kind = kind
        self.x = np.ascontiguousarray(x, kind)  # (inputs, n)
        self.y = np.ascontiguousarray(y, kind)  # (n,)
        rows = self.y.size
        root = np.ones(rows) if weight is None else np.sqrt(weight / weight.mean())
        self.root = root.astype(kind)  # of the weight of each row, (n,)
        self.sizes = tuple(sizes)
        self.count = weights_of(sizes)
        in_one = rows * self.count <= _WHOLE
        self._block = rows if in_one else min(_BLOCK, rows)
        self._store = np.empty((self.count + 1, self._block), kind)  # J and the residual of a block
        self._kept = rows * sum(sizes[1:-1]) <= _KEPT

    def at(self, theta: Array) -> Point:
        """Residuals and cost at these weights; what is worked out on the way is kept for `gram` and `bend`."""
        layers = unpacked(theta.astype(self.kind), self.sizes)
        w_out, b_out = layers[-1]
        kept: list[Sequence[Floats]] = []
        residual = np.empty_like(self.y)
        cost = 0.0
        for block in self._blocks():
            active = _activations(layers, self.x[:, block])
            output = (w_out @ active[-1])[0] + b_out[0]
            part = residual[block]
            np.subtract(self.y[block], output, out=part)
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
        """J' f_vv, shape (p,): the slope of the cost that the output's curvature along a step adds.

        Only after `gram` at the same point: J is still there if all rows are one block.
        """
        along = unpacked(step.astype(self.kind), self.sizes)
        *hidden, (w_out, _) = point.layers
        dw_out, _ = along[-1]
        total = np.zeros(self.count)
        for block, active in self._active(point):
            # First and second derivative of a layer's outputs h = tanh(z) along the step, (neurons, m).
            first: Floats = np.zeros((0, 0))
            second: Floats = first
            for i, (w, _) in enumerate(hidden):
                dw, db = along[i]
                z = dw @ active[i]  # z', in place from here on
                z += db[:, None]
                if i:  # the inputs do not move
                    z += w @ first
                h = active[i + 1]
                steep = _steep(h)
                moved = steep * z  # h' = (1 - h^2) z'
                z *= moved
                z *= h
                z *= -2.0  # the part -2 h h' z' of h''; the other one is (1 - h^2) z''
                second = z + steep * (2.0 * (dw @ first) + w @ second) if i else z
                first = moved

            root = self.root[block]
            bent = (2.0 * (dw_out @ first) + w_out @ second)[0]
            bent *= root
            j = self._store[:-1, : root.size]
            if self._block < self.y.size:
                _slopes(point.layers, active, root, j)
            total += j @ bent
        return total

    def output_gram(self, point: Point, more: tuple[Array, Array] | None = None) -> Array:
        """J'J of the output layer's weights alone, with the weighted effort in the last row and column.

        ``more`` holds W and b of further neurons of the last hidden layer, whose columns come before that of the bias.
        """
        total: Array | float = 0.0
        for block, active in self._active(point):
            root = self.root[block]
            columns = [active[-1] * root]
            if more is not None:
                w, b = (part.astype(self.kind) for part in more)
                columns.append(_layer(w, b, active[-2]) * root)
            j = np.vstack([*columns, root, self.y[block] * root])
            total = total + (j @ j.T).astype(np.float64)
        return np.asarray(total)

    def _blocks(self) -> Iterator[slice]:
        for at in range(0, self.y.size, self._block):
            yield slice(at, min(at + self._block, self.y.size))

    def _active(self, point: Point) -> Iterator[tuple[slice, Sequence[Floats]]]:
        """Each block with the activations of its rows: those that were kept, else anew."""
        for number, block in enumerate(self._blocks()):
            if point.active:
                yield block, point.active[number]
            else:
                yield block, _activations(point.layers, self.x[:, block])


def _activations(layers: Layers, x: Floats) -> list[Floats]:
    """The inputs, and each hidden layer's output, shape (neurons, m)."""
    active = [x]
    for w, b in layers[:-1]:
        active.append(_layer(w, b, active[-1]))
    return active


def _layer(w: Floats, b: Floats, below: Floats) -> Floats:
    """Outputs of a hidden layer, shape (neurons, m), from those of the layer below."""
    z = w @ below
    z += b[:, None]
    return np.tanh(z, out=z)


def _slopes(
    layers: Layers,
    active: Sequence[Floats],
    root: Floats,
    j: Floats,
) -> None:
    """Derivatives of the output by all weights, times the rows' root weights, into the rows of j, shape (p, m)."""
    # From the last layer back; of each layer the bias stands behind the weights.
    w_out, _ = layers[-1]
    end = j.shape[0] - 1
    j[end] = root
    np.multiply(active[-1], root, out=j[end - w_out.size : end])
    end -= w_out.size
    # Of the output by the outputs of a layer, (neurons, m).
    delta: Floats = w_out[0][:, None] * root
    for i in range(len(layers) - 2, -1, -1):
        w, _ = layers[i]
        neurons, inputs = w.shape
        of_bias = j[end - neurons : end]
        end -= neurons
        of_weights = j[end - w.size : end].reshape(neurons, inputs, -1)
        end -= w.size
        delta = np.multiply(delta, _steep(active[i + 1]), out=of_bias)
        np.multiply(delta[:, None, :], active[i][None], out=of_weights)
        if i:
            delta = w.T @ delta


def _steep(h: Floats) -> Floats:
    """Slope of tanh where its value is h."""
    square = h * h
    return np.subtract(1.0, square, out=square)

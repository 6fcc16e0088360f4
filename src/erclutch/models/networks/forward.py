"""The forward pass of a network, from normalised inputs to the effort: with the bits of the C, or through BLAS."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic import as_in_c
from erclutch.arithmetic.elementary import elementary
from erclutch.arithmetic.precision import FLOAT32
from erclutch.signals.array import Array


def forward_fnn(
    weights: Mapping[str, Array],
    x: NDArray[Any],
    *,
    exactly: bool = True,
) -> NDArray[Any]:
    """Equation (19), any number of hidden layers: W_out tanh(... tanh(W1 x + b1)) + b_out, shape (n,).

    Exactly: with the bits of the exported C in the precision of x. Otherwise through BLAS and NumPy's own functions.
    """
    tables = {name: table.astype(x.dtype, copy=False) for name, table in weights.items()}
    hidden = last_hidden(tables, x, exactly=exactly)  # (neurons, n)
    w_out = tables["W_out"][0]
    output = _weighted(w_out, hidden) if exactly else w_out @ hidden
    return tables["b_out"][0] + output


def last_hidden(
    tables: Mapping[str, Array],
    x: NDArray[Any],
    *,
    exactly: bool,
) -> NDArray[Any]:
    """Outputs of the last hidden layer of an FNN, shape (neurons, n)."""
    tanh = _functions(x)["tanh"] if exactly else np.tanh
    active = x
    layer = 1
    while f"W{layer}" in tables:
        w = tables[f"W{layer}"]
        b = tables[f"b{layer}"]
        if exactly:
            # From left to right as in the exported C: BLAS would add in an order that nobody knows.
            sums = np.repeat(b[:, None], active.shape[1], axis=1)
            for j in range(len(active)):
                sums += w[:, j : j + 1] * active[j]
        else:
            sums = w @ active + b[:, None]
        active = tanh(sums)
        layer += 1
    return active


def forward_rbfn(
    weights: Mapping[str, Array],
    x: NDArray[Any],
    *,
    exactly: bool = True,
) -> NDArray[Any]:
    """Equation (17): ``w_0 + sum_i w_i exp(-|x - c_i|^2 / (2 s_i^2))``, shape (n,); see `forward_fnn`."""
    tables = {name: table.astype(x.dtype, copy=False) for name, table in weights.items()}
    centres = tables["centres"]
    spread_square = (weights["spreads"] ** 2).astype(x.dtype, copy=False)
    distance_square = np.zeros((len(centres), x.shape[1]), x.dtype)  # of each neuron to each row
    for j in range(len(x)):
        distance = x[j] - centres[:, j : j + 1]
        distance_square += distance * distance
    exp = _functions(x)["exp"] if exactly else np.exp
    active = exp(-0.5 * distance_square / spread_square[:, None])
    return tables["b"][0] + _weighted(tables["w"], active)


def _functions(x: NDArray[Any]) -> Mapping[str, Callable[..., Any]]:
    """The exported C's functions in the precision of an array; NumPy's own for operands that record."""
    if x.dtype == object:
        # Elementwise, so that each operand answers by its own method.
        exp: Any = np.frompyfunc(np.exp, 1, 1)
        tanh: Any = np.frompyfunc(np.tanh, 1, 1)
        return {"exp": exp, "tanh": tanh}
    if x.dtype == np.float32:
        return elementary(FLOAT32)
    return {"tanh": as_in_c.tanh, "exp": as_in_c.exp}


def _weighted(weights: Array, a: Array) -> Array:
    """sum_i w_i a_i: four running sums side by side, then pairs, then what is left over; the order of the C."""
    whole = len(a) // 4 * 4
    four = [np.zeros(a.shape[1], a.dtype) for _ in range(4)]
    for i in range(whole):
        four[i % 4] += weights[i] * a[i]
    first = four[0] + four[1]
    second = four[2] + four[3]
    total = first + second
    for i in range(whole, len(a)):
        total = total + weights[i] * a[i]
    return total


def gaussians(centres: Array, spreads: Array, x: Array) -> Array:
    """Activations of an RBFN's neurons, shape (neurons, n): by one matrix product, for fits."""
    # |x - c|^2 = |c|^2 + |x|^2 - 2 c x
    of_centres = np.sum(centres**2, axis=1)[:, None]  # (neurons, 1)
    of_rows = np.sum(x**2, axis=0)[None]  # (1, n)
    distance_square = of_centres + of_rows - 2.0 * (centres @ x)
    spread_square = (spreads**2)[:, None]
    # Rounding may leave less than zero.
    return np.exp(-0.5 * np.maximum(distance_square, 0.0) / spread_square)

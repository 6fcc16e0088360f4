"""This module finds the neuron that contributes least and adjusts the other weights to its loss.

A network with some neurons too many trains to lower minima than one of the final size, and stays low as they go one by
one. The neuron of the last hidden layer goes whose output weight costs least to set to zero while all other weights
follow: the optimal brain surgeon (Hassibi and Stork 1993, doi 10.1109/ICNN.1993.298572) on a damped J'J.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from erclutch.fit.networks.backprop import WeightedRows, packed, unpacked
from erclutch.signals.array import Array

AFTER_LOSS = 1e-4  # damping of the first step after a neuron has gone
_DAMPING = 1e-5  # over each diagonal element of J'J
_FLOOR = 1e-2  # of such an element, over the largest of them


def without_least(rows: WeightedRows, theta: Array) -> Array:
    """Weights of the network without the neuron of its last hidden layer that it misses least."""
    return next(without_one(rows, theta))


def without_one(rows: WeightedRows, theta: Array) -> Iterator[Array]:
    """Weights of the network without one neuron of its last hidden layer, for each, the least missed first."""
    square = rows.gram(rows.at(theta))[:-1, :-1]  # J'J
    diagonal = square.diagonal()
    square[np.diag_indices_from(square)] += _DAMPING * (diagonal + _FLOOR * diagonal.max())
    inverse = np.linalg.inv(square)
    # The output weights stand last, ahead of the bias.
    outputs = np.arange(-1 - rows.sizes[-2], -1) + theta.size
    cost = theta[outputs] ** 2 / inverse.diagonal()[outputs]
    for neuron in np.argsort(cost).tolist():
        gone = outputs[neuron]
        surprise = theta[gone] / inverse[gone, gone]
        followed = theta - inverse[:, gone] * surprise
        # The weights into and out of the neuron go.
        *others, (w, b), (w_out, b_out) = unpacked(followed, rows.sizes)
        last = np.delete(w, neuron, 0), np.delete(b, neuron)
        output = np.delete(w_out, neuron, 1), b_out
        yield packed([*others, last, output])


def smaller(sizes: Sequence[int]) -> tuple[int, ...]:
    """Layers with one neuron less in the last hidden one."""
    return (*sizes[:-2], sizes[-2] - 1, sizes[-1])

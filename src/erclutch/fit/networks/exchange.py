"""A trained network exchanges a neuron for another and trains on, which leads from a good minimum to a better one.

A neuron that is hardly missed goes (`pruning`), and of many random ones the one comes that takes most from the
residual beside those that are there, as in orthogonal forward selection (Chen, Cowan and Grant 1991,
doi 10.1109/72.80341). It stays if the cost ends lower.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from erclutch.fit.networks.backprop import WeightedRows, packed, unpacked
from erclutch.fit.networks.first_weights import Slips, new_neurons, with_best_output
from erclutch.fit.networks.geodesic import FIRST_DAMPING, Trained, levenberg_marquardt
from erclutch.fit.networks.pruning import AFTER_LOSS, smaller, without_one

_CANDIDATES = 60
_STEPS_AFTER_LOSS = 6
_STEPS = 20  # after a neuron has come
_RIDGE = 1e-3  # of a candidate's square, over the number of rows: none comes that is a copy of what is there
_ROUNDING = 1e-7  # of the largest square, which single precision hides
_LOWER = 0.9995  # of the cost: a smaller fall ends the search


def exchanged(
    rows_of: Callable[[Sequence[int]], WeightedRows],
    sizes: Sequence[int],
    start: Trained,
    rng: np.random.Generator,
    slips: Slips | None,
    tries: int,
    most: int,
) -> Trained:
    """A trained network after exchanges of neurons of its last hidden layer, until none lowers its cost.

    Args:
        rows_of: rows for a network of these layers.
        sizes: layers of the network, inputs and output included.
        start: where to begin.
        rng: of the new neurons.
        slips: along which some of them are transitions.
        tries: neurons that an exchange tries to replace, the least missed first; the best result stays.
        most: exchanges.
    """
    if sizes[-2] == 1:
        return replace(start, steps=0)
    rows = rows_of(sizes)
    fewer = rows_of(smaller(sizes))
    best = start
    steps = 0
    for _ in range(most):
        before = best
        for theta in islice(without_one(rows, before.theta), tries):
            without = with_best_output(fewer, theta)
            left = levenberg_marquardt(fewer, without, _STEPS_AFTER_LOSS, AFTER_LOSS)

            # How much each new neuron would take from the cost with the output layer at its least squares, from the
            # products of neurons, new neurons, bias and effort, in this order.
            w_new, b_new = new_neurons(rng, fewer.sizes, _CANDIDATES, slips)
            total = fewer.output_gram(fewer.at(left.theta), (w_new, b_new))
            neurons = fewer.sizes[-2]
            bias = len(total) - 2
            there = np.array([*range(neurons), bias])
            come = np.arange(neurons, bias)
            # Of each the part that those that are there cannot make up: its square, and its product with the effort.
            square = total[np.ix_(there, there)]
            square[np.diag_indices_from(square)] += _ROUNDING * square.diagonal().max()
            across = total[np.ix_(there, come)]
            along = np.linalg.solve(square, across).astype(np.float64, copy=False)
            own = total[come, come] - np.einsum("ij,ij->j", across, along)
            slope = total[come, -1] - total[there, -1] @ along
            gains = slope**2 / (np.maximum(own, 0.0) + _RIDGE * fewer.y.size)
            most_helpful = int(np.argmax(gains))

            # It joins the last hidden layer, and has no say in the output yet.
            *others, (w, b), (w_out, b_out) = unpacked(left.theta, fewer.sizes)
            w_with_it = np.vstack([w, w_new[most_helpful]])
            b_with_it = np.append(b, b_new[most_helpful])
            w_out_with_it = np.append(w_out, [[0.0]], axis=1)
            joined = packed([*others, (w_with_it, b_with_it), (w_out_with_it, b_out)])
            grown = with_best_output(rows, joined)
            after = levenberg_marquardt(rows, grown, _STEPS, FIRST_DAMPING)
            steps += left.steps + after.steps
            best = min(best, after, key=lambda t: t.cost)
        if best.cost >= _LOWER * before.cost:
            break
    return replace(best, steps=steps)

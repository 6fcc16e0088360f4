"""The training of an FNN starts from random weights that know where the effort of such devices bends.

An effort turns over within a narrow band round each slip's zero, and random weights take many steps to get that steep.
So a share of the first layer's neurons starts as transitions along the slips, of random width; the other neurons and
layers start after Nguyen and Widrow (1990, doi 10.1109/IJCNN.1990.137819). The output layer is linear: its weights are
those of least squares on the rows.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from erclutch.fit.networks.backprop import WeightedRows
from erclutch.signals.array import Array

Layer = tuple[Array, Array]

_SHARE = 0.55  # of the first layer's neurons that start as transitions without further inputs: as many for each slip
_WIDTHS = (0.01, 0.4)  # of transitions, over the slip's root mean square
_FIELD = 0.7  # standard deviation of a transition's weight of the field
_ONE_HIDDEN = 3  # layers, with those of inputs and output
#: Ridge of the least squares, over the number of rows: with it neurons that start alike do not cancel.
_RIDGE = 1e-4


@dataclass(frozen=True)
class Slips:
    """Slips over their root mean square as linear functions of normalised inputs x: slope x + offset.

    Attributes:
        slope: shape (slips, inputs).
        offset: shape (slips,).
        field: whether the first input is the field.
    """

    slope: Array
    offset: Array
    field: bool = True


def first_weights(
    rng: np.random.Generator,
    sizes: Sequence[int],
    slips: Slips | None = None,
) -> Array:
    """Random weights for inputs within -1 and 1, with transitions along the slips if these are given."""
    parts: list[Array] = []
    for layer, (before, after) in enumerate(itertools.pairwise(sizes[:-1])):
        w, b = _spread(rng, before, after)
        if layer == 0 and slips is not None:
            _transitions(rng, slips, w, b)
        parts += [w.ravel(), b]
    scale = 1.0 / np.sqrt(sizes[-2])
    w_out = rng.uniform(-scale, scale, sizes[-2])
    b_out = np.zeros(1)
    return np.concatenate([*parts, w_out, b_out])


def new_neurons(
    rng: np.random.Generator,
    sizes: Sequence[int],
    count: int,
    slips: Slips | None,
) -> Layer:
    """W and b of so many random neurons for the last hidden layer."""
    w, b = _spread(rng, sizes[-3], count)
    if len(sizes) == _ONE_HIDDEN and slips is not None:
        _transitions(rng, slips, w, b)
    return w, b


def _spread(rng: np.random.Generator, before: int, after: int) -> Layer:
    """Weights whose transitions lie evenly over the inputs (Nguyen and Widrow)."""
    w = rng.uniform(-1.0, 1.0, (after, before))
    reach = 0.7 * after ** (1.0 / before)
    w *= reach / np.linalg.norm(w, axis=1, keepdims=True)
    if after == 1:
        return w, np.zeros(1)
    even = np.linspace(-1.0, 1.0, after)
    return w, reach * even * np.sign(w[:, 0])


def _transitions(
    rng: np.random.Generator,
    slips: Slips,
    w: Array,
    b: Array,
) -> None:
    """Make the first neurons transitions at zero slip, slip after slip, each of a width of its own.

    Their weights of further inputs stay, and the more of these there are, the more neurons stay as they were.
    """
    own = np.any(slips.slope != 0.0, axis=0)
    own[0] = True  # the field, or a slip where the field is no input
    ways = slips.offset.size
    count = ways * round(_SHARE * float(own.mean()) * b.size / ways)
    narrow, wide = _WIDTHS
    width = narrow * (wide / narrow) ** rng.uniform(size=count)
    which = np.arange(count) % ways
    slopes = slips.slope[which] / width[:, None]
    w[:count, own] = slopes[:, own]
    w[:count, 0] += slips.field * _FIELD * rng.standard_normal(count)
    b[:count] = slips.offset[which] / width


def with_best_output(rows: WeightedRows, theta: Array) -> Array:
    """Weights whose output layer is the least-squares solution on the rows."""
    total = rows.output_gram(rows.at(theta))
    square = total[:-1, :-1]
    slope = total[:-1, -1]
    square[np.diag_indices_from(square)] += _RIDGE * rows.y.size
    best = np.linalg.solve(square, slope).astype(np.float64, copy=False)
    return np.concatenate([theta[: -slope.size], best])

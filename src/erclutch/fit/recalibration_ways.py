"""Ways to recalibrate a model: which of its numbers may move, how far, and what they do to the effort."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.arithmetic.dual import partial_of, value_of
from erclutch.fit.solver.variable_projection import coordinates, parameters, seeded
from erclutch.logs.dataset import STEADY, Dataset
from erclutch.models.composition import OFFSET as CONSTANT_EFFORT
from erclutch.models.law_model import TorqueModel
from erclutch.models.model import Model
from erclutch.models.networks.network_inputs import inputs_of
from erclutch.models.networks.network_model import NetworkModel
from erclutch.models.stages import stages_at
from erclutch.signals.array import Array, rms

Rows = NDArray[np.intp]

#: Numbers of a whole model: what multiplies its effort, and what is added.
GAIN = "gain"
OFFSET = CONSTANT_EFFORT.name
#: Ways of more than the whole model's gain.
_ALL = "all numbers"
_FREE = "gains and offset"
_SMALL = 0.1  # a gain near zero may change by this share of the largest one


@dataclass(frozen=True)
class Number:
    """A number that may move: its value in the base, its usual change, and its bounds."""

    name: str
    start: float
    reach: float
    lower: float = -np.inf
    upper: float = np.inf


@dataclass(frozen=True)
class Way:
    """A set of numbers that may move together.

    Attributes:
        name: of the way, for people.
        numbers: those that may move, k of them.
        columns: slopes of the effort by the numbers, shape (n, k), at the values ``at``.
        model: the model for other values of the numbers, shape (k,).
        at: values of the numbers, shape (k,).
        slopes: the columns at other values; None where the effort is linear in the numbers.
        said: from values of a solver's coordinates to values as the model has them, shape (k,) both.
    """

    name: str
    numbers: Sequence[Number]
    columns: Array
    model: Callable[[Array], Model]
    at: Array
    slopes: Callable[[Array], Array] | None = None
    said: Callable[[Array], Array] = np.asarray

    @property
    def start(self) -> Array:
        """Values of the numbers in the base, shape (k,)."""
        return np.array([number.start for number in self.numbers])


def ways_of(
    model: Model,
    data: Dataset,
    rows: Rows,
    effort: Array,
) -> Iterator[Way]:
    """All ways for a model, from the one with the fewest numbers on.

    Args:
        model: the base.
        data: the new log.
        rows: those whose effort is looked at, shape (n,).
        effort: of the base on these rows, shape (n,).
    """
    gain = Number(GAIN, 1.0, 1.0, lower=0.0)
    usual_effort = rms(effort) or 1.0
    offset = Number(OFFSET, 0.0, usual_effort)
    ones = np.ones(effort.size)
    yield _linear("common gain", [gain], [effort], lambda c: model.scaled(c[0]))
    yield _linear(
        "common gain and offset", [gain, offset], [effort, ones], lambda c: model.scaled(*c)
    )

    law = model.law_part
    network = model.network_part
    if model.correction is not None:
        of_network = model.added(data.elements, data.clock, data.extras, exactly=False)
        added = of_network[rows]
        for name in ("gains", _FREE):
            yield _with_network(_gains(name, law, data, rows), model, added)
    elif law is not None:
        for name in ("gains", _FREE):
            yield _gains(name, law, data, rows)
        # One field tells nothing of an exponent of the field.
        fields_differ = False
        for element in data.elements:
            moved = np.ptp(element.field[rows])
            fields_differ |= bool(moved > STEADY * np.abs(element.field).max())
        if law.shape and fields_differ:
            yield _all_numbers(law, data, rows)
    elif network is not None and not stages_at(network.structure.dynamics, "effort"):
        # The weights of the output layer, in which the effort is linear: its tables are the last two.
        inputs = inputs_of(
            network.structure, data.elements, data.clock, data.extras, network.dynamics
        )
        active = network.last_layer(network.scaling.inputs(inputs[:, rows]))  # (neurons, n)
        columns = network.scaling.effort_scale * np.column_stack([*active, ones])
        of_weights, of_bias = list(network.weights)[-2:]
        weights = network.weights[of_weights]
        start = np.concatenate([weights.ravel(), network.weights[of_bias]])
        reach = np.maximum(np.abs(start), _SMALL * np.abs(start).max())
        numbers: list[Number] = []
        for place in range(start.size):
            at = float(start[place])
            numbers.append(Number(f"w_{place}", at, float(reach[place])))

        def with_output_layer(c: Array) -> NetworkModel:
            w_out = c[:-1].reshape(weights.shape)
            last = {of_weights: w_out, of_bias: c[-1:]}
            return replace(network, weights={**network.weights, **last})

        yield _linear(_ALL, numbers, [columns], with_output_layer)


def _linear(
    name: str,
    numbers: Sequence[Number],
    columns: Sequence[Array],
    model: Callable[[Array], Model],
) -> Way:
    """A way in whose numbers the effort is linear."""
    start = np.array([number.start for number in numbers])
    return Way(name, numbers, np.column_stack(columns), model, start)


def _gains(
    name: str,
    law: TorqueModel,
    data: Dataset,
    rows: Rows,
) -> Way:
    """The gains of a law; a constant effort is among them only where the way is free to have one."""
    structure = replace(law.structure, offset=name == _FREE)
    shape = list(law.shape.values())
    columns = structure.columns(data.elements, data.clock, law.reference, shape, extras=data.extras)
    largest_gain = max(map(abs, law.gains.values()))
    least = _SMALL * largest_gain
    numbers: list[Number] = []
    for gain in structure.gains():
        start = law.gains.get(gain.name, 0.0)
        lower = 0.0 if gain.nonnegative else -np.inf
        reach = max(abs(start), least)
        numbers.append(Number(gain.name, start, reach, lower))
    names = [number.name for number in numbers]

    def model(c: Array) -> TorqueModel:
        gains = dict(zip(names, c.tolist(), strict=True))
        return law.with_gains(gains)

    return _linear(name, numbers, [column[rows] for column in columns], model)


def _with_network(way: Way, base: Any, added: Array) -> Way:
    """The gains of a law, and the share of the network on its residual, which adds so much now, shape (n,)."""
    share = Number("network", 1.0, 1.0, lower=0.0)

    def model(c: Array) -> Model:
        law = way.model(c[:-1]).law_part
        return base.with_parts(law, float(c[-1]))

    columns = [way.columns, added]
    return _linear(way.name, [*way.numbers, share], columns, model)


def _all_numbers(law: TorqueModel, data: Dataset, rows: Rows) -> Way:
    """Shape and gains of a law, the constant effort too; the shape as the solver's coordinates u."""
    shapes = law.structure.shapes(law.period)
    gains = _gains(_FREE, law, data, rows)
    u = coordinates(shapes, list(law.shape.values()))
    k = u.size
    low = coordinates(shapes, [shape.lower for shape in shapes])
    high = coordinates(shapes, [shape.upper for shape in shapes])
    numbers: list[Number] = []
    for place, shape in enumerate(shapes):
        # A factor of e is usual where a number may span decades, half the range that is searched elsewhere.
        least, most = shape.scanned
        reach = 1.0 if shape.scale == "log" else 0.5 * (most - least)
        numbers.append(Number(shape.name, u[place], reach, low[place], high[place]))

    def model(c: Array) -> TorqueModel:
        q = parameters(shapes, c[:k])
        shape = dict(zip(law.shape, q, strict=True))
        return replace(gains.model(c[k:]).law_part, shape=shape)

    def slopes(c: Array) -> Array:
        q = seeded(shapes, c[:k])
        structure = replace(law.structure, offset=True)
        columns = structure.columns(data.elements, data.clock, law.reference, q, extras=data.extras)
        effort = sum(gain * column for gain, column in zip(c[k:], columns, strict=True))
        by_shape: list[Array] = []
        for place in range(k):
            of_all_rows = np.broadcast_to(partial_of(effort, place), data.rows)
            by_shape.append(of_all_rows[rows])
        by_gain = [value_of(column)[rows] for column in columns]
        return np.column_stack([*by_shape, *by_gain])

    def said(c: Array) -> Array:
        return np.concatenate([parameters(shapes, c[:k]), c[k:]])

    start = np.concatenate([u, gains.start])
    return Way(_ALL, [*numbers, *gains.numbers], gains.columns, model, start, slopes, said)

"""Whether effort follows the field one way: what makes an inverse unique. Checked on a grid, per side of zero field."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from erclutch.model import TorqueModel
from erclutch.networks.model import NetworkModel
from erclutch.saved import Model

Array = NDArray[np.float64]
_FIELDS, _SPEEDS = 33, 11
_SLACK = 1e-9  # of the effort's scale: rounding is no turning point


def steady(model: Model, fields: list[Array], slips: list[Array], extras: list[Array]) -> Array:
    """Effort at rest, shape (n,): the fluid settled, all past samples as the present."""
    if isinstance(model, TorqueModel):
        return model.steady(fields, slips)
    s = model.structure
    if s.device == "single":
        base = [fields[0], slips[0]]
    elif s.kind == "rbfn":
        base = [fields[0] - fields[1], *slips]
    else:
        base = [fields[0] - fields[1], 0.5 * (slips[0] - slips[1]), -0.5 * (slips[0] + slips[1])]
    rows = np.array([*base, *(x for _ in s.past for x in base), *extras], np.float64)
    return model.forward(model.scaling.inputs(rows))


def sides(model: Model) -> tuple[float, float, float]:
    """Origin, largest and smallest signed field of the inverse."""
    low, high = model.trained_on.field
    largest = max(abs(low), abs(high))
    if model.structure.device == "coaxial":
        return 0.0, largest, -largest
    if isinstance(model, TorqueModel):
        origin = min(max(low, 0.0), largest)
        return origin, largest, origin
    if low < 0.0 < high:
        return 0.0, high, low
    return low, high, low


def apart(model: Model, signed: Array) -> list[Array]:
    """The fields of the elements for a signed field."""
    return [np.maximum(signed, 0.0), np.maximum(-signed, 0.0)] if model.structure.device == "coaxial" else [signed]


def middles(model: Model) -> list[float]:
    """A further input's value for the check: the middle of its range."""
    if not isinstance(model, NetworkModel) or not model.structure.extras:
        return []
    return [float(v) for v in model.input_range[-len(model.structure.extras) :].mean(axis=1)]


def monotone_share(model: Model) -> float:
    """Share of lines of growing field, one for each side and pair of speeds, along which effort never turns."""
    origin, plus, minus = sides(model)
    low, high = model.trained_on.slip
    grid = np.linspace(low, high, _SPEEDS)
    slips = [w.ravel() for w in np.meshgrid(*([grid] * (2 if model.structure.device == "coaxial" else 1)))]
    lines = slips[0].size
    good = total = 0
    scale = float(np.max(np.abs(model.trained_on.effort)))
    for end in (plus, minus):
        if end == origin:
            continue
        field = np.repeat(np.linspace(origin, end, _FIELDS), lines)
        tiled = [np.tile(w, _FIELDS) for w in slips]
        extras = [np.full(field.size, v) for v in middles(model)]
        effort = steady(model, apart(model, field), tiled, extras).reshape(_FIELDS, lines)
        change = np.diff(effort, axis=0)
        one_way = np.all(change >= -_SLACK * scale, axis=0) | np.all(change <= _SLACK * scale, axis=0)
        good += int(np.count_nonzero(one_way))
        total += lines
    return good / total if total else 1.0

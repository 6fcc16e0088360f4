"""An inverse is unique if the effort follows the field one way: a grid checks it on each side of zero field."""

from __future__ import annotations

import numpy as np

from erclutch.models.model import Model, margins
from erclutch.signals.array import Array

_FIELDS, _SPEEDS = 33, 11
_SLACK = 1e-9  # of the effort's scale: rounding is no turning point


def sides(model: Model) -> tuple[float, float, float]:
    """Origin, largest and smallest signed field of the inverse."""
    low, high = model.trained_on.field
    if low == high:  # a search needs some width, and finds the same effort all over it
        high = margins((low, high))[1] if high else 1.0
    largest = max(abs(low), abs(high))
    if model.structure.device == "coaxial":
        return 0.0, largest, -largest
    if not model.signed:
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
    return [0.5 * (low + high) for low, high in model.extras.values()]


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
        effort = model.steady(apart(model, field), tiled, extras).reshape(_FIELDS, lines)
        change = np.diff(effort, axis=0)
        one_way = np.all(change >= -_SLACK * scale, axis=0) | np.all(change <= _SLACK * scale, axis=0)
        good += int(np.count_nonzero(one_way))
        total += lines
    return good / total if total else 1.0

"""An inverse is unique if the effort follows the field one way: a grid checks it on each side of zero field."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from erclutch.models.model import Model, margins
from erclutch.signals.array import Array, Mask, largest_size
from erclutch.signals.device import WAYS_OF

#: Points of the grid along a side of the field, and along the slip of an element.
_FIELDS = 33
_SLIPS = 11  # levels between the ends of the training range
_RELEASED = 0.2  # share of the effort that a field takes away which releases a device
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
    if model.structure.device != "coaxial":
        return [signed]
    first = np.maximum(signed, 0.0)
    second = np.maximum(-signed, 0.0)
    return [first, second]


def middles(model: Model) -> list[float]:
    """A further input's value for the check: the middle of its range."""
    return [0.5 * (low + high) for low, high in model.extras.values()]


@dataclass(frozen=True)
class _Lines:
    """Effort along lines of growing field on one side of zero field, each line at one pair of slips.

    Attributes:
        field: signed, from the origin outwards, shape (n,).
        slips: of each element, shape (lines,) each.
        effort: settled, shape (n, lines).
    """

    field: Array
    slips: list[Array]
    effort: Array


def _lines(model: Model) -> Iterator[_Lines]:
    origin, plus, minus = sides(model)
    low, high = model.trained_on.slip
    grid = np.linspace(low, high, _SLIPS)
    elements = len(WAYS_OF[model.structure.device])
    slips = [slip.ravel() for slip in np.meshgrid(*[grid] * elements)]  # of each element, (lines,)
    lines = slips[0].size
    for end in (plus, minus):
        if end == origin:  # nothing of the field on this side
            continue
        field = np.linspace(origin, end, _FIELDS)
        # All points of all lines at once: the lines of one field after another.
        field_of_points = np.repeat(field, lines)
        slips_of_points = [np.tile(slip, _FIELDS) for slip in slips]
        extras = [np.full(field_of_points.size, middle) for middle in middles(model)]
        effort = model.steady(apart(model, field_of_points), slips_of_points, extras)
        yield _Lines(field, slips, effort.reshape(_FIELDS, lines))


def monotone_share(model: Model) -> float:
    """Share of lines of growing field, one for each side and pair of speeds, along which effort never turns."""
    slack = _SLACK * largest_size(model.trained_on.effort)
    monotone = 0
    total = 0
    for lines in _lines(model):
        change = np.diff(lines.effort, axis=0)
        rises: Mask = np.all(change >= -slack, axis=0)
        falls: Mask = np.all(change <= slack, axis=0)
        monotone += int(np.count_nonzero(rises | falls))
        total += rises.size
    return monotone / total if total else 1.0


def releases(model: Model) -> bool:
    """Whether the largest field leaves clearly less of a single device's effort than no field, over all speeds.

    The elements of a pair drive against each other, so a field may lower the size of their effort.
    """
    if model.structure.device != "single":
        return False
    at_no_field = 0.0
    at_largest = 0.0
    for lines in _lines(model):
        size = np.abs(lines.effort)
        at_no_field += float(size[0].sum())
        at_largest += float(size[-1].sum())
    return at_largest < (1.0 - _RELEASED) * at_no_field


@dataclass(frozen=True)
class Turn:
    """Where a growing field moves the effort back the most.

    Attributes:
        back: by how much, as an effort of at least 0; 0 where the effort is monotone along all lines.
        fields: magnitudes of the field where it begins and where it ends to move back.
        slips: of each element.
        farthest: the effort of the largest magnitude along all lines.
    """

    back: float
    fields: tuple[float, float]
    slips: tuple[float, ...]
    farthest: float


def worst_turn(model: Model) -> Turn:
    """The largest way back of the settled effort along the lines that `monotone_share` counts."""
    worst = Turn(back=0.0, fields=(0.0, 0.0), slips=(), farthest=0.0)
    farthest = 0.0
    for lines in _lines(model):
        # The effort along each line, turned so that it rises on the whole, and the most that it had reached.
        rises = lines.effort[-1] >= lines.effort[0]
        way = np.where(rises, 1.0, -1.0)
        ahead = lines.effort * way
        reached = np.maximum.accumulate(ahead, axis=0)
        lost = reached - ahead
        most_lost = int(np.argmax(lost))
        end, line = np.unravel_index(most_lost, lost.shape)
        begin = int(np.argmax(ahead[: end + 1, line]))
        back = float(lost[end, line])
        if back > worst.back:
            magnitudes = np.abs(lines.field)
            worst = Turn(
                back,
                fields=(float(magnitudes[begin]), float(magnitudes[end])),
                slips=tuple(float(slip[line]) for slip in lines.slips),
                farthest=0.0,
            )
        of_largest = int(np.argmax(np.abs(lines.effort)))
        farthest = max(farthest, float(lines.effort.flat[of_largest]), key=abs)
    return replace(worst, farthest=farthest)

"""This module says what training data covered."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

from erclutch.logs.dataset import Dataset
from erclutch.logs.disk_rows import TrainingRows
from erclutch.models.law_model import Range
from erclutch.signals.array import Array


def range_of(data: TrainingRows) -> Range:
    """Smallest and largest field, slip and effort of all rows."""
    return reduce(_joined, map(_range_of_block, data.blocks))


def _range_of_block(block: Dataset) -> Range:
    def span(arrays: Sequence[Array]) -> tuple[float, float]:
        return min(float(a.min()) for a in arrays), max(float(a.max()) for a in arrays)

    return Range(span([e.field for e in block.elements]), span([e.slip for e in block.elements]), span([block.effort]))


def _joined(one: Range, other: Range) -> Range:
    def joined(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
        return min(a[0], b[0]), max(a[1], b[1])

    return Range(joined(one.field, other.field), joined(one.slip, other.slip), joined(one.effort, other.effort))

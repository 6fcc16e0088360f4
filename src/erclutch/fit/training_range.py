"""This module says what training data covered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from erclutch.logs.dataset import Dataset
from erclutch.logs.disk_rows import TrainingRows
from erclutch.models.law_model import Range
from erclutch.models.model import CELLS
from erclutch.signals.array import Array


def range_of(data: TrainingRows) -> Range:
    """Smallest and largest field, slip and effort of all rows, and the cells of field and slip near them."""
    whole = reduce(_joined, map(_range_of_block, data.blocks))
    seen = reduce(np.logical_or, (_cells_of_block(block, whole) for block in data.blocks))
    near = sliding_window_view(np.pad(seen, ((0, 0), (1, 1), (1, 1))), (3, 3), axis=(1, 2)).any(axis=(3, 4))
    masks = near.astype(np.int64) @ (1 << np.arange(CELLS))
    return replace(whole, near=tuple(tuple(element) for element in masks.tolist()))


def _cells_of_block(block: Dataset, whole: Range) -> NDArray[np.bool_]:
    """Cells that hold a row, shape (elements, field, slip)."""
    seen = np.zeros((len(block.elements), CELLS, CELLS), np.bool_)
    for i, element in enumerate(block.elements):
        row, column = (cell.astype(np.intp) for cell in whole.cell(element.field, element.slip))
        seen[i, row, column] = True
    return seen


def _range_of_block(block: Dataset) -> Range:
    def span(arrays: Sequence[Array]) -> tuple[float, float]:
        return min(float(a.min()) for a in arrays), max(float(a.max()) for a in arrays)

    return Range(span([e.field for e in block.elements]), span([e.slip for e in block.elements]), span([block.effort]))


def _joined(one: Range, other: Range) -> Range:
    def joined(a: tuple[float, float], b: tuple[float, float]) -> tuple[float, float]:
        return min(a[0], b[0]), max(a[1], b[1])

    return Range(joined(one.field, other.field), joined(one.slip, other.slip), joined(one.effort, other.effort))

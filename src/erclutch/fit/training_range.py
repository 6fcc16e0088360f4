"""This module says what training data covered."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial, reduce

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
    whole = _range_of_ends(data.ends)
    seen = reduce(np.logical_or, data.blocks.fold(partial(_cells_of, whole)))
    near = sliding_window_view(np.pad(seen, ((0, 0), (1, 1), (1, 1))), (3, 3), axis=(1, 2)).any(axis=(3, 4))
    masks = near.astype(np.int64) @ (1 << np.arange(CELLS))
    return replace(whole, near=tuple(tuple(element) for element in masks.tolist()))


def _cells_of(whole: Range, blocks: Iterable[Dataset]) -> NDArray[np.bool_]:
    """Cells that hold a row, shape (elements, field, slip)."""
    return reduce(np.logical_or, (_cells_of_block(whole, block) for block in blocks))


def _cells_of_block(whole: Range, block: Dataset) -> NDArray[np.bool_]:
    seen = np.zeros((len(block.elements), CELLS, CELLS), np.bool_)
    for i, element in enumerate(block.elements):
        row, column = (cell.astype(np.intp) for cell in whole.cell(element.field, element.slip))
        seen[i, row, column] = True
    return seen


def _range_of_ends(ends: Dataset) -> Range:
    def span(arrays: Sequence[Array]) -> tuple[float, float]:
        return min(float(a.min()) for a in arrays), max(float(a.max()) for a in arrays)

    return Range(span([e.field for e in ends.elements]), span([e.slip for e in ends.elements]), span([ends.effort]))

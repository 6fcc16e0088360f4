"""This module says what training data covered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from erclutch.logs.dataset import Dataset
from erclutch.models.model import CELLS, Range
from erclutch.signals.array import Array
from erclutch.signals.device import Element


def range_of(data: Dataset) -> Range:
    """Smallest and largest field, slip and effort of all rows, and the cells of field and slip near them."""
    whole = Range(_span([e.field for e in data.elements]), _span([e.slip for e in data.elements]), _span([data.effort]))
    return replace(whole, near=near_cells(whole, data.elements))


def near_cells(whole: Range, elements: Sequence[Element]) -> tuple[tuple[int, ...], ...]:
    """The cells of a range that hold a row, and those beside, of each element; see `Range.near`."""
    seen = np.zeros((len(elements), CELLS, CELLS), np.bool_)
    for i, element in enumerate(elements):
        row, column = (cell.astype(np.intp) for cell in whole.cell(element.field, element.slip))
        seen[i, row, column] = True
    near = sliding_window_view(np.pad(seen, ((0, 0), (1, 1), (1, 1))), (3, 3), axis=(1, 2)).any(axis=(3, 4))
    masks = near.astype(np.int64) @ (1 << np.arange(CELLS))
    return tuple(tuple(element) for element in masks.tolist())


def _span(signals: list[Array]) -> tuple[float, float]:
    return min(float(signal.min()) for signal in signals), max(float(signal.max()) for signal in signals)

"""This module says what training data covered."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from erclutch.logs.dataset import Dataset
from erclutch.models.model import CELLS, Range
from erclutch.signals.array import Array, Mask
from erclutch.signals.device import Element


def range_of(data: Dataset) -> Range:
    """Smallest and largest field, slip and effort of all rows, and the cells of field and slip near them."""
    whole = Range(
        field=span_of([element.field for element in data.elements]),
        slip=span_of([element.slip for element in data.elements]),
        effort=span_of([data.effort]),
    )
    return replace(whole, near=near_cells(whole, data.elements, swept=data.in_no_time))


def share_beyond(data: Dataset, part: Mask) -> float:
    """Share of the rows of a part that no other row comes near by field and slip; 0 where there are no others."""
    others = data.take(~part)
    if not others.rows:
        return 0.0
    outside = range_of(others).outside(data.take(part))
    return float(outside.mean()) if outside.size else 0.0


def near_cells(
    whole: Range, elements: Sequence[Element], *, swept: bool = False
) -> tuple[tuple[int, ...], ...]:
    """The cells of a range that hold a row, and those beside, of each element; see `Range.near`.

    Args:
        whole: the range.
        elements: field and slip of all rows.
        swept: whether the rows are points of a table, which was taken slip after slip at each field: then the cells
            between two points of one field are near as well.
    """
    seen = np.zeros((len(elements), CELLS, CELLS), np.bool_)
    for i, element in enumerate(elements):
        row, column = (cell.astype(np.intp) for cell in whole.cell(element.field, element.slip))
        seen[i, row, column] = True
    if swept:
        from_the_left = np.logical_or.accumulate(seen, axis=2)
        from_the_right = np.logical_or.accumulate(seen[:, :, ::-1], axis=2)[:, :, ::-1]
        seen = from_the_left & from_the_right
    # A cell is near where one of the nine around it, itself among them, holds a row.
    with_edge = np.pad(seen, ((0, 0), (1, 1), (1, 1)))
    around = sliding_window_view(with_edge, (3, 3), axis=(1, 2))
    near = around.any(axis=(3, 4))
    bits = 1 << np.arange(CELLS)
    masks = near.astype(np.int64) @ bits
    return tuple(tuple(element) for element in masks.tolist())


def span_of(signals: Sequence[Array]) -> tuple[float, float]:
    """Smallest and largest value of some signals, such as the fields of all elements."""
    low = min(float(signal.min()) for signal in signals)
    high = max(float(signal.max()) for signal in signals)
    return low, high

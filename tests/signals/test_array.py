"""What all rooms ask of an array: the largest of each window of rows, to the bit."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

from erclutch.signals.array import largest_of_windows


@pytest.mark.parametrize("rows", [1, 2, 3, 4, 5, 7, 8, 9, 63, 100])
def test_each_window_gives_its_largest_row(rows: int) -> None:
    values = np.random.default_rng(rows).normal(size=100)
    expected = sliding_window_view(values, rows).max(axis=1)
    np.testing.assert_array_equal(largest_of_windows(values, rows), expected)
    np.testing.assert_array_equal(
        -largest_of_windows(-values, rows), sliding_window_view(values, rows).min(axis=1)
    )

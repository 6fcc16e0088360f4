"""A share is written in per cent, and one beyond all measure takes no line of digits."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.signals.percent import percent


@pytest.mark.parametrize(
    ("share", "text"),
    [(0.0123, "1.2 %"), (-0.5, "-50.0 %"), (1000.0, "100000.0 %"), (1e150, "above 100,000 %")],
)
def test_a_share_beyond_all_measure_is_written_in_words(share: float, text: str) -> None:
    assert percent(share, 1) == text


def test_a_share_without_end_is_written_in_words() -> None:
    assert percent(np.inf) == "above 100,000 %"

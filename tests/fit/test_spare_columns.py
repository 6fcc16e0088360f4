"""Columns that would take error off the best law are told, the much-telling by themselves and the others together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.fit.checks.spare_columns import spare_columns
from erclutch.logs.dataset import Dataset
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

ROWS = 10


def log(**units: str) -> Dataset:
    """Rows of a device; their columns do not count here."""
    clock = Clock(0.01 * np.arange(float(ROWS)), (Span(0, ROWS, 0.01),))
    element = Element(np.zeros(ROWS), np.ones(ROWS))
    data = Dataset("single", (element,), np.ones(ROWS), clock, Units("N*m", "A", "rad/s"))
    return replace(data, extra_units=units)


def told(gains: dict[str, float], **units: str) -> list[str]:
    return [str(finding) for finding in spare_columns(log(**units), gains)]


def test_nothing_is_said_where_no_column_helps() -> None:
    assert told({}) == []


def test_a_column_that_tells_much_has_a_note_of_its_own_and_the_others_share_one() -> None:
    of_oil, of_others = told({"oil": 0.42, "ESC": 0.06, "target": 0.012}, oil="°C")
    assert "the column 'oil', which no model has as an input, would take 42 % off" in of_oil
    assert '--temperature "oil [°C]"' in of_oil
    assert "each take a little off the error of the best law: 'ESC' 6 %, 'target' 1 %" in of_others
    assert 'fit with --input "ESC", say' in of_others


@pytest.mark.parametrize("gain", [0.02, 0.3])
def test_a_single_column_is_told_with_its_figure(gain: float) -> None:
    (note,) = told({"pressure": gain})
    assert (
        f"the column 'pressure', which no model has as an input, would take {gain:.0%}"[:-1] in note
    )

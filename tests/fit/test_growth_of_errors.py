"""A model of many numbers follows its rows: its band is as wide as its errors on rows that a fit has not seen."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.fit.bands.prediction_bands import calibrated
from erclutch.fit.choice import validation
from erclutch.fit.choice.validation import growth_of_errors
from erclutch.fit.comparison import Settings, compare
from erclutch.logs.dataset import Dataset
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units


def log(rows: int, effort: Array, slip: Array, period: float = 0.01) -> Dataset:
    """A log without a field."""
    clock = Clock(period * np.arange(float(rows)), (Span(0, rows, period),))
    units = Units("N*m", "A", "rad/s")
    return Dataset("single", (Element(np.zeros(rows), slip),), effort, clock, units)


def test_the_part_in_the_middle_counts() -> None:
    seen = [np.full(5, 0.1)] * 3
    unseen = [np.full(5, 0.1), np.full(5, 0.3), np.full(5, 90.0)]
    assert growth_of_errors(unseen, seen) == pytest.approx(3.0)


def test_parts_without_an_error_or_without_a_refit_do_not_count() -> None:
    seen = [np.zeros(5), np.full(5, 0.1), np.full(5, 0.1)]
    assert growth_of_errors([np.ones(5), np.full(5, 0.2)], seen) == pytest.approx(2.0)
    assert growth_of_errors([], seen) == 1.0
    # Its square is zero: it ended in a division by zero.
    assert growth_of_errors([np.ones(5)], [np.full(5, 1e-200)]) == 1.0


@pytest.mark.slow
def test_a_band_is_wider_by_the_growth() -> None:
    rng = np.random.default_rng(1)
    noise = 0.1 * rng.standard_normal(4000)
    data = log(4000, noise, np.sin(0.03 * np.arange(4000.0)))
    every = np.ones(4000, np.bool_)
    plain, tripled = (calibrated(data, every, [noise], [4], None, [by])[0] for by in (1.0, 3.0))
    assert plain is not None
    assert tripled is not None
    # Akaike's factor for four parameters is one in a thousand.
    assert np.array(tripled[0].ahead) == pytest.approx(3.0 * np.array(plain[0].ahead), rel=0.01)


@pytest.mark.slow
def test_the_bands_of_a_comparison_are_as_wide_as_its_refits_ask_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rng = np.random.default_rng(7)
    rows = 400
    time = np.arange(float(rows))
    slip = np.sin(0.11 * time) + 0.6 * np.sin(0.043 * time + 1.0)
    data = log(rows, np.tanh(slip / 0.1) + 0.05 * rng.standard_normal(rows), slip)
    settings = Settings(models=("bingham", "casson"), lag="none")
    widths: dict[float, float] = {}
    for growth in (2.0, 8.0):
        monkeypatch.setattr(validation, "growth_of_errors", lambda unseen, seen, by=growth: by)
        band = compare(data, settings).entry("bingham/constant").band
        assert band is not None
        widths[growth] = band.held.width
    assert widths[8.0] == pytest.approx(4.0 * widths[2.0], rel=1e-6)

"""A band of several logs holds what is next to a standstill, where a motion unlike the logs may stay (SYNTHETIC)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from erclutch.fit.bands.prediction_bands import calibrated
from erclutch.fit.bands.standstill_widths import wide_next_to_standstill
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import Dataset, build_dataset, joined
from erclutch.models.band import Band
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element

PERIOD, ROWS = 5e-3, 1000
UNITS = {"field": "A", "slip": "rad/s", "effort": "N*m"}
#: Fast next to zero: sines are there for few of the rows whose slip is among the smallest quarter.
TOP = 2.0


def sines() -> Dataset:
    """Four logs at one field."""
    logs: list[Dataset] = []
    for number, hertz in enumerate((0.7, 1.1, 1.7, 2.6)):
        slip = TOP * np.sin(2.0 * np.pi * hertz * PERIOD * np.arange(ROWS))
        signals = {"field": np.ones(ROWS), "slip": slip, "effort": np.tanh(slip / 0.1)}
        data = build_dataset(recording_from_arrays(signals, UNITS, rate=1.0 / PERIOD))
        logs.append(replace(data, sources=(f"log {number}",)))
    return joined(logs)


def band_of(data: Dataset, errors: Array) -> Band:
    made = calibrated(data, np.ones(data.rows, np.bool_), [errors], [3], [errors])[0]
    assert made is not None
    return made[0]


def half_width_at(band: Band, slip: float) -> float:
    clock = Clock(np.zeros(1), (Span(0, 1, PERIOD),))
    element = Element(np.ones(1), np.array([slip]))
    low, high = band.around(np.zeros(1), (element,), clock)
    return float(0.5 * (high - low)[0])


def test_the_smallest_slips_have_the_errors_next_to_a_standstill() -> None:
    """A few rows next to zero are too few to widen their whole class, and a slow log has more of them."""
    data = sines()
    slip = data.elements[0].slip
    band = band_of(data, 0.1 * np.ones(data.rows))
    errors = np.where(np.abs(slip) < 0.02 * TOP, 0.5, 0.1)
    wide = wide_next_to_standstill(band, data, errors)
    for direction in (-1.0, 1.0):
        assert half_width_at(wide, direction * 0.3 * TOP) == 0.5
        for slip_of_row in (0.6 * TOP, 0.9 * TOP):
            row = direction * slip_of_row
            assert half_width_at(wide, row) == half_width_at(band, row)


def test_errors_that_are_alike_at_all_slips_widen_no_band() -> None:
    data = sines()
    errors = 0.1 * np.ones(data.rows)
    band = band_of(data, errors)
    assert wide_next_to_standstill(band, data, errors) == band

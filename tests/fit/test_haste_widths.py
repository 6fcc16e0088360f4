"""A band grows beyond the quickest motion of the logs as errors grew among them (SYNTHETIC, truth known)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from erclutch.fit.bands.haste_widths import with_haste
from erclutch.fit.bands.prediction_bands import calibrated, coverage
from erclutch.logs.dataset import Dataset, joined
from erclutch.models.band import Band
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units

PERIOD, ROWS = 5e-3, 1200


def device(
    hertz: Sequence[float], inertia: float = 0.0, noise: float = 0.0
) -> tuple[Dataset, Array]:
    """Two logs for each motion, with noise of the slip, and the errors of a law that knows nothing of the inertia."""
    logs: list[Dataset] = []
    for k, each in enumerate(np.repeat(hertz, 2).tolist()):
        rng = np.random.default_rng(k)
        time: Array = PERIOD * np.arange(float(ROWS))
        slip = 10.0 * np.sin(2.0 * np.pi * each * time)
        rate = 20.0 * np.pi * each * np.cos(2.0 * np.pi * each * time)
        error = inertia * rate + 0.1 * rng.standard_normal(ROWS)
        clock = Clock(time, (Span(0, ROWS, PERIOD),))
        element = Element(np.full(ROWS, 1.0), slip + noise * rng.standard_normal(ROWS))
        log = Dataset("single", (element,), 3.0 + error, clock, Units("N", "A", "mm/s"))
        logs.append(replace(log, sources=(f"{each:g} Hz, {k}",)))
    data = joined(logs)
    return data, data.effort - 3.0


def calibrated_on(data: Dataset, error: Array) -> Band:
    made = calibrated(data, np.ones(data.rows, np.bool_), [error], [4], [error])[0]
    assert made is not None
    return made[0]


def inside(band: Band, data: Dataset) -> float:
    ends = band.around(np.full(data.rows, 3.0), data.elements, data.clock)
    return coverage(data, ends, np.ones(data.rows, np.bool_)).share


def test_a_motion_quicker_than_all_logs_lies_inside_where_errors_grow_with_the_rate() -> None:
    data, error = device((0.25, 0.5, 1.0, 2.0), inertia=0.05)
    band = calibrated_on(data, error)
    grown = with_haste(band, data, error)
    quick, _ = device((4.0,), inertia=0.05)
    assert inside(band, quick) < 0.6
    assert inside(grown, quick) > 0.8  # haste needs half a second to be known
    assert inside(grown, data) == inside(band, data)


@pytest.mark.slow
def test_where_errors_do_not_grow_the_band_hardly_does() -> None:
    data, error = device((0.25, 0.5, 1.0, 2.0))
    grown = with_haste(calibrated_on(data, error), data, error)
    assert grown.haste is not None
    assert grown.haste.growth < 0.1
    assert 0.92 < inside(grown, device((4.0,))[0]) < 0.99


def test_logs_of_two_motions_say_how_errors_grow_and_those_of_one_do_not() -> None:
    data, error = device((1.0, 2.0), inertia=0.05)
    band = calibrated_on(data, error)
    quick, _ = device((4.0,), inertia=0.05)
    assert inside(band, quick) < 0.1
    assert (
        inside(with_haste(band, data, error), quick) > 0.5
    )  # more than two motions hold more of it
    data, error = device((1.0,), inertia=0.05)
    band = calibrated_on(data, error)
    assert with_haste(band, data, error) == band


def test_two_motions_whose_errors_are_alike_are_no_sign_that_errors_do_not_grow() -> None:
    """Each was left out of a fit to the other, so both are as far from what was fitted."""
    data, error = device((1.0, 2.0))
    grown = with_haste(calibrated_on(data, error), data, error)
    assert grown.haste is not None
    assert grown.haste.growth == 1.0


def test_the_band_grows_in_proportion_at_least_where_motions_differ_in_their_errors() -> None:
    """Errors that fall from slow to quick motions, as of a strain ahead of yield, hide one that grows with the rate."""
    data, error = device((0.25, 0.5, 1.0, 2.0))
    slower = np.repeat((2.0, 1.6, 1.3, 1.0), 2 * ROWS) * error
    grown = with_haste(calibrated_on(data, slower), data, slower)
    assert grown.haste is not None
    assert grown.haste.growth == 1.0


def test_noise_of_the_slip_hides_no_motion_quicker_than_all_logs() -> None:
    """Noise of a tenth of the slip changes more from row to row than these motions do."""
    data, error = device((0.25, 0.5, 1.0), inertia=0.05, noise=0.7)
    band = calibrated_on(data, error)
    grown = with_haste(band, data, error)
    assert grown.haste is not None
    assert grown.haste.smooth_s == grown.haste.lag_s
    quick, _ = device((4.0,), inertia=0.05, noise=0.7)
    assert inside(band, quick) < 0.2
    assert inside(grown, quick) > 0.8


def test_a_slip_without_noise_is_not_smoothed() -> None:
    data, error = device((0.25, 0.5, 1.0), inertia=0.05)
    grown = with_haste(calibrated_on(data, error), data, error)
    assert grown.haste is not None
    assert grown.haste.smooth_s == 0.0

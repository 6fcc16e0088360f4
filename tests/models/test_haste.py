"""Haste tells quick motions from slow ones, and grows a band beyond the quickest motion that was logged."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.models.haste import Haste
from erclutch.models.load import load_model
from erclutch.models.model_file import digest_of
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element
from tests.models.test_band import BAND as SMALL
from tests.models.test_band import refused_as_unfit, some_model
from tests.support.wide_band import BAND, HASTY

PERIOD = 1e-3
HASTE = Haste(0.02, 0.2, 2.0, 1.2, 0.5)


def sine(hertz: float, seconds: float = 6.0) -> tuple[Array, Clock]:
    time: Array = PERIOD * np.arange(float(round(seconds / PERIOD)))
    return 10.0 * np.sin(2.0 * np.pi * hertz * time), Clock(time, (Span(0, time.size, PERIOD),))


@pytest.mark.parametrize("hertz", [0.5, 1.0, 3.0])
def test_haste_is_the_mean_distance_of_a_sine_from_its_lag(hertz: float) -> None:
    slip, clock = sine(hertz)
    turn = 2.0 * np.pi * hertz * HASTE.lag_s
    distance = 10.0 * turn / np.hypot(1.0, turn)
    found = HASTE.of_rows(slip, clock)
    assert found[0] == 0.0
    assert np.mean(found[3000:]) == pytest.approx(2.0 / np.pi * distance, rel=0.03)


def test_haste_begins_at_zero_behind_a_gap() -> None:
    slip, clock = sine(3.0)
    apart = replace(clock, spans=(Span(0, 3000, PERIOD), Span(3000, slip.size, PERIOD)))
    found = HASTE.of_rows(slip, apart)
    assert found[3000] == 0.0
    assert np.array_equal(found[:3000], HASTE.of_rows(slip, clock)[:3000])


def test_a_band_grows_only_beyond_what_was_known() -> None:
    haste = np.array([0.0, 1.0, 2.0, 3.0, 6.0])
    assert np.allclose(HASTE.factor(haste), [1.0, 1.0, 1.0, 1.5, 2.4])


def test_a_quick_motion_has_a_wider_band_than_a_slow_one_and_is_told() -> None:
    haste = HASTY.haste
    assert haste is not None
    for hertz in (0.2, 20.0):
        slip, clock = sine(hertz)
        elements = [Element(np.full(slip.size, 200.0), slip)]
        plain, grown = (band.around(np.zeros(slip.size), elements, clock) for band in (BAND, HASTY))
        wider = (grown[1] - grown[0]) / (plain[1] - plain[0])
        assert np.allclose(wider, haste.factors(slip, clock))
        assert (
            haste.beyond(slip, clock)[3000:].all() == (wider[3000:] > 1.0).all() == (hertz == 20.0)
        )


def test_noise_is_no_haste_where_the_slip_is_smoothed() -> None:
    slip, clock = sine(0.5)
    noisy = slip + 0.5 * np.random.default_rng(0).standard_normal(slip.size)
    smoothed = replace(HASTE, smooth_s=0.02)
    plain, of_noise = (np.mean(smoothed.of_rows(each, clock)[3000:]) for each in (slip, noisy))
    assert of_noise == pytest.approx(plain, rel=0.1)
    assert np.mean(HASTE.of_rows(noisy, clock)[3000:]) > 1.2 * plain


def test_a_model_of_an_earlier_version_smooths_nothing(tmp_path: Path) -> None:
    body = replace(some_model(), band=replace(SMALL, haste=replace(HASTE, smooth_s=0.02))).to_dict()
    del body["band"]["haste"]["smooth_s"]
    body["digest"] = digest_of({key: value for key, value in body.items() if key != "digest"})
    path = tmp_path / "m.json"
    path.write_text(json.dumps(body), encoding="utf-8")
    band = load_model(path).band
    assert band is not None
    assert band.haste == HASTE


@pytest.mark.parametrize("smooth_s", [0.0, 0.02])
def test_a_model_keeps_the_haste_of_its_band(smooth_s: float, tmp_path: Path) -> None:
    model = replace(some_model(), band=replace(SMALL, haste=replace(HASTE, smooth_s=smooth_s)))
    path = tmp_path / "m.json"
    path.write_text(json.dumps(model.to_dict()), encoding="utf-8")
    assert load_model(path).band == model.band


@pytest.mark.parametrize(
    ("entry", "value"),
    [
        ("lag_s", 0.0),
        ("mean_s", -1.0),
        ("known", 0.0),
        ("quickest", 0.9),
        ("growth", -0.1),
        ("growth", "much"),
        ("smooth_s", -0.1),
    ],
)
def test_haste_that_makes_no_sense_is_refused_in_one_line(
    entry: str, value: Any, tmp_path: Path
) -> None:
    body = replace(some_model(), band=replace(SMALL, haste=HASTE)).to_dict()
    body["band"]["haste"][entry] = value
    refused_as_unfit(body, tmp_path / "m.json")

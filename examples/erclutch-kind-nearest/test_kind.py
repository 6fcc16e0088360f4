"""The kind stands in a comparison beside a law: fitted, ranked, kept, read back and recalibrated as ours are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from erclutch import Recording, Settings, build_dataset, compare, read_run, recalibrate, write_run
from erclutch.errors import SettingError
from erclutch.logs import recording_from_arrays


def log(gain: float = 1.0) -> Recording:
    """A SYNTHETIC brake whose field switches."""
    rng = np.random.default_rng(0)
    field = np.repeat(rng.uniform(0.0, 1.0, 40), 50)
    slip = 3.0 * np.sin(0.011 * np.arange(2000))
    effort = gain * (field * np.tanh(5.0 * slip) + 0.1 * slip) + 0.01 * rng.standard_normal(2000)
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    return recording_from_arrays(
        {"field": field, "slip": slip, "effort": effort}, units, rate=1000.0
    )


def test_it_is_fitted_ranked_kept_and_read_back(tmp_path: Path) -> None:
    recording = log()
    compared = compare(build_dataset(recording), Settings(("bingham", "nearest-3"), lag="none"))
    assert {entry.name for entry in compared.entries} == {"bingham", "nearest-3"}
    nearest = compared.entry("nearest-3")
    assert nearest.test.share.value < 0.3
    run = read_run(write_run(tmp_path / "run", compared, [recording]))
    assert_array_equal(run.model("nearest-3").predict(compared.data), nearest.predicted)


def test_its_gain_is_recalibrated() -> None:
    compared = compare(build_dataset(log()), Settings(("bingham", "nearest-3"), lag="none"))
    model = compared.entry("nearest-3").outcome.model
    found = recalibrate(model, build_dataset(log(gain=1.3)))
    assert found.numbers["gain"][0] == pytest.approx(1.3, abs=0.03)


def test_no_neighbours_are_refused() -> None:
    with pytest.raises(SettingError, match="no model 'nearest-0'"):
        compare(build_dataset(log()), Settings(("nearest-0",), lag="none"))

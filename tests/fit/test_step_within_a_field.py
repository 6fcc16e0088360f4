"""A law that is on or off does not win by a threshold that lies within the width of its step at a field of the log."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.fit.comparison import Settings, compare
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import build_dataset


@pytest.mark.slow
def test_a_threshold_on_a_middle_field_stands_in_for_a_level() -> None:
    """It tied with Bingham's law on MADE-UP rows at three fields, and erred by 10 times the noise at a fourth."""
    rng = np.random.default_rng(2)
    time = np.arange(300) / 50.0
    current = np.repeat([0.0, 0.5, 1.0, 0.5, 0.0, 1.0, 0.5, 0.0, 1.0, 0.5], 30)
    slip = 0.06 * np.sin(2 * np.pi * 0.7 * time) + 0.04 * np.sin(2 * np.pi * 1.9 * time)
    force = (40.0 + 200.0 * current**1.3) * np.tanh(slip / 0.01) + 600.0 * slip
    log = recording_from_arrays(
        {"field": current, "slip": slip, "effort": force + 6.0 * rng.standard_normal(time.size)},
        {"field": "A", "slip": "m/s", "effort": "N"},
        time=time,
    )
    models = ("on-off", "bingham")
    result = compare(build_dataset(log), Settings(models=models, lag="none"))
    step = result.entry("on-off")
    assert step.test.rmse.value < 1.3 * result.entry("bingham").test.rmse.value
    assert not step.sound
    assert result.recommended == "bingham"

"""A motion that is quicker than any training log is told where a model is scored, and its band is wider."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.logs.dataset import Dataset
from erclutch.models.haste import Haste
from erclutch.runs.new_rows import quicker_than_known, score_model
from erclutch.signals.array import Array
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from tests.models.test_band import BAND, some_model

HASTE = Haste(lag_s=0.01, mean_s=0.1, known=0.05, quickest=1.2, growth=0.5)


@pytest.mark.parametrize(("hertz", "told"), [(0.5, False), (20.0, True)])
def test_a_score_tells_a_motion_quicker_than_any_training_log(hertz: float, told: bool) -> None:
    time: Array = 1e-3 * np.arange(4000.0)
    element = Element(np.full(time.size, 50.0), 0.9 * np.sin(2.0 * np.pi * hertz * time))
    clock = Clock(time, (Span(0, time.size, 1e-3),))
    data = Dataset("single", (element,), np.zeros(time.size), clock, Units("N*m", "V", "rad/s"))
    model = replace(some_model(), band=replace(BAND, haste=HASTE))
    assert quicker_than_known(model, data)[500:].all() == told
    assert ("more quickly than in any training log" in score_model(model, data, "m").where) == told
    assert not quicker_than_known(replace(model, band=BAND), data).any()

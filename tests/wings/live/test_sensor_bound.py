"""What a healthy loop shows that a fault of a sensor shows, too: `studies/sensor_bound.py`, a small part of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.layout import FRAME
from erclutch.wings.live.session import LiveModel
from erclutch.wings.rig.twin.parameters import default_rig
from tests.support import sensor_bound, sensor_faults
from tests.support.slow_params import slow_but

pytestmark = pytest.mark.slow

RIG = default_rig()
BEGINS = 1548  # the row of a fault


@pytest.fixture(scope="module")
def pair() -> LiveModel:
    """Bingham's law, fitted to the TWIN's pair."""
    return sensor_faults.model_of(RIG, "bingham", "coaxial")


@pytest.fixture(scope="module")
def healthy(pair: LiveModel) -> Any:
    """Frames of the loop that the faults disturb."""
    settings = sensor_faults.settings_of("impedance", pair, RIG)
    return sensor_faults.frames_of(settings, pair.library, RIG, 0)


def likeness(pair: LiveModel, healthy: Any, sensor: str, kind: str) -> sensor_bound.Likeness:
    """Of a fault to one healthy session of the same loop."""
    settings = sensor_faults.settings_of("impedance", pair, RIG)
    faulty = sensor_faults.frames_of(settings, pair.library, RIG, 0, (sensor, kind, BEGINS))
    rows = sensor_bound.rows_in_time(healthy, faulty, BEGINS, too_high=False)
    other = AcceleratedRun(settings, pair.library, RIG, seed=1002).frames(sensor_faults.ROWS)[0]
    looks = sensor_bound.looks_of(faulty, settings)[BEGINS : BEGINS + rows]
    return sensor_bound.likeness_of(looks, [("healthy", sensor_bound.looks_of(other, settings))])


@pytest.mark.parametrize("kind", slow_but(("late",), ("stuck", "late")))
def test_an_encoder_that_stops_at_rest_looks_as_a_healthy_session_does_elsewhere(
    kind: str, pair: LiveModel, healthy: Any
) -> None:
    found = likeness(pair, healthy, "alpha", kind)
    assert found.margin >= 1.0, found
    assert found.session == "healthy"


@pytest.mark.parametrize("kind", ["5", "reversed"])
def test_a_fault_that_a_check_tells_looks_as_no_healthy_session_does(
    kind: str, pair: LiveModel, healthy: Any
) -> None:
    assert likeness(pair, healthy, "torque", kind).alone < 1.0


@pytest.mark.slow
def test_the_gain_of_a_doubled_meter_changes_by_what_the_noise_before_it_says(
    pair: LiveModel,
) -> None:
    """SYNTHETIC: one torque of the model, and a meter with white noise and an offset that reads double from row 600."""
    settings = replace(sensor_faults.settings_of("torque", pair, RIG), torque_lag=0.0)
    frames = np.zeros(1000, FRAME)
    torque, noise, offset, begin = 0.02, 0.001, 0.004, 600
    frames["estimate"] = torque
    frames["torque"] = torque + offset
    frames["torque"] += noise * np.random.default_rng(5).standard_normal(1000)
    frames["torque"][begin:] += torque
    changes = sensor_bound.gain_changes(frames, settings)
    assert not np.any(changes[:300])
    for column, rows in zip(changes.T, sensor_bound.GAIN_WINDOWS, strict=True):
        expected = torque * np.sqrt(rows) / noise
        assert column[begin + rows - 1] == pytest.approx(expected, rel=0.25)
        assert np.max(column[:begin]) < 7.0


def test_an_encoder_that_stops_while_its_drive_rests_has_the_bits_of_health() -> None:
    brake, begin = sensor_faults.model_of(RIG, "bingham", "single"), 1113
    settings = sensor_faults.settings_of("wall", brake, RIG)
    well = sensor_faults.frames_of(settings, brake.library, RIG, 0)
    stuck = sensor_faults.frames_of(settings, brake.library, RIG, 0, ("theta", "stuck", begin))
    assert sensor_bound.same_bits(well, stuck, begin, sensor_faults.ZERO_WITHIN)
    late = sensor_faults.frames_of(settings, brake.library, RIG, 0, ("theta", "doubled", begin))
    assert not sensor_bound.same_bits(well, late, begin, sensor_faults.ZERO_WITHIN)

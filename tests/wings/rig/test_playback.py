"""A recording plays back at the loop's period, whatever its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import SettingError
from erclutch.signals.recording import Recording
from erclutch.wings.rig.playback import angles_of, at_period, fields_of


def damper(rows: int, period: float) -> Recording:
    t = period * np.arange(float(rows))
    signals = {
        "field": np.where(t < 0.02, -0.4, 2.2),
        "slip": np.full(rows, 0.3),
        "effort": 900.0 * t,
    }
    units = {"field": "V", "slip": "m/s", "effort": "N"}
    return Recording("a", signals, units, t, period, ((0, rows),), True, "")


def turning(period: float, wrap: float) -> Recording:
    t = period * np.arange(500.0)
    signals = {"theta": 20.0 * t % wrap, "alpha": 0.0 * t, "E": np.sin(t)}
    return Recording(
        "a", signals, {"theta": "rad", "alpha": "rad", "E": "V"}, t, period, ((0, 500),), True, ""
    )


def test_an_encoder_that_starts_again_at_zero_has_no_jumps_between_rows() -> None:
    log = turning(2e-3, 2.0 * np.pi)
    angles = at_period(log, angles_of(log, (2.0 * np.pi, 0.0)), 1e-3, held=False)
    assert np.diff(angles[:, 0]) * 1e3 == pytest.approx(20.0)


@pytest.mark.parametrize("period", [1e-3, 3.0])
def test_a_replay_takes_the_seconds_that_are_wanted(period: float) -> None:
    log = turning(period, 1.0)
    for held in (True, False):
        assert len(at_period(log, angles_of(log), 1e-3, held=held, seconds=0.1)) == 101


def test_a_replay_too_long_for_memory_is_refused() -> None:
    log = turning(30.0, 1.0)
    with pytest.raises(SettingError, match="14970 s has more than 10,000,000 rows"):
        at_period(log, angles_of(log), 1e-3, held=True)


@pytest.mark.parametrize(("unit", "scale"), [("?", 100.0), ("rad", 100.0), ("m", 1.0)])
def test_a_position_in_another_unit_than_the_slip_is_not_differentiated(
    unit: str, scale: float
) -> None:
    """A real damper's position in cm without a unit: the loop's slip was 100 times that of the log, without a word."""
    log = damper(50, 1e-3)
    position = scale * 0.3 * (log.time - log.time[0])
    with_position = replace(
        log, signals={**log.signals, "position": position}, units={**log.units, "position": unit}
    )
    assert np.diff(angles_of(with_position)[:, 0]) * 1e3 == pytest.approx(0.3)


@pytest.mark.slow
@settings(deadline=None)
@given(st.sampled_from([1e-4, 3.328e-4, 1e-3, 2e-3, 7e-3]))
def test_speeds_and_fields_are_those_of_the_log(period: float) -> None:
    """At 3 kHz a row a step would be a third of the speed."""
    log = damper(round(0.05 / period), period)
    angles = at_period(log, angles_of(log), 1e-3, held=False)
    commands = at_period(log, fields_of(log), 1e-3, held=True)
    assert len(angles) == len(commands)
    assert len(angles) * 1e-3 == pytest.approx(log.rows * period, abs=1e-3 + period)
    assert np.diff(angles[:, 0]) * 1e3 == pytest.approx(0.3)
    assert angles[:, 2] == pytest.approx(0.9 * np.arange(len(angles)), abs=1e-9)
    t = 1e-3 * np.arange(len(commands))
    before, after = t < 0.02 - 1e-9, t >= 0.02 + period
    assert np.all(commands[before] == [0.0, 0.4, 0.0])  # the negative part of a single field
    assert np.all(commands[after] == [2.2, 0.0, 0.0])

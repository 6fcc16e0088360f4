"""Readings of healthy sensors that were taken for faults, sample by sample: each was a session that tripped."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.signals.speed import Derivative
from erclutch.wings.live.c_core import Core
from erclutch.wings.live.layout import EVENT_BITS, FRAME, SAMPLE
from erclutch.wings.live.motion_limits import (
    acceleration_noise,
    alpha_count,
    motion_limits,
    stroke_end,
)
from erclutch.wings.live.sensor_limits import free_drive, free_output, torque_limits
from erclutch.wings.live.settings import LoopProgram, LoopSettings, Mode
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig
from tests.support.healthy_devices import healthy_sessions

RIG = default_rig()
DOUBTS = EVENT_BITS["theta-doubted"] | EVENT_BITS["alpha-doubted"] | EVENT_BITS["torque-doubted"]


def frames_of(
    settings: LoopSettings,
    model: Path | None,
    rows: int,
    read: Callable[[int, Any], tuple[float, ...]],
) -> Any:
    """Frames of a loop whose sensors read theta, alpha and torque of a row, from the estimate of the row before."""
    core = Core(settings, model)
    sample, frames = np.zeros(1, SAMPLE), np.zeros(rows, FRAME)
    for k in range(rows):
        sample["seq"], sample["time_ns"] = k + 1, (k + 1) * 1_000_000
        estimate = float(frames["estimate"][k - 1]) if k else 0.0
        sample["theta"], sample["alpha"], sample["torque"] = read(k, estimate)
        frames[k] = core.step(sample, k)[1]
    return frames


def free_pair(
    rig: RigParameters = RIG, bandwidth: float = 150.0, band: float = 5e-3, **changes: Any
) -> LoopSettings:
    """A pair under a field of 0.3 V, on whose output nothing but dry friction acts."""
    derivative = Derivative("kalman", bandwidth)
    limits = torque_limits(0.4, band, 1e-3) | free_output(rig, derivative)
    program = LoopProgram("fields", Mode.FIELDS, amplitude=0.3, motor_torque=0.1)
    settings = LoopSettings(
        derivative=derivative, least_slip=1.0, rise_rate=1e6, fall_rate=1e6, programs=(program,)
    )
    return replace(settings, **limits, **changes)


def angle(k: int, speed: float) -> float:
    """Of a side that comes to a speed in 1,000 rows."""
    return 1e-3 * speed * (k * k / 2000.0 if k < 1000 else k - 500.0)


def doubted(frames: Any) -> list[int]:
    return np.flatnonzero(frames["events"] & np.uint32(DOUBTS)).tolist()


def test_a_rotor_that_rings_from_reading_to_reading_is_no_fault() -> None:
    """Under gains at 400 Hz a clutch that locks again and again swung by 30 mN m about nothing."""
    rng = np.random.default_rng(3)
    swings = 0.03 * rng.uniform(0.2, 1.0, 3000) * np.resize([1.0, -1.0], 3000)
    swings[:1000] *= np.linspace(0.0, 1.0, 1000)
    frames = frames_of(
        free_pair(), None, 3000, lambda k, _: (angle(k, 40.0), angle(k, 10.0), 0.0028 + swings[k])
    )
    assert not doubted(frames)


def test_at_rest_half_a_count_of_a_coarse_meter_is_no_fault() -> None:
    """Friction held 3.4 mN m, and a meter of 2 mN m read 4."""
    noise = 5e-4 * np.random.default_rng(3).standard_normal(2000)
    counts = [0.002 * round((0.0034 + each) / 0.002) for each in noise]
    counts[1000:] = [0.004] * 1000
    frames = frames_of(free_pair(), None, 2000, lambda k, _: (0.04 * k, 0.0, counts[k]))
    assert not doubted(frames)


@pytest.mark.slow
def test_counts_of_an_encoder_that_come_one_by_one_are_no_fault() -> None:
    """At a speed of very nearly two counts a period each count that is one too many stands alone."""
    coarse = RIG.changed({"sensors.table_step": 2e-5, "screw.coulomb": 0.0018})
    count = alpha_count(coarse)
    torque = 0.0018 + RIG.value("screw.viscous") * 2e3 * count

    def read(k: int, _: float) -> tuple[float, ...]:
        return angle(k, 300.0), count * math.floor(angle(k, 2.04e3 * count) / count), torque

    assert not doubted(frames_of(free_pair(coarse, 60.0), None, 4000, read))


@pytest.mark.parametrize("bandwidth", [30.0, 60.0, 150.0, 400.0])
def test_what_counts_make_by_chance_or_alone_is_within_the_noise(bandwidth: float) -> None:
    derivative = Derivative("kalman", bandwidth)
    chosen = acceleration_noise(derivative, 1e-3)
    settings = free_pair(RIG.changed({"sensors.table_step": 1e-4}), bandwidth)
    inertia = RIG.value("screw.load_inertia")
    counts = inertia * 1e-4 * 2.0 * math.pi / RIG.value("screw.lead") * chosen
    meter = 6.0 * 0.27 * RIG.value("sensors.torque_noise")
    assert settings.load_band == pytest.approx(
        math.hypot(counts, meter, 0.7 * RIG.value("screw.coulomb"))
    )


def test_a_noisy_meter_and_its_friction_widen_together_what_torque_and_motion_may_differ() -> None:
    noisy = free_output(RIG.changed({"sensors.torque_noise": 0.0032}))
    assert noisy["load_band"] > 6.0 * 0.27 * 0.0032
    assert free_output(RIG)["load_band"] == 0.7 * RIG.value("screw.coulomb")


def test_an_output_that_breaks_away_later_one_way_withstands_more() -> None:
    asymmetric = free_output(RIG.changed({"screw.asymmetry": 0.2}))
    assert asymmetric["load_friction"] == pytest.approx(1.2 / 1.06 * RIG.value("screw.coulomb"))
    assert free_output(RIG)["load_friction"] == RIG.value("screw.coulomb")


@pytest.mark.parametrize("changed", [{"sensors.torque_bandwidth": 150.0}, {"screw.backlash": 2e-5}])
def test_torque_and_motion_are_not_compared_where_either_comes_late(
    changed: dict[str, float],
) -> None:
    assert free_output(RIG.changed(changed))["load_inertia"] == 0.0
    assert free_output(RIG)["load_inertia"] > 0.0
    slow = "sensors.torque_bandwidth" in changed
    assert (free_drive(RIG.changed(changed))["load_inertia"] == 0.0) == slow


def test_torque_and_motion_are_not_compared_where_the_meter_is_seldom_read() -> None:
    """At 500 Hz three of 192 healthy sessions tripped where a clutch locked: its torque fell between two readings."""
    assert free_output(RIG, period=2e-3)["load_inertia"] == 0.0
    assert free_output(RIG, period=5e-4)["load_inertia"] > 0.0
    assert free_drive(RIG, period=2e-3)["load_inertia"] > 0.0


@pytest.mark.parametrize("bandwidth", [30.0, 60.0, 150.0, 400.0])
def test_an_end_stop_turns_an_output_behind_any_filter(bandwidth: float) -> None:
    """Behind 30 Hz the filter went on outward for ten periods at 400 rad/s, and the encoder was blamed."""
    end, derivative = stroke_end(RIG), Derivative("kalman", bandwidth)
    limits: dict[str, Any] = motion_limits(RIG, "coaxial", derivative, 1e-3)
    settings = LoopSettings(derivative=derivative, stroke=0.9 * end, **limits)
    angle, speed, angles = 0.0, 420.0, list[float]()
    stiff = RIG.value("screw.stop_stiffness") / 5.6e-5  # 1/s^2: of what turns with the output
    for _ in range(400):
        angles.append(angle)
        for _ in range(20):
            speed -= 5e-5 * stiff * max(angle - end, 0.0)
            angle += 5e-5 * speed
    assert max(angles) > end > angles[-1]
    frames = frames_of(settings, None, 400, lambda k, _: (0.65 * k, angles[k], 0.0))
    assert not doubted(frames)


def test_a_meter_is_not_stuck_because_the_model_guesses(bingham: Path) -> None:
    """Outside its log the model's torque jumped about, and a meter in counts of 2 mN m was to show that."""

    def read(k: int, estimate: float) -> tuple[float, ...]:
        theta = 0.04 * k if k < 600 else 24.0 + 2.0 * (k - 600)  # rad; beyond all slips of the log
        return theta, 0.0, 0.18 + 1e-6 * (min(k, 590) // 40 % 2)

    settings = replace(
        free_pair(), load_inertia=0.0, theta_glitch=1e6, theta_fastest=1e6, torque_still=1e-5
    )
    frames = frames_of(settings, bingham, 640, read)
    assert np.ptp(frames["estimate"][600:]) > 5.0 * settings.torque_still
    assert not np.any(frames["events"][600:] & EVENT_BITS["stuck"])


@pytest.mark.slow
@pytest.mark.parametrize("seed", [47, 58])
def test_another_device_with_its_own_model_does_not_trip(seed: int) -> None:
    """Of 40 drawn devices ten tripped; `studies/healthy_devices.py` draws more."""
    tripped = [
        f"{session.words}: {session.said}"
        for session in healthy_sessions(seed)
        if session.trip >= 0
    ]
    assert not tripped, "\n".join(tripped)

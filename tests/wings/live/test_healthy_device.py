"""No healthy device trips: every program of the TWIN's pair and brake, from the weakest motor to the strongest."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from erclutch.signals.device import DeviceName
from erclutch.signals.speed import Derivative
from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.c_core import Core
from erclutch.wings.live.command_line.live_options import ObserverOption
from erclutch.wings.live.layout import EVENT_BITS, SAMPLE
from erclutch.wings.live.motion_limits import innovation_lag, motion_limits
from erclutch.wings.live.sensor_limits import free_drive
from erclutch.wings.live.settings import LoopSettings
from erclutch.wings.rig.twin.parameters import default_rig
from tests.support.healthy_sessions import sessions
from tests.support.sensor_faults import model_of

RIG = default_rig()
STRONGEST = RIG.value("drive.torque_limit")
DEVICES: tuple[DeviceName, ...] = ("coaxial", "single")


def tripped(device: DeviceName, name: str, motors: Sequence[float], observers: Sequence[ObserverOption], rows: int,
            **control: Any) -> tuple[int, list[str]]:  # fmt: skip
    """How many sessions were run, and those that tripped, with the events of the trip."""
    model, brake = model_of(RIG, name, device), device == "single"
    count, found = 0, list[str]()
    for motor, observer in itertools.product(motors, observers):
        for settings, program in sessions(device, model, motor=motor, observer=observer, **control):
            run = AcceleratedRun(settings, model.library, RIG, seed=1, single=brake, locked=brake)
            events = run.frames(rows)[0]["events"]
            count += 1
            if at := np.flatnonzero(events & EVENT_BITS["trip"]).tolist():
                said = int(np.bitwise_or.reduce(events[max(at[0] - 20, 0) : at[0] + 1]))
                names = [event for event, bit in EVENT_BITS.items() if said & bit]
                found.append(
                    f"{device}, {program}, {motor:g} N m, {observer}, row {at[0]}: {' '.join(names)}"
                )
    return count, found


@pytest.mark.slow
@pytest.mark.parametrize("name", ["tracking-slow"])
def test_the_strongest_motor_of_the_rig_trips_no_healthy_pair(name: str) -> None:
    """The drive passed 1000 rad/s, and the loop took its encoder for broken."""
    model = model_of(RIG, "bingham", "coaxial")
    offered = sessions("coaxial", model, motor=STRONGEST, observer="none")
    settings = next(settings for settings, program in offered if program == name)
    frames = AcceleratedRun(settings, model.library, RIG, seed=0).frames(800)[0]
    assert frames["theta_dot"].max() > 1000.0
    assert not np.any(frames["events"] & np.uint32(EVENT_BITS["trip"]))


@pytest.mark.slow
@pytest.mark.parametrize("device", DEVICES)
def test_no_program_with_any_motor_torque_trips_a_healthy_device(device: DeviceName) -> None:
    motors = (0.02, 0.1, 0.2, 0.45, 0.7, STRONGEST)
    count, found = tripped(device, "bingham", motors, ("none",), rows=4000)
    assert count == len(motors) * (10 if device == "coaxial" else 7)
    assert not found, "\n".join(found)


@pytest.mark.slow
@pytest.mark.parametrize("device", DEVICES)
def test_no_observer_trips_a_healthy_device(device: DeviceName) -> None:
    """Under gains on the estimate the brake stopped from 2 rad/s within a period: its encoder was taken for stuck."""
    count, found = tripped(
        device, "bingham", (0.2, STRONGEST), ("off", "sensor", "motion"), rows=2000
    )
    assert count > 30
    assert not found, "\n".join(found)


@pytest.mark.slow
@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("bandwidth", [30.0, 80.0, 400.0])
def test_no_filter_of_the_speeds_trips_a_healthy_device(
    device: DeviceName, bandwidth: float
) -> None:
    """Torque was compared with a speed that the filter made later, or that jumped with the encoder's counts."""
    count, found = tripped(
        device, "bingham", (0.1, STRONGEST), ("none",), rows=2000, speed_bandwidth=bandwidth
    )
    assert count > 10
    assert not found, "\n".join(found)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fnn-16"])
def test_a_network_that_leaves_its_log_trips_no_healthy_pair(name: str) -> None:
    _, found = tripped("coaxial", name, (0.2, STRONGEST), ("none", "sensor"), rows=2000)
    assert not found, "\n".join(found)


@pytest.mark.parametrize("cutoff", [20.0, 150.0, 400.0])
@pytest.mark.parametrize("missing", [0, 1, 4, 19])
def test_the_hardest_push_of_the_rig_is_no_jump_whatever_the_filter_and_the_samples_that_are_missing(
    cutoff: float, missing: int
) -> None:
    """The drive swings under the largest torque that motor and clutch can give at once."""
    derivative = Derivative("kalman", cutoff)
    limits: dict[str, Any] = motion_limits(RIG, "single", derivative, 1e-3)
    core = Core(LoopSettings(device="single", derivative=derivative, **limits), None)
    torque = STRONGEST + 2.0 * RIG.value("clutch.rated_torque_1")
    time = 1e-3 * np.arange(400)
    speed = np.cumsum(1e-3 * torque / RIG.value("drive.inertia") * np.sign(np.sin(40.0 * time)))
    mean = 0.5 * (speed + np.concatenate(([0.0], speed[:-1])))  # in each period
    angle, sample = np.cumsum(1e-3 * mean), np.zeros(1, SAMPLE)
    for k in range(400):
        if k > 100 and k % 25 < missing:
            continue  # a packet that is lost
        sample["seq"], sample["time_ns"], sample["theta"] = k + 1, (k + 1) * 1_000_000, angle[k]
        assert not core.step(sample, k)[1]["events"] & EVENT_BITS["theta-doubted"], k


def test_a_reading_further_than_the_rig_can_push_is_a_jump() -> None:
    limits: dict[str, Any] = motion_limits(RIG, "single", Derivative("kalman"), 1e-3)
    core, sample, events = (
        Core(LoopSettings(device="single", **limits), None),
        np.zeros(1, SAMPLE),
        0,
    )
    for k in range(100):
        sample["seq"], sample["time_ns"], sample["theta"] = (
            k + 1,
            (k + 1) * 1_000_000,
            0.05 * k + 0.03 * (k == 99),
        )
        events = int(core.step(sample, k)[1]["events"])
    assert events & EVENT_BITS["theta-doubted"]
    assert events & EVENT_BITS["glitch"]


def test_a_slower_filter_is_further_behind() -> None:
    """A steady-state filter is off by acceleration x period^2 / h; pushes that come and go add a tenth."""
    lags = [innovation_lag(Derivative("kalman", cutoff), 1e-3) for cutoff in (30.0, 150.0)]
    assert lags[0] == pytest.approx(1.09e-3 / 0.0311, rel=1e-2)
    assert lags[1] == pytest.approx(1.10e-3 / 0.4616, rel=1e-2)


def test_limits_of_another_rig_follow_its_numbers() -> None:
    usual = motion_limits(RIG, "coaxial", Derivative("kalman"), 1e-3)
    strong = motion_limits(
        RIG.changed({"drive.torque_limit": 5.0}), "coaxial", Derivative("kalman"), 1e-3
    )
    light = motion_limits(
        RIG.changed({"drive.inertia": 1e-4}), "coaxial", Derivative("kalman"), 1e-3
    )
    soft = motion_limits(
        RIG.changed({"screw.stop_stiffness": 0.5}), "coaxial", Derivative("kalman"), 1e-3
    )
    assert strong["theta_glitch"] > 2.0 * usual["theta_glitch"]
    assert strong["theta_fastest"] > 5.0 * usual["theta_fastest"]
    assert light["theta_glitch"] > 2.0 * usual["theta_glitch"]
    assert soft["alpha_limit"] > 1.1 * usual["alpha_limit"]


def test_a_coarse_encoder_widens_what_torque_and_motion_may_differ() -> None:
    coarse = RIG.changed({"sensors.motor_counts": 512.0})
    assert free_drive(coarse)["load_band"] > 10.0 * free_drive(RIG)["load_band"]

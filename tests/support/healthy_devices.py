"""Healthy devices drawn at random: another rig than the TWIN's, its own model, sessions of `erclutch live` on it.

What a rig file says of a device is drawn, and where the device is later: warmer, with other friction, with more noise.
No sensor is wrong, so each session that trips is a false alarm.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from erclutch.signals.channels import NamedChannels
from erclutch.signals.device import DeviceName, Units
from erclutch.wings.live.accelerated import AcceleratedRun
from erclutch.wings.live.command_line.chosen_rig import channels_of_rig
from erclutch.wings.live.command_line.chosen_settings import settings_of
from erclutch.wings.live.command_line.live_options import ControlOptions, ObserverOption, RigOptions
from erclutch.wings.live.layout import EVENT_BITS
from erclutch.wings.live.session import LiveModel, ServedRig
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig
from tests.support.sensor_faults import model_of

ROWS = 4000
#: Times what the default rig has, evenly by the logarithm.
FACTORS: Mapping[str, tuple[float, float]] = {
    "drive.inertia": (0.6, 2.5),
    "screw.load_inertia": (0.6, 1.8),
    "screw.rotor_inertia": (0.6, 2.0),
    "drive.coulomb": (0.4, 2.0),
    "screw.coulomb": (0.5, 2.5),
    "clutch.rated_torque_1": (0.6, 2.0),
    "fluid.viscosity": (0.5, 2.0),
    "sensors.torque_noise": (0.3, 8.0),
    "screw.stribeck_speed": (0.4, 8.0),
    "fluid.building_time": (0.4, 1.3),
    "drive.torque_time": (0.3, 3.0),
    "fluid.thinning": (0.4, 2.0),
}
#: One of these.
CHOICES: Mapping[str, tuple[float, ...]] = {
    "sensors.motor_counts": (1024.0, 4096.0, 8192.0, 65536.0),
    "sensors.table_step": (1e-6, 5e-6, 2e-5),
    "sensors.torque_step": (0.0, 5e-5, 5e-4, 2e-3),
    "sensors.torque_bandwidth": (150.0, 400.0, 1000.0, 3000.0),
    "supply.time_constant": (2.7e-4, 1e-3),
    "screw.backlash": (0.0, 0.0, 2e-5),
    "screw.asymmetry": (0.06, 0.2),
    "drive.ripple": (0.0, 0.01, 0.04),
}
#: K above the temperature of the rig file, and times what the rig file says.
WARMER = (-10.0, 15.0)
DRIFTS: Mapping[str, tuple[float, float]] = {
    "screw.coulomb": (0.75, 1.3),
    "drive.coulomb": (0.75, 1.3),
    "sensors.torque_noise": (1.0, 2.0),
    "clutch.seal_1": (0.7, 1.5),
    "screw.viscous": (0.5, 2.0),
}
MODELS = ("bingham", "bingham", "hem", "fnn-16")
BANDWIDTHS = (
    30.0,
    45.0,
    60.0,
    80.0,
    110.0,
    150.0,
    200.0,
    250.0,
    300.0,
    400.0,
)  # Hz, of the speeds' filter
OBSERVERS: tuple[ObserverOption, ...] = ("none", "sensor", "motion", "off")


@dataclass(frozen=True)
class HealthySession:
    """What a session was, the row in which it tripped (-1: it did not), and what was said of it then."""

    words: str
    trip: int
    said: tuple[str, ...]


def healthy_sessions(seed: int) -> Iterator[HealthySession]:
    """Sixteen sessions on one device: two filters with two observers each, and four of the programs with each pair."""
    rng = np.random.default_rng((11, seed))
    rig = _rig(rng)
    now = _later(rig, rng)
    device: DeviceName = "coaxial" if rng.random() < 0.65 else "single"
    name = str(rng.choice(MODELS))
    model = model_of(rig, name, device)
    for bandwidth in rng.choice(BANDWIDTHS, 2, replace=False).tolist():
        for number in rng.choice(len(OBSERVERS), 2, replace=False).tolist():
            motor = math.exp(rng.uniform(math.log(0.03), math.log(rig.value("drive.torque_limit"))))
            noise = int(rng.integers(1 << 30))
            control = ControlOptions(
                motor=motor,
                observer=OBSERVERS[number],
                speed_bandwidth=bandwidth,
                meter_needed=(None, True, False)[int(rng.integers(3))],
            )
            words = f"seed {seed}, {device}, {name}, {bandwidth:g} Hz, {control.observer}, {motor:.3g} N m"
            yield from _programs(rng, rig, now, device, model, control, noise, words)


def _programs(
    rng: np.random.Generator,
    rig: RigParameters,
    now: RigParameters,
    device: DeviceName,
    model: LiveModel,
    control: ControlOptions,
    noise: int,
    words: str,
) -> Iterator[HealthySession]:
    named = NamedChannels({}, Units("N*m", "", "rad/s"), motor=True, sensor=True)
    twin = ServedRig("twin", "TWIN", {"kind": "twin"}, named)
    options = RigOptions(seed=noise % 1000), control
    offered = settings_of(
        twin, device, model, channels_of_rig(twin, device, model), rig, options, {}, None
    )
    single = device == "single"
    for number in rng.choice(
        len(offered.programs), min(4, len(offered.programs)), replace=False
    ).tolist():
        program = offered.programs[number]
        settings = replace(offered, programs=(program,))
        run = AcceleratedRun(settings, model.library, now, seed=noise, single=single, locked=single)
        events = run.frames(ROWS)[0]["events"]
        at = np.flatnonzero(events & EVENT_BITS["trip"])
        trip = int(at[0]) if at.size else -1
        bits = int(np.bitwise_or.reduce(events[max(trip - 20, 0) : trip + 1])) if at.size else 0
        said = tuple(event for event, bit in EVENT_BITS.items() if bits & bit)
        yield HealthySession(
            f"{words}, {program.name}, meter needed {control.meter_needed}", trip, said
        )


def _rig(rng: np.random.Generator) -> RigParameters:
    """Another rig than the default one, or that with a chance of a quarter."""
    usual, drawn = default_rig(), dict[str, float]()
    for path, (low, high) in FACTORS.items():
        if rng.random() < 0.5:
            drawn[path] = usual.value(path) * math.exp(rng.uniform(math.log(low), math.log(high)))
    for path, choices in CHOICES.items():
        if rng.random() < 0.35:
            drawn[path] = float(rng.choice(choices))
    if rng.random() < 0.25:
        drawn = {}
    if "clutch.rated_torque_1" in drawn:
        drawn["clutch.rated_torque_2"] = 0.94 * drawn["clutch.rated_torque_1"]
    return usual.changed(drawn)


def _later(rig: RigParameters, rng: np.random.Generator) -> RigParameters:
    """The device of a rig on another day."""
    drawn = dict[str, float]()
    if rng.random() < 0.6:
        drawn["thermal.room"] = float(rng.uniform(*WARMER))
    for path, (low, high) in DRIFTS.items():
        if rng.random() < 0.5:
            drawn[path] = rig.value(path) * float(rng.uniform(low, high))
    return rig.changed(drawn) if rng.random() < 0.7 else rig

"""What each sensor of a loop can read follows from the device and its model. The loop believes nothing else."""

from __future__ import annotations

import math

from erclutch.signals.device import DeviceName
from erclutch.wings.live.motion_limits import (
    MOTION,
    PEAK,
    USUAL_FILTER,
    AnyFilter,
    acceleration_noise,
    alpha_count,
    motion_limits,
    theta_count,
)
from erclutch.wings.live.session import LiveModel
from erclutch.wings.rig.twin.parameters import RigParameters

#: Times the largest effort of a log that a device gives, where no rated torque is known.
_BEYOND_LOG = 8.0
#: Times the largest slip of a log, and as much of a jump in a period: what an encoder reads beyond is no motion.
_FASTEST = 10.0
#: Times the band of a model under a settled field by which a healthy device jumps for longer than a few periods.
_BANDS = 3.0
#: Share of the largest effort that is at least allowed for: beyond its log a model guesses.
_LEAST_BAND = 0.1
#: Share of the largest effort by which the model's torque moves before a sensor that reads the same is stuck.
_STILL = 0.02
#: Share of that limit that a torque crosses in a period at most.
_CROSSES = 0.5
#: Of the dry friction of an output or a drive: what its place and way change of it, and the ringing of a meter.
_FRICTION = 0.7
#: Times a meter's noise: three standard deviations of twice the noise, of which the filter of the check passes 27 %.
_METER_SCATTER = 6.0 * 0.27
#: Of that friction: noise that makes more of a torque adds to it.
_MATTERS = 0.35
#: Times its sliding friction at which an output breaks away; the loop's check allows for that.
_BREAKS_AWAY = 1.3 * 1.06
#: Hz: a slower meter shows a torque when the motion has long answered to it.
_SLOWEST_METER = 200.0
#: s: a loop that reads its meter more seldom does not see what the torque does meanwhile where a clutch locks.
_LONGEST_PERIOD = 1.5e-3
_NOT_COMPARED: dict[str, float] = {
    "load_inertia": 0.0,
    "load_friction": 0.0,
    "load_drag": 0.0,
    "load_band": 0.0,
}


def torque_limits(effort: float, band: float, period: float) -> dict[str, float]:
    """What a torque sensor can read by a model alone: its largest effort and settled band in N m, the period in s."""
    limit = _BEYOND_LOG * effort
    return {
        "torque_limit": limit,
        "torque_rate": _CROSSES * limit / period,
        "torque_band": max(_BANDS * band, _LEAST_BAND * effort) if band > 0.0 else 0.0,
        "torque_still": _STILL * effort,
    }


def free_output(
    rig: RigParameters,
    derivative: AnyFilter | None = None,
    period: float = 1e-3,
) -> dict[str, float]:
    """What a loop has to know of an output on which nothing but dry friction acts beside the measured torque.

    Then torque and motion tell of each other. A hand, a spring or a weight on the output needs no sensor to be wrong.
    Nor does a table that is loose on its screw, a slow meter, or one that is seldom read: there nothing is compared.
    """
    if (
        rig.value("screw.backlash") > rig.value("sensors.table_step")
        or _is_slow(rig)
        or period > _LONGEST_PERIOD
    ):
        return _NOT_COMPARED
    acceleration = acceleration_noise(derivative or USUAL_FILTER, period)
    return _free_load(rig, "screw", rig.value("screw.load_inertia"), alpha_count(rig), acceleration)


def free_drive(
    rig: RigParameters,
    derivative: AnyFilter | None = None,
    period: float = 1e-3,
) -> dict[str, float]:
    """The same of the drive of a brake: nothing but the motor and dry friction acts on it beside the measured torque.

    Where a hand turns the brake, its torque is not known, and no sensor needs to be wrong.
    Beside a slow meter nothing is compared.
    """
    if _is_slow(rig):
        return _NOT_COMPARED
    acceleration = acceleration_noise(derivative or USUAL_FILTER, period)
    return _free_load(rig, "drive", rig.value("drive.inertia"), theta_count(rig), acceleration)


def _free_load(
    rig: RigParameters,
    part: str,
    inertia: float,
    count: float,
    acceleration: float,
) -> dict[str, float]:
    """What the loop has to know of a part of the rig on which nothing but friction acts beside the measured torque.

    Args:
        rig: whose friction counts.
        part: of the rig, by the name in front of its parameters.
        inertia: of the part.
        count: of its encoder, in rad.
        acceleration: that a count of 1 rad makes, see `acceleration_noise`.
    """
    noise = inertia * count * acceleration
    friction = rig.value(f"{part}.coulomb")
    if part == "screw":  # its preload breaks away later one way than the other
        withstands = rig.value("screw.breakaway") * (1.0 + rig.value("screw.asymmetry"))
        friction *= max(withstands / _BREAKS_AWAY, 1.0)
    band = max(_FRICTION * friction, noise)
    noise = math.hypot(noise, _METER_SCATTER * rig.value("sensors.torque_noise"))
    if part == "screw" and noise > _MATTERS * friction:
        band = math.hypot(_FRICTION * friction, noise)
    return {
        "load_inertia": inertia,
        "load_friction": friction,
        "load_drag": rig.value(f"{part}.viscous"),
        "load_band": band,
    }


def _is_slow(rig: RigParameters) -> bool:
    return rig.value("sensors.torque_bandwidth") < _SLOWEST_METER


def sensor_limits(
    device: DeviceName,
    model: LiveModel | None,
    rig: RigParameters | None,
    derivative: AnyFilter | None = None,
    period: float = 1e-3,
) -> dict[str, float]:
    """Settings of a loop that say what its sensors can read.

    Args:
        device: what hangs on the rig.
        model: that estimates; None where there is none.
        rig: the device's parameters; None where they are not known.
        derivative: the loop's filter of the speeds; that of `LoopSettings` by default.
        period: of the loop in s.

    Returns:
        Names of `LoopSettings` and their numbers, 0 where neither device nor model says a limit.
    """
    limits = (
        torque_limits(0.0, 0.0, period)
        if model is None
        else torque_limits(model.effort, model.band, period)
    )
    if rig is not None:
        clutches = (
            ("rated_torque_1", "rated_torque_2") if device == "coaxial" else ("rated_torque_1",)
        )
        limits["torque_limit"] = PEAK * sum(rig.value(f"clutch.{name}") for name in clutches)
        limits["torque_rate"] = _CROSSES * limits["torque_limit"] / period
        limits |= motion_limits(rig, device, derivative or USUAL_FILTER, period)
    else:
        slip = 0.0 if model is None else model.slip
        limits |= dict.fromkeys(MOTION, _FASTEST * slip)
    return limits

"""How far, how fast and how suddenly the sides of a rig can move follows from its torques, inertias and end stops."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

from erclutch.signals.device import DeviceName
from erclutch.signals.speed import Derivative, LiveDerivative, live
from erclutch.wings.rig.twin.parameters import RigParameters

#: Settings of speeds, and of jumps of speeds.
MOTION = ("theta_glitch", "alpha_glitch", "theta_fastest", "alpha_fastest")
AnyFilter = Derivative | LiveDerivative
#: Of the speeds of a loop that is told no other.
USUAL_FILTER = Derivative("kalman")
#: Times its rated torque that a clutch gives for a moment, with its fluid at rest or its rotor ringing.
PEAK = 2.0
#: Of the motor's largest torque: a ripple of 1, and one of 0.4 of its size, at their crests.
_CRESTS = 1.4
#: 1/s: of the filter through which torque and motion are compared, MOMENTUM_RATE of c/erc_plausible.c.
_COMPARED_BY = 150.0
#: Standard deviations by which the counts of an encoder let torque and motion differ: a quick filter passes them on.
_SCATTER = 3.0
#: Of what one count makes: the next one comes before it is forgotten.
_TWO_CLOSE = 1.15
#: Share of the largest answer of a filter below which it has forgotten a push.
_FORGOTTEN = 1e-6


def motion_limits(
    rig: RigParameters,
    device: DeviceName,
    derivative: AnyFilter,
    period: float,
) -> dict[str, float]:
    """Settings of a loop that say how far, how fast and how suddenly healthy sides can move.

    A motor may be told its largest torque at any time, on the page too: the limits hold for each torque of a program.

    Args:
        rig: the device's parameters.
        device: what hangs on the rig; a single device is CH1.
        derivative: the filter of the speeds: a slow one is further behind a side that speeds up.
        period: of the loop in s.

    Returns:
        Names of `LoopSettings` and their numbers; 0 where the rig says no limit.
    """
    motor = rig.value("drive.torque_limit") * (1.0 + _CRESTS * rig.value("drive.ripple"))  # N m
    clutches = ("rated_torque_1",) if device == "single" else ("rated_torque_1", "rated_torque_2")
    # In N m; there are never two fields at once.
    rated = max(rig.value(f"clutch.{name}") for name in clutches)
    on_drive = motor + PEAK * rated + rig.value("drive.coulomb") * rig.value("drive.breakaway")
    on_output = PEAK * rated + rig.value("screw.coulomb") * rig.value("screw.breakaway")
    inertia = rig.value("screw.rotor_inertia") + rig.value("screw.load_inertia")  # kg m^2

    lag = innovation_lag(derivative, period)  # s
    # A reading is a count off at most, and so is its prediction.
    theta_noise = 2.0 * theta_count(rig) / period
    alpha_noise = 2.0 * alpha_count(rig) / period
    viscous = rig.value("drive.viscous")  # N m s/rad
    drive_fastest = motor / viscous if viscous > 0.0 else 0.0
    limits = {
        "theta_glitch": lag * on_drive / rig.value("drive.inertia") + theta_noise,
        "alpha_glitch": lag * on_output / inertia + alpha_noise,
        "theta_fastest": drive_fastest,
        "alpha_fastest": drive_fastest,
    }
    if device == "coaxial":
        end = stroke_end(rig)
        # From one end stop to the other under the rated torque; an end stop gives way by what brings it to rest.
        output_fastest = math.sqrt(2.0 * (rated / inertia) * 2.0 * end)
        gives_way = output_fastest * math.sqrt(inertia / rig.value("screw.stop_stiffness"))
        limits |= {"alpha_fastest": output_fastest, "alpha_limit": end + gives_way}
    return limits


def stroke_end(rig: RigParameters) -> float:
    """Angle of the output shaft in rad at which the table reaches an end stop, on either side of the middle."""
    return 2.0 * math.pi * rig.value("screw.half_stroke") / rig.value("screw.lead")


def theta_count(rig: RigParameters) -> float:
    """A count of the motor's encoder in rad."""
    return 2.0 * math.pi / rig.value("sensors.motor_counts")


def alpha_count(rig: RigParameters) -> float:
    """A count of the output's encoder in rad: of the table's or of the shaft's, the coarser."""
    table = 2.0 * math.pi * rig.value("sensors.table_step") / rig.value("screw.lead")
    return max(table, 2.0 * math.pi / rig.value("sensors.rotary_counts"))


def innovation_lag(derivative: AnyFilter, period: float) -> float:
    """By how much a reading is off its prediction, in rad/s over a period, for each rad/s^2 of acceleration; in s.

    What a push of one period leaves, summed up: the most that any course of such accelerations does.
    """
    # Angles under 1 rad/s^2 in the first period, from rest.
    push = ((0.5 + k) * period * period for k in itertools.count())
    return sum(abs(off) for off, _ in _answers(derivative, period, push)) / period


def acceleration_noise(derivative: AnyFilter, period: float) -> float:
    """How far in 1/s^2 the acceleration that is compared may be off where readings come to the next count of 1.

    Three standard deviations of counts that come by chance; or what one count makes by itself, where each comes alone,
    at a speed of nearly whole counts a period.
    """
    count = itertools.chain((1.0,), itertools.repeat(0.0))
    passed = _COMPARED_BY * period / (1.0 + _COMPARED_BY * period)
    speed = 0.0
    squares = 0.0
    alone = 0.0
    most = 0.0
    for _, filtered in _answers(derivative, period, count):
        change = passed * (filtered - speed)
        speed += change
        squares += (change / period) ** 2
        alone += change / period
        most = max(most, abs(alone))
    # A count's error is anything within it.
    return max(_SCATTER * math.sqrt(squares / 12.0), _TWO_CLOSE * most)


def _answers(
    derivative: AnyFilter,
    period: float,
    angles: Iterator[float],
) -> Iterator[tuple[float, float]]:
    """Innovation in rad and speed in rad/s of a filter at rest to angles, until it has forgotten what happened."""
    chosen = derivative if isinstance(derivative, LiveDerivative) else live(derivative, period)
    filter = LiveDerivative(period, chosen.g, chosen.h, 0.0)
    most = 0.0
    for angle in angles:
        off = angle - (filter.position or 0.0) - period * filter.speed
        yield off, filter.step(angle)
        most = max(most, abs(off))
        if abs(off) <= _FORGOTTEN * most:
            return

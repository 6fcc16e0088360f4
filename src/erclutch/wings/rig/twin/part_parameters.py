"""The compiled code takes the parameters of the parts as named tuples of floats, one a part."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from erclutch.signals.array import Array
from erclutch.wings.rig.twin.parameters import RigParameters

#: Gauss points over the radius of a gap.
POINTS = 5
#: Field over the reference field, below which breaking no longer slows down.
LEAST_RATIO = 1e-6


class Supply(NamedTuple):
    """High-voltage unit; see default.toml for meanings and units."""

    command_limit: float
    voltage_limit: float
    time_constant: float
    slew_up: float
    slew_down: float
    leakage_1: float
    leakage_2: float


class Fluid(NamedTuple):
    """The ER fluid; ``idle_breaking`` is the shear rate that halves the structure without a field [1/s]."""

    polarisation: float
    critical_field: float
    viscosity: float
    thinning: float
    thinning_rate: float
    field_thickening: float
    residual_yield: float
    yield_strain: float
    breaking_rate: float
    breaking_exponent: float
    building_time: float
    decay_time: float
    residual_field: float
    residual_time: float
    rearranging_strain: float
    idle_breaking: float


class Clutch(NamedTuple):
    """What differs between the two clutches.

    Attributes:
        gap: between discs [m].
        strength: yield stress over the critical-field form 1.313 X^1.5 tanh(sqrt X) [Pa].
        seal: friction torque of the lip seal [N m].
        seal_slip: presliding angle of the seal [rad].
    """

    gap: float
    strength: float
    seal: float
    seal_slip: float


class Gaps(NamedTuple):
    """The Gauss points over the radius of gap 1, then of gap 2; each shape (2 POINTS,).

    Attributes:
        way: in which the motor turns the housing, 1 or -1.
        arm: r / gap: shear rate per slip.
        weight: faces x 2 pi r^2 dr: torque per shear stress [m^3].
        volume: weight over arm: energy per energy density [m^3].
        thick: torque per slip and viscosity [m^3], with the clutch's viscosity over the fluid's.
    """

    way: Array
    arm: Array
    weight: Array
    volume: Array
    thick: Array


class Drive(NamedTuple):
    """Motor, gears and housings."""

    inertia: float
    torque_time: float
    torque_limit: float
    ripple: float
    coulomb: float
    breakaway: float
    stribeck_speed: float
    viscous: float
    presliding: float


class Screw(NamedTuple):
    """Output shaft, torque meter's compliance, ball screw and table."""

    rotor_inertia: float
    load_inertia: float
    stiffness: float
    damping: float
    lead: float
    half_stroke: float
    stop_stiffness: float
    stop_damping: float
    coulomb: float
    breakaway: float
    stribeck_speed: float
    viscous: float
    presliding: float
    asymmetry: float
    waviness: float
    backlash: float


class Sensors(NamedTuple):
    """Torque meter and encoders."""

    torque_bandwidth: float
    torque_noise: float
    torque_step: float
    motor_counts: float
    table_step: float
    rotary_counts: float


class Thermal(NamedTuple):
    """Heat of both clutches."""

    capacity: float
    loss: float
    thinning: float
    softening: float
    room: float


class Parts(NamedTuple):
    """All parts of the rig."""

    supply: Supply
    fluid: Fluid
    clutch_1: Clutch
    clutch_2: Clutch
    gaps: Gaps
    drive: Drive
    screw: Screw
    sensors: Sensors
    thermal: Thermal


def yield_form(ratio: float) -> float:
    """The critical-field form 1.313 X^1.5 tanh(sqrt X) for X = E / E_c."""
    return float(1.313 * ratio**1.5 * np.tanh(np.sqrt(ratio)))


def single_clutch(parts: Parts) -> Parts:
    """CH1 alone: of the second clutch nothing is left, neither fluid nor seal."""
    there = np.repeat([1.0, 0.0], POINTS)
    gaps = parts.gaps
    alone = gaps._replace(
        weight=gaps.weight * there,
        volume=gaps.volume * there,
        thick=gaps.thick * there,
    )
    without_seal = parts.clutch_2._replace(seal=0.0)
    return parts._replace(clutch_2=without_seal, gaps=alone)


def parts_of(rig: RigParameters) -> Parts:
    """Parameters as the compiled code takes them."""
    clutch = rig.section("clutch")
    fluid = rig.section("fluid")
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    inner = clutch["inner_radius"]
    outer = clutch["outer_radius"]
    gap = clutch["gap"]
    radius = 0.5 * (outer - inner) * points + 0.5 * (outer + inner)
    weight = 0.5 * (outer - inner) * weights * 2.0 * np.pi * radius**2 * clutch["faces"]
    full = yield_form(rig.value("supply.voltage_limit") / gap / rig.value("fluid.critical_field"))

    def one(i: int) -> Clutch:
        return Clutch(
            gap=gap,
            strength=clutch[f"rated_torque_{i}"] / (float(weight.sum()) * full),
            seal=clutch[f"seal_{i}"],
            seal_slip=clutch["seal_slip"],
        )

    viscosity = clutch["viscosity_1"], clutch["viscosity_2"]
    idle_breaking = fluid["breaking_rate"] * LEAST_RATIO ** fluid["breaking_exponent"]
    # The points of both gaps, which are alike but for the viscosity.
    arms = np.tile(radius / gap, 2)
    weights = np.tile(weight, 2)
    return Parts(
        supply=Supply(**rig.section("supply")),
        fluid=Fluid(**fluid, idle_breaking=idle_breaking),
        clutch_1=one(1),
        clutch_2=one(2),
        gaps=Gaps(
            way=np.repeat([1.0, -1.0], POINTS),
            arm=arms,
            weight=weights,
            volume=weights / arms,
            thick=weights * arms * np.repeat(viscosity, POINTS),
        ),
        drive=Drive(**rig.section("drive")),
        screw=Screw(**rig.section("screw")),
        sensors=Sensors(**rig.section("sensors")),
        thermal=Thermal(**rig.section("thermal")),
    )

"""The ER fluid at one radius of a gap has chains that build up, strain, yield and break in a thinning liquid.

Shear stress = G z + eta g, with g the shear rate, z the chains' strain, G = tau_y s / z_y their stiffness:

    z' = g - |g| z / z_y                      elastic below the yield strain z_y, then flow (smooth sign, hysteresis)
    s' = k(E, g) (s_eq(E, g) - s)             structure: built by the field, broken by shear (a Mason-like number)
    tau_y = strength 1.313 X^1.5 tanh(sqrt X), X = E / E_c

The field of a clutch that is off comes to exactly zero, where what costs most need not be worked out.
"""

from __future__ import annotations

import math

from erclutch.wings.rig.twin.integrate import toward
from erclutch.wings.rig.twin.jit import compiled
from erclutch.wings.rig.twin.part_parameters import LEAST_RATIO, Fluid

_REFERENCE_FIELD = 2.0e6  # V/m: 2000 V over 1 mm, where the rates of default.toml hold


@compiled
def yield_stress(field: float, strength: float, fluid: Fluid) -> float:
    """Yield stress of fully built chains in Pa."""
    if field == 0.0:
        return 0.0
    root = math.sqrt(field * (1.0 / fluid.critical_field))
    tanh = 1.0 - 2.0 / (math.exp(2.0 * root) + 1.0)
    return strength * 1.313 * root * root * root * tanh


@compiled
def structure_rates(field: float, fluid: Fluid) -> tuple[float, float]:
    """Rate at which structure builds and decays at rest [1/s], and the shear rate that halves it [1/s]."""
    ratio = field / _REFERENCE_FIELD
    building = ratio * ratio / fluid.building_time + 1.0 / fluid.decay_time
    if field == 0.0:
        return building, fluid.idle_breaking
    return building, fluid.breaking_rate * (ratio + LEAST_RATIO) ** fluid.breaking_exponent


@compiled
def structure_after(
    s: float,
    rate: float,
    halving: float,
    shear: float,
    fluid: Fluid,
    dt: float,
) -> float:
    """Structure one step later, under a shear rate at the step's middle."""
    size = abs(shear)
    return toward(
        s, halving / (halving + size), (rate + size * (1.0 / fluid.rearranging_strain)) * dt
    )


@compiled
def strain_after(
    z: float,
    shear: float,
    fluid: Fluid,
    dt: float,
) -> float:
    """Strain of the chains one step later, under a shear rate at the step's middle."""
    size = abs(shear)
    return toward(
        z, math.copysign(fluid.yield_strain, shear), size * (1.0 / fluid.yield_strain) * dt
    )


@compiled
def viscosity(
    shear: float,
    s: float,
    field: float,
    warm: float,
    fluid: Fluid,
) -> float:
    """Viscosity in Pa s: thins with rate, thickens with field and structure; ``warm`` is its share left by heat."""
    thin = 1.0 + fluid.thinning / (1.0 + abs(shear) * (1.0 / fluid.thinning_rate))
    return (
        fluid.viscosity
        * warm
        * thin
        * (1.0 + fluid.field_thickening * field * (1.0 / _REFERENCE_FIELD) * s)
    )

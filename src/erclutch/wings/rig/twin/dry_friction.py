"""Dry friction of a bearing, gear, seal or screw is elastic at first, then slides (LuGre without its viscous terms).

    F = k z,   z' = v - |v| z / z_s(v),   k = F_c / presliding,
    z_s = presliding (1 + (breakaway - 1) exp(-(v / v_s)^2))

Steady sliding has F = k z_s: F_c when fast, breakaway F_c when slow. Stored energy is k z^2 / 2, so what is left,
k |v| z^2 / z_s, is dissipated and never negative.
"""

from __future__ import annotations

import math

from erclutch.wings.rig.twin.integrate import toward
from erclutch.wings.rig.twin.jit import compiled


@compiled
def stribeck(speed: float, breakaway: float, stribeck_speed: float) -> float:
    """Friction of steady sliding over Coulomb friction: ``breakaway`` at rest, 1 when fast."""
    ratio = speed / stribeck_speed
    squared = ratio * ratio
    # exp(-40) is less than rounding.
    return 1.0 + (breakaway - 1.0) * math.exp(-squared) if squared < 40.0 else 1.0


@compiled
def bristle_after(
    z: float,
    speed: float,
    limit: float,
    dt: float,
) -> tuple[float, float]:
    """Deflection one step later, for a speed at the step's middle, and the energy lost meanwhile over the stiffness.

    ``limit`` is the deflection of steady sliding, above 0.
    """
    share = abs(speed) / limit * dt
    after = toward(z, math.copysign(limit, speed), share)
    return after, 0.5 * (z * z + after * after) * share

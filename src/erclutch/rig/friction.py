"""Dry friction of a bearing, gear, seal or screw: elastic at first, then sliding (LuGre without its viscous terms).

    F = k z,   z' = v - |v| z / z_s(v),   z_s = F_s(v) / k,   F_s = F_c + (F_b - F_c) exp(-(v / v_s)^2)

k = F_c / presliding. Stored energy is k z^2 / 2, so what is left, k |v| z^2 / z_s, is dissipated and never negative.
"""

from __future__ import annotations

import math

from erclutch.rig.compiled import compiled
from erclutch.rig.integrate import toward


@compiled
def sliding_force(speed: float, coulomb: float, breakaway: float, stribeck_speed: float) -> float:
    """Friction of steady sliding, F_s."""
    ratio = speed / stribeck_speed
    return coulomb + (breakaway - coulomb) * math.exp(-ratio * ratio)


@compiled
def bristle_after(z: float, speed: float, sliding: float, stiffness: float, dt: float) -> float:
    """Deflection one step later, for a speed at the step's middle."""
    if speed == 0.0 or stiffness == 0.0:
        return z
    limit = sliding / stiffness
    return toward(z, math.copysign(limit, speed), abs(speed) / limit * dt) if limit > 0.0 else 0.0

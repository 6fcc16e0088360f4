"""The energy that the TWIN's parts store: kinetic and elastic."""

from __future__ import annotations

import numpy as np

from erclutch.wings.rig.twin import kernel as k
from erclutch.wings.rig.twin.fluid import yield_stress
from erclutch.wings.rig.twin.part_parameters import POINTS, Parts


def stored(x: np.ndarray, parts: Parts, before: np.ndarray) -> float:
    """Kinetic and elastic energy in J; ``before`` holds the speeds of half a step ago."""
    drive, screw, fluid = parts.drive, parts.screw, parts.fluid
    # The mean of both halves of a step: speeds stand half a step beside positions.
    total = 0.25 * drive.inertia * (x[k.OMEGA] ** 2 + before[0] ** 2)
    total += 0.25 * screw.rotor_inertia * (x[k.OMEGA_R] ** 2 + before[1] ** 2)
    total += 0.25 * screw.load_inertia * (x[k.OMEGA_L] ** 2 + before[2] ** 2)

    twist = x[k.PHI_R] - x[k.PHI_L]
    total += 0.5 * screw.stiffness * twist**2
    half_stroke = screw.half_stroke / screw.lead * 2.0 * np.pi  # rad
    beyond = max(abs(x[k.PHI_L]) - half_stroke, 0.0)
    total += 0.5 * screw.stop_stiffness * beyond**2

    # Bristles of dry friction, and the seals.
    total += 0.5 * drive.coulomb / drive.presliding * x[k.BRISTLE_IN] ** 2
    total += 0.5 * screw.coulomb / screw.presliding * x[k.BRISTLE_L] ** 2
    for channel in range(2):
        clutch = parts.clutch_1 if channel == 0 else parts.clutch_2
        total += 0.5 * clutch.seal / clutch.seal_slip * x[k.SEAL_1 + channel] ** 2

    # Chains of the fluid, point by point of both gaps.
    gaps = parts.gaps
    residual = fluid.residual_yield / fluid.yield_strain  # Pa, of chains without a field
    temperature = parts.thermal.room + x[k.WARMTH]
    firm = np.exp(-parts.thermal.softening * temperature)
    for point in range(gaps.arm.size):
        first = point < POINTS
        clutch = parts.clutch_1 if first else parts.clutch_2
        field = x[k.FIELD_1] if first else x[k.FIELD_2]
        stiffness = yield_stress(field, firm * clutch.strength, fluid) / fluid.yield_strain
        modulus = stiffness * x[k.STRUCTURE + point] + residual
        total += 0.5 * gaps.volume[point] * modulus * x[k.STRAIN + point] ** 2
    return total

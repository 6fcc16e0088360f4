"""The energy that the TWIN's parts store: kinetic and elastic."""

from __future__ import annotations

import numpy as np

from erclutch.wings.rig.twin import kernel as k
from erclutch.wings.rig.twin.fluid import yield_stress
from erclutch.wings.rig.twin.part_parameters import POINTS, Parts


def stored(x: np.ndarray, parts: Parts, before: np.ndarray) -> float:
    """Kinetic and elastic energy in J; ``before`` holds the speeds of half a step ago."""
    drive, screw, fluid = parts.drive, parts.screw, parts.fluid
    total = 0.25 * drive.inertia * (x[k.OMEGA] ** 2 + before[0] ** 2)
    total += 0.25 * screw.rotor_inertia * (x[k.OMEGA_R] ** 2 + before[1] ** 2)
    total += 0.25 * screw.load_inertia * (x[k.OMEGA_L] ** 2 + before[2] ** 2)
    total += 0.5 * screw.stiffness * (x[k.PHI_R] - x[k.PHI_L]) ** 2
    beyond = max(abs(x[k.PHI_L]) - screw.half_stroke / screw.lead * 2.0 * np.pi, 0.0)
    total += 0.5 * screw.stop_stiffness * beyond**2
    total += 0.5 * drive.coulomb / drive.presliding * x[k.BRISTLE_IN] ** 2
    total += 0.5 * screw.coulomb / screw.presliding * x[k.BRISTLE_L] ** 2
    for channel in range(2):
        clutch = parts.clutch_1 if channel == 0 else parts.clutch_2
        total += 0.5 * clutch.seal / clutch.seal_slip * x[k.SEAL_1 + channel] ** 2
    gaps = parts.gaps
    residual = fluid.residual_yield / fluid.yield_strain
    firm = np.exp(-parts.thermal.softening * (parts.thermal.room + x[k.WARMTH]))
    for i in range(gaps.arm.size):
        first = i < POINTS
        strength = firm * (parts.clutch_1.strength if first else parts.clutch_2.strength)
        stiffness = yield_stress(x[k.FIELD_1] if first else x[k.FIELD_2], strength, fluid) / fluid.yield_strain
        total += 0.5 * gaps.volume[i] * (stiffness * x[k.STRUCTURE + i] + residual) * x[k.STRAIN + i] ** 2
    return total

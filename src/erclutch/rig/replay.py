"""The twin driven by the commands of a log, from a measured start."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from erclutch.rig.compiled import compiled
from erclutch.rig.fluid import structure_rates
from erclutch.rig.kernel import (
    FIELD_1,
    METER_A,
    METER_B,
    MOTOR,
    OMEGA,
    OMEGA_L,
    OMEGA_R,
    PHI_L,
    PHI_R,
    SIZE,
    STRAIN,
    STRUCTURE,
    TABLE,
    THETA,
    VOLT_1,
    advance,
)
from erclutch.rig.parts import POINTS, Parts

Array = NDArray[np.float64]


@compiled
def _settled(x: Array, parts: Parts, field: float, motor: float, torque: float) -> None:
    """Inner states as after a while under constant commands and speeds: a guess that the first rows wash out."""
    for channel in range(2):
        wanted = max(field, 0.0) if channel == 0 else max(-field, 0.0)
        voltage = min(wanted, parts.supply.command_limit) / parts.supply.command_limit * parts.supply.voltage_limit
        x[VOLT_1 + channel] = voltage
        x[FIELD_1 + channel] = voltage / parts.clutch_1.gap
        _, halving = structure_rates(x[FIELD_1 + channel], parts.fluid)
        for i in range(channel * POINTS, channel * POINTS + POINTS):
            slip = parts.gaps.way[i] * x[OMEGA] - x[OMEGA_R]
            shear = slip * parts.gaps.arm[i]
            x[STRUCTURE + i] = halving / (halving + abs(shear))
            x[STRAIN + i] = math.copysign(parts.fluid.yield_strain, shear) if abs(slip) > 1.0 else 0.0
    x[MOTOR] = motor
    x[METER_A] = torque
    x[METER_B] = torque


@compiled
def follow(
    parts: Parts,
    field: Array,
    motor: Array,
    theta: float,
    alpha: float,
    theta_dot: float,
    alpha_dot: float,
    torque: float,
    dt: float,
    steps: int,
) -> Array:
    """Run the twin under a log's commands.

    Args:
        parts: of the rig.
        field: signed field commands E1 - E2, shape (n,).
        motor: motor torque in N m, shape (n,).
        theta: measured angle of the motor at the start in rad.
        alpha: of the output.
        theta_dot: measured speed of the motor there in rad/s.
        alpha_dot: of the output.
        torque: measured torque there in N m.
        dt: internal step in s.
        steps: how many make a row.

    Returns:
        theta, alpha and the metered torque without noise, as sampled, shape (n, 3).
    """
    x = np.zeros(SIZE)
    x[THETA], x[OMEGA] = theta, theta_dot
    x[PHI_L], x[OMEGA_L], x[OMEGA_R], x[TABLE] = (
        alpha,
        alpha_dot,
        alpha_dot,
        alpha * parts.screw.lead / 6.283185307179586,
    )
    x[PHI_R] = alpha + torque / parts.screw.stiffness
    _settled(x, parts, field[0], motor[0], torque)
    out = np.empty((field.size, 3))
    turn = 2.0 * math.pi / parts.screw.lead
    for k in range(field.size):
        out[k, 0], out[k, 1], out[k, 2] = x[THETA], x[TABLE] * turn, x[METER_B]
        advance(x, parts, max(field[k], 0.0), max(-field[k], 0.0), motor[k], False, dt, steps)
    return out

"""The twin follows the commands of a log from a measured start."""

from __future__ import annotations

import math

import numpy as np

from erclutch.signals.array import Array
from erclutch.wings.rig.twin import kernel as k
from erclutch.wings.rig.twin.fluid import structure_rates
from erclutch.wings.rig.twin.jit import compiled
from erclutch.wings.rig.twin.part_parameters import POINTS, Parts


@compiled
def follow(
    parts: Parts,
    field: Array,
    motor: Array,
    start: Array,
    dt: float,
    steps: int,
) -> Array:
    """Run the twin under a log's commands.

    Args:
        parts: of the rig.
        field: signed field commands E1 - E2, shape (n,).
        motor: motor torque in N m, shape (n,).
        start: what was measured at the start: angles of the motor and the output in rad, their speeds in rad/s, and the
            torque in N m, shape (5,).
        dt: internal step in s.
        steps: how many make a row.

    Returns:
        theta, alpha and the metered torque without noise, as sampled, shape (n, 3).
    """
    theta, alpha, theta_dot, alpha_dot, torque = start
    x = np.zeros(k.SIZE)
    x[k.THETA] = theta
    x[k.OMEGA] = theta_dot
    x[k.PHI_L] = alpha
    x[k.OMEGA_L] = alpha_dot
    x[k.OMEGA_R] = alpha_dot
    x[k.TABLE] = alpha * parts.screw.lead / 6.283185307179586
    x[k.PHI_R] = alpha + torque / parts.screw.stiffness

    # Inner states as after a while under constant commands and speeds: a guess that the first rows wash out.
    for channel in range(2):
        wanted = max(field[0], 0.0) if channel == 0 else max(-field[0], 0.0)
        command = min(wanted, parts.supply.command_limit)
        voltage = command / parts.supply.command_limit * parts.supply.voltage_limit
        x[k.VOLT_1 + channel] = voltage
        for at in (k.FIELD_1, k.PROMPT_1, k.RESIDUE_1):
            x[at + channel] = voltage / parts.clutch_1.gap
        _, halving = structure_rates(x[k.FIELD_1 + channel], parts.fluid)
        for point in range(channel * POINTS, channel * POINTS + POINTS):
            slip = parts.gaps.way[point] * x[k.OMEGA] - x[k.OMEGA_R]
            shear = slip * parts.gaps.arm[point]
            x[k.STRUCTURE + point] = halving / (halving + abs(shear))
            x[k.STRAIN + point] = 0.0
            if abs(slip) > 1.0:
                x[k.STRAIN + point] = math.copysign(parts.fluid.yield_strain, shear)
    x[k.MOTOR] = motor[0]
    x[k.METER_A] = torque
    x[k.METER_B] = torque

    out = np.empty((field.size, 3))
    turn = 2.0 * math.pi / parts.screw.lead
    for i in range(field.size):
        out[i, 0] = x[k.THETA]
        out[i, 1] = x[k.TABLE] * turn
        out[i, 2] = x[k.METER_B]
        first = max(field[i], 0.0)
        second = max(-field[i], 0.0)
        k.advance(x, parts, first, second, motor[i], False, dt, steps)
    return out

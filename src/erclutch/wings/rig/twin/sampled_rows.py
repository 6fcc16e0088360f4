"""The compiled rig runs at its controller's rate: sense, command, step, row after row.

Columns of a log, in the order of `LOGGED`, and the true states beside it, in the order of `TRUE`.
"""

from __future__ import annotations

import math

from erclutch.signals.array import Array
from erclutch.wings.rig.twin import kernel as k
from erclutch.wings.rig.twin.jit import compiled
from erclutch.wings.rig.twin.part_parameters import Parts
from erclutch.wings.rig.twin.supply import interlocked

#: What a rig logs: name, unit.
LOGGED = (
    ("E1", ""),
    ("E2", ""),
    ("motor_torque", "N*m"),
    ("theta", "rad"),
    ("table", "m"),
    ("alpha_rotary", "rad"),
    ("T", "N*m"),
)
#: What only a twin knows: name, unit.
TRUE = (
    ("true_theta_dot", "rad/s"),
    ("true_alpha_dot", "rad/s"),
    ("true_rotor_speed", "rad/s"),
    ("true_torque", "N*m"),
    ("true_motor_torque", "N*m"),
    ("true_field_1", "V/m"),
    ("true_field_2", "V/m"),
    ("true_warming", "K"),
)


@compiled
def sense(
    x: Array,
    parts: Parts,
    noise: float,
    row: Array,
) -> None:
    """What the sensors read: theta, table position, output shaft's angle, torque; into row[3:7]."""
    sensors = parts.sensors
    turn = 2.0 * math.pi
    row[3] = math.floor(x[k.THETA] / turn * sensors.motor_counts) / sensors.motor_counts * turn
    row[4] = math.floor(x[k.TABLE] / sensors.table_step) * sensors.table_step
    row[5] = math.floor(x[k.PHI_R] / turn * sensors.rotary_counts) / sensors.rotary_counts * turn
    torque = x[k.METER_B] + noise * sensors.torque_noise
    if sensors.torque_step > 0.0:
        torque = math.floor(torque / sensors.torque_step + 0.5) * sensors.torque_step
    row[6] = torque


@compiled
def true_states(x: Array, row: Array) -> None:
    """What only the twin knows, into row[0:8]."""
    row[0] = x[k.OMEGA]
    row[1] = x[k.OMEGA_L]
    row[2] = x[k.OMEGA_R]
    row[3] = x[k.TORQUE]
    row[4] = x[k.MOTOR]
    row[5] = x[k.FIELD_1]
    row[6] = x[k.FIELD_2]
    row[7] = x[k.WARMTH]


@compiled
def run_open(
    x: Array,
    parts: Parts,
    rows: Array,
    locked: bool,
    soft: float,
    guard: Array,
    dt: float,
    steps: int,
    out: Array,
) -> None:
    """Predefined commands. Beyond the soft stroke whole half-waves are mirrored, so that the table comes back.

    ``rows`` holds field, motor torque and noise, shape (n, 3); ``soft`` is in rad of the screw, 0 for no guard;
    ``guard`` is [mirrored now, last command] and is kept between calls; ``out`` gets LOGGED and TRUE, shape (n, 15).
    """
    for i in range(len(rows)):
        wanted = rows[i, 0]
        motor = rows[i, 1]
        noise = rows[i, 2]
        # A sequence changes sides, or steps, between half-waves: only there may its mirror begin or end.
        if wanted * guard[1] <= 0.0 or abs(wanted - guard[1]) > 0.1:
            place = x[k.PHI_L]
            outward = (place > soft and wanted > 0.0) or (place < -soft and wanted < 0.0)
            guard[0] = 1.0 if soft > 0.0 and outward else 0.0
        guard[1] = wanted
        if guard[0] > 0.5:
            wanted = -wanted
        first, second, _ = interlocked(max(wanted, 0.0), max(-wanted, 0.0))
        sense(x, parts, noise, out[i])
        true_states(x, out[i, 7:])
        out[i, 0] = first
        out[i, 1] = second
        out[i, 2] = motor
        k.advance(x, parts, first, second, motor, locked, dt, steps)


@compiled
def run_tracking(
    x: Array,
    parts: Parts,
    rows: Array,
    gains: Array,
    memory: Array,
    dt: float,
    steps: int,
    out: Array,
) -> None:
    """Position tracking by the PD law of equation (23), with its split into E1 and E2.

    ``rows`` holds motor torque, noise, alpha_r and its speed, shape (n, 4); ``gains`` k_p and k_d; ``memory`` the last
    alpha, nan at first; ``out`` gets LOGGED and TRUE, shape (n, 15).
    """
    period = dt * steps
    for i in range(len(rows)):
        motor = rows[i, 0]
        noise = rows[i, 1]
        sense(x, parts, noise, out[i])
        true_states(x, out[i, 7:])
        # Equation (23), the speed by a backward difference.
        alpha = out[i, 4] * 2.0 * math.pi / parts.screw.lead
        speed = 0.0 if math.isnan(memory[0]) else (alpha - memory[0]) / period
        memory[0] = alpha
        missing = rows[i, 2] - alpha
        missing_speed = rows[i, 3] - speed
        wanted = gains[0] * missing + gains[1] * missing_speed
        wanted = min(max(wanted, -parts.supply.command_limit), parts.supply.command_limit)
        first = max(wanted, 0.0)
        second = max(-wanted, 0.0)
        out[i, 0] = first
        out[i, 1] = second
        out[i, 2] = motor
        k.advance(x, parts, first, second, motor, False, dt, steps)

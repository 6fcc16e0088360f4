"""One internal step moves the whole rig: forces, then speeds half a step later, then positions and states.

Leapfrog: speeds live half a step behind positions and internal states. Elastic forces are explicit, viscous ones
implicit by the mean of the old and the new speed, internal states move under the speed in the middle of their step.
So the scheme is of second order, and the friction of sliding chains, seals and screw needs no special case at zero
speed.

Sign: + is the direction in which CH1 drives. Slips: w1 = omega - omega_r, w2 = -omega - omega_r.
"""

from __future__ import annotations

import math

from erclutch.signals.array import Array
from erclutch.wings.rig.twin.dry_friction import bristle_after, stribeck
from erclutch.wings.rig.twin.fluid import (
    strain_after,
    structure_after,
    structure_rates,
    viscosity,
    yield_stress,
)
from erclutch.wings.rig.twin.integrate import decay
from erclutch.wings.rig.twin.jit import compiled
from erclutch.wings.rig.twin.part_parameters import POINTS, Parts
from erclutch.wings.rig.twin.supply import voltage_after

# The state vector. Angles in rad, speeds in rad/s half a step behind them, the rest as named.
THETA = 0
OMEGA = 1
PHI_R = 2
OMEGA_R = 3
PHI_L = 4
OMEGA_L = 5
MOTOR = 6
VOLT_1 = 7
VOLT_2 = 8
FIELD_1 = 9
FIELD_2 = 10
BRISTLE_IN = 11
SEAL_1 = 12
SEAL_2 = 13
BRISTLE_L = 14
WARMTH = 15
METER_A = 16
METER_B = 17
TABLE = 18
# The ledger of energy in J: motor's work, field's work on strained chains, dissipation; and its smallest single term.
WORK = 19
FIELD_WORK = 20
DISSIPATED = 21
SMALLEST = 22
TORQUE = 23  # torque of the fluid and seals on the rotors, N m
# Fields by the supply alone, and what stays of them, in V/m.
PROMPT_1, PROMPT_2, RESIDUE_1, RESIDUE_2 = 24, 25, 26, 27
STIFF_1, STIFF_2 = 28, 29  # stiffness of fully built chains at the present fields, Pa
# A number a point of gap 1, then of gap 2, in rows of one length. A compiler does eight points at once only where rows
# are whole vectors apart; where they are ten numbers apart it does two, and the simulation takes 6 % longer.
ROW = 16
STRUCTURE = 32  # of the chains
STRAIN = STRUCTURE + ROW
SCRATCH = STRAIN + ROW  # two rows
SIZE = SCRATCH + 2 * ROW

# Loops over the points of both gaps write no sums, so that the compiler does several points at once; the sums follow in
# a fixed order, so that every machine gets the same ones.


@compiled
def gap_torques(
    x: Array,
    omega: float,
    omega_r: float,
    warm: float,
    parts: Parts,
) -> tuple[float, ...]:
    """Torque of the strained chains of gap 1 and 2, and of viscosity per slip."""
    gaps = parts.gaps
    fluid = parts.fluid
    residual = fluid.residual_yield * (1.0 / fluid.yield_strain)
    field_1 = x[FIELD_1]
    field_2 = x[FIELD_2]
    stiff_1 = x[STIFF_1]
    stiff_2 = x[STIFF_2]
    for i in range(gaps.arm.size):
        stiffness = stiff_1 if i < POINTS else stiff_2
        field = field_1 if i < POINTS else field_2
        s = x[STRUCTURE + i]
        shear = (gaps.way[i] * omega - omega_r) * gaps.arm[i]
        eta = viscosity(shear, s, field, warm, fluid)
        x[SCRATCH + i] = gaps.weight[i] * (stiffness * s + residual) * x[STRAIN + i]
        x[SCRATCH + ROW + i] = gaps.thick[i] * eta
    chains_1 = 0.0
    chains_2 = 0.0
    thick_1 = 0.0
    thick_2 = 0.0
    for i in range(SCRATCH, SCRATCH + POINTS):
        chains_1 += x[i]
        chains_2 += x[i + POINTS]
        thick_1 += x[i + ROW]
        thick_2 += x[i + ROW + POINTS]
    return chains_1, chains_2, thick_1, thick_2


@compiled
def _gaps_after(
    x: Array,
    omega: float,
    omega_r: float,
    before_1: float,
    before_2: float,
    firm: float,
    parts: Parts,
    dt: float,
) -> None:
    """Structure and strain one step later, and their entries in the ledger."""
    gaps = parts.gaps
    fluid = parts.fluid
    rate_1, halving_1 = structure_rates(0.5 * (before_1 + x[FIELD_1]), fluid)
    rate_2, halving_2 = structure_rates(0.5 * (before_2 + x[FIELD_2]), fluid)
    per_strain = 1.0 / fluid.yield_strain
    full = firm * per_strain
    soft_1 = x[STIFF_1]
    soft_2 = x[STIFF_2]
    stiff_1 = yield_stress(x[FIELD_1], parts.clutch_1.strength, fluid) * full
    stiff_2 = yield_stress(x[FIELD_2], parts.clutch_2.strength, fluid) * full
    x[STIFF_1] = stiff_1
    x[STIFF_2] = stiff_2
    residual = fluid.residual_yield * per_strain
    for i in range(gaps.arm.size):
        first = i < POINTS
        rate = rate_1 if first else rate_2
        halving = halving_1 if first else halving_2
        shear = (gaps.way[i] * omega - omega_r) * gaps.arm[i]
        s = x[STRUCTURE + i]
        z = x[STRAIN + i]
        s_new = structure_after(s, rate, halving, shear, fluid, dt)
        z_new = strain_after(z, shear, fluid, dt)
        x[STRUCTURE + i] = s_new
        x[STRAIN + i] = z_new
        # Energy of the chains: what the field's change adds, and what yields.
        soft = (soft_1 if first else soft_2) * s + residual
        stiff = (stiff_1 if first else stiff_2) * s_new + residual
        squared = 0.5 * gaps.volume[i] * (z * z + z_new * z_new)
        x[SCRATCH + i] = 0.5 * squared * (stiff - soft)
        x[SCRATCH + ROW + i] = 0.5 * (soft + stiff) * squared * abs(shear) * per_strain * dt
    gained = 0.0
    lost = 0.0
    smallest = x[SMALLEST]
    for i in range(SCRATCH, SCRATCH + 2 * POINTS):
        gained += x[i]
        lost += x[i + ROW]
        smallest = min(smallest, x[i + ROW])
    x[FIELD_WORK] += gained
    x[DISSIPATED] += lost
    x[SMALLEST] = smallest


@compiled
def _dry(
    x: Array,
    at: int,
    speed: float,
    limit: float,
    stiffness: float,
    dt: float,
) -> None:
    """A bristle one step later, and its entry in the ledger."""
    x[at], lost = bristle_after(x[at], speed, limit, dt)
    x[DISSIPATED] += stiffness * lost
    x[SMALLEST] = min(x[SMALLEST], stiffness * lost)


@compiled
def _speeds_after(
    x: Array,
    parts: Parts,
    warm: float,
    locked: bool,
    dt: float,
) -> None:
    """New speeds from the forces at this time; work and viscous losses into the ledger."""
    drive = parts.drive
    screw = parts.screw
    # Torques of clutches, screw, end stop and motor.
    chains_1, chains_2, thick_1, thick_2 = gap_torques(x, x[OMEGA], x[OMEGA_R], warm, parts)
    pull_1 = chains_1 + parts.clutch_1.seal / parts.clutch_1.seal_slip * x[SEAL_1]
    pull_2 = chains_2 + parts.clutch_2.seal / parts.clutch_2.seal_slip * x[SEAL_2]
    twist = screw.stiffness * (x[PHI_R] - x[PHI_L])
    limit = screw.half_stroke / screw.lead * 2.0 * math.pi
    beyond = max(abs(x[PHI_L]) - limit, 0.0)
    stop = math.copysign(screw.stop_stiffness * beyond, x[PHI_L])
    drag = screw.viscous + (screw.stop_damping if beyond > 0.0 else 0.0)
    ripple = math.sin(8.0 * x[THETA]) + 0.4 * math.sin(24.0 * x[THETA] + 1.0)
    motor = x[MOTOR] * (1.0 + drive.ripple * ripple)

    # (2 J / dt + K) v = force + 2 J / dt v_old for the mean speeds v, K tridiagonal and symmetric.
    j_in = 2.0 * drive.inertia / dt
    j_r = 2.0 * screw.rotor_inertia / dt
    j_l = 2.0 * screw.load_inertia / dt
    f_in = (
        motor - drive.coulomb / drive.presliding * x[BRISTLE_IN] - pull_1 + pull_2 + j_in * x[OMEGA]
    )
    f_r = pull_1 + pull_2 - twist + j_r * x[OMEGA_R]
    f_l = twist - screw.coulomb / screw.presliding * x[BRISTLE_L] - stop + j_l * x[OMEGA_L]
    across = thick_2 - thick_1
    d_in = j_in + drive.viscous + thick_1 + thick_2
    d_r = j_r + thick_1 + thick_2 + screw.damping
    d_l = j_l + screw.damping + drag
    d_r -= across * across / d_in
    f_r -= across / d_in * f_in
    if locked:  # the output keeps the speed that it has: 0, or what a hand gives it
        v_l = x[OMEGA_L]
        v_r = (f_r + screw.damping * v_l) / d_r
    else:
        d_l -= screw.damping * screw.damping / d_r
        v_l = (f_l + screw.damping / d_r * f_r) / d_l
        v_r = (f_r + screw.damping * v_l) / d_r
    v_in = (f_in - across * v_r) / d_in
    x[OMEGA] = 2.0 * v_in - x[OMEGA]
    x[OMEGA_R] = 2.0 * v_r - x[OMEGA_R]
    x[OMEGA_L] = v_l if locked else 2.0 * v_l - x[OMEGA_L]

    # The torque on the rotors, and the ledger.
    w_1 = v_in - v_r
    w_2 = -v_in - v_r
    x[TORQUE] = pull_1 + pull_2 + thick_1 * w_1 + thick_2 * w_2
    x[WORK] += motor * v_in * dt
    lost = thick_1 * w_1 * w_1 + thick_2 * w_2 * w_2 + drive.viscous * v_in * v_in
    lost += screw.damping * (v_r - v_l) * (v_r - v_l) + drag * v_l * v_l
    x[DISSIPATED] += lost * dt

    # The torque meter: two first-order stages.
    felt = twist + screw.damping * (v_r - v_l)
    share = 1.0 - decay(2.0 * math.pi * parts.sensors.torque_bandwidth * dt)
    x[METER_A] += share * (felt - x[METER_A])
    x[METER_B] += share * (x[METER_A] - x[METER_B])


@compiled
def _states_after(
    x: Array,
    parts: Parts,
    first: float,
    second: float,
    motor: float,
    firm: float,
    dt: float,
) -> None:
    """Positions and internal states under the new speeds."""
    drive = parts.drive
    screw = parts.screw
    omega = x[OMEGA]
    omega_r = x[OMEGA_R]
    omega_l = x[OMEGA_L]
    lost = x[DISSIPATED]
    field_1 = x[FIELD_1]
    field_2 = x[FIELD_2]

    # Voltages and fields in the gaps.
    share = 1.0 - decay(dt / parts.fluid.polarisation)
    stays = 1.0 - decay(dt / parts.fluid.residual_time)
    for channel in range(2):
        command = first if channel == 0 else second
        voltage = voltage_after(x[VOLT_1 + channel], command, parts.supply, dt)
        middle = 0.5 * (voltage + x[VOLT_1 + channel])
        x[VOLT_1 + channel] = voltage
        prompt = x[PROMPT_1 + channel] + share * (
            middle / parts.clutch_1.gap - x[PROMPT_1 + channel]
        )
        prompt = prompt if prompt > 1.0 else 0.0  # below 1 V/m it is off
        x[PROMPT_1 + channel] = prompt
        x[RESIDUE_1 + channel] += stays * (prompt - x[RESIDUE_1 + channel])
        field = prompt + parts.fluid.residual_field * (x[RESIDUE_1 + channel] - prompt)
        x[FIELD_1 + channel] = field if field > 1.0 else 0.0

    _gaps_after(x, omega, omega_r, field_1, field_2, firm, parts, dt)
    for channel in range(2):
        clutch = parts.clutch_1 if channel == 0 else parts.clutch_2
        slip = (omega if channel == 0 else -omega) - omega_r
        _dry(x, SEAL_1 + channel, slip, clutch.seal_slip, clutch.seal / clutch.seal_slip, dt)
    # What the fluid and the seals lost in this step, and the leakage of the supply, warm the fluid.
    electric = x[VOLT_1] ** 2 / parts.supply.leakage_1 + x[VOLT_2] ** 2 / parts.supply.leakage_2
    heat = (x[DISSIPATED] - lost) / dt + electric
    x[WARMTH] += dt * (heat - parts.thermal.loss * x[WARMTH]) / parts.thermal.capacity
    limit = drive.presliding * stribeck(omega, drive.breakaway, drive.stribeck_speed)
    _dry(x, BRISTLE_IN, omega, limit, drive.coulomb / drive.presliding, dt)
    # Deflection of the screw's bristles in steady sliding: Stribeck, direction and place.
    sliding = screw.presliding * stribeck(omega_l, screw.breakaway, screw.stribeck_speed)
    wave = math.sin(x[PHI_L]) + 0.5 * math.sin(7.3 * x[PHI_L] + 0.7)
    along = 1.0 + screw.waviness * wave
    way = 1.0 + screw.asymmetry if omega_l > 0.0 else 1.0 - screw.asymmetry
    _dry(x, BRISTLE_L, omega_l, sliding * along * way, screw.coulomb / screw.presliding, dt)
    wanted = min(max(motor, -drive.torque_limit), drive.torque_limit)
    x[MOTOR] += (wanted - x[MOTOR]) * (1.0 - decay(dt / drive.torque_time))
    x[THETA] += dt * omega
    x[PHI_R] += dt * omega_r
    x[PHI_L] += dt * omega_l
    # The table goes along once the backlash is taken up.
    place = x[PHI_L] * screw.lead / (2.0 * math.pi)
    lowest = place - 0.5 * screw.backlash
    highest = place + 0.5 * screw.backlash
    x[TABLE] = min(max(x[TABLE], lowest), highest)


@compiled
def advance(
    x: Array,
    parts: Parts,
    first: float,
    second: float,
    motor: float,
    locked: bool,
    dt: float,
    steps: int,
) -> None:
    """Advance the state by ``steps`` internal steps under constant commands. Changes ``x``."""
    above = parts.thermal.room + x[WARMTH]  # the reference temperature; slow: once a call will do
    warm = math.exp(-parts.thermal.thinning * above)
    firm = math.exp(-parts.thermal.softening * above)
    for _ in range(steps):
        _speeds_after(x, parts, warm, locked, dt)
        _states_after(x, parts, first, second, motor, firm, dt)

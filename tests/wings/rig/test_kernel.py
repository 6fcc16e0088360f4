"""The twin's physics against closed forms, its step against half of it, and its energy against itself."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from erclutch.wings.rig.twin import kernel as k
from erclutch.wings.rig.twin.excitation import FieldSettings, field_sequence, torque_sequence
from erclutch.wings.rig.twin.fluid import (
    strain_after,
    structure_after,
    structure_rates,
    yield_stress,
)
from erclutch.wings.rig.twin.parameters import RigParameters, default_rig, load_rig
from erclutch.wings.rig.twin.part_parameters import POINTS, Parts, parts_of
from tests.support.twin_energy import stored

SETS = sorted((Path(__file__).parents[3] / "examples" / "rigs").glob("*.toml"))
STEP = default_rig().value("integration.step")


def run(
    parts: Parts, seconds: float, step: float, seed: int = 0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Torque meter each ms, the last state, and the speeds half a step before it."""
    rng = np.random.default_rng(seed)
    rows = round(seconds * 1000)
    fields, motor = field_sequence(rows, rng, FieldSettings()), torque_sequence(rows, rng)
    x = np.zeros(k.SIZE)
    x[k.OMEGA] = 40.0
    torque, steps = np.empty(rows), round(1e-3 / step)
    before = x[[k.OMEGA, k.OMEGA_R, k.OMEGA_L]]
    for i in range(rows):
        k.advance(
            x, parts, max(fields[i], 0.0), max(-fields[i], 0.0), motor[i], False, step, steps - 1
        )
        before = x[[k.OMEGA, k.OMEGA_R, k.OMEGA_L]]
        k.advance(x, parts, max(fields[i], 0.0), max(-fields[i], 0.0), motor[i], False, step, 1)
        torque[i] = x[k.METER_B]
    return torque, x, before


@pytest.mark.slow
def test_halving_the_step_changes_the_torque_by_less_than_one_percent() -> None:
    parts = parts_of(default_rig())
    whole, half, quarter = (run(parts, 8.0, STEP / n)[0] for n in (1, 2, 4))

    def off(a: np.ndarray, b: np.ndarray) -> float:
        return float(np.sqrt(np.mean((a - b) ** 2) / np.mean(b**2)))

    assert off(whole, half) < 0.01
    assert off(half, quarter) < 0.5 * off(whole, half)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(
    "changes", [{}, {"fluid.residual_field": 0.1, "thermal.softening": 0.01, "thermal.room": 20.0}]
)
def test_energy_is_accounted_for_and_no_loss_is_negative(
    seed: int, changes: dict[str, float]
) -> None:
    energy_closes(default_rig().changed(changes), seed)


@pytest.mark.slow
@pytest.mark.parametrize("path", SETS, ids=lambda path: path.stem)
def test_further_sets_close_their_energy_and_meet_table_i(path: Path) -> None:
    rig = load_rig(path)
    energy_closes(rig, 1)
    for channel in (0, 1):
        assert held(0.05, 0.5, channel, {}, rig) == pytest.approx(
            rig.value(f"clutch.rated_torque_{channel + 1}"), rel=0.01
        )
    for section, names in rig.entries.items():
        for key, entry in names.items():
            assert entry.low <= entry.value <= entry.high, f"{section}.{key}"
            assert entry.meaning == default_rig().entry(f"{section}.{key}").meaning


def energy_closes(rig: RigParameters, seed: int) -> None:
    """The ledger of a run holds all that the parts store and lose."""
    parts = parts_of(rig)
    _, x, before = run(parts, 5.0, STEP, seed)
    start = 0.5 * parts.drive.inertia * 40.0**2
    gained = stored(x, parts, before) - start
    assert x[k.WORK] + x[k.FIELD_WORK] - x[k.DISSIPATED] - gained == pytest.approx(
        0.0, abs=2e-3 * x[k.WORK]
    )
    assert x[k.SMALLEST] >= 0.0
    assert x[k.DISSIPATED] > 0.0


def held(
    slip: float,
    command: float,
    channel: int,
    changes: dict[str, float],
    rig: RigParameters | None = None,
) -> float:
    """Torque of one clutch at a constant slip, once it is steady: rotor held, housing driven at a speed."""
    parts = parts_of(
        (rig or default_rig()).changed({"clutch.seal_1": 0.0, "clutch.seal_2": 0.0, **changes})
    )
    clutch = parts.clutch_1 if channel == 0 else parts.clutch_2
    field = command / parts.supply.command_limit * parts.supply.voltage_limit / clutch.gap
    torque, rate = 0.0, structure_rates(field, parts.fluid)
    strength = yield_stress(field, clutch.strength, parts.fluid)
    for i in range(POINTS):
        shear, s, z = slip * parts.gaps.arm[i], 0.0, 0.0
        for _ in range(200_000 if shear < 1.0 else 4000):
            s = structure_after(s, rate[0], rate[1], shear, parts.fluid, STEP)
            z = strain_after(z, shear, parts.fluid, STEP)
        torque += parts.gaps.weight[i] * strength * s * z / parts.fluid.yield_strain
    return torque


@pytest.mark.slow
@pytest.mark.parametrize(("channel", "rated"), [(0, "rated_torque_1"), (1, "rated_torque_2")])
def test_a_slow_fully_built_clutch_gives_its_rated_torque(channel: int, rated: str) -> None:
    """Table I at 2000 V, slow enough that shear breaks little of the structure."""
    wanted = default_rig().value(f"clutch.{rated}")
    assert held(0.05, 0.5, channel, {}) == pytest.approx(wanted, rel=0.01)


def test_the_disc_integral_of_a_bingham_fluid() -> None:
    """N [2 pi / 3 tau_y (r2^3 - r1^3) + pi eta w / (2 h) (r2^4 - r1^4)] with a constant yield stress and viscosity."""
    rig = default_rig()
    c, gaps = rig.section("clutch"), parts_of(rig).gaps
    tau, eta, w = 1500.0, 0.2, 12.0
    shear = w * gaps.arm[:POINTS]
    got = float(np.sum(gaps.weight[:POINTS] * (tau + eta * shear)))
    r1, r2, h, n = c["inner_radius"], c["outer_radius"], c["gap"], c["faces"]
    expected = n * (
        2 * math.pi / 3 * tau * (r2**3 - r1**3) + math.pi * eta * w / (2 * h) * (r2**4 - r1**4)
    )
    assert got == pytest.approx(expected, rel=1e-3)


@pytest.mark.slow
def test_torque_follows_a_step_of_the_field_within_milliseconds() -> None:
    """63 % of the final torque of a held output shaft, after a full step at a steady motor speed."""
    parts = parts_of(default_rig())
    x = np.zeros(k.SIZE)
    x[k.OMEGA] = 20.0
    k.advance(x, parts, 0.0, 0.0, 0.12, True, STEP, 200)
    rest = x[k.METER_B]
    trace = []
    for _ in range(60):
        k.advance(x, parts, 0.2, 0.0, 0.12, True, STEP, 10)
        trace.append(x[k.METER_B] - rest)
    rise = 0.5 * (1 + int(np.argmax(np.array(trace) > 0.632 * max(trace))))
    assert 1.0 <= rise <= 10.0


def braking(changes: dict[str, float], command: float) -> np.ndarray:
    """Torque meter each ms: 0.2 s with a field, 0.2 s without; the output is held, and nothing slows the motor down."""
    rig = default_rig().changed(
        {"drive.inertia": 1e3, "screw.coulomb": 0.0, "sensors.torque_bandwidth": 5000.0, **changes}
    )
    parts, x, trace = parts_of(rig), np.zeros(k.SIZE), np.empty(400)
    x[k.OMEGA] = 20.0
    for i in range(400):
        k.advance(x, parts, command if i < 200 else 0.0, 0.0, 0.0, True, STEP, 20)
        trace[i] = x[k.METER_B]
    return trace


@pytest.mark.slow
def test_a_warm_room_thins_the_liquid_and_softens_the_chains() -> None:
    """Viscosity and yield stress fall exponentially, each by its own parameter."""
    seals = {
        "clutch.seal_1": 0.0,
        "clutch.seal_2": 0.0,
        "fluid.residual_yield": 0.0,
        "clutch.viscosity_2": 0.5,
    }
    cold, hot, soft = (
        braking({**seals, "thermal.room": room, "thermal.softening": softening}, 0.3)
        for room, softening in ((-20.0, 0.0), (20.0, 0.0), (20.0, 0.01))
    )
    rate = default_rig().value("thermal.thinning")
    assert hot[-1] / cold[-1] == pytest.approx(
        math.exp(-40.0 * rate), rel=0.01
    )  # without a field the liquid alone
    yields = [trace[199] - trace[-1] for trace in (hot, soft)]
    assert yields[1] / yields[0] == pytest.approx(math.exp(-20.0 * 0.01), rel=0.02)
    assert (hot[199] - hot[-1]) == pytest.approx(
        cold[199] - cold[-1], rel=0.05
    )  # thickening of the liquid is small


def test_a_share_of_a_lasting_field_stays_and_fades() -> None:
    none, some = (
        braking(
            {"fluid.residual_field": share, "fluid.residual_time": 0.05, "fluid.decay_time": 1e-3},
            0.5,
        )
        for share in (0.0, 0.2)
    )
    left = some[230:] - none[230:]
    assert none[230] < 0.2 * none[199]
    assert left[0] > 0.01 * none[199]
    assert left[0] > 2.0 * left[50] > 8.0 * abs(left[150])


@pytest.mark.parametrize(("channel", "milliamperes"), [(1, 0.29), (2, 0.27)])
def test_leakage_current_of_table_1(channel: int, milliamperes: float) -> None:
    rig = default_rig()
    current = rig.value("supply.voltage_limit") / rig.value(f"supply.leakage_{channel}")
    assert 1e3 * current == pytest.approx(milliamperes, rel=0.01)


def test_a_locked_shaft_does_not_turn() -> None:
    parts = parts_of(default_rig())
    x = np.zeros(k.SIZE)
    k.advance(x, parts, 0.4, 0.0, 0.1, True, STEP, 20_000)
    assert x[k.OMEGA_L] == 0.0
    assert x[k.PHI_L] == 0.0
    assert abs(x[k.METER_B]) > 0.01


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_end_stop_pushes_back(side: float) -> None:
    parts = parts_of(default_rig())
    x = np.zeros(k.SIZE)
    x[[k.PHI_R, k.PHI_L]] = (
        side * 1.001 * parts.screw.half_stroke / parts.screw.lead * 2.0 * math.pi
    )
    k.advance(x, parts, 0.0, 0.0, 0.0, False, STEP, 1)
    assert side * x[k.OMEGA_L] < 0.0


def test_the_motor_gives_its_torque_and_no_more() -> None:
    """The first step from rest, where nothing has been strained yet: torque by time over inertia."""
    parts = parts_of(default_rig())
    x = np.zeros(k.SIZE)
    x[k.MOTOR] = 0.1
    k.advance(x, parts, 0.0, 0.0, 0.1, False, STEP, 1)
    torque = 0.1 * (1.0 + parts.drive.ripple * 0.4 * math.sin(1.0))
    assert x[k.OMEGA] == pytest.approx(torque * STEP / parts.drive.inertia, rel=0.05)


@pytest.mark.parametrize("channel", [0, 1])
def test_the_field_of_a_clutch_acts_in_its_own_gap(channel: int) -> None:
    parts = parts_of(default_rig())
    x = np.zeros(k.SIZE)
    x[k.STRUCTURE : k.STRUCTURE + 2 * POINTS] = 0.5
    *_, first, second = k.gap_torques(x, 20.0, 5.0, 1.0, parts)
    x[k.FIELD_1 + channel] = 2e6
    *_, first_on, second_on = k.gap_torques(x, 20.0, 5.0, 1.0, parts)
    assert (first_on != first, second_on != second) == (channel == 0, channel == 1)


def test_the_stored_energy_of_each_part_by_itself() -> None:
    parts, still = parts_of(default_rig()), np.zeros(3)

    def energy(**entries: float) -> float:
        x = np.zeros(k.SIZE)
        for name, value in entries.items():
            x[getattr(k, name)] = value
        return stored(x, parts, still)

    screw, drive, fluid, gaps = parts.screw, parts.drive, parts.fluid, parts.gaps
    assert energy(BRISTLE_IN=1e-3) == pytest.approx(0.5 * drive.coulomb / drive.presliding * 1e-6)
    assert energy(BRISTLE_L=1e-3) == pytest.approx(0.5 * screw.coulomb / screw.presliding * 1e-6)
    assert energy(PHI_R=1e-3) == pytest.approx(0.5 * screw.stiffness * 1e-6)
    for channel, strength in enumerate((parts.clutch_1.strength, parts.clutch_2.strength)):
        for i in (0, POINTS):
            x = np.zeros(k.SIZE)
            x[k.FIELD_1 + channel] = 2e6
            x[k.STRUCTURE + i], x[k.STRAIN + i] = 0.5, 1e-2
            own = yield_stress(2e6, strength, fluid) if (i == POINTS) == (channel == 1) else 0.0
            stiffness = (0.5 * own + fluid.residual_yield) / fluid.yield_strain
            assert stored(x, parts, still) == pytest.approx(0.5 * gaps.volume[i] * stiffness * 1e-4)

"""Roles that benches with two discs, three phases, two links and switched voltages give their columns. SYNTHETIC."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.logs.columns.phases import is_of_phases
from erclutch.logs.columns.seen_columns import seen_columns
from erclutch.signals.array import Array

TIME: Array = 0.002 * np.arange(1500, dtype=np.float64)
TURN = 2.0 * np.sin(7.0 * TIME)
SPEED = 14.0 * np.cos(7.0 * TIME)
CURRENT = np.where(TIME % 1.0 < 0.5, 0.2, 1.0)
TORQUE = (0.1 + 1.2 * CURRENT) * np.tanh(SPEED / 0.5) + 0.01 * SPEED
LOAD = 30.0 + 0.01 * np.sin(50.0 * TIME)


def planned(columns: Mapping[str, Array], units: Mapping[str, str] | None = None) -> Plan:
    named = {**(units or {})}
    table = Table(
        name="log.csv",
        columns=dict(columns),
        units={name: named.get(name) for name in columns},
        digest="0" * 64,
        path="log.csv",
    )
    return plan_of(table, ColumnMap())


def taken(plan: Plan, signal: str) -> str:
    choice = plan.signal(signal)
    return "" if choice is None else choice.column


@pytest.mark.parametrize(
    ("driving", "driven"),
    [
        ("Inner speed", "Outer speed"),
        ("upper_speed", "lower_speed"),
        ("Inside velocity", "Outside velocity"),
    ],
)
def test_two_cylinders_or_plates_slip_by_what_they_differ_by(driving: str, driven: str) -> None:
    columns = {
        "time": TIME,
        driving: 50.0 + SPEED,
        driven: np.full(TIME.size, 50.0),
        "Torque": TORQUE,
        "I": CURRENT,
    }
    plan = planned(columns, {driving: "rad/s", driven: "rad/s", "Torque": "N*m", "I": "A"})
    assert taken(plan, "slip") in (f"{driving} - {driven}", "")
    assert taken(plan, "slip") or f'--slip "{driving} - {driven} [rad/s]"' in plan.command()


def test_a_ball_on_a_disc_slides_by_what_their_speeds_differ_by_and_its_load_presses() -> None:
    rolling = 0.5 + 0.2 * np.sin(TIME)
    sliding = 0.1 * np.cos(7.0 * TIME)
    friction = 0.05 * np.tanh(sliding / 0.02)
    columns = {
        "time": TIME,
        "Disc Speed": rolling + sliding / 2.0,
        "Ball Speed": rolling - sliding / 2.0,
        "Load": LOAD,
        "Traction Force": friction * LOAD,
        "Mu": friction,
    }
    units = {"Disc Speed": "m/s", "Ball Speed": "m/s", "Load": "N", "Traction Force": "N"}
    plan = planned(columns, units)
    assert taken(plan, "slip") == "Disc Speed - Ball Speed"
    assert taken(plan, "effort") == "Traction Force"


@pytest.mark.parametrize("letters", ["abc", "uvw", "123"])
@pytest.mark.parametrize("form", ["i{}", "i_{}"])
def test_three_currents_that_add_up_to_nothing_are_those_of_a_motor(
    letters: str, form: str
) -> None:
    phases: dict[str, Array] = {}
    for place, letter in enumerate(letters):
        phases[form.format(letter)] = 3.0 * TORQUE * np.cos(7.0 * TURN - 2.0 * np.pi * place / 3.0)
    plan = planned({"t": TIME, **phases, "omega": SPEED, "tau": TORQUE, "i_brake": CURRENT})
    assert taken(plan, "field") == "i_brake"


@pytest.mark.parametrize("name", ["Efficiency", "eff. efficiency [%]", "Wirkungsgrad"])
@pytest.mark.parametrize("coil", [True, False])
def test_the_current_beside_an_efficiency_is_that_of_a_motor_under_test(
    name: str, coil: bool
) -> None:
    current = "Coil current" if coil else "Current"
    size = 2.0 + CURRENT
    columns = {"t": TIME, current: size, "omega": 30.0 - size, "tau": 0.1 * size, name: size / 9.0}
    plan = planned(columns, {current: "A", "omega": "rad/s", "tau": "N*m"})
    doubts = [doubt for doubt in plan.doubts if "a motor under test" in doubt]
    assert len(doubts) == (not coil)
    assert plan.command().endswith("--field none") == (not coil)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_force_that_moves_a_mass_too_is_asked_about(sign: float) -> None:
    own = 40.0 * np.tanh(SPEED)
    inertia = 3.0 * np.gradient(SPEED, TIME)
    columns = {"t": TIME, "v": SPEED, "loadcell": own + sign * inertia}
    units = {"v": "m/s", "loadcell": "N", "damper_force": "N", "inertia_force": "N"}
    plan = planned({**columns, "damper_force": own, "inertia_force": inertia}, units)
    assert plan.command().endswith('--effort "damper_force [N]"')
    assert not planned({**columns, "inertia_force": inertia}, units).doubts


def test_three_currents_of_three_coils_are_no_phases() -> None:
    coils: dict[str, Array] = {f"i{number}": CURRENT * number for number in (1, 2, 3)}
    table = Table("log.csv", {"t": TIME, **coils}, dict.fromkeys(("t", *coils)), digest="0" * 64)
    seen = seen_columns(table)
    assert not any(is_of_phases(seen, column) for column in seen.columns.values())


def test_a_letter_that_keeps_levels_is_proposed_as_the_field_beside_a_position() -> None:
    plan = planned({"t": TIME, "x": TURN, "F": TORQUE, "V": 2.0 * CURRENT})
    assert plan.command().endswith('--field "V" --position "x"')


@pytest.mark.parametrize("name", ["q_motor", "DailyAverageAngleDelta"])
def test_a_position_of_something_else_is_not_proposed_as_the_only_motion(name: str) -> None:
    assert "--position" not in planned({"t": TIME, name: TURN, "tau": TORQUE}).command()


def test_a_letter_that_keeps_levels_is_no_speed_where_nothing_moves() -> None:
    plan = planned({"t": TIME, "F": TORQUE, "V": 2.0 * CURRENT})
    assert '--slip "V"' not in plan.command()


def test_torques_of_joints_are_proposed_with_the_angle_of_theirs_and_not_with_the_speed_of_a_tip() -> (
    None
):
    tip = np.gradient(np.cos(TURN), TIME)
    columns = {
        "time": TIME,
        "theta1": TURN,
        "theta2": 0.3 * np.sin(5.0 * TIME),
        "x_dot": tip,
        "y_dot": tip[::-1],
    }
    plan = planned({**columns, "t1": TORQUE, "t2": 0.2 * np.sin(9.0 * TIME), "current": CURRENT})
    assert plan.command().endswith('--position "theta1" --effort "t1"')


def test_the_current_of_a_coil_is_proposed_before_that_which_makes_the_torque() -> None:
    drive = "r78[0]: Current actual value torque-generating"
    columns = {
        "Time": TIME,
        "r63[0]: Speed actual value": SPEED,
        "r80[0]: Torque actual value": TORQUE,
    }
    units = {
        "r63[0]: Speed actual value": "rad/s",
        "r80[0]: Torque actual value": "Nm",
        drive: "A",
        "p2900: coil": "A",
    }
    plan = planned({**columns, drive: np.abs(TORQUE), "p2900: coil": CURRENT}, units)
    assert taken(plan, "field") == "p2900: coil" or '--field "p2900: coil [A]"' in plan.command()


@pytest.mark.parametrize("copies", [1, 2])
def test_of_two_columns_of_one_name_none_is_taken_in_silence(copies: int) -> None:
    columns = {"t": TIME, "v": SPEED, "Force": TORQUE}
    for copy in range(copies):
        columns[f"Force ({copy + 2})"] = 0.9 * TORQUE + copy
    (question,) = planned({**columns, "I": CURRENT}, {"v": "m/s", "I": "A"}).questions
    assert question.signal == "effort"
    assert "columns Force, Force (2)" in question.problem


def test_a_column_that_repeats_another_of_its_name_asks_nothing() -> None:
    columns = {"t": TIME, "v": SPEED, "Force": TORQUE, "Force (2)": TORQUE, "I": CURRENT}
    plan = planned(columns, {"v": "m/s", "I": "A"})
    assert plan.questions == ()
    assert taken(plan, "effort") == "Force"


@pytest.mark.parametrize("load", ["CANBusLoad", "Bus Load", "Load"])
def test_of_several_torques_a_load_in_percent_is_not_proposed(load: str) -> None:
    second = 0.8 * TORQUE + 0.5 * np.sin(3.0 * TIME)
    third = TORQUE + 0.3 * np.cos(11.0 * TIME)
    columns = {
        "time": TIME,
        "N_HM": SPEED,
        load: LOAD,
        "Torque 1": TORQUE,
        "Torque 2": second,
        "Torque 3": third,
        "I_DC": CURRENT,
    }
    torques = {name: "N*m" for name in columns if name.startswith("Torque")}
    plan = planned(columns, {"time": "s", "N_HM": "1/min", load: "%", "I_DC": "A", **torques})
    assert plan.command().strip().endswith('--effort "Torque 1 [N*m]"')

"""Where a drive tells no torque, its current is proposed for it, by its joint or by how it goes with the motion."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.signals.array import Array
from tests.support.command import good
from tests.support.slow_params import slow_behind

TIME = np.arange(600) / 100
ANGLE = np.sin(3 * TIME)
SPEED = 3 * np.cos(3 * TIME)
DRAG = np.tanh(2 * SPEED) + 0.1 * SPEED


def planned(columns: dict[str, Array], units: dict[str, str] | None = None) -> Plan:
    table = Table(
        "a.csv",
        columns,
        {name: (units or {}).get(name) for name in columns},
        "0" * 64,
        path="a.csv",
    )
    return plan_of(table, ColumnMap())


def servo(
    current: str, units: dict[str, str] | None = None, course: Array = DRAG, **further: Array
) -> Plan:
    columns = {"timestamp": TIME, "present_position": np.round(2048 + 600 * ANGLE)}
    columns |= {"present_velocity": np.round(90 * SPEED), current: np.round(50 * course), **further}
    return planned(columns, units)


@pytest.mark.parametrize("current", ["present_current", "current", "iq_measured", "Motorstrom"])
def test_the_current_of_a_servo_without_a_torque_is_proposed_as_the_effort_and_not_as_the_field(
    current: str,
) -> None:
    plan = servo(current)
    assert {question.signal for question in plan.questions} == {"effort", "field"}
    words = shlex.split(plan.command())
    assert words[words.index("--effort") + 1] == current
    assert words[words.index("--field") + 1] == "none"


def test_a_current_with_a_unit_is_proposed_with_the_constant_of_its_motor_to_fill_in() -> None:
    words = shlex.split(servo("present_current", {"present_current": "mA"}).command())
    assert words[words.index("--effort") + 1 :][:3] == [
        "present_current [mA]",
        "--scale",
        "effort=NUMBER N*m/A",
    ]


@pytest.mark.parametrize("course", [np.abs(DRAG), np.sign(np.sin(40 * TIME)), 1.0 + 0.0 * DRAG])
def test_a_current_that_keeps_its_sign_or_goes_its_own_way_is_proposed_as_no_effort(
    course: Array,
) -> None:
    words = shlex.split(servo("present_current", course=course).command())
    assert words[words.index("--effort") + 1] == "COLUMN [N]"


def test_what_a_drive_was_told_and_a_current_beside_a_torque_are_proposed_as_no_effort() -> None:
    words = shlex.split(servo("goal_current").command())
    assert words[words.index("--effort") + 1] == "COLUMN [N]"
    effort = servo("present_current", present_torque=DRAG).signal("effort")
    assert effort is not None
    assert effort.column == "present_torque"


def robot(rests: int = 0) -> dict[str, Array]:
    columns = {"timestamp": 1000.0 + TIME}
    for part, scale in (
        ("target_q", ANGLE),
        ("target_moment", DRAG),
        ("actual_q", ANGLE),
        ("actual_qd", SPEED),
    ):
        for joint in range(6):
            columns[f"{part}_{joint}"] = scale * (joint >= rests) * (1 + 0.1 * joint)
    for joint in range(6):  # under gravity a current keeps its sign
        columns[f"actual_current_{joint}"] = DRAG * (joint >= rests) + 3.0 * (joint in (1, 2))
    return {
        **columns,
        "actual_robot_current": 1.5 + 0.1 * ANGLE,
        "actual_main_voltage": 48.0 + 0.1 * SPEED,
    }


@pytest.mark.slow
@pytest.mark.parametrize(("rests", "joint"), slow_behind(1, [(0, 0), (1, 1), (3, 3)]))
def test_of_a_robot_without_torques_speed_and_current_of_the_first_joint_that_moves_are_proposed(
    tmp_path: Path, rests: int, joint: int
) -> None:
    pd.DataFrame(robot(rests)).to_csv(tmp_path / "a.csv", index=False)
    last = good("inspect", "a.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert last.startswith("What settles it: erclutch inspect a.csv ")
    command = shlex.split(last.partition("erclutch ")[2])
    assert command[command.index("--slip") + 1] == f"actual_qd_{joint}"
    assert command[command.index("--effort") + 1] == f"actual_current_{joint}"
    assert "Understood." in good(*command, cwd=tmp_path)


GAINS = [f"K{row}{column}" for row in (1, 2) for column in (1, 2, 3, 4)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "settled"),
    [(GAINS, True), (GAINS[1:], False), (["K1", "K2"], False), (["E11"], False)],
)
def test_the_entries_of_a_whole_matrix_are_no_field(names: list[str], settled: bool) -> None:
    columns = {"time": TIME, "theta": ANGLE, "theta_dot": SPEED, "tau": DRAG}
    columns |= {name: 2.0 + np.sin(TIME * (1 + k)) for k, name in enumerate(names)}
    assert (not planned(columns).questions) == settled


@pytest.mark.slow
def test_the_motion_of_another_joint_is_no_field_and_is_not_proposed_as_one() -> None:
    other = {"q2": 0.5 * np.cos(2 * TIME), "dq2": -np.sin(2 * TIME)}
    both = {
        "q1": ANGLE,
        "dq1": SPEED,
        "tau1": DRAG,
        **other,
        "tau2": np.tanh(-3 * np.sin(2 * TIME)),
    }
    plan = planned({"time": TIME, **both})
    assert (plan.questions, len(plan.doubts)) == ((), 2)
    levels = np.round(4 * other["q2"]) / 40  # an angle that rests at a few levels
    plan = planned(
        {
            "Time": TIME,
            "t1": DRAG,
            "t2": 0.9 * DRAG,
            "q2": levels,
            "x_dot": SPEED,
            "y_dot": 0.3 * DRAG,
        }
    )
    assert "--field q2" not in plan.command().replace('"', "")


@pytest.mark.slow
def test_of_components_those_of_one_direction_are_proposed_together() -> None:
    """Fx_Mea goes with x_dot, whose torque follows the other motion as well."""
    other = SPEED + 0.4 * np.sin(7 * TIME)
    columns = {
        "Time": TIME,
        "Fy_Mea": np.tanh(3 * other),
        "Fx_Mea": DRAG,
        "x_dot": SPEED,
        "y_dot": other,
    }
    words = shlex.split(planned(columns).command())
    slip, effort = (words[words.index(option) + 1] for option in ("--slip", "--effort"))
    assert {slip[0], effort[1]} in ({"x"}, {"y"})


def test_of_the_two_currents_of_a_drive_that_which_makes_its_torque_is_proposed() -> None:
    drive = {
        "input_voltage": 48.0 + 0.1 * ANGLE,
        "current_motor": 5.0 * DRAG,
        "current_in": np.abs(DRAG),
    }
    axes = {
        "d_axis_current": 0.1 * ANGLE,
        "q_axis_current": 5.0 * DRAG,
        "erpm": np.round(500 * SPEED),
    }
    words = shlex.split(planned({"time": TIME, **drive, **axes}).command())
    assert words[words.index("--effort") + 1] == "q_axis_current"
    assert words[words.index("--slip") + 1 :][:3] == ["erpm", "--scale", "slip=NUMBER rpm/count"]


def test_laps_of_a_pin_on_a_disc_are_no_field() -> None:
    rubbed = {
        "Laps": np.floor(2 * TIME),
        "Speed": 10.0 + 0.1 * ANGLE,
        "Friction Force": 3.0 + 0.3 * ANGLE,
    }
    plan = planned({"Time": TIME, **rubbed})
    field = plan.signal("field")
    assert field is not None
    assert (plan.questions, field.column) == ((), "")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "unit", "effort"),
    slow_behind(
        2,
        [
            ("Weight", "g", "Weight [gf]"),
            ("Weight_g", "", "Weight_g [gf]"),
            ("Load", "kg", "Load [kgf]"),
            ("Load_kg", "", "Load_kg --scale effort=1 kgf/kg"),
            ("force_kg", "", "force_kg --scale effort=1 kgf/kg"),
        ],
    ),
)
def test_a_weight_is_asked_about_as_the_force_that_a_scale_shows(
    tmp_path: Path, name: str, unit: str, effort: str
) -> None:
    label = f"{name} ({unit})" if unit else name
    log = pd.DataFrame(
        {"Time (s)": TIME, "Displacement (mm)": 20.0 * ANGLE, label: 20.0 + 15.0 * DRAG}
    )
    log.to_csv(tmp_path / "a.csv", index=False)
    last = good("inspect", "a.csv", cwd=tmp_path, code=1).splitlines()[-1]
    command = shlex.split(last.partition("erclutch ")[2])
    assert (
        " ".join(command[command.index("--effort") + 1 :]).removesuffix(" --field none") == effort
    )
    said = good(*command, cwd=tmp_path)
    assert "Understood." in said
    assert " effort           N " in said


def test_the_output_of_a_controller_beside_an_angle_is_proposed_as_the_effort_and_a_voltage_is_not() -> (
    None
):
    swing = {"t": TIME, "theta": ANGLE, "theta_dot": SPEED, "u": DRAG}
    words = shlex.split(planned(swing).command())
    assert words[words.index("--effort") + 1] == "u"
    words = shlex.split(planned(swing, {"u": "V"}).command())
    assert words[words.index("--effort") + 1] != "u"

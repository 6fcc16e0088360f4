"""Parts of an effort beside the whole are none; the output of a controller is asked about."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of

TIME = np.arange(400) / 200.0
ANGLE = np.sin(7.0 * TIME)
SPEED = 7.0 * np.cos(7.0 * TIME)
FIRST = 2.0 * np.sign(SPEED) + 0.1 * SPEED
SECOND = 0.7 * np.cos(3.1 * TIME)


def planned(columns: Mapping[str, np.ndarray]) -> Plan:
    table = Table("run.csv", {"t": TIME, **columns}, dict.fromkeys(columns), digest="")
    return plan_of(table, ColumnMap.from_options({"field": "none"}))


@pytest.mark.parametrize(
    ("whole", "first", "second"),
    [
        ("total_torque", "left_torque", "right_torque"),
        ("sum_force", "force_1", "force_2"),
        ("tau_measured", "tau_rigid", "tau_friction"),
    ],
)
def test_of_a_whole_and_the_two_columns_that_make_it_up_the_whole_is_the_effort(
    whole: str, first: str, second: str
) -> None:
    columns = {"speed": SPEED, first: FIRST, second: SECOND, whole: FIRST + SECOND}
    assert planned(columns).signal("effort").column == whole  # pyright: ignore[reportOptionalMemberAccess]


def test_of_joints_in_matrices_the_measured_torque_is_proposed_and_no_part_of_a_model() -> None:
    columns: dict[str, np.ndarray] = {}
    for joint in (1, 2, 3):
        columns |= {f"q_{joint}": joint * ANGLE, f"qd_{joint}": joint * SPEED}
    for joint in (1, 2, 3):
        columns |= {f"tau_measured_{joint}": FIRST + joint * SECOND}
    for joint in (1, 2, 3):
        columns |= {f"tau_rigid_{joint}": joint * SECOND, f"tau_friction_{joint}": FIRST}
    command = planned(columns).command()
    assert "tau_measured" in command
    assert "tau_friction" not in command


def test_two_efforts_that_do_not_make_up_the_total_are_asked_about() -> None:
    columns = {"speed": SPEED, "left_force": FIRST, "right_force": SECOND, "total_force": SECOND**2}
    assert planned(columns).signal("effort") is None


def test_a_net_torque_is_no_whole_of_the_drive_and_its_load() -> None:
    columns = {"speed": SPEED, "drive_torque": FIRST, "load_torque": SECOND}
    effort = planned({**columns, "net_torque": FIRST + SECOND}).signal("effort")
    assert effort is None or effort.column != "net_torque"


def test_a_torque_that_a_feedforward_is_a_part_of_is_asked_about() -> None:
    columns = {"Actual_Position_deg": ANGLE, "Feedback_Torque_Nm": FIRST}
    columns |= {"Feedforward_Torque_Nm": SECOND, "Total_Torque_Nm": FIRST + SECOND}
    effort = planned(columns).signal("effort")
    assert effort is not None
    assert "the output of a controller" in effort.doubt


def test_a_feedback_beside_a_feedforward_is_asked_about_and_alone_it_is_measured() -> None:
    alone = {"speed": SPEED, "torque_feedback": FIRST}
    effort = planned(alone).signal("effort")
    assert effort is not None
    assert not effort.doubt
    beside = planned({**alone, "torque_feedforward": SECOND}).signal("effort")
    assert beside is not None
    assert "the output of a controller" in beside.doubt


@pytest.mark.parametrize(
    ("whole", "friction"),
    [
        ("tau", "tau_fric"),
        ("tau_meas", "tau_fric"),
        ("torque_measured", "torque_friction"),
    ],
)
def test_a_friction_beside_the_measured_effort_of_its_name_is_asked_about(
    whole: str, friction: str
) -> None:
    plan = planned({"speed": SPEED, whole: FIRST + SECOND, friction: FIRST})
    asked = next(each for each in plan.questions if each.signal == "effort")
    assert f"any of the columns {whole}, {friction}" in asked.problem
    assert f'--effort "{whole}"' in plan.command()


def test_a_friction_without_a_measured_effort_beside_it_is_the_effort() -> None:
    effort = planned({"speed": SPEED, "tau_fric": FIRST}).signal("effort")
    assert effort is not None
    assert effort.column == "tau_fric"

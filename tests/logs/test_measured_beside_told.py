"""Of two columns of one name that is taken which is said to be measured; the other is what a drive was told.

The data are SYNTHETIC.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, plan_of, read_table
from erclutch.logs.plan import Plan
from erclutch.signals.array import Array

TIME = np.arange(2000) / 200.0
CURRENT = np.where(TIME < 5.0, 0.5, 1.0)
SPEED = np.sin(2 * np.pi * 0.3 * TIME)
TOLD_SPEED = np.sin(2 * np.pi * 0.3 * TIME + 0.1)
TORQUE = 2.0 * CURRENT * np.tanh(SPEED / 0.05) + 0.3 * SPEED
TOLD_TORQUE = 2.1 * np.sin(2 * np.pi * 0.3 * TIME + 0.2)


def planned(path: Path, columns: dict[str, Array]) -> Plan:
    rows = np.column_stack([*columns.values()])
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.7g")
    return plan_of(read_table(path), ColumnMap())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("told", "measured"),
    [
        ("torque", "torque_measured"),
        ("torque [N m]", "torque actual [N m]"),
        ("Drehmoment [N m]", "Drehmoment Ist [N m]"),
    ],
)
def test_the_torque_that_was_measured_is_taken(tmp_path: Path, told: str, measured: str) -> None:
    columns = {"time": TIME, "current": CURRENT, "velocity": SPEED, told: TOLD_TORQUE}
    plan = planned(tmp_path / "brake.csv", {**columns, measured: TORQUE})
    taken = {each.signal: each.column for each in plan.signals}
    assert taken["effort"] == measured.partition(" [")[0]


@pytest.mark.slow
def test_the_speed_that_was_measured_is_taken(tmp_path: Path) -> None:
    columns = {"time": TIME, "current": CURRENT, "speed": TOLD_SPEED, "actual_speed": SPEED}
    plan = planned(tmp_path / "brake.csv", {**columns, "torque": TORQUE})
    taken = {each.signal: each.column for each in plan.signals}
    assert taken["slip"] == "actual_speed"


@pytest.mark.slow
def test_a_torque_that_is_called_tor_is_an_effort(tmp_path: Path) -> None:
    columns = {"t": TIME, "current": CURRENT, "velDes": TOLD_SPEED, "velAct": SPEED}
    plan = planned(tmp_path / "joint.csv", {**columns, "torDes": TOLD_TORQUE, "torAct": TORQUE})
    taken = {each.signal: each.column for each in plan.signals}
    assert (taken["slip"], taken["effort"]) == ("velAct", "torAct")


@pytest.mark.slow
def test_torques_that_joints_were_told_are_not_proposed_beside_those_that_were_measured(
    tmp_path: Path,
) -> None:
    columns = {"Time(s)": TIME}
    for joint in range(1, 5):
        columns[f"tau_{joint}"] = TOLD_TORQUE / joint
    for joint in range(1, 5):
        columns[f"tau_measured_{joint}"] = TORQUE / joint
    for joint in range(1, 5):
        columns[f"joint_vel_{joint}"] = SPEED * joint
    plan = planned(tmp_path / "robot.csv", columns)
    taken = {each.signal: each.column for each in plan.signals}
    assert (taken["slip"], taken["effort"]) == ("joint_vel_1", "tau_measured_1")


PLANNED = [("elbow_{}", "elbow_meas_{}"), ("knee {}", "knee actual {}"), ("hip_{}", "hip_{}_act")]


@pytest.mark.slow
@pytest.mark.parametrize(("planned_as", "measured_as"), PLANNED)
def test_of_a_trajectory_the_columns_that_were_measured_are_taken(
    tmp_path: Path, planned_as: str, measured_as: str
) -> None:
    columns = {"time": TIME, "shoulder_vel": -SPEED}
    columns |= {planned_as.format("vel"): TOLD_SPEED, planned_as.format("torque"): TOLD_TORQUE}
    measured = {measured_as.format("vel"): SPEED, measured_as.format("torque"): TORQUE}
    plan = planned(tmp_path / "leg.csv", {**columns, **measured})
    taken = {each.signal: each.column for each in plan.signals}
    assert (taken["slip"], taken["effort"]) == (*measured,)


def test_where_the_measured_torque_never_changes_the_other_one_may_be_all_there_is(
    tmp_path: Path,
) -> None:
    columns = {"time": TIME, "elbow_vel": SPEED, "elbow_torque": TORQUE}
    plan = planned(tmp_path / "leg.csv", {**columns, "elbow_meas_torque": 0.0 * TIME})
    taken = {each.signal: each.column for each in plan.signals}
    assert taken["effort"] == "elbow_torque"


@pytest.mark.parametrize(
    ("limb", "other"), [("elbow", "shoulder"), ("left_hip", "right_hip"), ("axle", "wheel")]
)
def test_the_speed_is_taken_that_is_called_like_the_limb_of_the_only_torque(
    tmp_path: Path, limb: str, other: str
) -> None:
    columns = {"time": TIME, f"{other}_vel": TOLD_SPEED, f"{limb}_vel": SPEED}
    plan = planned(tmp_path / "leg.csv", {**columns, f"{limb}_torque": TORQUE})
    taken = {each.signal: each.column for each in plan.signals}
    assert taken["slip"] == f"{limb}_vel"


def test_beside_a_torque_of_a_third_limb_the_speed_is_asked_about(tmp_path: Path) -> None:
    columns = {"time": TIME, "elbow_vel": SPEED, "shoulder_vel": TOLD_SPEED}
    plan = planned(tmp_path / "leg.csv", {**columns, "knee_torque": TORQUE})
    assert "slip" not in {each.signal for each in plan.signals}


def test_of_several_speeds_of_a_limb_the_command_names_one_of_them(tmp_path: Path) -> None:
    columns = {"time": TIME, "shoulder_vel": TOLD_SPEED, "elbow_fast_vel": SPEED}
    columns |= {"elbow_slow_vel": 1.01 * SPEED, "elbow_torque": TORQUE}
    plan = planned(tmp_path / "leg.csv", columns)
    assert [each for each in plan.examples if each.startswith("--slip")] == [
        '--slip "elbow_fast_vel"'
    ]


@pytest.mark.parametrize(
    ("motion", "tau"),
    [("elbow_vel", "elbow_tau"), ("hip_pos", "hip_meas_tau"), ("left_knee_vel", "left_knee_tau")],
)
def test_the_tau_of_a_joint_whose_motion_is_there_is_its_torque(
    tmp_path: Path, motion: str, tau: str
) -> None:
    gravity = 3.0 + 0.2 * np.cos(7.0 * TIME)  # does not follow the motion
    plan = planned(tmp_path / "leg.csv", {"time": TIME, motion: SPEED, tau: gravity})
    assert {each.signal: each.column for each in plan.signals}["effort"] == tau


@pytest.mark.slow
@pytest.mark.parametrize("tau", ["filter_tau", "tau", "knee_tau"])
def test_another_tau_that_does_not_follow_the_motion_is_asked_about(
    tmp_path: Path, tau: str
) -> None:
    columns = {"time": TIME, "elbow_vel": SPEED, tau: 3.0 + 0.2 * np.cos(7.0 * TIME)}
    plan = planned(tmp_path / "leg.csv", columns)
    assert "effort" not in {each.signal for each in plan.signals}

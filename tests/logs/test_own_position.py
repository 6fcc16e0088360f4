"""A position that nobody named stands beside the speed of its own joint or shaft, or it is left out."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.signals.array import Array

TIME = np.arange(600) / 100.0  # s
ANKLE = np.sin(5.0 * TIME)  # rad
ANKLE_SPEED = 5.0 * np.cos(5.0 * TIME)  # rad/s
MOTOR = 3.0 * np.sin(2.0 * TIME + 1.0)
MOTOR_SPEED = 6.0 * np.cos(2.0 * TIME + 1.0)
TORQUE = 0.5 * np.tanh(ANKLE_SPEED)


def _planned(columns: Mapping[str, Array], slip: str) -> Plan:
    table = Table("log.csv", {"time_s": TIME, **columns, "torque": TORQUE}, {}, "0" * 64)
    return plan_of(table, ColumnMap.from_labels({"slip": slip, "field": "none"}))


def _position(plan: Plan) -> str:
    choice = plan.signal("position")
    return "" if choice is None else choice.column


@pytest.mark.parametrize(
    ("slip", "position", "its_speed"),
    [
        ("ankle_velocity", "motor_angle", "motor_velocity"),
        ("arm speed", "shaft angle", "shaft speed"),
        ("ankle_velocity", "motor_position", "aux"),  # whose rate the numbers tell
    ],
)
def test_a_position_of_another_joint_is_left_out_with_a_word(
    slip: str, position: str, its_speed: str
) -> None:
    plan = _planned({slip: ANKLE_SPEED, position: MOTOR, its_speed: MOTOR_SPEED}, slip)
    assert _position(plan) == ""
    said = f"column {position} is the position of another motion than column {slip}: left out"
    assert any(note.startswith(said) for note in plan.notes)


@pytest.mark.parametrize(
    ("slip", "own", "other"),
    [
        ("ankle_velocity", "ankle_angle", "motor_angle"),
        ("arm speed", "arm angle", "shaft angle"),
    ],
)
def test_of_two_positions_that_of_the_joint_is_taken(slip: str, own: str, other: str) -> None:
    plan = _planned({slip: ANKLE_SPEED, other: MOTOR, own: ANKLE}, slip)
    assert _position(plan) == own


@pytest.mark.parametrize(
    ("beside", "values"),
    [
        ("ankle_velocity_raw", ANKLE_SPEED),  # of which the slip is a filtered copy
        ("motor_velocity", 9.0 * ANKLE_SPEED),  # of a motor behind a gear
    ],
)
def test_a_filtered_speed_keeps_its_position(beside: str, values: Array) -> None:
    late = 5.0 * np.cos(5.0 * TIME - 0.3)
    plan = _planned(
        {"ankle_velocity": late, "ankle_angle": ANKLE, beside: values}, "ankle_velocity"
    )
    assert _position(plan) == "ankle_angle"


def test_the_only_position_stays_beside_a_speed_of_another_name() -> None:
    plan = _planned({"omega": ANKLE_SPEED, "angle": ANKLE}, "omega")
    assert _position(plan) == "angle"

"""What the numbers of a log settle is not asked about: a speed at rest, two sensors of one speed, times of runs."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of

TIME = 0.01 * np.arange(600)
RATE = 100.0 + 80.0 * np.sin(3.0 * TIME)
TORQUE = 0.2 + 0.003 * RATE
NOISE = np.random.default_rng(3).normal(0.0, 1.0, TIME.size)


def planned(columns: dict[str, np.ndarray]) -> Plan:
    return plan_of(Table("a.csv", columns, dict.fromkeys(columns), "x", path="a.csv"), ColumnMap())


def column_of(plan: Plan, signal: str) -> str:
    found = plan.signal(signal)
    return found.column if found else ""


def test_a_speed_that_never_changes_is_not_the_slip_beside_one_that_does() -> None:
    plan = planned(
        {"time": TIME, "angular speed": RATE, "linear speed": 0.0 * RATE, "torque": TORQUE}
    )
    assert not plan.questions
    assert column_of(plan, "slip") == "angular speed"
    assert any("linear speed never changes" in note for note in plan.notes)


@pytest.mark.parametrize(
    "names", [("motor optical speed", "motor electrical speed"), ("hall_rpm", "optical_rpm")]
)
def test_two_sensors_of_one_speed_that_agree_are_one_speed(names: tuple[str, str]) -> None:
    first, second = names
    plan = planned({"time": TIME, first: RATE, second: RATE + NOISE, "torque": TORQUE})
    assert not plan.questions
    assert column_of(plan, "slip") == first
    plan = planned({"time": TIME, first: RATE, second: 1.2 * RATE, "torque": TORQUE})
    assert "slip may be any of" in str(plan.questions)


def test_two_shafts_that_turn_alike_are_asked_about_still() -> None:
    plan = planned(
        {"time": TIME, "speed front": RATE, "speed rear": RATE + NOISE, "torque": TORQUE}
    )
    assert "slip may be any of" in str(plan.questions)


@pytest.mark.parametrize("name", ["ABS LC1", "LC2", "load_cell_raw"])
def test_a_load_cell_is_no_field(name: str) -> None:
    plan = planned(
        {
            "time": TIME,
            "velocity": RATE,
            "measured_torque": TORQUE,
            name: 50.0 + 3.0 * NOISE.cumsum(),
        }
    )
    assert column_of(plan, "field") == ""
    assert not any(question.signal == "field" for question in plan.questions)

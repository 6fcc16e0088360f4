"""The current of a motor under test is told by its power and its efficiency, and is no field. SYNTHETIC."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, plan_of
from erclutch.signals.array import Array
from tests.support.plans_of_columns import planned, table

TIME = np.arange(400) / 100.0
SPEED = 300.0 + 200.0 * np.sin(3.0 * TIME)  # rad/s
TORQUE = 0.4 + 0.2 * np.sin(2.0 * TIME)
CURRENT = 4.0 + 9.0 * TORQUE + 0.01 * SPEED
VOLTAGE = 24.0 - 0.05 * CURRENT
GIVEN = SPEED * TORQUE
STAND = {
    "Time [s]": TIME,
    "Torque [N*m]": TORQUE,
    "Current [A]": CURRENT,
    "Speed [rpm]": SPEED * 30.0 / np.pi,
}


def _powers(voltage: Array, current: Array = CURRENT) -> dict[str, Array]:
    drawn = voltage * current
    return {
        "Electrical Power [W]": np.round(drawn, 2),
        "Mechanical Power [W]": np.round(GIVEN, 2),
        "Motor Efficiency [%]": np.round(100.0 * GIVEN / drawn, 2),
    }


PROPELLER = {
    "ESC [us]": 1000.0 + SPEED,
    "Thrust [N]": 1e-4 * SPEED**2,
    "Voltage [V]": VOLTAGE,
    **_powers(VOLTAGE),
    "Change": np.sin(5.0 * TIME),  # a number of the controller, whose name says nothing
}


def _named(columns: dict[str, Array], name: str) -> Plan:
    return plan_of(replace(table(columns), name=name, path=name), ColumnMap())


def test_a_stand_of_a_propeller_has_no_field() -> None:
    plan = planned({**STAND, **PROPELLER})
    assert not plan.questions
    assert not plan.doubts
    field = plan.signal("field")
    assert field is not None
    assert not field.column
    assert "Mechanical Power over it is Motor Efficiency" in " ".join(plan.notes)


def test_the_volts_that_feed_the_motor_are_not_the_field() -> None:
    plan = _named({**STAND, **_powers(np.full(400, 12.0))}, "curve-12V.csv")
    assert not plan.questions
    assert plan.signal("field").column == ""  # type: ignore[union-attr]


def test_other_volts_of_the_name_are_asked_about_and_rather_feed_the_motor() -> None:
    plan = _named({**STAND, **_powers(np.full(400, 12.0))}, "curve-10V.csv")
    assert "the name of the file says 10 V" in " ".join(each.problem for each in plan.questions)
    assert plan.command().endswith("--field none")


@pytest.mark.parametrize("name", ["MotorCurve-10V.csv", "motor 10V.csv", "servo_run_10V.csv"])
def test_volts_behind_the_word_motor_feed_the_motor_and_other_volts_of_its_powers_are_told(
    name: str,
) -> None:
    plan = _named({**STAND, **_powers(np.full(400, 12.0))}, name)
    assert not plan.questions
    assert "says 10 V, and the powers of the motor under test tell 12 V" in " ".join(plan.notes)


@pytest.mark.parametrize("name", ["motor_brake_10V.csv", "motor_coil_10V.csv", "motor_10A.csv"])
def test_volts_of_a_device_and_amperes_behind_the_word_motor_are_asked_about(name: str) -> None:
    plan = _named({**STAND, **_powers(np.full(400, 12.0))}, name)
    assert [each.signal for each in plan.questions] == ["field"]


def test_another_number_of_the_name_is_asked_about() -> None:
    plan = _named({**STAND, **_powers(np.full(400, 12.0))}, "curve-2A.csv")
    assert "the name of the file says 2 A" in " ".join(each.problem for each in plan.questions)


def test_a_bench_without_a_propeller_may_have_its_field_under_a_name_that_says_nothing() -> None:
    columns = {**STAND, "Voltage [V]": VOLTAGE, **_powers(VOLTAGE)}
    assert not planned(columns).questions
    plan = planned({**columns, "x7": np.repeat([0.0, 1.0, 2.0, 0.5], 100)})
    assert [each.signal for each in plan.questions] == ["field"]


@pytest.mark.parametrize(
    ("what", "other"),
    [
        ("the current of a coil", _powers(VOLTAGE, 8.0 + np.sin(TIME))),
        (
            "an efficiency of something else",
            {**_powers(VOLTAGE), "Motor Efficiency [%]": 50.0 + 9.0 * np.sin(7.0 * TIME)},
        ),
    ],
)
def test_where_the_numbers_do_not_tell_it_the_user_is_asked(
    what: str, other: dict[str, Array]
) -> None:
    plan = planned({**STAND, **PROPELLER, **other})
    assert "as that of a motor under test" in " ".join(plan.doubts), what


def test_a_score_of_the_motor_s_current_is_not_offered_either() -> None:
    score = (CURRENT - CURRENT.mean()) / CURRENT.std()
    columns = {**STAND, "Voltage [V]": VOLTAGE, **_powers(VOLTAGE), "Z_Score_Current [A]": score}
    assert "Z_Score" not in planned(columns).command()


def test_two_speeds_that_are_zero_all_through_are_not_one_motion() -> None:
    speeds = {"Motor Electrical Speed [rpm]": 0.0 * TIME, "Motor Optical Speed [rpm]": 0.0 * TIME}
    plan = planned({"Time [s]": TIME, "Torque [N*m]": TORQUE, **speeds})
    assert "slip" in [each.signal for each in plan.questions]

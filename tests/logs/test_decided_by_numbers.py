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


@pytest.mark.parametrize(
    ("names", "effort", "slip"),
    [
        (("angular speed", "linear speed"), "torque", "angular speed"),
        (("rotational velocity", "tangential velocity"), "Torque", "rotational velocity"),
        (("angular speed", "linear speed"), "force", "linear speed"),
    ],
)
def test_without_units_the_words_for_a_motion_tell_what_makes_a_power_with_the_effort(
    names: tuple[str, str], effort: str, slip: str
) -> None:
    first, second = names
    plan = planned({"time": TIME, first: RATE, second: 0.2 * RATE + NOISE, effort: TORQUE})
    assert column_of(plan, "slip") == slip
    assert not plan.questions


@pytest.mark.parametrize(
    ("names", "effort"),
    [
        (("angular speed", "motor speed"), "torque"),  # of one nothing says how it moves
        (("angular speed front", "angular speed rear"), "torque"),
        (("angular speed", "linear speed"), "load"),
    ],
)
def test_words_for_a_motion_tell_nothing_where_one_is_missing(
    names: tuple[str, str], effort: str
) -> None:
    first, second = names
    plan = planned({"time": TIME, first: RATE, second: 0.2 * RATE + NOISE, effort: TORQUE})
    assert any("slip may be any of" in question.problem for question in plan.questions)


@pytest.mark.parametrize(
    ("slip", "other"),
    [
        ("Sliding Speed", "Disc Speed 1"),
        ("relative speed", "output speed"),
        ("Relativdrehzahl", "Motordrehzahl"),
        ("vitesse de glissement", "vitesse disque"),
    ],
)
def test_the_speed_of_one_surface_over_the_other_is_the_slip(slip: str, other: str) -> None:
    plan = planned({"time": TIME, other: RATE, slip: 40.0 + 0.4 * RATE + NOISE, "torque": TORQUE})
    assert column_of(plan, "slip") == slip
    assert not plan.questions


def test_of_two_sliding_speeds_none_is_taken() -> None:
    two = {"Sliding Speed 1": RATE, "Sliding Speed 2": 0.4 * RATE + NOISE}
    plan = planned({"time": TIME, **two, "torque": TORQUE})
    assert any("slip may be any of" in question.problem for question in plan.questions)


@pytest.mark.parametrize("share", ["disc relative speed", "Relativdrehzahl"])
def test_a_relative_speed_may_be_the_share_of_a_speed_by_its_numbers(share: str) -> None:
    plan = planned({"time": TIME, "disc speed": RATE, share: 0.01 * RATE, "torque": TORQUE})
    assert any("slip may be any of" in question.problem for question in plan.questions)


@pytest.mark.parametrize(
    ("effort", "unit", "slip"),
    [("torque", "N*m", "disc speed"), ("friction force", "N", "sliding speed")],
)
def test_a_sliding_speed_makes_a_power_with_a_force_and_not_with_a_torque(
    effort: str, unit: str, slip: str
) -> None:
    columns = {"time": TIME, "disc speed": RATE, "sliding speed": 0.04 * RATE, effort: TORQUE}
    units = {"time": "s", "disc speed": "rpm", "sliding speed": "m/s", effort: unit}
    plan = plan_of(Table("a.csv", columns, units, "x", path="a.csv"), ColumnMap())
    assert column_of(plan, "slip") == slip
    plan = plan_of(
        Table("a.csv", columns, {**units, "disc speed": None}, "x", path="a.csv"), ColumnMap()
    )
    assert bool(plan.questions or plan.doubts) == (effort == "torque")


POINTS = {"X1": RATE % 7, "Y1": RATE % 11, "X2": RATE % 13, "Y2": RATE % 5}


def test_coordinates_of_several_points_are_no_field() -> None:
    motion = {"Elapsed Time": TIME, "Extension": RATE, "Load": TORQUE}
    plan = planned({**motion, **POINTS, "X_AVG": RATE % 3, "Y_AVG": RATE % 2})
    assert not plan.questions
    assert any("is a coordinate of one of several points" in note for note in plan.notes)


@pytest.mark.parametrize(
    "names",
    [
        ("X1", "X2", "Y1"),  # inputs and an output of a program that learns
        ("X1", "Y1"),
        ("X1", "Y1", "X2", "Y3"),
    ],
)
def test_letters_that_are_no_points_may_be_the_field(names: tuple[str, ...]) -> None:
    open_ones = dict(zip(names, POINTS.values(), strict=False))
    plan = planned({"time": TIME, "velocity": RATE, "force": TORQUE, **open_ones})
    assert any(question.signal == "field" for question in plan.questions)

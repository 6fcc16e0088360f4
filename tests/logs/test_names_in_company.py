"""Names that say something beside the others of their table: a letter in front of all, a file's ending behind all."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.columns.names_in_company import told_by_company
from erclutch.signals.array import Array

SPAN = np.arange(600.0) * 0.004
ANGLE = np.sin(3.0 * SPAN)
RATE = 3.0 * np.cos(3.0 * SPAN)
TORQUE = np.tanh(4.0 * RATE)


def _plan(columns: dict[str, Array]) -> Plan:
    return plan_of(Table("a", columns, {}, "0" * 64), ColumnMap())


@pytest.mark.parametrize("letter", ["f", "m"])
def test_a_letter_in_front_of_all_names_says_nothing(letter: str) -> None:
    columns = {f"{letter}time": SPAN}
    for joint, share in ((1, 1.0), (2, 0.3)):
        columns[f"{letter}q_{joint}"] = share * ANGLE
        columns[f"{letter}dq_{joint}"] = share * RATE
        columns[f"{letter}torque_{joint}"] = share * TORQUE
    plan = _plan(columns)
    assert plan.clock is not None
    assert plan.clock.column == f"{letter}time"
    assert f'--slip "{letter}dq_1"' in plan.examples
    assert f'--effort "{letter}torque_1"' in plan.examples


def test_names_that_only_begin_alike_keep_their_letter() -> None:
    plan = _plan({"flow": ANGLE, "fdq": RATE, "fuel": TORQUE})
    assert {"slip", "effort"} <= {question.signal for question in plan.questions}
    assert not any("fdq" in example for example in plan.examples)


def test_of_what_a_joint_did_and_was_told_the_former_is_proposed() -> None:
    columns: dict[str, Array] = {}
    for joint, share in ((1, 1.0), (2, 0.4)):
        columns[f"posd{joint}.txt"] = share * ANGLE + 0.01
        columns[f"veld{joint}.txt"] = share * RATE
        columns[f"posa{joint}.txt"] = share * ANGLE
        columns[f"vela{joint}.txt"] = share * RATE - 0.02 * ANGLE
        columns[f"trq{joint}.txt"] = share * TORQUE
    plan = _plan(columns)
    assert '--slip "vela1.txt"' in plan.examples
    assert '--effort "trq1.txt"' in plan.examples


def test_a_letter_behind_a_name_alone_is_no_word() -> None:
    plan = _plan({"t": SPAN, "vela": RATE, "trq": TORQUE})
    assert not any(each.column == "vela" for each in plan.signals)


@pytest.mark.parametrize(
    ("now", "wanted"),
    [
        ("current_position", "target_position"),
        ("currentPos", "targetPos"),
        ("curr_y", "desired_y"),
        ("current angle", "setpoint angle"),
        ("pos_current", "pos_target"),
    ],
)
def test_what_is_now_beside_what_is_wanted_is_a_motion_and_no_current(
    now: str, wanted: str
) -> None:
    plan = _plan({"time": SPAN, wanted: ANGLE + 0.02, now: ANGLE, "torque": TORQUE})
    assert [each.column for each in plan.signals if each.signal == "position"] == [now]
    assert not any(each.column == now for each in plan.signals if each.signal == "field")


@pytest.mark.parametrize("word", ["current", "present", "cur"])
def test_a_speed_as_it_is_now_is_the_slip(word: str) -> None:
    now = f"{word}_velocity"
    plan = _plan({"time": SPAN, "goal_velocity": RATE + 0.1, now: RATE, "torque": TORQUE})
    assert [each.column for each in plan.signals if each.signal == "slip"] == [now]


def test_a_place_as_it_is_now_is_no_field_beside_a_speed() -> None:
    columns = {"time": SPAN, "velocity": RATE, "torque": TORQUE}
    plan = _plan({**columns, "target_y": 2.0 * SPAN, "current_y": 1.9 * SPAN})
    assert not any(each.column == "current_y" for each in plan.signals)


@pytest.mark.parametrize(
    ("current", "wanted"),
    [
        ("current_1", "target_1"),
        ("motor_current", "motor_target"),
        ("torque_current", "torque_target"),
        ("current_coil", "current_set"),
    ],
)
def test_a_current_beside_a_target_of_no_motion_stays_a_current(current: str, wanted: str) -> None:
    level = 1.0 + np.floor(SPAN)
    columns = {"time": SPAN, "velocity": RATE, "torque": level * TORQUE}
    plan = _plan({**columns, current: level, wanted: 0.7 * level})
    assert [each.column for each in plan.signals if each.signal == "field"] == [current]


def test_signals_of_a_robot_as_they_are_now_are_taken_without_what_is_wanted() -> None:
    columns = {"current_position": ANGLE, "current_velocity": RATE, "current_torque": TORQUE}
    plan = _plan({"time": SPAN, **columns})
    taken = {each.signal: each.column for each in plan.signals if each.column}
    assert taken == {
        "slip": "current_velocity",
        "position": "current_position",
        "effort": "current_torque",
    }


@pytest.mark.parametrize("name", ["current_torque", "current_load", "current_d", "current_motor"])
def test_a_current_that_is_called_after_no_motion_keeps_its_meaning(name: str) -> None:
    said = {each: spoken_name(each) for each in ("time", "velocity", "torque", name)}
    assert told_by_company(said) == {}


def test_amperes_tell_a_current_that_is_called_after_a_motion() -> None:
    level = 1.0 + np.floor(SPAN)
    columns = {"time": SPAN, "velocity": RATE, "torque": level * TORQUE, "current_position": level}
    plan = plan_of(Table("a", columns, {"current_position": "A"}, "0" * 64), ColumnMap())
    assert [each.column for each in plan.signals if each.signal == "field"] == ["current_position"]


@pytest.mark.parametrize("place", ["BRK.", "bench/brake/", "PLC1.DB7:", "Rig3_"])
def test_a_place_in_front_of_all_names_says_nothing(place: str) -> None:
    level = 1.0 + np.floor(SPAN)
    columns = {f"{place}I_ist": level, f"{place}n_ist": RATE, f"{place}M_ist": level * TORQUE}
    units = {f"{place}I_ist": "A", f"{place}n_ist": "rad/s", f"{place}M_ist": "Nm"}
    plan = plan_of(Table("a", {"t": SPAN, **columns}, units, "0" * 64), ColumnMap())
    taken = {each.signal: each.column for each in plan.signals if each.column}
    assert not plan.questions
    assert taken == {
        "field": f"{place}I_ist",
        "slip": f"{place}n_ist",
        "effort": f"{place}M_ist",
    }


@pytest.mark.parametrize("place", ["Motor.", "servo_", "ESC/", "model."])
def test_a_place_with_a_meaning_stays(place: str) -> None:
    said = {name: spoken_name(name) for name in ("t", f"{place}I", f"{place}n", f"{place}M")}
    assert told_by_company(said) == {}


def test_names_that_are_understood_with_their_place_keep_it() -> None:
    said = {name: spoken_name(name) for name in ("t", "brake.torque", "brake.I", "brake.n")}
    assert told_by_company(said) == {}

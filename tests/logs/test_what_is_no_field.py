"""What a controller, a drive or a spare input logs is no field, by name and course. SYNTHETIC."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs import Plan
from erclutch.signals.array import Array
from tests.support.plans_of_columns import planned

TIME = np.arange(400.0) / 100
TURN = np.sin(3 * TIME)
EFFORT = 4 * np.cos(3 * TIME) + TURN
SCATTER = 0.1 * np.random.default_rng(5).normal(size=TIME.size)
JOINT = {
    "time [s]": TIME,
    "vel_act [rad/s]": TURN,
    "torque_act [N*m]": EFFORT,
    "vel_des [rad/s]": TURN + 0.3 * np.sin(11 * TIME),
}
RIG = {"time [s]": TIME, "Displacement [mm]": TURN, "Force [kN]": EFFORT}


def open_signals(plan: Plan) -> list[str]:
    """The signals that are asked about, by a question or a doubt."""
    return [question.signal for question in plan.questions] + ["doubt"] * len(plan.doubts)


@pytest.mark.parametrize("names", ["k{}_store", "K{}", "k_{}"])
def test_numbered_gains_of_a_controller_are_no_field(names: str) -> None:
    gains = {names.format(n): 1 + np.sin(n * TIME) for n in (1, 2, 3)}
    assert open_signals(planned({**JOINT, **gains})) == []


def test_a_letter_k_alone_and_a_relay_may_be_the_field() -> None:
    assert open_signals(planned({**JOINT, "k1": 1 + np.sin(TIME)})) == ["field"]
    relays = {f"K{n}": (TIME * n % 2 > 1).astype(float) for n in (1, 2, 3)}
    assert open_signals(planned({**JOINT, **relays})) == ["field"]
    without_a_controller = {label: JOINT[label] for label in list(JOINT)[:3]}
    gains = {f"k{n}": 1 + np.sin(n * TIME) for n in (1, 2, 3)}
    assert open_signals(planned({**without_a_controller, **gains})) == ["field"]


@pytest.mark.parametrize("name", ["i2t", "I2T", "i²t"])
def test_the_number_that_guards_a_drive_against_heat_is_no_field(name: str) -> None:
    parts: Array = np.floor(TIME)
    assert open_signals(planned({**JOINT, name: parts})) == []


@pytest.mark.parametrize("name", ["i", "i [A]", "current [A]"])
def test_a_current_with_the_sign_of_the_effort_is_that_of_a_drive_that_was_told_to_move(
    name: str,
) -> None:
    plan = planned({**JOINT, name: 0.5 * EFFORT + SCATTER})
    assert open_signals(plan) == []
    assert any("taken for the current of the drive, left out (--field" in n for n in plan.notes)


def test_a_current_with_the_sign_of_the_effort_is_doubted_where_no_drive_was_told() -> None:
    without_a_set_point = {label: JOINT[label] for label in list(JOINT)[:3]}
    plan = planned({**without_a_set_point, "i [A]": 0.5 * EFFORT + SCATTER})
    assert open_signals(plan) == ["doubt"]


def test_a_current_of_its_own_sign_stays_the_field_beside_a_motion_that_was_told() -> None:
    plan = planned({**JOINT, "i [A]": np.abs(EFFORT) / 4})
    field = plan.signal("field")
    assert field is not None
    assert field.column == "i"


@pytest.mark.parametrize("name", ["Aux Input 5 [V]", "AI 3 [V]", "Eingang 2 [V]"])
def test_an_input_with_the_sign_of_the_effort_is_another_output_of_its_sensor(name: str) -> None:
    plan = planned({**RIG, name: -0.3 * EFFORT + 0.2 * SCATTER})
    assert open_signals(plan) == []
    assert any("another output of its sensor, left out (--field" in note for note in plan.notes)


def test_an_input_that_only_goes_along_with_the_effort_is_asked_about() -> None:
    plan = planned({**RIG, "Aux Input 5 [V]": -0.3 * EFFORT + 2 * SCATTER})
    assert open_signals(plan) == ["field"]


def test_a_current_whose_other_sign_is_noise_is_doubted_beside_a_motion_that_was_told() -> None:
    """A coil's current with an offset of its sensor, and an effort of a device that is only pressed."""
    pressed = {**JOINT, "torque_act [N*m]": np.abs(EFFORT) - 0.02}
    plan = planned({**pressed, "i [A]": 0.5 * np.abs(EFFORT) - 0.01})
    assert open_signals(plan) == ["doubt"]


def test_an_input_of_one_sign_may_be_the_field() -> None:
    plan = planned({**RIG, "Aux Input 5 [V]": np.abs(EFFORT) / 4})
    field = plan.signal("field")
    assert open_signals(plan) != [] or (field is not None and field.column == "Aux Input 5")

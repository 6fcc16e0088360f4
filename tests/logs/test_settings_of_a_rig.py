"""A gap or a load that a rig was set to is asked about where no field is logged and the effort goes with its levels."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.plans_of_columns import planned

ROWS = np.arange(1200.0)
SPEED = 20 + 15 * np.sin(2 * np.pi * ROWS / 100)
GAP = np.repeat([2.0, 3.0, 5.0, 8.0], 300)
TORQUE = 0.05 * SPEED * np.exp(-GAP / 4)
STEADY = 0.05 * SPEED
NAMES = ["Air gap [mm]", "magnet_distance_mm", "Luftspalt [mm]", "Normal load [N]"]


@pytest.mark.parametrize("label", NAMES)
def test_a_setting_that_parts_the_efforts_is_asked_about(label: str) -> None:
    columns = {"t [s]": ROWS / 100, "w [rad/s]": SPEED, label: GAP, "torque [N*m]": TORQUE}
    plan = planned(columns)
    assert [question.signal for question in plan.questions] == ["field"]
    assert f"--field {label}" in plan.command().replace('"', "").replace("'", "")
    assert not planned(columns, field=label).questions
    assert not planned(columns, field="none").questions


@pytest.mark.parametrize("label", [NAMES[0], NAMES[3]])
def test_a_setting_with_which_no_effort_goes_is_not_asked_about(label: str) -> None:
    columns = {"t [s]": ROWS / 100, "w [rad/s]": SPEED, label: GAP, "torque [N*m]": STEADY}
    assert not planned(columns).questions


def test_beside_a_current_a_gap_is_not_asked_about() -> None:
    current = np.repeat([0.0, 1.0, 0.0, 1.0], 300)
    columns = {"t [s]": ROWS / 100, "w [rad/s]": SPEED, "I [A]": current, NAMES[0]: GAP}
    assert not planned({**columns, "torque [N*m]": TORQUE * (1 + current)}).questions


@pytest.mark.parametrize("label", ["Magnet position [mm]", "vane angle [deg]", "Supply [bar]"])
def test_levels_of_any_name_with_which_the_effort_goes_are_asked_about(label: str) -> None:
    """The rows of all places of a magnet were one log at no field, in silence."""
    columns = {"t [s]": ROWS / 100, "w [rad/s]": SPEED, label: GAP, "torque [N*m]": TORQUE}
    assert [question.signal for question in planned(columns).questions] == ["field"]
    assert not planned({**columns, "torque [N*m]": STEADY}).questions


def test_levels_of_a_temperature_are_no_field() -> None:
    columns = {"t [s]": ROWS / 100, "w [rad/s]": SPEED, "torque [N*m]": TORQUE}
    assert not planned({**columns, "Temp [°C]": 10 * GAP}).questions


_RNG = np.random.default_rng(5)
SWITCHED = np.repeat([0.0, 2.0, 1.0, 4.0, 0.0, 3.0], 200) + 0.02 * _RNG.standard_normal(1200)
TO_AND_FRO = 15.0 * np.sin(2.0 * np.pi * ROWS / 70.0)
PRESSED = (0.5 + SWITCHED) * np.tanh(TO_AND_FRO) + 0.02 * TO_AND_FRO


@pytest.mark.parametrize("label", ["P [bar]", "pressure [kPa]", "clamp force [N]"])
def test_a_pressure_that_wanders_and_presses_is_asked_about(label: str) -> None:
    columns = {"t [s]": ROWS / 100, "w [rad/s]": TO_AND_FRO, "torque [N*m]": PRESSED}
    plan = planned({**columns, label: SWITCHED})
    (question,) = plan.questions
    assert question.signal == "field"
    assert "at the same slip the effort is larger under more" in question.problem
    assert not planned({**columns, label: SWITCHED}, field=label).questions
    assert not planned({**columns, label: SWITCHED}, field="none").questions


def test_a_pressure_that_presses_nothing_is_not_asked_about() -> None:
    columns = {"t [s]": ROWS / 100, "w [rad/s]": TO_AND_FRO}
    friction = 2.0 * np.tanh(TO_AND_FRO) + 0.02 * TO_AND_FRO
    assert not planned({**columns, "torque [N*m]": friction, "P [bar]": SWITCHED}).questions
    # A gas spring's pressure follows the travel of the damper, and its friction goes with the effort.
    travel = np.cumsum(TO_AND_FRO)
    travel = travel - travel.min()
    assert not planned({**columns, "torque [N*m]": friction, "P [bar]": travel}).questions

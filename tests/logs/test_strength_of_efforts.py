"""A column whose name says nothing is offered as the field where the effort goes with it. SYNTHETIC."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.plans_of_columns import planned

ROWS = 4000
TIME = np.arange(ROWS) / 500.0
_RNG = np.random.default_rng(3)
TRAVEL = 0.4 * np.sin(7.0 * TIME) + 0.2 * np.sin(23.0 * TIME)
SPEED = np.gradient(TRAVEL, TIME)
COMMAND = np.repeat(_RNG.choice((0.0, 2.3), ROWS // 250), 250)
# A supply that overshoots behind each switch, with the noise of its sensor.
SUPPLY = COMMAND + 0.4 * np.gradient(COMMAND) + 0.02 * _RNG.standard_normal(ROWS)
FORCE = (500.0 + 300.0 * COMMAND) * np.tanh(2.0 * SPEED) + 60.0 * SPEED
MOTION = {"t": TIME, "D": TRAVEL, "V": SPEED, "F": FORCE}


@pytest.mark.parametrize("name", ["Y", "Z1", "u", "ch4"])
def test_what_the_effort_goes_with_is_offered(name: str) -> None:
    plan = planned({**MOTION, name: SUPPLY})
    field = plan.signal("field")
    is_taken = field is not None and field.column == name  # one letter is a field by its name
    assert is_taken or plan.command().endswith(f'--field "{name}"')


def test_the_reason_is_said() -> None:
    plan = planned({**MOTION, "Y": SUPPLY})
    (question,) = plan.questions
    assert "at the same slip the effort is larger where Y is" in question.problem
    assert plan.command().endswith('--field "Y"')


@pytest.mark.parametrize(
    ("what", "other"),
    [
        ("noise of one sign", 2.0 + _RNG.standard_normal(ROWS)),
        ("the effort's size", np.abs(FORCE)),
        ("a power", np.abs(FORCE * SPEED)),
        ("a position from zero up", TRAVEL + 1.0),
        ("both signs", SUPPLY - 1.15),
        ("a warming fluid, in which the effort falls", 3.0 - SUPPLY),
    ],
)
def test_other_columns_are_not_offered(what: str, other: np.ndarray) -> None:
    plan = planned({**MOTION, "Y": other})
    assert "the effort is larger where" not in " ".join(each.problem for each in plan.questions), (
        what
    )


def test_of_two_such_columns_none_is_offered() -> None:
    plan = planned({**MOTION, "Y": SUPPLY, "Z": SUPPLY**2 + 0.1})
    assert "the effort is larger where" not in " ".join(each.problem for each in plan.questions)


def test_a_recording_of_one_row_is_asked_about() -> None:
    """A table that is split by a word of a column may have a recording of one row."""
    labels = (
        "Timestamp_ms [ms]",
        "Velocity_rot_s [turn/s]",
        "MeasuredTorque_Nm [N*m]",
        "Switching",
    )
    plan = planned({label: np.array([3.0]) for label in labels})
    assert "field" in [each.signal for each in plan.questions]

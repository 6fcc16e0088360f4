"""A column that numbers the parts of a test is asked about where the effort differs between parts of one motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, plan_of, read_table
from erclutch.logs.applied import apply
from tests.support.plans_of_columns import planned

ROWS = np.arange(1200.0)
SPEED = 15 * np.sin(2 * np.pi * ROWS / 100)
PART = np.repeat([1.0, 2.0, 3.0, 4.0], 300)
FRICTION = np.tanh(SPEED)
AT_FIELDS = (0.2 + 0.5 * (PART - 1.0)) * FRICTION
NAMES = ["cycle", "Step", "Test No", "Run", "trial", "Versuch", "ID", "test_number"]


@pytest.mark.parametrize("name", NAMES)
def test_parts_with_which_the_effort_goes_are_asked_about(name: str) -> None:
    columns = {"t [s]": ROWS / 100, name: PART, "w [rad/s]": SPEED, "torque [N*m]": AT_FIELDS}
    plan = planned(columns)
    assert [question.signal for question in plan.questions] == ["field"]
    assert "part 4 has 8.5 times the effort of part 1" in plan.questions[0].problem
    assert '--scale "field=STEP A" --zero field=1' in plan.command()
    assert not planned(columns, field="none").questions


@pytest.mark.parametrize("name", NAMES)
def test_parts_with_which_no_effort_goes_are_no_field(name: str) -> None:
    columns = {"t [s]": ROWS / 100, name: PART, "w [rad/s]": SPEED, "torque [N*m]": FRICTION}
    assert not planned(columns).questions


def test_parts_at_speeds_of_their_own_are_not_held_against_each_other() -> None:
    """Steps of the speed: a viscous torque is larger in a fast part, at no field at all."""
    speed = SPEED * (2.0 ** (PART - 1.0))
    columns = {"t [s]": ROWS / 100, "step": PART, "w [rad/s]": speed, "torque [N*m]": 0.1 * speed}
    assert not planned(columns).questions


def test_parts_of_a_position_are_held_against_each_other_at_one_rate() -> None:
    """Larger strokes are faster, so a viscous force is larger at no field at all; so is that of a spring."""
    stroke = 0.02 * np.sin(2 * np.pi * ROWS / 100)
    force = (100.0 + 400.0 * (PART - 1.0)) * np.sign(np.cos(2 * np.pi * ROWS / 100))
    columns = {"t [s]": ROWS / 100, "cycle": PART, "stroke [m]": stroke, "force [N]": force}
    assert [question.signal for question in planned(columns).questions] == ["field"]
    larger = stroke * PART
    viscous = 5e3 * np.gradient(larger, 0.01)
    for force in (viscous, 1e4 * larger):
        rows = {**columns, "stroke [m]": larger, "force [N]": force}
        assert not planned(rows).questions


def test_beside_a_current_parts_are_not_asked_about() -> None:
    columns = {"t [s]": ROWS / 100, "run": PART, "w [rad/s]": SPEED, "I [A]": PART - 1.0}
    assert not planned({**columns, "torque [N*m]": AT_FIELDS}).questions


@pytest.mark.usefixtures("read_here")
def test_the_command_with_its_step_filled_in_makes_the_field(tmp_path: Path) -> None:
    log = tmp_path / "runs.csv"
    rows = np.column_stack([ROWS / 100, PART, SPEED, AT_FIELDS])
    head = "t [s],run,w [rad/s],torque [Nm]"
    np.savetxt(log, rows, delimiter=",", header=head, comments="", fmt="%.6g")
    table = read_table(log)
    command = plan_of(table, ColumnMap()).command()
    assert '--field "run" --scale "field=STEP A" --zero field=1' in command
    told = ColumnMap.from_labels({"field": "run"}, scales={"field": "0.5 A"}, zeros={"field": "1"})
    field = np.asarray(apply(plan_of(table, told), table).signals["field"])
    np.testing.assert_allclose(field, 0.5 * (PART - 1.0), atol=1e-12)

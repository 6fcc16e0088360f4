"""The time of a loop beside that of its computer is one time; numbers copied beside a table are no field."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
from erclutch.signals.array import Array

SPAN = np.arange(500.0) * 0.005
SPEED = np.sin(9.0 * SPAN)
SWITCHED: Array = (SPAN > 1.5).astype(np.float64)


def _plan(**columns: Array) -> Plan:
    table = Table("a", {**columns, "speed": SPEED, "torque": np.tanh(SPEED)}, {}, "0" * 64)
    return plan_of(table, ColumnMap())


def test_of_two_columns_that_tell_one_time_the_first_is_taken() -> None:
    late = 703.8 + SPAN + 2e-4 * np.cos(40.0 * SPAN)
    plan = _plan(state_time=late, loop_time=SPAN)
    assert plan.clock is not None
    assert plan.clock.column == "state_time"


def test_two_columns_that_drift_apart_are_asked_about() -> None:
    plan = _plan(state_time=703.8 + 1.1 * SPAN, loop_time=SPAN)
    assert any(question.signal == "time" for question in plan.questions)


def test_numbers_without_a_name_beside_a_table_are_proposed_for_no_field() -> None:
    plan = _plan(time=SPAN, c5=23.0 + 0.05 * (np.arange(500.0) // 100))
    assert not any("c5" in example for example in plan.examples)


@pytest.mark.parametrize("name", ["did_toe_off", "heel strike", "did_switch_on"])
def test_an_event_of_a_step_is_proposed_for_no_field(name: str) -> None:
    plan = _plan(time=SPAN, elbow_velocity=0.5 * SPEED, **{name: SWITCHED})
    assert not any(name in example for example in plan.examples)


def test_a_switch_of_a_coil_is_still_proposed() -> None:
    plan = _plan(time=SPAN, elbow_velocity=0.5 * SPEED, coil_on=SWITCHED)
    fields = [each.column for each in plan.signals if each.signal == "field"]
    assert fields == ["coil_on"] or any("coil_on" in example for example in plan.examples)

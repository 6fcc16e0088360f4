"""Names that say something beside the others of their table: a letter in front of all, a file's ending behind all."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Plan, Table, plan_of
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

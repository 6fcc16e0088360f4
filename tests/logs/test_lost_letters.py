"""Names whose letters a program could not write say nothing, and the layers of a print are no motion."""

from __future__ import annotations

import numpy as np
import pytest

from erclutch.logs import ColumnMap, Table, plan_of
from erclutch.logs.columns.names import spoken_name

ROWS = np.arange(200.0)


@pytest.mark.parametrize("name", ["?i", "\ufffdi", "?v", "?F", "cot ?v"])
def test_a_name_without_its_first_letter_says_nothing(name: str) -> None:
    said = spoken_name(name)
    assert not said.may_be
    assert not said.within
    assert not said.lettered
    assert not any(said.forms.values())


@pytest.mark.parametrize(("name", "signal"), [("force?", "effort"), ("speed (?)", "slip")])
def test_a_question_mark_behind_a_name_takes_nothing_from_it(name: str, signal: str) -> None:
    assert signal in spoken_name(name).may_be


def test_an_angle_whose_greek_letter_is_lost_is_no_current() -> None:
    columns = {"Turn Radius": 3.0 + ROWS, "?i": 30.0 - 0.1 * ROWS, "?o": 25.0 - 0.08 * ROWS}
    plan = plan_of(Table("a", columns, {}, "0" * 64), ColumnMap())
    assert not any(each.column in ("?i", "?o") for each in plan.signals)


@pytest.mark.parametrize("name", ["Layer Height", "Schicht hoch", "layers printed"])
def test_the_height_of_a_layer_is_no_position(name: str) -> None:
    columns = {"time": 0.1 * ROWS, name: 30.0 + 20.0 * (ROWS // 50), "load": np.sin(0.1 * ROWS)}
    units = {"time": "s", name: "um", "load": "N"}
    plan = plan_of(Table("a", columns, units, "0" * 64), ColumnMap())
    assert not any(each.column == name for each in plan.signals)

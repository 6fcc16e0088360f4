"""Names that mislead: letters that a program could not write, lengths that never move, what a torque is made of."""

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


@pytest.mark.parametrize("name", ["Moment arm", "lever_arm", "Torque Arm", "Hebelarm"])
def test_the_arm_of_a_moment_is_no_position(name: str) -> None:
    columns = {"Test #": 1.0 + ROWS, name: 15.0 + 3.0 * (ROWS > 99), "Torque": np.sin(0.1 * ROWS)}
    units = {"Test #": None, name: "cm", "Torque": "Nm"}
    plan = plan_of(Table("a", columns, units, "0" * 64), ColumnMap())
    assert not any(each.column == name for each in plan.signals)


def test_the_force_at_a_lever_arm_is_a_force() -> None:
    assert "effort" in spoken_name("lever arm force").may_be


@pytest.mark.parametrize(
    ("name", "signal"),
    [
        ("ankle_torque_from_current", "effort"),
        ("speed from encoder", "slip"),
        ("Drehmoment aus Strom", "effort"),
    ],
)
def test_what_a_quantity_was_made_of_is_not_its_head(name: str, signal: str) -> None:
    assert spoken_name(name).may_be == {signal}


def test_a_current_from_a_supply_is_no_field() -> None:
    assert "field" not in spoken_name("current_from_supply").may_be

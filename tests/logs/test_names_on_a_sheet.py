"""A sheet of numbers without names beside a sheet that holds one row of names."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openpyxl import Workbook

from erclutch.logs import ColumnMap, Table, plan_of
from erclutch.logs.readers.names_on_a_sheet import named_by
from erclutch.logs.readers.spreadsheet import find

SPAN = np.arange(60.0) * 0.05
SPEED = np.sin(2.0 * SPAN)
NAMES = ["Zeit [s]", "Drehzahl [rad/s]", "Drehmoment [Nm]"]
NUMBERS = np.column_stack([SPAN, SPEED, 3.0 * np.tanh(4.0 * SPEED)]).tolist()


def _workbook(path: Path, sheets: dict[str, list[list[Any]]]) -> Path:
    book = Workbook()
    for name in book.sheetnames:
        del book[name]
    for name, rows in sheets.items():
        sheet: Any = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


def test_the_names_of_another_sheet_are_those_of_the_columns(tmp_path: Path) -> None:
    path = _workbook(tmp_path / "a.xlsx", {"Werte": NUMBERS, "Namen": [NAMES]})
    table = find(str(path), None)  # in this process: the child is not the point
    assert [*table.columns] == ["Zeit", "Drehzahl", "Drehmoment"]
    assert table.units == {"Zeit": "s", "Drehzahl": "rad/s", "Drehmoment": "Nm"}
    assert table.rows == SPAN.size
    assert "names of the columns are those of sheet Namen" in table.notes


def test_the_names_may_stand_anywhere_on_a_sheet_in_front(tmp_path: Path) -> None:
    path = _workbook(tmp_path / "a.xlsx", {"Namen": [[], [None, *NAMES]], "Werte": NUMBERS})
    assert "Drehzahl" in find(str(path), None).columns


@pytest.mark.parametrize(
    "other",
    [
        [NAMES[:1]],  # a remark
        [[*NAMES, "Strom [A]"]],
        [NAMES, ["gemessen am", "Montag", "frueh"]],
        [["x", "x", "y"]],
        [["Zeit", 3, "Moment"]],
    ],
)
def test_a_sheet_that_says_something_else_names_nothing(
    tmp_path: Path, other: list[list[Any]]
) -> None:
    path = _workbook(tmp_path / "a.xlsx", {"Werte": NUMBERS, "Notiz": other})
    assert [*find(str(path), "Werte").columns] == ["c1", "c2", "c3"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "wanted"),
    [
        (NAMES[:2], "--field none --effort c3 --slip 'Drehzahl [rad/s]' --time 'Zeit [s]'"),
        (
            ["t (s)", "omega (rad/s)", "Corriente [A]", "Tension [V]"],
            "--effort c5 --field 'Corriente [A]' --slip 'omega [rad/s]' --time 't [s]'",
        ),
    ],
)
def test_fewer_names_than_columns_are_asked_about_with_what_is_left_over(
    tmp_path: Path, names: list[str], wanted: str
) -> None:
    current = np.repeat([0.0, 0.5, 1.0, 0.25], 15)
    torque = (0.2 + 3.0 * current) * np.tanh(4.0 * SPEED)
    others = [] if len(names) == 2 else [current, 12.0 - 0.3 * current]
    rows = np.column_stack([SPAN, SPEED, *others, torque]).tolist()
    path = _workbook(tmp_path / "a.xlsx", {"Werte": rows, "Namen": [names]})
    table = replace(find(str(path), None), path="a.xlsx")
    plan = plan_of(table, ColumnMap())
    assert "rows have" in table.unsure_names
    assert shlex.join(shlex.split(plan.command())[3:]) == wanted


def test_two_sheets_of_names_are_one_too_many(tmp_path: Path) -> None:
    named = {"Werte": NUMBERS, "A": [NAMES], "B": [["t", "n", "M"]]}
    path = _workbook(tmp_path / "a.xlsx", named)
    assert [*find(str(path), "Werte").columns] == ["c1", "c2", "c3"]


def test_a_table_with_names_of_its_own_asks_no_other_sheet() -> None:
    class Shut:
        sheet_names = ("Werte", "Namen")

        def get_sheet_by_name(self, name: str) -> Any:
            raise AssertionError(name)

    table = Table("a", {"w": SPEED}, {}, "0" * 64)
    assert named_by(table, Shut(), "Werte") is table

"""A sheet of numbers without names beside a sheet that holds one row of names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openpyxl import Workbook

from erclutch.logs import Table
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
        [NAMES[:2]],  # a name less
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

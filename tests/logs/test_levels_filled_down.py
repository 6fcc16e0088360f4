"""A level that stands in the first row of its rows alone holds for all of them; other blanks stay blanks. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import openpyxl
import pytest

from erclutch.logs import read, read_table

SPEED = np.arange(100.0, 1100.0, 100.0)
LEVELS = (0.0, 0.5, 1.0)


def rows_of_a_sheet(speed: np.ndarray = SPEED) -> list[list[float | None]]:
    """Current, speed in rpm and torque; the current stands in the first row of each level alone."""
    return [
        [level if row == 0 else None, float(each), 0.1 + 2.0 * level + 1e-4 * float(each)]
        for level in LEVELS
        for row, each in enumerate(speed)
    ]


def as_text(path: Path, rows: list[list[float | None]], delimiter: str = ",") -> Path:
    names = ("Coil current [A]", "Disc speed [rpm]", "Braking torque [N·m]")
    cells = [["" if cell is None else f"{cell:.9g}" for cell in row] for row in rows]
    lines = [delimiter.join(line) for line in (names, *cells)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("speed", [SPEED, SPEED[::-1]])
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_a_level_holds_down_to_the_next(tmp_path: Path, delimiter: str, speed: np.ndarray) -> None:
    log = read(as_text(tmp_path / "sheet.csv", rows_of_a_sheet(speed), delimiter))
    np.testing.assert_array_equal(log.signals["field"], np.repeat(LEVELS, SPEED.size))
    np.testing.assert_allclose(log.signals["slip"] * 30.0 / np.pi, np.tile(speed, 3))
    assert any("holds down to the next" in note for note in log.notes)


@pytest.mark.usefixtures("read_here")
def test_so_do_merged_cells_of_a_workbook(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    sheet.append(["Coil current [A]", "Disc speed [rpm]", "Braking torque [N·m]"])
    for row in rows_of_a_sheet():
        sheet.append(row)
    for place in range(len(LEVELS)):
        sheet.merge_cells(f"A{2 + 10 * place}:A{11 + 10 * place}")
    book.save(tmp_path / "sheet.xlsx")
    log = read(tmp_path / "sheet.xlsx")
    np.testing.assert_array_equal(log.signals["field"], np.repeat(LEVELS, SPEED.size))


def test_a_level_that_starts_in_the_middle_of_a_course_is_left(tmp_path: Path) -> None:
    rows = rows_of_a_sheet()
    rows[10][0], rows[14][0] = None, 0.5
    table = read_table(as_text(tmp_path / "sheet.csv", rows))
    assert np.isnan(table.columns["Coil current"]).sum() == len(rows) - len(LEVELS)


def test_blanks_of_a_log_in_time_are_left(tmp_path: Path) -> None:
    rows = rows_of_a_sheet()
    for place, row in enumerate(rows):
        row[1] = 10.0 * place
    table = read_table(as_text(tmp_path / "sheet.csv", rows))
    assert np.isnan(table.columns["Coil current"]).sum() == len(rows) - len(LEVELS)


@pytest.mark.parametrize("name", ["Torque [N·m]", "Braking torque [Nm]", "Force [N]"])
def test_an_effort_that_stands_once_a_course_is_not_made_up_for_the_rest(
    tmp_path: Path, name: str
) -> None:
    path = as_text(tmp_path / "sheet.csv", rows_of_a_sheet())
    path.write_text(path.read_text(encoding="utf-8").replace("Coil current [A]", name), "utf-8")
    table = read_table(path)
    (column, *_) = table.columns.values()
    assert np.isnan(column).sum() == len(LEVELS) * (SPEED.size - 1)


def test_what_steps_at_each_level_and_rests_between_is_no_course(tmp_path: Path) -> None:
    rows = rows_of_a_sheet()
    for place, row in enumerate(rows):
        row[1] = 30.0 - place // SPEED.size
        row[2] = float(np.sin(place))
    table = read_table(as_text(tmp_path / "sheet.csv", rows))
    assert np.isnan(table.columns["Coil current"]).sum() == len(rows) - len(LEVELS)

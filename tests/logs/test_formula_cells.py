"""Cells that were written as formulas are read as what they show; our own files have no cell that becomes a formula."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from erclutch.files.spreadsheet_cells import shown_as_words
from erclutch.logs import read
from erclutch.logs.log_writer import write_log
from tests.support.command import good, run

pytestmark = pytest.mark.usefixtures("read_here")
TIME = np.arange(120) / 100
SLIP = np.round(20 * np.sin(10 * TIME), 4)
FIELD = np.where(TIME < 0.6, 0.0, 1.5)
TORQUE = np.round((0.3 + FIELD) * np.tanh(2 * SLIP), 4)
NAMES = ("Time [s]", "Slip [rad/s]", "Current [A]", "Torque [N m]")


def written(path: Path, cell: str, name: str = "{}", mark: str = ",") -> Path:
    lines = [mark.join(name.format(each) for each in NAMES)]
    for row in zip(TIME, SLIP, FIELD, TORQUE, strict=True):
        numbers = [f"{value:.4f}" for value in row]
        numbers = [each.replace(".", ",") for each in numbers] if mark == ";" else numbers
        lines.append(mark.join(cell.format(number) for number in numbers))
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("cell", ['="{}"', '"=""{}"""', "={}", "'{}", "= {}".replace(" ", "")])
@pytest.mark.parametrize("mark", [",", ";", "\t"])
def test_a_number_in_a_formula_is_read(tmp_path: Path, cell: str, mark: str) -> None:
    log = read(written(tmp_path / "log.csv", cell, mark=mark))
    assert log.signals["slip"] == pytest.approx(SLIP)
    assert log.signals["field"] == pytest.approx(FIELD)
    assert log.signals["effort"] == pytest.approx(TORQUE)
    assert any("cells written as formulas" in note for note in log.notes)


@pytest.mark.slow
def test_a_name_in_a_formula_is_read(tmp_path: Path) -> None:
    assert "Understood" in good("inspect", written(tmp_path / "log.csv", "{}", '="{}"'))


@pytest.mark.slow
def test_a_formula_that_wants_computing_is_no_number(tmp_path: Path) -> None:
    path = written(tmp_path / "log.csv", "{}")
    lines = path.read_text().splitlines()
    computed = [f"{line.rpartition(',')[0]},=C{at}*2" for at, line in enumerate(lines[1:], 2)]
    path.write_text("\n".join([lines[0], *computed]) + "\n")
    done = run("inspect", path)
    assert done.code == 2
    assert "column Torque holds text ('=C2*2')" in done.error


@pytest.mark.parametrize("cell", ["=1+1", "+cmd|' /C calc'!A0", "-x", "@SUM(A1)", "\tx"])
def test_no_cell_of_ours_becomes_a_formula(cell: str) -> None:
    assert shown_as_words(cell) == f"'{cell}"


@pytest.mark.parametrize("cell", ["-1.5", "+2e-3", "slip [rad/s]", "a=b", "", ".5"])
def test_numbers_and_words_stay(cell: str) -> None:
    assert shown_as_words(cell) == cell


def test_a_column_of_somebody_else_becomes_no_formula(tmp_path: Path) -> None:
    columns = [("time", "s"), ("=HYPERLINK(A1)", "")]
    path = write_log(tmp_path / "log.csv", columns, [np.zeros((3, 2))], {}, rows=3)
    names = next(line for line in path.read_text().splitlines() if not line.startswith("#"))
    assert next(csv.reader([names])) == ["time [s]", "'=HYPERLINK(A1)"]

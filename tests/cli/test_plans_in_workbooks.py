"""A plan of tests in a workbook beside the logs gives their fields, and is no log itself. The data are SYNTHETIC."""

from __future__ import annotations

import shlex
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest

from tests.support.command import good, run

pytestmark = pytest.mark.slow

TIME = np.arange(400) / 200.0
SPEED = 5.0 * np.sin(6.0 * TIME)
CURRENTS = (0.5, 1.0, 0.25)


def bench(folder: Path, file: str, rows: list[list[Any]], *, sheet_of_notes: bool = False) -> None:
    """Three logs without a field, and a workbook."""
    folder.mkdir()
    for place, current in enumerate(CURRENTS, start=1):
        torque = (0.3 + 1.7 * current) * np.tanh(4.0 * SPEED) + 0.02 * SPEED
        np.savetxt(
            folder / f"run{place}.csv",
            np.column_stack([TIME, SPEED, torque]),
            delimiter=",",
            header="time [s],speed [rad/s],torque [Nm]",
            comments="",
            fmt="%.6g",
        )
    book = openpyxl.Workbook()
    sheet = book.active
    assert sheet is not None
    if sheet_of_notes:
        sheet.append(["Tests of the brake"])
        sheet = book.create_sheet("Matrix")
    for row in rows:
        sheet.append(row)
    book.save(folder / file)


@pytest.mark.parametrize(
    ("file", "rows", "sheet_of_notes"),
    [
        (
            "plan.xlsx",
            [["File", "Current [A]"], ["run1.csv", 0.5], ["run2.csv", 1], ["run3.csv", 0.25]],
            False,
        ),
        (
            "tests.xlsx",
            [
                ["Plan of the brake"],
                [],
                ["No", "Run", "Current (A)", "Operator"],
                [1, "run1", 0.5, "me"],
                [2, "run2", 1.0, "me"],
                [3, "run3", 0.25, "you"],
            ],
            False,
        ),
        (
            "Versuchsplan.xlsx",
            [
                ["Datei", "I / A", "T / °C"],
                ["run1.csv", "0,5", "20"],
                ["run2.csv", "1", "20"],
                ["run3.csv", "0,25", "21"],
            ],
            True,
        ),
        (  # with columns as a log has them
            "plan.xlsx",
            [
                ["Log", "Coil current [A]", "Speed [rpm]", "Torque [Nm]"],
                ["run1.csv", 0.5, 100, 2],
                ["run2.csv", 1, 100, 2],
                ["run3.csv", 0.25, 100, 1],
            ],
            False,
        ),
    ],
)
def test_a_workbook_beside_the_logs_gives_their_fields(
    tmp_path: Path, file: str, rows: list[list[Any]], sheet_of_notes: bool
) -> None:
    bench(tmp_path / "logs", file, rows, sheet_of_notes=sheet_of_notes)
    said = run("inspect", "logs", cwd=tmp_path)
    assert f"{file} says run1.csv 0.5 A, run2.csv 1 A, run3.csv 0.25 A" in said.out
    run("inspect", "logs", "--write-mapping", "logs/erclutch.toml", cwd=tmp_path)
    mapping = tomllib.loads((tmp_path / "logs" / "erclutch.toml").read_text("utf-8"))
    assert mapping["fields"] == {"run1.csv": "0.5 A", "run2.csv": "1 A", "run3.csv": "0.25 A"}
    assert "Understood. Fit them" in run("inspect", "logs", cwd=tmp_path).out


def test_a_workbook_that_is_a_log_stays_one(tmp_path: Path) -> None:
    head = ["time [s]", "current [A]", "speed [rad/s]", "torque [Nm]"]
    torque = (0.3 + 1.7 * 0.5) * np.tanh(4.0 * SPEED) + 0.02 * SPEED
    rows = np.column_stack([TIME, np.full(TIME.size, 0.5), SPEED, torque]).tolist()
    bench(tmp_path / "logs", "run4.xlsx", [head, *rows])
    for place in (1, 2, 3):
        (tmp_path / "logs" / f"run{place}.csv").unlink()
    bench(tmp_path / "other", "run4.xlsx", [head, *rows])
    (tmp_path / "other" / "run4.xlsx").rename(tmp_path / "logs" / "run5.xlsx")
    (tmp_path / "other" / "run1.csv").rename(tmp_path / "logs" / "run1.csv")
    done = run("inspect", "logs", cwd=tmp_path)
    assert "left out" not in done.error


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    rows = [["File", "Current [A]"], ["run1.csv", 0.5], ["run2.csv", 1], ["run3.csv", 0.25]]
    bench(tmp_path / "logs", "plan.xlsx", rows)
    done = run("inspect", "logs", cwd=tmp_path)
    assert done.error.startswith("note: plan.xlsx left out")


def test_the_mapping_of_a_sheet_is_written_with_that_sheet(tmp_path: Path) -> None:
    book = openpyxl.Workbook()
    book.remove(book.worksheets[0])
    for name in ("Run A", "Run B"):
        sheet = book.create_sheet(name)
        sheet.append(["t [s]", "I [A]", "w [rad/s]", "Kraft (V)"])
        for k in range(60):
            sheet.append([k / 100, 0.5, float(np.sin(k / 5)), float(np.tanh(np.sin(k / 5)))])
    book.save(tmp_path / "book.xlsx")
    said = good("inspect", "book.xlsx", "--variable", "Run A", cwd=tmp_path, code=1)
    (line,) = (line for line in said.splitlines() if line.startswith("A mapping file to fill in"))
    words = shlex.split(line.partition(": erclutch ")[2])
    good(*words, cwd=tmp_path, code=1)
    mapping = (tmp_path / "book.xlsx.toml").read_text(encoding="utf-8")
    assert 'variable = "Run A"' in mapping

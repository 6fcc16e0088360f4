"""A look at a file starts a few children, however many recordings or groups the file holds: a start takes a second."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import scipy.io

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, read_table, table_of_log
from erclutch.logs.log_file import recordings_in
from erclutch.logs.read_logs import read_all
from erclutch.logs.readers import child_process
from tests.support.command import good

pytestmark = pytest.mark.slow

TIME = np.arange(80) / 100  # s
LOG = {"t": TIME, "speed": np.sin(9 * TIME), "torque": np.cos(7 * TIME)}


@pytest.fixture
def started(read_here: None, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What each child is asked for, in their order."""
    asked: list[str] = []
    here = child_process.run

    def run(module: str, path: Path, *words: str, memory: int | None = None) -> Any:
        asked.append(words[-1])
        return here(module, path, *words, memory=memory)

    monkeypatch.setattr(child_process, "run", run)
    return asked


@pytest.mark.parametrize("others", [2, 9])
def test_recordings_beside_a_log_without_a_field_are_joined_to_it_in_one_child(
    tmp_path: Path, started: list[str], others: int
) -> None:
    beside = {f"room_{k}": {"t": TIME, "humidity": TIME + k} for k in range(others)}
    scipy.io.savemat(tmp_path / "log.mat", {"test": LOG, **beside})
    table = table_of_log(tmp_path / "log.mat", ColumnMap(), None)
    assert "torque" in table.columns
    assert len(started) == 4  # which one, their names, their tables, and the joints


def test_a_field_in_another_recording_is_still_found(tmp_path: Path, started: list[str]) -> None:
    beside = {"room": {"t": TIME, "humidity": TIME}, "coil": {"t": TIME, "current": 0 * TIME + 2}}
    beside["coil"]["current"][40:] = 1.0
    scipy.io.savemat(tmp_path / "log.mat", {"test": LOG, **beside})
    with pytest.raises(LogError, match=r"--variable 'test \+ coil'"):
        table_of_log(tmp_path / "log.mat", ColumnMap(), None)
    assert len(started) == 4


def test_the_groups_of_a_workbook_are_parted_from_one_reading(
    tmp_path: Path, started: list[str]
) -> None:
    rows = np.arange(200)
    steps = [f"step {k // 20}" for k in rows]
    log = pd.DataFrame({"speed [rad/s]": rows % 7, "torque [N*m]": rows % 5, "step": steps})
    log.to_excel(tmp_path / "log.xlsx", index=False)
    groups = recordings_in(tmp_path / "log.xlsx", "step=all")
    assert len(groups) == 10
    for group in groups:
        assert read_table(tmp_path / "log.xlsx", variable=group).rows == 20
    assert started.count("") <= 2


def book_of(path: Path, tests: int) -> Path:
    """A workbook of a testing machine: results, then a sheet of rows for each test."""
    with pd.ExcelWriter(path) as writer:
        pd.DataFrame({"Test": [1, 2], "Hardness": [1.1, 1.2]}).to_excel(
            writer, sheet_name="Results"
        )
        for test in range(tests):
            rows = pd.DataFrame(
                {
                    "Time [s]": TIME,
                    "Displacement [mm]": np.sin(9 * TIME) + test,
                    "Load [N]": np.cos(7 * TIME) + 0.01 * test,
                }
            )
            rows.to_excel(writer, sheet_name=f"Test {test + 1:03d}", index=False)
    return path


@pytest.mark.parametrize("tests", [3, pytest.param(45, marks=pytest.mark.slow)])
def test_a_workbook_with_a_sheet_for_each_test_is_read_once(
    tmp_path: Path, started: list[str], tests: int
) -> None:
    book_of(tmp_path / "log.xlsx", tests)
    said = good("inspect", "log.xlsx", cwd=tmp_path)
    assert f"{tests} logs;" in said
    assert said.splitlines()[-1] == "Understood. Fit it: erclutch fit log.xlsx --out RUN"
    assert started == [""]


def test_all_sheets_of_a_workbook_are_read_at_once_where_they_are_asked_for(
    tmp_path: Path, started: list[str]
) -> None:
    # Another number of sheets than above: a book of the same bytes has been read already.
    path = book_of(tmp_path / "log.xlsx", 4)
    assert len(recordings_in(path)) == 5
    assert read_table(path, variable="Test 002").rows == 80
    assert len(read_all(path, ColumnMap())) == 4
    assert len(started) == 1

"""Lines above the rows that give each test its field, beside a column that says which test a row is of. SYNTHETIC."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import MappingError
from erclutch.logs import read
from erclutch.logs.log_file import read_table
from erclutch.logs.rows.levels_of_a_legend import with_levels_of_a_legend

LEVELS = (0.0, 0.5, 1.5)
ROWS = 60  # of each test
TIME = np.arange(3 * ROWS) / 100.0
TEST = np.arange(3 * ROWS) // ROWS
SLIP = 3.0 * np.sin(9.0 * TIME)
TORQUE = (0.1 + np.array(LEVELS)[TEST]) * np.tanh(5.0 * SLIP)


def _log(folder: Path, lines: str, header: str, tests: tuple[object, ...]) -> Path:
    rows = [
        f"{tests[test]},{t:.2f},{w:.5f},{m:.5f}"
        for test, t, w, m in zip(TEST, TIME, SLIP, TORQUE, strict=True)
    ]
    path = folder / "log.csv"
    path.write_text("\n".join([lines, "", header, *rows, ""]), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("lines", "column", "tests"),
    [
        ("Test 1: 0 A\nTest 2: 0.5 A\nTest 3: 1.5 A", "Test", (1, 2, 3)),
        ("# run #3 = 1.5 A\n# run #2 = 0.5 A\n# run #1 = 0 A", "Run", (1, 2, 3)),
        ("Trial 7: 0 mA\nTrial 9: 500 mA\nTrial 12: 1500 mA", "Trial no.", (7, 9, 12)),
        ("soft: 0 A\nmiddle: 0.5 A\nhard: 1.5 A", "setting", ("soft", "middle", "hard")),
    ],
)
def test_each_row_has_the_field_of_its_test(
    tmp_path: Path, lines: str, column: str, tests: tuple[object, ...]
) -> None:
    log = read(_log(tmp_path, lines, f"{column},t [s],w [rad/s],M [N*m]", tests))
    assert log.units["field"] == "A"
    np.testing.assert_allclose(log.signals["field"], np.array(LEVELS)[TEST])
    assert any(
        f"lines above the rows tell the field of each {column}" in note for note in log.notes
    )


@pytest.mark.parametrize(
    ("lines", "column"),
    [
        ("Channel 1: 10 V\nChannel 2: 5 V\nChannel 3: 1 V", "Channel"),  # ranges of an amplifier
        ("Test 1: 0 A\nTest 2: 0.5 A", "Test"),  # nobody says what the third had
        ("Test 1: 0.5 A\nTest 2: 0.5 A\nTest 3: 0.5 A", "Test"),  # one field
        ("Test 1: 0 A\nTest 2: 0.5 V\nTest 3: 1 A", "Test"),
        ("Probe 1: 0 A\nProbe 2: 0.5 A\nProbe 3: 1.5 A", "Test"),
    ],
)
def test_other_lines_give_no_row_a_field(tmp_path: Path, lines: str, column: str) -> None:
    table = read_table(_log(tmp_path, lines, f"{column},t [s],w [rad/s],M [N*m]", (1, 2, 3)))
    assert "field" not in table.columns


def test_a_logged_field_needs_no_legend(tmp_path: Path) -> None:
    lines = "Test 1: 0 A\nTest 2: 0.5 A\nTest 3: 1.5 A"
    path = _log(tmp_path, lines, "Test,t [s],w [rad/s],M [N*m]", (1, 2, 3))
    table = read_table(path)
    assert "field" in table.columns
    bare = {name: values for name, values in table.columns.items() if name != "field"}
    logged = type(table)(
        **{**vars(table), "columns": {**bare, "current": TEST * 1.0}, "units": {"current": "A"}}
    )
    assert with_levels_of_a_legend(logged) is logged


def test_numbered_lines_without_a_column_of_tests_are_asked_about_together(tmp_path: Path) -> None:
    lines = "Test 1: 0 A\nTest 2: 0.5 A\nTest 3: 1.5 A"
    path = _log(tmp_path, lines, "sample,t [s],w [rad/s],M [N*m]", (1, 2, 3))
    with pytest.raises(MappingError) as error:
        read(path)
    assert '--constant "field=0, 0.5, 1.5 A"' in error.value.remedy

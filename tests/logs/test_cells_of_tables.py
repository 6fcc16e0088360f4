"""Cells as people and tools write them: lists of joints, and lines that sum up the rows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.logs import ColumnMap, plan_of, read_table
from tests.support.slow_params import slow_behind

COUNT = 60
TIME = 0.01 * np.arange(COUNT)
SPEEDS = np.array([np.sin((4.0 + k) * TIME) for k in range(3)])
EFFORTS = np.array([(1.0 + k) * np.tanh(9.0 * speed) for k, speed in enumerate(SPEEDS)])


def table_of_messages(path: Path, brackets: str, names: str, joints: int = 3) -> Path:
    """Messages of joints as a table: each cell holds a list."""
    start, end = brackets
    lines = ["Time,header.seq,name,position,velocity,effort"]
    for row in range(COUNT):
        parts = (np.cumsum(SPEEDS, axis=1), SPEEDS, EFFORTS)
        cells = [f'"{start}{", ".join(map(str, part[:joints, row]))}{end}"' for part in parts]
        lines.append(f'{TIME[row]:.2f},{row},"{names}",{",".join(cells)}')
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.slow
@pytest.mark.parametrize("brackets", ["()", "[]"])
def test_lists_in_cells_are_columns_of_joints(tmp_path: Path, brackets: str) -> None:
    table = read_table(table_of_messages(tmp_path / "a.csv", brackets, "['hip', 'knee', 'foot']"))
    assert np.array_equal(table.columns["knee.velocity"], SPEEDS[1])
    assert np.array_equal(table.columns["foot.effort"], EFFORTS[2])
    plan = plan_of(table, ColumnMap())
    assert {each.signal: each.column for each in plan.signals if each.column} == {
        "slip": "hip.velocity",
        "effort": "hip.effort",
    }


@pytest.mark.slow
@pytest.mark.parametrize("names", ["['hip', 'knee']", "['hip', 'hip', 'foot']", "[]"])
def test_lists_whose_places_have_no_names_are_numbered(tmp_path: Path, names: str) -> None:
    table = read_table(table_of_messages(tmp_path / "a.csv", "()", names))
    assert np.array_equal(table.columns["velocity_2"], SPEEDS[1])


@pytest.mark.slow
@pytest.mark.parametrize(
    "broken", slow_behind(2, ["(0.1, 0.2)", "(0.1, x, 0.2)", "", "(0.1, 0.2, 0.3"])
)
def test_lists_of_several_lengths_and_broken_lists_stay_text_and_are_told(
    tmp_path: Path, broken: str
) -> None:
    path = table_of_messages(tmp_path / "a.csv", "()", "['hip', 'knee', 'foot']")
    lines = path.read_text().splitlines()
    lines[20] = f'0.19,19,"[]","{broken}","(1, 2, 3)","(1, 2, 3)"'
    path.write_text("\n".join(lines) + "\n")
    table = read_table(path)
    assert "hip.position" not in table.columns
    assert any("column position holds text" in note for note in table.notes)


@pytest.mark.parametrize(
    "words", [("Mean", "SD"), ("Average", "CV"), ("Mittel", "Stabw"), ("x mean", "spread"), ("Ø",)]
)
def test_lines_that_sum_up_the_rows_are_no_rows(tmp_path: Path, words: tuple[str, ...]) -> None:
    speed = np.linspace(5.0, 100.0, 30)
    rows = [f"{k},{w:.3f},{0.1 + 0.01 * w:.4f}" for k, w in enumerate(speed, start=1)]
    below = [f"{word},{50 + k},{0.6 + k}" for k, word in enumerate(words)]
    path = tmp_path / "a.csv"
    path.write_text("No.,Speed [rpm],Torque [N*m]\n" + "\n".join([*rows, *below]) + "\n")
    table = read_table(path)
    assert table.rows == 30
    assert sum("sums up the rows" in note for note in table.notes) == len(words)


def test_a_meter_s_word_in_the_last_row_is_no_sum(tmp_path: Path) -> None:
    rows = [f"{0.1 * k:.1f},{k},{k}" for k in range(30)]
    path = tmp_path / "a.csv"
    path.write_text("Torque [N*m],Speed [rpm],x\n" + "\n".join([*rows, "OL,30,30"]) + "\n")
    assert read_table(path).rows == 31

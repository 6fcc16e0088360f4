"""A logger's remarks among its rows are left out and told, where the rows count on past them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from erclutch import read
from erclutch.errors import LogError
from erclutch.logs.readers.remarks_between_rows import without_remarks

NAMES = "time [s],speed [rad/s],torque [N*m]"
ROWS = [
    f"{k / 100:.2f},{math.sin(k / 9):.4f},{math.tanh(4 * math.sin(k / 9)):.4f}" for k in range(60)
]


def text(*lines: str) -> str:
    return "\n".join([NAMES, *lines, ""])


def written(path: Path, *lines: str) -> Path:
    path.write_text(text(*lines), encoding="utf-8")
    return path


@pytest.mark.slow
def test_rows_beside_remarks_are_read_as_without_them(tmp_path: Path) -> None:
    plain = read(written(tmp_path / "plain.csv", *ROWS))
    lines = [*ROWS[:1], "eoh", *ROWS[1:30], "motor on", *ROWS[30:]]
    log = read(written(tmp_path / "log.csv", *lines))
    for name, values in plain.signals.items():
        np.testing.assert_array_equal(log.signals[name], values)
    told = "2 lines among the rows without a number left out: 'eoh' (line 3), 'motor on' (line 33)"
    assert told in log.notes


@pytest.mark.parametrize("delimiter", [",", ";", "\t", " "])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_remark_stands_in_a_table_of_any_kind(delimiter: str, end: str) -> None:
    rows = [row.replace(",", delimiter) for row in ROWS]
    table = end.join([NAMES, *rows[:20], "pause", *rows[20:], ""])
    found = without_remarks(table)
    assert found is not None
    plain, note = found
    assert plain.split() == end.join([NAMES, *rows, ""]).split()
    assert note.startswith("a line among the rows without a number left out: 'pause' (line 22)")


AGAIN = [*ROWS[:30], "second", *ROWS[:30]]


@pytest.mark.parametrize(
    "lines",
    [
        ROWS,
        AGAIN,  # the time begins anew: another recording
        [*ROWS[:30], "Run 2", *ROWS[30:]],  # a number may be that of a run, or a value
        [*ROWS[:30], "", "second", "", *ROWS[30:]],
        [*ROWS[:30], "second", NAMES, *ROWS[30:]],
        [line for row in ROWS for line in (row, "saved")],  # as many as rows
        [*ROWS, "end"],
        [*ROWS[:5], "pause", *ROWS[5:8]],  # too few rows to tell
        [*ROWS[:30], f"{ROWS[30]}x", *ROWS[31:]],
    ],
)
def test_other_lines_stay(lines: list[str]) -> None:
    assert without_remarks(text(*lines)) is None


@pytest.mark.slow
def test_a_word_between_two_recordings_is_no_remark(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="line 32 has 1 cells where 3 are expected"):
        read(written(tmp_path / "log.csv", *AGAIN))


TURNED = [",".join(row.split(",")[::-1]) for row in ROWS]  # the time stands last
COUNTED = [f"{row.split(',')[1]},{100 + k},{row.split(',')[2]}" for k, row in enumerate(ROWS)]


@pytest.mark.parametrize("rows", [TURNED, COUNTED], ids=["time last", "a count in the middle"])
@pytest.mark.parametrize("place", [1, 30])
def test_any_column_may_count_on_past_a_remark(rows: list[str], place: int) -> None:
    found = without_remarks(text(*rows[:place], "eoh", *rows[place:]))
    assert found is not None
    plain, note = found
    assert plain.split() == text(*rows).split()
    assert f"'eoh' (line {place + 2})" in note


@pytest.mark.parametrize(
    "rows",
    [
        [row.rpartition(",")[0] for row in TURNED],  # nothing counts
        [f"{row.rpartition(',')[0]},{k // 40}" for k, row in enumerate(TURNED)],  # a step or two
        [f"{row.rpartition(',')[0]},{k % 31}" for k, row in enumerate(TURNED)],  # begins anew
        [f"{row},on" if k else row for k, row in enumerate(TURNED[::-1])],  # falls
    ],
)
def test_where_no_column_counts_on_a_word_may_part_two_recordings(rows: list[str]) -> None:
    assert without_remarks(text(*rows[:31], "second", *rows[31:])) is None


@pytest.mark.slow
def test_a_remark_below_the_first_row_leaves_the_rows_as_they_are(tmp_path: Path) -> None:
    names = "torque [N*m],speed [rad/s],time [s]"
    path = tmp_path / "log.csv"
    path.write_text("\n".join([names, TURNED[0], "begin of data", *TURNED[1:], ""]))
    log = read(path)
    assert log.rows == len(ROWS)
    np.testing.assert_allclose(log.time, np.arange(60) / 100, atol=1e-9)

"""Texts of hasty programs: a header without its line end, and numbers in the brackets of a list of one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import ErclutchError
from erclutch.logs import read, read_table
from erclutch.logs.readers.loose_text import with_a_line_of_names, without_brackets, without_matrix

ROWS = np.column_stack(
    [np.arange(40) / 100, np.sin(np.arange(40) / 5), np.cos(np.arange(40) / 5) ** 3]
)


def lines(delimiter: str = ",", decimal: str = ".") -> list[str]:
    return [delimiter.join(f"{cell:.6f}".replace(".", decimal) for cell in row) for row in ROWS]


@pytest.mark.parametrize(
    ("delimiter", "decimal"), [(",", "."), (";", "."), (";", ","), ("\t", ".")]
)
def test_a_first_row_behind_the_names_in_their_line_is_a_row(
    tmp_path: Path, delimiter: str, decimal: str
) -> None:
    names = delimiter.join(("time", "velocity", "torque"))
    path = tmp_path / "run.csv"
    path.write_text(names + delimiter + "\n".join(lines(delimiter, decimal)) + "\n")
    table = read_table(path)
    assert [*table.columns] == ["time", "velocity", "torque"]
    assert np.allclose(np.column_stack([*table.columns.values()]), ROWS, atol=1e-6)
    assert any("taken apart" in note for note in table.notes)


@pytest.mark.parametrize(
    "first",
    [
        "time,velocity,torque",
        "time,velocity,torque,1.0",
        "time,velocity,torque,a,b,c",
        "time,velocity,3,0.0,0.0,1.0",
        "0,0,1,0,0,1",
        ",,,0.0,0.0,1.0",
    ],
)
def test_other_first_lines_stay_as_they_are(first: str) -> None:
    text = "\n".join([first, *lines()])
    assert with_a_line_of_names(text) == (text, "")


def test_numbers_in_brackets_are_numbers(tmp_path: Path) -> None:
    rows = lines()
    cells = rows[0].split(",")
    listed = [f"[{cells[0]}],{cells[1]},[ {cells[2]} ]", *rows[1:]]
    path = tmp_path / "run.csv"
    path.write_text("\n".join(["time,velocity,torque", *listed]))
    table = read_table(path)
    assert np.allclose(np.column_stack([*table.columns.values()]), ROWS, atol=1e-6)
    assert any("2 numbers stand in brackets" in note for note in table.notes)


@pytest.mark.parametrize(
    "text",
    [
        "time [s],speed [rad/s],mu [1]\n0,1,2\n",
        "time,mu\n[s],[1]\n0,1\n",
        "a,b\n[1.0 2.0],3\n",
        "[1.5.2],3\n",
    ],
)
def test_units_and_longer_lists_keep_their_brackets(text: str) -> None:
    assert without_brackets(text) == (text, "")


@pytest.mark.slow
@given(st.text(alphabet="[]0123456789.,;eE+- \n\ttau", max_size=200))
def test_whatever_the_text_no_number_is_made_up(text: str) -> None:
    plain, _ = without_brackets(text)
    assert plain.replace("[", "").replace("]", "").replace(" ", "") == text.replace(
        "[", ""
    ).replace("]", "").replace(" ", "")
    apart, note = with_a_line_of_names(text)
    assert len(apart) == len(text)
    assert (apart != text) == bool(note)


@pytest.mark.slow
def test_a_long_line_of_brackets_takes_time_of_its_length(tmp_path: Path) -> None:
    path = tmp_path / "hostile.csv"
    path.write_text("[" * 200_000 + "\n" + "[ " * 100_000)
    with pytest.raises(ErclutchError):
        read_table(path)


@pytest.mark.parametrize("delimiter", [",", ";"])
@pytest.mark.parametrize("end", ["", "delimiter"])
def test_columns_that_one_row_fills_stand_behind_short_rows(
    tmp_path: Path, delimiter: str, end: str
) -> None:
    """A thrust stand writes the time in which its motor settled into one row, and no cells for it into the others."""
    close = delimiter if end else ""
    rows = lines(delimiter)
    rows[25] += delimiter.join(("", "", "0.0682", "9046"))
    names = delimiter.join(
        ("time", "speed", "torque", "App message", "90% settling time", "Max acceleration")
    )
    path = tmp_path / "stand.csv"
    path.write_text("\n".join([names + close, *(row + close for row in rows)]))
    table = read_table(path)
    assert [*table.columns][:3] == ["time", "speed", "torque"]
    assert np.allclose(np.column_stack([*table.columns.values()][:3]), ROWS, atol=1e-6)
    assert np.isfinite(table.columns["Max acceleration"]).sum() == 1


def test_a_row_with_cells_that_no_name_stands_over_is_still_refused(tmp_path: Path) -> None:
    rows = lines()
    rows[25] += ",,0.0682,9046"
    path = tmp_path / "stand.csv"
    path.write_text("\n".join(["time,speed,torque", *rows]))
    with pytest.raises(ErclutchError, match="line 27 has 6 cells where 3 are expected"):
        read(path)


def test_a_row_that_lacks_a_number_of_the_others_is_still_refused(tmp_path: Path) -> None:
    rows = lines()
    rows[10] = "0.10,0.5"
    rows[25] += ",,0.0682,9046"
    path = tmp_path / "stand.csv"
    path.write_text(
        "\n".join(["time,speed,torque,App message,90% settling time,Max acceleration", *rows])
    )
    with pytest.raises(ErclutchError, match="line 12"):
        read_table(path)


def test_a_table_that_labview_wrote_without_headers_is_a_table(tmp_path: Path) -> None:
    path = tmp_path / "bench.lvm"
    path.write_text("\n".join(lines("\t")))
    assert np.allclose(np.column_stack([*read_table(path).columns.values()]), ROWS, atol=1e-6)


@pytest.mark.slow
@given(
    st.lists(st.tuples(*[st.floats(-1e6, 1e6)] * 3), min_size=2, max_size=8),
    st.sampled_from([" ", ", ", "\t"]),
)
def test_the_rows_of_a_matrix_keep_their_numbers(
    rows: list[tuple[float, ...]], between: str
) -> None:
    text = "x = [" + "; ".join(between.join(map(repr, row)) for row in rows) + "];\n"
    bare, note = without_matrix(text)
    assert note
    read = [[float(cell) for cell in line.replace(",", " ").split()] for line in bare.splitlines()]
    assert np.array_equal(read, rows)


@pytest.mark.slow
@given(st.text(alphabet="[]; =x1,.\n\t", max_size=60))
def test_no_text_of_brackets_breaks_the_reading_of_matrices(text: str) -> None:
    bare, note = without_matrix(text)
    assert note or bare == text

"""Texts of strangers: other signs for a minus, dashes for no value, lines that sum up the rows, units in capitals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import LogError
from erclutch.logs import read_table
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.readers.numerals import with_plain_minus
from erclutch.logs.table import Table
from tests.support.command import run

ROWS = [f"{0.01 * row:.2f},{np.sin(0.3 * row):.4f},{2.0 - row:.1f}" for row in range(40)]
HEAD = "time [s],speed [rad/s],torque [N*m]"


def table_of(folder: Path, text: str, name: str = "a.csv") -> Table:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return read_table(path)


@pytest.mark.parametrize("minus", ["\u2212", "\u2012", "\u2013", "\ufe63", "\uff0d"])
def test_other_signs_for_a_minus_are_read(tmp_path: Path, minus: str) -> None:
    plain = table_of(tmp_path, "\n".join([HEAD, *ROWS]))
    other = table_of(tmp_path, "\n".join([HEAD, *ROWS]).replace("-", minus))
    for name, values in plain.columns.items():
        np.testing.assert_array_equal(other.columns[name], values)
    assert any("read as negative" in note for note in other.notes)


def test_a_power_of_ten_may_have_such_a_sign(tmp_path: Path) -> None:
    table = table_of(
        tmp_path, "a;b\n" + "\n".join(f"{row};1.5E\u22120{row % 3}" for row in range(12))
    )
    np.testing.assert_array_equal(table.columns["b"], [1.5, 0.15, 0.015] * 4)


def test_a_dash_within_words_stays() -> None:
    assert with_plain_minus("MR\u2013damper 10\u201320 A,\u22125") == (
        "MR\u2013damper 10\u201320 A,-5",
        "1 numbers have a minus that is no hyphen: read as negative",
    )


@pytest.mark.slow
@given(st.text(alphabet="0123456789,;. \u2212\u2013-eE\n", max_size=60))
def test_no_digit_is_lost(text: str) -> None:
    plain, _ = with_plain_minus(text)
    assert len(plain) == len(text)
    assert [letter for letter in plain if letter.isdigit()] == [
        letter for letter in text if letter.isdigit()
    ]


@pytest.mark.parametrize("dash", ["-", "--", "---", "\u2013", "\u2014", "\u2212"])
def test_a_dash_alone_is_no_value(tmp_path: Path, dash: str) -> None:
    rows = [*ROWS]
    rows[7] = rows[7].rsplit(",", 1)[0] + f",{dash}"
    table = table_of(tmp_path, "\n".join([HEAD, *rows]))
    assert np.flatnonzero(np.isnan(table.columns["torque"])).tolist() == [7]


@pytest.mark.parametrize("word", ["Mean", "Max:", "Average", "Std. dev", "Mittelwert", "平均"])
def test_lines_that_sum_up_the_rows_are_left_out(tmp_path: Path, word: str) -> None:
    table = table_of(tmp_path, "\n".join([HEAD, *ROWS, "Min,-1.0,-37.0", f"{word},0.1,-17.5", ""]))
    assert table.rows == len(ROWS)
    assert sum("sums up the rows" in note for note in table.notes) == 2


def test_another_word_in_the_last_line_is_told_still(tmp_path: Path) -> None:
    table = table_of(tmp_path, "\n".join([HEAD, *ROWS, "0.40,broken,3.0", ""]))
    assert (
        "line 42, column speed is 'broken' where a number is expected" in table.unreadable["speed"]
    )


def test_units_in_capitals_below_the_names(tmp_path: Path) -> None:
    rows = [f"{0.01 * row:8.3f}{row:10.2f}{2 * row:12.3f}{0.5:8.2f}" for row in range(30)]
    head = "    TIME      DISP       FORCE   CURRENT\n     SEC        MM          KN         A"
    table = table_of(tmp_path, "\n".join([head, *rows]), "a.txt")
    assert table.units == {"TIME": "SEC", "DISP": "mm", "FORCE": "kN", "CURRENT": "A"}


@pytest.mark.slow
def test_minutes_and_seconds_are_a_time_and_begin_anew_at_a_full_hour(tmp_path: Path) -> None:
    stamps = [
        f"{(3599 * 100 + 50 + row) // 6000 % 60:02d}:{(3599 * 100 + 50 + row) % 6000 / 100:06.3f}"
        for row in range(100)
    ]
    rows = [f"{stamp},{row},{row % 7}" for row, stamp in enumerate(stamps)]
    table = table_of(tmp_path, "\n".join(["Elapsed Time,speed [rad/s],torque [N*m]", *rows]))
    assert table.clock is not None
    np.testing.assert_allclose(table.clock, np.arange(100) / 100, atol=1e-9)


def test_names_that_are_units_in_words_tell_the_columns() -> None:
    for name, unit in (
        ("Newtons", "N"),
        ("Amperes", "A"),
        ("Millimetres", "mm"),
        ("Degrees", "deg"),
        ("Volts", "V"),
    ):
        assert split_end(name) == (name, unit)


def test_a_legend_above_the_table_says_what_columns_are(tmp_path: Path) -> None:
    legend = "# Ch1: displacement [mm]\n# Ch2: force in N\n# Ch3: A\n# Operator: Ch1\n"
    rows = [f"{0.01 * row},{row % 5},{row % 3},{row % 2}" for row in range(30)]
    table = table_of(tmp_path, legend + "\n".join(["Time,Ch1,Ch2,Ch3", *rows]))
    assert table.units == {"Time": None, "Ch1 displacement": "mm", "Ch2 force": "N", "Ch3": "A"}
    assert "lines above the table say what columns Ch1, Ch2, Ch3 are" in table.notes


@pytest.mark.parametrize(
    "above", ["force: sensor 3", "speed: 100 rpm\nforce: 20 N", "speed: -5 m/s\nforce: .5 N"]
)
def test_settings_that_are_called_like_columns_are_no_legend(tmp_path: Path, above: str) -> None:
    rows = [f"{0.01 * row},{row % 5},{row % 3}" for row in range(30)]
    table = table_of(tmp_path, f"{above}\n" + "\n".join(["time,speed,force", *rows]))
    assert table.units == {"time": None, "speed": None, "force": None}


def test_a_form_feed_below_a_sum_is_named_by_its_line(tmp_path: Path) -> None:
    """A printer's page break among the first rows ended in a TypeError."""
    rows = "".join(f"{row / 10:.1f} {row % 5} {row % 3}\n" for row in range(40))
    with pytest.raises(LogError, match="line 3 has 0 cells where 3 are expected"):
        table_of(tmp_path, f"t a b\nmean 1 2\n\f\n{rows}", "a.txt")


@pytest.mark.parametrize("between", [" ", ",", "\t"])
@pytest.mark.parametrize(
    "above", ["\f\nt a b\n", "\f\n\v\nt a b\n", "t a b\n\f\n", "t a b\ns A N\n\f\n"]
)
def test_a_page_break_above_the_rows_is_no_line(tmp_path: Path, above: str, between: str) -> None:
    """It ended in an IndexError, or took the place of the names."""
    rows = "".join(f"{row / 10:.1f} {row % 5} {row % 3}\n" for row in range(40))
    table = table_of(tmp_path, (above + rows).replace(" ", between), "a.txt")
    assert [*table.columns] == ["t", "a", "b"]
    assert not any("skipped" in note for note in table.notes)
    if "s A N" in above:
        assert table.units == {"t": "s", "a": "A", "b": "N"}


@pytest.mark.slow
def test_the_mean_of_a_test_to_and_fro_is_no_effort(tmp_path: Path) -> None:
    # It was taken in silence, and efforts forth and back cancel out in it.
    speeds = np.repeat([50.0, 100.0, 200.0, 400.0, 600.0], 4)
    currents = np.tile([0.0, 0.5, 1.0, 1.5], 5)
    largest = 100.0 + 450.0 * currents + 0.4 * speeds
    columns = (speeds, currents, largest, -0.96 * largest, 0.02 * largest)
    names = "Speed (mm/s),Current (A),F_max (N),F_min (N),F_mean (N)"
    table = np.column_stack(columns)
    np.savetxt(tmp_path / "log.csv", table, "%.6g", ",", header=names, comments="")
    said = run("inspect", "log.csv", cwd=tmp_path).out.splitlines()[-1]
    assert "which is the mean of a test to and fro, beside F_max and F_min" in said
    assert said.endswith('--effort "F_max [N]"')


@pytest.mark.slow
def test_the_mean_current_of_each_test_is_offered_as_its_field(tmp_path: Path) -> None:
    # That no field was logged was offered.
    speeds = np.repeat([50.0, 100.0, 200.0, 400.0, 600.0], 4)
    currents = np.tile([0.0, 0.5, 1.0, 1.5], 5)
    torques = 0.2 + 0.9 * currents + 0.0008 * speeds
    table = np.column_stack([speeds, currents, currents + 0.01, torques])
    names = "rpm,I_avg,I_max,T_avg"
    np.savetxt(tmp_path / "log.csv", table, "%.6g", ",", header=names, comments="")
    said = run("inspect", "log.csv", cwd=tmp_path).out.splitlines()[-1]
    assert said.endswith('--time none --field "I_avg" --effort "T_avg"')

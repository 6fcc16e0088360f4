"""Units in cells of their own, rows that sum up the others, names over several lines are read as such. SYNTHETIC."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.logs import read, read_table
from erclutch.logs.readers.unit_columns import with_units_in_cells

TIME = 0.02 * np.arange(60)
SPEED = 0.1 * np.sin(5.0 * TIME)
FORCE = 300.0 * np.sin(5.0 * TIME) - 7.0
CURRENT = np.where(TIME < 0.6, 0.25, 1.5)


def written(path: Path, lines: Sequence[str]) -> Path:
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def rows(form: str) -> list[str]:
    """Rows of time, speed, force and current in A, and in the range that a meter shows it in."""
    lines: list[str] = []
    for t, v, f, i in zip(TIME, SPEED, FORCE, CURRENT, strict=True):
        shown, unit = (i * 1e3, "mA") if i < 1.0 else (i, "A")
        lines.append(form.format(t=t, v=v * 1e3, f=f, i=shown, u=unit))
    return lines


@pytest.mark.parametrize(
    ("names", "form"),
    [
        ([], "{t:.2f},s, {v:.5f},mm/s, {f:.4f},N, {i:g},{u}"),
        (["time,,speed,,force,,current,"], "{t:.2f},s,{v:.5f},mm/s,{f:.4f},N,{i:g},{u}"),
        (
            ["time;unit;speed;unit;force;unit;current;unit"],
            "{t:.2f};s;{v:.5f};mm/s;{f:.4f};N;{i:g};{u}",
        ),
        (["time speed force current"], "{t:.2f} s {v:.5f} mm/s {f:.4f} N {i:g} {u}"),
        (
            ["bench 3", "time\t\tspeed\t\tforce\t\tcurrent\t"],
            "{t:.2f}\ts\t{v:.5f}\tmm/s\t{f:.4f}\tN\t{i:g}\t{u}",
        ),
    ],
)
def test_a_unit_in_a_cell_of_its_own_is_that_of_the_number_before_it(
    tmp_path: Path, names: list[str], form: str
) -> None:
    recording = read(written(tmp_path / "meter.csv", [*names, *rows(form)]))
    assert recording.units == {"field": "A", "slip": "m/s", "effort": "N"}
    np.testing.assert_allclose(recording.signals["slip"], SPEED, atol=1e-7)
    np.testing.assert_allclose(recording.signals["effort"], FORCE, atol=1e-3)
    np.testing.assert_allclose(recording.signals["field"], CURRENT)
    assert recording.period == pytest.approx(0.02)


@pytest.mark.parametrize(
    "lines",
    [
        [
            "time,speed,phase,force",
            *[f"{t:.2f},{v:.4f},A,{f:.3f}" for t, v, f in zip(TIME, SPEED, FORCE, strict=True)],
        ],
        [
            "time,speed,fix,force",
            *[f"{t:.2f},{v:.4f},V,{f:.3f}" for t, v, f in zip(TIME, SPEED, FORCE, strict=True)],
        ],
        [
            f"{t:.2f},{f:.3f},N" for t, f in zip(TIME, FORCE, strict=True)
        ],  # one letter alone may be a flag
        ["time,value,unit", *[f"{k},{k}.5,{'N' if k % 2 else 'mm'}" for k in range(40)]],
    ],
)
def test_letters_under_a_name_and_units_of_several_quantities_stay(lines: list[str]) -> None:
    text = "\n".join(lines) + "\n"
    assert with_units_in_cells(text) == (text, "")


@given(text=st.text(alphabet='0123456789.,; \t\n"smNAV-#', max_size=200))
def test_any_text_is_given_back_or_joined(text: str) -> None:
    joined, note = with_units_in_cells(text)
    assert bool(note) or joined == text


@pytest.mark.parametrize(
    "sums",
    [
        ["{low}", "{high}"],
        ["{low3}", "{high3}"],
    ],
)
def test_the_ends_of_each_range_above_the_rows_are_no_rows(tmp_path: Path, sums: list[str]) -> None:
    table = np.column_stack([TIME, SPEED, FORCE, CURRENT])
    ends: dict[str, str] = {}
    for name, of_rows in (("low", table.min(axis=0)), ("high", table.max(axis=0))):
        ends[name] = ";".join(f"{number:.6f}" for number in of_rows)
        ends[f"{name}3"] = ";".join(f"{number:.4g}" for number in of_rows)
    lines = [";".join(f"{number:.6f}" for number in row) for row in table]
    head = ["time;v;force;current", "s;m/s;N;A", *(line.format(**ends) for line in sums)]
    read_back = read_table(written(tmp_path / "diadem.csv", [*head, *lines]))
    assert read_back.rows == len(TIME)
    assert any("the first 2 rows sum up those below" in note for note in read_back.notes)


@pytest.mark.parametrize(
    "words", [("Minimum", "Maximum"), ("Mean", "Std", "Min", "Max"), ("Mittelwert",)]
)
def test_words_for_a_summary_above_the_rows_are_no_rows(
    tmp_path: Path, words: tuple[str, ...]
) -> None:
    lines = [f"{k},{t:.2f},{f:.3f}" for k, (t, f) in enumerate(zip(TIME, FORCE, strict=True))]
    table = read_table(
        written(
            tmp_path / "log.csv",
            ["point,time [s],force [N]", *[f"{word},1.0,2.0" for word in words], *lines],
        )
    )
    assert table.rows == len(TIME)
    assert list(table.columns) == ["point", "time", "force"]


def test_two_first_rows_that_are_no_ends_of_all_columns_stay(tmp_path: Path) -> None:
    square = np.where(np.arange(60) % 2, 1.0, -1.0)
    lines = [f"{t:.2f},{level},{f:.3f}" for t, level, f in zip(TIME, square, FORCE, strict=True)]
    assert read_table(written(tmp_path / "log.csv", ["time,u,force", *lines])).rows == 60


def test_rows_that_each_begin_with_such_a_word_stay(tmp_path: Path) -> None:
    lines = [f"{word},{k},{k * 2.5}" for k in range(20) for word in ("Max", "Min")]
    assert read_table(written(tmp_path / "peaks.csv", ["what,speed,force", *lines])).rows == 40


@pytest.mark.parametrize(
    "names",
    [
        ["s,mm/s,N,A", "Time,Speed,Force,Current"],
        ["[s],[mm/s],[N],[A]", "t,v,F,I"],
        ['"Time\n(s)","Speed\n(mm/s)","Force\n(N)","Current\n(A)"'],
        ['"Time\r\n[s]","Speed\r\nshaft\r\n[mm/s]","Force\r\n[N]","Current\r\n[A]"'],
    ],
)
def test_units_above_names_and_below_them_in_one_cell(tmp_path: Path, names: list[str]) -> None:
    lines = [
        f"{t:.2f},{v * 1e3:.4f},{f:.3f},{i}"
        for t, v, f, i in zip(TIME, SPEED, FORCE, CURRENT, strict=True)
    ]
    table = read_table(written(tmp_path / "log.csv", [*names, *lines]))
    assert [*table.units.values()] == ["s", "mm/s", "N", "A"]
    assert table.rows == len(TIME)

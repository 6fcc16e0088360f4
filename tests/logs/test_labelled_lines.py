"""Lines with the name of each value before it, as microcontrollers print them, are rows of a table."""

from __future__ import annotations

from pathlib import Path
from time import process_time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import LogError
from erclutch.logs import read, read_table
from erclutch.logs.readers.labelled_lines import READER, time_of
from tests.support.command import good
from tests.support.pace import within

TIME = np.arange(100) / 50
SPEED = np.round(np.sin(3 * TIME), 3)
TORQUE = np.round(np.tanh(10 * SPEED), 3)
FORMS = {
    "colons": "time:{t:g}, speed:{w:g}, torque:{f:g}",
    "spaces behind": "time: {t:g}\tspeed: {w:g}\ttorque: {f:g}",
    "equals": "time={t:g} speed={w:g} torque={f:g}",
    "bars": "time = {t:g} | speed = {w:g} | torque = {f:g}",
    "units": "time: {t:g} s, speed: {w:g} rad/s, torque: {f:g} Nm;",
}


def written(path: Path, form: str, *, above: str = "", between: str = "") -> Path:
    lines = [form.format(t=t, w=w, f=f) for t, w, f in zip(TIME, SPEED, TORQUE, strict=True)]
    lines[50:50] = [between] if between else []
    path.write_text(above + "\n".join([*lines, ""]), encoding="utf-8")
    return path


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("above", ["", "Setup done\nCalibrating...\n"])
def test_each_line_is_a_row(tmp_path: Path, form: str, above: str) -> None:
    table = read_table(written(tmp_path / "log.txt", FORMS[form], above=above))
    assert list(table.columns) == ["time", "speed", "torque"]
    np.testing.assert_array_equal(table.columns["speed"], SPEED)
    np.testing.assert_array_equal(table.columns["torque"], TORQUE)
    assert "each line has the names of its values" in table.notes
    assert table.units["torque"] == ("Nm" if form == "units" else None)


def test_a_line_that_was_cut_is_left_out_with_a_word(tmp_path: Path) -> None:
    table = read_table(written(tmp_path / "log.txt", FORMS["colons"], between="time:1.0, spe"))
    assert table.rows == 100
    assert "lines that do not hold these values left out: 1" in table.notes


@pytest.mark.parametrize("form", ["colons", "units"])
def test_lines_that_lack_a_value_have_an_empty_cell_there(tmp_path: Path, form: str) -> None:
    lines = written(tmp_path / "log.txt", FORMS[form]).read_text().splitlines()
    shorter = [line.partition("torque")[0].rstrip(" ,") for line in lines[60:]]
    (tmp_path / "log.txt").write_text("\n".join([*lines[:60], *shorter, ""]))
    table = read_table(tmp_path / "log.txt")
    assert table.rows == 100
    np.testing.assert_array_equal(np.isnan(table.columns["torque"]), np.arange(100) >= 60)
    np.testing.assert_array_equal(table.columns["speed"], SPEED)
    assert "lines that lack some of the values: 40; their cells are empty" in table.notes


def test_two_kinds_of_lines_are_no_table(tmp_path: Path) -> None:
    path = tmp_path / "log.txt"
    path.write_text("a:1, b:2\n" * 200 + "c:1, d:2\na:1, b:2\n" * 100)
    assert READER.claims(b"a:1, b:2\n" * 4)
    with pytest.raises(LogError, match="100 lines do not hold the values a, b, as 300 lines do"):
        read_table(path)


@pytest.mark.parametrize(
    "head",
    [
        b"Sample rate: 100 Hz\nOperator: 3\nTest: 5\nt,w,T\n1,2,3\n",
        b"t,w,T\n" + b"1,2,3\n" * 20,
        b"12:30:01, 3\n" * 20,
        b"date=2020-01-01 time=12:30:01\n" * 20,
        b"a:1, a:2\n" * 20,
        b'{"a": 1, "b": 2}\n' * 20,
    ],
)
def test_other_texts_are_not_claimed(head: bytes) -> None:
    assert not READER.claims(head)


@pytest.mark.parametrize(
    "form",
    [
        "t{t:.2f} w{w:.3f} T{f:.3f}",
        "t{t:.2f},w{w:.3f},T{f:.3f}",
        "t{t:.2f}w{w:.3f}T{f:.3f}",
        "<t{t:.2f}|w{w:.3f}|T{f:.3f}>",
        "t{t:.2f}\tw{w:.4e}\tT{f:.3f};",
    ],
)
@pytest.mark.parametrize("above", ["", "Setup done\n"])
def test_letters_right_in_front_of_their_numbers_are_names(
    tmp_path: Path, form: str, above: str
) -> None:
    table = read_table(written(tmp_path / "log.txt", form, above=above))
    assert list(table.columns) == ["t", "w", "T"]
    np.testing.assert_allclose(table.columns["t"], TIME)
    np.testing.assert_allclose(table.columns["w"], SPEED)
    np.testing.assert_allclose(table.columns["T"], TORQUE)


@pytest.mark.parametrize(
    "head",
    [
        b"F1,F2,F3\n" + b"1,2,3\n" * 20,
        b"A1 B2\nrest\nA1 B3\nmotion\nA2 B3\nrest\nmotion\nrest\n",
        b"G1 X10 Y20\nG1 X10 Y20 Z5\nM104 S200\n" * 5,
        b"s1 s2 s3\n" * 20,
        b"2024-01-05T12:00:01Z 3\n" * 20,
    ],
)
def test_words_with_numbers_behind_them_are_no_rows(head: bytes) -> None:
    assert not READER.claims(head)


@pytest.mark.slow
def test_a_time_that_is_called_as_a_torque_is_proposed_as_the_time(tmp_path: Path) -> None:
    written(tmp_path / "serial.txt", "T{t:.2f} F{f:.3f} v{w:.3f}")
    said = good("inspect", "serial.txt", cwd=tmp_path, code=1).splitlines()[-1]
    assert '--time "T [s]"' in said


@pytest.mark.slow
@given(st.text(st.sampled_from("ab:=,; \t1.2e-\n"), max_size=300))
def test_any_text_is_claimed_or_not(text: str) -> None:
    READER.claims(text.encode())


@pytest.mark.slow
def test_such_a_log_is_understood(tmp_path: Path) -> None:
    written(tmp_path / "serial.txt", FORMS["units"])
    assert good("inspect", "serial.txt", cwd=tmp_path).splitlines()[-1].startswith("Understood.")


@pytest.mark.slow
@pytest.mark.parametrize(
    "stamp",
    [
        "[{t:.3f}] ",
        "[{t:12.6f}] ",
        "[{ms} ms] ",
        "{t:.3f} ",
        "2025-03-12 10:00:0{t:.3f} INFO ",
        "2025-03-12 10:00:0{whole},{part:03d} - bench.rig - INFO - ",
        "[2025-03-12T10:00:0{t:.3f}] ",
        "[INFO] [174174520{t:.9f}] [bench.node]: ",
        "[WARN] [{t:.6f}]: ",
        "[INFO] time: {t:.3f} s, ",
        "INFO: time: {t:.3f} s, ",
    ],
)
def test_the_time_in_front_of_named_values_is_read(tmp_path: Path, stamp: str) -> None:
    # The current stood in a cell with the time, and was left out with it: behind a logger in silence.
    lines: list[str] = []
    for k in range(400):
        parts = {"t": k / 100, "ms": 10 * k, "whole": k // 100, "part": 10 * k % 1000}
        values = f"current: {k // 100 / 2} A, speed: {k % 37 - 18}.5 rpm, torque: {k % 7 - 3}.25 Nm"
        lines.append(stamp.format(**parts) + values)
    path = tmp_path / "log.txt"
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    log = read(path)
    assert log.period == pytest.approx(0.01)
    assert log.units == {"field": "A", "slip": "rad/s", "effort": "N*m"}
    np.testing.assert_allclose(log.signals["field"], np.repeat([0.0, 0.5, 1.0, 1.5], 100))


@pytest.mark.parametrize(
    "sign", ["[", " ", "1", "2025-03-12 10:00:00 - ", "[1", "_", "a - ", "[INFO] [1", "INFO "]
)
def test_long_lines_with_a_time_take_no_long_time(sign: str) -> None:
    begin = process_time()
    assert time_of(sign * 20_000) is not None
    assert within(process_time() - begin, 0.1)

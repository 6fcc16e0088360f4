"""Texts as bench programs export them are read: brackets of Eastern keyboards, numbered times, results above rows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import AlikeRecordingsError
from erclutch.logs import ColumnMap, Plan, plan_of, read_table, table_of_log
from erclutch.logs.log_file import recordings_of_file
from erclutch.logs.planning.recording_choice import logs_among

ROWS = 300
TIME = np.arange(ROWS) / 100
PLACE = 20 * np.sin(5 * TIME)  # mm
LEVELS = 0.5 * (np.arange(ROWS) // 100)
FORCE = 300 * np.tanh(np.cos(5 * TIME)) * (1 + LEVELS)
NUMBERS = {"t": TIME, "p": PLACE, "e": FORCE, "f": LEVELS}


def rows_of(letters: str, delimiter: str = ",", cell: str = "{:.6g}") -> list[str]:
    """Rows of a text; a letter a column, as in NUMBERS."""
    columns = [NUMBERS[letter] for letter in letters]
    return [delimiter.join(cell.format(values[row]) for values in columns) for row in range(ROWS)]


def planned(folder: Path, text: str) -> Plan:
    path = folder / "log.csv"
    path.write_text(text, encoding="utf-8")
    return plan_of(read_table(path), ColumnMap())


def assert_is_read(plan: Plan, field: bool = True) -> None:
    """Nothing is asked, the position is in mm and the effort in N, and the field is there."""
    assert not plan.questions, [question.short for question in plan.questions]
    position, effort = plan.signal("position"), plan.signal("effort")
    assert position is not None
    assert effort is not None
    assert (position.factor, effort.factor) == (1e-3, 1.0)
    taken = plan.signal("field")
    assert taken is not None
    assert bool(taken.column) == field
    assert plan.clock is not None


@pytest.mark.parametrize(
    "header",
    [
        "时间（s）,位移（mm）,阻尼力（N）,电流（A）",
        "時間［s］,変位［mm］,荷重［N］,電流［A］",
        "时间【s】,位移【mm】,力【N】,电流【A】",
        "Time {s},Stroke {mm},Force {N},Current {A}",
        "Time <s>,Stroke <mm>,Force <N>,Current <A>",
        "Time - s,Stroke - mm,Force - N,Current - A",
        "Time,Stroke,Load,Field\nSeconds,Millimeter,Newton,Ampere",
        "Running Time,Axial Displacement,Axial Force,Current\nSeconds,Millimeters,Newtons,Amps",
        "Seconds,Millimeter,Newton,Ampere",
    ],
)
def test_units_in_brackets_of_any_keyboard_and_in_words_are_read(
    tmp_path: Path, header: str
) -> None:
    assert_is_read(planned(tmp_path, "\n".join([header, *rows_of("tpef")]) + "\n"))


def test_a_bracket_that_holds_no_unit_stays_in_the_name(tmp_path: Path) -> None:
    header = "时间（s）,位移（活塞）,力（N）,电流（A）"
    plan = planned(tmp_path, "\n".join([header, *rows_of("tpef")]) + "\n")
    position = plan.signal("position")
    assert position is None or position.factor == 1.0


@pytest.mark.parametrize(
    "header",
    [
        "Time 1 (s),Force (N),Time 2 (s),Displacement (mm),Time 3 (s),Current (A)",
        "Zeit 1 [s],Kraft [N],Zeit 2 [s],Weg [mm],Zeit 3 [s],Strom [A]",
        "t_F [s],F [N],t_x [s],x [mm],t_I [s],I [A]",
    ],
)
def test_times_that_repeat_the_first_under_numbered_names_are_one(
    tmp_path: Path, header: str
) -> None:
    plan = planned(tmp_path, "\n".join([header, *rows_of("tetptf")]) + "\n")
    assert_is_read(plan)
    assert any("repeats" in note for note in plan.notes)


def test_a_second_stamp_that_differs_is_not_left_out(tmp_path: Path) -> None:
    rows = rows_of("tetptf")
    other = [row.split(",") for row in rows]
    for cells in other:
        cells[2] = f"{float(cells[2]) + 0.003:.6g}"
    header = "Time 1 (s),Force (N),Time 2 (s),Displacement (mm),Time 3 (s),Current (A)"
    plan = planned(tmp_path, "\n".join([header, *map(",".join, other)]) + "\n")
    assert not any("repeats" in note for note in plan.notes)


@pytest.mark.slow
@pytest.mark.parametrize(
    "above",
    [
        '"Results Table 1"\n"","Maximum Load","Extension at Max"\n"","(N)","(mm)"\n"1","512.3","4.2"\n',
        'Results Table 1\n"","Max (N)"\n1,512\n',
    ],
)
def test_results_above_the_rows_of_a_testing_machine_are_left_out_with_a_word(
    tmp_path: Path, above: str
) -> None:
    table = '"Time","Extension","Load"\n"(s)","(mm)","(N)"\n'
    rows = "\n".join(rows_of("tpe", cell='"{:.6g}"'))
    plan = planned(tmp_path, f"{above}\n{table}{rows}\n")
    assert_is_read(plan, field=False)
    assert any("above the table left out" in note for note in plan.notes)


def test_a_broken_row_in_a_table_is_asked_about(tmp_path: Path) -> None:
    rows = rows_of("tpe")
    rows[150] = "1.5,broken,cell"
    plan = planned(tmp_path, "\n".join(["Time (s),Extension (mm),Load (N)", *rows]) + "\n")
    (question,) = plan.questions
    assert "is 'broken' where a number is expected" in question.problem


@pytest.mark.parametrize(
    "cells",
    [
        "Reading: {e:.3f} N,Pos: {p:.3f} mm",
        "F={e:.3f} N,x={p:.3f} mm",
        "Load = {e:.3f} N,{p:.3f} mm",
    ],
)
def test_a_word_before_the_number_of_each_cell_is_left_out(tmp_path: Path, cells: str) -> None:
    rows = [f"{TIME[row]:.4f}," + cells.format(e=FORCE[row], p=PLACE[row]) for row in range(ROWS)]
    plan = planned(tmp_path, "\n".join(["time,force,position", *rows]) + "\n")
    assert_is_read(plan, field=False)


def test_words_that_change_from_row_to_row_are_not_left_out(tmp_path: Path) -> None:
    rows = [
        f"{TIME[row]:.4f},{'FG'[row % 2]}: {FORCE[row]:.3f} N,{PLACE[row]:.3f}"
        for row in range(ROWS)
    ]
    text = "\n".join(["time,reading,position", *rows]) + "\n"
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8")
    assert "reading" not in read_table(path).columns


@pytest.mark.slow
@pytest.mark.parametrize(
    "names", ["Torque:{:.4f},RPM:{:.1f},Current:{:.2f}", "T={:.4f} w={:.1f} I={:.2f}"]
)
def test_a_serial_monitor_stamps_lines_that_name_their_values(tmp_path: Path, names: str) -> None:
    lines: list[str] = []
    for row in range(ROWS):
        stamp = f"12:00:{row // 100:02d}.{row % 100 * 10:03d}"
        lines.append(f"{stamp} -> {names.format(FORCE[row], PLACE[row], LEVELS[row])}")
    path = tmp_path / "log.txt"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    table = read_table(path)
    assert table.rows == ROWS
    assert len(table.columns) == 3
    assert table.clock is not None
    assert table.clock[-1] == pytest.approx(2.99)


@pytest.mark.slow
def test_the_specimens_of_a_testing_machine_are_logs_below_their_results(tmp_path: Path) -> None:
    lines = [
        "Results Table 1,,",
        ",Gauge length,Maximum Force",
        ",(mm),(N)",
        "1,9.6,3196.2",
        "2,9.8,3051.7",
        ",,",
    ]
    for specimen in ("1", "2"):
        lines += [f"{specimen},Time,Displacement,Force", ",(s),(mm),(N)"]
        lines += [f",{row}" for row in rows_of("tpe")[60 * int(specimen) :]]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(AlikeRecordingsError):  # each is a log, and `inspect` reads all of them
        table_of_log(path, ColumnMap(), None)
    assert set(logs_among(path, recordings_of_file(path), ColumnMap(), None)) == {
        "table 2",
        "table 3",
    }


@pytest.mark.slow
def test_a_row_with_words_above_words_is_no_line_of_names_of_a_test(tmp_path: Path) -> None:
    rows = rows_of("tpe")
    rows[100:100] = ["1,home,stop", "2,fault,stop"]
    plan = planned(tmp_path, "\n".join(["Time (s),Extension (mm),Load (N)", *rows]) + "\n")
    (question,) = plan.questions
    assert "is 'home' where a number is expected" in question.problem


@pytest.mark.parametrize(
    "line",
    [
        "{{'t [s]': {t:.3f}, 'x [mm]': {p:.4f}, 'F [N]': {e:.3f}, 'ok': True, 'note': None}}",
        "{{ 't [s]':{t:.3f},'x [mm]':{p:.4f},'F [N]':{e:.3f} }}",
    ],
)
def test_dictionaries_as_python_prints_them_are_rows(tmp_path: Path, line: str) -> None:
    lines = [line.format(t=TIME[row], p=PLACE[row], e=FORCE[row]) for row in range(ROWS)]
    assert_is_read(planned(tmp_path, "\n".join(lines) + "\n"), field=False)


def test_an_apostrophe_in_a_word_of_json_changes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "log.json"
    rows = [
        f'{{"t [s]": {TIME[row]:.3f}, "F [N]": {FORCE[row]:.3f}, "who": "O\'Neil"}}'
        for row in range(ROWS)
    ]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    assert read_table(path).rows == ROWS


@pytest.mark.slow
@pytest.mark.parametrize("of_the_step_before", [True, False])
def test_a_v_that_adds_up_to_its_x_in_a_few_rows_is_not_offered_as_a_voltage(
    tmp_path: Path, of_the_step_before: bool
) -> None:
    speed = np.minimum(0.5 * np.arange(35), 2.3)
    steps = speed[:-1] if of_the_step_before else speed[1:]
    place = np.concatenate([[0.0], np.cumsum(steps * 0.01)])
    slip = np.minimum(speed, 0.9 * speed**2)
    rows = [
        f"{0.01 * row:.9g},{speed[row]:.9g},{place[row]:.9g},{3 * np.tanh(slip[row]):.9g},{slip[row]:.9g},{row % 7}"
        for row in range(35)
    ]
    plan = planned(tmp_path, "\n".join(["t,v,x,F,relative speed,zz", *rows]) + "\n")
    assert [question.signal for question in plan.questions] == ["field"]
    assert "v may be it" not in plan.questions[0].problem
    assert plan.examples == ("--field none",)

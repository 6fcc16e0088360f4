"""Logs and curves of one file that a column of words tells apart: by material, by trial, by direction."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, plan_of, read, read_all, read_table, recordings_in
from erclutch.logs.log_file import Group, group_of, wants_each
from tests.support.command import run
from tests.support.slow_params import slow_behind

pytestmark = pytest.mark.usefixtures("read_here")
SPEEDS = [10.0 * k for k in range(1, 13)]


def points_of(words: list[str], column: str = "material") -> str:
    """A curve of torque over speed for each word; that of the second is twice that of the first, and so on."""
    lines = [f"{column},current [A],speed [rpm],torque [Nm]"]
    for number, word in enumerate(words, start=1):
        lines += [f"{word},0.5,{speed:g},{number * (0.3 + 0.001 * speed):.6g}" for speed in SPEEDS]
    return "\n".join(lines) + "\n"


def trials_of(
    words: list[str], column: str = "trial", restarts: bool = True, rows: int = 40
) -> str:
    """A log for each word; their times restart, or go on."""
    lines = [f"{column},t [s],current [A],speed [rpm],torque [Nm]"]
    for number, word in enumerate(words):
        for k in range(rows):
            t = 0.01 * (k if restarts else k + rows * number)
            lines.append(
                f"{word},{t:.2f},{1 + 0.1 * number:g},{60 * np.sin(20 * t):.4f},{2 * np.sin(20 * t):.4f}"
            )
    return "\n".join(lines) + "\n"


def written(folder: Path, text: str, name: str = "log.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("variable", "group"),
    [
        ("material=steel", Group(None, "material", "steel")),
        ("Sheet 1; material=steel", Group("Sheet 1", "material", "steel")),
        ("material=all", Group(None, "material", "all")),
        ("trial = 2 A", Group(None, "trial", "2 A")),
        ("all", None),
        ("steel", None),
        ("material=", None),
        ("=steel", None),
        (None, None),
    ],
)
def test_a_group_is_named_by_its_column_and_its_word(
    variable: str | None, group: Group | None
) -> None:
    assert group_of(variable) == group


def test_all_and_all_of_a_column_want_each() -> None:
    assert [
        wants_each(each) for each in ("all", "material=all", "material=steel", "Sheet 1", None)
    ] == [
        *(True, True, False, False, False),
    ]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("column", "words", "proposed"),
    [
        ("material", ["steel", "brass", "PTFE"], "material=steel"),
        ("oil", ["A 32", "B 46"], "oil=A 32"),
        ("Cell_Label", ["5%300K", "12%300K"], "Cell_Label=all"),
        ("Aufbau", ["links", "rechts"], "Aufbau=all"),
    ],
)
def test_points_of_several_words_are_asked_about(
    tmp_path: Path, column: str, words: list[str], proposed: str
) -> None:
    path = written(tmp_path, points_of(words, column))
    plan = plan_of(read_table(path), ColumnMap())
    asked = {question.signal: question for question in plan.questions}
    assert words[0] in asked["variable"].problem
    assert plan.examples == (f'--variable "{proposed}"',)


@pytest.mark.slow
@pytest.mark.parametrize("column", slow_behind(2, ["direction", "trial", "Versuch", "Test_Run"]))
def test_points_and_logs_of_several_trials_are_those_of_one_device(
    tmp_path: Path, column: str
) -> None:
    swept = read(written(tmp_path, points_of(["up", "down"], column)))
    assert swept.rows == 2 * len(SPEEDS)
    timed = read(written(tmp_path, trials_of(["a", "b", "c"], column, rows=400), "timed.csv"))
    assert [stop - start for start, stop in timed.segments] == [400, 400, 400]


@pytest.mark.slow
@pytest.mark.parametrize("column", slow_behind(2, ["damper", "Probe", "group", "trial"]))
def test_logs_whose_times_restart_with_each_word_are_asked_about(
    tmp_path: Path, column: str
) -> None:
    path = written(tmp_path, trials_of(["a", "b", "c"], column))
    plan = plan_of(read_table(path), ColumnMap())
    assert [question.signal for question in plan.questions] == ["variable"]
    logs = read_all(path, ColumnMap.from_options({"variable": f"{column}=all"}))
    assert [log.rows for log in logs] == [40, 40, 40]
    assert [float(log.signals["field"][0]) for log in logs] == [1.0, 1.1, 1.2]


@pytest.mark.slow
def test_words_beside_one_course_of_time_ask_nothing(tmp_path: Path) -> None:
    table = read_table(written(tmp_path, trials_of(["idle", "load"], "state", restarts=False)))
    plan = plan_of(table, ColumnMap())
    assert not plan.questions
    assert (
        'column state parts the rows by 2 words: --variable "state=idle" takes those of one'
        in plan.notes
    )


@pytest.mark.parametrize(
    "cells", [["r1", "r2", "r3"] * 12, ["same"] * 36, ["ok"] * 30 + ["odd"] * 1 + [""] * 5]
)
def test_remarks_and_names_part_no_rows_unless_their_words_repeat(
    tmp_path: Path, cells: list[str]
) -> None:
    lines = [f"{cell},{k / 100},{np.sin(k):.3f}" for k, cell in enumerate(cells)]
    table = read_table(written(tmp_path, "remark,t [s],torque [Nm]\n" + "\n".join(lines) + "\n"))
    distinct = {cell for cell in cells if cell}
    assert bool(table.words) == (len(distinct) > 1 and len(cells) >= 3 * len(distinct))


def test_the_rows_of_a_word_are_a_log_and_count_only_their_own(tmp_path: Path) -> None:
    path = written(tmp_path, points_of(["steel", "brass"]))
    log = read(path, variable="material=brass", time="none")
    assert log.rows == len(SPEEDS)
    assert np.allclose(log.signals["effort"], [2 * (0.3 + 0.001 * speed) for speed in SPEEDS])
    assert f"rows where material is brass: {len(SPEEDS)} of {2 * len(SPEEDS)} rows" in log.notes


def test_numbers_part_rows_where_their_column_is_named(tmp_path: Path) -> None:
    path = written(tmp_path, points_of(["1", "2", "3"], "cell"))
    assert recordings_in(path, "cell=all") == ["cell=1", "cell=2", "cell=3"]
    assert read_table(path, variable="cell=2").rows == len(SPEEDS)
    for label in ("current [A]", "current", "current (A)"):
        assert read_table(path, variable=f"{label}=0.5").rows == 3 * len(SPEEDS)


@pytest.mark.parametrize(
    ("variable", "problem"),
    [
        ("material=wood", "no row has material 'wood' (there are: steel, brass)"),
        ("metal=steel", "there is no column 'metal' whose words part the rows"),
    ],
)
def test_a_word_or_a_column_that_is_not_there_is_told_with_those_that_are(
    tmp_path: Path, variable: str, problem: str
) -> None:
    path = written(tmp_path, points_of(["steel", "brass"]))
    with pytest.raises(LogError, match=r"--variable|Choose from") as caught:
        read_table(path, variable=variable)
    assert caught.value.problem == problem


def test_words_of_json_lines_part_the_rows(tmp_path: Path) -> None:
    lines = [
        f'{{"material": "{word}", "speed": {speed}, "torque": 1}}'
        for word in "ab"
        for speed in SPEEDS
    ]
    path = written(tmp_path, "\n".join(lines) + "\n", "log.jsonl")
    assert read_table(path, variable="material=b").rows == len(SPEEDS)


@pytest.mark.slow
def test_words_of_a_sheet_part_its_rows(tmp_path: Path) -> None:
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for line in points_of(["steel", "brass"]).splitlines():
        book.active.append([float(cell) if cell[0].isdigit() else cell for cell in line.split(",")])
    path = tmp_path / "log.xlsx"
    book.save(path)
    assert recordings_in(path, "material=all") == ["material=steel", "material=brass"]
    table = read_table(path, variable="material=brass")
    assert np.allclose(table.columns["torque"], [2 * (0.3 + 0.001 * speed) for speed in SPEEDS])


@pytest.mark.slow
def test_inspect_ends_in_the_command_that_settles_it(tmp_path: Path) -> None:
    path = written(tmp_path, trials_of(["a", "b"], "setup"))
    done = run("inspect", path)
    assert done.code == 1
    assert done.out.strip().splitlines()[-1].endswith('--variable "setup=all"')
    again = run("inspect", path, "--variable", "setup=all")
    assert again.code == 0
    assert "--variable setup=all --out RUN" in again.out


@pytest.mark.slow
@pytest.mark.parametrize("names", ["gamma,tau", "γ,τ", "Gamma,Tau"])
def test_a_gamma_beside_a_tau_is_for_flowcurve(tmp_path: Path, names: str) -> None:
    rows = "".join(f"{word},{x},{20 + x}\n" for word in "AB" for x in range(1, 13))
    written(tmp_path, f"amostra,{names}\n{rows}")
    options = f"--shear-rate '{names.partition(',')[0]} [1/s]' --sheet amostra=all"
    assert run("inspect", "log.csv", cwd=tmp_path).out.strip().splitlines()[-1] == (
        f"What settles it: erclutch flowcurve log.csv {options}"
    )


@pytest.mark.slow
@pytest.mark.parametrize("words", [["up", "down"], ["Anfang", "Ende"]])
def test_words_beside_a_shear_rate_part_the_curves_that_inspect_proposes(
    tmp_path: Path, words: list[str]
) -> None:
    rates = [*range(1, 21), *range(20, 0, -1)]
    rows = "".join(f"{k},{x},{20 + x},{words[k // 20]}\n" for k, x in enumerate(rates))
    written(tmp_path, f"Time [s],Shear Rate [1/s],Shear Stress [Pa],Notes\n{rows}")
    last = run("inspect", "log.csv", cwd=tmp_path).out.strip().splitlines()[-1]
    assert last == "Or as a flow curve: erclutch flowcurve log.csv --sheet Notes=all"


@pytest.mark.parametrize("words", [["2.5A", "-2.5A", "5A"], ["10 mm", "20 mm"], ["2 V", "4 V"]])
def test_levels_of_what_was_set_are_no_groups(tmp_path: Path, words: list[str]) -> None:
    plan = plan_of(read_table(written(tmp_path, points_of(words, "peak_value"))), ColumnMap())
    assert not plan.questions


def test_rows_without_a_time_are_asked_about_at_once(tmp_path: Path) -> None:
    lines = ["material,current [A],motor_speed [rpm],output_speed [rpm],torque [Nm]"]
    for word in ("steel", "brass"):
        lines += [
            f"{word},0.5,{(7 * k) % 11},{(5 * k) % 7},{0.3 + 0.01 * k:.3f}" for k in range(24)
        ]
    plan = plan_of(read_table(written(tmp_path, "\n".join(lines) + "\n")), ColumnMap())
    assert {question.signal for question in plan.questions} == {"time", "slip", "variable"}
    assert not any("COLUMN" in option for option in plan.examples)


@pytest.mark.parametrize("levels", [["20", "50", "100"], ["0", "1"]])
def test_a_curve_at_each_number_of_a_column_is_of_points(tmp_path: Path, levels: list[str]) -> None:
    plan = plan_of(read_table(written(tmp_path, points_of(levels, "throttle [%]"))), ColumnMap())
    assert not plan.questions
    assert plan.clock is not None
    assert plan.clock.kind == "points"


@pytest.mark.parametrize("column", ["participant", "subject", "specimen number"])
def test_points_of_people_or_pieces_by_number_are_asked_about(tmp_path: Path, column: str) -> None:
    path = written(tmp_path, points_of(["1", "2", "3"], column))
    plan = plan_of(read_table(path), ColumnMap())
    assert any("parts the rows into 3: 1, 2, 3" in each.problem for each in plan.questions)
    assert any(f"{column}=" in each for each in plan.examples)


@pytest.mark.parametrize("column", ["level", "repeat"])
def test_points_with_other_whole_numbers_are_not_asked_about(tmp_path: Path, column: str) -> None:
    plan = plan_of(read_table(written(tmp_path, points_of(["1", "2", "3"], column))), ColumnMap())
    assert not any("parts the rows" in each.problem for each in plan.questions)


def loops_of(words: list[str], course: str, restarts: bool) -> str:
    """A mean loop of torque over angle for each word, without a time; a course that restarts with each, or goes on."""
    lines = [f"pace,{course},angle [deg],torque [Nm]"]
    for number, word in enumerate(words):
        for k in range(50):
            at = k / 50 + (0 if restarts else number)
            lines.append(f"{word},{at:.2f},{np.sin(7 * at):.5f},{np.cos(7 * at) + number:.5f}")
    return "\n".join(lines) + "\n"


@pytest.mark.slow
@pytest.mark.parametrize("course", ["phase", "share of cycle", "percent"])
def test_rows_without_a_time_whose_course_restarts_with_each_word_are_asked_about(
    tmp_path: Path, course: str
) -> None:
    path = written(tmp_path, loops_of(["slow", "fast", "faster"], course, restarts=True))
    for told in (ColumnMap(), ColumnMap(rate=100.0)):
        plan = plan_of(read_table(path), told)
        assert any("column pace parts the rows into 3" in each.problem for each in plan.questions)


@pytest.mark.slow
def test_rows_without_a_time_whose_course_goes_on_are_one_log(tmp_path: Path) -> None:
    path = written(tmp_path, loops_of(["slow", "fast", "faster"], "distance", restarts=False))
    plan = plan_of(read_table(path), ColumnMap(rate=100.0))
    assert not any("parts the rows" in each.problem for each in plan.questions)

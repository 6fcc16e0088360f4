"""Tables as strangers write them: read right, or asked about; each input is made up after a kind of public file."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from openpyxl import Workbook

from erclutch.errors import LogError, MappingError
from erclutch.logs import ColumnMap, plan_of, read_table, recordings_in
from erclutch.logs.log_file import tables_in
from erclutch.logs.readers import child_process, spreadsheet
from tests.support.command import good
from tests.support.old_workbook import write_old_workbook


def written(folder: Path, text: str, name: str = "log.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def rows(count: int = 40, beside: str = "") -> str:
    return "".join(f"{k * 10},{(k % 7) - 3},{(k % 5) - 2}{beside}\n" for k in range(count))


@pytest.mark.parametrize(
    "above",
    [
        "Some Graph,3,,,,,\nItemCount,3,,,,MIN,MAX\n-1,321,Motor(2.0),#ffff00,,,\n",
        "Logger 7,,,,,,\nserial,4711,,,,,\nrange,-5,5,,,,\n",
    ],
)
def test_a_text_that_a_spreadsheet_filled_up_to_its_longest_line_keeps_its_names(
    tmp_path: Path, above: str
) -> None:
    text = f"{above}time [ms],speed [rad/s],torque [N*m],,,,\n{rows(beside=',,,,')}"
    table = read_table(written(tmp_path, text))
    assert table.rows == 40
    assert list(table.columns)[:3] == ["time", "speed", "torque"]
    assert table.units["time"] == "ms"


@pytest.mark.parametrize("header", ["pos (1),speed (1),torque (1)", "pos (2),speed (2),torque (2)"])
def test_a_number_in_brackets_is_an_index_and_no_unit(tmp_path: Path, header: str) -> None:
    table = read_table(written(tmp_path, f"{header}\n{rows()}"))
    assert set(table.units.values()) == {None}


def test_speeds_of_several_motors_are_asked_about(tmp_path: Path) -> None:
    header = "time [ms],speed (1),torque (1),speed (2),torque (2)"
    text = "".join(
        f"{k * 10},{(k % 7) - 3},{(k % 5) - 2},{(k % 3) - 1},{(k % 9) - 4}\n" for k in range(40)
    )
    plan = plan_of(read_table(written(tmp_path, f"{header}\n{text}")), ColumnMap())
    assert {"slip", "effort"} <= {question.signal for question in plan.questions}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "proposed"),
    [("knock", "--field none"), ("in_window", "--field none"), ("coil_on", '--field "coil_on"')],
)
def test_a_mark_of_0_and_1_is_proposed_as_the_field_only_where_it_switches_something(
    tmp_path: Path, name: str, proposed: str
) -> None:
    body = "".join(f"{k / 100},{(k % 7) - 3},{(k % 5) - 2},{int(k > 50)}\n" for k in range(100))
    written(tmp_path, f"t [s],speed [rad/s],torque [N*m],{name}\n{body}")
    last = good("inspect", "log.csv", cwd=tmp_path, code=1).splitlines()[-1]
    assert last == f"What settles it: erclutch inspect log.csv {proposed}"


@pytest.mark.parametrize("coefficient", ["COF", "Friction COF effective value", "mu"])
def test_a_load_beside_a_coefficient_of_friction_is_no_effort(
    tmp_path: Path, coefficient: str
) -> None:
    body = "".join(
        f"{k / 100},{0.1 + k % 3 / 10},{180 + k % 2},{0.1 + k % 5 / 100}\n" for k in range(100)
    )
    header = f"t [s],sliding speed [m/s],Load [N],{coefficient}"
    plan = plan_of(read_table(written(tmp_path, f"{header}\n{body}")), ColumnMap())
    assert plan.signal("effort") is None
    with pytest.raises(MappingError, match="Load is a load beside a coefficient of friction"):
        plan.require_answers()


@pytest.mark.parametrize("name", ["Velocidad_kmh", "speed_km_h", "velocity_kph"])
def test_kilometres_an_hour_at_the_end_of_a_name_are_a_unit(tmp_path: Path, name: str) -> None:
    plan = plan_of(read_table(written(tmp_path, f"t_ms,{name},force_N\n{rows()}")), ColumnMap())
    slip = plan.signal("slip")
    assert slip is not None
    assert slip.factor == pytest.approx(1 / 3.6)


def test_a_load_without_such_a_coefficient_is_the_effort(tmp_path: Path) -> None:
    body = "".join(f"{k / 100},{(k % 7) / 10},{180 + k % 2}\n" for k in range(100))
    plan = plan_of(
        read_table(written(tmp_path, f"t [s],Displacement [mm],Load [N]\n{body}")), ColumnMap()
    )
    effort = plan.signal("effort")
    assert effort is not None
    assert effort.column == "Load"


def workbook(path: Path, sheets: int) -> Path:
    book = Workbook()
    for number in range(sheets):
        sheet = book.create_sheet(f"run {number}") if number else book.worksheets[0]
        sheet.title = f"run {number}"
        sheet.append(["t [s]", "field [A]", "speed [rad/s]", "torque [N*m]"])
        for k in range(50):
            sheet.append([k / 100, number / 10, (k * (number + 1)) % 7 - 3, (k % 5) - 2])
    book.save(path)
    return path


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_all_sheets_of_a_workbook_are_read_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = workbook(tmp_path / "runs.xlsx", 7)
    started: list[str] = []
    run = child_process.run

    def counted(
        module: str, file: Path, *arguments: str, memory: int | None = None
    ) -> child_process.Answer:
        started.append(arguments[-1])
        return run(module, file, *arguments, memory=memory)

    monkeypatch.setattr(child_process, "run", counted)
    names = recordings_in(path)
    tables = tables_in(path, names)
    assert list(tables) == [f"run {number}" for number in range(7)]
    for name, table in tables.items():
        alone = spreadsheet.find(str(path), name)  # opens the workbook for this sheet
        assert not isinstance(table, Exception)
        assert list(table.columns) == list(alone.columns)
        assert all((table.columns[each] == alone.columns[each]).all() for each in alone.columns)
        assert table.notes == alone.notes
        assert read_table(path, variable=name).digest == table.digest
    tables_in(path, names)
    assert len(started) == 1  # names, all tables and each of them


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_what_stands_against_one_sheet_stands_against_no_other(tmp_path: Path) -> None:
    path = workbook(tmp_path / "runs.xlsx", 3)
    tables = tables_in(path, ["run 0", "no such sheet", "run 2"])
    assert [isinstance(table, Exception) for table in tables.values()] == [False, True, False]


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_inspect_of_a_workbook_of_logs_takes_all(tmp_path: Path) -> None:
    workbook(tmp_path / "runs.xlsx", 7)
    last = good("inspect", "runs.xlsx", cwd=tmp_path).splitlines()[-1]
    assert shlex.split(last)[-5:] == ["erclutch", "fit", "runs.xlsx", "--out", "RUN"]


@pytest.mark.usefixtures("read_here")
def test_a_workbook_of_excel_97_is_read(tmp_path: Path) -> None:
    names: list[str | float] = ["t [s]", "field [A]", "speed [rad/s]", "torque [N*m]"]
    numbers: list[list[str | float]] = [
        [k / 100, k // 20 / 2, (k % 7) - 3.0, (k % 5) - 2.0] for k in range(60)
    ]
    table = read_table(write_old_workbook(tmp_path / "log.xls", "run", [names, *numbers]))
    assert table.rows == 60
    assert table.columns["torque"].tolist() == [row[3] for row in numbers]
    assert not plan_of(table, ColumnMap()).questions


@pytest.mark.usefixtures("read_here")
def test_a_torn_workbook_of_excel_97_is_an_error_of_ours(tmp_path: Path) -> None:
    names: list[str | float] = ["t [s]", "speed [rad/s]"]
    path = write_old_workbook(
        tmp_path / "log.xls", "run", [names, *([k / 100, k % 7 - 3.0] for k in range(60))]
    )
    path.write_bytes(path.read_bytes()[:2500])
    with pytest.raises(LogError):
        read_table(path)


def test_a_yield_stress_of_a_table_of_results_is_no_effort(tmp_path: Path) -> None:
    body = "".join(f"{k},{5 + k % 3},{3 + k % 2}\n" for k in range(20))
    plan = plan_of(
        read_table(written(tmp_path, f"run,Casson yield stress [mPa],Hematocrit [%]\n{body}")),
        ColumnMap(),
    )
    assert plan.signal("effort") is None


def sheet_with_numbers_beside(path: Path, gap: int, name: str | None = None) -> Path:
    """A report: settings, a table of parameters, a table of points; and copies of two of its columns behind a gap."""
    book = Workbook()
    sheet = book.active
    assert sheet is not None
    empty: list[str | float | None] = [None] * gap
    sheet.append(["Test Name:", "buff 2", None, *empty, name, name])
    sheet.append(["Cycle", "n'", "K'", *empty, 0.5, 9.5])
    for cycle in range(4):
        sheet.append([cycle, 0.4 + 0.1 * cycle, 30 - cycle, *empty, 0.5 + cycle, 9.5])
    sheet.append([])
    sheet.append(["Time [s]", "Rate [1/s]", "Stress [Pa]", *empty, 5.5, 9.5])
    for row in range(30):
        sheet.append([row, 10.0 + row, 20.0 + row, *empty, 6.5 + row, 9.5])
    book.save(path)
    return path


@pytest.mark.usefixtures("read_here")
def test_numbers_without_a_name_behind_a_gap_hide_no_table(tmp_path: Path) -> None:
    path = sheet_with_numbers_beside(tmp_path / "log.xlsx", gap=4)
    assert recordings_in(path) == ["table 1", "table 2"]
    table = read_table(path, variable="table 2")
    assert table.labels == ("Time [s]", "Rate [1/s]", "Stress [Pa]")
    assert table.rows == 30
    assert any(
        "numbers without a name beside the table (2 columns): left out" in note
        for note in table.notes
    )


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize(("gap", "name"), [(1, None), (4, "copy")])
def test_columns_with_a_name_or_next_to_the_table_stay(
    tmp_path: Path, gap: int, name: str | None
) -> None:
    path = sheet_with_numbers_beside(tmp_path / "log.xlsx", gap, name)
    try:
        notes = read_table(path).notes
    except LogError:
        return
    assert not any("beside the table" in note for note in notes)

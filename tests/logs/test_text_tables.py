"""Several tables in one text are several recordings; a text with one table is read as ever."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import ErclutchError, LogError
from erclutch.logs import Table, read_table, recordings_in
from erclutch.logs.log_file import tables_in
from erclutch.logs.readers import dialect, text_tables
from tests.support.examples import examples
from tests.support.slow_params import slow_behind

TIME = np.arange(50) / 100
SPEED = np.round(np.sin(9 * TIME), 6)
CURRENT = np.repeat([0.0, 1.0], 25)


def rows(*columns: np.ndarray, between: str = ",", decimal: str = ".") -> str:
    lines = (
        between.join(f"{x:.9g}".replace(".", decimal) for x in row)
        for row in zip(*columns, strict=True)
    )
    return "\n".join(lines) + "\n"


def two(
    between: str = ",", decimal: str = ".", titles: tuple[str, str] = ("", ""), blank: str = "\n"
) -> str:
    first = f"time [s]{between}speed [rad/s]\n" + rows(
        TIME, SPEED, between=between, decimal=decimal
    )
    second = f"time [s]{between}current [A]\n" + rows(
        TIME, CURRENT, between=between, decimal=decimal
    )
    return f"{titles[0]}{first}{blank}{titles[1]}{second}"


def file_of(folder: Path, text: str) -> Path:
    path = folder / "tables.csv"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize(("between", "decimal"), [(",", "."), (";", ","), ("\t", ".")])
@pytest.mark.parametrize(
    ("titles", "names"),
    slow_behind(
        1, [(("", ""), ["table 1", "table 2"]), (("Run 1\n", "# Run 2\n"), ["Run 1", "Run 2"])]
    ),
)
@pytest.mark.parametrize("blank", ["\n", ""])
def test_each_table_is_a_recording(
    tmp_path: Path,
    between: str,
    decimal: str,
    titles: tuple[str, str],
    names: list[str],
    blank: str,
) -> None:
    path = file_of(tmp_path, two(between, decimal, titles, blank))
    with pytest.raises(LogError, match="several recordings: "):
        read_table(path)
    found = recordings_in(path)
    assert len(found) == 2
    if blank:
        assert found == names
    first, second = (read_table(path, variable=name) for name in found)
    np.testing.assert_allclose(first.columns["speed"], SPEED)
    np.testing.assert_allclose(second.columns["current"], CURRENT)
    assert (first.rows, second.rows) == (50, 50)
    assert second.units["current"] == "A"
    assert second.notes[0] == f"recording read from {found[1]}, 1 of 2 tables of the text"


def test_a_row_of_units_and_other_columns(tmp_path: Path) -> None:
    text = "a remark\nt,v\ns,rad/s\n" + rows(TIME, SPEED) + "\nanother remark\nt,v,T\ns,rad/s,N*m\n"
    path = file_of(tmp_path, text + rows(TIME, SPEED, SPEED))
    table = read_table(path, variable="another remark")
    assert table.units["T"] == "N*m"
    assert table.rows == 50


def test_a_text_with_one_table_has_no_recordings_to_choose_from(tmp_path: Path) -> None:
    path = file_of(tmp_path, "time [s],speed [rad/s]\n" + rows(TIME, SPEED))
    assert recordings_in(path) == []
    with pytest.raises(
        LogError, match="the text is one recording, so it has no 'table 1' for --variable"
    ):
        read_table(path, variable="table 1")


@pytest.mark.parametrize("line", ["abc,def", "time [s],", "x,y\n1,2"])
def test_a_wrong_line_is_no_second_table(tmp_path: Path, line: str) -> None:
    path = file_of(
        tmp_path, "time [s],speed [rad/s]\n" + rows(TIME, SPEED) + line + "\n" + rows(TIME, SPEED)
    )
    try:
        said = str(read_table(path).unreadable)
    except ErclutchError as error:
        said = str(error)
    assert said != "{}"
    assert "several recordings" not in said


def test_a_wrong_cell_of_a_table_is_named_with_its_table(tmp_path: Path) -> None:
    text = two().replace(f"{SPEED[20]:.9g}", "what")
    table = read_table(file_of(tmp_path, text), variable="table 1")
    assert "line 22, column speed is 'what'" in table.unreadable["speed"]


def test_text_above_a_table_is_skipped_with_a_word(tmp_path: Path) -> None:
    prose = "This is a test of the clutch.\nIt ran well, and 3 of 4 problems are solved.\nOperator: somebody\n\n"
    table = read_table(file_of(tmp_path, prose + "time [s],speed [rad/s]\n" + rows(TIME, SPEED)))
    np.testing.assert_allclose(table.columns["speed"], SPEED)
    assert any(
        n.startswith("text above the table skipped: 'This is a test of the clutch.'")
        for n in table.notes
    )
    assert table.metadata["Operator"] == "somebody"


@pytest.mark.slow
@settings(max_examples=examples(100), deadline=None)
@given(place=st.integers(0, 5000), damage=st.sampled_from("0x,;.\n\t -\"'#"))
def test_a_changed_byte_never_moves_a_column(
    tmp_path_factory: pytest.TempPathFactory, place: int, damage: str
) -> None:
    """Of each table that is read at most one row of a column differs; what is missing is named."""
    text = two()
    place %= len(text)
    path = file_of(tmp_path_factory.getbasetemp(), text[:place] + damage + text[place + 1 :])
    for variable, name, right in (("table 1", "speed", SPEED), ("table 2", "current", CURRENT)):
        try:
            table = read_table(path, variable=variable)
        except ErclutchError:
            continue
        if name in table.columns and table.rows == 50:
            assert int(np.count_nonzero(table.columns[name] != right)) <= 1
            assert int(np.count_nonzero(table.columns.get("time", TIME) != TIME)) <= 1


@pytest.mark.parametrize(
    ("names", "units"),
    [
        ("Zeit;Weg;Strom;Kraft;Pressure", "sec;m;A;N;bar"),
        ("Tiempo;Fuerza;Desplazamiento;Corriente;U", "sec;N;cm;mA;V"),
        ("t;disp;force;Error;Speed setpoint", "sec;m;N;-;-"),
    ],
)
def test_a_row_of_seconds_and_short_units_names_nothing(
    tmp_path: Path, names: str, units: str
) -> None:
    rows = "\n".join(f"{k / 100};{k % 7};{k % 5};{k % 3};{k % 11}" for k in range(20))
    (tmp_path / "a.csv").write_text(f"Test bench 4\n{names}\n{units}\n{rows}\n", encoding="utf-8")
    table = read_table(tmp_path / "a.csv")
    assert [*table.columns] == names.split(";")
    written = dict(zip(names.split(";"), units.split(";"), strict=True))
    assert {name: table.units.get(name) or "-" for name in table.columns} == written
    # Without another line of names they are names.
    (tmp_path / "b.csv").write_text(f"Test bench 4\n{units}\n{rows}\n", encoding="utf-8")
    assert next(iter(read_table(tmp_path / "b.csv").columns)) == "sec"


def block(number: int, header: str, time: np.ndarray) -> str:
    """A second of a log as testing machines write it: what it is, names, units, rows; then nothing."""
    about = f"Data Acquisition\t\t\tTime:\t{number + 1.5}\tSec\t10/4/2021 7:48:0{number} AM\n"
    return f"{about}{header}{rows(np.sin(9 * time), np.cos(9 * time), time, between=chr(9))}\n"


@pytest.mark.parametrize("units", ["in\tlbf\tSec", "mm\tkN\tsec"])
def test_blocks_of_one_test_are_one_recording_where_the_time_goes_on(
    tmp_path: Path, units: str
) -> None:
    header = f"Stroke\tLoad\tTime\n{units}\n"
    text = "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\n" + "".join(
        block(each, header, TIME + each / 2) for each in range(4)
    )
    table = read_table(file_of(tmp_path, text))
    assert list(table.columns) == ["Stroke", "Load", "Time"]
    assert [table.units[name] for name in table.columns] == units.split("\t")
    np.testing.assert_allclose(
        table.columns["Time"], np.concatenate([TIME + each / 2 for each in range(4)])
    )
    assert any("the names stand 4 times in the text" in note for note in table.notes)


def test_blocks_whose_time_begins_anew_or_in_other_units_are_recordings_of_their_own(
    tmp_path: Path,
) -> None:
    header = "Stroke\tLoad\tTime\nmm\tkN\tsec\n"
    anew = "".join(block(each, header, TIME) for each in range(3))
    assert recordings_in(file_of(tmp_path, anew)) == ["table 1", "table 2", "table 3"]
    other = block(0, header, TIME) + block(1, header.replace("mm", "in"), TIME + 0.5)
    assert recordings_in(file_of(tmp_path, other)) == ["table 1", "table 2"]


@pytest.mark.slow
def test_a_text_of_many_tables_is_searched_once_for_all_of_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`inspect` of an export of some hundred short steps searched the text anew for each of them, for minutes."""
    searched: list[int] = []

    def counted(lines: list[str]) -> list[int]:
        searched.append(len(lines))
        return headers(lines)

    headers: Callable[[list[str]], list[int]] = text_tables.lines_of_names
    monkeypatch.setattr(text_tables, "lines_of_names", counted)
    rows = "\n".join(f"{k / 10},{k % 7},{k % 5}" for k in range(30))
    path = tmp_path / "steps.txt"
    path.write_text(
        "\n\n".join(f"Step {k}\nt [s],w{k} [rad/s],M [N*m]\n{rows}" for k in range(9)) + "\n"
    )
    tables = tables_in(path, recordings_in(path))
    assert len(tables) == 9
    assert all(isinstance(table, Table) for table in tables.values())
    assert len(searched) <= 1


def test_who_sniffs_a_text_again_gets_lines_above_the_rows_of_his_own() -> None:
    """The dialect of a text is kept for the next who asks: what one changes of it, the other does not see."""
    text = "Sample: oil 3\n\ntime,voltage\n" + rows(TIME, CURRENT)
    first = dialect.sniff(text)
    assert first.metadata == {"Sample": "oil 3"}
    first.metadata["Sample"] = "another"
    again = dialect.sniff(text)
    assert again.metadata == {"Sample": "oil 3"}
    assert again.names == first.names == ("time", "voltage")
    assert dialect.sniff(text, ",") != again  # not where another decimal mark is asked for

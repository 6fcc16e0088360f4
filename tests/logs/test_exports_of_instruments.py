"""Exports of scopes, loggers and programs say names, units and steps in lines of their own. SYNTHETIC."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from openpyxl import Workbook
from scipy.io import savemat

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, Table, plan_of, read, read_table, table_of_log
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.readers.waveform_lines import with_steps_above
from erclutch.signals.array import Array
from tests.support.slow_params import slow_behind

pytestmark = pytest.mark.usefixtures("read_here")  # no child process for each file

TIME: Array = 0.002 * np.arange(300, dtype=np.float64)
SPEED = 14.0 * np.cos(17.0 * TIME)  # rad/s
CURRENT = np.where(TIME % 0.2 < 0.1, 0.2, 1.0)
TORQUE = (0.1 + 1.2 * CURRENT) * np.tanh(SPEED / 0.5) + 0.01 * SPEED


def rows_of(columns: Sequence[Array], mark: str = ",") -> list[str]:
    return [mark.join(f"{number:.8g}" for number in row) for row in np.column_stack(columns)]


def written(path: Path, head: Sequence[str], columns: Sequence[Array], mark: str = ",") -> Path:
    path.write_text("\n".join([*head, *rows_of(columns, mark)]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("head", "mark"),
    [
        (["ETASAsciiItemFile\trecord", "time\tn\tM\tI", "f8\tf8\tf8\tf8", "s\trad/s\tNm\tA"], "\t"),
        (["time,w,M,I", "Unit:,rad/s,Nm,A", "Interp:,linear,linear,zoh"], ","),
        (
            [
                "time,w,M,I",
                ",Unit: rad/s,Unit: N*m,Unit: A",
                ",Interp: linear,Interp: linear,Interp: zoh",
            ],
            ",",
        ),
        (["time,Model Root/Brake/w [rad/s],Model Root/Brake/M [Nm],Model Root/Coil/I [A]"], ","),
        (
            [
                "time,Platform()://Model Root/w [rad/s],Platform()://Model Root/M [Nm],Platform()://Model Root/I [A]"
            ],
            ",",
        ),
        (["Time (s) | Speed (rad/s) | Torque (Nm) | Current (A)", "---|---:|:---:|---"], "|"),
        (["time [s];speed [rad/s];torque [Nm];current [A]", "--------;-------;-----;----"], ";"),
        (
            [
                "Kanal\tZeit\tw\tM\tI",
                "Einheit\ts\trad/s\tNm\tA",
                "Kommentar\t\tWelle\tMesswelle\tShunt",
                "",
            ],
            "\t",
        ),
        (
            [
                "Time 1 - default sample rate\tSpeed\tTorque\tCurrent",
                "[s]\t[rad/s]\t[N m]\t[A]",
                "---\t---\t---\t---",
            ],
            "\t",
        ),
    ],
)
def test_lines_between_names_and_rows_say_units_and_types(
    tmp_path: Path, head: list[str], mark: str
) -> None:
    recording = read(written(tmp_path / "export.txt", head, [TIME, SPEED, TORQUE, CURRENT], mark))
    assert recording.units == {"field": "A", "slip": "rad/s", "effort": "N*m"}
    assert recording.period == pytest.approx(0.002)
    np.testing.assert_allclose(recording.signals["effort"], TORQUE, atol=1e-6)


@pytest.mark.parametrize(
    ("head", "columns"),
    [
        (
            [
                "waveform\t[0]\t[1]\t[2]",
                "t0\t12:00\t12:00\t12:00",
                "delta t\t0.002\t0.002\t0.002",
                "",
            ],
            3,
        ),
        (
            [
                "channel names:",
                "w (rad/s)\tM (Nm)\tI (A)",
                "start times:",
                "12:00\t12:00\t12:00",
                "dt:",
                "0.002",
                "data:",
            ],
            0,
        ),
    ],
)
def test_waveforms_of_labview_have_one_step(tmp_path: Path, head: list[str], columns: int) -> None:
    names = ["w (rad/s)[0]\tM (Nm)[1]\tI (A)[2]"] if columns else []
    recording = read(
        written(tmp_path / "waves.txt", [*head, *names], [SPEED, TORQUE, CURRENT], "\t")
    )
    assert recording.units == {"field": "A", "slip": "rad/s", "effort": "N*m"}
    assert recording.period == pytest.approx(0.002)


def test_waveforms_of_two_steps_are_left_as_they_are() -> None:
    text = "waveform\t[0]\t[1]\ndelta t\t0.002\t0.004\n\na\tb\n1\t2\n"
    assert with_steps_above(text) == (text, "")


@pytest.mark.slow
@given(text=st.text(alphabet="XCHt0123,.\t\nde la:Incremt Start", max_size=200))
def test_any_text_may_have_lines_of_steps(text: str) -> None:
    said, note = with_steps_above(text)
    assert bool(note) or said == text


def test_a_scope_says_start_and_increment_in_its_first_lines(tmp_path: Path) -> None:
    rows = [f"{number},{row},," for number, row in enumerate(rows_of([SPEED, TORQUE]))]
    head = ["X,CH1,CH2,Start,Increment,", "Sequence,Volt,Volt,-3.0e-01,2.000000e-03,"]
    path = tmp_path / "scope.csv"
    path.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")
    table = read_table(path)
    assert table.sample_period == pytest.approx(0.002)
    assert (table.units["CH1"], table.units["CH2"]) == ("V", "V")
    np.testing.assert_allclose(table.columns["CH2"], TORQUE, atol=1e-6)


def test_volts_of_a_scope_under_labels_are_no_speed_and_no_force(tmp_path: Path) -> None:
    head = ["Vertical Units,V,V,V", "Label,Velocity,Force,Current", "TIME,CH1,CH2,CH3"]
    table = read_table(written(tmp_path / "tek.csv", head, [TIME, SPEED, TORQUE, CURRENT]))
    assert table.units["CH2 Force"] == "V"
    plan = plan_of(table, ColumnMap())
    assert '--effort "CH2 Force" --scale "effort=NUMBER N/V"' in plan.command()


@pytest.mark.parametrize("unit", ["(None)", "None", "N/A"])
def test_no_unit_in_words_is_no_unit(tmp_path: Path, unit: str) -> None:
    head = [f"time [s],fActVelo [{unit.strip('()')}],fActTorque [N/A],current [None]"]
    table = read_table(written(tmp_path / "scope.csv", head, [TIME, SPEED, TORQUE, CURRENT]))
    assert [*table.units.values()] == ["s", None, None, None]


def test_quotes_around_a_part_of_a_name_are_no_prime() -> None:
    assert not spoken_name('"DB1".Torque').is_primed
    assert spoken_name('G"').is_primed
    assert "effort" in spoken_name('"DB1".Torque').may_be


def tidy(path: Path, names: str, form: str) -> Path:
    lines = [names]
    for t, w, m, i in zip(TIME, SPEED, TORQUE, CURRENT, strict=True):
        shown, unit = (i * 1e3, "mA") if i < 0.5 else (i, "A")
        for name, number, own in (
            ("speed", w, "rad/s"),
            ("torque", m, "N m"),
            ("current", shown, unit),
        ):
            lines.append(form.format(t=t, name=name, number=number, unit=own))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("names", "form"),
    slow_behind(
        1,
        [
            ("time,quantity,unit,value", "{t:.3f},{name},{unit},{number:.8g}"),
            ("_time,_field,unit,_value", "{t:.3f},{name},{unit},{number:.8g}"),
            ("Kanal;Wert;Einheit;Zeit", "{name};{number:.8g};{unit};{t:.3f}"),
        ],
    ),
)
def test_a_tidy_signal_in_two_units_is_brought_to_one(
    tmp_path: Path, names: str, form: str
) -> None:
    recording = read(tidy(tmp_path / "long.csv", names, form))
    assert recording.units["field"] == "A"
    np.testing.assert_allclose(recording.signals["field"], CURRENT)


@pytest.mark.slow
def test_a_tidy_signal_in_units_of_two_quantities_is_no_column(tmp_path: Path) -> None:
    path = tidy(
        tmp_path / "long.csv", "time,quantity,unit,value", "{t:.3f},{name},{unit},{number:.8g}"
    )
    path.write_text(path.read_text("utf-8").replace("mA", "V"), encoding="utf-8")
    assert "current" not in read_table(path).columns


def test_values_beside_their_units_in_json_lines_have_them(tmp_path: Path) -> None:
    lines: list[str] = []
    for t, w, m, i in zip(TIME, SPEED, TORQUE, CURRENT, strict=True):
        row: dict[str, Any] = {"t": t, "speed": {"value": w * 30.0 / np.pi, "unit": "rpm"}}
        row |= {"torque": {"value": m * 1e3, "units": "mN*m"}, "current": {"value": i, "unit": "A"}}
        lines.append(json.dumps(row))
    path = tmp_path / "log.jsonl"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    recording = read(path)
    np.testing.assert_allclose(recording.signals["slip"], SPEED)
    np.testing.assert_allclose(recording.signals["effort"], TORQUE)


def workbook(path: Path, sheets: dict[str, tuple[list[str], list[Array]]]) -> Path:
    book = Workbook()
    for name in book.sheetnames:
        del book[name]
    for name, (names, columns) in sheets.items():
        sheet: Any = book.create_sheet(name)
        sheet.append(names)
        for row in np.column_stack(columns).tolist():
            sheet.append(row)
    book.save(path)
    return path


@pytest.mark.slow
@pytest.mark.parametrize(("unit", "in_unit"), slow_behind(1, [("s", 1.0), ("ms", 1e3)]))
def test_a_field_in_another_sheet_is_asked_about_and_joined(
    tmp_path: Path, unit: str, in_unit: float
) -> None:
    rows = slice(None, None, 5)
    motion = (["Time (s)", "Speed (rad/s)", "Torque (Nm)"], [TIME, SPEED, TORQUE])
    supply = (
        [f"Time ({unit})", "Current (A)", "Voltage (V)"],
        [TIME[rows] * in_unit, CURRENT[rows], CURRENT[rows]],
    )
    path = workbook(tmp_path / "log.xlsx", {"DAQ": motion, "Supply": supply})
    with pytest.raises(LogError, match="DAQ is a log without a field, and Supply may be the field"):
        table_of_log(path, ColumnMap(), None)
    recording = read(path, variable="DAQ + Supply")
    assert recording.units["field"] == "A"
    differs = recording.signals["field"] != CURRENT[: recording.rows]
    assert np.count_nonzero(differs) < 0.05 * recording.rows  # a value is held until the next


@pytest.mark.slow
def test_a_field_in_a_sheet_without_a_time_is_told(tmp_path: Path) -> None:
    motion = (["Time (s)", "Speed (rad/s)", "Torque (Nm)"], [TIME, SPEED, TORQUE])
    path = workbook(
        tmp_path / "log.xlsx",
        {"DAQ": motion, "Supply": (["Current (A)", "n"], [CURRENT[:60], TIME[:60]])},
    )
    with pytest.raises(LogError, match="Supply, which may be it, has no time in common"):
        table_of_log(path, ColumnMap(), None)


@pytest.mark.parametrize(
    ("name", "said"), [("log.xls", "not a table"), ("log.xlsx", "under the name of a workbook")]
)
def test_a_page_of_html_under_the_name_of_a_workbook_is_called_so(
    tmp_path: Path, name: str, said: str
) -> None:
    """The old name is that of many a text; a page is none that holds a table."""
    path = tmp_path / name
    path.write_text("<html><table><tr><td>1</td></tr></table></html>", encoding="utf-8")
    with pytest.raises(LogError, match=f"the file is XML or HTML.*{said}"):
        read_table(path)


def mat(path: Path, variables: dict[str, Any]) -> Table:
    savemat(path, variables)
    return read_table(path)


def test_a_table_of_matlab_that_was_made_a_struct_has_the_units_of_its_properties(
    tmp_path: Path,
) -> None:
    names = ["Time", "Speed", "Torque"]
    properties = {
        "VariableNames": np.array(names, dtype=object),
        "VariableUnits": np.array(["s", "rpm", "mN*m"], dtype=object),
    }
    columns = dict(zip(names, (TIME, SPEED, TORQUE), strict=True))
    table = mat(
        tmp_path / "t.mat",
        {"T": {**{k: v[:, None] for k, v in columns.items()}, "Properties": properties}},
    )
    assert table.units == {"Time": "s", "Speed": "rpm", "Torque": "mN*m"}


def test_elements_of_a_data_set_of_simulink_have_their_names(tmp_path: Path) -> None:
    elements = [
        (name, {"Time": TIME[:, None], "Data": values[:, None]})
        for name, values in (("omega", SPEED), ("torque", TORQUE), ("current", CURRENT))
    ]
    table = mat(
        tmp_path / "d.mat",
        {"logsout": np.array(elements, dtype=[("Name", object), ("Values", object)])},
    )
    assert [*table.columns][1:] == ["omega", "torque", "current"]

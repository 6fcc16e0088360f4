"""Exports of instruments: channels with times of their own, labels and groups above names, names without brackets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import ErclutchError
from erclutch.logs import Plan, plan_of, read, read_table, recordings_in
from erclutch.logs.columns.labels import name_columns, own_unit
from erclutch.logs.columns.levels_in_names import differ_by_field
from erclutch.logs.columns.name_ends import split_end
from erclutch.logs.columns.name_pattern import constants_of
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.planning.recording_choice import table_of_log
from erclutch.logs.readers.header_pairs import sample_period
from erclutch.logs.readers.keyed_heads import with_keyed_heads
from erclutch.signals import units

ROWS = 400
TIME = np.arange(ROWS) / 100
LEVELS = 0.5 * (np.arange(ROWS) // 40 % 3)
TURN = np.sin(np.arange(ROWS) / 9)
DRAG = np.tanh(10 * TURN) * (1 + LEVELS)


def rows(*columns: np.ndarray, between: str = ",") -> str:
    return "".join(
        between.join(f"{each:.6g}" for each in row) + "\n" for row in zip(*columns, strict=True)
    )


def written(folder: Path, text: str, name: str = "a.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def planned(path: Path) -> Plan:
    return plan_of(read_table(path), ColumnMap())


# --- channels with times of their own ---------------------------------------------------------------------------------


@pytest.mark.slow
def test_lines_of_a_key_and_a_value_name_the_channels_of_a_scope(tmp_path: Path) -> None:
    head = (
        "Name\tScope Project\nFile\tC:\\brake.svdx\n\nName\tTorque\tName\tVelo\tName\tCoilCurrent\n"
    )
    head += "Data-Type\tREAL64\tData-Type\tREAL64\tData-Type\tREAL64\nSampleTime[ms]\t10\tSampleTime[ms]\t10\t"
    head += "SampleTime[ms]\t10\nUnit\tNm\tUnit\trad/s\tUnit\tA\n\n"
    milliseconds = TIME * 1e3
    body = rows(milliseconds, DRAG, milliseconds, TURN, milliseconds, LEVELS, between="\t")
    recording = read(written(tmp_path, head + body))
    np.testing.assert_allclose(recording.signals["effort"], DRAG, rtol=1e-4)
    np.testing.assert_allclose(recording.signals["slip"], TURN, rtol=1e-4)
    np.testing.assert_allclose(recording.signals["field"], LEVELS)
    assert recording.period == pytest.approx(
        0.01
    )  # s: the header gives the period, and so the unit of the time


def test_channels_behind_times_of_their_own_are_joined_at_the_times_of_the_effort(
    tmp_path: Path,
) -> None:
    own_time = np.arange(ROWS) / 50  # the current is sampled half as often, for twice as long
    head = "Time (s),Torque (Nm),Time (s),Speed (rad/s),Time (s),Current (A)\n"
    recording = read(written(tmp_path, head + rows(TIME, DRAG, TIME, TURN, own_time, LEVELS)))
    at = np.searchsorted(own_time, TIME + 1e-9, side="right") - 1
    np.testing.assert_allclose(recording.signals["field"], LEVELS[at])
    np.testing.assert_allclose(recording.signals["effort"], DRAG, rtol=1e-4)


def test_a_channel_with_fewer_samples_than_the_others_ends_before_them(tmp_path: Path) -> None:
    head = "Time (s),Torque (Nm),Time (s),Speed (rad/s),Time (s),Current (A)\n"
    cells: list[str] = []
    for place in range(ROWS):
        late = f"{TIME[2 * place]:.6g},{LEVELS[2 * place]:.6g}" if 2 * place < ROWS else ","
        cells.append(
            f"{TIME[place]:.6g},{DRAG[place]:.6g},{TIME[place]:.6g},{TURN[place]:.6g},{late}\n"
        )
    recording = read(written(tmp_path, head + "".join(cells)))
    assert recording.rows == ROWS - 1
    assert len(recording.segments) == 1


@pytest.mark.parametrize("time", ["Time (s)", "t [s]", "Zeit [s]"])
def test_rows_end_with_the_channels_that_were_sampled_longest(tmp_path: Path, time: str) -> None:
    head = f"{time},Torque (Nm),{time},Speed (rad/s),{time},Current (A)\n"
    lines: list[str] = []
    for place in range(ROWS):
        line = f"{TIME[place]:.6g},{DRAG[place]:.6g},{TIME[place]:.6g},{TURN[place]:.6g}"
        if 2 * place < ROWS:
            line += f",{TIME[2 * place]:.6g},{LEVELS[2 * place]:.6g}"
        lines.append(line)
    recording = read(written(tmp_path, head + "\n".join(lines) + "\n"))
    assert recording.rows == ROWS - 1
    np.testing.assert_allclose(recording.signals["effort"], DRAG[:-1], rtol=1e-4)


@pytest.mark.parametrize("place", [ROWS // 3, ROWS - 2])
def test_a_row_of_channels_that_was_cut_off_is_an_error(tmp_path: Path, place: int) -> None:
    head = "Time (s),Torque (Nm),Time (s),Speed (rad/s)\n"
    lines = rows(TIME, DRAG, TIME, TURN).splitlines()
    cut_between_pairs = place < ROWS - 2
    lines[place] = ",".join(lines[place].split(",")[: 2 if cut_between_pairs else 3])
    with pytest.raises(ErclutchError, match=f"line {place + 2} has"):
        read_table(written(tmp_path, head + "\n".join(lines) + "\n"))


def test_times_that_repeat_the_first_are_left_out(tmp_path: Path) -> None:
    head = "Time (s),Torque (Nm),Time (s),Speed (rad/s),Time (s),Current (A)\n"
    table = read_table(written(tmp_path, head + rows(TIME, DRAG, TIME, TURN, TIME, LEVELS)))
    assert sum("Time" in name for name in table.columns) == 1


@pytest.mark.slow
@pytest.mark.parametrize(("factor", "unit"), [(1e3, "ms"), (1e6, "us")])
def test_a_time_without_a_unit_that_grows_by_the_period_of_the_header_is_in_its_unit(
    tmp_path: Path, factor: float, unit: str
) -> None:
    head = "Sample interval: 10 ms\nTime,Torque (Nm),Speed (rad/s),Current (A)\n"
    plan = planned(written(tmp_path, head + rows(TIME * factor, DRAG, TURN, LEVELS)))
    assert plan.clock is not None
    assert plan.clock.unit == unit
    assert not plan.doubts


def test_a_time_without_a_unit_that_disagrees_with_the_header_stays_in_doubt(
    tmp_path: Path,
) -> None:
    head = "Sample interval: 3 ms\nTime,Torque (Nm),Speed (rad/s),Current (A)\n"
    plan = planned(written(tmp_path, head + rows(TIME * 1e3, DRAG, TURN, LEVELS)))
    assert plan.clock is not None
    assert plan.clock.doubt


# --- lines above the names --------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("key", ["Labels", "Label", "Channel Names"])
def test_labels_of_an_oscilloscope_stand_above_the_names_of_its_channels(
    tmp_path: Path, key: str
) -> None:
    head = f"Model,MSO44\nSample Interval,0.01\n{key},Speed,Torque,Current\nTIME,CH1,CH2,CH3\n"
    plan = planned(written(tmp_path, head + rows(TIME, TURN, DRAG, LEVELS)))
    taken = {each.signal: each.column for each in plan.signals}
    assert taken == {"slip": "CH1 Speed", "effort": "CH2 Torque", "field": "CH3 Current"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "head",
    [
        "Time,Motor,,Brake,\n,Speed,Current,Torque,Current\ns,rad/s,A,Nm,A\n",
        "Time (s),Drive,,Brake,\n,Speed (rad/s),Current (A),Torque (Nm),Current (A)\n",
    ],
)
def test_groups_tell_columns_of_one_name_apart(tmp_path: Path, head: str) -> None:
    plan = planned(written(tmp_path, head + rows(TIME, TURN, 3 * DRAG, DRAG, LEVELS)))
    field = plan.signal("field")
    assert field is not None
    assert field.column.startswith("Brake Current")
    assert not plan.questions
    assert not plan.doubts


@pytest.mark.parametrize(
    "types", ["f8,f8,f8,f8", "REAL64,REAL64,REAL64,REAL64", "double,double,int16,float"]
)
def test_types_below_the_units_are_no_units(tmp_path: Path, types: str) -> None:
    head = f"time,nBrk,MBrk,iCoil\ns,min-1,Nm,A\n{types}\n"
    table = read_table(written(tmp_path, head + rows(TIME, TURN, DRAG, LEVELS)))
    assert table.units == {"time": "s", "nBrk": "min-1", "MBrk": "Nm", "iCoil": "A"}


def test_sensors_above_names_that_differ_change_no_name(tmp_path: Path) -> None:
    head = "Clock,Encoder,Load cell,Driver\nTime (s),Speed (rad/s),Torque (Nm),Current (A)\n"
    table = read_table(written(tmp_path, head + rows(TIME, TURN, DRAG, LEVELS)))
    assert list(table.columns) == ["Time", "Speed", "Torque", "Current"]


@pytest.mark.slow
@pytest.mark.parametrize("setting", ["Current: {} A", "Coil current,{},A", "Strom = {} A"])
def test_tables_below_each_other_have_the_field_that_stands_above_each(
    tmp_path: Path, setting: str
) -> None:
    text = ""
    for field in (0.0, 0.5, 1.0):
        text += f"{setting.format(field)}\nTime (s),Displacement (mm),Force (N)\n{rows(TIME, TURN, DRAG + field)}\n"
    path = written(tmp_path, text)
    table = table_of_log(path, ColumnMap(), None, recordings_in(path)[1])
    plan = plan_of(table, ColumnMap())
    assert plan.constants["field"] == 0.5


@pytest.mark.slow
def test_what_stands_above_the_first_table_alone_is_no_setting_of_it(tmp_path: Path) -> None:
    text = "Current: 0.7 A\n"
    for _ in range(2):
        text += f"Time (s),Displacement (mm),Force (N)\n{rows(TIME, TURN, DRAG)}\n"
    path = written(tmp_path, text)
    table = table_of_log(path, ColumnMap(), None, recordings_in(path)[0])
    assert not table.metadata


# --- names and units --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "stem", "unit"),
    [
        ("Torque_Nm_", "Torque", "N*m"),
        ("Force_N_", "Force", "N"),
        ("Velocity_m_s_", "Velocity", "m/s"),
        ("Torque..Nm.", "Torque", "N*m"),
        ("Coil.current..A.", "Coil.current", "A"),
        ("Velocity..mm.s.", "Velocity", "mm/s"),
        ("Torque.N.m.", "Torque", "N*m"),
        ("Angular.Velocity..rad.s.", "Angular.Velocity", "rad/s"),
    ],
)
def test_units_in_brackets_that_matlab_and_r_took_away_are_units(
    name: str, stem: str, unit: str
) -> None:
    assert split_end(name) == (stem, unit)


@pytest.mark.parametrize(
    ("name", "stem", "unit"),
    [
        ("brakeTorqueNm", "brakeTorque", "N*m"),
        ("motorSpeedRpm", "motorSpeed", "rpm"),
        ("coilCurrentA", "coilCurrent", "A"),
        ("coilTempC", "coilTemp", "°C"),
        ("timeMs", "time", "ms"),
        ("velRadS", "vel", "rad/s"),
    ],
)
def test_a_unit_may_end_a_name_with_capitals(name: str, stem: str, unit: str) -> None:
    assert split_end(name) == (stem, unit)


@pytest.mark.parametrize("name", ["torqueC", "deltaT", "phaseV", "motorN", "isOn", "lastIn", "xA"])
def test_a_capital_behind_another_word_is_no_unit(name: str) -> None:
    assert split_end(name) == (name, None)


@pytest.mark.parametrize("name", ["Trial_", "x..y", "notes..."])
def test_other_names_that_end_so_have_no_unit(name: str) -> None:
    assert split_end(name) == (name, None)


@pytest.mark.parametrize(
    "name", ["SpdShaft_Act", "Speed shaft", "Vitesse arbre", "Prędkość", "主轴转速"]
)
def test_turns_a_minute_are_the_unit_of_a_speed(name: str) -> None:
    assert own_unit(name, "1/min", ("rad/s",)) == "turn/min"


@pytest.mark.parametrize("name", ["Shear rate", "vitesse de cisaillement", "剪切速率"])
def test_a_shear_rate_counts_no_turns(name: str) -> None:
    assert own_unit(name, "1/min", ("rad/s",)) != "turn/min"


@pytest.mark.parametrize(
    ("key", "text", "period"),
    [
        ("Abtastzeit [ms]", "2", 0.002),
        ("Abtastrate", "500 Hz", 0.002),
        ("Fréquence d'échantillonnage", "1 kHz", 0.001),
        ("采样频率", "200 Hz", 0.005),
        ("サンプリング周期", "2 ms", 0.002),
    ],
)
def test_a_sampling_rate_is_read_in_other_languages(key: str, text: str, period: float) -> None:
    found = sample_period({key: text})
    assert found is not None
    assert found[0] == pytest.approx(period)


def test_a_second_is_written_in_korean() -> None:
    assert units.fits("초", ("s",)) == (1.0, "s")
    assert units.fits("밀리초", ("s",)) == (pytest.approx(1e-3), "s")


@pytest.mark.parametrize("port", ["Out1", "Value", "In2"])
def test_paths_in_a_model_are_named_by_their_last_block(port: str) -> None:
    labels = [
        "Time",
        f"Model Root/Sensors/Torque_Nm/{port}",
        f"Model Root/Encoder/omega_rad_s/{port}",
    ]
    assert name_columns(labels)[0] == ["Time", "Torque_Nm", "omega_rad_s"]


def test_paths_with_one_last_block_stay_whole() -> None:
    labels = ["Root/Motor/Torque/Out1", "Root/Brake/Torque/Out1"]
    assert name_columns(labels)[0] == labels


# --- fields in names --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "names", [("0 A", "0,5 A", "1,0 A"), ("F_0,5A", "F_1,5A"), ("I=0A", "I=0.5A")]
)
def test_a_decimal_comma_in_a_name_is_that_of_its_field(names: tuple[str, ...]) -> None:
    assert differ_by_field(names)


def test_a_list_of_numbers_in_a_name_is_no_field() -> None:
    assert not differ_by_field(("1,2,3A", "1,2,4A"))


def test_a_decimal_comma_in_the_name_of_a_file_is_read() -> None:
    assert constants_of("damper_{field}A", "damper_0,5A.csv") == {"field": (0.5, "A")}


@pytest.mark.slow
def test_the_same_motion_at_several_fields_is_no_copy(tmp_path: Path) -> None:
    from erclutch.errors import AlikeRecordingsError

    text = ""
    for field in (0.0, 0.5, 1.0):
        text += (
            f"{field} A\nTime (s),Displacement (mm),Force (N)\n{rows(TIME, TURN, DRAG + field)}\n"
        )
    with pytest.raises(AlikeRecordingsError):
        table_of_log(written(tmp_path, text), ColumnMap(), None)


LVM_HEAD = """LabVIEW Measurement\t
Separator\tTab
Decimal_Separator\t.
X_Columns\tMulti
***End_of_Header***\t

Channels\t3
Samples\t{samples}
Y_Unit_Label\t{units}
X0\t{zeros}
***End_of_Header***
X_Value\tCurrent\tX_Value\tSpeed\tX_Value\tTorque\tComment
"""


@pytest.mark.parametrize(
    ("gap", "units", "known"),
    [
        ("\t\t", ["A", "rpm", "Nm"], ["A", "rpm", "Nm"]),
        ("\t\t", ["A", "rpm", ""], ["A", "rpm", None]),
        ("\t\t", ["", "", "Nm"], [None, None, "Nm"]),
        ("\t", ["A", "rpm", "Nm"], ["A", "rpm", "Nm"]),
        ("\t", ["A", "", "Nm"], ["A", None, "Nm"]),
    ],
)
def test_units_of_labview_stand_above_their_channel_or_one_after_another(
    tmp_path: Path, gap: str, units: list[str], known: list[str | None]
) -> None:
    head = LVM_HEAD.format(
        samples=gap.join(["6"] * 3), units=gap.join(units), zeros=gap.join(["0.0"] * 3)
    )
    rows = [
        f"{0.1 * k:.1f}\t{k}\t{0.1 * k:.1f}\t{10 + k}\t{0.1 * k:.1f}\t{20 + k}" for k in range(6)
    ]
    path = tmp_path / "log.lvm"
    path.write_text(head + "\n".join(rows) + "\n")
    table = read_table(path)
    assert [table.units[name] for name in ("Current", "Speed", "Torque")] == known


def keyed(mark: str, lines: dict[str, str], decimal: str = ".") -> str:
    """Lines with a key and a cell for each of three channels, above rows without a first cell."""
    head = [mark.join([key, *said.split("|")]) for key, said in lines.items()]
    rows = [
        mark.join(["", *(f"{k + place}.5".replace(".", decimal) for place in range(3))])
        for k in range(30)
    ]
    return "\n".join([*head, "", *rows]) + "\n"


YOKOGAWA = {
    '"Model Name"': '"DL850E"',
    '"BlockNumber"': '"1"',
    '"TraceName"': '"Current"|"Speed"|"Torque"',
    '"BlockSize"': '"30"|"30"|"30"',
    '"VUnit"': '"A"|"rpm"|"Nm"',
    '"HResolution"': '"2.0E-02"|"2.0E-02"|"2.0E-02"',
    '"HUnit"': '"s"|"s"|"s"',
    '"Time"': '"10:11:12"|"10:11:12"|"10:11:12"',
}
FAMOS = {
    "Kanal": "Current|Speed|Torque",
    "Einheit": "A|rpm|Nm",
    "Delta-X": "20|20|20",
    "X-Einheit": "ms|ms|ms",
}


@pytest.mark.parametrize(
    ("lines", "mark", "decimal"),
    [(YOKOGAWA, ",", "."), (FAMOS, "\t", ","), (FAMOS, ";", ","), (FAMOS, ";", ".")],
)
def test_lines_with_a_key_in_front_say_what_the_channels_are(
    tmp_path: Path, lines: dict[str, str], mark: str, decimal: str
) -> None:
    path = tmp_path / "log.csv"
    path.write_text(keyed(mark, lines, decimal))
    table = read_table(path)
    assert table.labels == ("Current [A]", "Speed [rpm]", "Torque [Nm]")
    assert table.sample_period == pytest.approx(0.02)
    assert table.rows == 30
    assert table.columns["Torque"][:2].tolist() == [2.5, 3.5]


@pytest.mark.slow
def test_channels_of_two_rates_are_no_columns_of_one_table(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(keyed(";", {**FAMOS, "Delta-X": "20|10|20"}))
    with pytest.raises(ErclutchError):
        read_table(path)


@pytest.mark.slow
@given(text=st.text(alphabet='Kanal;,\t\n"0.5Einht', max_size=200))
def test_any_text_may_have_lines_with_keys(text: str) -> None:
    changed, note = with_keyed_heads(text)
    assert changed == text or note


@pytest.mark.parametrize("end", ["", ";", ";;"])
def test_a_time_over_its_unit_stands_beside_groups_over_their_names(
    tmp_path: Path, end: str
) -> None:
    lines = [f"Zeit;Bremse;;Spule{end}", "s;Drehzahl [1/min];Moment [Nm];Strom [mA]"]
    lines += [f"{0.1 * k:.1f};{10 + k};{20 + k};{30 + k}" for k in range(20)]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(lines) + "\n")
    assert read_table(path).labels == ("Zeit [s]", "Drehzahl [1/min]", "Moment [Nm]", "Strom [mA]")


def test_channels_of_a_data_logger_have_the_names_in_their_brackets() -> None:
    names, own_units, _ = name_columns(
        ["Scan Number", "101 <Coil I> (ADC)", "102 <Speed> (VDC)", "103 <x> (counts)"]
    )
    assert names[:3] == ["Scan Number", "Coil I", "Speed"]
    assert own_units[:3] == [None, "A", "V"]

"""What loggers and people write above, beside and in place of a header is told apart from rows and names. SYNTHETIC."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, apply, plan_of, read_table
from erclutch.logs.table import Table

_ROWS = [f"{0.01 * row:.2f},{row % 7}.5,{row % 5 - 2}.25" for row in range(40)]


def table_of(tmp_path: Path, lines: Sequence[str], name: str = "log.csv") -> Table:
    path = tmp_path / name
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return read_table(path)


@pytest.mark.parametrize(
    "settings",
    [
        ["Calibration,2.71,0.2983", "Offset,0,0", "Units,g,g"],
        ["Range,5,2", "Filter,FLAT,FLAT", "Factor,1.5,2.5", "Label,a,b"],
        ["Serial,4711,4712", "Gain,1,10"],
    ],
)
def test_settings_of_each_channel_above_the_names_are_no_rows(
    tmp_path: Path, settings: list[str]
) -> None:
    table = table_of(tmp_path, [*settings, "Time,CH1,CH2", *_ROWS])
    assert [name.split()[0] for name in table.columns] == [
        "Time",
        "CH1",
        "CH2",
    ]  # a label may stand behind
    assert table.rows == len(_ROWS)


@pytest.mark.parametrize("word", ["Unit", "単位", "Einheit", "Units"])
def test_a_line_that_is_called_unit_gives_the_units_of_the_names_below(
    tmp_path: Path, word: str
) -> None:
    table = table_of(tmp_path, ["Offset,0,0", f"{word},N,mm", "Time(sec),Force,Stroke", *_ROWS])
    assert table.units == {"Time": "sec", "Force": "N", "Stroke": "mm"}


def test_a_line_that_is_called_unit_and_holds_none_gives_none(tmp_path: Path) -> None:
    table = table_of(tmp_path, ["Unit,left,right", "Time(sec),Force,Stroke", *_ROWS])
    assert table.units["Force"] is None


@pytest.mark.parametrize(
    "labels",
    ["0775,,0758,", "a,,b,", '"5 A",,"10 A",', "0.5,,1.5,"],
)
def test_labels_over_pairs_of_x_and_y_name_the_curves(tmp_path: Path, labels: str) -> None:
    rows = [f"{x},{x * x},{x + 0.5},{x * 3}" for x in range(1, 13)]
    table = table_of(tmp_path, [labels, "X,Y,X,Y", *rows])
    first, second = (label.strip('"') for label in labels.split(",")[::2])
    assert list(table.columns) == [first, "c2", second, "c4"]
    assert table.rows == len(rows)


def test_a_row_between_two_headers_is_not_skipped(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="line 3, column t is 't' where a number is expected"):
        table_of(tmp_path, ["t,x,F", "0.00,,1.25", "t,x,F", *_ROWS])


@pytest.mark.parametrize("remarks", ["Press,3140,Release,3120", "Date,2024", "operator: me"])
def test_remarks_beside_the_names_are_left_out(tmp_path: Path, remarks: str) -> None:
    rows = [f"{10 * row},{row % 9}.5" for row in range(30)]
    table = table_of(tmp_path, [f"Displacement,Force,,{remarks}", *rows])
    assert list(table.columns)[:2] == ["Displacement", "Force"]


@pytest.mark.parametrize("unit", ["s", "ms"])
def test_an_oscilloscope_writes_a_unit_alone_over_its_time(tmp_path: Path, unit: str) -> None:
    table = table_of(tmp_path, [f"in {unit},C1 in V,C2 in V", *_ROWS])
    assert table.units == {f"in {unit}": unit, "C1": "V", "C2": "V"}


def log_of(time: str, times: Sequence[str]) -> list[str]:
    rows = [f"{at},{np.sin(0.3 * row):.6f},{0.5 + row % 3}" for row, at in enumerate(times)]
    return [f"{time},speed [rad/s],torque [Nm]", *rows]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("time", "times"),
    [
        ("t [s]", [f"{0.01 * row:.2f}" for row in range(60)]),
        ("Timestamp", [f"2024-05-06 10:00:{0.1 * row:06.3f}" for row in range(60)]),
        ("time [ms]", [f"{5 * row}" for row in range(60)]),
    ],
)
def test_a_log_whose_newest_row_stands_first_is_turned_round(
    tmp_path: Path, time: str, times: list[str]
) -> None:
    head, *rows = log_of(time, times)
    forward = table_of(tmp_path, [head, *rows], "forward.csv")
    backward = table_of(tmp_path, [head, *rows[::-1]], "backward.csv")
    told = ColumnMap.from_options({"field": "none"})
    right = apply(plan_of(forward, told), forward)
    turned = apply(plan_of(backward, told), backward)
    np.testing.assert_allclose(turned.signals["slip"], right.signals["slip"])
    np.testing.assert_allclose(np.diff(turned.time), np.diff(right.time), atol=1e-9)
    assert any("the rows are turned round" in note for note in turned.notes)
    assert not any("the rows are turned round" in note for note in right.notes)


@pytest.mark.slow
@pytest.mark.parametrize("other", ["T_on [s]", "delay [s]"])
def test_dates_to_the_second_give_way_to_the_same_time_in_finer_steps(
    tmp_path: Path, other: str
) -> None:
    seconds = [498.8 + 0.01 * row for row in range(300)]
    rows = [
        f"2024-05-06 10:00:{int(at - 490.0):02d},{at:.2f},{row % 2},{np.sin(row):.5f},{row % 3}"
        for row, at in enumerate(seconds)
    ]
    table = table_of(tmp_path, [f"Time,stop [s],{other},speed [rad/s],torque [Nm]", *rows])
    clock = plan_of(table, ColumnMap.from_options({"field": "none"})).clock
    assert clock is not None
    assert clock.column == "stop"


@pytest.mark.parametrize("mark", [",", "\t", ";", " "])
def test_names_and_units_in_comments_above_numbers_between_blanks(
    tmp_path: Path, mark: str
) -> None:
    above = ["# bench 3", f"# time{mark}force{mark}stroke", f"# s{mark}N{mark}mm"]
    table = table_of(tmp_path, [*above, *(row.replace(",", " ") for row in _ROWS)], "log.txt")
    assert table.units == {"time": "s", "force": "N", "stroke": "mm"}


@pytest.mark.parametrize(
    "names",
    [
        ["# column 1: time [s]", "# column 2: force [N]", "# column 3: stroke [mm]"],
        ["# 0 = time (s)", "# 1 = force (N)", "# 2 = stroke (mm)"],
        ["% Ch1: time [s]", "% remark", "% Ch2: force [N]", "% Ch3: stroke [mm]"],
    ],
)
def test_comments_name_the_columns_by_their_numbers(tmp_path: Path, names: list[str]) -> None:
    table = table_of(tmp_path, [*names, *_ROWS])
    assert table.units == {"time": "s", "force": "N", "stroke": "mm"}


def test_a_summary_below_the_rows_is_left_out_with_a_word(tmp_path: Path) -> None:
    summary = ["", "Summary", "quantity,value", "largest force,6.5", "", "operator AB"]
    table = table_of(tmp_path, ["time,force,stroke", *_ROWS, *summary])
    assert table.rows == len(_ROWS)
    assert any("text below the table left out: 'Summary'" in note for note in table.notes)


def test_rows_behind_a_blank_line_are_no_summary(tmp_path: Path) -> None:
    table = table_of(tmp_path, ["time,force,stroke", *_ROWS[:20], "", *_ROWS[20:]])
    assert table.rows == len(_ROWS)


@pytest.mark.slow
@pytest.mark.parametrize("every", [10, 13])
def test_a_header_that_a_logger_says_again_parts_no_log(tmp_path: Path, every: int) -> None:
    lines: list[str] = []
    for row, line in enumerate(_ROWS):
        lines += ["time [s],force [N],stroke [mm]"] if row % every == 0 else []
        lines.append(line)
    table = table_of(tmp_path, lines)
    assert table.rows == len(_ROWS)
    assert any("the time goes on below each: one recording" in note for note in table.notes)


@pytest.mark.slow
def test_a_header_below_which_the_time_begins_anew_parts_a_log(tmp_path: Path) -> None:
    head = "time [s],force [N],stroke [mm]"
    with pytest.raises(LogError, match="several recordings"):
        table_of(tmp_path, [head, *_ROWS, head, *_ROWS])


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["utf-8", "cp1250", "iso8859_2"])
def test_a_testing_machine_in_polish_is_understood_with_its_own_letters(
    tmp_path: Path, encoding: str
) -> None:
    head = "Godzina;Przemieszczenie;Obciążenie;Odkształcenie 1\n(s);(mm);(N);(mm/mm)"
    rows = [
        f'"{k / 10:.2f}";"{k * k / 900:.4f}";"{3 * k + k % 7:.3f}";"{k / 9000:.6f}"'
        for k in range(90)
    ]
    text = "\n".join([head, *(row.replace(".", ",") for row in rows)])
    (tmp_path / "log.csv").write_bytes(text.encode(encoding))
    plan = plan_of(read_table(tmp_path / "log.csv"), ColumnMap())
    chosen = {signal: choice.column for signal, choice in plan.choices.items()}
    assert (plan.questions, plan.doubts) == ((), ())
    assert (chosen["time"], chosen["position"], chosen["effort"]) == (
        "Godzina",
        "Przemieszczenie",
        "Obciążenie",
    )


@pytest.mark.parametrize("name", ["45°N m²s", "Kraft¹Sensor", "Größe±Fehler", "N·m"])
def test_signs_inside_of_latin_words_stay_signs(tmp_path: Path, name: str) -> None:
    text = "\n".join([f"Zeit;{name};Kraft", *(row.replace(",", ";") for row in _ROWS)])
    (tmp_path / "log.csv").write_bytes(text.encode("latin-1"))
    assert any(
        name.split("°")[0][:3] in column for column in read_table(tmp_path / "log.csv").columns
    )
    assert not any(
        letter in "ąćęłńśźż" for letter in "".join(read_table(tmp_path / "log.csv").columns)
    )


@pytest.mark.slow
@pytest.mark.parametrize(("head", "mark"), [("w,T", ","), ("w\tT", "\t"), ("w T", " "), ("", ";")])
def test_stamps_of_a_serial_monitor_are_the_time(tmp_path: Path, head: str, mark: str) -> None:
    rows = [f"12:30:{0.1 * row:06.3f} -> {row % 7}.5{mark}{row % 5}.25" for row in range(40)]
    above = [f"12:29:59.900 -> {head}"] if head else []
    table = table_of(tmp_path, [*above, *rows], "monitor.txt")
    assert table.clock is not None
    np.testing.assert_allclose(np.diff(table.clock), 0.1, atol=1e-6)
    assert len(table.columns) == 2


_LANGUAGES = {
    "Russian": ("Время, с;Ток, А;Скорость, об/мин;Момент, Н·м", "cp1251"),
    "Russian in brackets": (
        "Время [с];Ток [А];Скорость вращения [рад/с];Крутящий момент [Нм]",
        "utf-8",
    ),
    "Korean": ("시간(s);전류(A);속도(rpm);토크(Nm)", "cp949"),
    "Korean in UTF-8": ("시간(s);모터 전류(A);회전 속도(rpm);토크(Nm)", "utf-8"),
    "Polish": ("Czas [s];Prąd [A];Prędkość obrotowa [obr/min];Moment [Nm]", "utf-8"),
    "Polish of Windows": ("Czas [s];Prąd [A];Prędkość obrotowa [obr/min];Moment [N·m]", "cp1250"),
    "Polish of ISO": ("Czas [s];Prąd [A];Prędkość [obr/min];Obciążenie [Nm]", "iso8859_2"),
    "Czech": ("Čas [s];Proud [A];Otáčky [ot/min];Moment [Nm]", "cp1250"),
    "Dutch": ("Tijd [s];Stroom [A];Toerental [omw/min];Koppel [Nm]", "utf-8"),
    "Swedish": ("Tid [s];Ström [A];Varvtal [varv/min];Vridmoment [Nm]", "cp1252"),
    "Turkish": ("Zaman (s);Akım (A);Hız (rpm);Tork (Nm)", "utf-8"),
    "Italian": ("Tempo [s];Corrente [A];Velocità [giri/min];Coppia [Nm]", "cp1252"),
    "Portuguese": ("Tempo (s);Corrente (A);Rotação (rpm);Torque (N.m)", "cp1252"),
}


@pytest.mark.parametrize("language", _LANGUAGES)
def test_headers_of_further_languages_are_understood(tmp_path: Path, language: str) -> None:
    head, encoding = _LANGUAGES[language]
    rows = [
        f"{0.01 * row:.2f};{row // 30}.5;{row % 7 - 3}.25;{row % 5 - 2}.75" for row in range(120)
    ]
    (tmp_path / "log.csv").write_bytes("\n".join([head, *rows]).encode(encoding))
    table = read_table(tmp_path / "log.csv")
    plan = plan_of(table, ColumnMap())
    assert not plan.questions
    assert not plan.doubts
    names = list(table.columns)
    chosen = {signal: choice.column for signal, choice in plan.choices.items()}
    assert chosen == dict(zip(("time", "field", "slip", "effort"), names, strict=True))
    si = {each.signal: each.si for each in plan.signals}
    assert si == {"field": "A", "slip": "rad/s", "effort": "N*m"}


def test_a_byte_that_is_no_sign_of_its_encoding_ends_no_reading(tmp_path: Path) -> None:
    # 0x81 is none of Windows' signs: in a remark it made a traceback of a log with Polish names.
    head = "Czas [s];Prędkość obrotowa [obr/min];Siła [N]\n".encode("cp1250")
    rows = b"0.1;2;3\n0.2;4;5\n0.3;5;7\n"
    (tmp_path / "log.csv").write_bytes(b"# \x81\n" + head + rows)
    table = read_table(tmp_path / "log.csv")
    assert table.rows == 3
    assert len(table.columns) == 3


@pytest.mark.parametrize(
    "text", ["Zeit;Größe [°C];Kraft [N]", "temps;déplacé à é;force", "tempo;ação [µm];força"]
)
def test_accents_of_latin_words_are_not_cyrillic(tmp_path: Path, text: str) -> None:
    (tmp_path / "log.csv").write_bytes(
        "\n".join([text, *(row.replace(",", ";") for row in _ROWS)]).encode("latin-1")
    )
    assert "".join(read_table(tmp_path / "log.csv").columns).isascii() is False
    assert all(letter < "\u0400" for letter in "".join(read_table(tmp_path / "log.csv").columns))


@pytest.mark.parametrize(
    "comment",
    [
        "# t [s], x [mm], F [N]",
        "# Columns: t [s]; x [mm]; F [N]",
        "% t (s)  x (mm)  F (N)",
        "// T [s]\tX [mm]\tF [N]",
    ],
)
def test_a_comment_states_the_units_of_bare_names(tmp_path: Path, comment: str) -> None:
    rows = "".join(f"{k / 100}\t{k % 7}\t{k % 5}\n" for k in range(60))
    path = tmp_path / "log.txt"
    path.write_text(f"{comment}\nt\tx\tF\n{rows}")
    assert dict(read_table(path).units) == {"t": "s", "x": "mm", "F": "N"}


def test_a_comment_may_state_the_units_of_some_names(tmp_path: Path) -> None:
    rows = "".join(f"{k / 100}\t{k % 7}\t{k % 5}\n" for k in range(60))
    path = tmp_path / "log.txt"
    path.write_text(f"# x [mm], F [N]\nt\tx\tF\n{rows}")
    assert dict(read_table(path).units) == {"t": None, "x": "mm", "F": "N"}


@pytest.mark.parametrize("comment", ["# t [s], x [mm], G [N]", "# t [s], x [mm], F [N], v [m/s]"])
def test_a_comment_on_other_columns_states_no_units(tmp_path: Path, comment: str) -> None:
    rows = "".join(f"{k / 100}\t{k % 7}\t{k % 5}\n" for k in range(60))
    path = tmp_path / "log.txt"
    path.write_text(f"{comment}\nt\tx\tF\n{rows}")
    assert not any(read_table(path).units.values())

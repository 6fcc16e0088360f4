"""Tables that lie on their side or are tidy, words of meters, hexadecimal numbers, remarks in rows, arrays of NumPy."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from erclutch.errors import LogError
from erclutch.logs import ColumnMap, plan_of, read, read_table
from erclutch.logs.readers.lying_tables import upright
from tests.support.command import good
from tests.support.slow_params import slow_behind

ROWS = [(k / 100, (k % 7) - 3.0, (k % 5) - 2.0) for k in range(60)]
NAMES = ("t [s]", "speed [rad/s]", "torque [N*m]")


def written(folder: Path, text: str, name: str = "log.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def upright_text(beside: dict[int, str] | None = None) -> str:
    remarks = beside or {}
    rows = "".join(f"{t},{w},{remarks.get(k, torque)}\n" for k, (t, w, torque) in enumerate(ROWS))
    return f"{','.join(NAMES)}\n{rows}"


@pytest.mark.parametrize("with_unit_cells", [False, True])
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_a_table_with_a_signal_a_row_is_set_upright(
    tmp_path: Path, delimiter: str, with_unit_cells: bool
) -> None:
    heads = (
        [["t", "s"], ["speed", "rad/s"], ["torque", "Nm"]]
        if with_unit_cells
        else [[name] for name in NAMES]
    )
    lines = [
        delimiter.join([*head, *map(str, row)])
        for head, row in zip(heads, zip(*ROWS, strict=True), strict=True)
    ]
    table = read_table(written(tmp_path, "\n".join(lines) + "\n"))
    assert list(table.columns) == ["t", "speed", "torque"]
    assert table.columns["speed"].tolist() == [w for _, w, _ in ROWS]
    assert table.units["torque"] in ("N*m", "Nm")
    assert "the table has a signal a row: its rows are taken as columns" in table.notes


def test_rows_with_a_name_that_are_no_signals_stay_rows(tmp_path: Path) -> None:
    text = "material,D [1/s],tau [Pa]\n" + "".join(
        f"sample {k},{k + 1},{2 * k + 3}\n" for k in range(12)
    )
    assert read_table(written(tmp_path, text)).rows == 12


@pytest.mark.slow
@given(st.text(max_size=300))
def test_any_text_is_set_upright_or_left_alone(text: str) -> None:
    again, note = upright(text)
    assert note or again == text


@pytest.mark.parametrize("unit_column", [False, True])
def test_a_tidy_table_has_a_column_for_each_signal(tmp_path: Path, unit_column: bool) -> None:
    text = "time,signal,value" + (",unit" if unit_column else "") + "\n"
    for t, w, torque in ROWS:
        for name, unit, value in (("speed", "rad/s", w), ("torque", "Nm", torque)):
            text += (
                f"{t},{name},{value},{unit}\n" if unit_column else f"{t},{name} [{unit}],{value}\n"
            )
    table = read_table(written(tmp_path, text))
    assert table.rows == 60
    assert table.columns["torque"].tolist() == [torque for _, _, torque in ROWS]
    assert table.units["speed"] == "rad/s"
    assert not plan_of(table, ColumnMap()).questions


@pytest.mark.parametrize("column", ["Messstelle", "tagname", "point"])
def test_words_that_name_an_effort_and_others_are_signals_whatever_their_column_is_called(
    tmp_path: Path, column: str
) -> None:
    """A historian's export; an effort is known by its unit, and times of their own are no hindrance."""
    text = f"Zeit;{column};Wert;Einheit\n"
    for t, w, torque in ROWS:
        text += f"{t};BRK.n_ist;{w};1/min\n{t + 0.004};BRK.M_ist;{torque};Nm\n"
    table = read_table(written(tmp_path, text))
    assert table.columns["BRK.M_ist"].tolist() == [torque for _, _, torque in ROWS][:-1]
    assert table.units == {"Zeit": None, "BRK.n_ist": "1/min", "BRK.M_ist": "Nm"}


def test_words_of_a_state_beside_a_value_part_the_rows(tmp_path: Path) -> None:
    rows = "".join(f"{t},{('run', 'stop')[k % 2]},{w}\n" for k, (t, w, _) in enumerate(ROWS))
    assert read_table(written(tmp_path, f"time,state,value\n{rows}")).rows == len(ROWS)


def test_the_signals_of_a_tidy_table_with_times_of_their_own_are_joined_at_those_of_the_effort(
    tmp_path: Path,
) -> None:
    rows = "".join(
        f"{t},speed [rad/s],{100 * t}\n{t + 0.004},torque [Nm],{torque}\n" for t, _, torque in ROWS
    )
    table = read_table(written(tmp_path, f"time,signal,value\n{rows}"))
    assert table.columns["time"].tolist() == [t + 0.004 for t, _, _ in ROWS[:-1]]
    assert np.allclose(table.columns["speed"], 100 * table.columns["time"])
    assert table.columns["torque"].tolist() == [torque for _, _, torque in ROWS[:-1]]
    assert any("joined by straight lines" in note for note in table.notes)
    assert not plan_of(table, ColumnMap()).questions


@pytest.mark.slow
@pytest.mark.parametrize("id_of", [lambda name: f"0x{len(name):03X}", lambda name: str(len(name))])
def test_the_number_of_a_message_is_no_signal_of_a_tidy_table(
    tmp_path: Path, id_of: Callable[[str], str]
) -> None:
    rows = ""
    for t, _, torque in ROWS:
        for at, name, value in ((t, "speed [rad/s]", 100 * t), (t + 0.004, "torque [Nm]", torque)):
            rows += f"{at},can0,{id_of(name)},{name},{value}\n"
    table = read_table(written(tmp_path, f"timestamp,bus,id,signal,value\n{rows}"))
    assert {*table.columns} == {"timestamp", "speed", "torque"}
    assert "column id is the same in all values of a signal: left out" in table.notes


def test_a_number_that_differs_within_a_signal_leaves_a_tidy_table_as_it_is(
    tmp_path: Path,
) -> None:
    rows = "".join(
        f"{t},{n},speed,{100 * t}\n{t + 0.004},{n},torque,{torque}\n"
        for n, (t, _, torque) in enumerate(ROWS)
    )
    table = read_table(written(tmp_path, f"time,counter,signal,value\n{rows}"))
    assert "counter" in table.columns


@pytest.mark.parametrize(
    "names",
    [("speed", "angle"), ("torque A", "torque B"), ("speed", "torque")],
    ids=["no effort", "two", "falls back"],
)
def test_a_tidy_table_that_cannot_be_joined_is_left_as_it_is(
    tmp_path: Path, names: tuple[str, str]
) -> None:
    first, second = names
    rows = "".join(f"{t},{first},{w}\n{t + 0.004},{second},{torque}\n" for t, w, torque in ROWS)
    rows += "0.0,speed,1\n" if second == "torque" else ""
    table = read_table(written(tmp_path, f"time,signal,value\n{rows}"))
    assert "signal" in table.words


@pytest.mark.slow
@pytest.mark.parametrize("delimiter", [" ", "\t", ","])
def test_rows_of_numbers_wider_than_any_log_are_columns(tmp_path: Path, delimiter: str) -> None:
    long = np.arange(1500) / 100
    lines = [
        delimiter.join(f"{value:.6e}" for value in row)
        for row in (long, np.sin(long), np.cos(long))
    ]
    table = read_table(written(tmp_path, "\n".join(lines) + "\n", "log.txt"))
    assert table.rows == 1500
    assert np.allclose(table.columns["c2"], np.sin(long), atol=1e-6)
    assert plan_of(table, ColumnMap()).questions  # names say nothing


@pytest.mark.slow
def test_rows_of_numbers_no_wider_than_a_log_stay_rows(tmp_path: Path) -> None:
    lines = [" ".join(str(k * m) for k in range(200)) for m in range(1, 13)]
    assert read_table(written(tmp_path, "\n".join(lines) + "\n", "log.txt")).rows == 12


@pytest.mark.slow
@pytest.mark.parametrize("word", slow_behind(2, ["OL", "-OL", "OVLD", "ovld", "OVRNG"]))
def test_a_reading_beyond_the_range_of_its_meter_is_missing_and_told(
    tmp_path: Path, word: str
) -> None:
    path = written(tmp_path, upright_text({5: word, 6: word}))
    table = read_table(path)
    assert np.flatnonzero(np.isnan(table.columns["torque"])).tolist() == [5, 6]
    assert (
        f"column torque holds {word!r} in 2 rows, a reading beyond the range of its meter: no number"
        in table.notes
    )
    said = good("inspect", "log.csv", cwd=tmp_path)
    assert "2 rows dropped, the log cut there" in " ".join(said.split())


@pytest.mark.parametrize("remark", ["1.5 # brake on", "1.5 // brake on", "1.5,# brake on"])
def test_a_remark_behind_the_numbers_of_a_row_is_left_out(tmp_path: Path, remark: str) -> None:
    table = read_table(written(tmp_path, upright_text({4: remark})))
    assert table.columns["torque"][4] == 1.5
    assert any("left out" in note for note in table.notes)


def test_a_number_behind_a_number_is_no_remark(tmp_path: Path) -> None:
    table = read_table(written(tmp_path, upright_text({4: "1.5 2.5"})))
    assert "torque" not in table.columns


def test_hexadecimal_numbers_are_whole_numbers(tmp_path: Path) -> None:
    rows = "".join(f"{10 * k},0x{k:04X},{k % 5}\n" for k in range(40))
    table = read_table(written(tmp_path, f"time [ms],pos,torque [N*m]\n{rows}"))
    assert table.columns["pos"].tolist() == list(range(40))
    assert "column pos holds hexadecimal numbers, read as whole numbers" in table.notes


@pytest.mark.slow
def test_hexadecimal_numbers_that_may_be_negative_are_not_read(tmp_path: Path) -> None:
    rows = "".join(f"{10 * k},0x{(k - 20) & 0xFFFF:04X},{k % 5}\n" for k in range(40))
    assert "pos" not in read_table(written(tmp_path, f"time [ms],pos,torque [N*m]\n{rows}")).columns


@pytest.mark.slow
@pytest.mark.parametrize("words", [("CW", "CCW"), ("forward", "reverse"), ("up", "down")])
@pytest.mark.parametrize("against", [1, -1])
def test_a_speed_takes_its_sign_from_words_of_the_sense(
    tmp_path: Path, words: tuple[str, str], against: int
) -> None:
    text = "t [s],direction,speed [rad/s],torque [N*m]\n"
    for k in range(80):
        sense = 1 if k % 20 < 10 else -1
        text += f"{k / 100},{words[sense < 0]},{1 + k % 3},{against * sense * (2 + k % 4)}\n"
    table = read_table(written(tmp_path, text))
    assert table.columns["speed"].tolist() == [
        (1 if k % 20 < 10 else -1) * (1 + k % 3) for k in range(80)
    ]
    assert (
        f"column speed has no sign and torque has: it is turned where direction is {words[1]}"
        in table.notes
    )
    assert not plan_of(table, ColumnMap()).doubts


@pytest.mark.slow
def test_a_torque_that_keeps_to_no_sense_leaves_the_speed_in_doubt(tmp_path: Path) -> None:
    rows = "".join(
        f"{k / 100},{'CW' if k % 20 < 10 else 'CCW'},{1 + k % 3},{k % 5 - 2}\n" for k in range(80)
    )
    table = read_table(written(tmp_path, f"t [s],direction,speed [rad/s],torque [N*m]\n{rows}"))
    assert table.columns["speed"].min() > 0
    assert plan_of(table, ColumnMap()).doubts


@pytest.mark.slow
@pytest.mark.parametrize(("count", "unit"), [(300, "ms"), (60, "s")])
def test_many_whole_stamps_without_a_unit_are_proposed_as_milliseconds(
    tmp_path: Path, count: int, unit: str
) -> None:
    rows = "".join(f"{61015 + 10 * k},{k % 7 - 3},{k % 5 - 2}\n" for k in range(count))
    written(tmp_path, f"t,rpm,torque\n{rows}")
    assert (
        f'--time "t [{unit}]"' in good("inspect", "log.csv", cwd=tmp_path, code=1).splitlines()[-1]
    )


def test_names_above_an_empty_comment_are_names(tmp_path: Path) -> None:
    rows = "".join(f"{t}\t{w}\t{torque}\n" for t, w, torque in ROWS)
    table = read_table(
        written(tmp_path, f"#t (s)\tspeed (rad/s)\ttorque (N*m)\n#\n{rows}", "log.dat")
    )
    assert list(table.columns) == ["t", "speed", "torque"]


@pytest.mark.usefixtures("read_here")
def test_arrays_of_numpy_are_read(tmp_path: Path) -> None:
    t, w, torque = (np.array(column) for column in zip(*ROWS, strict=True))
    np.savez(tmp_path / "log.npz", time_s=t, speed=w, torque=torque, note=np.array("a test"))
    np.save(tmp_path / "log.npy", np.array(ROWS, [("t", "f8"), ("speed", "f8"), ("torque", "f8")]))
    for name in ("log.npz", "log.npy"):
        table = read_table(tmp_path / name)
        assert table.rows == 60
        assert table.columns["torque"].tolist() == torque.tolist()


@pytest.mark.usefixtures("read_here")
def test_objects_in_arrays_of_numpy_are_never_made(tmp_path: Path) -> None:
    np.save(tmp_path / "log.npy", np.array([{"a": 1}], dtype=object))
    with pytest.raises(LogError, match="Python objects, which may run programs"):
        read_table(tmp_path / "log.npy")
    (tmp_path / "torn.npy").write_bytes(b"\x93NUMPY\x01\x00")
    with pytest.raises(LogError, match="damaged"):
        read_table(tmp_path / "torn.npy")


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_topics_with_a_payload_each_are_signals(tmp_path: Path) -> None:
    # The payload of all topics was proposed as the effort.
    lines: list[str] = []
    for k in range(200):
        values = {"current_A": k // 50 / 2, "speed_rpm": k % 37 - 18.5, "torque_Nm": k % 7 - 3.25}
        for topic, value in values.items():
            lines.append(f'{{"t": {k / 100}, "topic": "brake/{topic}", "payload": {value}}}')
    path = tmp_path / "log.jsonl"
    path.write_text("\n".join([*lines, ""]), encoding="utf-8")
    log = read(path)
    assert log.period == pytest.approx(0.01)
    assert log.units == {"field": "A", "slip": "rad/s", "effort": "N*m"}
    np.testing.assert_allclose(log.signals["field"], np.repeat([0.0, 0.5, 1.0, 1.5], 50))

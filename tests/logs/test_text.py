from __future__ import annotations

import gzip
import random
import re
import time
import tracemalloc
import zlib
from collections.abc import Callable, Iterable
from contextlib import suppress
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from erclutch import registry
from erclutch.errors import ErclutchError, LogError, MappingError
from erclutch.logs import Table, read, read_table
from erclutch.logs.columns.labels import name_columns, split_label
from erclutch.logs.log_reader import GROUP, LogSource, read_by
from erclutch.logs.readers.dates import seconds
from erclutch.logs.readers.dialect import LINE_END, lines_of
from erclutch.logs.readers.text_blocks import text_extent, text_windows
from erclutch.logs.readers.text_bytes import decode
from tests.support.examples import examples
from tests.support.pace import within
from tests.support.slow_params import slow_behind

HEADERS = ("plain", "quoted", "square", "round", "slash", "second row", "comment", "none")
NAMES, UNITS = ("t", "Y", "V", "F"), ("s", "V", "cm/s", "N")


def table_of(text: str | bytes, name: str = "log.csv") -> Table:
    source = LogSource(Path(name), text if isinstance(text, bytes) else text.encode(), "digest")
    return read_by(registry.find(GROUP, "text"), source)


def header_of(style: str, delimiter: str) -> list[str]:
    labels = {
        "plain": [delimiter.join(NAMES)],
        "quoted": [delimiter.join(f'"{name}"' for name in NAMES)],
        "square": [
            delimiter.join(f"{name} [{unit}]" for name, unit in zip(NAMES, UNITS, strict=True))
        ],
        "round": [
            delimiter.join(f"{name} ({unit})" for name, unit in zip(NAMES, UNITS, strict=True))
        ],
        "slash": [
            delimiter.join(f"{name} / {unit}" for name, unit in zip(NAMES, UNITS, strict=True))
        ],
        "second row": [delimiter.join(NAMES), delimiter.join(UNITS)],
        "comment": ["# " + delimiter.join(NAMES)],
        "none": [],
    }
    return labels[style]


@pytest.mark.slow
@settings(max_examples=examples(150), suppress_health_check=[HealthCheck.too_slow], deadline=None)
@given(
    data=st.lists(
        st.tuples(*[st.floats(allow_nan=False, allow_infinity=False, width=64)] * 4),
        min_size=3,
        max_size=12,
    ),
    delimiter=st.sampled_from([",", ";", "\t", "|", "  "]),
    comma=st.booleans(),
    style=st.sampled_from(HEADERS),
    ending=st.sampled_from(["\n", "\r\n", "\r"]),
    trailing=st.booleans(),
    encoding=st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "latin-1"]),
)
def test_numbers_come_back_exactly(
    data: list[tuple[float, ...]],
    delimiter: str,
    comma: bool,
    style: str,
    ending: str,
    trailing: bool,
    encoding: str,
) -> None:
    comma = comma and delimiter != ","
    trailing = trailing and delimiter != "  "
    if delimiter == "  " and style == "slash":
        style = "square"
    lines = [delimiter.join(repr(cell) for cell in row) for row in data]
    lines = [line.replace(".", ",") if comma else line for line in lines]
    text = (
        ending.join(
            line + delimiter.strip(" ") * trailing
            for line in [*header_of(style, delimiter), *lines]
        )
        + ending
    )
    table = table_of(text.encode(encoding))
    assert list(table.columns) == (["c1", "c2", "c3", "c4"] if style == "none" else list(NAMES))
    assert np.array_equal(np.column_stack(list(table.columns.values())), np.array(data))
    if style in {"square", "round", "slash", "second row"}:
        assert tuple(table.units.values()) == UNITS
    assert any("delimiter" in note for note in table.notes) == trailing


@pytest.mark.slow
@settings(max_examples=examples(200), deadline=None)
@given(st.binary(max_size=300))
def test_random_bytes_give_a_table_or_an_error_of_ours(data: bytes) -> None:
    with suppress(ErclutchError):
        assert table_of(data).rows >= 0


@pytest.mark.slow
@settings(max_examples=examples(200), deadline=None)
@given(
    st.lists(st.tuples(st.integers(0, 200), st.integers(0, 255)), min_size=1, max_size=8),
    st.integers(0, 200),
)
def test_a_damaged_log_gives_a_table_or_an_error_of_ours(
    changes: list[tuple[int, int]], cut: int
) -> None:
    text = bytearray(
        b"Rate: 1000\n"
        + b't,"V [cm/s]",F,\n'
        + b"".join(b"%d.5,2.25,-%d,\n" % (i, i) for i in range(15))
    )
    for place, byte in changes:
        text[place % len(text)] = byte
    with suppress(ErclutchError):
        assert table_of(bytes(text[: len(text) - cut % 100])).rows >= 0


@pytest.mark.slow
@settings(max_examples=examples(150), deadline=None)
@given(st.text("0123456789.,;-+eE \t\n\r\"'#%|ab:/", max_size=200))
def test_almost_tables_give_a_table_or_an_error_of_ours(text: str) -> None:
    with suppress(ErclutchError):
        assert table_of(text).rows >= 0


@pytest.mark.slow
def test_a_long_text_tells_how_much_was_read(tmp_path: Path) -> None:
    path, told = tmp_path / "log.csv", list[tuple[int, int]]()
    path.write_text("t,a\n" + "".join(f"{k},{k % 7}\n" for k in range(100_000)))
    read_table(path, told=lambda done, total: told.append((done, total)))
    parts = [done for done, total in told]
    assert parts == sorted(parts)
    assert 0 < parts[0] < parts[-1] == told[-1][1]


def test_ctrl_c_ends_the_reading_of_a_long_text(tmp_path: Path) -> None:
    def stop(done: int, total: int) -> None:
        raise KeyboardInterrupt

    (tmp_path / "log.csv").write_text("t,a\n" + "1,2\n" * 1000)
    with pytest.raises(KeyboardInterrupt):
        read_table(tmp_path / "log.csv", told=stop)


def test_lines_end_as_windows_linux_and_old_macs_end_them() -> None:
    text = "a\r\nb\n\rc\r\r\nd\n"
    assert lines_of(text) == LINE_END.split(text) == ["a", "b", "", "c", "", "d", ""]
    assert lines_of("") == LINE_END.split("") == [""]


def test_labels_split_into_name_and_unit() -> None:
    assert split_label("V [cm/s]") == ("V", "cm/s")
    assert split_label("Force (N)") == ("Force", "N")
    assert split_label("time / s") == ("time", "s")
    assert split_label("Torque_Nm") == ("Torque_Nm", None)
    assert split_label("u[0]") == ("u[0]", None)
    assert split_label("gain (left)") == ("gain (left)", None)
    assert split_label("n [weird]") == ("n", "weird")
    assert split_label("F/A") == ("F/A", None)


def test_columns_that_differ_in_their_unit_keep_both_names() -> None:
    table = table_of("t [s],V [V],V [cm/s],F,F\n" + "".join(f"{i},1,2,3,4\n" for i in range(12)))
    assert list(table.columns) == ["t", "V [V]", "V [cm/s]", "F", "F (2)"]
    assert any("renamed 'F (2)'" in note for note in table.notes)


def test_a_column_filled_in_its_first_row_is_a_constant() -> None:
    table = table_of("t,fs,F,\n0,3004.8,1,\n" + "".join(f"{i},,2,\n" for i in range(1, 12)))
    assert list(table.columns) == ["t", "F"]
    assert table.constants == {"fs": 3004.8}


def test_text_columns_are_left_out_and_said() -> None:
    table = table_of("t;mode;F\n" + "".join(f"{i};AUTO;{i},5\n" for i in range(12)))
    assert list(table.columns) == ["t", "F"]
    assert "column mode holds text ('AUTO') in 12 of 12 rows: left out" in table.notes
    assert table.numbered(3) == "F"


def test_a_header_block_gives_period_and_metadata() -> None:
    text = "Sampling Rate [kHz]: 2\nOperator: Meier\n\nn, F\n" + "".join(
        f"{i}, 1.5\n" for i in range(12)
    )
    table = table_of(text)
    assert table.sample_period == pytest.approx(0.5e-3)
    assert table.metadata["Operator"] == "Meier"


@pytest.mark.slow
def test_dates_become_a_clock() -> None:
    text = "when;F\n" + "".join(f"2024-03-05 10:00:{i:02d},500;1,5\n" for i in range(12))
    table = table_of(text)
    assert table.clock_name == "when"
    assert table.clock is not None
    assert np.array_equal(table.clock, np.arange(12.0))


def test_comments_between_rows_are_skipped_and_lines_still_counted() -> None:
    text = "t,F\n" + "0,1\n# pause\n" + "".join(f"{i},2\n" for i in range(1, 9)) + "9,oops\n"
    table = table_of(text)
    assert list(table.columns) == ["t"]
    assert table.unreadable == {"F": "line 12, column F is 'oops' where a number is expected"}


def test_a_row_cut_off_at_the_end_is_left_out() -> None:
    table = table_of("t,V,F\n" + "".join(f"{i},2,3\n" for i in range(12)) + "12,2")
    assert table.rows == 12
    assert "the last row was cut off in the middle: left out" in table.notes


@pytest.mark.parametrize(
    ("end", "kept"),
    [
        ("-1.07", False),
        ("-1.", False),
        ("-1", False),
        ("-", False),
        ("-1.0743", True),
        ("-1.07\n", True),
    ],
)
def test_a_last_number_that_is_cut_is_no_number(end: str, kept: bool, tmp_path: Path) -> None:
    """A logger that was stopped writes a part of a number: it was read as another number, in silence."""
    rows = [f"{0.01 * i:.2f},{i % 7}.5,{(-1) ** i * i / 7:.4f}" for i in range(40)]
    file = tmp_path / "log.csv"
    file.write_text("\n".join(["t [s],field [V],torque [N*m]", *rows, f"0.40,2.5,{end}"]))
    table = read_table(file)
    assert table.rows == 40 + kept
    assert any("end within a number" in note for note in table.notes) != kept


def test_numbers_of_any_length_are_whole(tmp_path: Path) -> None:
    """Where numbers have as many digits as they need, a short one at the end is whole."""
    rows = [f"{0.01 * i:.2f},{i % 7}.5,{i / 8:g}" for i in range(40)]
    file = tmp_path / "log.csv"
    file.write_text("\n".join(["t [s],field [V],torque [N*m]", *rows, "0.40,2.5,5"]))
    assert read_table(file).rows == 41


def test_quoted_decimal_commas_between_commas() -> None:
    table = table_of('t,F\n"0,5","1,25"\n"1,5","2,25"\n"2,5","3,25"\n')
    assert np.array_equal(table.columns["F"], [1.25, 2.25, 3.25])


def test_nan_and_infinity_are_numbers() -> None:
    table = table_of("t,F\n0,1\n1,NaN\n2,inf\n3,-Infinity\n4,\n5,2\n")
    np.testing.assert_array_equal(table.columns["F"], [1, np.nan, np.inf, -np.inf, np.nan, 2])


def test_gzip_is_undone(tmp_path: Path) -> None:
    path = tmp_path / "log.csv.gz"
    path.write_bytes(gzip.compress(b"t,F\n0,1\n1,2\n"))
    assert read_table(path).rows == 2
    path.write_bytes(gzip.compress(b"t,F\n0,1\n1,2\n")[:-9])
    with pytest.raises(LogError, match="gzip data is damaged"):
        read_table(path)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "the file is empty"),
        ("  \n\n", "the file is empty"),
        ("t,V,F\n", "no row of numbers in 1 line ("),
        ("Dear all,\nplease find attached\n" * 2000, "no row of numbers in"),
        ("t\n1\n2\nx3\n4\n5\n", "line 4, column t is 'x3' where a number is expected"),
        ("t,F\n0,1\n1,2,9\n3,4\n", "line 3 has 3 cells where 2 are expected"),
        ("t,V,F\n0,1,2\n1,2\n3,4,5\n6,7,8\n", "line 3 has 2 cells where 3 are expected"),
        ("t V F\n0 1 2\n1 2\n3 4 5\n6 7 8\n", "line 3 has 2 cells where 3 are expected"),
        ("t,F\nodd,0\n1,2\n2,3\n3,4\n", "line 2, column 1 is 'odd' where a number is expected"),
        (
            "t,F\n0,5,1,25\n1,5,2,25\n",
            "line 1 names 2 columns but the rows have 4 cells (commas in the numbers?)",
        ),
        ("t,F\x00\n0,1\n", "the file holds binary data, not text"),
    ],
)
def test_bad_text_is_named(text: str, problem: str) -> None:
    with pytest.raises(LogError) as caught:
        table_of(text)
    assert problem in str(caught.value)
    assert str(caught.value).startswith("log.csv: ")


# --- hidden characters, long rows, last lines ------------------------------------------------------------------------


def read_or_refused(text: str) -> Table | str:
    """The table, or what is said where there is none."""
    try:
        return table_of(text)
    except LogError as error:
        return str(error)


ROWS = "".join(f"{k * 1e-3:.3f},{k % 7},{k % 5}\n" for k in range(40))


@pytest.mark.parametrize("last", ["\x1c", "\x1d\x1e", "\x0c", " \x85", "\x1c\x1c\n"])
def test_a_last_line_of_control_characters_is_left_out_or_named(last: str) -> None:
    """A text with more of them than one in a hundred is taken for binary data, so there are many rows."""
    found = read_or_refused("t,a,b\n" + ROWS + last)
    if isinstance(found, str):
        assert "line 42" in found
        assert found.isprintable()
    else:
        assert found.rows == 40
        assert "the last row was cut off in the middle: left out" in found.notes


@pytest.mark.parametrize("cell", ["\u00a03", "3\u00a0", "\x1c3", "3\x0b", "\u20073", "3\u200b"])
def test_a_hidden_character_in_a_cell_is_told_with_its_line(cell: str) -> None:
    found = read_or_refused("t,a,b\n" + ROWS + f"0.040,{cell},1\n" + "0.041,1,1\n")
    if isinstance(found, str):
        assert "line 42, column a" in found
    else:
        assert any("line 42 holds a hidden character (U+" in note for note in found.notes)
        assert found.columns["a"][40] == 3.0


def test_a_clean_file_has_no_note() -> None:
    assert table_of("t,a,b\r\n" + ROWS).notes == ()
    assert table_of("t,a,Grösse [µm]\n" + ROWS).notes == ()


def test_an_extra_empty_cell_is_told_with_its_line() -> None:
    table = table_of("t,a,b\n" + ROWS + "0.040,1,1,\n" + "0.041,1,1\n")
    assert table.rows == 42
    assert table.notes == ("line 42 has more cells than there are columns: left out",)


@pytest.mark.parametrize("last", ["DAQ Pause, DAQ Stop\n", "DAQ Pause\nDAQ Stop", "DAQ Stop,,\n\n"])
def test_last_lines_without_a_number_are_left_out_and_told(last: str) -> None:
    table = table_of("t,a,b\n" + ROWS + last)
    assert table.rows == 40
    (note,) = table.notes
    assert note.startswith(("the last line holds no number", "the last 2 lines hold no number"))


@pytest.mark.slow
def test_a_second_remark_on_a_row_is_left_out_and_told() -> None:
    """A DAQ writes what happened behind the row; nothing stands in between."""
    rows = [f"{k}, 05/25/2022 05:50:06.{k:03d} PM, {k % 7}" for k in range(100, 160)]
    rows[0] += ", DAQ Start"
    rows[-1] += ", DAQ Pause, DAQ Stop"
    table = table_of("Sample, Date/Time, Force (N), Events\n" + "\n".join(rows) + "\n")
    assert table.rows == 60
    assert "line 61 has more cells than there are columns: left out" in table.notes
    table = table_of(
        "Sample, Date/Time, Force (N), Events\n" + "\n".join(rows).replace("DAQ Stop", "7") + "\n"
    )
    # A number too many is no remark: whether its row is dropped is asked (`test_torn_columns`).
    assert "line 61 has 5 cells where 4 are expected" in table.torn_rows


def test_a_label_with_two_units_keeps_its_own_and_says_so() -> None:
    names, units, notes = name_columns(["field [A]", "F", "x [mm]"], ["V", "N", "mm"])
    assert (names, units) == (["field", "F", "x"], ["A", "N", "mm"])
    assert notes == ["column 'field' has two units: A in its name is taken, V is not"]


@pytest.mark.parametrize("units", ["s,V,°C", "[s],[V],[°C]", "s,V,degC", "ms,kV,dB"])
def test_a_row_of_units_with_one_that_has_no_factor(units: str) -> None:
    table = table_of(f"t,a,b\n{units}\n" + ROWS)
    assert tuple(table.columns) == ("t", "a", "b")
    assert tuple(table.units.values()) == tuple(unit.strip("[]") for unit in units.split(","))


@pytest.mark.parametrize("name", ["time", "Date/Time", "DateTime"])
def test_dates_of_a_spreadsheet_are_days(tmp_path: Path, name: str) -> None:
    days = 44927.5 + np.arange(200) / 86400.0 / 100.0
    rows = "".join(f"{t:.10f},{k % 2},{np.sin(k / 9):.6f},{k % 7}\n" for k, t in enumerate(days))
    path = tmp_path / "log.csv"
    path.write_text(f"{name},field [V],slip [rad/s],effort [N*m]\n{rows}")
    recording = read(path)
    assert recording.period == pytest.approx(0.01, rel=1e-6)
    assert any(
        "no unit: dates as spreadsheets number them, taken as days" in note
        for note in recording.notes
    )


@pytest.mark.parametrize(("unit", "factor"), [("ms", 1e3), ("us", 1e6), ("ns", 1e9)])
def test_a_time_since_1970_is_known_by_its_size(tmp_path: Path, unit: str, factor: float) -> None:
    stamps = [round(factor * (1_709_560_790 + k / 100)) for k in range(200)]
    (tmp_path / "log.csv").write_text(
        "timestamp,field [V],slip [rad/s],effort [N*m]\n" + _signals(stamps)
    )
    recording = read(tmp_path / "log.csv")
    assert recording.period == pytest.approx(0.01, rel=1e-6)
    assert any(f"no unit: a time since 1970, taken as {unit}" in note for note in recording.notes)


@pytest.mark.slow
def test_rows_far_apart_in_a_time_without_a_unit_are_doubted(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("time,field [V],slip [rad/s],effort [N*m]\n" + _signals(range(200)))
    with pytest.raises(
        MappingError, match=r'grows by 1 a row.*--time "time \[s\]", or --time "time \[ms\]"'
    ):
        read(log)
    assert read(log, time="time [ms]").period == pytest.approx(1e-3)
    assert any('give --time "time [ms]"' in note for note in read(log, time="time").notes)


@pytest.mark.parametrize(("name", "step", "unit"), [("tick", 5000, "us"), ("TS", 5, "ms")])
def test_a_first_column_that_grows_as_a_controller_counts_is_offered_as_the_time(
    tmp_path: Path, name: str, step: int, unit: str
) -> None:
    log = tmp_path / "log.csv"
    stamps = range(0, 300 * step, step)
    log.write_text(f"{name},field [V],slip [rad/s],effort [N*m]\n" + _signals(stamps))
    with pytest.raises(MappingError, match=rf'give --time "{name} \[{unit}\]"'):
        read(log)


def test_a_first_column_that_counts_rows_is_no_time(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text("cnt,field [V],slip [rad/s],effort [N*m]\n" + _signals(range(300)))
    with pytest.raises(MappingError) as error:
        read(log)
    assert "cnt [" not in str(error.value)


@pytest.mark.parametrize(("first", "step"), [(0.0, 0.4), (1.7e9, 2.0), (1.7e12, 20.0)])
def test_rows_that_are_near_each_other_or_stamped_since_1970_are_not(
    tmp_path: Path, first: float, step: float
) -> None:
    log = tmp_path / "log.csv"
    log.write_text(
        "time,field [V],slip [rad/s],effort [N*m]\n"
        + _signals(first + step * k for k in range(200))
    )
    assert read(log).period == pytest.approx(step * (1e-3 if first > 1e12 else 1.0))


@pytest.mark.slow
def test_names_one_short_are_those_of_all_columns_but_of_the_row_names(tmp_path: Path) -> None:
    log, names = tmp_path / "log.csv", "time [s],field [V],slip [rad/s],effort [N*m]\n"
    rows = _signals(k / 100 for k in range(200)).splitlines()
    counted, called = (
        [f"{name(k)},{row}" for k, row in enumerate(rows)]
        for name in ("{}".format, '"run {}"'.format)
    )
    for named in (counted, called):
        log.write_text(names + "\n".join(named) + "\n")
        assert read(log).period == pytest.approx(0.01)
    behind, before = (
        [f"{row},{k / 7:.3f}" for k, row in enumerate(rows)],
        [f"{k / 50},{r}" for k, r in enumerate(rows)],
    )
    for told_of_nowhere in (behind, before):
        log.write_text(names + "\n".join(told_of_nowhere) + "\n")
        with pytest.raises(LogError, match=r"line 1 names 4 columns but the rows have 5 cells"):
            read(log)


def _signals(stamps: Iterable[object]) -> str:
    return "".join(f"{t},{k % 2},{np.sin(k / 9):.6f},{k % 7}\n" for k, t in enumerate(stamps))


@pytest.mark.parametrize(
    "pattern",
    [
        *(
            "%d/%m/%Y %H:%M:%S.%f",
            "%m/%d/%Y %H:%M:%S.%f",
            "%d.%m.%Y %H:%M:%S.%f",
            "%m-%d-%Y %H:%M:%S.%f",
        ),
        *(
            "%Y-%m-%dT%H:%M:%S.%f",
            "%Y-%m-%d %H:%M:%S.%f000",
            "%d/%m/%y %H:%M:%S,%f",
            "%m/%d/%Y %I:%M:%S.%f %p",
        ),
    ],
)
@pytest.mark.parametrize("whole", ["keeps its zeros", "loses its zeros"])
def test_dates_over_midnight_in_any_order_of_day_and_month(pattern: str, whole: str) -> None:
    first = datetime(2024, 4, 3, 23, 59, 58)
    texts = [(first + timedelta(seconds=k / 50)).strftime(pattern) for k in range(200)]
    if whole == "loses its zeros":
        texts = [re.sub(r"[.,]0+(?=\D|$)", "", text) for text in texts]
    found = seconds(pd.Series(texts))
    assert found is not None
    np.testing.assert_allclose(found, np.arange(200) / 50, atol=1e-9)


@pytest.mark.slow
def test_a_clock_set_back_within_its_zone_goes_on() -> None:
    before, after = "2024-10-27T02:59:59.5+02:00", "2024-10-27T02:00:00+01:00"
    found = seconds(pd.Series([before, after, after.replace(":00+", ":01+")]))
    assert found is not None
    assert found.tolist() == [0.0, 0.5, 1.5]


@pytest.mark.slow
def test_a_date_and_a_time_in_two_columns(tmp_path: Path) -> None:
    rows = "".join(
        f"31.12.2024;{'23:59:59' if k < 10 else '00:00:00'},{k % 10}00;{k % 2},5;{k % 7},0\n"
        for k in range(20)
    )
    rows = rows.replace("31.12.2024;00", "01.01.2025;00")
    path = tmp_path / "log.csv"
    path.write_text("Datum;Uhrzeit;Kraft [N];Weg [mm]\n" + rows)
    table = read_table(path)
    assert table.clock_name == "Datum and Uhrzeit"
    assert table.clock is not None
    np.testing.assert_allclose(table.clock, np.arange(20) / 10, atol=1e-9)
    assert not [note for note in table.notes if "holds text" in note]
    path.write_text(
        "Uhrzeit;Kraft [N];Weg [mm]\n" + re.sub(r"(?m)^[\d.]+;", "", rows)
    )  # over midnight, without a date
    clock = read_table(path).clock
    assert clock is not None
    np.testing.assert_allclose(clock, np.arange(20) / 10, atol=1e-9)


# --- size ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", slow_behind(12, range(40)))
def test_a_damaged_gzip_is_named_on_every_road(seed: int, tmp_path: Path) -> None:
    """Whole, in blocks, and where only the first lines are asked for: a checksum, an end too early, damaged codes."""
    rows = "".join(f"{k / 1000},{k % 7 + 0.5}\n" for k in range(4000))
    whole = gzip.compress(f"t,F\n{rows}".encode(), mtime=0)
    chance = random.Random(seed)
    damaged = bytearray(
        whole[: chance.randrange(len(whole) // 2, len(whole))] if seed % 3 == 0 else whole
    )
    damaged[chance.randrange(20, len(damaged))] ^= 1 << chance.randrange(8)
    path = tmp_path / "log.csv.gz"
    path.write_bytes(damaged)
    source = LogSource(path, b"", "")
    roads: list[Callable[[], object]] = [
        lambda: read_table(path),
        lambda: list(text_windows(source, 50, 10)),
        lambda: text_extent(path),
    ]
    for road in roads:
        with suppress(LogError):
            road()
    with pytest.raises(LogError, match="gzip data is damaged"):
        list(text_windows(source, 50, 10))


@pytest.mark.slow
def test_a_small_gzip_takes_little_memory(tmp_path: Path) -> None:
    path = tmp_path / "log.csv.gz"
    path.write_bytes(gzip.compress(("t,a,b\n" + ROWS).encode()))
    tracemalloc.start()
    assert read_table(path).rows == 40
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 50e6


@pytest.mark.slow
def test_a_gzip_that_unpacks_to_far_more_than_a_log_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.csv.gz"
    squeeze = zlib.compressobj(6, zlib.DEFLATED, 31)
    block = b"0.001,0.5,0.5\n" * 100_000
    path.write_bytes(b"".join(squeeze.compress(block) for _ in range(40)) + squeeze.flush())
    with pytest.raises(
        LogError, match=r"bomb.csv.gz: the file unpacks to more than [34]\d,\d+,\d+ bytes of text\."
    ):
        read_table(path)


@pytest.mark.slow
def test_names_are_made_in_linear_time() -> None:
    started = time.process_time()
    names, _, notes = name_columns(["x"] * 20_000 + ["x (7)"])
    assert within(time.process_time() - started, 2.0)
    assert len(set(names)) == 20_001
    assert names[1] == "x (2)"
    assert notes[0] == "column 2 has the name 'x' of an earlier one: renamed 'x (2)'"


@pytest.mark.slow
@given(
    st.lists(
        st.sampled_from(["x", "x [N]", "x [m]", "x (2)", "", " x", "c2", "a\x00\u202e"]),
        max_size=12,
    )
)
def test_names_differ_and_can_be_seen(labels: list[str]) -> None:
    names, _, _ = name_columns(labels)
    assert len(set(names)) == len(labels)
    assert all(name and name.isprintable() for name in names)


def test_a_delimiter_behind_the_labels_alone_names_no_column() -> None:
    body = "\n".join(f"{k};{2 * k}" for k in range(1, 20))
    for text in (f"t;x;\n{body}", f"t [s];x [V];\n{body}"):
        table = table_of(text)
        assert (list(table.columns), table.notes) == (["t", "x"], ())
        assert list(table.columns["x"]) == [2.0 * k for k in range(1, 20)]


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be", "utf-16", "utf-8-sig"])
def test_utf_16_is_read_with_and_without_its_mark(encoding: str) -> None:
    text = "t [s],x [V]\n" + "\n".join(f"{k},{2 * k}" for k in range(1, 20))
    table = table_of(text.encode(encoding))
    assert (list(table.columns), table.units["x"]) == (["t", "x"], "V")


def test_a_python_without_eastern_tables_reads_the_numbers() -> None:
    class Bare(bytes):
        def decode(self, encoding: str = "utf-8", errors: str = "strict") -> str:
            if encoding in ("gb18030", "shift_jis"):
                raise LookupError(f"unknown encoding: {encoding}")
            return super().decode(encoding, errors)

    assert decode(Bare("time [s],Kraft [N] für\n0,1\n".encode("latin-1"))).endswith("für\n0,1\n")


def _in_blocks(blocks: list[int], gap: str = "\n") -> str:
    rows = iter(range(sum(blocks)))
    return "v [m/s],F [N]\n" + gap.join(
        "".join(
            f"{np.sin(row / 3):.4f},{np.cos(row / 5):.4f}\n"
            for _, row in zip(range(many), rows, strict=False)
        )
        for many in blocks
    )


@pytest.mark.parametrize("gap", ["\n", "\r\n \r\n", "# second test\n"])
def test_a_blank_line_between_rows_without_a_clock_begins_a_stretch(
    tmp_path: Path, gap: str
) -> None:
    (tmp_path / "a.csv").write_text(_in_blocks([30, 20], "\n" + gap), encoding="utf-8", newline="")
    log = read(tmp_path / "a.csv", rate="10 Hz")
    assert log.segments == ((0, 30), (30, 50))
    assert "a blank line stands above data row 31: a new stretch each time" in log.notes


@pytest.mark.parametrize("blocks", [[1] * 40, [5] * 8, [45, 3]])
def test_blank_lines_between_few_rows_are_spaces(tmp_path: Path, blocks: list[int]) -> None:
    (tmp_path / "a.csv").write_text(_in_blocks(blocks), encoding="utf-8")
    assert len(read(tmp_path / "a.csv", rate="10 Hz").segments) == 1


@pytest.mark.parametrize(
    "line", ["Radius, Type, Rate, Load,\nDisc B,Rotary,100,3,", "Disc B,Rotary,100,3,"]
)
def test_settings_with_numbers_above_the_names_are_no_row(tmp_path: Path, line: str) -> None:
    rows = "".join(
        f"{row / 10:.1f},{np.sin(row / 3):.4f},{np.cos(row / 5):.4f},4,\n" for row in range(30)
    )
    (tmp_path / "a.csv").write_text(
        f"{line}\ntime [s],v [m/s],F [N],step,\n{rows}", encoding="utf-8"
    )
    table = read_table(tmp_path / "a.csv")
    assert (table.rows, [*table.columns]) == (30, ["time", "v", "F", "step"])


@pytest.mark.parametrize(
    ("head", "between", "end"),
    [
        ("%t,i,v,F\n%[s],[A],[rad/s],[N]\n", ",", ";"),
        ("t,i,v,F\n", ",", ";  "),
        ("t\ti\tv\tF\n", "\t", ";"),
    ],
)
def test_a_semicolon_at_the_end_of_each_row_is_no_cell(
    tmp_path: Path, head: str, between: str, end: str
) -> None:
    rows = [[f"{k / 100:.2f}", f"{k % 3}.5", f"-{k}.25", f"{2 * k}.125"] for k in range(40)]
    path = tmp_path / "log.csv"
    path.write_text(
        head + "\r\n".join(between.join(row) + end for row in rows) + "\r\n", encoding="utf-8"
    )
    table = read_table(path)
    assert {name: values[3] for name, values in table.columns.items()} == {
        "t": 0.03,
        "i": 0.5,
        "v": -3.25,
        "F": 6.125,
    }


@pytest.mark.parametrize("above", ["t,i,F\n", "%t,i,F\n%[s],[A],[N]\n", "t,i,F\ns,A,N\n"])
def test_a_first_row_without_a_number_is_a_row_and_no_names(tmp_path: Path, above: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text(
        above + "nan,NaN,nan\n" + "".join(f"{k / 100},{k % 3},{k}\n" for k in range(40)),
        encoding="utf-8",
    )
    table = read_table(path)
    assert [*table.columns] == ["t", "i", "F"]
    assert table.rows == 41


def test_semicolons_between_cells_and_decimal_commas_stay(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t;F;\n" + "".join(f"0,{k:02d};{k},5;\n" for k in range(40)), encoding="utf-8")
    table = read_table(path)
    assert [table.columns[name][3] for name in ("t", "F")] == [0.03, 3.5]


def test_a_line_of_too_few_names_is_told(tmp_path: Path) -> None:
    rows = "".join(f"{row / 10},{row % 3}.5,{row}.25,0.0,1.5\n" for row in range(30))
    path = tmp_path / "log.csv"
    path.write_text("time,hip,knee\n" + rows)
    table = read_table(path)
    assert list(table.columns) == ["c1", "c2", "c3", "c4", "c5"]
    assert (
        "the line above the rows names 3 columns, the rows have 5 cells: the columns are called c1 .. c5"
        in table.notes
    )


@pytest.mark.slow
@pytest.mark.parametrize("between", ["/", "-", "_", "T", " "])
def test_a_date_and_a_time_of_day_may_have_any_sign_between_them(
    tmp_path: Path, between: str
) -> None:
    stamps = "".join(f"2023/09/04{between}16:29:{k / 100 + 10:.2f},{k % 7}\n" for k in range(60))
    path = tmp_path / "dated.csv"
    path.write_text("stamp,force [N]\n" + stamps, encoding="utf-8")
    table = read_table(path)
    assert table.clock is not None
    np.testing.assert_allclose(table.clock, np.arange(60) / 100, atol=1e-9)

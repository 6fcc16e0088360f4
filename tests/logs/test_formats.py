"""Logs of each format, written by the usual library of the format (LVM and OpenDocument by hand), read as numbers.

`studies/formats.py` damages the same files 10,000 times.
"""

from __future__ import annotations

import datetime
import gc
import json
import sqlite3
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import ErclutchError, LogError, MappingError
from erclutch.logs import ColumnMap, Table, log_reader, read, read_all, read_table, recordings_in
from erclutch.logs.readers import reader_in_child
from tests.support.command import good
from tests.support.log_formats import FORMATS, choices, mutated, small_log

ROOT = Path(__file__).parents[2]
UNITS = ("--field", "field [V]", "--slip", "slip [rad/s]", "--effort", "effort [N*m]")
LVM = """LabVIEW Measurement\t
Separator\tTab
Decimal_Separator\t{mark}
X_Columns\t{x}
***End_of_Header***\t
\t
"""


COLUMNS = small_log()
# Libraries of text formats are in this package: their files are read at once.
AT_ONCE = ("lvm", "jsonl", "mcap", "csv", "white space", "daq", "csv gz")
#: Their libraries are written in Python, so damage ends in an exception. Native code is left to a child, which it may
#: kill; that costs a start of Python and a second of imports for each file.
IN_PYTHON = ("mdf", "tdms", "bag")
every = pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=() if n in AT_ONCE else pytest.mark.slow) for n in FORMATS],
)


def written(folder: Path, name: str) -> Path:
    _, file, write = FORMATS[name]
    write(folder / file, COLUMNS)
    return folder / file


def refused(path: Path, variable: str | None = None) -> str:
    with pytest.raises(LogError) as caught:
        read_table(path, variable=variable)
    return str(caught.value)


@every
def test_a_log_of_each_format_has_the_numbers_that_were_written(tmp_path: Path, name: str) -> None:
    recording = read(written(tmp_path, name), choices(name))
    for signal in ("field", "slip", "effort"):
        np.testing.assert_array_equal(recording.signals[signal], COLUMNS[signal][1])
    np.testing.assert_allclose(recording.time, COLUMNS["time"][1], rtol=0, atol=1e-15)
    if not name.startswith("bag"):  # messages have no units
        assert recording.units == {
            name: unit for name, (unit, _) in COLUMNS.items() if name != "time"
        }


def fitted(path: Path) -> list[Any]:
    """Parameters and scores as `erclutch fit` prints them; 0.001 * n and n / 1000 differ, so the band may by a bit."""
    # The effort as it is opposes the slip, and a fit with its sign turned would search for memory.
    turned = (*UNITS[:-1], f"-{UNITS[-1]}")
    said = good("fit", path, *turned, "--models", "bingham", "fnn-2", "--lag", "none", "--json")
    return [
        (each["name"], each["fit"]["parameters"], each["train"], each["test"])
        for each in json.loads(said)["ranking"]
    ]


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_fit_gives_the_same_numbers_for_each_format_as_for_csv(tmp_path: Path) -> None:
    header = ",".join(f"{name} [{unit}]" for name, (unit, _) in COLUMNS.items())
    rows = zip(*(values.tolist() for _, values in COLUMNS.values()), strict=True)
    lines = [header, *(",".join(map(repr, row)) for row in rows)]
    (tmp_path / "log.csv").write_text("\n".join(lines), encoding="utf-8")
    wanted = fitted(tmp_path / "log.csv")
    assert len(wanted) == 2
    for name in ("mdf", "tdms", "xlsx", "ods", "hdf5", "bag sqlite", "lvm", "jsonl"):
        assert fitted(written(tmp_path, name)) == wanted, name


@pytest.mark.slow
@every
@pytest.mark.filterwarnings(
    "ignore::pytest.PytestUnraisableExceptionWarning"
)  # asammdf leaves a damaged file open
def test_a_damaged_file_gives_a_table_or_an_error_of_ours(
    tmp_path: Path, name: str, request: pytest.FixtureRequest
) -> None:
    if name.startswith(IN_PYTHON):
        request.getfixturevalue("read_here")
    log = written(tmp_path, name)
    part = log if log.is_file() else next(path for path in log.iterdir() if path.suffix != ".yaml")
    data = part.read_bytes()
    for number in range(30 if name in ("lvm", "jsonl") else 5):
        part.write_bytes(mutated(data, (77, number)))
        with suppress(ErclutchError):
            assert isinstance(read_table(log), Table)
    gc.collect()  # what the file left open is closed here, not in the next test


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("name", ["mdf", "tdms", "hdf5"])
def test_several_groups_need_a_choice(tmp_path: Path, name: str) -> None:
    from asammdf import MDF, Signal

    slow = np.arange(50) / 100
    path = tmp_path / FORMATS[name][1]
    if name == "mdf":
        time, effort = COLUMNS["time"][1], COLUMNS["effort"][1]
        with MDF() as file:
            file.append([Signal(effort, time, name="effort", unit="N*m")], comment="fast")
            file.append([Signal(2 * effort, time, name="effort", unit="N*m")], comment="same time")
            file.append([Signal(slow, slow, name="heat", unit="K")], comment="slow")
            file.save(path)
        fast, last = "fast", "slow"
        assert list(read_table(path, variable="fast").columns) == [
            "time",
            "effort",
            "effort (same time)",
        ]
    elif name == "tdms":
        from nptdms import ChannelObject, TdmsWriter

        with TdmsWriter(path) as file:
            for group in ("fast", "slow"):
                file.write_segment([ChannelObject(group, "heat", slow, {"wf_increment": 0.01})])
        fast, last = "fast", "slow"
    else:
        import h5py

        with h5py.File(path, "w") as file:
            file["fast/heat"], file["slow/heat"] = slow, slow
            file["slow/table"] = np.array(
                list(zip(slow, slow, strict=True)), dtype=[("a", "f8"), ("b", "f8")]
            )
            file["out"] = h5py.ExternalLink("secret.h5", "/")
        fast, last = "fast", "slow"
        assert list(read_table(path, variable="slow/table").columns) == ["a", "b"]
    assert "the file holds several recordings: fast, slow" in refused(path)
    assert f"Choose one, such as --variable {fast}" in refused(path)
    assert "there is no group 'none' of numbers (there are: fast, slow" in refused(path, "none")
    np.testing.assert_array_equal(read_table(path, variable=last).columns["heat"], slow)


@pytest.mark.usefixtures("read_here")
def test_a_unit_whose_attribute_in_an_hdf5_file_lost_its_name_is_told(tmp_path: Path) -> None:
    """The name of an attribute has no checksum: one wrong letter, and the unit was gone in silence."""
    import h5py

    time = np.arange(2000) * 1e-3
    with h5py.File(tmp_path / "log.h5", "w") as file:
        for name, unit, attribute in (
            ("time", "s", "unit"),
            ("slip", "rad/s", "unkt"),
            ("torque", "N*m", "unit"),
        ):
            data = file.create_dataset(name, data=time + 1.0, chunks=(500,), fletcher32=True)
            data.attrs[attribute] = unit
            data.attrs["gain"] = "2"
            data.attrs["sensor"] = "left"
    table = read_table(tmp_path / "log.h5")
    assert table.units == {"time": "s", "slip": None, "torque": "N*m"}
    told = [note for note in table.notes if "attribute" in note]
    assert told == [
        "slip: its attribute 'unkt' holds 'rad/s', and is not called unit: the column has no unit"
    ]


@pytest.mark.slow
@pytest.mark.parametrize(("file", "chunks"), [("a.h5", None), ("a.h5", (40,)), ("a.mat", (40,))])
def test_rows_that_are_not_in_an_hdf5_file_are_no_zeros(
    tmp_path: Path, file: str, chunks: tuple[int] | None
) -> None:
    """The library reads the fill value where a chunk was never written, or damage has lost its place."""
    import h5py

    path = tmp_path / file
    with h5py.File(path, "w", userblock_size=512 if file == "a.mat" else 0) as made:
        made["t"] = np.arange(100.0)
        made.create_dataset("F", (100,), "f8", chunks=chunks)
        if chunks:
            made["F"][:40] = 1.0
        made.create_dataset("missing", (100,), "f8", chunks=(40,), fillvalue=np.nan)[:40] = 1.0
    if file == "a.mat":
        with path.open("r+b") as out:
            out.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    assert "rows of the data set /F are not in the file: they would be read as 0.0" in refused(path)
    with h5py.File(path, "r+") as made:
        made["F"][:] = 1.0
    assert np.isnan(read_table(path).columns["missing"]).sum() == 60


@pytest.mark.usefixtures("read_here")
def test_zeros_whose_checksum_is_zero_too_are_told(tmp_path: Path) -> None:
    """The checksum of zeros is zero: damage that sets a part and its checksum to zero passed in silence."""
    import h5py

    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as made:
        made.create_dataset("time", data=1e-3 * np.arange(1, 101), chunks=(50,), fletcher32=True)
        made.create_dataset("F", data=np.linspace(1.0, 2.0, 100), chunks=(50,), fletcher32=True)
        made.create_dataset(
            "packed", data=np.zeros(100), chunks=(50,), fletcher32=True, compression="gzip"
        )
        chunks: list[Any] = []
        made["F"].id.chunk_iter(chunks.append)
    assert "zeros alone" not in " ".join(read_table(path).notes)
    with path.open("r+b") as damaged:
        damaged.seek(chunks[1].byte_offset)
        damaged.write(bytes(chunks[1].size))
    table = read_table(path)
    assert not table.columns["F"][50:].any()
    assert (
        "F: 1 of 2 stored parts are zeros alone: no checksum tells if a damage made them so"
        in table.notes
    )


@pytest.mark.slow
def test_what_tdms_does_not_hold_is_said(tmp_path: Path) -> None:
    from nptdms import ChannelObject, TdmsWriter

    path = tmp_path / "a.tdms"
    with TdmsWriter(path) as file:
        for second in (0, 5):
            start = np.datetime64("2026-01-31T12:00:00") + np.timedelta64(second, "s")
            more = {"wf_increment": 1e-3, "wf_start_time": start}
            file.write_segment([ChannelObject("run", name, np.arange(20.0), more) for name in "ab"])
    assert any(
        note.startswith("the acquisition was started anew") for note in read_table(path).notes
    )
    path.write_bytes(path.read_bytes()[:-200])
    assert any(
        note.startswith("the last segment was not written completely")
        for note in read_table(path).notes
    )


@pytest.mark.slow
def test_a_sheet_with_a_title_dates_and_gaps(tmp_path: Path) -> None:
    from openpyxl import Workbook

    book = Workbook()
    sheet: Any = book.active
    other = book.create_sheet("Notes")
    other.append(["nothing but text"])
    sheet.title = "Run 1"
    sheet["B1"], sheet["B2"] = "Bench", "# 3"
    for column, cell in enumerate(["when", "F [N]", "remark"], start=2):
        sheet.cell(4, column, cell)
    for row in range(20):
        sheet.cell(
            5 + row,
            2,
            datetime.datetime(2026, 1, 31, 12) + datetime.timedelta(milliseconds=10 * row),
        )
        sheet.cell(5 + row, 3, row / 3 if row != 7 else None)
    path = tmp_path / "a.xlsx"
    book.save(path)
    table = read_table(path)
    assert table.labels == ("F [N]",)
    assert table.clock is not None
    np.testing.assert_allclose(table.clock, np.arange(20) / 100, atol=1e-9)
    third = [row / 3 if row != 7 else np.nan for row in range(20)]
    np.testing.assert_allclose(table.columns["F"], third, rtol=1e-15)  # openpyxl writes 16 digits
    assert "the dates of column when are read to 1 ms" in table.notes
    assert "recording read from sheet Run 1" in table.notes
    sheet.cell(10, 3, "stalled")
    book.save(path)
    assert "sheet Run 1: line 10, column F is 'stalled' where a number is expected" in refused(path)


@pytest.mark.slow
def test_a_sheet_that_is_not_there_is_told_with_all_that_are(tmp_path: Path) -> None:
    """Only the first of them was named."""
    from openpyxl import Workbook

    book = Workbook()
    first: Any = book.active
    first.title = "Test A"
    for sheet in (first, book.create_sheet("Test B")):
        sheet.append(["time [s]", "F [N]"])
        for row in range(20):
            sheet.append([row / 100, row / 3])
    path = tmp_path / "a.xlsx"
    book.save(path)
    with pytest.raises(
        LogError, match=r"no sheet 'Test C' of numbers \(there are: Test A, Test B\)"
    ):
        read_table(path, variable="Test C")


@pytest.mark.slow
def test_a_bag_is_one_log_in_a_folder_and_its_names_are_no_program(tmp_path: Path) -> None:
    bag = written(tmp_path, "bag sqlite")
    inside = read_table(bag / "bag1.db3")
    assert (
        inside.labels == read_table(bag).labels == ("header.stamp [s]", "field", "slip", "effort")
    )
    said = good("inspect", bag, *UNITS)
    assert "recording read from topic /rig" in said
    assert "damage to the file is not seen in the numbers" in said
    assert fitted(tmp_path)  # the folder above holds one log: the bag
    with sqlite3.connect(bag / "bag1.db3") as file:
        file.execute(
            "update topics set type = ?",
            (f"a/msg/B:\n    open({str(tmp_path / 'made')!r}, 'w')\nclass C",),
        )
    file.close()
    assert refused(bag / "bag1.db3")
    assert not (tmp_path / "made").exists()


@pytest.mark.slow
def test_segments_of_an_lvm_file(tmp_path: Path) -> None:
    rows = "X_Value\tF\tX_Value\tG\tComment\n{0}\t1,5\t{0}\t2\t\n{1}\t2,5\t{1}\t3\t\n"
    segment = "Channels\t2\nSamples\t{n}\t{n}\nY_Unit_Label\tN\tV\n***End_of_Header***\t\n" + rows
    head, path = LVM.format(mark=",", x="Multi"), tmp_path / "a.lvm"
    path.write_text(
        head + segment.format("0,0", "0,1", n=2) + segment.format("0,2", "0,3", n=3),
        encoding="utf-8",
    )
    table = read_table(path)
    assert table.labels == ("time [s]", "F [N]", "G [V]")
    np.testing.assert_array_equal(table.columns["time"], [0.0, 0.1, 0.2, 0.3])
    assert "2 segments are joined: their time goes on" in table.notes
    path.write_text(head + segment.format("0,0", "0,1", n=2) * 2, encoding="utf-8")
    assert "several recordings: segment 1, segment 2" in refused(path)
    assert read_table(path, variable="segment 2").rows == 2
    path.write_text(head + segment.format("0,0", "0,1", n=3), encoding="utf-8")
    assert "a segment has 2 rows of 3" in read_table(path).notes


def test_an_lvm_file_without_times(tmp_path: Path) -> None:
    path = tmp_path / "a.lvm"
    body = "X0\t1.0E+0\nDelta_X\t0.5\n***End_of_Header***\nX_Value\tF [N]\tComment\n\t1\t\n\t2\t\n\t3\t\n"
    path.write_text(LVM.format(mark=".", x="No") + "Channels\t1\n" + body, encoding="utf-8")
    np.testing.assert_array_equal(read_table(path).columns["time"], [1.0, 1.5, 2.0])
    for whole, damaged, named in (
        ("X0\t1.0E+0", "X0", "X0 is ''"),
        ("Delta_X\t0.5", "Delta_X\t?", "Delta_X is '?'"),
    ):
        text = (
            LVM.format(mark=".", x="No") + "Channels\t1\nSamples\n" + body.replace(whole, damaged)
        )
        path.write_text(text, encoding="utf-8")
        assert named in refused(path)


def test_a_row_of_json_without_a_name_is_said(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    path.write_text('{"F": 1, "x": 2}\n{"F": 1, "y": 2}\n', encoding="utf-8")
    assert "2 of 2 rows lack a name, such as row 1: read as missing" in read_table(path).notes


@pytest.mark.parametrize(
    "line", ["{", "[1]", '{"F": "x"}', '{"F": true}', '{"F": 1' + "0" * 400 + "}", "{" * 10**5]
)
def test_a_wrong_line_of_json_is_named(tmp_path: Path, line: str) -> None:
    path = tmp_path / "a.jsonl"
    path.write_text('{"F": 1}\n' + line, encoding="utf-8")
    assert "line 2" in refused(path)


ROW = {"t [s]": 0.0, "motor": {"speed [rad/s]": 1.0, "on": True}, "torque [N*m]": 2.0, "who": "me"}
ROWS_OF_JSON = [ROW | {"t [s]": k / 100} for k in range(20)]


@pytest.mark.parametrize(
    "content",
    [
        ROWS_OF_JSON,
        {"rig": "a", "data": ROWS_OF_JSON},
        {"about": {"rig": {"rows": ROWS_OF_JSON}}, "seconds": 3},
        {
            "t [s]": [k / 100 for k in range(20)],
            "motor": {"speed [rad/s]": [1.0] * 20, "on": [True] * 20},
            "torque [N*m]": [2.0] * 20,
            "who": ["me"] * 20,
        },
    ],
)
@pytest.mark.parametrize("indent", [None, 1])
def test_json_is_rows_or_lists_nested_or_not(
    tmp_path: Path, content: Any, indent: int | None
) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps(content, indent=indent), encoding="utf-8")
    table = read_table(path)
    assert table.labels == ("t [s]", "speed [rad/s]", "on", "torque [N*m]")
    np.testing.assert_array_equal(table.columns["on"], np.ones(20))
    np.testing.assert_allclose(table.columns["t"], np.arange(20) / 100)
    assert list(table.unreadable) == ["who"]


def test_several_lists_of_json_are_several_recordings(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"run1": ROWS_OF_JSON, "run2": ROWS_OF_JSON[:12]}), encoding="utf-8")
    assert "several recordings: run1, run2. Choose one, such as --variable run1" in refused(path)
    assert recordings_in(path) == ["run1", "run2"]
    assert read_table(path, variable="run2").rows == 12


@pytest.mark.slow
def test_a_list_of_settings_beside_lists_of_rows_blocks_none_of_them(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    settings = [{"k": k, "gap": 1.0} for k in range(20)]
    path.write_text(
        json.dumps({"setup": settings, "run1": ROWS_OF_JSON, "run2": ROWS_OF_JSON}),
        encoding="utf-8",
    )
    logs = read_all(path, ColumnMap.from_labels({"field": "on"}))
    assert [log.name for log in logs] == ["a.json: run1", "a.json: run2"]
    assert "setup left out: no columns of a motion and an effort in there" in logs[0].notes
    path.write_text(json.dumps({"setup": settings, "more": settings}), encoding="utf-8")
    with pytest.raises(MappingError, match="things are missing"):
        read_all(path, ColumnMap())


@pytest.mark.slow
def test_dates_of_json_are_a_clock_and_equal_ends_keep_their_whole_names(tmp_path: Path) -> None:
    path = tmp_path / "a.json"
    rows = [
        {"at": f"2026-03-01T10:00:{k:02d}.5Z", "a": {"w": k}, "b": {"w": None}} for k in range(20)
    ]
    path.write_text(json.dumps(rows), encoding="utf-8")
    table = read_table(path)
    assert list(table.columns) == ["a.w", "b.w"]
    assert table.clock_name == "at"
    np.testing.assert_allclose(np.diff(table.clock), 1.0)  # type: ignore[arg-type]
    assert np.isnan(table.columns["b.w"]).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("data", "said"),
    [
        (
            b"TDSh\0\0",
            "the index of a TDMS log (.tdms_index), not text. Give the .tdms file beside it.",
        ),
        (
            b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1\0",
            "an old Office file without a table that can be read",
        ),
        (b"SQLite format 3\0", "a SQLite database"),
        (b"PK\x03\x04" + bytes(26) + b"a.csv\0", "a zip archive, not text. Unpack it"),
        (b"\x80\x04\x95\0\0", "a Python pickle, which may run programs and is never opened"),
        (b"ORC\0\1\2", "Apache ORC"),
        (
            b'<?xml version="1.0"?>\n<usi:tdm version="1.0">',
            "the header of a DIAdem log (.tdm), not a table",
        ),
        (
            b"date Sat Jan 31\nbase hex timestamps absolute\n 0.1 1 123 Rx d 1 00\n",
            "a Vector bus log (.asc)",
        ),
        (b"\0\1\2\3", "binary data, not text. Export it as CSV"),
    ],
)
def test_the_first_bytes_name_a_format(tmp_path: Path, data: bytes, said: str) -> None:
    path = tmp_path / "log.dat"
    path.write_bytes(data)
    assert said in refused(path)


def test_a_missing_library_is_named_with_its_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    nothing: Callable[[str], None] = lambda name: None  # noqa: E731
    monkeypatch.setattr(reader_in_child, "find_spec", nothing)
    (tmp_path / "a.tdms").write_bytes(b"TDSm" + bytes(100))
    assert refused(tmp_path / "a.tdms").endswith(
        'nptdms, which is not installed. Install it: pip install "erclutch[formats]".'
    )


def test_each_reader_says_whether_it_tells_damage(tmp_path: Path) -> None:
    own = [reader for plugin, reader in log_reader._readers([]) if plugin.own]
    assert len(own) >= 11
    assert all(reader.tells_damage.startswith(("seen", "not seen")) for reader in own)
    assert (
        read_table(written(tmp_path, "jsonl")).damage
        == "not seen: a text has no checksum (packed as .gz it has one)"
    )


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("kind", ["scan", "course"])
def test_a_topic_of_long_lists_beside_one_of_numbers_is_left_out(tmp_path: Path, kind: str) -> None:
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg("float64[] numbers\n", f"rig/msg/{kind}"))
    store.register(get_types_from_msg("float64 speed\nfloat64 torque\n", "rig/msg/Row"))
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        lists = bag.add_connection(f"/{kind}", f"rig/msg/{kind}", typestore=store)
        rows = bag.add_connection("/rig", "rig/msg/Row", typestore=store)
        message = store.types[f"rig/msg/{kind}"](np.zeros(2000))
        bag.write(lists, 0, store.serialize_cdr(message, f"rig/msg/{kind}"))
        for k in range(20):
            row = store.types["rig/msg/Row"](float(k), 2.0 * k)
            bag.write(rows, 10**7 * k, store.serialize_cdr(row, "rig/msg/Row"))
    table = read_table(tmp_path / "bag")
    assert table.columns["torque"].tolist() == [2.0 * k for k in range(20)]
    assert f"topic /{kind}: the field numbers has 2,000 numbers, above 500: left out" in table.notes
    with pytest.raises(
        LogError, match=f"topic /{kind}: the field numbers has 2,000 numbers, above 500"
    ):
        read_table(tmp_path / "bag", variable=f"/{kind}")


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_a_topic_whose_messages_nobody_defines_is_left_out(tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg("float64 distance\n", "rig/msg/Near"))
    with Writer(tmp_path / "bag", version=8, storage_plugin=StoragePlugin.SQLITE3) as bag:
        near = bag.add_connection("/near", "rig/msg/Near", typestore=store)
        torques = bag.add_connection("/torque", "std_msgs/msg/Float64", typestore=store)
        for k in range(20):
            for connection, kind in ((near, "rig/msg/Near"), (torques, "std_msgs/msg/Float64")):
                message = store.types[kind](2.0 * k)
                bag.write(connection, 10**7 * k, store.serialize_cdr(message, kind))
    (file,) = (tmp_path / "bag").glob("*.db3")
    with sqlite3.connect(file) as tables:  # as bags were before Iron
        tables.execute("DELETE FROM message_definitions")
    table = read_table(tmp_path / "bag")
    assert table.columns["data"].tolist() == [2.0 * k for k in range(20)]
    why = "topic /near: the bag does not define its messages, of type rig/msg/Near"
    assert f"{why}: left out" in table.notes
    with pytest.raises(LogError, match=why) as raised:
        read_table(tmp_path / "bag", variable="/near")
    assert "ROS 2 Iron or later" in raised.value.remedy

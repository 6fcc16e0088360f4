from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import ErclutchError, LogError
from erclutch.logs import read, read_table
from erclutch.logs.log_reader import LogSource
from erclutch.logs.log_writer import write_log
from erclutch.logs.readers.parquet import READER, parquet_windows, read_parquet
from tests.support.examples import examples


def whole() -> bytes:
    count = 50
    fields = [
        pa.field("t", pa.float64(), metadata={"unit": "ms"}),
        pa.field("field [V]", pa.float32()),
        pa.field("slip", pa.int32(), metadata={"unit": "rpm"}),
        pa.field("effort", pa.float64(), metadata={"unit": "Nm"}),
        pa.field("mode", pa.string()),
    ]
    columns = [
        np.arange(count) * 1.0,
        np.ones(count, np.float32),
        np.arange(count, dtype=np.int32),
        np.arange(count) / 7,
        ["on"] * count,
    ]
    schema = pa.schema(fields, metadata={"erclutch": '{"device": "single"}'})
    sink = io.BytesIO()
    pq.write_table(pa.table(columns, schema=schema), sink)
    return sink.getvalue()


@pytest.mark.usefixtures("read_here")
def test_units_and_settings_come_from_the_metadata(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    path.write_bytes(whole())
    table = read_table(path)
    assert table.labels == ("t [ms]", "field [V]", "slip [rpm]", "effort [Nm]", "mode")
    assert table.metadata == {"erclutch": '{"device": "single"}'}
    assert any(note.startswith("column mode holds ") for note in table.notes)
    recording = read(path)
    assert recording.period == pytest.approx(1e-3)
    assert recording.units == {"field": "V", "slip": "rad/s", "effort": "N*m"}
    assert np.array_equal(recording.signals["effort"], np.arange(50) / 7)


@pytest.mark.slow
def test_a_file_that_ends_the_process_ends_a_child_alone(tmp_path: Path) -> None:
    """Read whole, in windows, or asked for its extent: each is a line."""
    (tmp_path / "pyarrow").mkdir()
    (tmp_path / "pyarrow" / "__init__.py").write_text("import os; os.abort()")
    path = tmp_path / "log.parquet"
    path.write_bytes(whole())
    code = (
        "import sys, erclutch\nfrom erclutch.logs import extent_of, read_batches\n"
        "for ask in (erclutch.read, extent_of, lambda path: list(read_batches(path))):\n"
        "    try:\n        ask(sys.argv[1])\n"
        "    except erclutch.ErclutchError as error:\n        print(error)\n"
    )
    paths = os.pathsep.join([str(tmp_path), *sys.path])
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)],
        env={**os.environ, "PYTHONPATH": paths},
        capture_output=True,
        text=True,
    )
    assert done.stdout.count("log.parquet: the reader broke on this file (signal 6)") == 3, (
        done.stderr
    )


@pytest.mark.slow
def test_windows_of_a_child_are_those_of_the_process(tmp_path: Path) -> None:
    path, stamps = tmp_path / "log.parquet", pa.array(np.arange(900) * 2_000, pa.timestamp("us"))
    columns = {"when": stamps, "F": pa.array([None, *range(899)], pa.int64())}
    pq.write_table(pa.table(columns), path, row_group_size=250)
    source = LogSource(path, b"", "")
    assert READER.windows is not None
    assert READER.extent is not None
    there, here = (
        list(windows(source, 200, 10, 100, 800)) for windows in (READER.windows, parquet_windows)
    )
    assert (
        [each[:2] for each in there]
        == [each[:2] for each in here]
        == [(100, 300), (300, 500), (500, 800)]
    )
    for (_, _, one), (_, _, other) in zip(there, here, strict=True):
        assert (one.first_row, one.clock_name, one.notes) == (
            other.first_row,
            other.clock_name,
            other.notes,
        )
        np.testing.assert_array_equal(one.columns["F"], other.columns["F"])
        np.testing.assert_array_equal(one.clock, other.clock)
    assert READER.extent(path) == (900, 2)


def test_a_missing_number_of_a_slice_is_nan() -> None:
    sink = io.BytesIO()
    pq.write_table(
        pa.table({"a": pa.array([1, None, 3, None], pa.int32()), "b": pa.nulls(4, pa.float64())}),
        sink,
    )
    table = read_parquet(LogSource(Path("a.parquet"), sink.getvalue(), ""))
    assert str(table.columns["a"]) == "[ 1. nan  3. nan]"
    assert np.isnan(table.columns["b"]).all()


def test_date_columns_become_the_clock_and_missing_becomes_nan() -> None:
    stamps = pa.array(np.arange(20) * 2_000_000, pa.timestamp("us"))
    sink = io.BytesIO()
    pq.write_table(pa.table({"when": stamps, "F": pa.array([None, *range(19)], pa.int64())}), sink)
    table = read_parquet(LogSource(Path("a.parquet"), sink.getvalue(), ""))
    assert table.clock is not None
    assert np.array_equal(table.clock, np.arange(20) * 2.0)
    assert np.isnan(table.columns["F"][0])


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"PAR1" + bytes(100), "it is cut off"),
        (b"nothing of the kind", "it does not begin with PAR1"),
        (whole()[:8] + bytes(30) + whole()[-8:], "the Parquet data is damaged"),
    ],
)
def test_a_damaged_file_is_named(tmp_path: Path, data: bytes, problem: str) -> None:
    path = tmp_path / "log.parquet"
    path.write_bytes(data)
    with pytest.raises(LogError, match=problem):
        read_table(path)


@pytest.mark.slow
def test_a_small_file_that_unpacks_to_much_is_not_read_whole(tmp_path: Path) -> None:
    path, zeros = (
        tmp_path / "zeros.parquet",
        pa.table({name: np.zeros(2_000_000) for name in "tabc"}),
    )
    with pq.ParquetWriter(path, zeros.schema, compression="zstd") as writer:
        for _ in range(20):
            writer.write_table(zeros)
    with pytest.raises(
        LogError, match=r"unpacks to more than [\d,]+ numbers\. Give it to erclutch fit"
    ):
        read_table(path)
    assert next(parquet_windows(LogSource(path, b"", ""), 50_000, 10))[:2] == (0, 50_000)


@pytest.mark.slow
def test_ten_million_rows_of_a_constant_field_are_read(tmp_path: Path) -> None:
    path, zeros = (
        tmp_path / "constant.parquet",
        pa.table({name: np.zeros(1_000_000) for name in ("t", "field")}),
    )
    with pq.ParquetWriter(path, zeros.schema, compression="zstd") as writer:
        for _ in range(10):
            writer.write_table(zeros)
    assert read_table(path).rows == 10_000_000


def test_too_little_memory_is_no_damage(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr(pq.ParquetFile, "read", full)
    with pytest.raises(LogError, match="the columns need more memory than there is"):
        read_parquet(LogSource(Path("a.parquet"), whole(), ""))


@pytest.mark.slow
def test_a_damaged_description_of_the_columns_does_not_end_the_process(tmp_path: Path) -> None:
    """The library's own look at a column ended it, where the description said that the sizes of its levels differ."""
    data = whole()
    path = tmp_path / "log.parquet"
    described = int.from_bytes(data[-8:-4], "little")
    for place in range(len(data) - 8 - described, len(data) - 8):
        damaged = bytearray(data)
        damaged[place] = (damaged[place] + 1) % 256
        path.write_bytes(damaged)
        with suppress(ErclutchError):
            read_parquet(LogSource(path, bytes(damaged), ""))
        with suppress(ErclutchError):
            list(parquet_windows(LogSource(path, b"", ""), 20, 5))


@pytest.mark.parametrize("words", [("ON", "OFF"), ("ein", "aus"), ("True", "False")])
@pytest.mark.usefixtures("read_here")
def test_a_switch_in_words_is_a_column_of_ones_and_zeros(
    tmp_path: Path, words: tuple[str, str]
) -> None:
    path = tmp_path / "log.parquet"
    pq.write_table(pa.table({"w": np.arange(40) / 7, "coil": [*words] * 20}), path)
    table = read_table(path)
    np.testing.assert_array_equal(table.columns["coil"], [1.0, 0.0] * 20)
    (block,) = parquet_windows(LogSource(path, b"", ""), 100, 0)
    np.testing.assert_array_equal(block[2].columns["coil"], [1.0, 0.0] * 20)


@pytest.mark.usefixtures("read_here")
def test_words_of_materials_part_the_rows_as_in_a_text(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    pq.write_table(pa.table({"w": np.arange(40) / 7, "pad": ["steel"] * 20 + ["cork"] * 20}), path)
    assert read_table(path).words["pad"].words == ("steel", "cork")
    assert read_table(path, variable="pad=cork").rows == 20


def test_texts_that_are_left_out_are_told_in_the_order_of_the_columns() -> None:
    remarks = [f"remark {letter}" for letter in "hgfedcba"]
    columns = {"w": np.arange(40) / 7}
    texts = {name: [f"{name} {row}" for row in range(40)] for name in remarks}
    sink = io.BytesIO()
    pq.write_table(pa.table({**columns, **texts}), sink, write_page_checksum=True)
    notes = read_parquet(LogSource(Path("a.parquet"), sink.getvalue(), "")).notes
    assert notes == tuple(f"column {name} holds text: left out" for name in remarks)


def test_a_file_without_numbers() -> None:
    sink = io.BytesIO()
    pq.write_table(pa.table({"mode": ["slow", "fast"]}), sink)
    with pytest.raises(LogError, match="no column of numbers"):
        read_parquet(LogSource(Path("a.parquet"), sink.getvalue(), ""))


@pytest.mark.slow
@settings(max_examples=examples(150), deadline=None)
@given(st.lists(st.tuples(st.integers(0, 10_000), st.integers(0, 255)), min_size=1, max_size=6))
def test_a_mutated_file_gives_a_table_or_an_error_of_ours(changes: list[tuple[int, int]]) -> None:
    data = bytearray(whole())
    for place, byte in changes:
        data[4 + place % (len(data) - 8)] = byte
    with suppress(ErclutchError):
        assert read_parquet(LogSource(Path("a.parquet"), bytes(data), "")).columns


def damaged_in_silence(checksums: bool, flips: int = 150) -> int:
    """Of files with one bit turned, those that are read without an error and give other numbers."""
    rng = np.random.default_rng(0)
    sink = io.BytesIO()
    columns = {f"c{i}": rng.normal(size=200) for i in range(3)}
    pq.write_table(pa.table(columns), sink, write_page_checksum=checksums)
    data, wrong = sink.getvalue(), 0
    for _ in range(flips):
        turned = bytearray(data)
        turned[rng.integers(len(data))] ^= 1 << int(rng.integers(8))
        with suppress(LogError):
            found = read_parquet(LogSource(Path("a.parquet"), bytes(turned), "")).columns
            wrong += not all(
                np.array_equal(found.get(name, 0), values) for name, values in columns.items()
            )
    return wrong


@pytest.mark.slow
def test_checksums_are_checked_and_a_file_without_them_says_so() -> None:
    assert damaged_in_silence(checksums=True) == 0
    assert damaged_in_silence(checksums=False) > 50
    note = "the file has no checksums: damaged numbers in it cannot be told from good ones"
    for checksums in (True, False):
        sink = io.BytesIO()
        pq.write_table(
            pa.table({"a": [1.0, 2.0], "b": [1, 2]}), sink, write_page_checksum=checksums
        )
        assert (note in read_parquet(LogSource(Path("a.parquet"), sink.getvalue(), "")).notes) == (
            not checksums
        )


def test_own_logs_have_checksums_and_windows_say_whether_a_file_has(tmp_path: Path) -> None:
    own = write_log(
        tmp_path / "own.parquet", [("a", "s"), ("b", "")], [np.zeros((9, 2))], {}, rows=9
    )
    other = tmp_path / "other.parquet"
    pq.write_table(pa.table({"a": [1.0, 2.0]}), other)
    for path, has in ((own, True), (other, False)):
        notes = [
            note
            for _, _, table in parquet_windows(LogSource(path, b"", ""), 5, 1)
            for note in table.notes
        ]
        assert any("no checksums" in note for note in notes) == (not has)


@pytest.mark.slow
def test_writing_a_log_does_not_wait_for_pandas(tmp_path: Path) -> None:
    """Its import takes a sixth of the time of `simulate training`; `pa.array` would ask for it."""
    code = (
        "import sys, numpy as np\n"
        "from erclutch.logs.log_writer import write_log\n"
        "rows = np.array([[0.0, np.nan], [1.0, -0.0], [2.0, np.inf]])\n"
        "write_log(sys.argv[1], (('time', 's'), ('slip', 'rad/s')), [rows], {}, rows=3)\n"
        "assert 'pandas' not in sys.modules\n"
    )
    path = tmp_path / "a.parquet"
    subprocess.run([sys.executable, "-c", code, str(path)], check=True)
    with path.open("rb") as file:
        slip = pq.read_table(file)["slip"].to_numpy()
    assert np.isnan(slip[0])
    assert str(slip[1:]) == "[-0. inf]"


def test_damage_is_told_in_one_line() -> None:
    data = bytearray(whole())
    data[-60:-20] = b"\xff" * 40
    with pytest.raises(LogError) as caught:
        read_parquet(LogSource(Path("a.parquet"), bytes(data), ""))
    assert str(caught.value).isprintable()


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("by_pandas", [False, True])
def test_units_of_all_columns_may_stand_in_one_text_of_the_file(
    tmp_path: Path, by_pandas: bool
) -> None:
    units = {"t": "s", "speed": "rpm", "gain": None}
    said = {"attributes": {"units": units}} if by_pandas else units
    table = pa.table({name: np.arange(50.0) for name in ("t", "speed", "gain", "torque")})
    key = "pandas" if by_pandas else "units"
    pq.write_table(table.replace_schema_metadata({key: json.dumps(said)}), tmp_path / "a.parquet")
    wanted = {"t": "s", "speed": "rpm", "gain": None, "torque": None}
    assert read_table(tmp_path / "a.parquet").units == wanted


@pytest.mark.usefixtures("read_here")
@pytest.mark.parametrize("said", ["[1]", "{", '{"speed": 3}', '"rpm"'])
def test_a_text_that_gives_no_units_gives_none(tmp_path: Path, said: str) -> None:
    table = pa.table({"t": np.arange(50.0), "speed": np.arange(50.0)})
    pq.write_table(table.replace_schema_metadata({"units": said}), tmp_path / "a.parquet")
    assert read_table(tmp_path / "a.parquet").units["speed"] is None

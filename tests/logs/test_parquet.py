from __future__ import annotations

import io
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
from erclutch.logs.readers.parquet import read_parquet


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


def test_units_and_settings_come_from_the_metadata(tmp_path: Path) -> None:
    path = tmp_path / "log.parquet"
    path.write_bytes(whole())
    table = read_table(path)
    assert table.labels == ("t [ms]", "field [V]", "slip [rpm]", "effort [Nm]")
    assert table.metadata == {"erclutch": '{"device": "single"}'}
    assert "column mode holds string: left out" in table.notes
    recording = read(path)
    assert recording.period == pytest.approx(1e-3)
    assert recording.units == {"field": "V", "slip": "rad/s", "effort": "N*m"}
    assert np.array_equal(recording.signals["effort"], np.arange(50) / 7)


def test_date_columns_become_the_clock_and_missing_becomes_nan() -> None:
    stamps = pa.array(np.arange(20) * 2_000_000, pa.timestamp("us"))
    sink = io.BytesIO()
    pq.write_table(pa.table({"when": stamps, "F": pa.array([None, *range(19)], pa.int64())}), sink)
    table = read_parquet(LogSource(Path("a.parquet"), sink.getvalue(), ""))
    assert table.clock is not None
    assert np.array_equal(table.clock, np.arange(20) * 2.0)
    assert np.isnan(table.columns["F"][0])


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


def test_a_file_without_numbers() -> None:
    sink = io.BytesIO()
    pq.write_table(pa.table({"mode": ["on", "off"]}), sink)
    with pytest.raises(LogError, match="no column of numbers"):
        read_parquet(LogSource(Path("a.parquet"), sink.getvalue(), ""))


@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(st.integers(0, 10_000), st.integers(0, 255)), min_size=1, max_size=6))
def test_a_mutated_file_gives_a_table_or_an_error_of_ours(changes: list[tuple[int, int]]) -> None:
    data = bytearray(whole())
    for place, byte in changes:
        data[4 + place % (len(data) - 8)] = byte
    with suppress(ErclutchError):
        assert read_parquet(LogSource(Path("a.parquet"), bytes(data), "")).columns

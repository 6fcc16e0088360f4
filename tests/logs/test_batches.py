"""A log that is read stretch by stretch has the rows, the clock and the speeds of the log that is read whole."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from erclutch.errors import LogError, MappingError, SettingError, ShortLogError
from erclutch.logs import extent_of, read, read_batches
from erclutch.logs.batches import MARGIN, RowRange, blocks_of, chained, neighbours
from erclutch.logs.dataset import build_dataset
from erclutch.signals.speed import Derivative
from tests.support.slow_params import slow_but

pytestmark = pytest.mark.usefixtures("read_here")

N = 26_000


def columns(position: bool = False, gap: int | None = None) -> dict[str, np.ndarray]:
    t = np.arange(N) * 1e-3
    if gap:
        t[gap:] += 0.5
    slip = 3.0 * np.sin(7.0 * t)
    moved = {"position [rad]": -3.0 / 7.0 * np.cos(7.0 * t)} if position else {"slip [rad/s]": slip}
    return {
        "t [s]": np.round(t, 6),
        "field [V]": np.floor(t),
        **moved,
        "effort [N*m]": np.tanh(slip),
        "D": np.arange(N),
    }


def written(path: Path, of: dict[str, np.ndarray]) -> Path:
    pq.write_table(
        pa.table({name: np.asarray(values, np.float64) for name, values in of.items()}),
        path,
        row_group_size=7000,
    )
    return path


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(
        tmp_path_factory.mktemp("batches") / "log.parquet", columns(position=True, gap=13_001)
    )


@pytest.mark.slow
@pytest.mark.parametrize(("rows", "starts"), [(10_000, [0, 10_000]), (13_000, [0]), (40_000, [0])])
def test_all_rows_once_and_in_order(log: Path, rows: int, starts: list[int]) -> None:
    """The last rows, fewer than two batches and a margin, come together."""
    whole, at = read(log), 0
    assert [batch.start for batch in read_batches(log, rows=rows)] == starts
    for batch in read_batches(log, rows=rows):
        assert batch.start == at
        at = batch.stop
        assert batch.rows[0] == max(batch.start - MARGIN, 0)
        assert batch.rows[-1] == min(batch.stop + MARGIN, N) - 1
        np.testing.assert_array_equal(
            batch.recording.signals["effort"], whole.signals["effort"][batch.rows]
        )
        np.testing.assert_allclose(batch.recording.time, whole.time[batch.rows], atol=1e-9)
        assert batch.recording.period == whole.period
        assert batch.recording.digest == whole.digest
    assert at == N


@pytest.mark.slow
@pytest.mark.parametrize("name", ["savgol", "kalman"])
def test_speeds_run_over_the_edges(log: Path, name: Any) -> None:
    derivative = Derivative(name)
    whole = build_dataset([read(log)], derivative=derivative)
    blocks = list(blocks_of(read_batches(log, rows=10_000), "single", derivative))
    parts = [block.data for block in blocks]
    np.testing.assert_allclose(
        np.concatenate([part.elements[0].slip for part in parts]), whole.elements[0].slip, atol=1e-9
    )
    np.testing.assert_array_equal(np.concatenate([part.effort for part in parts]), whole.effort)
    assert [len(part.clock.spans) for part in parts] == [1, 2]
    assert [part.clock.joins for part in parts] == [False, True]
    assert all("\0row" not in part.extras for part in parts)
    np.testing.assert_array_equal(
        np.concatenate([block.file_rows for block in blocks]), np.arange(N)
    )
    together = chained(parts)
    assert together.clock.spans == whole.clock.spans
    assert together.source_rows == ((0, N),)


@pytest.mark.slow
def test_rows_cut_out_of_a_block_say_whether_they_go_on(log: Path) -> None:
    data = build_dataset([read(log)])  # the gap is before row 13,001
    assert [
        neighbours(data, at, at + 5).clock.joins for at in (0, 500, 13_000, 13_001, 13_002)
    ] == [*(False, True, True, False, True)]
    parts = [
        neighbours(data, a, b) for a, b in ((0, 500), (500, 13_001), (13_001, 13_002), (13_002, N))
    ]
    assert chained(parts).clock.spans == data.clock.spans
    with_past = chained(parts[1:])
    assert with_past.clock.joins
    assert [(span.start, span.stop) for span in with_past.clock.spans] == [
        (0, 12_501),
        (12_501, N - 500),
    ]


@pytest.mark.slow
def test_some_rows_of_a_file_are_read_as_in_the_whole_file(log: Path) -> None:
    derivative = Derivative()
    whole = build_dataset([read(log)], derivative=derivative)
    for first, stop in ((0, 13_001), (13_001, None), (13_001, 24_000), (11_000, 11_500)):
        part = RowRange(first, stop, whole.period)
        blocks = list(blocks_of(read_batches(log, rows=10_000, part=part), "single", derivative))
        rows = np.concatenate([block.file_rows for block in blocks])
        np.testing.assert_array_equal(rows, np.arange(first, N if stop is None else stop))
        slips = np.concatenate([block.data.elements[0].slip for block in blocks])
        np.testing.assert_allclose(slips, whole.elements[0].slip[rows], atol=1e-9)
        assert blocks[0].data.clock.joins == (first == 11_000)


@pytest.mark.slow
def test_a_filter_that_looks_further_back_than_a_margin(log: Path) -> None:
    blocks = blocks_of(read_batches(log, rows=10_000), "single", Derivative("lowpass", cutoff=0.05))
    assert next(blocks).data.rows == 10_000  # the first batch needs no rows before it
    with pytest.raises(
        SettingError, match=rf"lowpass at 0.05 Hz remembers more than {MARGIN} rows"
    ):
        next(blocks)


@pytest.mark.slow
def test_a_rate_counts_on_from_batch_to_batch(tmp_path: Path) -> None:
    path = written(
        tmp_path / "a.parquet",
        {name: values for name, values in columns().items() if name != "t [s]"},
    )
    for batch in read_batches(path, {"rate": 500.0}, rows=10_000):
        np.testing.assert_allclose(batch.recording.time, batch.rows / 500.0)


@pytest.mark.slow
def test_missing_values_are_named_with_their_rows_or_dropped(tmp_path: Path) -> None:
    of = columns()
    of["effort [N*m]"] = np.where(
        (np.arange(N) >= 15_000) & (np.arange(N) < 15_003), np.nan, of["effort [N*m]"]
    )
    path = written(tmp_path / "a.parquet", of)
    with pytest.raises(
        LogError,
        match=r"^a.parquet, data rows 10001 to 26000: column effort has 3 values .* data row 15001",
    ):
        list(read_batches(path, rows=10_000))
    kept = [
        b.rows[(b.rows >= b.start) & (b.rows < b.stop)]
        for b in read_batches(path, rows=10_000, invalid="drop")
    ]
    np.testing.assert_array_equal(
        np.concatenate(kept), np.delete(np.arange(N), np.s_[15_000:15_003])
    )


@pytest.mark.slow
def test_stretches_without_a_row_are_left_out_unless_all_are(tmp_path: Path) -> None:
    of = columns()
    of["effort [N*m]"] = np.where(np.arange(N) >= 9_000, np.nan, of["effort [N*m]"])
    path = written(tmp_path / "a.parquet", of)
    kept = [batch.rows for batch in read_batches(path, rows=10_000, invalid="drop")]
    assert max(rows.max() for rows in kept) == 8_999
    of["effort [N*m]"] = np.full(N, np.nan)
    with pytest.raises((ShortLogError, LogError)):
        list(read_batches(written(tmp_path / "b.parquet", of), rows=10_000, invalid="drop"))


def test_other_formats_come_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.jsonl"
    few = {name: values[:50].tolist() for name, values in columns().items()}
    path.write_text(
        "".join(
            json.dumps(dict(zip(few, row, strict=True))) + "\n"
            for row in zip(*few.values(), strict=True)
        )
    )
    (batch,) = read_batches(path)
    assert (batch.start, batch.stop, batch.rows.tolist()) == (0, 50, list(range(50)))
    np.testing.assert_array_equal(batch.recording.signals["effort"], read(path).signals["effort"])


def as_text(path: Path, of: dict[str, np.ndarray], above: str = "") -> Path:
    head = above + ",".join(of)
    np.savetxt(
        path, np.column_stack(list(of.values())), "%.9g", delimiter=",", header=head, comments=""
    )
    return path


@pytest.mark.slow
@pytest.mark.parametrize("name", slow_but(("a.csv",), ("a.csv", "a.csv.gz")))
def test_a_text_is_read_in_blocks_as_it_is_read_whole(tmp_path: Path, name: str) -> None:
    path = as_text(tmp_path / name, columns(gap=13_001), "Tester: nobody\n")
    whole = read(path)
    rows, columns_there = extent_of(path) or (0, 0)
    assert rows == pytest.approx(N, rel=0.1)  # by the length of the first lines
    assert columns_there == 5
    at = 0
    for batch in read_batches(path, rows=10_000):
        assert batch.start == at
        assert (batch.rows[0], batch.rows[-1]) == (
            max(at - MARGIN, 0),
            min(batch.stop + MARGIN, N) - 1,
        )
        np.testing.assert_array_equal(
            batch.recording.signals["slip"], whole.signals["slip"][batch.rows]
        )
        np.testing.assert_allclose(batch.recording.time, whole.time[batch.rows], atol=1e-9)
        at = batch.stop
    assert at == N
    for first, stop in ((13_001, None), (13_001, 24_000), (0, 13_001)):
        last = N if stop is None else stop
        batches = list(read_batches(path, rows=10_000, part=RowRange(first, stop)))
        assert (batches[0].start, batches[-1].stop) == (first, last)
        assert batches[0].rows[0] == max(first - MARGIN, 0)


@pytest.mark.slow
def test_comments_and_blank_lines_of_a_text_are_no_rows(tmp_path: Path) -> None:
    path = as_text(tmp_path / "a.csv", columns())
    lines = path.read_text().splitlines()
    lines[100:100] = ["# a remark", "", "   "]
    path.write_text("\n".join(lines))
    assert [batch.stop for batch in read_batches(path, rows=10_000)] == [10_000, N]


@pytest.mark.slow
def test_errors_in_a_later_block_of_a_text_name_its_rows(tmp_path: Path) -> None:
    path = as_text(tmp_path / "a.csv", columns())
    lines = path.read_text().splitlines()
    time, field, _, *others = lines[20_001].split(",")
    lines[20_001] = ",".join([time, field, "oops", *others])
    path.write_text("\n".join(lines))
    with pytest.raises(LogError, match=r"column slip has 1 value missing .* in data row 20001"):
        list(read_batches(path, rows=10_000))
    of = columns()
    of["effort [N*m]"][15_000] = np.nan
    with pytest.raises(LogError, match="data rows 10001 to 26000: column effort has 1 value"):
        list(read_batches(as_text(tmp_path / "b.csv", of), rows=10_000))


@pytest.mark.slow
def test_what_a_text_cannot_have_in_blocks(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    rows = [f"2026-01-01 00:00:{0.001 * k:09.6f},1,2,3" for k in range(20_000)]
    path.write_text("when,field [V],slip [rad/s],effort [N*m]\n" + "\n".join(rows))
    with pytest.raises(LogError, match=r"the time 'when' is no number, .* Write it as Parquet"):
        list(read_batches(path, rows=10_000))
    packed = as_text(tmp_path / "b.csv.gz", columns())
    packed.write_bytes(packed.read_bytes()[:-2000])
    with pytest.raises(LogError, match="the gzip data is damaged"):
        list(read_batches(packed, rows=10_000))


def test_what_batches_cannot_have(log: Path) -> None:
    with pytest.raises(SettingError, match="batches of 9999 rows"):
        next(read_batches(log, rows=9_999))
    with pytest.raises(SettingError, match="field has one number a segment"):
        next(read_batches(log, {"constants": {"mass": "1 kg", "field": "0, 1 A"}}, rows=10_000))
    with pytest.raises(MappingError):
        next(read_batches(log, {"slip": "nothing"}, rows=10_000))

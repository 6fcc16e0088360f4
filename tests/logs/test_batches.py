"""A log that is read stretch by stretch has the rows, the clock and the speeds of the log that is read whole."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from erclutch.errors import LogError, MappingError, SettingError, ShortLogError
from erclutch.logs import read, read_batches
from erclutch.logs.batches import MARGIN, datasets
from erclutch.logs.dataset import build_dataset
from erclutch.signals.speed import Derivative

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
        pa.table({name: np.asarray(values, np.float64) for name, values in of.items()}), path, row_group_size=7000
    )
    return path


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("batches") / "log.parquet", columns(position=True, gap=13_001))


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
        np.testing.assert_array_equal(batch.recording.signals["effort"], whole.signals["effort"][batch.rows])
        np.testing.assert_allclose(batch.recording.time, whole.time[batch.rows], atol=1e-9)
        assert batch.recording.period == whole.period
        assert batch.recording.digest == whole.digest
    assert at == N


@pytest.mark.parametrize("name", ["savgol", "kalman"])
def test_speeds_run_over_the_edges(log: Path, name: Any) -> None:
    derivative = Derivative(name)
    whole = build_dataset([read(log)], derivative=derivative)
    parts = [data for _, data in datasets(read_batches(log, rows=10_000), "single", derivative) if data is not None]
    np.testing.assert_allclose(
        np.concatenate([part.elements[0].slip for part in parts]), whole.elements[0].slip, atol=1e-9
    )
    np.testing.assert_array_equal(np.concatenate([part.effort for part in parts]), whole.effort)
    assert [len(part.clock.spans) for part in parts] == [1, 2]
    assert [part.clock.joins for part in parts] == [False, True]
    assert all("\0row" not in part.extras for part in parts)


def test_a_filter_that_looks_further_back_than_a_margin(log: Path) -> None:
    found = datasets(read_batches(log, rows=10_000), "single", Derivative("lowpass", cutoff=0.05))
    assert next(found)[1] is not None  # the first batch needs no rows before it
    with pytest.raises(SettingError, match=rf"lowpass at 0.05 Hz remembers more than {MARGIN} rows"):
        next(found)


def test_a_rate_counts_on_from_batch_to_batch(tmp_path: Path) -> None:
    path = written(tmp_path / "a.parquet", {name: values for name, values in columns().items() if name != "t [s]"})
    for batch in read_batches(path, {"rate": 500.0}, rows=10_000):
        np.testing.assert_allclose(batch.recording.time, batch.rows / 500.0)


def test_missing_values_are_named_with_their_rows_or_dropped(tmp_path: Path) -> None:
    of = columns()
    of["effort [N*m]"] = np.where((np.arange(N) >= 15_000) & (np.arange(N) < 15_003), np.nan, of["effort [N*m]"])
    path = written(tmp_path / "a.parquet", of)
    with pytest.raises(
        LogError, match=r"^a.parquet, data rows 10001 to 26000: column effort has 3 values .* data row 15001"
    ):
        list(read_batches(path, rows=10_000))
    kept = [b.rows[(b.rows >= b.start) & (b.rows < b.stop)] for b in read_batches(path, rows=10_000, invalid="drop")]
    np.testing.assert_array_equal(np.concatenate(kept), np.delete(np.arange(N), np.s_[15_000:15_003]))


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
    path = tmp_path / "a.csv"
    few = {name: values[:50] for name, values in columns().items()}
    np.savetxt(path, np.column_stack(list(few.values())), delimiter=",", header=",".join(few), comments="")
    (batch,) = read_batches(path)
    assert (batch.start, batch.stop, batch.rows.tolist()) == (0, 50, list(range(50)))
    np.testing.assert_array_equal(batch.recording.signals["effort"], read(path).signals["effort"])


def test_what_batches_cannot_have(log: Path) -> None:
    with pytest.raises(SettingError, match="batches of 9999 rows"):
        next(read_batches(log, rows=9_999))
    with pytest.raises(SettingError, match="field has one number a segment"):
        next(read_batches(log, {"constants": {"mass": "1 kg", "field": "0, 1 A"}}, rows=10_000))
    with pytest.raises(MappingError):
        next(read_batches(log, {"slip": "nothing"}, rows=10_000))

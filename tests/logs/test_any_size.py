"""Logs that fit into memory are read whole; of others whole stretches are kept, with their clock and their places."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from erclutch.errors import LogError, MappingError, SettingError, UnloggedFieldError
from erclutch.logs import any_size
from erclutch.logs.any_size import read_rows
from erclutch.logs.dataset import build_dataset
from erclutch.logs.reading import Reading
from erclutch.logs.stretch_choice import STRETCH

pytestmark = pytest.mark.usefixtures("read_here")

N = 60_000


def log_columns(rows: int = N, seed: int = 0, position: bool = True) -> dict[str, np.ndarray]:
    """A log with a gap after each 25,000 rows and a rest, and a number that counts the rows as effort."""
    t = np.arange(rows) * 1e-3 + (np.arange(rows) // 25_000)
    moved = (
        {"position [rad]": np.sin(7.0 * t + seed)}
        if position
        else {"slip [rad/s]": 7.0 * np.cos(7.0 * t + seed)}
    )
    return {
        "t [s]": np.round(t, 6),
        "field [V]": np.floor(t),
        **moved,
        "effort [N*m]": np.arange(float(rows)) + seed,
    }


def written(path: Path, of: dict[str, np.ndarray]) -> Path:
    pq.write_table(pa.table(of), path, row_group_size=20_000)
    return path


@pytest.fixture(autouse=True)
def _little_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """A fit needs nothing but its rows here, and a task has few."""
    monkeypatch.setattr(any_size, "_WITHOUT_ROWS", 0)
    monkeypatch.setattr(any_size, "_TASK", 20_000)


def memory_for(rows: int, columns: int = 4) -> float:
    return any_size._FOR_EACH_BYTE * 8.0 * columns * rows + 1.0  # pyright: ignore[reportPrivateUsage]


@pytest.mark.slow
def test_logs_that_fit_are_the_data_set_of_all_rows(tmp_path: Path) -> None:
    paths = [written(tmp_path / f"{seed}.parquet", log_columns(seed=seed)) for seed in (1, 2)]
    how = Reading()
    rows = read_rows(paths, how, memory=memory_for(2 * N))
    whole = build_dataset([log for path in paths for log in how.read(path, "single")])
    assert rows.left_out == 0
    assert rows.in_blocks == ()
    assert rows.data.clock.spans == whole.clock.spans
    np.testing.assert_array_equal(rows.data.elements[0].slip, whole.elements[0].slip)
    assert [log.name for log in rows.logs] == ["1.parquet", "2.parquet"]


@pytest.mark.slow
def test_kept_stretches_are_rows_of_the_whole_log(tmp_path: Path) -> None:
    """Speeds at their edges too: they are differentiated before anything is cut."""
    paths = [written(tmp_path / f"{seed}.parquet", log_columns(seed=seed)) for seed in (1, 2)]
    how = Reading()
    seen: list[tuple[str, int, int]] = []
    show = lambda what, rows, total: seen.append((what, rows, total))  # noqa: E731
    rows = read_rows(paths, how, memory=memory_for(N), progress=show)
    whole = build_dataset([log for path in paths for log in how.read(path, "single")])
    data = rows.data
    assert 0.6 * N <= data.rows <= N + STRETCH
    assert rows.left_out == 2 * N - data.rows
    starts = [start for start, _ in whole.source_rows]
    at = np.concatenate(
        [k + rows.places[slice(*own)] for k, own in zip(starts, data.source_rows, strict=True)]
    )
    np.testing.assert_array_equal(data.effort, whole.effort[at])
    np.testing.assert_allclose(data.elements[0].slip, whole.elements[0].slip[at], atol=1e-9)
    np.testing.assert_allclose(data.clock.time, whole.clock.time[at])
    for span in data.clock.spans:
        assert np.all(np.diff(at[span.start : span.stop]) == 1)
        assert span.period == pytest.approx(1e-3)
        assert np.ptp(data.clock.time[span.start : span.stop]) < 25.0  # no gap inside
    assert data.sources == ("1.parquet", "2.parquet")
    assert "rows are fitted, in whole stretches" in data.notes[-1]
    assert seen[-1] == ("reading 2.parquet", 2 * N, 2 * N)


@pytest.mark.slow
def test_what_is_said_of_a_log_in_blocks_is_what_its_recording_says(tmp_path: Path) -> None:
    path = written(tmp_path / "a.parquet", log_columns())
    (recording,) = Reading().read(path, "single")
    (log,) = read_rows([path], Reading(), memory=memory_for(20_000)).logs
    for name in ("name", "digest", "origin", "mapping", "rows", "segments", "uniform"):
        assert getattr(log, name) == getattr(recording, name), name
    assert log.period == pytest.approx(recording.period)
    assert log.duration == pytest.approx(recording.duration, rel=1e-3)


@pytest.mark.slow
def test_tasks_begin_behind_gaps(tmp_path: Path) -> None:
    path = written(tmp_path / "a.parquet", log_columns())
    (log,) = read_rows([path], Reading(), memory=memory_for(20_000)).in_blocks
    assert [(cut.file_row, cut.place) for cut in log.cuts] == [
        (0, 0),
        (25_000, 25_000),
        (50_000, 50_000),
    ]
    (windowed,) = read_rows(
        [path], Reading(window=(1.0, None, None)), memory=memory_for(20_000)
    ).in_blocks
    assert windowed.rows == N - 1000
    assert len(windowed.cuts) == 1  # the window counts from the log's first row


@pytest.mark.slow
def test_logs_of_which_nothing_is_kept_are_no_sources(tmp_path: Path) -> None:
    paths = [written(tmp_path / f"{seed}.parquet", log_columns(10_000, seed)) for seed in range(12)]
    rows = read_rows(paths, Reading(), memory=memory_for(30_000))
    assert len(rows.in_blocks) == 12
    assert 0 < len(rows.logs) == len(rows.data.sources) < 12
    assert [rows.in_blocks[k].name for k in rows.numbers] == list(rows.data.sources)


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_a_format_that_is_read_whole_is_kept_in_stretches_too(tmp_path: Path) -> None:
    from scipy.io import savemat

    path = tmp_path / "a.mat"
    savemat(
        path, {name.split(" ")[0]: values for name, values in log_columns(position=False).items()}
    )
    rows = read_rows([path], Reading(), memory=memory_for(30_000))
    assert 0 < rows.left_out < N
    assert rows.in_blocks[0].rows == N
    faster = read_rows([path], Reading(rate=500.0), memory=memory_for(15_000))
    assert faster.in_blocks[0].period == pytest.approx(2e-3)


@pytest.mark.slow
def test_what_logs_in_blocks_cannot_have(tmp_path: Path) -> None:
    path = written(tmp_path / "a.parquet", log_columns())
    few = memory_for(20_000)
    with pytest.raises(SettingError, match="--resample needs the whole log in memory"):
        read_rows([path], Reading(rate=500.0), memory=few)
    with pytest.raises(SettingError, match=r"the same file as a\.parquet"):
        read_rows([path, path], Reading(), memory=few)
    other = log_columns(seed=3, position=False)
    other["slip [m/s]"] = other.pop("slip [rad/s]")
    with pytest.raises(MappingError, match="units differ"):
        read_rows([path, written(tmp_path / "b.parquet", other)], Reading(), memory=few)
    with pytest.raises(LogError, match="there is no such file"):
        read_rows([tmp_path / "none.csv"], Reading(), memory=few)


@pytest.mark.slow
def test_logs_in_blocks_that_differ_by_an_unlogged_field_are_asked_about(tmp_path: Path) -> None:
    paths: list[Path] = []
    for duty in (10, 50):
        columns = log_columns(position=False)
        del columns["field [V]"]
        columns["effort [N*m]"] = duty * np.tanh(columns["slip [rad/s]"])
        paths.append(written(tmp_path / f"PWM{duty}.parquet", columns))
    few = memory_for(N)
    with pytest.raises(
        UnloggedFieldError, match=r'5 times the effort of PWM10.* --name-pattern "PWM\{field\}"'
    ):
        read_rows(paths, Reading(), memory=few)
    rows = read_rows(paths, Reading.from_options({"field": "none"}), memory=few)
    assert rows.left_out > 0


def test_too_little_memory_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(any_size, "_WITHOUT_ROWS", 500_000_000)
    with pytest.raises(SettingError, match=r"memory 0\.9"):
        read_rows([], Reading(), memory=0.9e9)

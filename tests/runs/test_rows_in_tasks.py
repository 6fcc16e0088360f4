"""Logs larger than memory in tasks: states go over all borders, and neither workers nor ranges move a bit."""

from __future__ import annotations

import os
import signal
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from erclutch.errors import LogError, RunError, SettingError
from erclutch.fit.laws.fit_law import fit_structure, reference_of
from erclutch.fit.laws.law_over_rows import separable
from erclutch.fit.laws.variable_projection import coordinates, jacobian, linearised
from erclutch.logs import disk_rows, read, read_batches
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.disk_rows import DiskRows
from erclutch.models.law_model import Structure
from erclutch.models.laws import law_from_name
from erclutch.models.stages import shown_stages
from erclutch.runs.large_fit import fit_large
from erclutch.runs.tasks import tasks_on
from erclutch.signals.speed import Derivative

ROWS, GAPS = 30_000, (5_000, 16_390, 16_500)
STAGES = sorted(stage.name for stage in shown_stages() if stage.place != "temperature")


def write(path: Path, rows: int, gaps: tuple[int, ...] = (), seed: int = 0) -> Path:
    """A log of a single element whose force follows the current with a lag."""
    rng = np.random.default_rng(seed)
    t = np.arange(rows) * 1e-3
    for gap in gaps:
        t[gap:] += 0.5
    current, speed = 2.0 * np.abs(np.sin(2.1 * t)), 4.0 * np.cos(3.0 * t) + 3.0 * np.sin(0.7 * t)
    force = 10.0 * current * np.tanh(speed) + 0.8 * speed + 0.1 * rng.standard_normal(rows)
    columns = {"time": ("s", np.round(t, 6)), "I": ("A", current), "v": ("m/s", speed), "F": ("N", force)}
    schema = pa.schema([pa.field(name, pa.float64(), metadata={"unit": unit}) for name, (unit, _) in columns.items()])
    arrays = [pa.array(values) for _, values in columns.values()]
    pq.write_table(pa.Table.from_arrays(arrays, schema=schema), path)
    return path


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("tasks") / "log.parquet", ROWS, GAPS)


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks and ranges of few rows: the log has many borders."""
    monkeypatch.setattr(disk_rows, "BLOCK", 4096)
    monkeypatch.setattr(disk_rows, "RANGE", 8192)


def on_disk(*paths: Path, rows: int = 10_000) -> DiskRows:
    data = DiskRows()
    for path in paths:
        data.add(read_batches(path, rows=rows), "single", Derivative())
    return data


def in_memory(path: Path) -> Dataset:
    return build_dataset(read(path))


def whole(of: Any, stretches: Any) -> list[Any]:
    return [of(data, rows) for data, rows in stretches]


@pytest.mark.parametrize("stage", STAGES)
def test_states_and_their_derivatives_go_over_all_borders_to_the_bit(log: Path, small: None, stage: str) -> None:
    memory = in_memory(log)
    structure = Structure("single", "bingham", law_from_name("bingham", "single"), stage, friction=True)
    reference = reference_of(memory)
    shapes = structure.shapes(reference.period)
    u = coordinates(shapes, [0.6 * s.scanned[0] + 0.4 * s.scanned[1] for s in shapes])
    columns, slopes, projection = jacobian(separable(memory, structure, reference, shapes, slice(None)), u)

    def posed(data: Dataset, rows: slice) -> tuple[np.ndarray, np.ndarray]:
        stacked, own, _ = linearised(separable(data, structure, reference, shapes, rows), u, projection)
        return stacked[:, :-1], own

    with on_disk(log) as data:
        assert data.period == reference.period
        parts = [part for each in data.stretches(partial(whole, posed), past=True) for part in each]
    assert len(parts) > 8
    np.testing.assert_array_equal(np.vstack([stacked for stacked, _ in parts]), columns)
    if stage.startswith(("oscillator", "effort-second-order", "second-order", "stops", "bouc-wen", "spencer")):
        np.testing.assert_allclose(np.vstack([own for _, own in parts]), slopes, rtol=1e-9, atol=1e-9)
    else:
        np.testing.assert_array_equal(np.vstack([own for _, own in parts]), slopes)


@pytest.mark.parametrize("name", ["casson+lag", "bingham+dahl", "rbfm-5/forward"])
def test_a_law_gets_the_bits_of_a_fit_in_memory(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("erclutch.fit.laws.fit_law.MANY_ROWS", 20_000)
    monkeypatch.setattr(disk_rows, "BLOCK", 8192)
    law, _, dynamics = name.partition("+")
    structure = Structure("single", law, law_from_name(law, "single"), dynamics or "none", friction=True)
    path = write(tmp_path / "log.parquet", ROWS, GAPS)
    one = fit_structure(in_memory(path), structure, intervals=False)
    with on_disk(path) as data:
        other = fit_structure(data, structure)
    assert other.model.to_dict() == one.model.to_dict()
    assert other.train_cost == pytest.approx(one.train_cost, rel=1e-12)
    assert other.rank == one.rank


def test_neither_workers_nor_the_cluster_move_a_bit(tmp_path: Path, small: None) -> None:
    paths = [write(tmp_path / f"{k}.parquet", 9_000 + 1_000 * k, GAPS[:1], seed=k) for k in range(3)]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("erclutch.fit.laws.fit_law.MANY_ROWS", 20_000)
        found = [
            fit_large(paths, ("hem+lag", "rbfm-5/forward", "rbfn-4"), workers=workers, test=paths[:1]).to_dict()
            for workers in (1, 2, 4)
        ]
    assert found[0] == found[1] == found[2]


def test_test_errors_of_a_law_with_a_memory_are_those_of_whole_logs(tmp_path: Path, small: None) -> None:
    paths = [write(tmp_path / f"{k}.parquet", 13_000, GAPS[:1], seed=k) for k in range(2)]
    (entry,) = fit_large(paths[0], ("bingham+lag",), test=paths).entries
    data = build_dataset([read(path) for path in paths])
    error = float(np.mean((data.effort - entry.outcome.model.predict(data)) ** 2))
    assert entry.test_mse == pytest.approx(error, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("cluster", ["processes", "local"])
def test_other_processes_give_the_same_models_and_a_dead_worker_is_replaced(tmp_path: Path, cluster: str) -> None:
    if cluster == "local":
        pytest.importorskip("distributed")
    paths = [write(tmp_path / f"{k}.parquet", 120_000, seed=k) for k in range(2)]
    models = ("hem+lag", "rbfm-5/forward", "fnn-2")
    here = fit_large(paths, models)
    there = fit_large(paths, models, cluster=cluster, workers=2)
    assert [e.outcome.model.to_dict() for e in there.entries] == [e.outcome.model.to_dict() for e in here.entries]
    assert there.worker_memory
    assert here.worker_memory is None
    mark = tmp_path / "died"
    with tasks_on(cluster, 2) as tasks:
        assert list(tasks(partial(_dies_once, mark), range(5))) == [0, 1, 4, 9, 16]


def _dies_once(mark: Path, number: int) -> int:
    if number == 3 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL if os.name == "posix" else signal.SIGTERM)
    return number * number


def test_a_part_at_an_address_is_read_from_a_copy_that_goes(tmp_path: Path) -> None:
    pytest.importorskip("fsspec")
    path = write(tmp_path / "log.parquet", 12_000)
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    one, other = (fit_large([place], ("bingham",), scratch=scratch) for place in (path, f"file://{path}"))
    assert other.to_dict() == one.to_dict()
    assert list(scratch.iterdir()) == []
    with pytest.raises(LogError, match=r"none\.parquet: cannot be read"):
        fit_large([f"file://{tmp_path}/none.parquet"], ("bingham",))


def test_what_is_wrong_in_a_task_is_named_with_its_part(tmp_path: Path) -> None:
    good, empty = write(tmp_path / "good.parquet", 12_000), tmp_path / "empty.parquet"
    empty.touch()
    with pytest.raises(LogError, match=r"empty\.parquet"):
        fit_large([good, empty], ("bingham",), workers=2)
    with pytest.raises(SettingError, match="cluster"):
        fit_large(good, ("bingham",), cluster="nonsense")
    with on_disk(good) as data:
        os.truncate(data.stem(0).with_name("00000-1.f8"), 800)
        with pytest.raises(RunError, match=r"00000-1\.f8: kept rows are missing"):
            list(data.blocks)


def test_a_task_knows_its_own_parts_alone(tmp_path: Path, small: None) -> None:
    paths = [write(tmp_path / f"{k}.parquet", 12_000 + 1000 * k, ()) for k in range(3)]
    with on_disk(*paths) as data:
        ends = np.cumsum([0, 12_000, 13_000, 14_000]).tolist()
        assert data.rows == ends[-1]
        for first, last in ((0, 0), (0, 1), (1, 1), (1, 2), (2, 2)):
            some = data.only(ends[first], ends[last + 1])
            assert len(some._parts) == last - first + 1
            assert some._starts.tolist() == ends[first : last + 2]
            assert some._spans[:, 0].tolist() == ends[first : last + 1]
            assert data.only(ends[first] + 1, ends[last + 1] - 1)._starts.tolist() == ends[first : last + 2]
        assert len(data.only(ends[1] - 1, ends[1] + 1)._parts) == 2

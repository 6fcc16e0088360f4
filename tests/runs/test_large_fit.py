"""Logs larger than memory: the same rows and figures as in memory, whatever the batches; bad input in any of them."""

from __future__ import annotations

import itertools
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Generator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from threadpoolctl import threadpool_limits

from erclutch.cli import main
from erclutch.errors import CheckError, ErclutchError, LogError, MappingError, RunError, SettingError
from erclutch.fit.centroids import centroids_of, compress
from erclutch.fit.laws.fit_law import fit_structure
from erclutch.fit.networks.fit_network import fit_network
from erclutch.logs import read, read_batches
from erclutch.logs.batches import datasets
from erclutch.logs.blocks import OneBlock
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.disk_rows import DiskRows
from erclutch.logs.reading import Reading
from erclutch.models.law_model import Structure, TorqueModel
from erclutch.models.laws import law_from_name
from erclutch.models.load import load_model
from erclutch.models.networks import network_from_name
from erclutch.runs.large_fit import _squared_errors, fit_large, write_large
from erclutch.signals.clock import Clock, Span
from erclutch.signals.device import Element, Units
from erclutch.signals.speed import Derivative, differentiate, reach

Columns = Mapping[str, tuple[str, np.ndarray]]
COAXIAL: Any = "coaxial"


def pair(rows: int, seed: int = 0, gaps: tuple[int, ...] = ()) -> dict[str, tuple[str, np.ndarray]]:
    """Columns of a pair's log at 1 kHz: angles, one field at a time, a smooth torque with noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(rows) * 1e-3
    for gap in gaps:
        t[gap:] += 0.5
    signed = 0.45 * np.sin(2.1 * t) * np.sin(0.37 * t + 1.0)
    first, second = np.maximum(signed, 0.0), np.maximum(-signed, 0.0)
    theta, alpha = 30.0 * t + 2.0 * np.sin(3.0 * t), 8.0 * np.sin(1.3 * t)
    w = 30.0 + 6.0 * np.cos(3.0 * t)
    v = 10.4 * np.cos(1.3 * t)
    one, two = w - v, -w - v
    torque = 0.1 * first * np.tanh(one) + 0.1 * second * np.tanh(two) + 1e-3 * (one * first + two * second)
    torque += 2e-4 * (one + two) + 1e-3 * rng.standard_normal(rows)
    return {
        "time": ("s", np.round(t, 6)),
        "E1": ("", first),
        "E2": ("", second),
        "theta": ("rad", theta),
        "alpha": ("rad", alpha),
        "T": ("N*m", torque),
    }


def write(path: Path, columns: Columns, group: int = 50_000) -> Path:
    arrays = [pa.array(values) for _, values in columns.values()]
    fields = [
        pa.field(name, a.type, metadata={"unit": unit})
        for (name, (unit, _)), a in zip(columns.items(), arrays, strict=True)
    ]
    pq.write_table(pa.Table.from_arrays(arrays, schema=pa.schema(fields)), path, row_group_size=group)
    return path


_OPEN: list[DiskRows] = []


@pytest.fixture(autouse=True)
def _closed() -> Generator[None]:  # pyright: ignore[reportUnusedFunction]
    yield
    while _OPEN:
        _OPEN.pop().__exit__(None, None, None)


def spooled(*paths: Path, rows: int = 262_144, derivative: Derivative | None = None, invalid: Any = None) -> DiskRows:
    spool = DiskRows()
    _OPEN.append(spool)
    for path in paths:
        batches = read_batches(path, device=COAXIAL, rows=rows, invalid=invalid)
        spool.add(batches, COAXIAL, derivative or Derivative())
    return spool


@cache
def in_memory(*paths: Path, invalid: Any = None) -> Dataset:
    return build_dataset([read(path, device=COAXIAL, invalid=invalid) for path in paths], device=COAXIAL)


@pytest.fixture(scope="session")
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    gaps = (7, 9_998, 20_003, 29_994, 30_001, 45_000)
    return write(tmp_path_factory.mktemp("large") / "short.parquet", pair(62_000, gaps=gaps))


@pytest.fixture(scope="session")
def long(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("large") / "long.parquet", pair(131_072 + 17_001))


# --- the same as in memory --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("window", [(9.5, 42.25, None), (None, None, 12.0), (None, 12.5, 3.0)])
def test_a_window_is_that_of_the_log_in_memory(short: Path, window: Any) -> None:
    reading = Reading(rows=10_000, window=window)
    spool = DiskRows()
    _OPEN.append(spool)
    spool.add(reading.batches(short, COAXIAL), COAXIAL, Derivative())
    whole = build_dataset(reading.read(short, COAXIAL), device=COAXIAL)
    kept = spool.read(0, spool.rows, ordered=True)
    assert spool.sources[0].read == 62_000
    assert [(s.start, s.stop) for s in kept.clock.spans] == [(s.start, s.stop) for s in whole.clock.spans]
    np.testing.assert_array_equal(kept.effort, whole.effort)
    np.testing.assert_array_equal(kept.clock.time, whole.clock.time)
    for one, other in zip(kept.elements, whole.elements, strict=True):
        np.testing.assert_allclose(one.slip, other.slip, atol=1e-7)


@pytest.mark.parametrize(
    ("window", "said"), [((1e3, None, None), "0 rows lie from 1000 s on"), ((None, None, -1), "--skip -1 s")]
)
def test_a_window_that_the_log_cannot_have_is_refused(short: Path, window: Any, said: str) -> None:
    with pytest.raises(SettingError, match=said):
        fit_large([short], ("bingham",), device=COAXIAL, reading=Reading(rows=50_000, window=window))


class _SomeBlocks(OneBlock[Any]):
    """Blocks of one range."""

    def fold(self, of: Any) -> Any:
        return iter([of(self.whole)])


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 6), st.lists(st.integers(1, 400), min_size=1, max_size=6), st.integers(0, 2), st.integers(0, 99))
def test_blocks_give_the_centroids_of_the_whole_to_the_last_bit(
    inputs: int, sizes: list[int], level: int, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    x, y = rng.standard_normal((inputs, sum(sizes))), rng.standard_normal(sum(sizes))
    whole = compress(x, y, level)
    ends = np.cumsum(sizes)[:-1]
    blocks = [(xs, ys, xs) for xs, ys in zip(np.split(x, ends, axis=1), np.split(y, ends), strict=True)]
    parts = centroids_of(_SomeBlocks(blocks), [level])[level]
    for one, other in ((whole.x, parts.x), (whole.y, parts.y), (whole.count, parts.count)):
        np.testing.assert_array_equal(one, other)
    assert parts.scatter == pytest.approx(whole.scatter, rel=1e-9, abs=1e-9)


@settings(max_examples=6, deadline=None)
@given(rows=st.integers(10_000, 40_000))
def test_batches_of_any_size_give_the_rows_of_the_whole_log(short: Path, rows: int) -> None:
    data, spool = in_memory(short), spooled(short, rows=rows)
    found = spool.thinned(spool.rows)
    assert found.rows == data.rows
    assert spool.period == pytest.approx(1e-3, rel=1e-9)
    np.testing.assert_array_equal(found.effort, data.effort)
    for one, other in zip(found.elements, data.elements, strict=True):
        np.testing.assert_array_equal(one.field, other.field)
        np.testing.assert_allclose(one.slip, other.slip, atol=1e-7)


@pytest.mark.parametrize("name", ["central", "difference", "lowpass", "kalman"])
def test_filters_of_speeds_run_over_the_edges_of_batches(short: Path, name: Any) -> None:
    derivative = Derivative(name)
    whole = build_dataset(read(short, device=COAXIAL), device=COAXIAL, derivative=derivative)
    spool = spooled(short, rows=10_000, derivative=derivative)
    np.testing.assert_allclose(spool.thinned(spool.rows).elements[0].slip, whole.elements[0].slip, atol=1e-6)


@pytest.mark.parametrize("derivative", [Derivative("lowpass", 5.0), Derivative("kalman", 20.0), Derivative("savgol")])
def test_a_filter_forgets_within_its_reach(derivative: Derivative) -> None:
    x = np.cumsum(np.random.default_rng(0).standard_normal(9000)) * 1e-3
    back = reach(derivative, 1e-3)
    assert back < 4096

    def speeds(y: np.ndarray) -> np.ndarray:
        return differentiate(
            y, Clock(np.linspace(0.0, (y.size - 1) * 1e-3, y.size), (Span(0, y.size, 1e-3),)), derivative
        )

    at = 4500
    np.testing.assert_allclose(speeds(x[at - back :])[back : back + 400], speeds(x)[at : at + 400], rtol=0, atol=1e-9)


def test_means_over_the_spool_are_those_of_numpy_to_the_last_bit(long: Path) -> None:
    data, spool = in_memory(long), spooled(long)
    found = spool.blocks.means(lambda block: [block.effort, block.elements[0].slip ** 2])
    assert found == [float(np.mean(data.effort)), float(np.mean(data.elements[0].slip ** 2))]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["fnn-4", "rbfn-8", "rbfn-6/kmeans", "rbfn-4/refined"])
def test_networks_get_the_weights_of_a_fit_in_memory(long: Path, name: str) -> None:
    network = network_from_name(name, COAXIAL)
    with threadpool_limits(1):
        one = fit_network(in_memory(long), network)
        other = fit_network(spooled(long, rows=20_000), network)
    assert other.model.to_dict() == one.model.to_dict()
    assert other.train_cost == pytest.approx(one.train_cost, rel=1e-10)
    assert other.train_rows == one.train_rows


@pytest.mark.parametrize("name", ["bingham", "hem/forward", "quadratic", "rbfm-10/forward", "rbfm-5"])
def test_laws_get_the_figures_of_a_fit_in_memory(long: Path, name: str) -> None:
    structure = Structure(COAXIAL, name, law_from_name(name, COAXIAL))
    data = in_memory(long)
    with threadpool_limits(1):
        one = fit_structure(data, structure, intervals=False)
        other = fit_structure(spooled(long, rows=20_000), structure)
    assert dict(other.model.shape) == pytest.approx(dict(one.model.shape), rel=1e-9)
    assert other.model.reference == one.model.reference
    assert other.model.trained_on == one.model.trained_on
    assert other.train_cost == pytest.approx(one.train_cost, rel=1e-8)
    assert other.rank == one.rank
    # An RBFM's gains trade off (condition above 1e10): what it predicts is what agrees.
    difference = other.model.predict(data) - one.model.predict(data)
    assert float(np.sqrt(np.mean(difference**2))) < 1e-6 * float(np.std(data.effort))


def test_a_log_below_the_rows_that_centroids_need_is_fitted_in_memory(short: Path) -> None:
    structure = Structure(COAXIAL, "hem", law_from_name("hem", COAXIAL))
    one = fit_structure(in_memory(short), structure, intervals=False)
    other = fit_structure(spooled(short), structure)
    assert other.train_cost == pytest.approx(one.train_cost, rel=1e-6)


def test_each_model_of_one_law_is_fitted(short: Path) -> None:
    names = ("bingham", "bingham+lag", "bingham+dahl")
    fitted = fit_large(short, names, device=COAXIAL).entries
    assert tuple(entry.name for entry in fitted) == names


def test_several_logs_of_several_formats_are_one(tmp_path: Path) -> None:
    paths = [write(tmp_path / "a.parquet", pair(15_000)), tmp_path / "b.csv"]
    columns = pair(6_000, seed=1)
    heads = ",".join(f"{name} [{unit}]" if unit else name for name, (unit, _) in columns.items())
    rows = np.column_stack([values for _, values in columns.values()])
    np.savetxt(paths[1], rows, delimiter=",", header=heads, comments="", fmt="%.12g")
    result = fit_large(paths, ("bingham", "fnn-3"), device=COAXIAL, test=[paths[1]])
    assert [source.kept for source in result.sources] == [15_000, 6_000]
    assert (result.rows, result.test_rows) == (21_000, 6_000)
    whole = fit_network(in_memory(*paths), network_from_name("fnn-3", COAXIAL))
    assert result.entries[1].outcome.model.to_dict() == whole.model.to_dict()
    test = in_memory(paths[1])
    for entry in result.entries:
        error = float(np.mean((test.effort - entry.outcome.model.predict(test)) ** 2))
        assert entry.test_mse == pytest.approx(error, rel=1e-9)
        assert entry.seconds > 0.0


def test_time_goes_on_from_batch_to_batch_with_a_rate_too(tmp_path: Path) -> None:
    columns = {name: column for name, column in pair(25_000).items() if name != "time"}
    path = write(tmp_path / "rate.parquet", columns)
    batches = read_batches(path, {"rate": 1000.0}, device=COAXIAL, rows=10_000)
    time = np.concatenate([data.clock.time for _, data in datasets(batches, COAXIAL, Derivative()) if data is not None])
    np.testing.assert_allclose(time, np.arange(25_000) * 1e-3, atol=1e-9)


def test_dropped_rows_are_dropped_as_in_memory(tmp_path: Path) -> None:
    columns = pair(45_000)
    columns["T"][1][[5, 20_000, 29_999, 30_000]] = np.nan
    columns["T"][1][20_010:40_000] = np.nan  # more than a whole batch
    path = write(tmp_path / "holes.parquet", columns)
    with pytest.raises(LogError):
        spooled(path, rows=10_000)
    spool, data = spooled(path, rows=10_000, invalid="drop"), in_memory(path, invalid="drop")
    assert spool.sources[0].read == 45_000
    np.testing.assert_array_equal(spool.thinned(spool.rows).effort, data.effort)


def random_rows(rows: int, seed: int) -> Dataset:
    """Rows of one element with no order in them."""
    rng = np.random.default_rng(seed)
    clock = Clock(np.arange(float(rows)), (Span(0, rows, 1.0),))
    element = Element(rng.random(rows), rng.standard_normal(rows))
    return Dataset("single", (element,), rng.standard_normal(rows), clock, Units("N", "A", ""))


@pytest.fixture(scope="module")
def bingham() -> TorqueModel:
    law = law_from_name("bingham", "single")
    return fit_structure(random_rows(300, 0), Structure("single", "bingham", law), intervals=False).model


@settings(max_examples=100, deadline=None)
@given(st.lists(st.integers(1, 300), min_size=1, max_size=5), st.integers(0, 99))
def test_errors_add_up_over_blocks(bingham: TorqueModel, sizes: list[int], seed: int) -> None:
    rows, model = sum(sizes), bingham
    data = random_rows(rows, seed)
    ends = np.cumsum([0, *sizes]).tolist()
    blocks = [data.picked(slice(a, b)) for a, b in itertools.pairwise(ends)]
    (error,) = _squared_errors([model], ((block, slice(None)) for block in blocks)).tolist()
    assert error == pytest.approx(float(np.sum((data.effort - model.predict(data)) ** 2)), rel=1e-12)


def test_rows_in_memory_are_the_one_block_of_their_data_set(short: Path) -> None:
    data = in_memory(short)
    calls: list[int] = []
    squares = data.blocks.map(lambda block: calls.append(block.rows) or block.effort**2)
    assert [s.size for s in squares] == [s.size for s in squares] == [data.rows]
    assert calls == [data.rows], "what is made of rows in memory is made once"
    assert squares.means(lambda s: [s]) == [float(np.mean(data.effort**2))]


# --- what cannot be ---------------------------------------------------------------------------------------------------


def refusal(path: Path | list[Path], models: tuple[str, ...] = ("bingham",), **how: Any) -> ErclutchError:
    with pytest.raises(ErclutchError) as caught:
        fit_large(path, models, device=COAXIAL, reading=Reading(rows=10_000, **how))
    return caught.value


def test_a_missing_value_in_a_late_batch_is_named_with_its_row(tmp_path: Path) -> None:
    columns = pair(90_000)
    columns["T"][1][67_890] = np.nan
    error = refusal(write(tmp_path / "hole.parquet", columns))
    assert isinstance(error, LogError)
    assert "column T has 1 value missing or infinite, the first (nan) in data row 67891" in str(error)
    assert "hole.parquet, data rows 60001 to 70000" in str(error)


def test_time_that_runs_backwards_between_batches_is_refused(tmp_path: Path) -> None:
    columns = pair(40_000)
    columns["time"][1][20_000:] -= 5.0
    assert "runs backwards" in str(refusal(write(tmp_path / "back.parquet", columns)))


def test_missing_columns_and_other_units_are_refused(tmp_path: Path) -> None:
    good = write(tmp_path / "good.parquet", pair(12_000))
    columns = pair(12_000, seed=1)
    lacking = write(tmp_path / "lacking.parquet", {k: v for k, v in columns.items() if k != "alpha"})
    error = refusal([good, lacking])
    assert isinstance(error, MappingError)
    assert "lacking.parquet" in str(error)
    volts = write(tmp_path / "volts.parquet", {**columns, "E1": ("V", columns["E1"][1]), "E2": ("V", columns["E2"][1])})
    error = refusal([good, volts])
    assert "units differ" in str(error)
    assert "volts.parquet" in str(error)
    assert "the same file as good.parquet" in str(refusal([good, good]))
    assert "there is no such file" in str(refusal([tmp_path / "none.parquet"]))


def test_a_field_without_unit_that_outgrows_a_plain_number_is_refused(tmp_path: Path) -> None:
    columns = pair(40_000)
    columns["E1"][1][30_000:] *= 10.0
    bare = {name: (("?" if name in ("E1", "E2") else unit), values) for name, (unit, values) in columns.items()}
    path = tmp_path / "bare.parquet"
    arrays = {name: values for name, (_, values) in bare.items()}
    pq.write_table(pa.table(arrays), path)
    error = refusal(path)
    assert isinstance(error, MappingError)
    assert "unit" in str(error)


def test_files_without_numbers_or_rows_or_an_end_are_refused(tmp_path: Path) -> None:
    words, empty, cut = tmp_path / "words.parquet", tmp_path / "empty.parquet", tmp_path / "cut.parquet"
    pq.write_table(pa.table({"time": ["a", "b"] * 10, "T": ["c", "d"] * 10}), words)
    assert "no column of numbers" in str(refusal(words))
    pq.write_table(pa.table({"time": pa.array([], pa.float64())}), empty)
    assert "no rows" in str(refusal(empty))
    cut.write_bytes(write(tmp_path / "whole.parquet", pair(12_000)).read_bytes()[:-100])
    assert "damaged" in str(refusal(cut))


def test_fewer_rows_than_weights_and_constants_are_refused(tmp_path: Path) -> None:
    few = write(tmp_path / "few.parquet", pair(400))
    error = refusal(few, ("fnn-100",))
    assert isinstance(error, CheckError)
    assert "400 training rows for the 501 weights" in str(error)
    columns = pair(12_000)
    still = write(tmp_path / "still.parquet", {**columns, "T": ("N*m", np.full(12_000, 0.1))})
    assert "effort is constant" in str(refusal(still))


def test_models_with_memory_or_a_stimulus_are_refused_with_the_reason(short: Path) -> None:
    error = refusal(short, ("on-off",))
    assert isinstance(error, SettingError)
    assert "stimulus" in str(error)
    for network in (
        network_from_name("fnn-3", COAXIAL, past=(1,)),
        network_from_name("fnn-3", COAXIAL, dynamics="lag"),
        network_from_name("fnn-3", COAXIAL, extras=tuple("abcde")),
    ):
        with DiskRows() as none, pytest.raises(SettingError, match="larger than memory"):
            fit_network(none, network)
    assert "unknown" in str(refusal(short, ("nonsense",))) or "no law" in str(refusal(short, ("nonsense",)))
    assert "no model was given" in str(refusal(short, ()))


@pytest.mark.slow
def test_a_set_of_models_leaves_out_what_cannot_be(tmp_path: Path) -> None:
    result = fit_large(write(tmp_path / "log.parquet", pair(3000)), ("all",), device=COAXIAL)
    assert len(result.left_out) == 1
    assert "on-off" in result.left_out[0]
    assert "fnn-16" in [entry.name for entry in result.entries]


def test_fields_that_are_on_together_stop_laws_but_not_networks(tmp_path: Path) -> None:
    columns = pair(120_000)
    columns["E1"][1][:] += 0.01
    columns["E2"][1][:] += 0.01
    path = write(tmp_path / "both.parquet", columns)
    error = refusal(path, ("hem",))
    assert isinstance(error, CheckError)
    assert "both clutches are under field in 120000 rows" in str(error)
    found = fit_large(path, ("fnn-2",), device=COAXIAL)
    assert [f.subject for f in found.findings if f.level == "warning"] == ["fields"]


def test_other_settings_that_cannot_be(short: Path, tmp_path: Path) -> None:
    with pytest.raises(RunError, match="--scratch"):
        fit_large(short, ("bingham",), device=COAXIAL, scratch=tmp_path / "missing")
    with pytest.raises(SettingError, match="no log"):
        fit_large([], ("bingham",))
    with pytest.raises(SettingError, match="batches of 5 rows"):
        fit_large(short, ("bingham",), device=COAXIAL, reading=Reading(rows=5))
    slow = refusal(short, derivative=Derivative("lowpass", 0.5))
    assert "remembers more than 4096 rows" in str(slow)
    stepped = refusal(short, mapping={"constants": {"T": "0, 1 N*m"}})
    assert "one number a segment" in str(stepped)


# --- the command ------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_command_writes_models_that_load(short: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    command = ["fit-large", str(short), "--device", "coaxial", "--models", "bingham/forward", "fnn-3"]
    assert run([*command, "--test-log", str(short), "--out", str(out)]) == 0
    said = capsys.readouterr()
    assert "62,000 rows, tested on 62,000" in said.out
    assert "peak memory" in said.out
    model = load_model(out / "models" / "bingham_forward.json")
    summary = json.loads((out / "large.json").read_text())
    assert [m["name"] for m in summary["models"]] == ["bingham/forward", "fnn-3"]
    data = in_memory(short)
    assert summary["models"][0]["train_mse"] == pytest.approx(
        float(np.mean((data.effort - model.predict(data)) ** 2)), rel=1e-9
    )
    assert run([*command, "--out", str(out)]) == 2
    assert "--force" in capsys.readouterr().err
    assert run([*command, "--out", str(out), "--force", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["cpu_seconds"]["fnn-3"] > 0
    assert run([*command, "--batch", "5"]) == 2


def run(arguments: list[str]) -> int:
    return main(arguments)


def test_a_folder_that_is_something_else_is_kept(short: Path, tmp_path: Path) -> None:
    result = fit_large(short, ("bingham",), device=COAXIAL)
    (tmp_path / "mine").mkdir()
    with pytest.raises(RunError):
        write_large(tmp_path / "mine", result, force=True)
    assert list((tmp_path / "mine").iterdir()) == []


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_an_interrupt_leaves_nothing(tmp_path: Path) -> None:
    write(tmp_path / "log.parquet", pair(1_500_000))
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    command = [sys.executable, "-m", "erclutch", "fit-large", "log.parquet", "--device", "coaxial", "--models", "all"]
    command += ["--out", "out", "--scratch", str(scratch)]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    time.sleep(4.0)
    assert process.poll() is None, "the fit was done before the interrupt"
    process.send_signal(signal.SIGINT)
    out, said = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "Traceback" not in said
    assert out == ""
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["log.parquet", "scratch"]


@pytest.mark.slow
def test_memory_does_not_grow_with_the_rows(tmp_path: Path) -> None:
    peaks: list[int] = []
    for rows in (2_400_000, 4_800_000):  # a task holds a range of 2**20 rows; whether two meet at their peaks is chance
        path = write(tmp_path / f"{rows}.parquet", pair(rows), group=10**9)
        command = [sys.executable, "-m", "erclutch", "fit-large", str(path), "--device", "coaxial"]
        command += ["--models", "rbfm-10/forward", "fnn-4", "--json", "--scratch", str(tmp_path), "--workers", "1"]
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=300)
        peaks.append(json.loads(done.stdout)["peak_memory_bytes"])
    # The six columns alone would take 115 MB more.
    assert peaks[1] - peaks[0] < 20e6
    assert peaks[1] < 0.7e9

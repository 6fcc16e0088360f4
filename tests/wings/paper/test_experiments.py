"""Tables and sweeps: on the twin and on a user's logs, kept point by point, and beside what the paper prints."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import RunError
from erclutch.logs.dataset import Dataset
from erclutch.models.stages import slip_stages
from erclutch.runs.cluster import TaskPool, task_pool
from erclutch.wings.paper import memory_table
from erclutch.wings.paper.beside_the_paper import _to_bingham  # pyright: ignore[reportPrivateUsage]
from erclutch.wings.paper.published import APPROACHES
from erclutch.wings.paper.section_figures import draw_estimates
from erclutch.wings.paper.sweep_figures import draw_fnn_sweep, draw_kernel_sweep, draw_rbfn_sweep
from erclutch.wings.paper.sweep_points import Points
from erclutch.wings.paper.sweeps import RunsRecipe, fnn_sweep, kernel_sweep, rbfn_sweep
from erclutch.wings.paper.tables import printed, table, twin_runs
from erclutch.wings.rig.twin.parameters import default_rig
from tests.support.command import good, run

RECIPE = RunsRecipe(twin_runs, (("names", ("training", "test")), ("seconds", 20.0), ("seed", 3)))
#: Enough to tell a memory by.
FEW_SECONDS = 8.0


@pytest.fixture(scope="module")
def runs() -> dict[str, Dataset]:
    return RECIPE.make(**dict(RECIPE.options))


@pytest.fixture
def threads() -> Iterator[TaskPool]:
    with task_pool("threads", 2) as pool:
        yield pool


def silent(done: int, total: int, what: str) -> None:
    assert 0 < done <= total
    assert what


@pytest.mark.slow
def test_a_table_scores_what_it_fitted(runs: dict[str, Dataset]) -> None:
    rows = table(runs, models=("bingham/forward", "rbfm-5/forward", "fnn-4"))
    assert [r.name for r in rows] == ["bingham/forward", "rbfm-5/forward", "fnn-4"]
    for row in rows:
        for name, data in runs.items():
            error = float(np.mean((data.effort - row.model.predict(data)) ** 2))
            assert row.errors[name] == pytest.approx(error)
            low, high = row.bands[name]
            assert low <= row.errors[name] <= high
    errors = [row.errors["training"] for row in rows]
    assert errors == sorted(errors, reverse=True)
    assert printed("bingham/forward")["training"] == APPROACHES["bingham/forward"].train
    assert printed("nothing") == {}


@pytest.mark.slow
def test_the_table_with_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Sign and memory each take from the error, past samples too; a second call finds what the first one kept."""
    runs = twin_runs(("training", "test"), seconds=FEW_SECONDS, seed=3)
    monkeypatch.setattr(memory_table, "PAPER", ("bingham/forward",))
    monkeypatch.setattr(memory_table, "PAPER_NETWORKS", ("fnn-3",))
    stages, found = memory_table.memory_table(
        runs, Points(tmp_path / "p.jsonl", {}), 0, False, silent
    )
    assert slip_stages(stages), f"no memory of the slip in {stages}"
    law = [
        found[variant]["bingham"]["training"][0]
        for variant in ("as in the paper", "sign of the slip", "memory")
    ]
    assert law[2] < 0.7 * law[1] < 0.7 * law[0]
    network = [
        found[variant]["fnn-3"]["training"][0]
        for variant in ("as in the paper", "past samples", "memory")
    ]
    assert max(network[1:]) < 0.6 * network[0]
    plain = table(runs, models=("bingham/forward", "fnn-3"))
    for row, name in zip(plain, ("bingham", "fnn-3"), strict=True):
        assert found["as in the paper"][name]["test"][0] == pytest.approx(row.errors["test"])
        assert found["as in the paper"][name]["parameters"] == row.parameters
    monkeypatch.setattr(memory_table, "compare", pytest.fail)
    assert memory_table.memory_table(runs, Points(tmp_path / "p.jsonl", {}), 0, False, silent) == (
        stages,
        found,
    )
    assert memory_table.noise_floor(default_rig()) == pytest.approx(0.0003**2 + 0.00005**2 / 12)


@pytest.mark.slow
def test_figure_6_shows_what_the_models_estimate(runs: dict[str, Dataset], tmp_path: Path) -> None:
    test = runs["test"]
    rows = table({"training": runs["training"]}, models=("bingham/forward", "hem/forward"))
    paths = draw_estimates(test, rows, tmp_path, "TWIN")
    assert [p.name for p in paths] == ["fig6.pdf", "fig6.png", "fig6.csv"]
    with paths[-1].open() as file:
        kept = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    hem = rows[1].model.predict(test)
    start = int(np.argmin(np.abs(hem - kept[0]["hem/forward"])))
    for name, values in (("measured", test.effort), ("hem/forward", hem)):
        assert [r[name] for r in kept] == pytest.approx(
            values[start : start + len(kept)].tolist(), rel=1e-8
        )


@pytest.mark.slow
def test_a_ratio_to_bingham_is_that_of_its_own_run(runs: dict[str, Dataset]) -> None:
    rows = table(runs, models=("bingham/forward", "hem/forward"))
    swapped = [replace(r, errors={**r.errors, "zero-field": r.errors["test"]}) for r in rows]
    ours, theirs = _to_bingham(swapped, "zero-field")
    assert ours == [1.0, rows[1].errors["test"] / rows[0].errors["test"]]
    assert theirs == [1.0, pytest.approx(6.5249e-5 / 5.5329e-5)]


@pytest.mark.slow
def test_sweeps_draw_what_they_found_and_resume(threads: TaskPool, tmp_path: Path) -> None:
    settings = {"rows": 1}
    path = tmp_path / "points.jsonl"
    first = fnn_sweep(
        RECIPE, threads, Points(path, settings), 0, silent, neurons=(1, 3), restarts=2
    )
    kept = path.read_text()
    assert len(kept.splitlines()) == 2
    path.write_text(kept + '{"settings": "x", "ke')  # as after a power cut
    again = fnn_sweep(
        RECIPE, threads, Points(path, settings), 0, silent, neurons=(1, 3), restarts=2
    )
    assert path.read_text() == kept
    for key in first:
        np.testing.assert_array_equal(first[key], again[key])
    assert first["train"][1] < first["train"][0]
    assert first["restarts"].shape == (2, 2)
    paths = draw_fnn_sweep(first, tmp_path, "TWIN", {3: 2e-5})
    assert [p.name for p in paths] == ["fig5.pdf", "fig5.png", "fig5.csv"]
    with paths[-1].open() as file:
        assert [float(r["train_mse"]) for r in csv.DictReader(file)] == pytest.approx(
            first["train"].tolist()
        )


@pytest.mark.slow
@pytest.mark.parametrize("cluster", ["processes", "local"])
def test_a_sweep_has_the_same_bits_wherever_it_runs(threads: TaskPool, cluster: str) -> None:
    if cluster == "local":
        pytest.importorskip("distributed")
    wanted = fnn_sweep(RECIPE, threads, Points(None, {}), 0, silent, neurons=(1, 2, 3), restarts=1)
    with task_pool(cluster, 2) as pool:
        found = fnn_sweep(RECIPE, pool, Points(None, {}), 0, silent, neurons=(1, 2, 3), restarts=1)
    assert all(np.array_equal(found[key], wanted[key]) for key in wanted)


@pytest.mark.slow
def test_the_other_sweeps(threads: TaskPool, tmp_path: Path) -> None:
    rbfn = rbfn_sweep(RECIPE, threads, Points(None, {}), 0, silent)
    assert rbfn["scan"].shape == (len(rbfn["spreads"]), len(rbfn["neurons"]))
    assert np.all(np.diff(rbfn["train"]) < 1e-9 + 0.05 * rbfn["train"][:-1])
    assert len(draw_rbfn_sweep(rbfn, tmp_path, "TWIN")) == 3
    kernels = kernel_sweep(RECIPE, threads, Points(None, {}), 0, silent)
    assert kernels["train"][-1] <= kernels["train"][0]
    assert len(draw_kernel_sweep(kernels, tmp_path, "TWIN")) == 3


def test_points_of_other_settings_are_not_used(tmp_path: Path) -> None:
    path = tmp_path / "p.jsonl"
    assert Points(path, {"a": 1}).get("x", lambda: 5) == 5
    assert Points(path, {"a": 2}).get("x", lambda: 6) == 6
    assert Points(path, {"a": 1}).get("x", lambda: 7) == 5
    path.write_text("[]\n")
    with pytest.raises(RunError, match="no file of a sweep"):
        Points(path, {})


@pytest.mark.slow
def test_tables_on_the_command_line(tmp_path: Path) -> None:
    done = run("reproduce", "table2", "--seconds", "15", cwd=tmp_path)
    assert done.code == 0, done.error
    assert "Table II: TWIN beside the paper" in done.out
    with (tmp_path / "reproduced" / "table2.csv").open() as file:
        rows = {r["model"]: r for r in csv.DictReader(file)}
    assert list(rows) == list(APPROACHES)
    assert float(rows["fnn-16"]["training_paper"]) == APPROACHES["fnn-16"].train
    told = json.loads(
        run("reproduce", "table2", "--seconds", "5", "--json", "--out", "short", cwd=tmp_path).out
    )
    assert [row["model"] for row in told["rows"]] == list(APPROACHES)
    assert told["rows"][0]["training_low"] < told["rows"][0]["training_mse"]
    assert (tmp_path / told["files"][0]).is_file()
    for name, scenario in (("log", "training"), ("zero", "zero-field"), ("held", "zero-motion")):
        assert (
            run(
                "simulate", scenario, "--seconds", "12", "--out", f"{name}.parquet", cwd=tmp_path
            ).code
            == 0
        )
    own = ("--log", "log.parquet", "--zero-field", "zero.parquet", "--zero-motion", "held.parquet")
    done = run("reproduce", "table3", *own, "--device", "coaxial", cwd=tmp_path)
    assert done.code == 0, done.error
    assert "Table III" in done.out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("table2", "--seconds", "1"), "Give 5 to 86400 s"),
        (("table3", "--log", "none.csv"), "none.csv"),
        (("fig5", "--out", "file"), "cannot be made"),
        (("fig7", "--log", "none.csv"), "a log is no rig"),
    ],
)
def test_requests_that_cannot_be(tmp_path: Path, words: tuple[str, ...], said: str) -> None:
    (tmp_path / "file").write_text("")
    done = run("reproduce", *words, cwd=tmp_path)
    assert done.code == 2
    assert said in done.error
    assert "Traceback" not in done.error


@pytest.mark.slow
def test_the_kept_points_are_plain_json(threads: TaskPool, tmp_path: Path) -> None:
    fnn_sweep(
        RECIPE, threads, Points(tmp_path / "p.jsonl", {}), 1, silent, neurons=(1,), restarts=1
    )
    body = json.loads((tmp_path / "p.jsonl").read_text())
    assert set(body) == {"settings", "key", "value", "digest"}


def test_the_list_of_experiments_is_json_too(tmp_path: Path) -> None:
    listed = json.loads(good("experiment", "--json", cwd=tmp_path))
    assert "wall" in {each["name"] for each in listed}


def test_an_experiment_gives_its_numbers_as_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What it prints for people is kept back, and the JSON is all that stands on the output."""
    from erclutch.cli import terminal
    from erclutch.wings.paper.commands import experiment

    def online(names: list[str], *_: object) -> list[dict[str, object]]:
        terminal.tell("a table for people")
        return [{"experiment": name, "rows": []} for name in names]

    monkeypatch.setattr(experiment, "run_online", online)
    said = json.loads(good("experiment", "zero-field", "--json", cwd=tmp_path))
    assert said == {"data": "TWIN", "experiments": [{"experiment": "zero-field", "rows": []}]}
    assert good("experiment", "zero-field", cwd=tmp_path) == "a table for people\n"


def test_the_list_of_scenarios_is_json_too(tmp_path: Path) -> None:
    listed = json.loads(good("simulate", "--json", cwd=tmp_path))
    assert next(each for each in listed if each["name"] == "training")["seconds"] == 290.0

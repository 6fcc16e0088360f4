"""Runs side by side: the same rows, the paired difference, the settings that differ."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import ErclutchError
from erclutch.fit.choice.scoring import difference
from erclutch.fit.comparison import Settings, compare
from erclutch.logs import read
from erclutch.logs.dataset import build_dataset
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.report.html.runs_page import sentence, what_changed, write_comparison
from erclutch.report.numbers.number_text import scale_for
from erclutch.report.numbers.paired_runs import changes, differing_settings, pair
from erclutch.runs.run_folder import Run, read_run
from erclutch.runs.written_run import write_run
from erclutch.signals.recording import Recording


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("log") / "log.csv"
    write_synthetic_log(path, 4.0)
    return read(path)


def run_of(folder: Path, recording: Recording, *models: str, test: float = 0.3) -> Run:
    found = compare(build_dataset(recording), Settings(models=models, lag="none", test=test))
    return read_run(write_run(folder, found, [recording], reading={}))


@pytest.fixture(scope="module")
def runs(recording: Recording, tmp_path_factory: pytest.TempPathFactory) -> tuple[Run, Run]:
    folder = tmp_path_factory.mktemp("runs")
    return run_of(folder / "a", recording, "quadratic"), run_of(
        folder / "b", recording, "bingham", "quadratic"
    )


@pytest.mark.slow
def test_the_same_rows(runs: tuple[Run, Run]) -> None:
    found = pair(runs)
    assert found.rows == 1200
    assert found.whole
    first, second = found.contenders
    assert (first.label, first.model, second.label) == ("a", "quadratic", "b")
    assert first.more is None
    rmse = [float(np.sqrt(np.mean(c.residual**2))) for c in found.contenders]
    assert second.more is not None
    assert second.more.value == pytest.approx(rmse[1] - rmse[0])
    assert second.more.low <= second.more.value <= second.more.high
    assert [c.figures.rmse.value for c in found.contenders] == pytest.approx(rmse)
    assert found.differing == (("models", ("quadratic", "bingham, quadratic")),)


@pytest.mark.slow
def test_the_same_model_does_not_differ(runs: tuple[Run, Run]) -> None:
    found = pair(runs, ["quadratic"])
    more = found.contenders[1].more
    assert more is not None
    assert more.to_list() == [0.0, 0.0, 0.0]
    assert "cannot be told from" in sentence(found, scale_for("N*m", 1.0))
    assert [s.name for s in found.same] == ["quadratic"]
    assert found.same[0].share.value == 0.0


@pytest.mark.slow
def test_only_rows_that_all_held_out_count(
    recording: Recording, runs: tuple[Run, Run], tmp_path: Path
) -> None:
    found = pair([runs[0], run_of(tmp_path / "half", recording, "quadratic", test=0.5)])
    assert found.rows == 1200
    assert not found.whole
    assert ("test", ("0.3", "0.5")) in found.differing
    path = write_comparison(found, tmp_path / "c.html")
    assert "no pictures of them together" in path.read_text()


@pytest.mark.slow
def test_another_log_is_refused(
    recording: Recording, runs: tuple[Run, Run], tmp_path: Path
) -> None:
    other = run_of(tmp_path / "other", replace(recording, digest="of another file"), "quadratic")
    with pytest.raises(
        ErclutchError,
        match=r"only 0 rows were held out by all runs.*erclutch score LOG --run RUN RUN",
    ):
        pair([runs[0], other])
    twice = {name: 2.0 * v if name == "effort" else v for name, v in recording.signals.items()}
    scaled = run_of(tmp_path / "scaled", replace(recording, signals=twice), "quadratic")
    with pytest.raises(ErclutchError, match="the effort of these rows is not that of"):
        pair([runs[0], scaled])


@pytest.mark.slow
def test_the_page_holds_all_runs(runs: tuple[Run, Run], tmp_path: Path) -> None:
    text = write_comparison(pair(runs), tmp_path / "c.html").read_text()
    for words in (
        "a: Quadratic law",
        "b: ",
        "What was done differently",
        'id="traces-plot"',
        'class="badge synthetic"',
    ):
        assert words in text


@pytest.mark.slow
def test_the_paired_interval_is_narrower_and_holds_the_truth() -> None:
    """Two models share most of their error: pairing takes it out. 95 % of intervals hold the true difference."""
    rng = np.random.default_rng(0)
    hits, trials = 0, 120
    for k in range(trials):
        common = rng.normal(size=1500)
        a, b = common + 0.1 * rng.normal(size=1500), 1.05 * common + 0.1 * rng.normal(size=1500)
        found = difference(b, a, block=5, seed=k)
        truth = np.sqrt(1.05**2 + 0.01) - np.sqrt(1.01)
        hits += found.low <= truth <= found.high
        assert found.high - found.low < 0.25 * 2 * 1.96 / np.sqrt(2 * 1500)
    assert 0.88 <= hits / trials <= 1.0


@pytest.mark.slow
def test_what_changed_is_said_and_a_lag_gets_no_credit_for_a_network(
    recording: Recording, runs: tuple[Run, Run], tmp_path: Path
) -> None:
    settings = Settings(models=("fnn-2",), lag="lag", past=(5, 20))
    made = compare(build_dataset(recording), settings)
    network = read_run(write_run(tmp_path / "network", made, [recording], reading={}))
    found = pair([runs[0], network])
    assert {change.what for change in changes(*found.contenders)} == {
        "law or network",
        "stages on the command",
        "past samples",
    }
    said = what_changed(found)
    assert "past samples (none there, 5 and 20 here)" in said
    assert "do not tell what each of them does" in said
    text = write_comparison(found, tmp_path / "c.html").read_text()
    assert "nothing tells what the stages gain" in text
    assert "past samples (none there, 5 and 20 here)" in text


@pytest.mark.slow
def test_a_lag_alone_gets_its_credit(
    recording: Recording, runs: tuple[Run, Run], tmp_path: Path
) -> None:
    made = compare(build_dataset(recording), Settings(models=("quadratic",), lag="lag"))
    lagged = read_run(write_run(tmp_path / "lagged", made, [recording], reading={}))
    found = pair([runs[0], lagged])
    assert [change.what for change in changes(*found.contenders)] == ["stages on the command"]
    assert "The stages alone (lag) take" in write_comparison(found, tmp_path / "c.html").read_text()


def test_settings_that_differ_are_said_as_a_user_would() -> None:
    def body(offset: bool | None, test: float, past: list[str]) -> dict[str, Any]:
        settings = {"offset": offset, "test": test, "past": past}
        rest: dict[str, Any] = {
            "reading": {},
            "units": {},
            "versions": {},
            "logs": [],
            "train_rows": 7,
            "test_rows": 3,
        }
        return {"device": "single", "settings": settings, **rest}

    found = differing_settings([body(None, 0.3, []), body(False, 0.30000000000000004, ["5ms"])])
    assert found == (("offset", ("by default", "no")), ("past", ("none", "5ms")))

"""The recommended model is fitted to all rows after the choice, and kept beside the one that was judged."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from erclutch.errors import RunError, SettingError
from erclutch.fit.comparison import Comparison, Settings, compare
from erclutch.fit.final_fit import with_final_fit
from erclutch.logs import recording_from_arrays
from erclutch.logs.dataset import build_dataset
from erclutch.report.html.provenance_section import command_of
from erclutch.runs.new_rows import called_final, models_of
from erclutch.runs.run_folder import FINAL, read_run
from erclutch.runs.written_run import write_run
from erclutch.signals.recording import Recording
from tests.support.command import good, refused


@pytest.fixture(scope="module")
def judged() -> tuple[Comparison, Recording]:
    """Bingham's law with some noise, SYNTHETIC."""
    rng = np.random.default_rng(0)
    t = 5e-3 * np.arange(1000)
    slip, field = 3.0 * np.sin(4.0 * t) + np.sin(11.0 * t), np.where(t % 0.7 < 0.3, 1.0, 0.2)
    effort = (0.2 + field) * np.tanh(slip / 0.1) + 0.3 * slip + 0.05 * rng.standard_normal(t.size)
    units = {"field": "A", "slip": "rad/s", "effort": "N*m"}
    recording = recording_from_arrays(
        {"field": field, "slip": slip, "effort": effort}, units, rate=200.0
    )
    return compare(build_dataset(recording), Settings(("bingham", "fnn-2"), lag="none")), recording


@pytest.mark.slow
def test_a_law_is_fitted_to_all_rows_and_keeps_the_band_of_the_judged_one(
    judged: tuple[Comparison, Recording],
) -> None:
    comparison, _ = judged
    assert comparison.recommended == "bingham"
    final = with_final_fit(comparison).final
    assert final is not None
    entry = comparison.entry("bingham")
    assert (final.train_rows, entry.outcome.train_rows) == (1000, 700)
    assert final.train_cost < float(
        np.sum((comparison.data.effort - entry.predicted) ** 2)
    )  # of all rows
    assert final.model.band == entry.outcome.model.band


@pytest.mark.slow
def test_a_network_is_fitted_to_all_rows_too(judged: tuple[Comparison, Recording]) -> None:
    comparison = replace(judged[0], recommended="fnn-2")
    final = with_final_fit(comparison).final
    assert final is not None
    assert (final.train_rows, final.model.name) == (1000, "fnn-2")


@pytest.mark.slow
def test_the_run_keeps_both_and_says_which_is_which(
    judged: tuple[Comparison, Recording], tmp_path: Path
) -> None:
    comparison, recording = judged
    whole = with_final_fit(comparison)
    run = read_run(write_run(tmp_path / "run", whole, [recording], reading={}))
    assert whole.final is not None
    final = run.model(FINAL)
    assert final.to_dict() == whole.final.model.to_dict()
    assert final.to_dict() != run.model("bingham").to_dict()
    assert run.body["final"]["rows"] == 1000
    names = [name for name, _ in models_of(run, run.model(), None)]
    assert names == [*run.names, called_final(final)] == [*run.names, "final: bingham, of all rows"]
    assert "--final" in command_of(run.body)


@pytest.mark.slow
def test_a_final_model_that_was_changed_or_never_kept_is_refused(
    judged: tuple[Comparison, Recording], tmp_path: Path
) -> None:
    comparison, recording = judged
    bare = read_run(write_run(tmp_path / "bare", comparison, [recording]))
    with pytest.raises(RunError, match="keeps no model of all rows"):
        bare.model(FINAL)
    run = read_run(write_run(tmp_path / "run", with_final_fit(comparison), [recording]))
    file = run.folder / "models" / "final.json"
    other = json.loads((run.folder / "models" / "bingham.json").read_text())
    file.write_text(json.dumps(other))
    with pytest.raises(RunError, match="not the model that the run wrote"):
        run.model(FINAL)


@pytest.mark.slow
def test_what_is_not_recommended_is_not_fitted_to_all_rows(
    judged: tuple[Comparison, Recording],
) -> None:
    comparison = replace(judged[0], candidates={})
    with pytest.raises(SettingError, match="bingham cannot be fitted again"):
        with_final_fit(comparison)


def test_a_model_of_all_rows_needs_a_run_to_be_kept_in(tmp_path: Path) -> None:
    assert "Give --out RUN too" in refused("fit", "log.csv", "--final", cwd=tmp_path)


def test_force_without_a_run_to_replace_is_refused(tmp_path: Path) -> None:
    said = refused("fit", "log.csv", "--force", cwd=tmp_path)
    assert "--force: no run is kept" in said
    assert "Give --out RUN too" in said


@pytest.mark.slow
def test_commands_take_a_run_with_a_model_of_all_rows(
    judged: tuple[Comparison, Recording], tmp_path: Path
) -> None:
    """`score` ended in a traceback: it looked for the model of all rows in the ranking."""
    comparison, recording = judged
    folder = write_run(tmp_path / "run", with_final_fit(comparison), [recording], reading={})
    columns = np.column_stack([recording.signals[name] for name in ("field", "slip", "effort")])
    log = tmp_path / "log.csv"
    header = "field [A],slip [rad/s],effort [N*m]"
    np.savetxt(log, columns, delimiter=",", header=header, comments="", fmt="%.9g")
    every = good("score", log, "--run", folder, "--rate", "200 Hz")
    assert "final, Bingham law, of all rows" in " ".join(every.split())
    one = good("score", log, "--run", folder, "--rate", "200 Hz", "--model", FINAL, "--json")
    (scored,) = json.loads(one)["models"]
    assert scored["title"] == "final, Bingham law, of all rows"
    good("export", folder, "--to", "python", "--model", FINAL, "--out", tmp_path / "final")

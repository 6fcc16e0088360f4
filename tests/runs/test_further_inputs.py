"""A law with a further input and the same law without it: two models of one run, each with a name and a file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from erclutch.export import ExportOptions, step_of
from erclutch.export.exported_step import OUTSIDE
from erclutch.export.step_numbers import run
from erclutch.fit.comparison import Comparison, Settings, compare
from erclutch.logs import read
from erclutch.logs.dataset import Dataset, build_dataset
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.report.numbers.model_stages import stage_gain
from erclutch.runs.new_rows import score_model
from erclutch.runs.run_folder import read_run
from erclutch.runs.run_rows import read_rows
from erclutch.runs.run_shape import file_name
from erclutch.runs.written_run import write_run
from erclutch.signals.recording import Recording
from tests.support.command import good

# `test_runs.py` reads rows in a child, as a user does.
pytestmark = pytest.mark.usefixtures("read_here")


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("log") / "log.csv"
    write_synthetic_log(path, 2.0)
    return read(path)


def with_spring(recording: Recording, name: str) -> Dataset:
    """A clutch with a lag, a spring beside it, and the spring's travel as a further input of this name, SYNTHETIC.

    It has no memory: of what the log itself remembers a fit makes five more rungs, in five times the time.
    """
    data = build_dataset(recording)
    (clutch,) = data.elements
    lagged = lfilter(
        [0.125], [1.0, -0.875], clutch.field / clutch.field.max()
    )  # 8 rows behind the command
    torque = 0.5 * lagged**1.5 * np.tanh(clutch.slip / 0.5) + 0.003 * clutch.slip
    travel = np.sin(9.0 * data.clock.time)
    noise = np.random.default_rng(1).normal(size=data.rows)
    effort = torque + np.std(torque) * (0.5 * travel + 0.02 * noise)
    return replace(data, effort=effort, extras={name: travel})


def compared(recording: Recording, name: str) -> Comparison:
    return compare(with_spring(recording, name), Settings(models=("bingham",)))


@pytest.mark.slow
@pytest.mark.parametrize("column", ["travel", 'Weg/"links" <µ>: a+b', "x" * 300])
def test_both_are_kept_and_read_back(recording: Recording, tmp_path: Path, column: str) -> None:
    made = compared(recording, column)
    names = [entry.name for entry in made.entries]
    assert len(set(names)) == len(names)
    assert made.recommended.startswith("bingham+lag@with ")
    folder = write_run(tmp_path / "run", made, [recording])
    back = read_run(folder)
    for entry in made.entries:
        assert np.array_equal(back.model(entry.name).predict(made.data), entry.predicted)
    assert all(
        path.name.isascii() and len(path.name) < 200 for path in (folder / "models").iterdir()
    )
    titles = [entry["title"] for entry in back.body["ranking"]]
    assert len(set(titles)) == len(titles)
    gained = stage_gain(back.body["ranking"])
    assert gained is None or ("@" in gained.richer["name"]) == ("@" in gained.plainer["name"])


@pytest.mark.slow
def test_the_report_opens(recording: Recording, tmp_path: Path) -> None:
    folder = write_run(tmp_path / "run", compared(recording, "travel"), [recording])
    good("report", str(folder))
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "with travel" in page
    assert (
        "<mi>c</mi>" in page
    )  # the equation has the term of the input, not the table of numbers alone
    assert "<mtext>travel</mtext>" in page


@pytest.mark.slow
def test_the_report_says_what_a_network_with_a_further_input_adds(
    recording: Recording, tmp_path: Path
) -> None:
    """Its rows kept no further inputs, and the report ended in an error."""
    data = with_spring(recording, "travel")
    made = compare(data, Settings(models=("bingham+fnn-2",), lag="none"))
    folder = write_run(tmp_path / "run", made, [recording])
    assert np.array_equal(read_rows(read_run(folder)).data.extras["travel"], data.extras["travel"])
    good("report", str(folder))
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "The network adds" in page


def test_names_that_no_file_can_have_are_kept_apart() -> None:
    names = [
        "a@with x:y",
        "a@with x;y",
        "a@with " + 300 * "x",
        "a@with " + 301 * "x",
        "bingham/power+lag",
    ]
    files = [file_name(name) for name in names]
    assert len(set(files)) == len(files)
    assert files[-1] == "bingham_power+lag"


@pytest.mark.slow
def test_a_further_input_beyond_the_training_rows_is_a_guess_as_in_the_exported_step(
    recording: Recording,
) -> None:
    """`predict` said 0 % where the exported C raised its flag in most rows: the oil was hotter than in training."""
    data = with_spring(recording, "travel")
    model = compare(data, Settings(models=("rbfn-4",), lag="none")).entries[0].outcome.model
    far = replace(data, extras={"travel": 1.5 * data.extras["travel"]})
    assert model.outside(data).mean() < 0.1  # rows held out among them
    guessed = model.outside(far)
    (element,) = far.elements
    rows = np.column_stack([element.field, element.slip, far.extras["travel"]])[::50]
    _, flags = run(step_of(model, ExportOptions(period=1e-3)), rows)
    assert (flags & OUTSIDE > 0).tolist() == guessed[::50].tolist()
    told = score_model(model, far, "rbfn-4")
    assert told.guessed == guessed.mean() > 0.2
    assert "further input travel above 1 (" in told.where

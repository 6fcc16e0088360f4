"""Options of `erclutch live`: those of every day first, files of a rig apart from runs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Never

import pytest

from erclutch.cli import app
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.wings.live import session
from erclutch.wings.live.settings import LoopSettings
from tests.support.command import good, refused, run

pytestmark = pytest.mark.slow


def test_help_shows_what_one_needs_every_day_and_folds_the_rest() -> None:
    short = good("live", "--help")
    everyday = (
        "--run",
        "--model",
        "--rig",
        "--log",
        "--program",
        "--motor",
        "--observer",
        "--seconds",
        "--record",
    )
    assert all(option in short for option in everyday)
    assert "--track-integral" not in short
    assert re.search(r"Torque control: \d options \(--adapt, .*\), with --help-all", short)
    assert len(short.split()) < 0.4 * len(good("live", "--help-all").split())
    assert good("live", "--help") == short


def test_a_rig_is_described_by_a_file() -> None:
    hints = {
        name: str(each.hint)
        for each in app["live"].assemble_argument_collection()
        for name in each.names
    }
    assert "pathlib.Path" in hints["--rig-file"]
    assert "pathlib.Path" in hints["--run"]


def test_a_misspelt_program_is_told_before_a_model_is_fitted(tmp_path: Path) -> None:
    said = refused("live", "--headless", "--program", "torque-stp", cwd=tmp_path)
    assert said.startswith(
        "error: there is no program 'torque-stp'. Did you mean torque-step? Choose one of rest, "
    )


def test_a_model_without_its_run_is_refused(tmp_path: Path) -> None:
    assert "no run is given" in refused("live", "--model", "bingham", cwd=tmp_path)


def settings_given(
    words: tuple[str, ...], cwd: Path, monkeypatch: pytest.MonkeyPatch
) -> LoopSettings:
    """What ``erclutch live WORDS`` would run."""
    given: list[LoopSettings] = []

    def kept(_: object, settings: LoopSettings, *__: object) -> Never:
        given.append(settings)
        raise session.LiveError("no loop is started here", remedy="None")

    monkeypatch.setattr(session, "Session", kept)
    assert (
        "no loop is started here" in run("live", "--no-model", "--headless", *words, cwd=cwd).error
    )
    return given[0]


@pytest.mark.parametrize(
    ("option", "on_a_rig", "in_a_replay"),
    [((), 1.0, 0.0), (("--meter-needed",), 2.0, 2.0), (("--no-meter-needed",), 0.0, 0.0)],
    ids=["neither", "needed", "not needed"],
)
def test_meter_needed_says_which_torques_bring_zero_field(
    option: tuple[str, ...],
    on_a_rig: float,
    in_a_replay: float,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """1: those that cannot be by themselves; 2: also those that disagree with the model; 0: none."""
    write_synthetic_log(tmp_path / "log.csv", seconds=2.0)
    assert settings_given(option, tmp_path, monkeypatch).meter_needed == on_a_rig
    replay = (*option, "--rig", "replay", "--log", "log.csv")
    assert settings_given(replay, tmp_path, monkeypatch).meter_needed == in_a_replay

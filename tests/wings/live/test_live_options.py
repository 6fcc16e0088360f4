"""Options of `erclutch live`: those of every day first, files of a rig apart from runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from erclutch.cli import app
from tests.support.command import good, refused


@pytest.mark.slow
def test_help_shows_what_one_needs_every_day_and_folds_the_rest() -> None:
    short = good("live", "--help")
    everyday = ("--run", "--model", "--rig", "--log", "--program", "--motor", "--observer", "--seconds", "--record")
    assert all(option in short for option in everyday)
    assert "--track-integral" not in short
    assert re.search(r"Torque control: \d options \(--adapt, .*\), with --help-all", short)
    assert len(short.split()) < 0.4 * len(good("live", "--help-all").split())
    assert good("live", "--help") == short


def test_a_rig_is_described_by_a_file() -> None:
    hints = {name: str(each.hint) for each in app["live"].assemble_argument_collection() for name in each.names}
    assert "pathlib.Path" in hints["--rig-file"]
    assert "pathlib.Path" in hints["--run"]


def test_a_misspelt_program_is_told_before_a_model_is_fitted(tmp_path: Path) -> None:
    said = refused("live", "--headless", "--program", "torque-stp", cwd=tmp_path)
    assert said.startswith("error: there is no program 'torque-stp'. Did you mean torque-step? Choose one of rest, ")


def test_a_model_without_its_run_is_refused(tmp_path: Path) -> None:
    assert "no run is given" in refused("live", "--model", "bingham", cwd=tmp_path)

"""`erclutch demo`: a log of the TWIN, models, a report; what was there is replaced only if a demo wrote it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from erclutch.logs import read
from tests.support.command import good, refused
from tests.support.compared_once import compare_once

COMMAND = (sys.executable, "-m", "erclutch")


@pytest.mark.slow
def test_demo(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compare_once(monkeypatch)
    said = good("demo", "--seconds", "10", "--out", "kept", cwd=tmp_path)
    assert "TWIN: " in said
    for words in (
        "1 of 3  Collecting",
        "2 of 3  Fitting",
        "3 of 3  Writing the report",
        "Recommended: ",
    ):
        assert words in said
    assert "mN" not in said  # one unit in the table and in the sentences below
    assert f"Report: {tmp_path / 'kept' / 'report.html'}" in said
    assert (
        json.loads((tmp_path / "kept" / "run" / "run.json").read_text())["kind"] == "erclutch run"
    )
    # That of an earlier demo is replaced.
    earlier = (tmp_path / "kept" / "report.html").stat().st_mtime_ns
    said = json.loads(good("demo", "--seconds", "10", "--out", "kept", "--json", cwd=tmp_path))
    assert (tmp_path / "kept" / "report.html").stat().st_mtime_ns > earlier
    assert sorted(p.name for p in tmp_path.iterdir()) == ["kept"]
    assert sorted(p.name for p in (tmp_path / "kept").iterdir()) == [
        "report.html",
        "run",
        "twin.parquet",
    ]
    assert said["data"] == "TWIN"
    assert said["run"]["recommended"] in {each["name"] for each in said["run"]["ranking"]}
    assert 'class="badge twin"' in (tmp_path / "kept" / "report.html").read_text()


def test_a_short_demo_is_refused(tmp_path: Path) -> None:
    assert "--seconds 0.5" in refused("demo", "--seconds", "0.5", cwd=tmp_path)


@pytest.mark.slow
def test_the_truth_of_the_twin_is_neither_an_input_nor_a_hint(tmp_path: Path) -> None:
    good("simulate", "brake", "--seconds", "4", "--out", "twin.csv", cwd=tmp_path)
    assert read(tmp_path / "twin.csv").spare.keys().isdisjoint({"true_torque", "true_theta_dot"})
    said = refused("fit", "twin.csv", "--effort", "true_torqe", cwd=tmp_path)
    assert "Did you mean true" not in said


def test_demo_never_replaces_what_is_no_demo(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("mine")
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "thesis.tex").write_text("mine")
    for out, words in (
        ("log.csv", "log.csv: exists and is not the folder of a demo. Give another --out."),
        ("mine", "mine: exists and is not the folder of a demo"),
        ("no/demo", "no/demo: its parent folder cannot be written"),
    ):
        assert words in refused("demo", "--out", out, cwd=tmp_path)


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
@pytest.mark.parametrize("at", ["1 of 3", "2 of 3", "bingham", "fnn-6 ", "3 of 3"])
def test_an_interrupted_demo_leaves_nothing(at: str, tmp_path: Path) -> None:
    command = subprocess.Popen(
        [*COMMAND, "demo", "--seconds", "10"],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    assert command.stdout is not None
    for line in command.stdout:
        if at in line:
            break
    command.send_signal(signal.SIGINT)
    _, said = command.communicate(timeout=60)
    assert command.returncode == 130, said
    assert said == "error: interrupted; nothing was left half-written\n"
    assert list(tmp_path.iterdir()) == []

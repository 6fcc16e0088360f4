"""The command prints what the model says, refuses what it cannot print, and is listed."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import pytest

import erclutch
from erclutch.cli import main
from erclutch.logs.synthetic import write_synthetic_log


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("effort")
    write_synthetic_log(folder / "log.csv", 2.0)
    words = ("--models", "bingham", "--lag", "none", "--out", str(folder / "run"))
    assert main(["fit", str(folder / "log.csv"), *words]) == 0
    return folder / "run"


def test_the_table_is_what_the_model_says(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["effort-table", str(run), "--field", "0", "1500", "--rows", "7"]) == 0
    head, *rows = csv.reader(io.StringIO(capsys.readouterr().out))
    assert head == ["slip [rad/s]", "effort at 0 V [N*m]", "effort at 1500 V [N*m]"]
    table = np.array(rows, np.float64)
    model = erclutch.read_run(run).model()
    for column, field in ((1, 0.0), (2, 1500.0)):
        effort = model.steady([np.full(7, field)], [table[:, 0]])
        np.testing.assert_allclose(table[:, column], effort, rtol=1e-4, atol=1e-5)


def test_a_table_without_rows_is_refused(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effort-table", str(run), "--rows", "1"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert said == (
        "error: effort-table of erclutch-command-effort-table 0.1.0: --rows 1. Give 2 to 1000."
    )


def test_help_lists_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    said = capsys.readouterr().out
    assert "effort-table" in said.partition("Of other packages")[2]

"""`erclutch fit` of a log beyond memory: the same run as ever, every row scored, and an interrupted scoring goes on."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from erclutch.cli import main
from erclutch.logs import any_size
from erclutch.logs.synthetic import synthetic_log
from erclutch.runs import every_row
from erclutch.runs.every_row_folder import FILE, FOLDER, read_every_row
from erclutch.runs.run_folder import read_run

pytestmark = pytest.mark.usefixtures("read_here")

ROWS = 40_000
OPTIONS = ("--models", "bingham", "fnn-4", "--lag", "lag", "--memory", "0.05")


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """40 s of the SYNTHETIC log, with a gap in the middle."""
    path = tmp_path_factory.mktemp("any-size") / "log.parquet"
    columns = synthetic_log(ROWS / 1000.0)
    time = columns["time"][1] + np.arange(ROWS) // 20_000
    named = {
        f"{name} [{unit}]": values for name, (unit, values) in columns.items() if name != "time"
    }
    pq.write_table(pa.table({"time [s]": time, **named}), path)
    return path


@pytest.fixture(autouse=True)
def _little_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(any_size, "_WITHOUT_ROWS", 10_000_000)
    monkeypatch.setattr(any_size, "_TASK", 15_000)


@pytest.mark.slow
def test_the_run_is_as_any_other_and_every_row_is_scored(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "run"
    assert main(["fit", str(log), *OPTIONS, "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "log.parquet: 40,000 rows, 40 s at 1000 Hz, 1 gap" in printed
    assert "of 40,000 rows are fitted, in whole stretches" in printed
    assert "Every row: 40,000, of which" in printed
    assert f"Kept in {out}" in printed
    run = read_run(out)
    figures = read_every_row(run)
    assert figures is not None
    assert sorted(figures["models"]) == sorted(run.names)
    assert (
        figures["rows"]
        == ROWS
        > figures["kept_rows"]
        == run.body["train_rows"] + run.body["test_rows"]
    )
    assert not (out / FOLDER).exists()
    assert main(["report", str(out), "--out", str(tmp_path / "report.html")]) == 0
    assert (
        main(["predict", str(log), "--run", str(out), "--out", str(tmp_path / "predicted.parquet")])
        == 0
    )
    assert pq.read_metadata(tmp_path / "predicted.parquet").num_rows == ROWS


@pytest.mark.slow
def test_json_has_the_figures_of_every_row(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit", str(log), *OPTIONS, "--json"]) == 0
    body = json.loads(capsys.readouterr().out)
    assert body["every_row"]["rows"] == ROWS
    assert body["recommended"] in body["every_row"]["models"]


@pytest.mark.slow
def test_a_log_that_fits_has_no_more_than_it_had(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fit", str(log), *OPTIONS[:-1], "1", "--out", str(tmp_path / "run")]) == 0
    assert "Every row" not in capsys.readouterr().out
    assert not (tmp_path / "run" / FILE).exists()


@pytest.mark.slow
def test_an_interrupted_scoring_goes_on_with_the_same_command(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    words = ["fit", str(log), *OPTIONS, "--out", str(tmp_path / "run")]
    original: Any = every_row.score_part
    scored: list[int] = []

    def interrupted(plan: Any, models: Any, how: Any, report: Any, part: Any) -> Any:
        if part.at == 1 and scored:
            raise KeyboardInterrupt
        scored.append(part.at)
        return original(plan, models, how, report, part)

    monkeypatch.setattr(every_row, "score_part", interrupted)
    assert main(words) == 130
    assert "the same command with --resume scores the rest" in capsys.readouterr().out
    assert scored == [0]
    scored.clear()
    assert main([*words, "--resume"]) == 0
    assert scored == [1]
    assert "Every row: 40,000" in capsys.readouterr().out
    assert read_every_row(read_run(tmp_path / "run")) is not None
    assert main([*words, "--resume"]) == 2
    assert "every row is scored already" in capsys.readouterr().err
    assert main(words) == 2  # there is a run already
    assert main([*words[:-2], "--resume"]) == 2
    assert "--resume without a run" in capsys.readouterr().err

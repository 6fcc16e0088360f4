"""`erclutch recalibrate` as a user meets it: from any folder, with a run that other commands take, errors of a line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from erclutch.logs.synthetic import synthetic_log
from erclutch.report.html.provenance_section import command_of
from erclutch.runs.run_folder import read_run
from tests.support.command import good, run


def write(path: Path, gain: float, seed: int, force: str = "N*m", seconds: float = 6.0) -> Path:
    columns = synthetic_log(seconds, seed)
    columns["torque"] = (force, gain * columns["torque"][1])
    header = ",".join(f"{name} [{unit}]" for name, (unit, _) in columns.items())
    rows = np.column_stack([values for _, values in columns.values()])
    np.savetxt(path, rows, delimiter=",", fmt="%.6g", header=header, comments="")
    return path


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("base")
    write(folder / "log.csv", 1.0, 0)
    good(
        "fit",
        "log.csv",
        "--models",
        "bingham",
        "--lag",
        "lag",
        "--effort",
        "torque",
        "--test",
        "0.3",
        "--out",
        "RUN",
        cwd=folder,
    )
    return folder / "RUN"


@pytest.mark.slow
def test_a_gain_becomes_a_run_that_other_commands_take(base: Path, tmp_path: Path) -> None:
    write(tmp_path / "new.csv", 1.15, 1)
    said = good("recalibrate", base, "new.csv", "--out", "NEW", cwd=tmp_path)
    assert "Recalibrated, common gain: gain 1.1" in said
    assert "Parameters of m1, Bingham law with a lag, recalibrated" in said
    found = read_run(tmp_path / "NEW")
    assert found.body["recommended"] == "bingham+lag@recalibrated"
    assert set(found.names) == {"bingham+lag", "bingham+lag@recalibrated"}
    assert found.body["reading"]["effort"] == "torque"
    mine, kept = (found.entry(name) for name in ("bingham+lag@recalibrated", "bingham+lag"))
    assert mine["test"]["rmse"][0] < kept["test"]["rmse"][0]
    values = [{p["name"]: p for p in entry["fit"]["parameters"]} for entry in (mine, kept)]
    assert values[0]["T_y"]["value"] == pytest.approx(1.15 * values[1]["T_y"]["value"], rel=0.05)
    assert values[0]["T_y"]["low"] < values[0]["T_y"]["value"] < values[0]["T_y"]["high"]
    assert values[0]["tau"] == values[1]["tau"]
    for name in (
        "T_y",
        "eta",
        "T_0",
    ):  # the gain is known well; what the base did not know of each number stays
        widths = [each[name]["high"] - each[name]["low"] for each in values]
        assert 1.1 * widths[1] < widths[0] < 1.6 * widths[1], name
    assert command_of(found.body) == (
        "erclutch recalibrate RUN new.csv --device single --effort torque --model bingham+lag --share 0.7 --stretches 1"
        " --out RUN"
    )
    good("report", "NEW", cwd=tmp_path)
    assert "Recalibrated, common gain" in (tmp_path / "NEW" / "report.html").read_text()
    good("export", "NEW", "--out", "C", cwd=tmp_path)
    assert json.loads((tmp_path / "C" / "model.json").read_text())["about"][
        "recalibrated"
    ].startswith("common gain")
    good("recalibrate", "NEW", "new.csv", cwd=tmp_path)


@pytest.mark.slow
def test_what_helps_nothing_keeps_the_base_and_says_so(base: Path, tmp_path: Path) -> None:
    write(tmp_path / "same.csv", 1.0, 2)
    said = good("recalibrate", base, "same.csv", "--out", "SAME", cwd=tmp_path)
    assert "The base is kept: nothing helps for sure" in said
    assert read_run(tmp_path / "SAME").names == ("bingham+lag",)


@pytest.mark.slow
def test_what_the_other_rows_refute_is_not_recommended(base: Path, tmp_path: Path) -> None:
    columns = write(tmp_path / "turn.csv", 1.5, 3)
    rows = np.genfromtxt(columns, delimiter=",", skip_header=1)
    rows[1800:, 3] /= 1.5
    head = columns.read_text().splitlines()[0]
    np.savetxt(columns, rows, delimiter=",", fmt="%.6g", header=head, comments="")
    said = good("recalibrate", base, "turn.csv", "--share", "0.3", "--out", "TURN", cwd=tmp_path)
    assert "The base is kept: on the rows that neither saw" in said
    found = read_run(tmp_path / "TURN")
    assert found.body["recommended"] == "bingham+lag"
    assert len(found.names) == 2


@pytest.mark.slow
def test_errors_are_one_line(base: Path, tmp_path: Path) -> None:
    log = write(tmp_path / "log.csv", 1.0, 0, seconds=1.0)
    other = write(tmp_path / "other.csv", 1.0, 0, force="N", seconds=1.0)
    cases = {
        ("nowhere", log): "not a run",
        (base, "missing.csv"): "missing.csv",
        (base, log, "--model", "casson"): "no model 'casson'",
        (base, log, "--share", "0.01"): "10 rows to recalibrate with, at least 20",
        (base, log, "--share", "1.5"): "--share 1.5",
        (base, log, "--stretches", "0"): "--stretches 0",
        (base, other): "other.csv: effort in N, ",
        (base, log, "--device", "coaxial"): "coaxial",
        (base, log, "--out", "nowhere/NEW"): "parent",
    }
    for arguments, text in cases.items():
        done = run("recalibrate", *arguments, cwd=tmp_path)
        assert done.code == 2, (arguments, done.out)
        assert done.error.startswith("error: ")
        assert done.error.count("\n") == 1, done.error
        assert text in done.error

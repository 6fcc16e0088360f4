"""What a run says of other logs: from any folder, with the run's own reading, whole files or none."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

import erclutch
from erclutch.errors import shell_word
from erclutch.logs.synthetic import synthetic_log
from erclutch.models.model_file import digest_of
from erclutch.runs.run_folder import read_run
from tests.support.command import good, refused, run

pytestmark = pytest.mark.slow

NAMES = {"time": "t", "field": "u", "slip": "w", "torque": "M"}


def _write(path: Path, seed: int, effort: bool = True, seconds: float = 3.0) -> None:
    columns = {
        name: column
        for name, column in synthetic_log(seconds, seed).items()
        if effort or name != "torque"
    }
    header = ",".join(f"{NAMES[name]} [{unit}]" for name, (unit, _) in columns.items())
    np.savetxt(
        path,
        np.column_stack([v for _, v in columns.values()]),
        delimiter=",",
        header=header,
        comments="",
    )


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two logs, one of them also without effort, and a run of the first."""
    folder = tmp_path_factory.mktemp("predict")
    _write(folder / "one.csv", 0)
    _write(folder / "two.csv", 1)
    _write(folder / "blind.csv", 1, effort=False)
    (folder / "several").mkdir()
    for name in ("one.csv", "two.csv"):
        shutil.copy(folder / name, folder / "several")
    named = ("--time", "t [s]", "--field", "u [V]", "--slip", "w [rad/s]", "--effort", "M [N*m]")
    models = ("--models", "bingham", "quadratic", "--lag", "none", "--out", "run")
    assert run("fit", "one.csv", *named, *models, cwd=folder)[0] == 0
    return folder


def test_score_finds_the_only_run_itself(place: Path) -> None:
    named = run("score", "two.csv", "--run", "run", cwd=place)
    found = run("score", "two.csv", cwd=place)
    assert (found.code, found.out) == (0, named.out)
    assert found.error == "run: run, the only run here\n"


def test_predict_writes_all_rows_with_the_band_and_needs_no_effort(
    place: Path, tmp_path: Path
) -> None:
    code, said, _ = run(
        "predict",
        place / "blind.csv",
        "--run",
        place / "run",
        "--band",
        "--out",
        "p.csv",
        cwd=tmp_path,
    )
    assert code == 0
    assert "3,000 rows" in said
    lines = (tmp_path / "p.csv").read_text().splitlines()
    assert lines[1] == "time [s],field [V],slip [rad/s],effort [N*m],low [N*m],high [N*m],outside"
    kept = erclutch.read_run(place / "run")
    log = erclutch.read(
        place / "two.csv",
        {"field": "u [V]", "slip": "w [rad/s]", "effort": "M [N*m]", "time": "t [s]"},
    )
    data, model = erclutch.build_dataset(log), kept.model()
    assert model.band is not None
    effort = model.predict(data)
    ends = model.band.around(effort, data.elements, data.clock)
    for values, column in zip(
        (effort, *ends, model.outside(data)), lines[1].split(",")[3:], strict=True
    ):
        written = np.genfromtxt(
            lines[2:], delimiter=",", usecols=[lines[1].split(",").index(column)]
        )
        assert np.allclose(written, values, rtol=1e-8, atol=1e-9)
    assert len(lines) == 2 + data.rows


@pytest.mark.parametrize(
    ("cell", "said"), [("", "has 1 value missing"), ("-999", "holds -999 in 1 row")]
)
def test_predict_says_which_rows_it_leaves_out(
    place: Path, tmp_path: Path, cell: str, said: str
) -> None:
    lines = (place / "blind.csv").read_text().splitlines()
    row = lines[-100].split(",")
    lines[-100] = ",".join([*row[:2], cell, *row[3:]])
    (tmp_path / "holes.csv").write_text("\n".join(lines) + "\n")
    code, told, _ = run(
        "predict", "holes.csv", "--run", place / "run", "--out", "p.csv", cwd=tmp_path
    )
    assert code == 0
    assert "2,999 rows" in told
    assert said in " ".join(told.split())


def test_the_command_line_wins_over_how_the_run_read_its_logs(place: Path, tmp_path: Path) -> None:
    copy = tmp_path / "run"
    shutil.copytree(place / "run", copy)
    body = json.loads((copy / "run.json").read_text())
    body["reading"] |= {"field": None, "name_pattern": "{field}A"}
    del body["reading"]["field"], body["digest"]
    (copy / "run.json").write_text(json.dumps({**body, "digest": digest_of(body)}))
    asked = ("score", place / "two.csv", "--run", copy)
    assert "does not match the pattern" in run(*asked, cwd=tmp_path)[2]
    assert run(*asked, "--constant", "field=0.75 V", cwd=tmp_path)[0] == 0
    assert (
        run(
            "score",
            place / "two.csv",
            "--run",
            place / "run",
            "--constant",
            "field=1 V",
            cwd=tmp_path,
        )[0]
        == 0
    )


def test_predict_as_parquet_with_a_sensor_of_a_models_file(place: Path, tmp_path: Path) -> None:
    file = place / "run" / "models" / "quadratic.json"
    given = ("--field", "u", "--slip", "w", "--effort", "M", "--time", "t")
    asked = ("predict", place / "two.csv", "--run", file, "--sensor", "--out", "p.parquet", *given)
    assert run(*asked, cwd=tmp_path)[0] == 0
    table = pq.read_table(tmp_path / "p.parquet").to_pydict()
    measured = synthetic_log(3.0, 1)["torque"][1]
    inside = (np.array(table["low"]) <= measured) & (measured <= np.array(table["high"]))
    assert abs(inside.mean() - 0.95) < 0.02
    assert set(table["outside"]) <= {0.0, 1.0}


def test_no_log_is_written_over_by_its_prediction(place: Path, tmp_path: Path) -> None:
    """With --force the prediction took the place of the log."""
    log = tmp_path / "log.csv"
    log.write_bytes((place / "two.csv").read_bytes())
    before = log.read_bytes()
    code, _, error = run(
        "predict", "log.csv", "--run", place / "run", "--out", "log.csv", "--force", cwd=tmp_path
    )
    assert (code, log.read_bytes()) == (2, before)
    assert "log.csv: this is one of the logs, and would be written over" in error


def test_predict_says_where_it_guesses(place: Path, tmp_path: Path) -> None:
    """It told the share of such rows alone, and score told where they lie."""
    lines = (place / "blind.csv").read_text().splitlines()
    fields = [name.strip() for name in lines[0].split(",")]
    at = next(i for i, name in enumerate(fields) if name.startswith("u"))
    cells = [line.split(",") for line in lines]
    for row in cells[1:]:
        row[at] = f"{3.0 * float(row[at]):.6g}"
    text = "\n".join(",".join(row) for row in cells)
    (tmp_path / "far.csv").write_text(text + "\n")
    code, said, _ = run(
        "predict", "far.csv", "--run", place / "run", "--out", "p.csv", cwd=tmp_path
    )
    assert code == 0
    assert re.search(r"note: outside: field above [\d.]+ V \(\d+", " ".join(said.split()))


def test_score_ranks_the_models_of_a_run_on_another_log(
    place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "120")  # a narrow screen leaves columns out
    code, said, _ = run("score", place / "two.csv", "--run", place / "run", cwd=tmp_path)
    assert code == 0
    errors = [
        float(number)
        for number in re.findall(
            r"^ [* ] m\d, (?:Bingham|Quadratic) law(?: in E)?\s+([\d.]+)", said, re.MULTILINE
        )
    ]
    assert len(errors) == 2, said
    assert errors == sorted(errors)
    assert "worst second" in said
    assert "(* recommended)" in said
    assert len(re.findall(r"^ \* m\d, ", said, re.MULTILINE)) == 1
    kept = read_run(place / "run")
    title = f"{kept.id_of(kept.recommended)}, {kept.titles[kept.recommended]}, is recommended by run: it errs by "
    words = " ".join(said.split())
    assert words.count("is recommended by") == words.count(title) == 1
    assert "on the rows that its fit held out." in words
    both = run(
        "score",
        place / "one.csv",
        place / "two.csv",
        "--run",
        place / "run",
        "--model",
        "bingham",
        cwd=tmp_path,
    )
    assert "worst log" in both[1]
    assert "Bingham law" in both[1]
    assert "Quadratic law" not in both[1]


def test_score_says_what_to_do_where_the_device_has_changed(place: Path, tmp_path: Path) -> None:
    names, *rows = (place / "two.csv").read_text().splitlines()
    effort = next(i for i, name in enumerate(names.split(",")) if name.startswith("M"))
    weaker = [row.split(",") for row in rows]
    for row in weaker:
        row[effort] = f"{0.6 * float(row[effort]):.9g}"
    (tmp_path / "worn.csv").write_text(
        "\n".join([names, *(",".join(row) for row in weaker)]) + "\n"
    )
    said = {
        log: run("score", log, "--run", place / "run", cwd=tmp_path)[1]
        for log in (place / "one.csv", "worn.csv")
    }
    assert "erclutch recalibrate" not in said[place / "one.csv"]
    command = f"recalibrate {shell_word(str(place / 'run'))} worn.csv --out NEW"
    assert f"adapt the model: erclutch {command}" in " ".join(said["worn.csv"].split())
    code, _, error = run(*shlex.split(command), cwd=tmp_path)
    assert code == 0, error


def test_score_of_several_logs_shows_which_of_them_has_changed(place: Path, tmp_path: Path) -> None:
    names, *rows = (place / "two.csv").read_text().splitlines()
    weaker = [[float(cell) for cell in row.split(",")] for row in rows]
    effort = next(i for i, name in enumerate(names.split(",")) if name.startswith("M"))
    for row in weaker:
        row[effort] *= 0.8
    lines = [",".join(f"{value:.9g}" for value in row) for row in weaker]
    (tmp_path / "weak.csv").write_text("\n".join([names, *lines]) + "\n")
    words = ("score", place / "two.csv", "weak.csv", "--run", place / "run", "--model", "bingham")
    code, said, _ = run(*words, cwd=tmp_path)
    assert code == 0
    assert "Bingham law, by log" in said
    logs = json.loads(run(*words, "--json", cwd=tmp_path)[1])["models"][0]["logs"]
    assert [log["log"] for log in logs] == ["two.csv", "weak.csv"]
    assert logs[1]["gain"] == pytest.approx(0.8 * logs[0]["gain"], rel=1e-6)
    assert logs[1]["rmse"] > logs[0]["rmse"]


def test_several_logs_give_a_folder_and_several_runs_one_table(place: Path, tmp_path: Path) -> None:
    code, said, _ = run(
        "predict", place / "several", "--run", place / "run", "--out", "p", cwd=tmp_path
    )
    assert (code, sorted(path.name for path in (tmp_path / "p").iterdir())) == (
        0,
        ["one.csv", "two.csv"],
    )
    assert said.count("3,000 rows") == 2
    shutil.copytree(place / "run", tmp_path / "sister")
    _, said, _ = run(
        "score",
        place / "two.csv",
        "--run",
        place / "run",
        "sister",
        "--model",
        "bingham",
        cwd=tmp_path,
    )
    assert "Models of 2 runs" in said
    assert "sister" in said


@pytest.mark.slow
def test_predictions_of_logs_of_one_name_have_their_folders_in_their_names(
    place: Path, tmp_path: Path
) -> None:
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
        shutil.copy(place / "two.csv", tmp_path / folder / "log.csv")
    words = ["predict", "first", "second", "--run", place / "run", "--out"]
    good(*words, "p", cwd=tmp_path)
    assert sorted(path.name for path in (tmp_path / "p").iterdir()) == [
        "first_log.csv",
        "second_log.csv",
    ]
    # Two formats of one log would be one file.
    shutil.copy(place / "two.csv", tmp_path / "first" / "log.txt")
    assert "two logs are called log" in refused("predict", "first", *words[3:], "q", cwd=tmp_path)


def test_score_says_that_a_run_was_trained_on_the_log(place: Path, tmp_path: Path) -> None:
    shutil.copy(place / "one.csv", tmp_path / "renamed.csv")
    for log, trained in ((tmp_path / "renamed.csv", True), (place / "two.csv", False)):
        code, said, _ = run(
            "score", log, "--run", place / "run", "--model", "bingham", cwd=tmp_path
        )
        assert (code, "trained on 70 % of the rows of its logs" in " ".join(said.split())) == (
            0,
            trained,
        )


def test_a_log_that_was_held_out_is_no_training_log(tmp_path: Path) -> None:
    """Several patterns follow one --test."""
    for seed, name in enumerate(("one.csv", "two.csv", "three.csv")):
        _write(tmp_path / name, seed)
    names = ("--time", "t [s]", "--field", "u [V]", "--slip", "w [rad/s]", "--effort", "M [N*m]")
    logs = ("one.csv", "two.csv", "three.csv")
    fitted = run(
        "fit",
        *logs,
        "--test",
        "tw*",
        "thr*",
        *names,
        "--models",
        "bingham",
        "--lag",
        "none",
        "--out",
        "r",
        cwd=tmp_path,
    )
    assert fitted[0] == 0, fitted[2]
    assert "held out: two.csv, three.csv" in " ".join(fitted[1].split())
    for log, trained in (("one.csv", True), ("two.csv", False), ("three.csv", False)):
        code, said, _ = run("score", log, "--run", "r", cwd=tmp_path)
        assert (code, "was trained on" in said) == (0, trained), said


def test_python_predicts_and_scores_frames_as_the_commands_do(place: Path, tmp_path: Path) -> None:
    frame = pd.read_csv(place / "two.csv")
    found = erclutch.predict(place / "run", frame.set_index(np.arange(10, 3010)), band=True)
    run("predict", place / "two.csv", "--run", place / "run", "--out", "p.csv", cwd=tmp_path)
    assert np.allclose(
        found["effort"], pd.read_csv(tmp_path / "p.csv", comment="#")["effort [N*m]"], atol=1e-8
    )
    assert found.index[0] == 10
    assert found[["low", "high"]].notna().all(axis=None)
    fast = erclutch.predict(place / "run", pd.DataFrame(frame * [1.0, 1.0, 2.0, 1.0]), band=True)
    assert 0 < fast["low"].isna().sum() < len(fast)
    assert fast["outside"][fast["low"].isna()].all()
    frame.loc[7, "u [V]"] = np.nan
    broken = erclutch.predict(place / "run", frame.drop(columns="M [N*m]"))
    assert broken["effort"].isna().to_numpy().nonzero()[0].tolist() == [7]
    assert broken["outside"][7]
    wider = erclutch.score(
        place / "run", pd.read_csv(place / "two.csv") * [1.0, 1.5, 1.0, 1.0], name="bingham"
    )
    assert wider["guessed"][0] > 0.1
    assert "field above 1826 V" in wider["where"][0]


def test_python_reads_a_log_as_the_run_did(place: Path, tmp_path: Path) -> None:
    how = (
        "--time",
        "t [s]",
        "--field",
        "u [V]",
        "--slip",
        "w [rad/s]",
        "--resample",
        "500Hz",
        "--from",
        "1s",
    )
    models = ("--effort", "M [N*m]", "--models", "bingham", "--lag", "none", "--out", "run")
    assert run("fit", place / "one.csv", *how, *models, cwd=tmp_path)[0] == 0
    run("predict", place / "two.csv", "--run", "run", "--out", "p.csv", cwd=tmp_path)
    written, found = (
        pd.read_csv(tmp_path / "p.csv", comment="#"),
        erclutch.predict(tmp_path / "run", place / "two.csv"),
    )
    assert len(written) < 1500 < 2 * len(written)
    np.testing.assert_allclose(found["effort"], written["effort [N*m]"], atol=1e-8)
    np.testing.assert_allclose(found.index, written["time [s]"], atol=1e-9)
    _, said, _ = run("score", place / "two.csv", "--run", "run", cwd=tmp_path)
    assert f"{len(written):,} rows" in said
    assert f"{erclutch.score(tmp_path / 'run', place / 'two.csv')['rmse'][0]:.4g}" in said


def _without_bands(run: Path) -> None:
    """The run as a version without bands wrote it."""
    body = json.loads((run / "run.json").read_text())
    for entry in body["ranking"]:
        file = run / entry["file"]
        model = json.loads(file.read_text())
        del entry["band"], model["band"], model["digest"]
        entry["model_digest"] = model["digest"] = digest_of(model)
        file.write_text(json.dumps(model))
    del body["digest"]
    (run / "run.json").write_text(json.dumps({**body, "digest": digest_of(body)}))


def test_a_run_without_bands_still_predicts_scores_and_is_reported(
    place: Path, tmp_path: Path
) -> None:
    shutil.copytree(place / "run", tmp_path / "old")
    _without_bands(tmp_path / "old")
    asked = ("predict", place / "two.csv", "--run", "old", "--out", "p.csv")
    code, _, error = run(*asked, "--band", cwd=tmp_path)
    assert (code, error.count("\n")) == (2, 1)
    assert "the model has no band" in error
    assert not (tmp_path / "p.csv").exists()
    assert run(*asked, cwd=tmp_path)[0] == 0
    assert "low" not in (tmp_path / "p.csv").read_text().splitlines()[1]
    assert "no band" in run("score", place / "two.csv", "--run", "old", cwd=tmp_path)[1]
    assert run("report", "old", cwd=tmp_path)[0] == 0


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("predict", "blind.csv", "--run", "run", "--out", "new.csv", "--sensor"), "M"),
        (("predict", "two.csv", "--run", "run", "--out", "two.csv"), "there is a file already"),
        (("predict", "two.csv", "--run", "run", "--out", "new.xls"), "cannot end in"),
        (
            (
                "predict",
                "two.csv",
                "--run",
                "run/models/bingham.json",
                "--model",
                "x",
                "--out",
                "n.csv",
            ),
            "of a run, and",
        ),
        (
            ("predict", "two.csv", "--run", "run", "--model", "casson", "--out", "n.csv"),
            "no model 'casson'",
        ),
        (("predict", "none.csv", "--run", "run", "--out", "n.csv"), "there is no such file"),
        (("predict", "several", "--run", "run", "--out", "n.csv"), "one file for 2 logs"),
        (("score", "blind.csv", "--run", "run"), "M"),
        (
            ("score", "two.csv", "--run", "two.csv"),
            "two.csv: no readable model: it is no JSON from line 1 on",
        ),
        (
            ("score", "two.csv", "--run", "gone"),
            "gone: no readable model: there is no such file. Check the path",
        ),
    ],
)
def test_what_cannot_be_is_one_line_and_leaves_no_file(
    place: Path, arguments: tuple[str, ...], said: str
) -> None:
    before = {path: path.stat().st_mtime_ns for path in place.iterdir()}
    code, out, error = run(*arguments, cwd=place)
    assert (code, out, error.count("\n")) == (2, "", 1), error
    assert said in error
    assert {path: path.stat().st_mtime_ns for path in place.iterdir()} == before


def test_in_python_columns_are_said_to_predict_and_score_as_to_read(place: Path) -> None:
    log, model = place / "two.csv", erclutch.read_run(place / "run").model()
    named: dict[str, Any] = {"field": "u [V]", "slip": "w [rad/s]", "effort": "M [N*m]"}
    alone = erclutch.predict(model, log, **named)
    pd.testing.assert_frame_equal(alone, erclutch.predict(model, log, named))
    part = erclutch.score(place / "run", log, begin="1s", end="2s")
    assert not np.isclose(part["rmse"][0], erclutch.score(place / "run", log)["rmse"][0], rtol=1e-6)
    with pytest.raises(erclutch.ErclutchError, match=r"Did you mean field\?"):
        erclutch.predict(model, log, feild="u [V]")


def test_a_log_that_moves_otherwise_is_told(place: Path, tmp_path: Path) -> None:
    columns = pd.read_csv(place / "two.csv")
    columns["t [s]"] *= 6.0
    columns.to_csv(tmp_path / "slow.csv", index=False)
    for command in (("score",), ("predict", "--out", tmp_path / "p.csv")):
        code, said, warned = run(
            *command, tmp_path / "slow.csv", "--run", place / "run", cwd=tmp_path
        )
        assert code == 0
        assert "slow.csv moves more slowly than every training log" in " ".join(
            (said + warned).split()
        )
    _, said, warned = run("score", place / "two.csv", "--run", place / "run", cwd=tmp_path)
    assert "than every training log" not in said + warned


def test_a_sheet_of_points_with_a_stage_is_predicted_scored_reported_and_exported(
    tmp_path: Path,
) -> None:
    speed = np.linspace(0.05, 0.6, 6)
    speed = np.tile(np.concatenate([-speed[::-1], speed]), 3)
    current = np.repeat([0.0, 0.8, 1.6], 12)
    force = 500.0 * current * np.tanh(speed / 0.03) + 500.0 * speed
    force[speed < 0.0] *= 0.6
    force += 100.0 * np.tanh(speed / 0.03) + 4.0 * np.random.default_rng(7).normal(size=speed.size)
    rows = np.column_stack([current, speed, force])
    header = "current [A],velocity [m/s],force [N]"
    np.savetxt(tmp_path / "sheet.csv", rows, delimiter=",", header=header, comments="")

    fitted = good(
        *("fit", "sheet.csv", "--time", "none", "--models", "bingham", "--out", "run"), cwd=tmp_path
    )
    assert "Its specification: bingham+sides" in fitted
    # The rows have no time, so no seconds and no rate are told of them.
    assert fitted.startswith("sheet.csv: 36 points of a table\n")
    good("predict", "sheet.csv", "--run", "run", "--band", "--out", "predicted.csv", cwd=tmp_path)
    predicted = pd.read_csv(tmp_path / "predicted.csv", comment="#")
    assert np.sqrt(np.mean((predicted["effort [N]"] - force) ** 2)) < 8.0  # twice the noise
    assert "Bingham law with two sides" in good("score", "sheet.csv", "--run", "run", cwd=tmp_path)
    good("report", "run", cwd=tmp_path)
    page = (tmp_path / "run" / "report.html").read_text("utf-8")
    assert "The stages alone (sides) take" in page
    assert "tell little of a lag" not in page
    good("export", "run", cwd=tmp_path)


def test_score_says_that_an_angle_was_drawn_out(tmp_path: Path) -> None:
    time = np.arange(3000) / 500.0
    for name, quick in (("one.csv", 2.0), ("two.csv", 3.0)):
        angle = 4.0 * np.sin(quick * time) + 3.0 * time  # rad
        speed = 4.0 * quick * np.cos(quick * time) + 3.0
        field = np.where(time < 3.0, 0.5, 1.0)
        torque = (0.2 + field) * np.tanh(speed) + 0.01 * np.sin(97.0 * time)
        columns = np.column_stack([time, field, angle % (2.0 * np.pi), torque])
        header = "t [s],I [A],q [rad],M [N*m]"
        np.savetxt(tmp_path / name, columns, delimiter=",", header=header, comments="")
    named = ("--field", "I [A]", "--position", "q [rad]", "--effort", "M [N*m]")
    models = ("--models", "bingham", "quadratic", "--lag", "none", "--out", "run")
    assert run("fit", "one.csv", *named, *models, cwd=tmp_path).code == 0
    assert "drawn out without jumps" in good("score", "two.csv", "--run", "run", cwd=tmp_path)


def test_score_and_predict_take_the_zero_of_the_run(tmp_path: Path) -> None:
    time = np.arange(3000) / 500.0
    for name, quick in (("one.csv", 4.0), ("two.csv", 5.0)):
        speed = 9.0 * np.sin(quick * time) + 2.0 * np.sin(1.3 * time)
        field = np.where(time < 3.0, 0.5, 1.0)
        torque = (0.2 + field) * np.tanh(speed / 0.5) + 0.02 * speed
        columns = np.column_stack([time, field, speed, np.round(2110.0 + 200.0 * torque)])
        header = "t [s],I [A],w [rad/s],torque"
        np.savetxt(tmp_path / name, columns, delimiter=",", header=header, comments="")
    told = ("--effort", "torque", "--scale", "effort=0.005 N*m/count", "--zero", "effort=2110")
    models = ("--models", "bingham", "--lag", "none", "--out", "run")
    assert run("fit", "one.csv", *told, *models, cwd=tmp_path).code == 0
    score = json.loads(good("score", "two.csv", "--run", "run", "--json", cwd=tmp_path))
    assert score["models"][0]["rmse"] < 0.01
    good("predict", "two.csv", "--run", "run", "--out", "p.csv", cwd=tmp_path)


def test_a_zero_for_one_signal_leaves_the_zero_of_the_run_for_another(tmp_path: Path) -> None:
    time = np.arange(3000) / 500.0
    for name, rest in (
        ("one.csv", 0.0),
        ("two.csv", 3.0),
    ):  # the second speed reads 3 rad/s at rest
        speed = 9.0 * np.sin(4.0 * time) + 2.0 * np.sin(1.3 * time)
        field = np.where(time < 3.0, 0.5, 1.0)
        torque = (0.2 + field) * np.tanh(speed / 0.5) + 0.02 * speed
        columns = [time, field, speed + rest, np.round(2110.0 + 200.0 * torque)]
        header = "t [s],I [A],w [rad/s],torque"
        rows = np.column_stack(columns)
        np.savetxt(tmp_path / name, rows, delimiter=",", header=header, comments="")
    told = ("--effort", "torque", "--scale", "effort=0.005 N*m/count", "--zero", "effort=2110")
    models = ("--models", "bingham", "--lag", "none", "--out", "run")
    assert run("fit", "one.csv", *told, *models, cwd=tmp_path).code == 0
    of_slip = ("--zero", "slip=3")
    score = json.loads(good("score", "two.csv", "--run", "run", *of_slip, "--json", cwd=tmp_path))
    assert score["models"][0]["rmse"] < 0.01
    # What is said of the same signal goes in the place of what the run says.
    anew = ("--zero", "slip=3", "--zero", "effort=2310")
    score = json.loads(good("score", "two.csv", "--run", "run", *anew, "--json", cwd=tmp_path))
    assert score["models"][0]["rmse"] == pytest.approx(1.0, rel=0.05)


def _signed(place: Path, path: Path, factor: float) -> Path:
    """The second log with its torque times a factor."""
    table = pd.read_csv(place / "two.csv")
    table["M [N*m]"] *= factor
    table.to_csv(path, index=False)
    return path


@pytest.mark.parametrize(
    ("factor", "option"),
    [(-1.0, ("--scale", "effort=-1")), (1000.0, ("--effort", "M [mN*m]"))],
)
def test_a_factor_that_explains_an_error_is_told(
    place: Path, tmp_path: Path, factor: float, option: tuple[str, str]
) -> None:
    """A torque with the other sign was told as a device that has changed."""
    log = _signed(place, tmp_path / "turned.csv", factor)
    out = " ".join(good("score", log, "--run", place / "run", cwd=tmp_path).split())
    told = re.search(r"The effort measured here is (\S+) times the estimated", out)
    assert told
    assert float(told[1]) == pytest.approx(factor, rel=0.1)
    assert "That is far more" not in out
    mended = good("score", log, "--run", place / "run", *option, cwd=tmp_path)
    assert "times the estimated" not in " ".join(mended.split())


def test_a_log_in_other_units_is_refused_with_the_options_that_settle_it(
    place: Path, tmp_path: Path
) -> None:
    table = pd.read_csv(place / "two.csv")
    table.columns = [name.partition(" [")[0] for name in table.columns]
    table.columns = ["time", "voltage", "speed", "torque"]
    table.to_csv(tmp_path / "bare.csv", index=False)
    error = refused(
        "score", "bare.csv", "--run", place / "run", *BARE, "--time", "time [s]", cwd=tmp_path
    )
    assert error.startswith("error: bare.csv: effort in units as logged")
    assert '--field "COLUMN [V]" --slip "COLUMN [rad/s]" --effort "COLUMN [N*m]"' in error
    told = ("--field", "voltage [V]", "--slip", "speed [rad/s]", "--effort", "torque [N*m]")
    good("score", "bare.csv", "--run", place / "run", *told, "--time", "time [s]", cwd=tmp_path)


BARE = ("--field", "voltage", "--slip", "speed", "--effort", "torque")


def test_a_log_unlike_the_runs_own_is_told_as_such_and_not_as_a_changed_device(
    place: Path, tmp_path: Path
) -> None:
    """The factor of a field that nobody had logged was told as a unit or an aged device."""
    table = pd.read_csv(place / "two.csv")
    table["u [V]"] *= 20.0
    table["M [N*m]"] *= 3.0
    table.to_csv(tmp_path / "strong.csv", index=False)
    out = " ".join(good("score", "strong.csv", "--run", place / "run", cwd=tmp_path).split())
    assert "fit both logs together" in out
    assert "times the estimated" not in out

"""A run folder: the same bytes again, never half of one, never over anything else, and nothing changed unnoticed."""

from __future__ import annotations

import hashlib
import json
import stat
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from erclutch.errors import RunError
from erclutch.files.given_files import file_digest
from erclutch.fit.comparison import Comparison, Settings, compare
from erclutch.logs import read
from erclutch.logs.dataset import build_dataset
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.models.load import load_model
from erclutch.models.model_file import digest_of
from erclutch.runs import written_run
from erclutch.runs.new_rows import predict
from erclutch.runs.run_folder import read_run
from erclutch.runs.written_run import write_run
from erclutch.signals.recording import Recording
from tests.support.command import good


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path = tmp_path_factory.mktemp("log") / "log.csv"
    write_synthetic_log(path, 2.0)
    return read(path)


@pytest.fixture(scope="module")
def compared(recording: Recording) -> Comparison:
    return compare(
        build_dataset(recording), Settings(models=("quadratic", "bingham/square"), lag="none")
    )


@pytest.fixture
def run(tmp_path: Path, compared: Comparison, recording: Recording) -> Path:
    return write_run(tmp_path / "run", compared, [recording], reading={"device": "single"})


def bytes_of(folder: Path) -> dict[str, str]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in files
    }


@pytest.mark.slow
def test_the_files_of_a_run(run: Path) -> None:
    assert sorted(bytes_of(run)) == [
        "models/bingham_square.json",
        "models/quadratic.json",
        "predictions.parquet",
        "run.json",
        "table.csv",
    ]
    assert stat.S_IMODE(run.stat().st_mode) == 0o755


@pytest.mark.slow
def test_the_same_log_and_settings_give_the_same_bytes(
    tmp_path: Path, recording: Recording
) -> None:
    folders = []
    for workers in (1, 2, 2):
        settings = Settings(models=("quadratic", "bingham"), workers=workers, blocks=2)
        again = compare(build_dataset(recording), settings)
        assert any(entry.name.count("+") > 1 for entry in again.entries), (
            "no law has several stages"
        )
        assert all(len(entry.folds) == 2 for entry in again.entries)
        folders.append(write_run(tmp_path / f"run{len(folders)}", again, [recording]))
    first = bytes_of(folders[0])
    assert len(first) >= 8
    assert all(bytes_of(folder) == first for folder in folders[1:])


@pytest.mark.slow
def test_a_run_reads_back(run: Path, compared: Comparison) -> None:
    back = read_run(run)
    assert back.names == tuple(e.name for e in compared.entries)
    assert back.body["best"] == compared.best
    assert back.body["recommended"] == compared.recommended
    for entry in compared.entries:
        model = back.model(entry.name)
        assert model.to_dict() == entry.outcome.model.to_dict()
        assert np.array_equal(model.predict(compared.data), entry.predicted)
    assert back.model().name == compared.recommended
    with pytest.raises(RunError, match="Choose one of"):
        back.model("hem")


@pytest.mark.slow
def test_an_id_names_a_model_of_a_run(run: Path, compared: Comparison) -> None:
    back = read_run(run)
    for place, entry in enumerate(compared.entries):
        assert back.model(f"m{place + 1}").name == back.entry(f"m{place + 1}")["name"] == entry.name
        assert (back.entry(entry.name)["id"], back.entry(entry.name)["title"]) == (
            f"m{place + 1}",
            compared.titles[entry.name],
        )
    with pytest.raises(RunError, match=r"no model 'm9'\. Choose one of m1 \("):
        back.model("m9")


def test_run_json_says_what_went_in(run: Path, compared: Comparison, recording: Recording) -> None:
    body = json.loads((run / "run.json").read_text())
    assert body["logs"][0]["sha256"] == recording.digest
    assert body["logs"][0]["rows"] == 2000
    assert body["train_rows"] + body["test_rows"] == 2000
    assert body["settings"]["models"] == ["quadratic", "bingham/square"]
    assert body["reading"] == {"device": "single"}
    assert body["units"] == {"effort": "N*m", "field": "V", "slip": "rad/s"}
    assert {"erclutch", "python", "numpy"} <= set(body["versions"])
    best = body["ranking"][0]
    assert best["test"]["rmse"] == compared.entries[0].test.rmse.to_list()


def test_the_table_holds_the_figures_to_the_last_digit(run: Path, compared: Comparison) -> None:
    header, *rows = [line.split(",") for line in (run / "table.csv").read_text().splitlines()]
    for row, entry in zip(rows, compared.entries, strict=True):
        cells = dict(zip(header, row, strict=True))
        assert cells["model"] == entry.name
        assert float(cells["test_rmse"]) == entry.test.rmse.value
        assert float(cells["test_rmse_low"]) == entry.test.rmse.low
        assert float(cells["aic"]) == entry.criteria["aic"]


def test_predictions_hold_the_rows_exactly(run: Path, compared: Comparison) -> None:
    import pyarrow.parquet as pq

    table = pq.read_table(run / "predictions.parquet")
    element = compared.data.elements[0]
    columns = {
        "field": element.field,
        "slip": element.slip,
        "effort": compared.data.effort,
        "test": compared.test,
    }
    predicted = [f"effort:{entry.name}" for entry in compared.entries]
    assert table.column_names == ["time", *columns, *predicted], (
        "one log needs no column that names it"
    )
    for name, values in columns.items():
        assert np.array_equal(table[name].to_numpy(), values)
    for entry in compared.entries:
        assert np.array_equal(table[f"effort:{entry.name}"].to_numpy(), entry.predicted)
    assert table.schema.field("slip").metadata == {b"unit": b"rad/s"}


@pytest.mark.slow
def test_rows_are_read_without_pandas(run: Path, compared: Comparison) -> None:
    """Arrow imports it in C, where a Ctrl-C is lost."""
    code = "import sys; from erclutch.runs.run_folder import read_run; from erclutch.runs.run_rows import read_rows; "
    code += f"rows = read_rows(read_run({str(run)!r})); assert 'pandas' not in sys.modules; print(rows.test.sum())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert int(done.stdout) == compared.test.sum()


@pytest.mark.slow
def test_a_column_that_holds_no_numbers_is_one_line(run: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    from erclutch.runs.run_rows import read_rows

    path, body = run / "predictions.parquet", json.loads((run / "run.json").read_text())
    table = pq.read_table(path)
    lists = pa.array([[1.0]] * table.num_rows)
    pq.write_table(table.set_column(table.column_names.index("slip"), "slip", lists), path)
    body["files"]["predictions.parquet"] = file_digest(path)
    del body["digest"]
    (run / "run.json").write_text(json.dumps({**body, "digest": digest_of(body)}))
    with pytest.raises(RunError, match=r"does not fit run\.json"):
        read_rows(read_run(run))


@pytest.mark.slow
def test_predictions_of_several_logs_name_them(tmp_path: Path, recording: Recording) -> None:
    import pyarrow.parquet as pq

    logs = [recording, replace(recording, name="other.csv", digest="of another file")]
    found = compare(build_dataset(logs), Settings(models=("bingham",), lag="none"))
    run = write_run(tmp_path / "run", found, logs)
    names = pq.read_table(run / "predictions.parquet")["log"].to_pylist()
    assert names == ["log.csv"] * 2000 + ["other.csv"] * 2000


def test_figures_that_are_not_finite_are_null(
    tmp_path: Path, compared: Comparison, recording: Recording
) -> None:
    from erclutch.fit.choice.scoring import score

    wild = score(compared.data.effort[:100], np.full(100, np.inf))
    entries = (compared.entries[0], replace(compared.entries[1], test=wild))
    run = write_run(tmp_path / "run", replace(compared, entries=entries), [recording])
    assert read_run(run).body["ranking"][1]["test"]["rmse"] == [None, None, None]


# --- never over anything ----------------------------------------------------------------------------------------------


def error_of(call: Callable[[], object]) -> str:
    with pytest.raises(RunError) as caught:
        call()
    return str(caught.value)


def test_a_run_is_not_overwritten_unless_forced(
    run: Path, compared: Comparison, recording: Recording
) -> None:
    before = bytes_of(run)
    message = error_of(lambda: write_run(run, compared, [recording]))
    assert message == f"{run}: there is a run already. Give --out another name, or --force."
    assert bytes_of(run) == before
    (run / "stale.txt").write_text("of the old run")
    write_run(run, compared, [recording], reading={"device": "other"}, force=True)
    assert "stale.txt" not in bytes_of(run)
    assert read_run(run).body["reading"] == {"device": "other"}


@pytest.mark.parametrize("force", [False, True])
@pytest.mark.parametrize("kind", ["folder", "empty folder", "file", "dangling link"])
def test_what_is_no_run_is_never_replaced(
    tmp_path: Path, compared: Comparison, recording: Recording, kind: str, force: bool
) -> None:
    target = tmp_path / "mine"
    if kind == "file":
        target.write_text("mine")
    elif kind == "dangling link":
        target.symlink_to(tmp_path / "nowhere")
    else:
        target.mkdir()
        if kind == "folder":
            (target / "thesis.tex").write_text("mine")
    message = error_of(lambda: write_run(target, compared, [recording], force=force))
    assert "mine" in message
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mine"]
    if kind == "folder":
        assert (target / "thesis.tex").read_text() == "mine"
    if kind == "file":
        assert target.read_text() == "mine"


def test_a_missing_parent_is_not_made(
    tmp_path: Path, compared: Comparison, recording: Recording
) -> None:
    message = error_of(lambda: write_run(tmp_path / "no" / "run", compared, [recording]))
    assert message.endswith(f"its parent folder does not exist. Make {tmp_path / 'no'} first.")
    assert not (tmp_path / "no").exists()


def test_a_parent_that_cannot_be_written(
    tmp_path: Path, compared: Comparison, recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    def locked(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "mkdir", locked)
    message = error_of(lambda: write_run(tmp_path / "run", compared, [recording]))
    assert "run: the run cannot be written: Permission denied. Give --out a folder" in message
    assert list(tmp_path.iterdir()) == []


# --- never half of one ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("writer", ["write_json", "write_scores", "write_predictions"])
@pytest.mark.parametrize(
    "error", [OSError(28, "No space left on device"), KeyboardInterrupt(), MemoryError()]
)
@pytest.mark.parametrize("existing", [False, True])
def test_nothing_is_left_after_a_failure_in_the_middle(
    tmp_path: Path,
    compared: Comparison,
    recording: Recording,
    monkeypatch: pytest.MonkeyPatch,
    writer: str,
    error: BaseException,
    existing: bool,
) -> None:
    target = tmp_path / "run"
    before = bytes_of(write_run(target, compared, [recording])) if existing else {}

    def full(*_: Any) -> None:
        raise error

    monkeypatch.setattr(written_run, writer, full)
    expected = RunError if isinstance(error, OSError) else type(error)
    with pytest.raises(expected) as caught:
        write_run(target, compared, [recording], reading={"new": 1}, force=existing)
    if isinstance(error, OSError):
        assert "No space left on device" in str(caught.value)
    assert [p.name for p in tmp_path.iterdir()] == (["run"] if existing else [])
    assert (bytes_of(target) if existing else {}) == before


@pytest.mark.parametrize(
    "error",
    [
        OSError(5, "Input/output error"),
        KeyboardInterrupt(),
    ],
)
def test_a_failed_move_keeps_the_old_run(
    run: Path,
    compared: Comparison,
    recording: Recording,
    monkeypatch: pytest.MonkeyPatch,
    error: BaseException,
) -> None:
    before = bytes_of(run)

    def broken(*_: Any) -> None:
        raise error

    monkeypatch.setattr("erclutch.files.places._renamed", broken)
    with pytest.raises((RunError, KeyboardInterrupt)):
        write_run(run, compared, [recording], force=True)
    assert run.exists()
    assert bytes_of(run) == before
    assert [p.name for p in run.parent.iterdir()] == ["run"]


# --- nothing changed unnoticed ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('"recommended": "', '"recommended": "x'),
        ('"train_rows": 1', '"train_rows": 2'),
        ('"rmse"', '"Rmse"'),
    ],
)
def test_an_edited_run_is_refused(run: Path, old: str, new: str) -> None:
    path = run / "run.json"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    assert (
        error_of(lambda: read_run(run))
        == f"{run}: run.json was changed after the run. Fit the log again."
    )


def test_reformatting_is_no_change(run: Path) -> None:
    path = run / "run.json"
    before, back = path.read_bytes(), read_run(run)
    path.write_text(json.dumps(json.loads(path.read_text()), sort_keys=True))
    assert path.read_bytes() != before
    assert read_run(run).body == back.body


@pytest.mark.parametrize("key", ["gains", "shape", "reference"])
def test_an_edited_model_is_refused(run: Path, key: str) -> None:
    path = run / "models" / "bingham_square.json"
    body = json.loads(path.read_text())
    name = next(iter(body[key]))
    body[key][name] *= 1.0000001
    path.write_text(json.dumps(body))
    message = error_of(lambda: read_run(run).model("bingham/square"))
    assert "the numbers do not match their digest" in message
    assert "bingham_square.json" in message


def test_an_exchanged_model_is_refused(run: Path) -> None:
    other = (run / "models" / "quadratic.json").read_bytes()
    (run / "models" / "bingham_square.json").write_bytes(other)
    error_of(lambda: read_run(run).model("bingham/square"))


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", '"run"', "\x00", '{"kind": "erclutch run"}'])
def test_what_is_no_run_is_said(tmp_path: Path, text: str) -> None:
    (tmp_path / "run.json").write_text(text)
    assert str(tmp_path) in error_of(lambda: read_run(tmp_path))


def test_the_file_of_a_model_is_the_recommended_ones_by_default(run: Path) -> None:
    read = read_run(run)
    assert load_model(read.model_file()).to_dict() == read.model().to_dict()
    assert "no model 'other'" in error_of(lambda: read.model_file("other"))


def test_no_folder_another_schema_a_missing_model(tmp_path: Path, run: Path) -> None:
    assert "not a run" in error_of(lambda: read_run(tmp_path / "nowhere"))
    assert "not a run" in error_of(lambda: read_run(tmp_path))
    (run / "models" / "quadratic.json").unlink()
    assert "no readable model" in error_of(lambda: read_run(run).model("quadratic"))
    body = json.loads((run / "run.json").read_text())
    (run / "run.json").write_text(json.dumps({**body, "schema": 99}))
    assert "schema 99, of a newer version of erclutch; this version reads schema 2" in error_of(
        lambda: read_run(run)
    )


def test_run_json_that_is_no_text(tmp_path: Path) -> None:
    (tmp_path / "run.json").write_bytes(b"\xff\xfe\x00\x80")
    assert "not a run" in error_of(lambda: read_run(tmp_path))


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_a_run_written_from_python_keeps_how_its_log_was_read(tmp_path: Path) -> None:
    """The next log with these columns needs no second word, in Python or a shell; no command claims to repeat it."""
    path = tmp_path / "plain.csv"
    write_synthetic_log(path, seconds=3.0)
    path.write_text("q0,q1,q2,q3\n" + path.read_text().split("\n", 2)[2])
    columns: dict[str, Any] = {
        "time": "q0 [s]",
        "field": "q1 [A]",
        "slip": "q2 [rad/s]",
        "effort": "q3 [N*m]",
    }
    log = read(path, **columns, begin=0.5)
    made = compare(build_dataset(log), Settings(models=("bingham",), lag="none"))
    run = read_run(write_run(tmp_path / "run", made, [log]))
    assert run.body["reading"] is None
    assert run.reading == {**columns, "begin": "0.5"}
    assert len(predict(tmp_path / "run", path)) > log.rows, "the window was of that log alone"
    assert "m1, Bingham law" in good("score", "plain.csv", "--run", "run", cwd=tmp_path)

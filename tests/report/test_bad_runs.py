"""Runs that are not what they were: one clear error, and nothing written."""

from __future__ import annotations

import json
import os
import shutil
import time
from pathlib import Path

import pytest

from erclutch.errors import RunError
from erclutch.report.numbers.run_material import material_of
from erclutch.runs.run_folder import read_run

pytestmark = pytest.mark.slow


@pytest.fixture
def run(kept_run: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(kept_run, tmp_path / "run"))


def error_of(run: Path) -> str:
    with pytest.raises(RunError) as caught:
        material_of(read_run(run))
    message = str(caught.value)
    assert message.endswith(".")
    return message


def sign(run: Path) -> None:
    """The digests made anew, as a hand does that changed the rows."""
    from erclutch.models.model_file import digest_of
    from erclutch.runs.run_folder import file_digest

    body = json.loads((run / "run.json").read_text())
    body["files"]["predictions.parquet"] = file_digest(run / "predictions.parquet")
    body["digest"] = digest_of({k: v for k, v in body.items() if k != "digest"})
    (run / "run.json").write_text(json.dumps(body))


@pytest.mark.parametrize(
    "name", ["run.json", "table.csv", "predictions.parquet", "models/bingham.json"]
)
def test_a_missing_file(run: Path, name: str) -> None:
    (run / name).unlink()
    assert name.rpartition("/")[2] in error_of(run)


@pytest.mark.parametrize("name", ["table.csv", "predictions.parquet"])
@pytest.mark.parametrize("how", ["cut", "changed", "emptied"])
def test_an_edited_file(run: Path, name: str, how: str) -> None:
    path = run / name
    content = bytearray(path.read_bytes())
    if how == "cut":
        content = content[: len(content) // 2]
    elif how == "changed":
        content[len(content) // 2] ^= 1
    else:
        content = bytearray()
    path.write_bytes(bytes(content))
    assert f"{name}: changed after the run" in error_of(run)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "most"), [("table.csv", "64 MiB"), ("predictions.parquet", "4096 MiB")]
)
def test_a_file_of_terabytes_is_refused_at_once(run: Path, name: str, most: str) -> None:
    with (run / name).open("ab") as file:
        file.truncate(1 << 42)  # on no disk: all of it is a hole
    began = time.process_time()
    assert f"{name}: cannot be read: it has more than {most}" in error_of(run)
    assert time.process_time() - began < 5.0


def test_an_edited_number_of_a_model(run: Path) -> None:
    path = run / "models" / "bingham.json"
    body = json.loads(path.read_text())
    body["gains"]["T_y"] *= 1.01
    path.write_text(json.dumps(body))
    assert "do not match their digest" in error_of(run)


def test_an_older_schema(run: Path) -> None:
    path = run / "run.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "schema": 1}))
    assert (
        "schema 1; this version reads schema 2. Fit the log again with this version."
        in error_of(run)
    )


@pytest.mark.slow
def test_predictions_of_another_run(run: Path) -> None:
    """Even with a digest that fits: the columns must."""
    import pyarrow.parquet as pq

    path = run / "predictions.parquet"
    pq.write_table(pq.read_table(path).drop_columns(["effort:bingham"]), path)
    sign(run)
    assert "does not fit run.json" in error_of(run)


@pytest.mark.parametrize("value", [float("inf"), float("nan"), 1e200])
@pytest.mark.parametrize("column", ["slip", "effort"])
def test_a_row_that_holds_no_usual_number(run: Path, column: str, value: float) -> None:
    """Even with a digest that fits: the report took roots of sums of such rows."""
    import pyarrow.parquet as pq

    path = run / "predictions.parquet"
    table = pq.read_table(path)
    values = table[column].to_numpy().copy()
    values[len(values) // 2] = value
    place = table.column_names.index(column)
    pq.write_table(table.set_column(place, column, [values]), path)
    sign(run)
    assert f"{column} is not a number up to 1e+150 in each row" in error_of(run)


@pytest.mark.parametrize(
    ("folder", "said"),
    [
        ("nowhere", "there is no such folder"),
        ("empty", "it holds no run.json"),
        ("file", "run.json lies in the folder"),
    ],
)
def test_no_run_at_all(tmp_path: Path, folder: str, said: str) -> None:
    (tmp_path / "file").write_text("x")
    (tmp_path / "empty").mkdir()
    assert f"not a run: {said}" in error_of(tmp_path / folder)


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_a_folder_that_cannot_be_written(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Permissions do not bind root, so the look is made to see none."""
    from erclutch.report.html.report_file import may_write_report

    monkeypatch.setattr("erclutch.files.os.access", lambda *_: False)
    with pytest.raises(
        RunError, match=r"its folder cannot be written\. Give --out a file in another folder"
    ):
        may_write_report(run / "report.html")


def test_a_disk_that_fills_up(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from erclutch.report.html.report_page import write_report

    material = material_of(read_run(run))
    before = sorted(p.name for p in run.iterdir())

    def full(*_: object, **__: object) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(RunError, match="No space left on device"):
        write_report(material, run / "report.html")
    assert sorted(p.name for p in run.iterdir()) == before


@pytest.mark.parametrize("value", [float("nan"), "\ud800"])
def test_what_has_no_digest_or_cannot_be_written(run: Path, value: object) -> None:
    path = run / "run.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), "notes": [value]}))
    assert "run.json" in error_of(run)


def test_a_template_that_cannot_be_filled_in_is_told(
    run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import jinja2

    from erclutch.report.html import report_page

    broken = jinja2.Environment(loader=jinja2.DictLoader({}), undefined=jinja2.StrictUndefined)
    monkeypatch.setattr(report_page, "templates", lambda *_: broken)
    with pytest.raises(RunError) as caught:
        report_page.report_html(material_of(read_run(run)))
    assert "the part verdict of the page cannot be filled in (TemplateNotFound" in str(caught.value)
    assert str(caught.value).endswith(
        "or fit again with this version if the run is of another one."
    )

"""A run.json that another hand has written, digest and all, is opened as it should be or refused in one line."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from erclutch.errors import ErclutchError, LogError, RunError
from erclutch.fit.comparison import Settings, compare
from erclutch.logs import read
from erclutch.logs.dataset import build_dataset
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.models.model_file import digest_of
from erclutch.report.html.report_page import report_html
from erclutch.report.html.runs_page import write_comparison
from erclutch.report.numbers.paired_runs import pair
from erclutch.report.numbers.run_material import material_of
from erclutch.report.printed_table import parameter_table, ranking_table
from erclutch.runs.new_rows import predict, score
from erclutch.runs.recalibrated_run import recalibrated
from erclutch.runs.run_folder import outcome_of, read_run
from erclutch.runs.run_rows import read_rows
from erclutch.runs.written_run import write_run
from tests.support.examples import examples

# `test_runs.py` reads rows in a child, as a user does.
pytestmark = pytest.mark.usefixtures("read_here")

_GONE: Any = object()
VALUES = [_GONE, None, -1, 1e9, 10**9, 10**400, "", "x", True, [], {}, float("inf")]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("log") / "log.csv"
    write_synthetic_log(path, 2.0)
    return path


@pytest.fixture(scope="module")
def run(log: Path) -> Path:
    recording = read(log)
    found = compare(
        build_dataset(recording), Settings(models=("bingham", "bingham+lag", "fnn-4"), lag="none")
    )
    reading = {
        "device": "single",
        "invalid": "drop",
        "constant": [],
        "cutoff": 100.0,
        "derivative": "lowpass",
    }
    return write_run(log.parent / "run", found, [recording], reading=reading)


@pytest.fixture(scope="module")
def recalibrated_run(run: Path, log: Path) -> Path:
    recording = read(log)
    found = recalibrated(read_run(run), build_dataset(recording), model="bingham")
    return write_run(log.parent / "again", found, [recording], reading={})


def body_of(run: Path) -> dict[str, Any]:
    return json.loads((run / "run.json").read_text())


def placed(body: dict[str, Any], folder: Path, like: Path) -> Path:
    """A run of another body, with its digest made anew."""
    body.pop("digest", None)
    text = json.dumps(
        {**body, "digest": digest_of(json.loads(json.dumps(body).replace("Infinity", "0")))}
    )
    if not folder.exists():
        folder.mkdir()
        for path in like.iterdir():
            if path.name != "run.json":
                (folder / path.name).symlink_to(path)
    (folder / "run.json").write_text(text.replace("Infinity", "1e400"))
    return folder


def places(part: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every place in a body."""
    pairs = (
        part.items()
        if isinstance(part, dict)
        else enumerate(part)
        if isinstance(part, list)
        else ()
    )
    for key, inner in pairs:
        yield (*at, key)
        yield from places(inner, (*at, key))


def change(body: dict[str, Any], place: tuple[Any, ...], value: Any) -> None:
    inner: Any = body
    for key in place[:-1]:
        inner = inner[key]
    if value is _GONE:
        del inner[place[-1]]
    else:
        inner[place[-1]] = value


def use(run: Path, beside: Path, log: Path) -> None:
    """All that is made of a run."""
    found = read_run(run)
    ranking_table(found)
    parameter_table(found, found.names[0])
    predict(found, log)
    score(found, log)
    outcome_of(found, None)
    report_html(material_of(found))
    write_comparison(pair([found, read_run(beside)]), run.parent / "comparison.html")


@pytest.mark.slow
@settings(max_examples=examples(60), deadline=None)
@given(st.data())
def test_one_change_of_run_json_is_refused_or_harmless(
    run: Path, log: Path, data: st.DataObject
) -> None:
    body = body_of(run)
    del body["digest"]
    of_a_form: dict[tuple[Any, ...], list[tuple[Any, ...]]] = {}
    for place in places(body):
        of_a_form.setdefault(
            tuple("#" if isinstance(key, int) else key for key in place), []
        ).append(place)
    place = data.draw(st.sampled_from(data.draw(st.sampled_from(list(of_a_form.values())))))
    change(body, place, data.draw(st.sampled_from(VALUES)))
    folder = placed(body, log.parent / "changed", run)
    with suppress(ErclutchError):
        use(folder, run, log)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        (
            ("ranking", 0, "test", "share"),
            _GONE,
            "ranking[0].test.share is missing, not a list of 3",
        ),
        (("ranking", 0, "test", "rmse", 1), None, "ranking[0].test.rmse is [0."),
        (
            ("ranking", 1, "train", "rmse"),
            True,
            "ranking[1].train.rmse is True, not a number with its band, or nulls",
        ),
        (
            ("ranking", 0, "fit", "parameters", 2, "value"),
            _GONE,
            "fit.parameters[2].value is missing, not a finite",
        ),
        (("ranking", 0, "fit", "weights"), 999, "ranking[0].parameters_count is "),
        (("ranking", 0, "criteria", "aic"), 10**400, "ranking[0].criteria.aic is 1000"),
        (
            ("ranking", 0, "file"),
            "../model.json",
            "ranking[0].file is '../model.json', not that of 'bingham",
        ),
        (("ranking",), 1e9, "ranking is 1000000000.0, not a list of 1 or more"),
        (("findings",), None, "findings is None, not a list"),
        (("units",), "x", "units is 'x', not an object"),
        (("units", "effort"), "N\n", "units.effort is 'N\\n', not a unit such as N*m"),
        (("device",), "x", "device is 'x', not single or coaxial"),
        (("recommended",), _GONE, "recommended is missing, not a text"),
        (("best",), "x", "best is 'x', not a model of the ranking"),
        (("files",), -1, "files is -1, not an object"),
        (("settings",), {"a": 1}, "settings.models is missing, not a list"),
        (("reading", "derivative"), "x", "reading.derivative is 'x', not central or savgol"),
        (("logs", 0, "rows"), -1, "logs[0].rows is -1, not 0 or more"),
        (("logs",), [], "logs is [], not a list of 1 or more"),
        (("logs", 0, "rows"), 10**300, "logs[0].rows is 1000"),
        (("test_rows",), 10**9, "source_rows are [[0, 2000]], not stretches that cover"),
        (("spans", 0, 0), 5, "spans are [[5, 2000, "),
        (("versions", "numpy"), 10**400, "versions.numpy is 1000"),
    ],
)
def test_the_error_names_the_place_and_what_was_expected(
    run: Path, tmp_path: Path, place: tuple[Any, ...], value: Any, said: str
) -> None:
    body = body_of(run)
    change(body, place, value)
    folder = placed(body, tmp_path / "changed", run)
    with pytest.raises(RunError) as caught:
        read_run(folder)
    assert str(caught.value).startswith(f"{folder / 'run.json'}: unfit entry: ")
    assert said in str(caught.value)
    assert str(caught.value).endswith(". Fit the log again.")


@pytest.mark.slow
def test_two_models_of_one_name_are_refused(run: Path, tmp_path: Path) -> None:
    body = body_of(run)
    body["ranking"].append(body["ranking"][0])
    with pytest.raises(RunError, match="two of them the same"):
        read_run(placed(body, tmp_path / "twice", run))


@pytest.mark.slow
def test_dynamics_that_are_not_the_models_are_refused(run: Path, tmp_path: Path) -> None:
    body = body_of(run)
    lagging = next(entry for entry in body["ranking"] if entry["name"] == "bingham+lag")
    lagging["dynamics"]["delay"] = -1.0
    with pytest.raises(RunError, match="not the model that the run wrote"):
        read_run(placed(body, tmp_path / "changed", run)).model("bingham+lag")


@pytest.mark.parametrize("other", [{"test_rows": 599, "train_rows": 1401}, {"device": "coaxial"}])
def test_rows_that_are_not_the_runs_are_refused(
    run: Path, tmp_path: Path, other: dict[str, Any]
) -> None:
    folder = placed({**body_of(run), **other}, tmp_path / "changed", run)
    with pytest.raises(RunError, match=r"predictions\.parquet: does not fit run\.json"):
        read_rows(read_run(folder))


def test_further_keys_of_a_newer_version_are_let_be(run: Path, tmp_path: Path) -> None:
    body = body_of(run)
    parts = (
        body,
        body["settings"],
        body["reading"],
        body["logs"][0],
        body["ranking"][0],
        body["ranking"][0]["fit"],
    )
    for part in (*parts, body["files"], body["units"], body["ranking"][0]["test"]):
        part["further"] = {"new": [None]}
    assert read_run(placed(body, tmp_path / "newer", run)).names


@pytest.mark.slow
@pytest.mark.usefixtures("read_here")
def test_a_recalibrated_run_opens(recalibrated_run: Path, log: Path) -> None:
    use(recalibrated_run, log.parent / "run", log)


def test_a_run_in_place_of_a_log_and_a_log_in_place_of_a_run(run: Path, log: Path) -> None:
    with pytest.raises(LogError, match=r"run: this is the folder of a run\. Give a log"):
        read(run)
    with pytest.raises(
        RunError,
        match=r"log\.csv: not a run: run\.json lies in the folder of a run, and this is a fi",
    ):
        read_run(log)

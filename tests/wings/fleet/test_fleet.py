"""A fleet: planted outliers and drifts are found; logs that fail are rows; a second start fits what is missing."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest

from erclutch.cli import main
from erclutch.cli.options import DEFAULT_READING, LogOptions
from erclutch.errors import ErclutchError, RunError, SettingError
from erclutch.fit.comparison import Settings
from erclutch.logs.reading import Reading
from erclutch.logs.synthetic import write_synthetic_log
from erclutch.report.plots.plot_description import Line
from erclutch.runs.cluster import WorkerLostError
from erclutch.wings.fleet.commands.fit_many import advice_of_logs
from erclutch.wings.fleet.fitted_fleet import Fleet
from erclutch.wings.fleet.fleet import DeviceTask, fit_device, fit_many, logs_of_devices
from erclutch.wings.fleet.fleet_charts import fleet_panels, named
from erclutch.wings.fleet.fleet_page import fleet_html, mixed, not_compared, too_few
from erclutch.wings.fleet.fleet_statistics import OUTLYING, control_chart, outlier_scores, trend
from erclutch.wings.fleet.fleet_tables import fit_row, tables_of
from tests.support.dask_cluster import dask_cluster, kill_a_worker, peak

pytestmark = pytest.mark.slow

FAST = Settings(lag="none")
MODELS = ("quadratic",)


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fleet") / "logs"
    folder.mkdir()
    for i in range(5):
        write_synthetic_log(folder / f"unit{2 * i + 1}.csv", 1.0, i)
    (folder / "unit20.csv").write_text("")
    return folder


@pytest.fixture(scope="module")
def fleet(logs: Path) -> Fleet:
    return fit_many(logs, MODELS, out=logs.parent / "run", settings=FAST)


def rows_of(fleet: Fleet, table: str) -> Any:
    import pyarrow.parquet as pq

    read: Any = pq.read_table
    return read(fleet.folder / f"{table}.parquet").to_pylist()


def test_statistics_find_what_was_planted() -> None:
    noise = np.random.default_rng(1).normal(0.0, 1.0, 60)
    x = np.arange(60.0)
    planted = 10.0 + noise
    planted[17] += 15.0
    score = outlier_scores(planted, planted - 1.96, planted + 1.96)
    assert np.flatnonzero(np.abs(score) > OUTLYING).tolist() == [17]
    wide = outlier_scores(planted, planted - 30.0, planted + 30.0)
    assert np.abs(wide).max() < OUTLYING, "an interval as wide as the distance explains it"
    found, none = trend(x, 0.1 * x + noise), trend(x, noise)
    assert found is not None
    assert none is not None
    assert found.low < 0.1 < found.high
    assert found.chance < 1e-6
    assert none.chance > 0.01
    chart = control_chart(np.where(x < 40, noise, noise + 12.0), 40)
    assert chart is not None
    assert chart.out[40:].all()
    assert chart.out[:40].sum() <= 1
    assert outlier_scores(np.ones(6), np.ones(6), np.ones(6)).tolist() == [0.0] * 6
    assert trend(x[:4], x[:4]) is None


def test_a_failed_log_is_a_row(fleet: Fleet) -> None:
    assert list(fleet.failed) == ["unit20.csv"]
    assert "empty" in fleet.failed["unit20.csv"]
    fits = rows_of(fleet, "fits")
    assert [row["device"] for row in fits] == [f"unit{n}.csv" for n in (1, 3, 5, 7, 9, 20)]
    rows = rows_of(fleet, "parameters")
    assert {row["parameter"] for row in rows} >= {"T_y", "eta", "rmse"}
    assert all(
        row["low"] <= row["value"] <= row["high"] for row in rows if row["parameter"] == "T_y"
    )


def test_a_second_start_fits_what_is_missing(fleet: Fleet, logs: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(fleet.folder, tmp_path / "run")
    done = sorted((copy / "devices").iterdir())
    done[0].unlink()
    done[1].write_text(done[1].read_text()[:-9])
    seen: list[str] = []
    again = fit_many(
        logs,
        MODELS,
        out=copy,
        settings=FAST,
        workers=1,
        progress=lambda n, of, name: seen.append(name),
    )
    assert (len(seen), again.taken, again.digest) == (2, 4, fleet.digest)
    with pytest.raises(RunError, match="other settings"):
        fit_many(logs, MODELS, out=copy, settings=Settings(lag="none", seed=1))


def test_what_was_changed_in_a_fleet_is_fitted_again(
    fleet: Fleet, logs: Path, tmp_path: Path
) -> None:
    """A number that was changed went into the tables in silence; an entry of another kind ended in a traceback."""
    copy = shutil.copytree(fleet.folder, tmp_path / "run")
    number, kind, *_ = sorted((copy / "devices").iterdir())
    body = json.loads(number.read_text())
    body["run"]["ranking"][0]["test"]["rmse"][0] *= 3.0
    number.write_text(json.dumps(body))
    kind.write_text(kind.read_text().replace('"logs": [', '"logs": 5, "others": [', 1))
    again = fit_many(logs, MODELS, out=copy, settings=FAST, workers=1)
    assert (again.taken, again.digest) == (4, fleet.digest)


def test_a_changed_log_is_fitted_again(fleet: Fleet, logs: Path, tmp_path: Path) -> None:
    copy, changed = (
        shutil.copytree(fleet.folder, tmp_path / "run"),
        shutil.copytree(logs, tmp_path / "logs"),
    )
    write_synthetic_log(changed / "unit3.csv", 1.0, 77)
    again = fit_many(changed, MODELS, out=copy, settings=FAST)
    assert again.taken == 5
    assert again.digest != fleet.digest


def test_a_changed_mapping_beside_the_logs_fits_them_again(logs: Path, tmp_path: Path) -> None:
    (tmp_path / "logs").mkdir()
    shutil.copy(logs / "unit1.csv", tmp_path / "logs")
    mapping = tmp_path / "logs" / "erclutch.toml"
    mapping.write_text("this is no mapping\n")
    assert fit_many(tmp_path / "logs", MODELS, out=tmp_path / "run", settings=FAST).failed
    mapping.write_text("[columns]\n")
    again = fit_many(tmp_path / "logs", MODELS, out=tmp_path / "run", settings=FAST)
    assert (again.taken, again.failed) == (0, {})


def test_logs_of_a_folder_are_one_device(logs: Path, tmp_path: Path) -> None:
    for name, log in (("b/1.csv", "unit1.csv"), ("b/2.csv", "unit3.csv"), ("a/1.csv", "unit5.csv")):
        (tmp_path / "logs" / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(logs / log, tmp_path / "logs" / name)
    found = fit_many(tmp_path / "logs", MODELS, out=tmp_path / "run", settings=FAST, by="folder")
    assert [(row["device"], row["logs"]) for row in found.fits] == [
        ("a", "1.csv"),
        ("b", "1.csv; 2.csv"),
    ]


def test_a_folder_with_logs_of_two_devices_is_warned_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "logs" / "unit"
    folder.mkdir(parents=True)
    time = np.arange(1500) / 250
    current = np.repeat([0.0, 1.0, 0.5, 1.5, 2.0], 300)
    slip = 12.0 * np.sin(5.0 * time)
    torque = (0.2 + 1.5 * current) * np.tanh(slip / 0.3)
    for device, times in (("a", 1.0), ("b", 3.0)):
        rows = np.column_stack([time, slip, current, times * torque])
        head = "t [s],w [rad/s],I [A],T [Nm]"
        np.savetxt(folder / f"{device}.csv", rows, "%.6g", ",", header=head, comments="")
    words = ["--by", "folder", "--models", *MODELS, "--lag", "none", "--out", str(tmp_path / "run")]
    main(["fit-many", str(tmp_path / "logs"), *words])
    said = " ".join(capsys.readouterr().out.split())
    assert "at the same field and slip b.csv has 3 times the effort of a.csv" in said
    assert said.endswith("erclutch fit says why, log by log.")


def test_a_folder_of_folders_has_no_advice_and_ends_no_fit(tmp_path: Path) -> None:
    for name in ("0A", "1A"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "log.csv").write_text("t,c\n0,1\n1,2\n")
    assert advice_of_logs((tmp_path,), DEFAULT_READING) == []


def test_folders_of_one_name_below_different_ones_are_told_apart(
    logs: Path, tmp_path: Path
) -> None:
    for place in ("one/logs", "two/logs"):
        (tmp_path / place).mkdir(parents=True)
        shutil.copy(logs / "unit20.csv", tmp_path / place / "1.csv")  # empty: a row with the reason
    found = fit_many(
        [tmp_path / "one", tmp_path / "two"], MODELS, out=tmp_path / "run", settings=FAST
    )
    assert [row["device"] for row in found.fits] == ["one/logs/1.csv", "two/logs/1.csv"]


@pytest.mark.slow
def test_what_cannot_be_is_said(logs: Path, tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    with pytest.raises(ErclutchError, match="exists and is not a fleet"):
        fit_many(logs, MODELS, out=tmp_path / "other", settings=FAST)
    with pytest.raises(SettingError, match="--name-pattern"):
        fit_many(logs, MODELS, out=tmp_path / "run", settings=FAST, by="serial")
    with pytest.raises(SettingError, match="no log"):
        fit_many(tmp_path / "other", MODELS, out=tmp_path / "run", settings=FAST)
    assert not (tmp_path / "run").exists()


def test_the_command_writes_a_report(
    logs: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    words = [
        "fit-many",
        str(logs),
        "--models",
        "quadratic",
        "--lag",
        "none",
        "--out",
        str(tmp_path / "run"),
    ]
    assert main(words) == 0
    said = capsys.readouterr().out
    assert "SYNTHETIC" in said
    assert f"table digest {json.loads((tmp_path / 'run/fleet.json').read_text())['digest']}" in said
    page = (tmp_path / "run/report.html").read_text()
    assert "5 of 6 were fitted" in page
    assert "unit20.csv" in page


def test_a_fleet_of_too_few_devices_says_why_its_columns_are_empty(fleet: Fleet) -> None:
    assert too_few(fleet.stands_for) == ""
    start = "Trends, limits and what stands out need 5 devices with this model; "
    for count, have in ((3, "3 devices have it."), (1, "1 device has it.")):
        few = [replace(series, devices=series.devices[:count]) for series in fleet.stands_for]
        assert too_few(few) == start + have
    assert too_few([]) == ""


@pytest.mark.slow
def test_a_fleet_is_drawn_in_a_notebook(fleet: Fleet) -> None:
    """It ended in a KeyError: matplotlib had no look for the intervals."""
    assert len(fleet.plot()) == len(fleet.stands_for)


def test_a_fleet_of_measured_and_computed_logs_is_called_mixed(fleet: Fleet) -> None:
    for origins, badge in ((("", "TWIN"), "MIXED"), (("",), "RECORDING"), (("TWIN",), "TWIN")):
        page = fleet_html(replace(fleet, origins=origins))
        shown = re.search(r'class="badge[^"]*"[^>]*>\s*(\w+)', page)
        assert shown is not None
        assert shown[1] == badge


@pytest.mark.slow
def test_a_page_says_where_no_model_stands_for_the_fleet(fleet: Fleet) -> None:
    """It said of none that it is recommended most often."""
    often = "It is the model recommended most often"
    none = "Of no log or device a model is recommended"
    pages = fleet_html(fleet), fleet_html(replace(fleet, model=None))
    assert [(often in page, none in page) for page in pages] == [(True, False), (False, True)]


def test_names_of_devices_are_cut_and_turn_no_line_round() -> None:
    """The letters behind a mark from right to left stood in the other order."""
    assert named(("\u202ex", "b", "W" * 200)) == f"\\u202ex, b, {'W' * 60}…"
    assert named(tuple("abcdefgh")) == "a, b, c, d, e, f and 2 more"
    assert named(()) == "–"


@pytest.mark.slow
def test_a_chart_holds_its_intervals_and_names_what_it_shows(fleet: Fleet) -> None:
    few = replace(fleet, series=tuple(replace(s, chart=None) for s in fleet.series))
    for panel in fleet_panels(fleet.stands_for, fleet.over):
        # These logs reach 818 to 1952 V: their yield efforts are of other fields, and too few are left for limits.
        assert ("Grey" in panel.caption) is not panel.caption.startswith("T_y")
    for panel in fleet_panels(few.stands_for, few.over):
        assert "Grey" not in panel.caption
        assert panel.x.whole
        bars = next(m for m in panel.marks if isinstance(m, Line)).y
        assert panel.y.low is not None
        assert panel.y.high is not None
        assert panel.y.low < np.nanmin(bars) < np.nanmax(bars) < panel.y.high
        assert 1e-2 < np.nanmax(np.abs(bars)) < 1e5


def test_a_scheduler_that_is_killed_ends_in_one_line_and_the_rest_is_fitted_later(
    fleet: Fleet, logs: Path, tmp_path: Path
) -> None:
    out = tmp_path / "d"
    with dask_cluster(tmp_path, 1) as (address, scheduler):

        def kill(done: int, total: int, name: str) -> None:
            if done == 2:
                os.kill(scheduler, signal.SIGKILL)

        with pytest.raises(WorkerLostError) as caught:
            fit_many(logs, MODELS, out=out, settings=FAST, cluster=address, progress=kill)
    made = fit_many(logs, MODELS, out=out, settings=FAST)
    said = f"the cluster went away; {made.taken} of 6 logs are done and kept in {out}."
    assert str(caught.value) == f"{said} Start the cluster again, then the same command."
    assert made.taken >= 2
    assert made.digest == fleet.digest


def test_the_same_tables_on_processes_and_on_dask(fleet: Fleet, logs: Path, tmp_path: Path) -> None:
    """A real scheduler and real workers; one is killed with -9 on the way."""
    made = fit_many(logs, MODELS, out=tmp_path / "p", settings=FAST, cluster="processes")
    assert made.digest == fleet.digest
    with dask_cluster(tmp_path, 2) as (address, scheduler):

        def kill(done: int, total: int, name: str) -> None:
            if done == 1:
                kill_a_worker(address)

        made = fit_many(
            logs, MODELS, out=tmp_path / "d", settings=FAST, cluster=address, progress=kill
        )
        assert peak(scheduler) < 200.0
        assert os.path.exists(f"/proc/{scheduler}"), "a cluster that was running goes on"
    assert made.digest == fleet.digest


def test_a_fleet_takes_the_window_and_the_rate_that_were_given(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    write_synthetic_log(log, 1.0)
    window = LogOptions(begin="200ms", end="0.7", resample="500 Hz")
    (direct,) = window.read([log])
    assert direct.period == pytest.approx(2e-3)
    task = DeviceTask(
        "log", (str(log),), Settings(("quadratic",), lag="none"), window.how(), "single"
    )
    found = fit_device(task)["run"]["logs"][0]
    assert (found["rows"], found["period_s"]) == (direct.rows, direct.period)


@pytest.mark.parametrize(("low", "recommended"), [(0.9, True), (-0.1, False)])
def test_a_log_that_no_model_explains_recommends_none(low: float, recommended: bool) -> None:
    figures = {"rmse": [1.0, 0.9, 1.1], "share": [0.3, 0.2, 0.4], "r2": [0.91, low, 0.95]}
    entry = {
        "name": "bingham",
        "sound": True,
        "test": figures,
        "train": figures,
        "parameters_count": 5,
        "notes": [],
    }
    run = {
        "ranking": [entry],
        "recommended": "bingham",
        "findings": [],
        "train_rows": 7,
        "test_rows": 3,
    }
    assert fit_row({**run, "units": {"effort": "N*m"}}, entry)["recommended"] is recommended


def test_devices_whose_names_differ_by_a_leading_zero_keep_all_of_their_logs() -> None:
    """Their logs stand between each other in the order of numbers: the last ones took the place of the others."""
    top = Path("logs").resolve()
    files = [top / "01" / "a.csv", top / "1" / "b.csv", top / "01" / "c.csv"]
    grouped = logs_of_devices(files, "folder", Reading())
    assert grouped == {"01": (str(files[0]), str(files[2])), "1": (str(files[1]),)}


def body_of(device: str, values: dict[str, float], failed: str) -> dict[str, object]:
    return {"device": device, "logs": [device], "modified": 0.0, "values": values, "failed": failed}


def test_a_number_of_the_name_that_is_called_as_a_column_keeps_the_column(tmp_path: Path) -> None:
    bodies = [
        body_of("B01.csv", {"device": 1.0, "week": 4.0}, "no slip"),
        body_of("B01_repeat.csv", {}, "no match"),
    ]
    tables_of(bodies, "week", 0).write(tmp_path)
    fits = pq.read_table(tmp_path / "fits.parquet").to_pydict()
    assert fits["device"] == ["B01.csv", "B01_repeat.csv"]
    assert fits["device in name"] == [1.0, None]


def test_a_yield_effort_at_another_field_is_not_compared() -> None:
    """Seven logs reach 1.2 A and one stays at 0.9 A: its yield effort is smaller, and the device is the same."""
    bodies: list[dict[str, Any]] = []
    for week in range(8):
        shorter = week == 4
        effort = (3.9 if shorter else 4.7) + 0.01 * (week % 3)
        number = {
            "name": "T_y",
            "meaning": "yield effort at the reference field",
            "value": effort,
            "at_bound": None,
        }
        viscous = {
            "name": "eta",
            "meaning": "viscous effort per slip",
            "value": 0.02 + 1e-4 * (week % 3),
            "at_bound": None,
        }
        fit: dict[str, Any] = {"parameters": [], "converged": True}
        for each, unit in ((number, "N*m"), (viscous, "N*m/(rad/s)")):
            fit["parameters"].append(
                {**each, "low": 0.99 * each["value"], "high": 1.01 * each["value"], "unit": unit}
            )
        figures = {"rmse": [0.1, 0.09, 0.11], "share": [0.1, 0.09, 0.11], "r2": [0.99, 0.98, 1.0]}
        model = {
            "name": "bingham",
            "sound": True,
            "test": figures,
            "train": figures,
            "parameters_count": 2,
        }
        model |= {"notes": [], "fit": fit}
        run = {
            "ranking": [model],
            "recommended": "bingham",
            "best": "bingham",
            "findings": [],
            "train_rows": 9,
        }
        run |= {"test_rows": 4, "units": {"effort": "N*m"}}
        body = body_of(f"W{week}", {}, "")
        bodies.append({**body, "run": run, "reference_field": 0.9 if shorter else 1.2})
    tables = tables_of(bodies, "name", 0)
    of_yield, of_viscosity, *_ = tables.series
    assert of_yield.outliers == ()
    assert of_yield.apart == {"W4": 0.9}
    assert len(of_yield.devices) == 7
    assert len(of_viscosity.devices) == 8
    # A law carries the number to a field that is near, here from 1.1 A to 1.2 A.
    bodies[4] |= {"reference_field": 1.1, "field_exponents": {"bingham": 1.0}}
    carried = tables_of(bodies, "name", 0).series[0]
    assert carried.apart == {}
    assert carried.value[4] == pytest.approx(3.91 * 1.2 / 1.1)
    assert not_compared(tables.series).endswith("with another field: W4 (0.9).")


def test_several_devices_in_one_trend_are_told(fleet: Fleet) -> None:
    series = fleet.stands_for[0]
    weeks = np.repeat(np.arange(6.0), 3)
    three = replace(series, x=weeks)
    assert mixed([three], "week").startswith(
        "3 logs stand at one week: a trend over several devices hides the drift"
    )
    alone = replace(
        series, x=np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0])
    )  # one week was measured twice
    assert mixed([alone], "week") == mixed([], "week") == ""


def test_a_pattern_that_no_name_matches_is_told_as_the_reason() -> None:
    bodies = [
        body_of(
            "B01.csv", {}, "B01.csv: the file's name does not match the pattern '{device}_{week}'"
        )
    ]
    with pytest.raises(
        SettingError, match=r"no log has a number 'week'; .* does not match the pattern"
    ):
        tables_of(bodies, "week", 0)

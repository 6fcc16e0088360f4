"""Many logs, the same models: each log or device is fitted by itself, and all parameters stand in one table.

::

    fleet.json           settings, versions, and the digest of the tables
    devices/NAME.json    what came out of one log or device; a second start takes it where the log is the same
    parameters.parquet   a row for each parameter of each model of each device
    fits.parquet         a row for each model of each device; a device that failed has a row with the reason
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from erclutch.errors import ErclutchError, RunError, SettingError
from erclutch.files import file_digest, may_write, whole_file
from erclutch.files.places import nothing, release, reserve
from erclutch.fit.comparison import Settings, compare
from erclutch.logs import ColumnMap
from erclutch.logs.dataset import build_dataset
from erclutch.logs.log_reader import log_suffixes
from erclutch.logs.mapping import file_beside
from erclutch.logs.name_pattern import constants_of
from erclutch.logs.reading import Reading
from erclutch.runs.cluster import finished, saying_kept, task_pool
from erclutch.runs.run_folder import run_to_dict, unwritable, versions, write_json
from erclutch.signals.device import DeviceName
from erclutch.signals.shown import Shown, one_line
from erclutch.wings.fleet.fleet_statistics import OUTLYING, RMSE, FleetSeries, control_chart, outlier_scores, trend

if TYPE_CHECKING:
    from erclutch.report.notebook import Card

MARKER = "fleet.json"
_DEVICES = "devices"

#: Called with the devices done, those there are, and the device that was just done.
FleetProgress = Callable[[int, int, str], None]
Rows = list[dict[str, Any]]


@dataclass(frozen=True)
class DeviceTask:
    """One fit of a fleet: small, so that it can be sent.

    Attributes:
        name: of the device or log.
        paths: its logs.
        settings: of the comparison.
        reading: how logs are read.
        device: "single" or "coaxial".
    """

    name: str
    paths: tuple[str, ...]
    settings: Settings
    reading: Reading
    device: DeviceName


@dataclass(frozen=True, repr=False)
class Fleet(Shown):
    """What came out.

    Attributes:
        folder: where it is kept.
        parameters, fits: rows of the tables.
        series: each number of each model over the devices.
        model: the model that is recommended most often.
        digest: SHA-256 of the rows of both tables, sorted.
        taken: devices that were done by an earlier start.
        over: what the devices are ordered by.
        origins: labels of logs that a computer made, such as TWIN.
    """

    folder: Path
    parameters: Rows
    fits: Rows
    series: tuple[FleetSeries, ...]
    model: str | None
    digest: str
    taken: int
    over: str
    origins: tuple[str, ...]

    def __repr__(self) -> str:
        most = f"most often {self.model or 'no model'}"
        return one_line(self, self.folder.name, f"{self.devices} devices", f"{len(self.failed)} failed", most)

    def notebook_card(self) -> Card:
        """What a notebook shows: the fits of the model that is recommended most often, and who stands out."""
        from erclutch.report.notebook import Card, as_frame, badge_of_origins, rows_as_frame
        from erclutch.report.plots.plot_description import Plot, PlotTable
        from erclutch.wings.fleet.fleet_charts import fleet_panels, named

        out = sorted({device for series in self.stands_for for device in series.outliers})
        says = [f"Stands out: {named(tuple(out))}."] if out else []
        says += [f"{device} failed: {why}" for device, why in list(self.failed.items())[:3]]
        header = ("device", "model", "parameters", "rmse", "rmse_low", "rmse_high", "effort_unit", "share")
        fits = [row for row in self.fits if row["model"] == self.model and not row["failed"]]
        names = dict.fromkeys(key for row in self.parameters for key in row)

        def charts() -> Plot:
            panels = fleet_panels(self.stands_for, self.over)
            return Plot(panels, PlotTable((), ()), 0.5 + 1.4 * len(panels))

        return Card(
            self.folder.name,
            lambda: rows_as_frame(header, [[row.get(key) for key in header] for row in fits]),
            badge=badge_of_origins(self.origins),
            says=lambda: says,
            frame=lambda: as_frame({key: [row.get(key) for row in self.parameters] for key in names}),
            plots={"charts": charts},
        )

    @property
    def stands_for(self) -> tuple[FleetSeries, ...]:
        """Numbers of the model that stands for the fleet."""
        return tuple(series for series in self.series if series.model == self.model)

    @property
    def failed(self) -> dict[str, str]:
        """Devices that were not fitted, with the reasons."""
        kept = {row["device"]: str(row["failed"]) for row in self.fits if row["failed"]}
        return {device: why.removeprefix(f"{device}: ") for device, why in kept.items()}

    @property
    def devices(self) -> int:
        """All devices, those that failed too."""
        return len({row["device"] for row in self.fits})


_Made = tuple[Rows, Rows, tuple[FleetSeries, ...], str | None, str]


def fit_many(
    logs: Sequence[str | Path] | str | Path,
    models: Sequence[str] = ("all",),
    *,
    out: str | Path,
    device: DeviceName = "single",
    reading: Reading | None = None,
    settings: Settings | None = None,
    by: str = "log",
    over: str = "name",
    baseline: int = 0,
    cluster: str | None = None,
    workers: int = 2,
    force: bool = False,
    progress: FleetProgress = lambda done, total, name: None,
) -> Fleet:
    """Fit the same models to each of many logs or devices. The folder is this call's alone until it returns.

    Args:
        logs: log files; a folder stands for the logs in it and in the folders below.
        models: as for `compare`.
        out: folder of the results. Where it holds a fleet of the same settings, only what is missing is fitted.
        device: "single" or "coaxial".
        reading: columns, units and filters.
        settings: further settings of each comparison; its models are ``models``.
        by: "log", each log by itself; "folder", the logs of a folder are one device; or a field of the name pattern.
        over: order of the devices: "name", "mtime" (time of the file) or a field of the name pattern.
        baseline: how many of the first devices give the limits of the control charts; 0 for all.
        cluster: see `erclutch.runs.cluster.task_pool`; changes no figure.
        workers: threads or processes side by side; changes no figure.
        force: begin anew where there is a fleet of other settings.
        progress: called after each device.

    Raises:
        SettingError: no log, a model or a cluster that cannot be.
        RunError: the folder holds something else, or cannot be written.
        WorkerLostError: the cluster went away; what is done is kept.
    """
    folder, how = Path(out), reading or Reading()
    asked = replace(settings or Settings(), models=tuple(models), workers=1)
    files = _logs_of([logs] if isinstance(logs, str | Path) else logs)
    tasks = [DeviceTask(name, paths, asked, how, device) for name, paths in _grouped(files, by, how).items()]
    body = {"settings": asked.to_dict(), "reading": repr(how), "device": device, "by": by, "versions": versions()}
    _begin(folder, body, force)
    try:
        return _fill(folder, tasks, body, over, baseline, (cluster, workers), progress)
    finally:
        release(folder)


def _fill(
    folder: Path,
    tasks: Sequence[DeviceTask],
    body: Mapping[str, Any],
    over: str,
    baseline: int,
    where: tuple[str | None, int],
    progress: FleetProgress,
) -> Fleet:
    """Fit what an earlier start did not finish, and write the tables of all; ``where`` tasks run: cluster, workers."""
    found = {task.name: kept for task in tasks if (kept := _kept(folder, task)) is not None}
    taken, left = len(found), [task for task in tasks if task.name not in found]
    if left:
        with saying_kept(found, len(tasks), f"logs are done and kept in {folder}"), task_pool(*where) as pool:
            for index, result in finished(pool, fit_device, left):
                task = left[index]
                if isinstance(result, Exception):  # its process died: it is tried again at the next start
                    result = _failed(task, str(result))
                else:
                    _write(_file(folder, task.name), result)
                found[task.name] = result
                progress(len(found), len(tasks), task.name)
    made = _tables([found[task.name] for task in tasks], over, baseline)
    _write_tables(folder, body, made)
    origins = {log["origin"] for each in found.values() for log in each.get("run", {}).get("logs", ())} - {"", None}
    return Fleet(folder, *made, taken, over, tuple(sorted(origins)))


def fit_device(task: DeviceTask) -> dict[str, Any]:
    """Fit one device: what `erclutch fit --json` prints, or why not, as JSON values."""
    how = task.reading
    body = _failed(task, "")
    try:
        body |= {
            "sha256": _digests(task),
            "modified": min(Path(path).stat().st_mtime for path in task.paths),
        }
        recordings = [log for path in task.paths for log in how.read(path, task.device)]
        data = build_dataset(recordings, device=task.device, derivative=how.derivative)
        values = dict(recordings[0].constants)
        return body | {"values": values, "run": run_to_dict(compare(data, task.settings), recordings, None)}
    except (ErclutchError, OSError) as error:
        return body | {"failed": str(error)}
    except Exception as error:  # a failed log is a row, whatever failed
        return body | {"failed": f"unforeseen {type(error).__name__}: {error}"}


def _digests(task: DeviceTask) -> list[str]:
    """Of the logs, and of the mapping files beside them."""
    logs = [Path(path) for path in task.paths]
    return [file_digest(path) for path in (*logs, *filter(None, map(file_beside, logs)))]


def _failed(task: DeviceTask, reason: str) -> dict[str, Any]:
    names, none = [Path(path).name for path in task.paths], dict[str, float]()
    return {"device": task.name, "logs": names, "sha256": [], "values": none, "modified": 0.0, "failed": reason}


# --- what is fitted, and what is kept -----------------------------------------------------------------------------


def _logs_of(paths: Sequence[str | Path]) -> list[Path]:
    found: list[Path] = []
    for path in map(Path, paths):
        inside = sorted(p for p in path.rglob("*") if p.suffix.lower() in log_suffixes() and p.is_file())
        found += inside if path.is_dir() else [path]
    if not found:
        raise SettingError("there is no log", remedy=f"Give logs; they end in {', '.join(log_suffixes())}")
    return list(dict.fromkeys(p.resolve() for p in found))


def _grouped(files: Sequence[Path], by: str, how: Reading) -> dict[str, tuple[str, ...]]:
    """The logs of each device by its name, in order."""
    top = os.path.commonpath([path.parent for path in files])
    if by == "log":
        names = [path.relative_to(top).as_posix() for path in files]
    elif by == "folder":
        names = [path.parent.relative_to(top).as_posix() for path in files]
    else:
        pattern = how.mapping.name_pattern if isinstance(how.mapping, ColumnMap) else None
        if pattern is None or f"{{{by}" not in pattern:
            remedy = f"Give --name-pattern with {{{by}}} in it, or --by log, or --by folder"
            raise SettingError(f"--by {by} is no field of the name pattern", remedy=remedy)
        names = [f"{by} {constants_of(pattern, path.name)[by][0]:g}" for path in files]
    pairs = sorted(zip(names, map(str, files), strict=True), key=lambda pair: _natural(pair[0]) + _natural(pair[1]))
    return {name: tuple(path for _, path in group) for name, group in groupby(pairs, key=lambda pair: pair[0])}


def _natural(name: str) -> list[tuple[int, str]]:
    """Unit 9 stands before unit 10."""
    return [(int(word), "") if word.isdecimal() else (0, word) for word in re.split(r"(\d+)", name)]


def _begin(folder: Path, body: Mapping[str, Any], force: bool) -> None:
    reserve(folder, nothing)
    known: Any = None
    if (folder / MARKER).is_file():
        try:
            known = json.loads((folder / MARKER).read_text(encoding="utf-8"))
        except ValueError as error:
            if not force:
                raise RunError(f"{MARKER}: {error}", where=str(folder), remedy="Give --force to begin anew") from error
    else:
        may_write(folder, False, MARKER)
    if isinstance(known, dict):
        held = cast(dict[str, Any], known)
        other = [key for key in body if held.get(key) != json.loads(json.dumps(body[key]))]
        if other and not force:
            problem = f"there is a fleet of other {' and '.join(other)}"
            raise RunError(problem, where=str(folder), remedy="Give the same, --out another name, or --force")
        if not force:
            return
    try:
        if force:
            shutil.rmtree(folder / _DEVICES, ignore_errors=True)
        (folder / _DEVICES).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(folder, error) from error
    _write(folder / MARKER, body)


def _write(path: Path, body: Mapping[str, Any]) -> None:
    with whole_file(path, unwritable) as partial:
        write_json(partial, body)


def _file(folder: Path, name: str) -> Path:
    plain = re.sub(r"[^A-Za-z0-9._-]+", "_", name)[:80]
    return folder / _DEVICES / f"{plain}-{hashlib.sha256(name.encode()).hexdigest()[:8]}.json"


def _kept(folder: Path, task: DeviceTask) -> dict[str, Any] | None:
    """What an earlier start found, if it is whole, and the logs and the mappings beside them are the same."""
    try:
        body = json.loads(_file(folder, task.name).read_text(encoding="utf-8"))
        same = body["device"] == task.name and body["sha256"] == _digests(task)
        return body if same and not str(body["failed"]).startswith("unforeseen") else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


# --- tables -------------------------------------------------------------------------------------------------------


def _tables(found: Sequence[Mapping[str, Any]], over: str, baseline: int) -> _Made:
    """Rows of both tables, the series, the model to show, the digest."""
    places = _places(found, over)
    fits: Rows = []
    parameters: Rows = []
    for place, body in zip(places, found, strict=True):
        same = {"device": body["device"], "order": place}
        when = datetime.fromtimestamp(body["modified"], UTC).isoformat(timespec="seconds")
        about = same | {"logs": "; ".join(body["logs"]), "modified": when, **body["values"]}
        for entry in body["run"]["ranking"] if "run" in body else [None]:
            row = _fit_row(body.get("run", {}), entry)
            fits.append(about | row | {"failed": body["failed"]})
            numbers = [] if entry is None else [*entry["fit"]["parameters"], _error_of(row)]
            keys = ("value", "low", "high", "at_bound", "unit")
            parameters += [
                same
                | {"model": row["model"], "recommended": row["recommended"], "parameter": number["name"]}
                | {key: number[key] for key in keys}
                | {"rmse": row["rmse"], "warnings": row["notes"]}
                for number in numbers
            ]
    series = _series(parameters, baseline)
    named = [row["model"] for row in fits if row["recommended"]]
    model = max(sorted(set(named)), key=named.count, default=None)
    lines = sorted(json.dumps(row, sort_keys=True) for row in fits + parameters)
    return parameters, fits, series, model, hashlib.sha256("\n".join(lines).encode()).hexdigest()


def _places(found: Sequence[Mapping[str, Any]], over: str) -> list[float]:
    if over == "name":
        return [float(i + 1) for i in range(len(found))]
    if over == "mtime":
        first = min((b["modified"] for b in found if b["modified"]), default=0.0)
        return [(b["modified"] - first) / 86400.0 for b in found]
    if not any(over in body["values"] for body in found):
        remedy = f"Give --name-pattern with {{{over}}} in it, or --over name, or --over mtime"
        raise SettingError(f"no log has a number {over!r}", remedy=remedy)
    return [float(body["values"].get(over, np.nan)) for body in found]


def _fit_row(run: Mapping[str, Any], entry: Mapping[str, Any] | None) -> dict[str, Any]:
    names = ("model", "recommended", "sound", "rmse", "rmse_low", "rmse_high", "share", "train_rmse", "parameters")
    if entry is None:
        return dict.fromkeys((*names, "train_rows", "test_rows", "effort_unit", "notes")) | {"recommended": False}
    values = (entry["name"], entry["name"] == run["recommended"], entry["sound"], *entry["test"]["rmse"])
    values += (entry["test"]["share"][0], entry["train"]["rmse"][0], entry["parameters_count"])
    more = {"train_rows": run["train_rows"], "test_rows": run["test_rows"], "effort_unit": run["units"]["effort"]}
    return dict(zip(names, values, strict=True)) | more | {"notes": "; ".join(entry["notes"])}


def _error_of(row: Mapping[str, Any]) -> dict[str, Any]:
    ends = {"value": row["rmse"], "low": row["rmse_low"], "high": row["rmse_high"]}
    return {"name": RMSE, "unit": row["effort_unit"], "at_bound": None} | ends


def _series(parameters: Rows, baseline: int) -> tuple[FleetSeries, ...]:
    groups: dict[tuple[str, str, str], Rows] = {}
    for row in parameters:
        groups.setdefault((row["model"], row["parameter"], row["unit"]), []).append(row)
    made: list[FleetSeries] = []
    for key, rows in groups.items():
        known = sorted(
            (r for r in rows if r["value"] is not None and r["order"] == r["order"]), key=itemgetter("order")
        )
        x, value, low, high = (
            np.array([np.nan if r[c] is None else r[c] for r in known], float)
            for c in ("order", "value", "low", "high")
        )
        score = outlier_scores(value, low, high)
        for row, each in zip(known, score, strict=True):
            row["score"] = float(each) if np.isfinite(each) else None
            row["outlier"] = bool(abs(each) > OUTLYING)
        names = tuple(r["device"] for r in known)
        chart = control_chart(value, baseline)
        made.append(FleetSeries(*key, names, x, value, low, high, score, trend(x, value), chart))
    return tuple(made)


def _write_tables(folder: Path, body: Mapping[str, Any], made: _Made) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    parameters, fits, _, model, digest = made
    for name, rows in (("parameters", parameters), ("fits", fits)):
        columns = list(dict.fromkeys(key for row in rows for key in row))
        table = pa.table({key: [row.get(key) for row in rows] for key in columns})
        with whole_file(folder / f"{name}.parquet", unwritable) as partial, partial.open("wb") as file:
            pq.write_table(table, file)
    _write(folder / MARKER, {**body, "model": model, "digest": digest})

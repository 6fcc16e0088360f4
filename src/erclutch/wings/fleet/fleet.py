"""Many logs, the same models: each log or device is fitted by itself, and all parameters stand in one table.

::

    fleet.json           settings, versions, and the digest of the tables
    devices/NAME.json    what came out of one log or device; a second start takes it where the log is the same
    parameters.parquet   a row for each parameter of each model of each device
    fits.parquet         a row for each model of each device; a device that failed has a row with the reason
    report.html          a page that says what stands out and what drifts
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from erclutch.errors import ErclutchError, RunError, SettingError, keywords_checked
from erclutch.files import may_fill, may_write, whole_file
from erclutch.files.given_files import file_digest, plain_words, small_json
from erclutch.files.groups import together
from erclutch.files.places import nothing, release, reserve
from erclutch.fit.comparison import Settings, compare
from erclutch.logs import ColumnMap
from erclutch.logs.columns.name_pattern import constants_of, names_a_folder
from erclutch.logs.dataset import build_dataset
from erclutch.logs.log_reader import log_suffixes, may_be_log
from erclutch.logs.mapping import file_beside
from erclutch.logs.reading import Reading
from erclutch.models.model_file import digest_of, keeps_digest
from erclutch.runs.cluster import finished, saying_kept, task_pool
from erclutch.runs.written_run import run_to_dict, unwritable, versions, write_json
from erclutch.signals.device import DeviceName
from erclutch.wings.fleet.fitted_fleet import Fleet
from erclutch.wings.fleet.fleet_tables import FILES, logs_of_several_devices, tables_of
from erclutch.wings.fleet.joints_as_devices import logs_of_joints

MARKER = "fleet.json"
REPORT = "report.html"
_DEVICES = "devices"
_LESS = 0.99  # of a field, to see how an effort follows it

#: Called with the devices done, those there are, and the device that was just done.
FleetProgress = Callable[[int, int, str], None]


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


@keywords_checked
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
        by: "log", each log by itself; "folder", the logs of a folder are one device; "joint", each joint of a robot's
            logs is a device; or a field of the name pattern.
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
    folder = Path(out)
    reading = reading or Reading()
    asked = replace(settings or Settings(), models=tuple(models), workers=1)
    # A folder stands for the logs in it and below; each log is taken once.
    suffixes = log_suffixes()
    files: list[Path] = []
    for path in map(Path, [logs] if isinstance(logs, str | Path) else logs):
        if path.is_dir():
            files += sorted(file for file in path.rglob("*") if may_be_log(file, suffixes))
        else:
            files.append(path)
    if not files:
        remedy = f"Give logs; they end in {', '.join(suffixes)}"
        raise SettingError("there is no log", remedy=remedy)
    files = list(dict.fromkeys(path.resolve() for path in files))
    if by == "joint":
        joints = logs_of_joints(files, reading, device)
        tasks = [
            DeviceTask(name, each.paths, asked, replace(reading, mapping=each.mapping), device)
            for name, each in joints.items()
        ]
    else:
        logs_by_device = logs_of_devices(files, by, reading)
        tasks = [
            DeviceTask(name, paths, asked, reading, device)
            for name, paths in logs_by_device.items()
        ]
    body = {
        "settings": asked.to_dict(),
        "reading": repr(reading),
        "device": device,
        "by": by,
        "versions": versions(),
    }
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
    from erclutch.wings.fleet.fleet_page import write_fleet_report

    done: dict[str, dict[str, Any]] = {}  # what came out of each device, by its name
    for task in tasks:
        # What an earlier start kept counts if it is whole and unchanged, and the logs and the mappings beside them are
        # the same.
        with suppress(OSError, ValueError, KeyError, TypeError, AttributeError):
            kept = small_json(_file(folder, task.name))
            is_same = (
                keeps_digest(kept)
                and kept["device"] == task.name
                and kept["sha256"] == _digests(task)
            )
            was_our_defect = str(kept["failed"]).startswith("unforeseen")  # perhaps mended by now
            if is_same and not was_our_defect:
                done[task.name] = kept
    taken = len(done)

    left = [task for task in tasks if task.name not in done]
    if left:
        with (
            saying_kept(done, len(tasks), f"logs are done and kept in {folder}"),
            task_pool(*where) as pool,
        ):
            for index, outcome in finished(pool, fit_device, left):
                task = left[index]
                # Its process died: it is tried again at the next start.
                if isinstance(outcome, Exception):
                    outcome = _failed(task, str(outcome))
                elif not {*_failed(task, "")} <= outcome.keys() or outcome["device"] != task.name:
                    outcome = _failed(task, "the worker gave what is not of this device")
                else:
                    _write(_file(folder, task.name), {**outcome, "digest": digest_of(outcome)})
                done[task.name] = outcome
                progress(len(done), len(tasks), task.name)

    tables = tables_of([done[task.name] for task in tasks], over, baseline)
    origins: set[str] = set()
    for device in done.values():
        origins |= {log["origin"] for log in device.get("run", {}).get("logs", ())}
    fleet = Fleet(
        folder,
        tables.parameters,
        tables.fits,
        tables.series,
        tables.model,
        tables.digest,
        taken,
        over,
        tuple(sorted(origins)),
        logs_of_several_devices(done),
    )
    with together():  # a report beside tables of other devices would mislead
        tables.write(folder)
        _write(folder / MARKER, {**body, "model": tables.model, "digest": tables.digest})
        write_fleet_report(fleet, folder / REPORT)
    return fleet


def fit_device(task: DeviceTask) -> dict[str, Any]:
    """Fit one device: what `erclutch fit --json` prints, or why not, as JSON values."""
    reading = task.reading
    body = _failed(task, "")
    try:
        body["sha256"] = _digests(task)
        body["modified"] = min(Path(path).stat().st_mtime for path in task.paths)
        recordings = [
            recording for path in task.paths for recording in reading.read(path, task.device)
        ]
        data = build_dataset(recordings, device=task.device, derivative=reading.derivative)
        comparison = compare(data, task.settings)
        fields: list[float] = []  # the reference field of each law, one for all models
        exponents: dict[str, float | None] = {}
        for entry in comparison.entries:
            law = entry.outcome.model.law_part
            exponents[entry.name] = None
            if law is None:
                continue
            fields.append(law.reference.field)
            # By which power the yield effort of the law follows the field at the largest one.
            form = law.structure.law.yield_form
            if form is not None:
                shape = [law.shape[each.name] for each in form.shape]
                ratio = form.factor(1.0, *shape) / form.factor(_LESS, *shape)
                exponents[entry.name] = float(np.log(ratio) / np.log(1.0 / _LESS))
        return {
            **body,
            "reference_field": fields[0] if fields else None,
            "field_exponents": exponents,
            "values": dict(recordings[0].constants),
            "run": run_to_dict(comparison, recordings, None),
        }
    except (ErclutchError, OSError) as error:
        return {**body, "failed": str(error)}
    except Exception as error:  # a failed log is a row, whatever failed
        return {**body, "failed": f"unforeseen {type(error).__name__}: {error}"}


def _digests(task: DeviceTask) -> list[str]:
    """Of the logs, and of the mapping files beside them."""
    logs = [Path(path) for path in task.paths]
    mappings = [mapping for log in logs if (mapping := file_beside(log))]
    return [file_digest(path, sys.maxsize) for path in (*logs, *mappings)]  # logs of any size


def _failed(task: DeviceTask, reason: str) -> dict[str, Any]:
    """What came out of a device of which nothing is known but the reason."""
    return {
        "device": task.name,
        "logs": [Path(path).name for path in task.paths],
        "sha256": [],
        "values": {},
        "modified": 0.0,
        "failed": reason,
    }


# --- what is fitted, and what is kept -----------------------------------------------------------------------------


def logs_of_devices(
    files: Sequence[Path],
    by: str,
    reading: Reading,
) -> dict[str, tuple[str, ...]]:
    """The logs of each device by its name, in order."""
    top = os.path.commonpath([path.parent for path in files])
    if by == "log":
        names = [path.relative_to(top).as_posix() for path in files]
    elif by == "folder":
        names = [path.parent.relative_to(top).as_posix() for path in files]
    else:
        pattern = reading.mapping.name_pattern if isinstance(reading.mapping, ColumnMap) else None
        if pattern is None or f"{{{by}" not in pattern:
            remedy = (
                f"Give --name-pattern with {{{by}}} in it, or --by log, --by folder, --by joint"
            )
            raise SettingError(f"--by {by} is no field of the name pattern", remedy=remedy)
        tails = [str(path) if names_a_folder(pattern) else path.name for path in files]
        names = [f"{by} {constants_of(pattern, tail)[by][0]:g}" for tail in tails]
    pairs = list(zip(names, map(str, files), strict=True))
    pairs.sort(key=lambda pair: [*_natural(pair[0]), *_natural(pair[1])])
    logs: dict[str, list[str]] = {}
    for name, path in pairs:
        logs.setdefault(name, []).append(path)
    return {name: tuple(paths) for name, paths in logs.items()}


def _natural(name: str) -> list[tuple[int, str]]:
    """Unit 9 stands before unit 10."""
    words = re.split(r"(\d+)", name)
    return [(int(word), "") if word.isdecimal() else (0, word) for word in words]


def _begin(folder: Path, body: Mapping[str, Any], force: bool) -> None:
    """Take the folder for this call, and go on with the fleet in it or begin a new one.

    Raises:
        RunError: the folder holds something else, or a fleet of other settings, or cannot be written.
    """
    may_fill(folder)
    reserve(folder, nothing)
    marker = folder / MARKER
    held: Any = None
    if marker.is_file():
        try:
            held = small_json(marker)
        except (OSError, ValueError) as error:
            if not force:
                raise RunError(
                    f"{MARKER}: {plain_words(error)}",
                    where=str(folder),
                    remedy="Give --force to begin anew",
                ) from error
    else:
        may_write(folder, False, MARKER, "a fleet")
    if isinstance(held, dict) and not force:
        kept = cast(dict[str, Any], held)
        # Lists for tuples, as they come back from the file.
        as_kept: dict[str, Any] = json.loads(json.dumps(body))
        other = [key for key in body if kept.get(key) != as_kept[key]]
        if other:
            raise RunError(
                f"there is a fleet of other {' and '.join(other)}",
                where=str(folder),
                remedy="Give the same, --out another name, or --force",
            )
        return

    devices = folder / _DEVICES
    try:
        if force:  # nothing of the other settings may stay beside a fleet that is interrupted
            for name in (REPORT, *FILES):
                (folder / name).unlink(missing_ok=True)
            shutil.rmtree(devices, ignore_errors=True)
        devices.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(folder, error) from error
    _write(marker, body)


def _write(path: Path, body: Mapping[str, Any]) -> None:
    with whole_file(path, unwritable) as partial:
        write_json(partial, body)


def _file(folder: Path, name: str) -> Path:
    """The file of a device: its name as files may be called, and a digest that keeps alike names apart."""
    plain = re.sub(r"[^A-Za-z0-9._-]+", "_", name)[:80]
    digest = hashlib.sha256(name.encode()).hexdigest()[:8]
    return folder / _DEVICES / f"{plain}-{digest}.json"

"""Models are fitted to logs larger than memory and scored on all rows, range of rows by range of rows.

    result = erclutch.fit_large(["a.parquet", "b.parquet"], ("rbfm-10/forward", "fnn-16"), device="coaxial")
    result.entries[0].outcome.model

The logs are read once, a task a log. Fields, slips, effort and time go to the files of a temporary folder (48 bytes a
row of a pair, 32 of a single device), over which every fit makes its passes, in tasks too. Laws with a memory run over
the rows in their order. Laws with a stimulus of their own, and networks with past samples or dynamics, are refused.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError, SettingError
from erclutch.files import may_write, whole_folder
from erclutch.fit.candidate import SETS
from erclutch.fit.centroids import not_on_disk
from erclutch.fit.comparison import Settings
from erclutch.fit.data_check import Finding, check
from erclutch.fit.kinds.law_alone import structures_for
from erclutch.fit.kinds.law_with_network import residuals_for
from erclutch.fit.kinds.network_alone import networks_for
from erclutch.fit.laws.fit_law import fit_structure, require_no_stimulus
from erclutch.fit.networks.fit_network import fit_network, require_no_past
from erclutch.fit.outcome import AnyOutcome
from erclutch.logs.dataset import Dataset
from erclutch.logs.disk_rows import DiskRows, Part, Source, Stretch, TrainingRows, read_part
from erclutch.logs.reading import Reading
from erclutch.models.load import Model
from erclutch.models.model import full_name
from erclutch.models.model_file import digest_of
from erclutch.runs.cluster import saying_kept
from erclutch.runs.run_folder import unwritable, versions, write_json, write_models
from erclutch.runs.run_shape import file_name
from erclutch.runs.tasks import Tasks, tasks_on
from erclutch.signals.array import Array
from erclutch.signals.device import DeviceName, Units

LARGE_SCHEMA = 1
MARKER = "large.json"
_CHECKED = 100_000  # rows, evenly taken, that the checks before the fit look at

#: Called with what is being done and the rows done so far.
LargeFitProgress = Callable[[str, int], None]


@dataclass(frozen=True)
class LargeEntry:
    """One model.

    Attributes:
        outcome: the fit; its cost is that of all rows.
        test_mse: mean squared error on the test logs; None without.
        seconds: CPU time of the fit, all its passes included.
    """

    outcome: AnyOutcome
    test_mse: float | None
    seconds: float

    @property
    def name(self) -> str:
        """The model's name."""
        return self.outcome.model.name

    @property
    def train_mse(self) -> float:
        """Mean squared error on all training rows."""
        return self.outcome.train_cost / self.outcome.train_rows


@dataclass(frozen=True)
class LargeFit:
    """What came out.

    Attributes:
        entries: models in the order in which they were asked for.
        sources: training logs.
        test_sources: test logs.
        test_rows: rows of the test logs.
        units: of effort, field and slip.
        findings: what the checks saw, on rows evenly taken from all.
        left_out: models of a set such as "all" that cannot be fitted this way, with the reason.
        read_seconds: CPU time of reading.
        worker_memory: most bytes of memory that a worker had; None where they are threads of this process.
        settings: what was asked for, as JSON values.
    """

    entries: tuple[LargeEntry, ...]
    sources: tuple[Source, ...]
    test_sources: tuple[str, ...]
    test_rows: int
    units: Units
    findings: tuple[Finding, ...]
    left_out: tuple[str, ...]
    read_seconds: float
    worker_memory: int | None
    settings: Mapping[str, Any]

    @property
    def rows(self) -> int:
        """Training rows."""
        return sum(source.kept for source in self.sources)

    def to_dict(self) -> dict[str, Any]:
        """All but what differs from run to run, as JSON values."""
        return {
            "kind": "erclutch large fit",
            "schema": LARGE_SCHEMA,
            "versions": versions(),
            "settings": dict(self.settings),
            "units": asdict(self.units),
            "logs": [
                {"name": s.name, "sha256": s.digest, "rows": s.read, "kept": s.kept, "origin": s.origin}
                for s in self.sources
            ],
            "test_logs": list(self.test_sources),
            "train_rows": self.rows,
            "test_rows": self.test_rows,
            "findings": [str(finding) for finding in self.findings],
            "left_out": list(self.left_out),
            "models": [
                {
                    "name": e.name,
                    "file": f"models/{file_name(e.name)}.json",
                    "model_digest": e.outcome.model.to_dict()["digest"],
                    "train_mse": e.train_mse,
                    "test_mse": e.test_mse,
                    "stop": e.outcome.stop,
                }
                for e in self.entries
            ],
        }


def fit_large(
    paths: Sequence[str | Path] | str | Path,
    models: Sequence[str] = ("all",),
    *,
    device: DeviceName = "single",
    reading: Reading | None = None,
    test: Sequence[str | Path] = (),
    friction: bool | None = None,
    offset: bool | None = None,
    seed: int = 0,
    workers: int = 1,
    cluster: str | None = None,
    scratch: str | Path | None = None,
    progress: LargeFitProgress = lambda what, rows: None,
) -> LargeFit:
    """Fit models to logs that need not fit into memory.

    Args:
        paths: logs of the same device and units, files or addresses for `fsspec`; all but Parquet are read whole.
        models: laws without a stimulus, and networks; "all" and "paper" leave out what cannot be.
        device: "single" or "coaxial".
        reading: columns, units and filters.
        test: logs to score the models on.
        friction: a column of friction at zero field; None: for a single device.
        offset: a constant effort; None: for a single device.
        seed: of the networks' starts.
        workers: tasks side by side; changes no figure.
        cluster: where they run; see `task_pool`. All workers must see ``scratch``.
        scratch: folder for the temporary folder; None is the system's.
        progress: called as rows are read and models are done.

    Raises:
        LogError, MappingError: a log that cannot be read or understood, in any of its rows.
        CheckError, SettingError: rows that cannot support a fit; models that cannot be fitted this way, or none.
        RunError: no room for the temporary folder.
    """
    logs = [paths] if isinstance(paths, str | Path) else list(paths)
    how = reading or Reading()
    if not logs:
        raise SettingError("no log was given", remedy="Give at least one log file")
    settings = Settings(tuple(models), lag="none", friction=friction, offset=offset, seed=seed, workers=workers)
    with saying_kept((), len(logs), "logs are kept: the fit begins anew"), tasks_on(cluster, workers) as tasks:
        with DiskRows(scratch, tasks) as rows:
            seconds = _read(logs, how, device, rows, tasks, progress)
            findings, left_out, fitted = _fitted(rows, settings, tasks, progress)
        with DiskRows(scratch, tasks) as others:
            _read(test, how, device, others, tasks, progress)
            errors = _errors(others, [each.model for each, _ in fitted])
    return LargeFit(
        entries=tuple(LargeEntry(o, e, s) for (o, s), e in zip(fitted, errors, strict=True)),
        sources=tuple(rows.sources),
        test_sources=tuple(source.name for source in others.sources),
        test_rows=others.rows,
        units=rows.units,
        findings=findings,
        left_out=tuple(left_out),
        read_seconds=seconds,
        worker_memory=tasks.peak,
        settings={"models": list(models), "device": device, "friction": friction, "offset": offset, "seed": seed},
    )


def _chosen(sample: Dataset, settings: Settings) -> tuple[dict[str, Callable[[TrainingRows], AnyOutcome]], list[str]]:
    """How each model is fitted, by its name; and what of a set of models cannot be."""
    for residual in residuals_for(sample, settings):
        raise not_on_disk(residual.specification, "its network is fitted to the law's residual of each row")
    how = {"seed": settings.seed, "workers": settings.workers}
    laws = [
        (
            full_name(s.specification, s.dynamics),
            partial(require_no_stimulus, s),
            partial(fit_structure, structure=s, intervals=False),
        )
        for s in structures_for(sample, settings)
    ]
    networks = [
        (full_name(s.specification, s.dynamics), partial(require_no_past, s), partial(fit_network, structure=s, **how))
        for s in networks_for(sample, settings)
    ]
    kept: dict[str, Callable[[TrainingRows], AnyOutcome]] = {}
    left_out: list[str] = []
    for name, require, fit in (*laws, *networks):
        try:
            require()
        except SettingError as error:
            if not any(model in SETS for model in settings.models):
                raise
            left_out.append(error.problem)
        else:
            kept[name] = fit
    if not kept:
        raise SettingError("no model was given", remedy="Give --models all, or names from erclutch laws")
    return kept, left_out


def _read(
    logs: Sequence[str | Path], how: Reading, device: DeviceName, rows: DiskRows, tasks: Tasks, report: LargeFitProgress
) -> float:
    """The CPU time that reading took."""
    began = tasks.seconds
    jobs = [(str(path), rows.stem(index)) for index, path in enumerate(logs)]
    seen = report if tasks.here else None
    for part in tasks(partial(_read_log, how, device, seen), jobs):
        rows.append(part)
        report(f"read {part.source.name}", rows.rows)
    return tasks.seconds - began


def _read_log(how: Reading, device: DeviceName, report: LargeFitProgress | None, job: tuple[str, Path]) -> Part:
    """The rows of one log, on disk. What lies at an address is copied there first, and the copy goes at the end."""
    address, stem = job
    show = report and partial(report, f"read {PurePosixPath(address).name}")
    if "://" not in address:
        return read_part(how.batches(address, device), device, how.derivative, stem, show)
    folder = stem.with_name(f"{stem.name}-copy")
    folder.mkdir(exist_ok=True)
    try:
        copy = copied(address, folder)
        return read_part(how.batches(copy, device), device, how.derivative, stem, show)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def copied(address: str, folder: Path) -> Path:
    """A copy of the file at an address that `fsspec` opens.

    Raises:
        LogError: it cannot be read, or what reads such addresses is not installed.
    """
    try:
        import fsspec  # pyright: ignore[reportMissingTypeStubs]
    except ImportError as error:
        remedy = 'Run: pip install "erclutch[cluster]"'
        raise LogError("addresses need fsspec", where=address, remedy=remedy) from error
    name = PurePosixPath(address.partition("?")[0]).name or "log"
    try:
        opened: Any = cast(Any, fsspec).open(address, "rb")
        with opened as source, (folder / name).open("wb") as to:
            shutil.copyfileobj(source, to, 1 << 20)
    except Exception as error:  # whatever a file system of another package raises
        raise LogError(f"cannot be read: {error}", where=address, remedy="Check the address and its access") from error
    return folder / name


def _fitted(
    rows: DiskRows, settings: Settings, tasks: Tasks, report: LargeFitProgress
) -> tuple[tuple[Finding, ...], list[str], list[tuple[AnyOutcome, float]]]:
    """What the checks say of rows evenly taken, the models that cannot be, and each fit with its CPU time."""
    sample = rows.thinned(_CHECKED)
    findings = check(sample, np.zeros(sample.rows, np.bool_))
    fits, left_out = _chosen(sample, settings)
    return findings, left_out, [_timed(name, fit, rows, tasks, report) for name, fit in fits.items()]


def _timed(
    name: str, fit: Callable[[TrainingRows], AnyOutcome], rows: DiskRows, tasks: Tasks, report: LargeFitProgress
) -> tuple[AnyOutcome, float]:
    report(f"fit {name}", rows.rows)
    began, first = tasks.seconds, tasks.passes
    tasks.show = lambda passes, done: report(f"fit {name}, pass {passes - first}, {done} tasks done", rows.rows)
    return fit(rows), tasks.seconds - began


def _errors(rows: DiskRows, models: Sequence[Model]) -> list[float | None]:
    """Mean squared error of each model over all rows; None without rows."""
    if not rows.rows:
        return [None] * len(models)
    past = any(model.structure.dynamics != "none" for model in models)
    totals = sum(rows.stretches(partial(_squared_errors, models), past=past), np.zeros(len(models)))
    return [float(total) / rows.rows for total in totals]


def _squared_errors(models: Sequence[Model], stretches: Iterable[Stretch]) -> Array:
    totals = np.zeros(len(models))
    for data, rows in stretches:
        errors = [(data.effort - model.predict(data))[rows] for model in models]
        totals += [float(error @ error) for error in errors]
    return totals


def write_large(out: str | Path, result: LargeFit, *, force: bool = False) -> Path:
    """Write the models and a summary: ``large.json`` and ``models/NAME.json``, which `erclutch.load_model` reads.

    Raises:
        RunError: the folder exists, or cannot be written.
    """
    target = Path(out)
    may_write(target, force, MARKER)
    with whole_folder(target, unwritable) as folder:
        body = result.to_dict()
        write_json(folder / MARKER, {**body, "digest": digest_of(body)})
        write_models(folder, {entry.name: entry.outcome.model for entry in result.entries})
    return target

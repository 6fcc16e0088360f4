"""Logs larger than memory: models without memory of the past, fitted and scored on all rows, block by block.

    result = erclutch.fit_large(["a.parquet", "b.parquet"], ("rbfm-10/forward", "fnn-16"), device="coaxial")
    result.entries[0].outcome.model

The logs are read once. Their fields, slips and effort go to a temporary file (40 bytes a row of a pair, 24 of a single
device), over which every fit makes its passes. Laws with a stimulus of their own, dynamics and past samples need rows
together that are not together in memory, and are refused.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from erclutch.check import Finding, check
from erclutch.comparison import AnyOutcome, Settings, networks_for, structures_for
from erclutch.dataset import Dataset
from erclutch.device import DeviceName, Units
from erclutch.differentiate import Derivative
from erclutch.errors import SettingError
from erclutch.fit.streamed import fit_network_streamed, fit_structure_streamed, refuse_structure, squared_errors
from erclutch.logs import Batch, ColumnMap, read_batches
from erclutch.logs.assemble import Invalid
from erclutch.model import Structure, digest_of
from erclutch.networks import NetworkStructure
from erclutch.runs import file_name, may_write, unwritable, versions, write_json
from erclutch.spool import Source, Spool, datasets
from erclutch.whole_folder import whole_folder

LARGE_SCHEMA = 1
MARKER = "large.json"
_CHECKED = 100_000  # rows, evenly taken, that the checks before the fit look at
_SETS = ("all", "paper")

#: Called with what is being done and the rows done so far.
Progress = Callable[[str, int], None]


@dataclass(frozen=True)
class Reading:
    """How logs are read; see `erclutch.read`.

    Attributes:
        mapping: which column is which signal.
        mapping_file: a mapping file in place of those beside the logs.
        invalid: "error", "drop", or None for what the mapping says.
        variable: which recording of a MATLAB file.
        derivative: filter for speeds that are not logged.
        rows: of a batch.
    """

    mapping: ColumnMap | Mapping[str, Any] | None = None
    mapping_file: str | Path | None = None
    invalid: Invalid | None = None
    variable: str | None = None
    derivative: Derivative = field(default_factory=Derivative)
    rows: int = 65_536

    def batches(self, path: str | Path, device: DeviceName) -> Iterator[Batch]:
        """The batches of one log."""
        return read_batches(
            path,
            self.mapping,
            device=device,
            invalid=self.invalid,
            variable=self.variable,
            mapping_file=self.mapping_file,
            rows=self.rows,
        )


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
            "units": {"effort": self.units.effort, "field": self.units.field, "slip": self.units.slip},
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
    scratch: str | Path | None = None,
    progress: Progress | None = None,
) -> LargeFit:
    """Fit models to logs that need not fit into memory.

    Args:
        paths: logs of the same device and units. Parquet is read in batches, other formats one whole file at a time.
        models: laws without a stimulus of their own, and networks; "all" and "paper" leave out what cannot be.
        device: "single" or "coaxial".
        reading: columns, units and filters.
        test: logs to score the models on.
        friction: a column of friction at zero field; None: for a single device.
        offset: a constant effort; None: for a single device.
        seed: of the networks' starts.
        workers: starts of a network side by side; changes no figure.
        scratch: folder for the temporary file; None is the system's.
        progress: called as rows are read and models are done.

    Raises:
        LogError, MappingError: a log that cannot be read or understood, in any of its rows.
        CheckError: rows that cannot support a fit.
        SettingError: models that cannot be fitted this way, or none.
        RunError: no room for the temporary file.
    """
    logs = _listed(paths)
    how, report = reading or Reading(), progress or _silent
    settings = Settings(tuple(models), lag="none", friction=friction, offset=offset, seed=seed, workers=workers)
    with Spool(scratch) as spool:
        began = process_time()
        for path in logs:
            spool.add(
                how.batches(path, device),
                device,
                how.derivative,
                lambda rows, p=path: report(f"read {Path(p).name}", rows),
            )
        seconds = process_time() - began
        sample = spool.thinned(_CHECKED)
        findings = check(sample, np.zeros(sample.rows, np.bool_))
        structures, left_out = _chosen(sample, settings)
        fits = [_fit(spool, structure, settings, report) for structure in structures]
        sources, units = tuple(spool.sources), spool.units
    errors, rows = _test_errors(test, how, device, [outcome for outcome, _ in fits], report)
    entries = [LargeEntry(o, e, s) for (o, s), e in zip(fits, errors, strict=True)]
    names = tuple(Path(path).name for path in test)
    return LargeFit(
        tuple(entries), sources, names, rows, units, findings, tuple(left_out), seconds, _asked(settings, device)
    )


def _listed(paths: Sequence[str | Path] | str | Path) -> list[str | Path]:
    logs: list[str | Path] = [paths] if isinstance(paths, str | Path) else list(paths)
    if not logs:
        raise SettingError("no log was given", remedy="Give at least one log file")
    return logs


def _silent(what: str, rows: int) -> None:
    """No progress is shown."""


def _asked(settings: Settings, device: DeviceName) -> dict[str, Any]:
    return {
        "models": list(settings.models),
        "device": device,
        "friction": settings.friction,
        "offset": settings.offset,
        "seed": settings.seed,
    }


def _chosen(sample: Dataset, settings: Settings) -> tuple[list[Structure | NetworkStructure], list[str]]:
    """What is fitted, and what of a set of models cannot be."""
    kept: list[Structure | NetworkStructure] = []
    left_out: list[str] = []
    for structure in (*structures_for(sample, settings), *networks_for(sample, settings)):
        try:
            refuse_structure(structure)
        except SettingError as error:
            if not any(name in _SETS for name in settings.models):
                raise
            left_out.append(error.problem)
        else:
            kept.append(structure)
    if not kept:
        raise SettingError("no model was given", remedy="Give --models all, or names from erclutch laws")
    return kept, left_out


def _fit(
    spool: Spool, structure: Structure | NetworkStructure, settings: Settings, report: Progress
) -> tuple[AnyOutcome, float]:
    report(f"fit {structure.specification}", spool.rows)
    began = process_time()
    outcome: AnyOutcome
    if isinstance(structure, Structure):
        outcome = fit_structure_streamed(spool, structure)
    else:
        outcome = fit_network_streamed(spool, structure, seed=settings.seed, workers=settings.workers)
    return outcome, process_time() - began


def _test_errors(
    test: Sequence[str | Path], how: Reading, device: DeviceName, outcomes: Sequence[AnyOutcome], report: Progress
) -> tuple[list[float | None], int]:
    """Mean squared errors over all test logs together, and their rows."""
    totals, rows = np.zeros(len(outcomes)), 0
    threadpool_limits: Any = import_module("threadpoolctl").threadpool_limits
    with threadpool_limits(1):
        for path in test:
            report(f"score on {Path(path).name}", rows)
            blocks = (data for _, data in datasets(how.batches(path, device), device, how.derivative) if data)
            errors = squared_errors(blocks, [outcome.model.predict for outcome in outcomes])
            totals += [error for error, _ in errors]
            rows += errors[0][1]
    return ([float(total / rows) for total in totals] if rows else [None] * len(outcomes)), rows


def write_large(folder: str | Path, result: LargeFit, *, force: bool = False) -> Path:
    """Write the models and a summary: ``large.json`` and ``models/NAME.json``, which `erclutch.load_model` reads.

    Raises:
        RunError: the folder exists, or cannot be written.
    """
    target = Path(folder)
    may_write(target, force, MARKER)
    with whole_folder(target, unwritable) as partial:
        body = result.to_dict()
        write_json(partial / MARKER, {**body, "digest": digest_of(body)})
        (partial / "models").mkdir()
        for entry in result.entries:
            write_json(partial / "models" / f"{file_name(entry.name)}.json", entry.outcome.model.to_dict())
    return target


def peak_memory() -> int | None:
    """The most bytes of memory that this process has had so far; None where the system does not tell.

    On Linux ``ru_maxrss`` also holds what the process that started this one had, so the kernel's own mark comes first.
    """
    try:
        marks = Path("/proc/self/status").read_text(encoding="ascii", errors="replace").splitlines()
    except OSError:
        marks = []
    for mark in marks:
        if mark.startswith("VmHWM:"):
            return 1024 * int(mark.split()[1])
    try:
        resource: Any = import_module("resource")
    except ImportError:  # Windows
        return None
    most = int(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    return most if sys.platform == "darwin" else 1024 * most

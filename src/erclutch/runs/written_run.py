"""A comparison is written as a run folder; `erclutch.runs.run_folder` says what is in it, and reads it back."""

from __future__ import annotations

import csv
import importlib.metadata
import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from erclutch import files
from erclutch._version import __version__
from erclutch.files import file_digest, whole_folder
from erclutch.logs.keywords import told_alike
from erclutch.models.model import Model
from erclutch.models.model_file import digest_of
from erclutch.models.model_titles import id_of
from erclutch.runs.run_shape import FINAL_FILE, GUARDED, RUN_SCHEMA, file_name
from erclutch.signals.recording import LogFacts

if TYPE_CHECKING:
    from erclutch.fit.comparison import Comparison, RankedModel
    from erclutch.fit.outcome import AnyOutcome

_LIBRARIES = ("numpy", "scipy", "pandas", "pyarrow", "pint")
_REMEDY = "Give --out a folder on a disk that can be written and has space"
#: The error of a run's folder that cannot be written.
unwritable = partial(files.unwritable, problem="the run cannot be written", remedy=_REMEDY)
#: Say before any work whether a run may be written to a folder.
may_write = partial(files.may_write, marker="run.json")


def write_run(
    folder: str | Path,
    comparison: Comparison,
    recordings: Sequence[LogFacts],
    *,
    reading: Mapping[str, Any] | None = None,
    force: bool = False,
) -> Path:
    """Write a comparison as a run folder.

    Args:
        folder: where; its parent must exist.
        comparison: what came out.
        recordings: the logs that went in.
        reading: the options by which `erclutch fit` read them, as JSON values; None where it did not, so that no
            command can repeat the run. What `erclutch.read` was told is kept then.
        force: replace a run that is already there (never anything else).

    Returns:
        The folder.

    Raises:
        RunError: the folder exists, or cannot be written.
    """
    target = Path(folder)
    may_write(target, force)
    with whole_folder(target, unwritable) as partial:
        _fill(partial, run_to_dict(comparison, recordings, reading), comparison)
    return target


def _fill(folder: Path, body: Mapping[str, Any], comparison: Comparison) -> None:
    write_models(folder, {entry.name: entry.outcome.model for entry in comparison.entries})
    if comparison.final is not None:
        write_json(folder / FINAL_FILE, comparison.final.model.to_dict())
    _write_table(folder / "table.csv", comparison)
    _write_predictions(folder / "predictions.parquet", comparison)
    # What `fit --json` prints, and what keeps the folder together.
    whole = {**body, "files": {name: file_digest(folder / name) for name in GUARDED}}
    write_json(folder / "run.json", {**whole, "digest": digest_of(whole)})


def write_models(folder: Path, models: Mapping[str, Model]) -> None:
    """Write each model as models/NAME.json."""
    (folder / "models").mkdir()
    for name, model in models.items():
        write_json(folder / "models" / f"{file_name(name)}.json", model.to_dict())


def write_json(path: Path, body: Mapping[str, Any]) -> None:
    """Plain JSON, indented, without numbers that are not finite."""
    path.write_text(json.dumps(body, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def run_to_dict(
    comparison: Comparison, recordings: Sequence[LogFacts], reading: Mapping[str, Any] | None
) -> dict[str, Any]:
    """Everything of a run but the rows, as JSON values."""
    data = comparison.data
    return {
        "kind": "erclutch run",
        "schema": RUN_SCHEMA,
        "versions": versions(),
        "settings": comparison.settings.to_dict(),
        "reading": None if reading is None else dict(reading),
        **({} if reading is not None else {"told": told_alike(recordings)}),
        "device": data.device,
        "units": asdict(data.units),
        "logs": [
            {"name": r.name, "sha256": r.digest, "rows": r.rows, "segments": len(r.segments), "period_s": r.period}
            | {"origin": r.origin, "mapping": list(r.mapping) if r.mapping else None}
            for r in recordings
        ],
        "notes": list(data.notes),
        "source_rows": [list(rows) for rows in data.source_rows],
        "spans": [[span.start, span.stop, span.period] for span in data.clock.spans],
        "train_rows": int(np.count_nonzero(~comparison.test)),
        "test_rows": int(np.count_nonzero(comparison.test)),
        "findings": [asdict(finding) for finding in comparison.findings],
        "ranking": [
            _entry_to_dict(entry, id_of(place), comparison.titles[entry.name])
            for place, entry in enumerate(comparison.entries)
        ],
        "best": comparison.best,
        "recommended": comparison.recommended,
        **({"chosen_by": comparison.chosen_by} if comparison.chosen_by else {}),
        **({} if comparison.recalibration is None else {"recalibration": dict(comparison.recalibration)}),
        **({} if comparison.final is None else {"final": _final_to_dict(comparison.final)}),
    }


def _final_to_dict(final: AnyOutcome) -> dict[str, Any]:
    """The model of all rows: its name, how many rows it was fitted to, and its digest."""
    return {"name": final.model.name, "rows": final.train_rows, "model_digest": final.model.to_dict()["digest"]}


def versions() -> dict[str, str]:
    """Versions of erclutch, Python and the libraries that figures depend on."""
    return {
        "erclutch": __version__,
        "python": platform.python_version(),
        **{name: importlib.metadata.version(name) for name in _LIBRARIES},
    }


def _entry_to_dict(entry: RankedModel, model_id: str, title: str) -> dict[str, Any]:
    fit = entry.outcome.to_dict()
    del fit["model"]
    return without_infinities(
        {
            "name": entry.name,
            **({"model": entry.outcome.model.name} if entry.label else {}),
            "file": f"models/{file_name(entry.name)}.json",
            "model_digest": entry.outcome.model.to_dict()["digest"],
            "id": model_id,
            "title": title,
            "sound": entry.sound,
            # Delay and time constants in s, of a law as fitted, of a network as given to it; empty without any.
            "dynamics": {name: float(value) for name, value in entry.outcome.model.times.items()},
            "parameters_count": entry.outcome.parameters,
            "train": entry.train.to_dict(),
            "test": entry.test.to_dict(),
            "excess_over_best": entry.excess.to_list(),
            "criteria": entry.criteria,
            "folds_rmse": list(entry.folds),
            **({} if entry.band is None else {"band": asdict(entry.band)}),
            **({} if entry.validation is None else {"validation_rmse": entry.validation.to_list()}),
            **({} if entry.by_log is None else {"rmse_by_log": list(entry.by_log)}),
            "fit": fit,
            "notes": list(entry.notes),
        }
    )


def without_infinities(value: Any) -> Any:
    """JSON has no infinity: null stands for it."""
    if isinstance(value, dict):
        return {key: without_infinities(item) for key, item in cast(dict[str, Any], value).items()}
    if isinstance(value, list):
        return [without_infinities(item) for item in cast(list[Any], value)]
    return None if isinstance(value, float) and not np.isfinite(value) else value


_COLUMNS = ("rmse", "share", "r2", "mse", "largest")


def _write_table(path: Path, comparison: Comparison) -> None:
    unit = comparison.data.units.effort
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        bands = [f"test_{name}{end}" for name in _COLUMNS for end in ("", "_low", "_high")]
        writer.writerow(["rank", "model", "parameters", "effort_unit", *bands, "train_rmse", "train_mse", "aic", "bic"])
        for rank, entry in enumerate(comparison.entries, start=1):
            figures = [v for name in _COLUMNS for v in getattr(entry.test, name).to_list()]
            figures += [entry.train.rmse.value, entry.train.mse.value, entry.criteria["aic"], entry.criteria["bic"]]
            writer.writerow([rank, entry.name, entry.outcome.parameters, unit, *map(repr, figures)])


def _write_predictions(path: Path, comparison: Comparison) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    data = comparison.data
    columns: dict[str, tuple[Any, str]] = {"time": (data.clock.time, "s")}
    if len(data.sources) > 1:
        names = np.repeat(data.sources, [b - a for a, b in data.source_rows])
        columns["log"] = (pa.array(names).dictionary_encode(), "")
    columns |= data.named_signals
    columns["effort"] = (data.effort, data.units.effort)
    columns["test"] = (comparison.test, "")
    for entry in comparison.entries:
        columns[f"effort:{entry.name}"] = (entry.predicted, data.units.effort)
    arrays = [values if isinstance(values, pa.Array) else pa.array(values) for values, _ in columns.values()]
    fields = [
        pa.field(name, array.type, metadata={"unit": unit})
        for (name, (_, unit)), array in zip(columns.items(), arrays, strict=True)
    ]
    floats = [f.name for f in fields if f.type == pa.float64()]
    # The open file and not its name: Arrow takes no name that is not UTF-8.
    with path.open("wb") as file:
        pq.write_table(
            pa.Table.from_arrays(arrays, schema=pa.schema(fields)),
            file,
            compression="zstd",
            use_dictionary=[f.name for f in fields if f.name not in floats],
            use_byte_stream_split=floats,
            write_page_checksum=True,
        )

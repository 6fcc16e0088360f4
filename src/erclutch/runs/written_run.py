"""A comparison is written as a run folder; `erclutch.runs.run_folder` says what is in it, and reads it back."""

from __future__ import annotations

import csv
import importlib.metadata
import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from erclutch import files
from erclutch._version import __version__
from erclutch.errors import keywords_checked
from erclutch.files import whole_folder
from erclutch.files.given_files import file_digest
from erclutch.logs.keywords import told_alike
from erclutch.models.model import Model
from erclutch.models.model_file import digest_of
from erclutch.models.model_titles import id_of
from erclutch.runs.run_shape import FINAL_FILE, GUARDED, INPUT, RUN_SCHEMA, file_name
from erclutch.signals.recording import LogFacts

if TYPE_CHECKING:
    from erclutch.fit.comparison import Comparison, RankedModel

_LIBRARIES = ("numpy", "scipy", "pandas", "pyarrow", "pint")
_REMEDY = "Give --out a folder on a disk that can be written and has space"
#: The error of a run's folder that cannot be written.
unwritable = partial(files.unwritable, problem="the run cannot be written", remedy=_REMEDY)
#: Say before any work whether a run may be written to a folder.
may_write = partial(files.may_write, marker="run.json")


@keywords_checked
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
        body = run_to_dict(comparison, recordings, reading)
        write_models(partial, {entry.name: entry.outcome.model for entry in comparison.entries})
        if comparison.final is not None:
            write_json(partial / FINAL_FILE, comparison.final.model.to_dict())
        write_scores(partial / "table.csv", comparison)
        write_predictions(partial / "predictions.parquet", comparison)
        # What `fit --json` prints, and what keeps the folder together.
        body["files"] = {name: file_digest(partial / name) for name in GUARDED}
        body["digest"] = digest_of(body)
        write_json(partial / "run.json", body)
    return target


def write_models(folder: Path, models: Mapping[str, Model]) -> None:
    """Write each model as models/NAME.json."""
    (folder / "models").mkdir()
    for name, model in models.items():
        write_json(folder / "models" / f"{file_name(name)}.json", model.to_dict())


def write_json(path: Path, body: Mapping[str, Any]) -> None:
    """Plain JSON, indented, without numbers that are not finite."""
    path.write_text(json.dumps(body, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def run_to_dict(
    comparison: Comparison,
    recordings: Sequence[LogFacts],
    reading: Mapping[str, Any] | None,
) -> dict[str, Any]:
    """Everything of a run but the rows, as JSON values."""
    data = comparison.data
    logs: list[dict[str, Any]] = []
    for log in recordings:
        logs.append(
            {
                "name": log.name,
                "sha256": log.digest,
                "rows": log.rows,
                "segments": len(log.segments),
                "period_s": log.period,
                "origin": log.origin,
                "mapping": list(log.mapping) if log.mapping else None,
            }
        )
    ranking: list[dict[str, Any]] = []
    for place, entry in enumerate(comparison.entries):
        ranking.append(_entry_to_dict(entry, id_of(place), comparison.titles[entry.name]))
    body: dict[str, Any] = {
        "kind": "erclutch run",
        "schema": RUN_SCHEMA,
        "versions": versions(),
        "settings": comparison.settings.to_dict(),
        "reading": None if reading is None else dict(reading),
    }
    if reading is None:
        body["told"] = told_alike(recordings)
    body |= {
        "device": data.device,
        "units": asdict(data.units),
        "logs": logs,
        "notes": list(data.notes),
        "source_rows": [list(rows) for rows in data.source_rows],
        "spans": [[span.start, span.stop, span.period] for span in data.clock.spans],
        "train_rows": int(np.count_nonzero(~comparison.test)),
        "test_rows": int(np.count_nonzero(comparison.test)),
        "findings": [asdict(finding) for finding in comparison.findings],
        "ranking": ranking,
        "best": comparison.best,
        "recommended": comparison.recommended,
    }
    if comparison.chosen_by:
        body["chosen_by"] = comparison.chosen_by
    if comparison.recalibration is not None:
        body["recalibration"] = dict(comparison.recalibration)
    if comparison.final is not None:
        final = comparison.final.model
        body["final"] = {
            "name": final.name,
            "rows": comparison.final.train_rows,
            "model_digest": final.to_dict()["digest"],
        }
    return body


def versions() -> dict[str, str]:
    """Versions of erclutch, Python and the libraries that figures depend on."""
    return {
        "erclutch": __version__,
        "python": platform.python_version(),
        **{name: _version_of(name) for name in _LIBRARIES},
    }


#: The installed version of a library, which is looked up in the folders of all packages.
_version_of = cache(importlib.metadata.version)


def _entry_to_dict(entry: RankedModel, model_id: str, title: str) -> dict[str, Any]:
    model = entry.outcome.model
    fit = entry.outcome.to_dict()
    del fit["model"]
    body: dict[str, Any] = {"name": entry.name}
    if entry.name != model.name:
        body["model"] = model.name
    body |= {
        "file": f"models/{file_name(entry.name)}.json",
        "model_digest": model.to_dict()["digest"],
        "id": model_id,
        "title": title,
        "sound": entry.sound,
        # Delay and time constants in s, of a law as fitted, of a network as given to it; empty without any.
        "dynamics": {name: float(value) for name, value in model.times.items()},
        "parameters_count": entry.outcome.parameters,
        "train": entry.train.to_dict(),
        "test": entry.test.to_dict(),
        "excess_over_best": entry.excess.to_list(),
        "criteria": entry.criteria,
        "folds_rmse": list(entry.folds),
    }
    if entry.band is not None:
        body["band"] = asdict(entry.band)
    if entry.validation is not None:
        body["validation_rmse"] = entry.validation.to_list()
    if entry.turned_down:
        body["turned_down"] = entry.turned_down
    if entry.by_log is not None:
        body["rmse_by_log"] = list(entry.by_log)
    body["fit"] = fit
    body["notes"] = list(entry.notes)
    return without_infinities(body)


def without_infinities(value: Any) -> Any:
    """JSON has no infinity: null stands for it."""
    if isinstance(value, dict):
        items = cast(dict[str, Any], value).items()
        return {key: without_infinities(item) for key, item in items}
    if isinstance(value, list):
        return [without_infinities(item) for item in cast(list[Any], value)]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


_COLUMNS = ("rmse", "share", "r2", "mse", "largest")


def write_scores(path: Path, comparison: Comparison) -> None:
    """The figures of each model as CSV, the best first."""
    unit = comparison.data.units.effort
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        heads = ["rank", "model", "parameters", "effort_unit"]
        for name in _COLUMNS:
            heads += [f"test_{name}", f"test_{name}_low", f"test_{name}_high"]
        writer.writerow([*heads, "train_rmse", "train_mse", "aic", "bic"])
        for rank, entry in enumerate(comparison.entries, start=1):
            about = [rank, entry.name, entry.outcome.parameters, unit]
            figures: list[float] = []
            for name in _COLUMNS:
                figures += getattr(entry.test, name).to_list()
            figures += [entry.train.rmse.value, entry.train.mse.value]
            figures += [entry.criteria["aic"], entry.criteria["bic"]]
            writer.writerow([*about, *map(repr, figures)])


def write_predictions(path: Path, comparison: Comparison) -> None:
    """Measured and estimated efforts of all rows as Parquet."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    data = comparison.data
    columns: dict[str, tuple[Any, str]] = {"time": (data.clock.time, "s")}
    if len(data.sources) > 1:
        rows_of_logs = [stop - start for start, stop in data.source_rows]
        names = np.repeat(data.sources, rows_of_logs)
        columns["log"] = (pa.array(names).dictionary_encode(), "")
    columns |= data.named_signals
    for name, values in data.extras.items():
        columns[f"{INPUT}{name}"] = (values, "")
    columns["effort"] = (data.effort, data.units.effort)
    columns["test"] = (comparison.test, "")
    for entry in comparison.entries:
        columns[f"effort:{entry.name}"] = (entry.predicted, data.units.effort)
    arrays: list[Any] = []
    fields: list[Any] = []
    for name, (values, unit) in columns.items():
        array = values if isinstance(values, pa.Array) else pa.array(values)
        arrays.append(array)
        fields.append(pa.field(name, array.type, metadata={"unit": unit}))
    floats = [field.name for field in fields if field.type == pa.float64()]
    others = [field.name for field in fields if field.name not in floats]
    # The open file and not its name: Arrow takes no name that is not UTF-8.
    with path.open("wb") as file:
        pq.write_table(
            pa.Table.from_arrays(arrays, schema=pa.schema(fields)),
            file,
            compression="zstd",
            use_dictionary=others,
            use_byte_stream_split=floats,
            write_page_checksum=True,
        )

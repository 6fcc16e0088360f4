"""A run is a folder: what was asked, what was read, what came out. The same log and settings give the same bytes.

::

    run.json             settings, versions, logs with digests, findings, the ranked figures, the recommendation,
                         the gapless stretches of rows and the digests of the other files
    table.csv            the ranking, a row a model
    models/NAME.json     each model with its numbers, parameters with intervals, and a digest
    models/final.json    the recommended model fitted to all rows, if asked for: no row judges it
    predictions.parquet  time, fields, slips, measured effort, the test mask, and each model's effort

A folder is written beside its final name and moved there when it is whole, so there is never half a run.
"""

from __future__ import annotations

import csv
import importlib.metadata
import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from erclutch import files
from erclutch._version import __version__
from erclutch.errors import RunError
from erclutch.export.exported_step import named_after
from erclutch.files import file_digest, plain_words, whole_folder
from erclutch.fit.standing import Standing, standing_of_run
from erclutch.logs.keywords import told_alike
from erclutch.models.load import load_model
from erclutch.models.model import Model
from erclutch.models.model_file import digest_of, keeps_digest, require_schema
from erclutch.models.model_titles import id_of, titles_of
from erclutch.runs.run_shape import GUARDED, file_name, require_shape
from erclutch.signals.recording import LogFacts
from erclutch.signals.shown import Shown, one_line, presenter

if TYPE_CHECKING:
    from erclutch.fit.comparison import Comparison, RankedModel
    from erclutch.fit.outcome import AnyOutcome, FitOutcome

RUN_SCHEMA = 2
#: What the model of all rows is called where a model of a run is named, and its file.
FINAL, _FINAL_FILE = "final", "models/final.json"
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
        write_json(folder / _FINAL_FILE, comparison.final.model.to_dict())
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


@dataclass(frozen=True, repr=False)
class Run(Shown):
    """A run read back.

    Attributes:
        folder: where it lies.
        body: run.json.
    """

    folder: Path
    body: Mapping[str, Any]

    def __repr__(self) -> str:
        chosen = self.entry(self.body["recommended"])
        rmse, share = chosen["test"]["rmse"][0], chosen["test"]["share"][0]
        error = f"RMSE {rmse:.4g} {self.body['units']['effort']} on {self.body['test_rows']} rows held out"
        return one_line(
            self,
            self.folder.name,
            f"{len(self.body['ranking'])} models",
            f"{self.standing.word} {chosen['title']}",
            error,
            f"{share:.1%} of the standard deviation",
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Models, best test error first."""
        return tuple(entry["name"] for entry in self.body["ranking"])

    @cached_property
    def titles(self) -> Mapping[str, str]:
        """What each model is called in plain words, by its name."""
        return titles_of(self.names)

    def id_of(self, name: str) -> str:
        """The id of a model in this run: ``m1`` for the first of the ranking."""
        return id_of(self.names.index(name))

    @property
    def reading(self) -> Mapping[str, Any]:
        """How the logs were read, as options of `erclutch fit`; the next logs are read in the same way."""
        return self.body.get("reading") or self.body.get("told") or {}

    @property
    def c_name(self) -> str:
        """Prefix of the C names of an export where none is given: after the first log, such as ``damper_model``."""
        return named_after(Path(str(self.body["logs"][0]["name"])).stem)

    def entry(self, name: str) -> Mapping[str, Any]:
        """What run.json says of a model, which is named by its specification or its id.

        Raises:
            RunError: no such model.
        """
        for place, entry in enumerate(self.body["ranking"]):
            if name in (entry["name"], id_of(place)):
                return entry
        known = ", ".join(f"{id_of(place)} ({name})" for place, name in enumerate(self.names))
        raise RunError(f"no model {name!r}", where=str(self.folder), remedy=f"Choose one of {known}")

    def file(self, name: str) -> Path:
        """Path of a file whose digest run.json holds, once it has been checked.

        Raises:
            RunError: the file is missing, cannot be read, or was changed.
        """
        path = self.folder / name
        try:
            found = file_digest(path)
        except OSError as error:
            raise RunError(
                f"cannot be read: {error.strerror or error}",
                where=str(path),
                remedy="Restore the file, or fit the log again",
            ) from error
        if found != self.body["files"][name]:
            raise RunError("changed after the run", where=str(path), remedy="Restore the file, or fit the log again")
        return path

    def report(self) -> Any:
        """The report, to be shown in a notebook; `erclutch report` writes it as a file.

        Raises:
            RunError: a file of the run is missing or was changed.
        """
        return presenter().report(self)

    def model(self, name: str | None = None) -> Model:
        """A model of the run; None gives the recommended one, "final" that one fitted to all rows.

        Raises:
            RunError: no such model, or its file was changed.
        """
        if name == FINAL:
            return self._final()
        entry = self.entry(name or self.recommended)
        path = self.model_file(entry["name"])
        model = load_model(path)
        said = entry["model_digest"], entry.get("model", entry["name"]), entry["dynamics"]
        if (model.to_dict()["digest"], model.name, dict(model.times)) != said:
            raise RunError("this is not the model that the run wrote", where=str(path), remedy="Fit the log again")
        return model

    def _final(self) -> Model:
        """The recommended model fitted to all rows."""
        if "final" not in self.body:
            problem = "the run keeps no model of all rows"
            raise RunError(problem, where=str(self.folder), remedy="Fit the log again with --final")
        path, said = self.folder / _FINAL_FILE, self.body["final"]
        model = load_model(path)
        if (model.to_dict()["digest"], model.name) != (said["model_digest"], said["name"]):
            raise RunError("this is not the model that the run wrote", where=str(path), remedy="Fit the log again")
        return model

    def model_file(self, name: str | None = None) -> Path:
        """The file of a model, see `model`; RunError for a model that is not there."""
        entry = self.entry(name or self.recommended)
        return self.folder / "models" / f"{file_name(str(entry['name']))}.json"

    @property
    def recommended(self) -> str:
        """The model that stands for the run where none is named.

        Raises:
            RunError: the run recommends none.
        """
        name, standing = str(self.body["recommended"]), self.standing
        if standing.why_none:
            remedy = "Turn a sign and fit again" if standing.sign_open else "Log more of what it has to explain"
            raise RunError(
                f"this run recommends no model: the nearest, {name}, {standing.why_none}",
                where=str(self.folder),
                remedy=f"{remedy}, or name a model all the same",
            )
        return name

    @property
    def standing(self) -> Standing:
        """Whether the model that the training rows chose is recommended, and why not."""
        return standing_of_run(self.body)


def outcome_of(run: Run, name: str | None) -> FitOutcome[Any]:
    """A model of a run as the outcome of its fit; None: the recommended one.

    Raises:
        RunError: as `Run.model`.
    """
    from erclutch.fit.outcome import Estimate, FitOutcome

    model = run.model(name)
    entry = run.entry(name or run.recommended)
    fit: dict[str, Any] = entry["fit"]
    estimates: list[Estimate] = []
    for number in fit["parameters"]:
        # JSON has no infinity: null stands for an end that the data do not give.
        low = -np.inf if number["low"] is None else number["low"]
        high = np.inf if number["high"] is None else number["high"]
        entries: dict[str, Any] = {**number, "low": low, "high": high}
        estimates.append(Estimate(**entries))
    return FitOutcome[Any](
        model=model,
        stop=fit["stop"],
        iterations=fit["iterations"],
        estimates=tuple(estimates),
        paper_form=fit["paper_form"],
        rank=fit["rank"],
        unknowns=fit["unknowns"],
        condition=np.inf if fit["condition"] is None else fit["condition"],
        bandwidth=fit["bandwidth_rows"],
        train_cost=(entry["train"]["mse"][0] or 0.0) * fit["train_rows"],
        train_rows=fit["train_rows"],
        weights=fit["weights"],
    )


def read_run(folder: str | Path) -> Run:
    """Read a run folder.

    Raises:
        RunError: not a run, of another schema, or changed since it was written.
    """
    path = Path(folder) / "run.json"
    if Path(folder).is_file():
        problem = "not a run: run.json lies in the folder of a run, and this is a file"
        raise RunError(problem, where=str(folder), remedy="Give the --out folder of erclutch fit")
    try:
        body = json.loads(path.read_text(encoding="utf-8"))
        json.dumps(body, ensure_ascii=False).encode()  # fails on half a character, which no report can hold
    except (OSError, ValueError, RecursionError) as error:
        what = f"not a run: run.json: {plain_words(error)}"
        raise RunError(what, where=str(folder), remedy="Give the --out folder of erclutch fit") from error
    if not isinstance(body, dict) or cast(dict[str, Any], body).get("kind") != "erclutch run":
        raise RunError("run.json does not describe a run", where=str(folder), remedy="Give the folder of erclutch fit")
    body = cast(dict[str, Any], body)
    require_schema(body.get("schema"), RUN_SCHEMA, str(folder))
    if not keeps_digest(body):
        raise RunError("run.json was changed after the run", where=str(folder), remedy="Fit the log again")
    try:
        require_shape(body)
    except ValueError as error:
        raise RunError(f"unfit entry: {error}", where=str(path), remedy="Fit the log again") from error
    return Run(Path(folder), body)

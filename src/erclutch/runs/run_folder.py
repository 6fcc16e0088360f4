"""A run is a folder: what was asked, what was read, what came out. The same log and settings give the same bytes.

::

    run.json             settings, versions, logs with digests, findings, the ranked figures, the recommendation,
                         the gapless stretches of rows and the digests of the other files
    table.csv            the ranking, a row a model
    models/NAME.json     each model with its numbers, parameters with intervals, and a digest
    predictions.parquet  time, fields, slips, measured effort, the test mask, and each model's effort

A folder is written beside its final name and moved there when it is whole, so there is never half a run.
"""

from __future__ import annotations

import csv
import importlib.metadata
import json
import platform
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast, get_args

import numpy as np

from erclutch import files
from erclutch._version import __version__
from erclutch.errors import RunError
from erclutch.files import file_digest, plain_words, whole_folder
from erclutch.fit.levenberg_marquardt import Stop
from erclutch.logs.assemble import Invalid
from erclutch.models.load import load_model
from erclutch.models.model import Model
from erclutch.models.model_file import (
    digest_of,
    keeps_digest,
    name_of,
    names_of,
    number_of,
    require_schema,
    truth_of,
    whole_number_of,
)
from erclutch.signals.device import DEVICES
from erclutch.signals.recording import NAMED_COLUMNS, Recording
from erclutch.signals.shown import Shown
from erclutch.signals.speed import DerivativeName
from erclutch.signals.units import is_written_well

if TYPE_CHECKING:
    from erclutch.fit.comparison import Comparison, RankedModel
    from erclutch.fit.outcome import FitOutcome

RUN_SCHEMA = 2
#: Files of a run whose digests stand in run.json, so that a changed one is noticed.
_GUARDED = ("table.csv", "predictions.parquet")
_LIBRARIES = ("numpy", "scipy", "pandas", "pyarrow", "pint")
_REMEDY = "Give --out a folder on a disk that can be written and has space"
#: The error of a run's folder that cannot be written.
unwritable = partial(files.unwritable, problem="the run cannot be written", remedy=_REMEDY)
#: Say before any work whether a run may be written to a folder.
may_write = partial(files.may_write, marker="run.json")


def write_run(
    folder: str | Path,
    comparison: Comparison,
    recordings: Sequence[Recording],
    *,
    reading: Mapping[str, Any] | None = None,
    force: bool = False,
) -> Path:
    """Write a comparison as a run folder.

    Args:
        folder: where; its parent must exist.
        comparison: what came out.
        recordings: the logs that went in.
        reading: how they were read, as JSON values: the options of `erclutch fit` that were given; None where they were
            not read by it, so that no command can repeat the run.
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
    _write_table(folder / "table.csv", comparison)
    _write_predictions(folder / "predictions.parquet", comparison)
    # What `fit --json` prints, and what keeps the folder together.
    whole = {**body, "files": {name: file_digest(folder / name) for name in _GUARDED}}
    write_json(folder / "run.json", {**whole, "digest": digest_of(whole)})


def write_models(folder: Path, models: Mapping[str, Model]) -> None:
    """Write each model as models/NAME.json."""
    (folder / "models").mkdir()
    for name, model in models.items():
        write_json(folder / "models" / f"{file_name(name)}.json", model.to_dict())


def file_name(model: str) -> str:
    """A model's name as a file's: no slash."""
    return model.replace("/", "_")


def write_json(path: Path, body: Mapping[str, Any]) -> None:
    """Plain JSON, indented, without numbers that are not finite."""
    path.write_text(json.dumps(body, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def run_to_dict(
    comparison: Comparison, recordings: Sequence[Recording], reading: Mapping[str, Any] | None
) -> dict[str, Any]:
    """Everything of a run but the rows, as JSON values."""
    data = comparison.data
    return {
        "kind": "erclutch run",
        "schema": RUN_SCHEMA,
        "versions": versions(),
        "settings": comparison.settings.to_dict(),
        "reading": None if reading is None else dict(reading),
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
        "ranking": [_entry_to_dict(e) for e in comparison.entries],
        "best": comparison.best,
        "recommended": comparison.recommended,
        **({} if comparison.recalibration is None else {"recalibration": dict(comparison.recalibration)}),
    }


def versions() -> dict[str, str]:
    """Versions of erclutch, Python and the libraries that figures depend on."""
    return {
        "erclutch": __version__,
        "python": platform.python_version(),
        **{name: importlib.metadata.version(name) for name in _LIBRARIES},
    }


def _entry_to_dict(entry: RankedModel) -> dict[str, Any]:
    fit = entry.outcome.to_dict()
    del fit["model"]
    return _finite(
        {
            "name": entry.name,
            **({"model": entry.outcome.model.name} if entry.label else {}),
            "file": f"models/{file_name(entry.name)}.json",
            "model_digest": entry.outcome.model.to_dict()["digest"],
            "title": entry.outcome.model.title,
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
            **({} if entry.by_log is None else {"rmse_by_log": list(entry.by_log)}),
            "fit": fit,
            "notes": list(entry.notes),
        }
    )


def _finite(value: Any) -> Any:
    """JSON has no infinity: null stands for it."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in cast(dict[str, Any], value).items()}
    if isinstance(value, list):
        return [_finite(item) for item in cast(list[Any], value)]
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
    pq.write_table(
        pa.Table.from_arrays(arrays, schema=pa.schema(fields)),
        path,
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

    @property
    def names(self) -> tuple[str, ...]:
        """Models, best test error first."""
        return tuple(entry["name"] for entry in self.body["ranking"])

    def entry(self, name: str) -> Mapping[str, Any]:
        """What run.json says of a model.

        Raises:
            RunError: no such model.
        """
        for entry in self.body["ranking"]:
            if entry["name"] == name:
                return entry
        raise RunError(f"no model {name!r}", where=str(self.folder), remedy=f"Choose one of {', '.join(self.names)}")

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
        return self.shown_by("report")

    def model(self, name: str | None = None) -> Model:
        """A model of the run; None gives the recommended one.

        Raises:
            RunError: no such model, or its file was changed.
        """
        wanted = name or str(self.body["recommended"])
        path = self.model_file(wanted)
        model, entry = load_model(path), self.entry(wanted)
        said = entry["model_digest"], entry.get("model", wanted), entry["dynamics"]
        if (model.to_dict()["digest"], model.name, dict(model.times)) != said:
            raise RunError("this is not the model that the run wrote", where=str(path), remedy="Fit the log again")
        return model

    def model_file(self, name: str | None = None) -> Path:
        """The file of a model, see `model`; RunError for a model that is not there."""
        return self.folder / "models" / f"{file_name(str(self.entry(name or self.body['recommended'])['name']))}.json"


def outcome_of(run: Run, name: str | None) -> FitOutcome[Any]:
    """A model of a run as the outcome of its fit; None: the recommended one.

    Raises:
        RunError: as `Run.model`.
    """
    from erclutch.fit.outcome import Estimate, FitOutcome

    model, entry = run.model(name), run.entry(name or str(run.body["recommended"]))
    fit: dict[str, Any] = entry["fit"]
    kept: dict[str, Any] = {
        key: fit[key] for key in ("stop", "iterations", "paper_form", "rank", "unknowns", "weights")
    }
    numbers: list[dict[str, Any]] = [dict(number) for number in fit["parameters"]]
    for number in numbers:
        ends = {"low": -np.inf, "high": np.inf}
        number.update({end: far for end, far in ends.items() if number[end] is None})
    return FitOutcome[Any](
        model=model,
        estimates=tuple(Estimate(**number) for number in numbers),
        condition=np.inf if fit["condition"] is None else fit["condition"],
        bandwidth=fit["bandwidth_rows"],
        train_cost=(entry["train"]["mse"][0] or 0.0) * fit["train_rows"],
        train_rows=fit["train_rows"],
        **kept,
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
        _BODY(body, "")
        _require_agreement(body)
    except ValueError as error:
        raise RunError(f"unfit entry: {error}", where=str(path), remedy="Fit the log again") from error
    return Run(Path(folder), body)


# --- the shape of run.json: as `run_to_dict` writes it, with further keys that a newer version may write -------------

#: Like the checks of `model_file`: raises ValueError with the name of an entry, its value and what was expected.
_Check = Callable[[Any, str], object]


class _Missing:
    """Stands for an entry that is not there, and is called so in messages."""

    def __repr__(self) -> str:
        return "missing"


def _checked_as(kind: type, what: str) -> _Check:
    """A value of a type."""

    def check(value: Any, name: str) -> None:
        if not isinstance(value, kind):
            raise ValueError(f"{name} is {value!r:.40}, not {what}")

    return check


_text, _object = _checked_as(str, "a text"), _checked_as(dict, "an object")


def _figure(value: Any, name: str) -> None:
    """A finite number of any size."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
        raise ValueError(f"{name} is {value!r:.40}, not a finite number")


def _count(value: Any, name: str) -> None:
    """How many of something."""
    if whole_number_of(value, name) < 0:
        raise ValueError(f"{name} is {value!r:.40}, not 0 or more")


def _period(value: Any, name: str) -> None:
    """A sampling period."""
    number_of(value, name, positive=True)


def _unit(value: Any, name: str) -> None:
    """A unit as it is written."""
    _text(value, name)
    if not is_written_well(value):
        raise ValueError(f"{name} is {value!r:.40}, not a unit such as N*m")


def _one_of(*choices: str) -> _Check:
    def check(value: Any, name: str) -> None:
        if value not in choices:
            raise ValueError(f"{name} is {value!r:.40}, not {' or '.join(choices)}")

    return check


def _either(what: str, *checks: _Check) -> _Check:
    """A value of one of several shapes."""

    def check(value: Any, name: str) -> None:
        for each in checks:
            with suppress(ValueError):
                each(value, name)
                return
        raise ValueError(f"{name} is {value!r:.40}, not {what}")

    return check


def _or_null(of: _Check) -> _Check:
    return lambda value, name: None if value is None else of(value, name)


def _list(of: _Check, least: int = 0) -> _Check:
    """A list of one shape."""

    def check(value: Any, name: str) -> None:
        if not isinstance(value, list) or len(cast(list[Any], value)) < least:
            raise ValueError(f"{name} is {value!r:.40}, not a list{f' of {least} or more' if least else ''}")
        for at, item in enumerate(cast(list[Any], value)):
            of(item, f"{name}[{at}]")

    return check


def _items(*of: _Check) -> _Check:
    """A list of these."""

    def check(value: Any, name: str) -> None:
        if not isinstance(value, list) or len(cast(list[Any], value)) != len(of):
            raise ValueError(f"{name} is {value!r:.40}, not a list of {len(of)}")
        for at, (each, item) in enumerate(zip(of, cast(list[Any], value), strict=True)):
            each(item, f"{name}[{at}]")

    return check


def _pairs(of: _Check) -> _Check:
    """An object whose every value is of one shape."""

    def check(value: Any, name: str) -> None:
        _object(value, name)
        for key, item in cast(dict[str, Any], value).items():
            of(item, f"{name}.{key}")

    return check


def _entries(required: Mapping[str, _Check], optional: Mapping[str, _Check] | None = None) -> _Check:
    """An object of these entries, and any others."""

    def check(value: Any, name: str) -> None:
        _object(value, name)
        found = {**dict.fromkeys(required, _Missing()), **cast(dict[str, Any], value)}
        for key, of in {**required, **(optional or {})}.items():
            if key in found:
                of(found[key], f"{name}.{key}".lstrip("."))

    return check


_NUMBERS = _list(_or_null(_figure))
_BANDED = _items(*(_or_null(_figure),) * 3)  # value, low, high


def _banded(high: _Check) -> _Check:
    """A number with its band, or null all over."""
    null = _checked_as(type(None), "null")
    return _either("a number with its band, or nulls", _items(_figure, _figure, high), _items(null, null, null))


_SCORE = _entries(
    {"rows": _count, "bias": _or_null(_figure), "share": _BANDED, "r2": _BANDED}
    | dict.fromkeys(("mse", "rmse", "largest"), _banded(_figure))
)
_COVERAGE = _entries({"rows": _count, "where": _text} | dict.fromkeys(("share", "worst", "width"), _figure))
_PARAMETER = _entries(
    {"name": name_of, "meaning": _text, "unit": _text, "value": _figure}
    | {"low": _or_null(_figure), "high": _or_null(_figure), "at_bound": _or_null(_one_of("lower", "upper"))}
)
_FIT = _entries(
    {
        "converged": truth_of,
        "stop": _one_of(*get_args(Stop)),
        "parameters": _list(_PARAMETER),
        "paper_form": _pairs(_or_null(_figure)),
        "condition": _or_null(_figure),
    }
    | dict.fromkeys(("iterations", "rank", "unknowns", "bandwidth_rows", "train_rows", "weights"), _count)
)
_RANKED = _entries(
    {
        **{"name": name_of, "file": _text, "model_digest": _text, "title": _text, "sound": truth_of},
        **{"dynamics": _pairs(_figure), "parameters_count": _count, "train": _SCORE, "test": _SCORE},
        "excess_over_best": _banded(_or_null(_figure)),
        "criteria": _entries(dict.fromkeys(("aic", "bic", "aic_independent", "bic_independent"), _or_null(_figure))),
        **{"folds_rmse": _NUMBERS, "fit": _FIT, "notes": _list(_text)},
    },
    {
        "model": name_of,
        "band": _entries({"held": _COVERAGE, "plain": _figure, "with_sensor": _or_null(_COVERAGE)}),
        "rmse_by_log": _BANDED,
    },
)
_SETTINGS = _entries(
    {
        **{"models": _list(_text), "lag": _text, "test": _either("a share or names", _figure, _list(_text))},
        **{"blocks": _count, "friction": _or_null(truth_of), "offset": _or_null(truth_of), "seed": _count},
        **{"past": _list(_either("a row or a time", _count, _text)), "polish": truth_of},
    }
)
_READING = _entries(
    {},
    dict.fromkeys(("time", *(name.lower() for name in NAMED_COLUMNS)), _text)
    | dict.fromkeys(("device", "rate", "lead", "begin", "end", "skip", "name_pattern", "map", "variable"), _text)
    | {"resample": _text, "invalid": _one_of(*get_args(Invalid)), "derivative": _one_of(*get_args(DerivativeName))}
    | dict.fromkeys(("input", "constant", "scale"), _list(_text))
    | {"cutoff": _figure, "window": _count},
)
_RECALIBRATION = _entries(
    dict.fromkeys(("run", "run_digest", "model", "way", "verdict"), _text)
    | {"share": _figure, "stretches": _count, "numbers": _pairs(_NUMBERS), "unseen_blocks_rmse": _pairs(_NUMBERS)}
)
_LOG = _entries(
    {"name": _text, "sha256": _text, "rows": _count, "segments": _count, "period_s": _period, "origin": _text}
    | {"mapping": _or_null(_items(_text, _text))}
)


_BODY = _entries(
    {
        "versions": _pairs(_text),
        "settings": _SETTINGS,
        "reading": _or_null(_READING),
        "device": _one_of(*DEVICES),
        "units": _entries(dict.fromkeys(("effort", "field", "slip"), _unit)),
        "logs": _list(_LOG, 1),
        "notes": _list(_text),
        "source_rows": _list(_items(_count, _count)),
        "spans": _list(_items(_count, _count, _or_null(_period))),
        "train_rows": _count,
        "test_rows": _count,
        "findings": _list(_entries(dict.fromkeys(("level", "subject", "message", "remedy"), _text))),
        "ranking": _list(_RANKED, 1),
        "best": _text,
        "recommended": _text,
        "files": _entries(dict.fromkeys(_GUARDED, _text)),
    },
    {"recalibration": _RECALIBRATION},
)


def _require_agreement(body: Mapping[str, Any]) -> None:
    """Refuse entries that do not agree with each other; see `_Check`."""
    names = names_of([entry["name"] for entry in body["ranking"]], "the names of the ranking")
    for key in ("best", "recommended"):
        if body[key] not in names:
            raise ValueError(f"{key} is {body[key]!r:.60}, not a model of the ranking")
    for at, entry in enumerate(body["ranking"]):
        if entry["file"] != f"models/{file_name(entry['name'])}.json":
            raise ValueError(f"ranking[{at}].file is {entry['file']!r:.60}, not that of {entry['name']!r:.60}")
        count = len(entry["fit"]["parameters"]) + entry["fit"]["weights"]
        if entry["parameters_count"] != count:
            raise ValueError(
                f"ranking[{at}].parameters_count is {entry['parameters_count']}, not {count} as in its fit"
            )
    if len(body["source_rows"]) != len(body["logs"]):
        raise ValueError(f"source_rows are {len(body['source_rows'])}, not one for each of {len(body['logs'])} logs")
    rows = body["train_rows"] + body["test_rows"]
    for key in ("source_rows", "spans"):
        edges = [0, *(stop for _, stop, *_ in body[key])]
        if [start for start, *_ in body[key]] != edges[:-1] or edges != sorted({*edges}) or edges[-1] != rows:
            raise ValueError(f"{key} are {body[key]!r:.40}, not stretches that cover the {rows} rows in order")

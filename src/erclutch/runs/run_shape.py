"""This is the shape of run.json as `written_run` writes it; a newer version may write further entries."""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any, cast, get_args

from erclutch.fit.solver.levenberg_marquardt import Stop
from erclutch.logs.plan import Invalid
from erclutch.models.model_file import name_of, names_of, number_of, truth_of, whole_number_of
from erclutch.models.model_titles import id_of
from erclutch.signals.device import DEVICES
from erclutch.signals.recording import NAMED_COLUMNS
from erclutch.signals.speed import DerivativeName
from erclutch.signals.units import is_written_well

RUN_SCHEMA = 2
#: Characters of a model's name that its file keeps: with the digest and the ending far below what a system takes.
_LONGEST_NAME = 150
#: What the model of all rows is called where a model of a run is named, and its file.
FINAL, FINAL_FILE = "final", "models/final.json"
#: Files of a run whose digests stand in run.json, so that a changed one is noticed.
GUARDED = ("table.csv", "predictions.parquet")
#: Stands ahead of the name of a further input, where its column is kept beside the fields and slips.
INPUT = "input:"
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


_text = _checked_as(str, "a text")
_object = _checked_as(dict, "an object")


def _figure(value: Any, name: str) -> None:
    """A finite number of any size."""
    # True is an int to Python.
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not abs(value) <= sys.float_info.max:
        raise ValueError(f"{name} is {value!r:.40}, not a finite number")


#: The largest count that a float and a page's script hold exactly. No log comes near it.
MOST_COUNTED = 2**53


def _count(value: Any, name: str) -> None:
    """How many of something."""
    number = whole_number_of(value, name)
    if number < 0:
        raise ValueError(f"{name} is {value!r:.40}, not 0 or more")
    if number > MOST_COUNTED:
        raise ValueError(f"{name} is {value!r:.40}, above {MOST_COUNTED}")


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
            raise ValueError(
                f"{name} is {value!r:.40}, not a list{f' of {least} or more' if least else ''}"
            )
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


def _entries(
    required: Mapping[str, _Check], optional: Mapping[str, _Check] | None = None
) -> _Check:
    """An object of these entries, and any others."""

    def check(value: Any, name: str) -> None:
        _object(value, name)
        entries = {**dict.fromkeys(required, _Missing()), **cast(dict[str, Any], value)}
        for key, of in {**required, **(optional or {})}.items():
            if key in entries:
                of(entries[key], f"{name}.{key}".lstrip("."))

    return check


_NUMBERS = _list(_or_null(_figure))
_BANDED = _items(*(_or_null(_figure),) * 3)  # value, low, high


def _banded(high: _Check) -> _Check:
    """A number with its band, or null all over."""
    null = _checked_as(type(None), "null")
    return _either(
        "a number with its band, or nulls", _items(_figure, _figure, high), _items(null, null, null)
    )


_SCORE = _entries(
    {"rows": _count, "bias": _or_null(_figure), "share": _BANDED, "r2": _BANDED}
    | dict.fromkeys(("mse", "rmse", "largest"), _banded(_figure))
)
_COVERAGE = _entries(
    {"rows": _count, "where": _text} | dict.fromkeys(("share", "worst", "width"), _figure)
)
_PARAMETER = _entries(
    {"name": name_of, "meaning": _text, "unit": _text, "value": _figure}
    | {
        "low": _or_null(_figure),
        "high": _or_null(_figure),
        "at_bound": _or_null(_one_of("lower", "upper")),
    }
)
_FIT = _entries(
    {
        "converged": truth_of,
        "stop": _one_of(*get_args(Stop)),
        "parameters": _list(_PARAMETER),
        "paper_form": _pairs(_or_null(_figure)),
        "condition": _or_null(_figure),
    }
    | dict.fromkeys(
        ("iterations", "rank", "unknowns", "bandwidth_rows", "train_rows", "weights"), _count
    )
)
_RANKED = _entries(
    {
        **{
            "name": name_of,
            "file": _text,
            "model_digest": _text,
            "title": _text,
            "sound": truth_of,
        },
        **{
            "dynamics": _pairs(_figure),
            "parameters_count": _count,
            "train": _SCORE,
            "test": _SCORE,
        },
        "excess_over_best": _banded(_or_null(_figure)),
        "criteria": _entries(
            dict.fromkeys(("aic", "bic", "aic_independent", "bic_independent"), _or_null(_figure))
        ),
        **{"folds_rmse": _NUMBERS, "fit": _FIT, "notes": _list(_text)},
    },
    {
        "id": _text,
        "model": name_of,
        "band": _entries({"held": _COVERAGE, "plain": _figure, "with_sensor": _or_null(_COVERAGE)}),
        "rmse_by_log": _BANDED,
        "validation_rmse": _BANDED,
        "turned_down": _text,
    },
)
_SETTINGS = _entries(
    {
        **{
            "models": _list(_text),
            "lag": _text,
            "test": _either("a share or names", _figure, _list(_text)),
        },
        **{
            "blocks": _count,
            "friction": _or_null(truth_of),
            "offset": _or_null(truth_of),
            "seed": _count,
        },
        **{"past": _list(_either("a row or a time", _count, _text)), "polish": truth_of},
    }
)
_READING = _entries(
    {},
    dict.fromkeys(("time", *(name.lower() for name in NAMED_COLUMNS)), _text)
    | dict.fromkeys(
        ("device", "rate", "lead", "begin", "end", "skip", "name_pattern", "map", "variable"), _text
    )
    | {
        "resample": _text,
        "invalid": _one_of(*get_args(Invalid)),
        "derivative": _one_of(*get_args(DerivativeName)),
        "decimal": _one_of(".", ","),
        "keep_values": _checked_as(bool, "true or false"),
    }
    | dict.fromkeys(("input", "constant", "scale", "zero"), _list(_text))
    | {"cutoff": _figure, "window": _count},
)
_RECALIBRATION = _entries(
    dict.fromkeys(("run", "run_digest", "model", "way", "verdict"), _text)
    | {
        "share": _figure,
        "stretches": _count,
        "numbers": _pairs(_NUMBERS),
        "unseen_blocks_rmse": _pairs(_NUMBERS),
    }
)
_LOG = _entries(
    {
        "name": _text,
        "sha256": _text,
        "rows": _count,
        "segments": _count,
        "period_s": _period,
        "origin": _text,
    }
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
        "findings": _list(
            _entries(dict.fromkeys(("level", "subject", "message", "remedy"), _text))
        ),
        "ranking": _list(_RANKED, 1),
        "best": _text,
        "recommended": _text,
        "files": _entries(dict.fromkeys(GUARDED, _text)),
    },
    {
        "recalibration": _RECALIBRATION,
        "chosen_by": _text,
        "told": _object,
        "final": _entries({"name": _text, "rows": _count, "model_digest": _text}),
    },
)


def reading_of(body: Mapping[str, Any]) -> Mapping[str, Any]:
    """How a run read its logs, as options of `erclutch fit`: as the command was told, or as Python was."""
    return body.get("reading") or body.get("told") or {}


def require_shape(body: Mapping[str, Any]) -> None:
    """Refuse a run.json whose entries are not of these shapes, or do not agree with each other.

    Raises:
        ValueError: the entry, its value and what was expected.
    """
    _BODY(body, "")
    names = names_of([entry["name"] for entry in body["ranking"]], "the names of the ranking")
    for key in ("best", "recommended"):
        if body[key] not in names:
            raise ValueError(f"{key} is {body[key]!r:.60}, not a model of the ranking")
    for at, entry in enumerate(body["ranking"]):
        if entry.get("id", id_of(at)) != id_of(at):
            raise ValueError(f"ranking[{at}].id is {entry['id']!r:.60}, not {id_of(at)!r}")
        if entry["file"] != f"models/{file_name(entry['name'])}.json":
            raise ValueError(
                f"ranking[{at}].file is {entry['file']!r:.60}, not that of {entry['name']!r:.60}"
            )
        count = len(entry["fit"]["parameters"]) + entry["fit"]["weights"]
        if entry["parameters_count"] != count:
            raise ValueError(
                f"ranking[{at}].parameters_count is {entry['parameters_count']}, not {count} as in its fit"
            )
    if len(body["source_rows"]) != len(body["logs"]):
        raise ValueError(
            f"source_rows are {len(body['source_rows'])}, not one for each of {len(body['logs'])} logs"
        )
    rows = body["train_rows"] + body["test_rows"]
    for key in ("source_rows", "spans"):
        starts = [start for start, *_ in body[key]]
        edges = [0, *(stop for _, stop, *_ in body[key])]
        follow_each_other = starts == edges[:-1]
        rising = edges == sorted({*edges})
        if not follow_each_other or not rising or edges[-1] != rows:
            raise ValueError(
                f"{key} are {body[key]!r:.40}, not stretches that cover the {rows} rows in order"
            )


def file_name(model: str) -> str:
    """A model's name as a file's, on any system.

    A name may end in the columns that are the law's inputs, which may be called anything and at any length. What no
    file can be called is replaced, and a digest keeps such names apart.
    """
    plain = model.replace("/", "_")
    whole = re.sub(r"[^A-Za-z0-9_+@.,() -]", "_", plain)
    if whole == plain and len(whole) <= _LONGEST_NAME:
        return plain
    digest = hashlib.sha256(model.encode()).hexdigest()[:8]
    return f"{whole[:_LONGEST_NAME]}-{digest}"

"""An export is a folder: the target's files, model.json, and export.json that says what was asked and lists digests.

It is written beside its final name and moved there when it is whole.
"""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any, cast

from erclutch import files
from erclutch._version import __version__
from erclutch.errors import ErclutchError, ExportError
from erclutch.export.exported_step import ExportedStep, ExportOptions
from erclutch.export.step_record import step_of
from erclutch.files.given_files import file_digest, plain_words, small_json
from erclutch.models.load import load_model
from erclutch.models.model_file import UNFIT, number_of, pair_of, require_schema, truth_of
from erclutch.registry import Plugin, require
from erclutch.signals.speed import Derivative

SCHEMA = 1
KIND = "erclutch export"
_MARKER = "export.json"
_REMEDY = "Give --out a folder on a disk that can be written and has space"
#: Say before any work whether an export may be written to a folder.
may_write = partial(files.may_write, marker=_MARKER, what="an export", kind=ExportError)
#: The error of an export's folder that cannot be written.
unwritable = partial(
    files.unwritable, problem="the export cannot be written", remedy=_REMEDY, kind=ExportError
)


def finish(
    step: ExportedStep,
    options: ExportOptions,
    target: Plugin,
    folder: Path,
) -> None:
    """Write model.json and export.json, after all other files."""
    _write_json(folder / "model.json", step.model.to_dict())
    used = {**asdict(options), "name": step.name, "period": step.period}
    for switch in ("alarms", "adapt"):
        if not used[switch]:  # left out, as files of earlier versions have none
            del used[switch]
    written = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    body: dict[str, Any] = {
        "kind": KIND,
        "schema": SCHEMA,
        "erclutch": __version__,
        "target": target.name,
        "name": step.name,
        "model": step.model.name,
        "digest": step.digest,
        "options": used,
        "files": {str(path.relative_to(folder)): file_digest(path) for path in written},
    }
    needed = list(step.model.plugins)
    if not target.own:
        needed.append(target)
    if needed:
        body["plugins"] = [plugin.to_dict() for plugin in needed]
    _write_json(folder / _MARKER, body)


def _write_json(path: Path, body: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(body, indent=1, allow_nan=False) + "\n", encoding="utf-8")


@dataclass(frozen=True)
class Exported:
    """An export read back.

    Attributes:
        folder: where it lies.
        target: name of the target.
        step: made again from its model and options.
    """

    folder: Path
    target: str
    step: ExportedStep


def read_export(folder: str | Path) -> Exported:
    """Read an export, checking that its files are those that were written.

    Raises:
        ExportError: no export, one of a newer schema, or a file that was changed.
    """
    place = Path(folder)
    where = str(place)
    again = "Export the model again"
    try:
        read: Any = small_json(place / _MARKER)
    except (OSError, ValueError) as error:
        remedy = "Give a folder that erclutch export wrote"
        if (place / "run.json").is_file():
            remedy = f"This is a run: erclutch export {shlex.quote(str(place))} makes one"
        problem = f"not an export: export.json: {plain_words(error)}"
        if isinstance(error, FileNotFoundError):
            problem = f"not an export: {'it holds no export.json' if place.is_dir() else 'there is no such folder'}"
        raise ExportError(problem, where=where, remedy=remedy) from error
    body = cast(dict[str, Any], read) if isinstance(read, dict) else {}
    if body.get("kind") != KIND:
        raise ExportError("export.json does not describe an export", where=where, remedy=again)
    require_schema(body.get("schema"), SCHEMA, where, error=ExportError, older=again)
    require(body.get("plugins", []), where)
    try:
        for name, digest in body["files"].items():
            if not (place / name).is_file():
                raise ExportError(f"{name} is missing", where=where, remedy=again)
            if file_digest(place / name) != digest:
                raise ExportError(f"{name} was changed after the export", where=where, remedy=again)
        asked = body["options"]
        period = asked["period"]
        limits = asked["limits"]
        options = ExportOptions(
            name=str(asked["name"]),
            precision=asked["precision"],
            period=None if period is None else number_of(period, "period", positive=True),
            inputs=asked["inputs"],
            derivative=Derivative(**asked["derivative"]),
            limits=None if limits is None else pair_of(limits, "limits"),
            alarms=truth_of(asked.get("alarms", False), "alarms"),
            adapt=truth_of(asked.get("adapt", False), "adapt"),
        )
        step = step_of(load_model(place / "model.json"), options)
        if step.digest != body["digest"]:
            raise ExportError("model.json is not the exported model", where=where, remedy=again)
        return Exported(place, str(body["target"]), step)
    except ErclutchError:
        raise
    except UNFIT as error:
        raise ExportError(f"unfit entry: {error!s:.200}", where=where, remedy=again) from error

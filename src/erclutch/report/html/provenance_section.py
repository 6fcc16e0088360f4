"""This section states provenance: logs with digests, settings, versions, seed, and the command that repeats the run."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import PurePath
from typing import Any

from erclutch.errors import TYPED
from erclutch.fit.comparison import Settings
from erclutch.models.model_titles import id_of
from erclutch.report.html.section import Section
from erclutch.report.numbers.number_text import count, number
from erclutch.report.numbers.run_material import Material


def _fill(material: Material) -> dict[str, Any]:
    """Where every number comes from."""
    body = material.body
    reading = material.run.reading
    logs: list[dict[str, Any]] = []
    # Files that said which column is which, each once.
    mappings: dict[tuple[str, str], dict[str, str]] = {}
    for log in body["logs"]:
        logs.append(
            {
                "name": log["name"],
                "origin": log["origin"] or "RECORDING",
                "rows": count(log["rows"]),
                "gaps": log["segments"] - 1,
                "rate": f"{number(1.0 / log['period_s'], 5)} Hz",
                "sha256": log["sha256"],
            }
        )
        if log.get("mapping"):
            name, sha256 = log["mapping"]
            mappings[name, sha256] = {"name": name, "sha256": sha256}
    specifications: list[tuple[str, str, str]] = []
    for place, entry in enumerate(body["ranking"]):
        specifications.append((id_of(place), entry["title"], entry["name"]))
    return {
        "logs": logs,
        "means": material.badge_means,
        "mappings": list(mappings.values()),
        "notes": body["notes"],
        "settings": [(key, setting_text(value)) for key, value in body["settings"].items()],
        "reading": [(key, setting_text(value)) for key, value in reading.items()],
        "versions": list(body["versions"].items()),
        "specifications": specifications,
        "command": command_of(body),
        "digest": body["digest"],
        "rows": f"{count(body['train_rows'])} to fit, {count(body['test_rows'])} held out",
    }


PROVENANCE = Section(
    "provenance", "Where every number comes from", "Provenance", _fill, folded=True, printed=True
)


def setting_text(value: Any) -> str:
    """A setting's value as text."""
    if value is None:
        return "by device"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return ", ".join(map(str, value)) or "none"  # pyright: ignore[reportUnknownArgumentType, reportUnknownVariableType]
    return str(value)


def command_of(body: Mapping[str, Any]) -> str:
    """The command that gives the run again from its logs; empty where it was not made by ``erclutch fit``."""
    if body["reading"] is None:
        return ""
    logs: list[str] = []  # files, each once
    for log in body["logs"]:
        # Of "log.xlsx: Test A" the file is log.xlsx, which holds several recordings.
        name = str(log["name"])
        file, colon, _ = name.partition(": ")
        if not colon or not PurePath(file).suffix:
            file = name
        if file not in logs:
            logs.append(file)
    reading: list[str] = []
    for key, value in body["reading"].items():
        name = TYPED.get(str(key), str(key).replace("_", "-"))
        reading += _option(name, value)

    recalibration: Mapping[str, Any] | None = body.get("recalibration")
    if recalibration is not None:
        words = ["erclutch", "recalibrate", str(recalibration["run"]), *logs, *reading]
        for key in ("model", "share", "stretches"):
            words += _option(key, recalibration[key])
        return shlex.join([*words, "--out", "RUN"])

    words = ["erclutch", "fit", *logs, *reading]
    settings = body["settings"]
    usual = Settings().to_dict()
    for key in dict.fromkeys(("models", "test", *usual)):
        # As JSON has it.
        usual_value = list(usual[key]) if isinstance(usual[key], tuple) else usual[key]
        if settings[key] != usual_value:
            words += _option(key, settings[key])
    if "final" in body:
        words.append("--final")
    return shlex.join([*words, "--out", "RUN"])


def _option(name: str, value: Any) -> list[str]:
    """Words of an option for its value."""
    if isinstance(value, bool):
        return [f"--{name}" if value else f"--no-{name}"]
    if name in ("models", "past"):
        return [f"--{name}", *map(str, value)]
    if isinstance(value, list):
        return [word for item in value for word in (f"--{name}", str(item))]  # pyright: ignore[reportUnknownVariableType, reportUnknownArgumentType]
    # A value that starts with a minus sign would be taken for an option.
    text = str(value)
    return [f"--{name}={text}"] if text.startswith("-") else [f"--{name}", text]

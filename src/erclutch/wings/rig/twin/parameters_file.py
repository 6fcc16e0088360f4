"""A rig is written as the TOML file that `load_rig` reads: value, unit, source, range, and what a calibration found."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from erclutch.errors import RunError
from erclutch.files import whole_file
from erclutch.wings.rig.twin.parameters import SECTIONS, ParameterEntry, RigParameters

_HEADER = """\
# A rig: two coaxial ER clutches on a ball screw, as in Huang and Ishikawa. For the digital TWIN, not a measurement.
#
# Copy this file, change what differs on your rig, give it as --rig-file my.toml. A file may hold only what it changes.
# source: paper (the article), catalogue (a data sheet), assumed (a plausible value), calibrated (see [calibration]),
# given (by a user's file). range: plausible values, and the limits of a calibration. Of a calibrated value: start,
# where the search and its prior began, and its 95 % interval.
"""
_TITLES = {
    "supply": "high-voltage unit, one channel a clutch",
    "drive": "motor, gears and housings",
    "screw": "output shaft, torque meter, ball screw and table",
    "excitation": "how commands are drawn (section III-B)",
}


def write_rig(path: str | Path, rig: RigParameters, calibration: Mapping[str, Any] | None = None) -> Path:
    """Write a rig, whole or not at all.

    Args:
        path: the file, ending in .toml.
        rig: its parameters.
        calibration: how its calibrated values were made: numbers, texts, and tables of them.

    Raises:
        RunError: another ending, or it cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() != ".toml":
        raise RunError(f"a rig cannot end in {path.suffix!r}", where=str(path), remedy="End it in .toml")
    with whole_file(path) as partial:
        partial.write_text(rig_text(rig, calibration), encoding="utf-8")
    return path


def rig_text(rig: RigParameters, calibration: Mapping[str, Any] | None = None) -> str:
    """A rig as TOML."""
    lines = [_HEADER.rstrip()]
    if calibration:
        lines += ["", "[calibration]", *(f"{key} = {_plain(value)}" for key, value in calibration.items())]
    for section in SECTIONS:
        title = _TITLES.get(section)
        lines += ["", f"[{section}]" + (f"  # {title}" if title else "")]
        lines += [f"{key} = {_entry_text(entry)}" for key, entry in rig.entries[section].items()]
    return "\n".join(lines) + "\n"


def _entry_text(entry: ParameterEntry) -> str:
    pairs = {"value": entry.value, "unit": entry.unit, "source": entry.source, "range": (entry.low, entry.high)}
    pairs |= {"start": entry.start, "interval": entry.interval, "meaning": entry.meaning}
    return _plain({key: value for key, value in pairs.items() if value is not None})


def _plain(value: Any) -> str:
    """A value as TOML: numbers, texts (JSON strings are TOML strings), arrays and inline tables."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(str(k))} = {_plain(v)}" for k, v in value.items()) + " }"  # pyright: ignore
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_plain(v) for v in value) + "]"  # pyright: ignore
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value, ensure_ascii=False)


def _key(name: str) -> str:
    return name if name.replace("_", "").replace("-", "").isalnum() else json.dumps(name)

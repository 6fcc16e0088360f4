"""A rig is written as the TOML file that `load_rig` reads: value, unit, source, range, and what a calibration found."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

from erclutch.errors import RunError
from erclutch.files import whole_file
from erclutch.wings.rig.twin.parameters import SECTIONS, RigParameters

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


def write_rig(
    path: str | Path,
    rig: RigParameters,
    calibration: Mapping[str, Any] | None = None,
) -> Path:
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
        raise RunError(
            f"a rig cannot end in {path.suffix!r}", where=str(path), remedy="End it in .toml"
        )
    with whole_file(path) as partial:
        partial.write_text(rig_text(rig, calibration), encoding="utf-8")
    return path


def rig_text(rig: RigParameters, calibration: Mapping[str, Any] | None = None) -> str:
    """A rig as TOML."""
    lines = [_HEADER.rstrip()]
    if calibration:
        lines += [
            "",
            "[calibration]",
            *(f"{key} = {_plain(value)}" for key, value in calibration.items()),
        ]
    for section in SECTIONS:
        title = f"  # {_TITLES[section]}" if section in _TITLES else ""
        lines += ["", f"[{section}]{title}"]
        for key, entry in rig.entries[section].items():
            pairs = {
                "value": entry.value,
                "unit": entry.unit,
                "source": entry.source,
                "range": (entry.low, entry.high),
                "start": entry.start,
                "interval": entry.interval,
                "meaning": entry.meaning,
            }
            known = {name: value for name, value in pairs.items() if value is not None}
            lines.append(f"{key} = {_plain(known)}")
    return "\n".join(lines) + "\n"


def _plain(value: Any) -> str:
    """A value as TOML: numbers, texts (JSON strings are TOML strings), arrays and inline tables."""
    if isinstance(value, Mapping):
        pairs: list[str] = []
        for key, each in cast("Mapping[str, Any]", value).items():
            is_bare = key.replace("_", "").replace("-", "").isalnum()
            pairs.append(f"{key if is_bare else json.dumps(key)} = {_plain(each)}")
        return f"{{ {', '.join(pairs)} }}"
    if isinstance(value, list | tuple):
        numbers = ", ".join(_plain(each) for each in cast("Sequence[Any]", value))
        return f"[{numbers}]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value, ensure_ascii=False)

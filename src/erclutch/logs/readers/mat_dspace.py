"""A recording of dSPACE ControlDesk in a MATLAB file.

The layout was learnt from public scripts that read such recordings, not from dSPACE's documents:
HoriFujimotoLab/AcqTools ``dmat2struct.m`` (``X(1).Data``, ``Y(k).Data``, ``Y(k).Name`` like
``"Model Root"/"Encoder"/"In1"``); A. Schellenberg's ``plotOutputDSpace.m`` (the period is
``Capture.SamplingPeriod*Capture.Downsampling``); scripts that cut recordings by ``X(Y(i).XIndex).Data``, so XIndex
counts from 1 and X may be an array of rasters. No file from a dSPACE machine was at hand: the test files are built so.
"""

from __future__ import annotations

import re
from collections import Counter
from typing import Any, cast

import numpy as np

from erclutch.logs.readers.found_recordings import Found, told_apart
from erclutch.logs.readers.vectors import columns_of, vector

_GENERIC = re.compile(r"(?:In|Out)\d*|Value|Signal", re.I)
#: Between the parts of a path, and neither inside of quotes nor of a unit in brackets.
_LONGEST = 2000  # letters of a signal's path
_SLASH = re.compile(r'/(?=(?:[^"]*"[^"]*")*[^"]*$)(?![^\[(]*[\])])')


def structs_of(node: Any) -> list[dict[str, Any]]:
    """The structs of a node that is one, or a list of them."""
    items = cast("list[Any]", node) if isinstance(node, list) else [node]
    return [cast("dict[str, Any]", item) for item in items if isinstance(item, dict)]


def dspace(fields: dict[str, Any], signals: list[dict[str, Any]]) -> Found:
    """A ControlDesk recording: one time axis (raster) X, signals Y.

    Sure of Name, Data and 1-based XIndex, which public scripts use; less so of Unit, taken where it is a text.
    """
    recording = Found({}, notes=["laid out as a dSPACE ControlDesk recording"])

    rasters = [int(_scalar(signal.get("XIndex"), 1.0)) for signal in signals]  # counted from 1
    raster = Counter(rasters).most_common(1)[0][0]
    kept = [signal for signal, own in zip(signals, rasters, strict=True) if own == raster]
    others = len(signals) - len(kept)
    if others:
        recording.notes.append(f"{others} signals on other time axes than X({raster}) left out")

    axes = structs_of(fields["X"])
    axis = axes[raster - 1] if 0 < raster <= len(axes) else {}
    time = vector(axis.get("Data"))
    rows = None
    if time is not None and time.size > 1:
        rows = time.size
        recording.columns["time"] = time
        recording.units["time"] = _text(axis.get("Unit")) or "s"

    # A signal that two plots show may be there twice.
    once: list[dict[str, Any]] = []
    for signal in kept:
        same_name = [other for other in once if other["Name"] == signal["Name"]]
        if not any(np.array_equal(other["Data"], signal["Data"]) for other in same_name):
            once.append(signal)
    labels = told_apart(_short_names([str(signal["Name"]) for signal in once]))
    for label, signal in zip(labels, once, strict=True):
        columns = columns_of(label, signal["Data"], rows)
        if not columns:
            recording.notes.append(f"signal {label} has no {rows or ''} samples: left out")
        for name, values in columns:
            recording.columns[name] = values
            recording.units[name] = _text(signal.get("Unit"))

    capture: Any = fields.get("Capture")
    if isinstance(capture, dict):
        settings = cast("dict[str, Any]", capture)
        sampling = _scalar(settings.get("SamplingPeriod"), 0.0)  # [s]
        period = sampling * _scalar(settings.get("Downsampling"), 1.0)
        recording.period = period if 0.0 < period < float("inf") else None
    for key in ("Description", "RTProgram", "Comment"):
        text = _text(fields.get(key))
        if text:
            recording.metadata[key] = text
    return recording


def _text(node: Any) -> str | None:
    return node if isinstance(node, str) and node.strip() else None


def _scalar(node: Any, default: float) -> float:
    """The first number of a node; the default where there is none or it is not finite."""
    numbers = vector(node)
    if numbers is None or not numbers.size or not np.isfinite(numbers[0]):
        return default
    return float(numbers[0])


def _short_names(paths: list[str]) -> list[str]:
    """Shortest ends of paths like ``"Model Root"/"Encoder"/"In1"`` that differ, without the port at the end."""
    parts_of: list[list[str]] = []
    lengths: list[int] = []  # how many parts of a path are its name
    for path in paths:
        path_of_model = path[:_LONGEST]  # a search for slashes takes the square of its length
        parts = [part.strip().strip("\"'") for part in _SLASH.split(path_of_model) if part.strip()]
        parts = parts or [path]
        ends_in_port = len(parts) > 1 and _GENERIC.fullmatch(parts[-1])
        parts_of.append(parts)
        lengths.append(2 if ends_in_port else 1)

    # Names that are alike take one part more, until all of them differ or are whole.
    names: list[str] = []
    for _ in range(max(map(len, parts_of), default=1) + 1):
        names = ["/".join(parts[-length:]) for parts, length in zip(parts_of, lengths, strict=True)]
        for place, name in enumerate(names):
            if names.count(name) > 1:
                lengths[place] += 1

    portless: list[str] = []
    for name in names:
        block, _, port = name.rpartition("/")
        portless.append(block if block and _GENERIC.fullmatch(port) else name)
    return portless if len({*portless}) == len(portless) else names

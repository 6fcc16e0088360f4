"""A MATLAB file holds its recording in dSPACE structures, structs and matrices, or plain vectors of the workspace.

The layout of a ControlDesk recording was learnt from public scripts that read them, not from dSPACE's documents:
HoriFujimotoLab/AcqTools ``dmat2struct.m`` (``X(1).Data``, ``Y(k).Data``, ``Y(k).Name`` like
``"Model Root"/"Encoder"/"In1"``); A. Schellenberg's ``plotOutputDSpace.m`` (the period is
``Capture.SamplingPeriod*Capture.Downsampling``); scripts that cut recordings by ``X(Y(i).XIndex).Data``, so XIndex
counts from 1 and X may be an array of rasters. No file from a dSPACE machine was at hand: the test files are built so.
"""

from __future__ import annotations

import json
import re
import shlex
from collections import Counter
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError
from erclutch.signals.array import Array

_TIME = re.compile(r"t|time|zeit|tout|timestamps?|time_?s", re.I)
_GENERIC = re.compile(r"(?:In|Out)\d*|Value|Signal", re.I)


@dataclass
class Found:
    """One recording: columns by label with units, and what else was said about it."""

    columns: dict[str, Array]
    units: dict[str, str | None] = field(default_factory=dict[str, "str | None"])
    period: float | None = None
    constants: dict[str, float] = field(default_factory=dict[str, float])
    metadata: dict[str, str] = field(default_factory=dict[str, str])
    notes: list[str] = field(default_factory=list[str])


def choose(tree: dict[str, Any], variable: str | None) -> Found:
    """The only recording of the file, or the one that ``variable`` names.

    Raises:
        LogError: none, several without a choice, or no variable of that name.
    """
    if variable is not None and variable not in tree:
        problem = f"there is no variable '{variable}' (there are: {_listed(tree)})"
        raise LogError(problem, remedy="Give one of these as --variable")
    if variable is not None:
        found = _structure(variable, tree[variable]) or _workspace({variable: tree[variable]})
        if found is None:
            remedy = f"Give another as --variable ({_listed(tree)})"
            raise LogError(f"variable '{variable}' holds no recording", remedy=remedy)
        return found
    recordings = {name: found for name, node in tree.items() if (found := _structure(name, node)) is not None}
    loose = _workspace({name: node for name, node in tree.items() if name not in recordings})
    if loose is not None and not recordings:
        return loose
    if len(recordings) == 1 and loose is None:
        name, found = next(iter(recordings.items()))
        found.notes.insert(0, f"recording read from variable {name}")
        return found
    if recordings:
        names = [*recordings, *(loose.columns if loose else ())]
        problem = f"the file holds several recordings: {', '.join(names)}"
        raise LogError(problem, remedy=f"Choose one, such as --variable {shlex.quote(names[0])}, or --variable all")
    hint = " (objects such as timeseries cannot be read: save ts.Time and ts.Data as vectors)"
    objects = any(node is None for node in tree.values())
    problem = f"no recording in the variables {_listed(tree)}{hint if objects else ''}"
    raise LogError(problem, remedy="Save a struct of vectors, or vectors of one length")


def recordings(tree: dict[str, Any]) -> list[str]:
    """Variables that are a recording each."""
    return [name for name, node in tree.items() if _structure(name, node) is not None]


def _listed(tree: dict[str, Any]) -> str:
    names = list(tree)
    return ", ".join(names[:20]) + (", ..." if len(names) > 20 else "") if names else "none"


def _structure(name: str, node: Any) -> Found | None:
    """A recording inside one struct, or None."""
    if not isinstance(node, dict):
        return None
    fields = cast("dict[str, Any]", node)
    signals = _structs(fields.get("Y")) if "X" in fields else []
    if signals and all({"Name", "Data"} <= one.keys() for one in signals):
        return _dspace(fields, signals)
    if isinstance(fields.get("signals"), dict | list):
        return _simulink(fields)
    lower = {key.lower(): value for key, value in fields.items()}
    if isinstance(lower.get("time"), np.ndarray) and isinstance(lower.get("data"), np.ndarray):
        return _workspace({"time": lower["time"], name: lower["data"]})
    return _workspace(fields)


def _structs(node: Any) -> list[dict[str, Any]]:
    items = cast("list[Any]", node) if isinstance(node, list) else [node]
    return [cast("dict[str, Any]", item) for item in items if isinstance(item, dict)]


def _dspace(fields: dict[str, Any], signals: list[dict[str, Any]]) -> Found:
    """A ControlDesk recording: one time axis (raster) X, signals Y.

    Sure of Name, Data and 1-based XIndex, which public scripts use; less so of Unit, taken where it is a text.
    """
    axes = _structs(fields["X"])
    indices = [int(_scalar(one.get("XIndex"), 1.0)) for one in signals]
    raster = Counter(indices).most_common(1)[0][0]
    axis = axes[raster - 1] if 0 < raster <= len(axes) else {}
    found = Found({}, notes=["laid out as a dSPACE ControlDesk recording"])
    others = sum(index != raster for index in indices)
    if others:
        found.notes.append(f"{others} signals on other time axes than X({raster}) left out")
    kept = [one for one, index in zip(signals, indices, strict=True) if index == raster]
    time = _vector(axis.get("Data"))
    rows = time.size if time is not None and time.size > 1 else None
    if time is not None and rows:
        found.columns["time"], found.units["time"] = time, _text(axis.get("Unit")) or "s"
    for label, one in zip(_short_names([str(one["Name"]) for one in kept]), kept, strict=True):
        parts = _columns_of(label, one["Data"], rows)
        found.columns.update(parts)
        found.units.update({part: _text(one.get("Unit")) for part, _ in parts})
        if not parts:
            found.notes.append(f"signal {label} has no {rows or ''} samples: left out")
    capture = cast("dict[str, Any]", fields["Capture"]) if isinstance(fields.get("Capture"), dict) else {}
    step = _scalar(capture.get("SamplingPeriod"), 0.0) * _scalar(capture.get("Downsampling"), 1.0)
    found.period = step if 0.0 < step < float("inf") else None
    found.metadata = {key: text for key in ("Description", "RTProgram", "Comment") if (text := _text(fields.get(key)))}
    return found


def _text(node: Any) -> str | None:
    return node if isinstance(node, str) and node.strip() else None


def _scalar(node: Any, default: float) -> float:
    """The first number of a node; the default where there is none or it is not finite."""
    array = _vector(node)
    return float(array[0]) if array is not None and array.size and np.isfinite(array[0]) else default


def _short_names(paths: list[str]) -> list[str]:
    """Shortest ends of paths like ``"Model Root"/"Encoder"/"In1"`` that differ, without the port at the end."""
    split = [
        [part.strip().strip('"') for part in re.split(r'/(?=(?:[^"]*"[^"]*")*[^"]*$)', path) if part.strip()] or [path]
        for path in paths
    ]
    lengths = [2 if len(parts) > 1 and _GENERIC.fullmatch(parts[-1]) else 1 for parts in split]
    names: list[str] = []
    for _ in range(max(map(len, split), default=1) + 1):
        names = ["/".join(parts[-length:]) for parts, length in zip(split, lengths, strict=True)]
        lengths = [length + (names.count(name) > 1) for name, length in zip(names, lengths, strict=True)]
    ends = [name.rpartition("/") for name in names]
    shorter = [end[0] if end[0] and _GENERIC.fullmatch(end[2]) else name for name, end in zip(names, ends, strict=True)]
    return shorter if len(set(shorter)) == len(shorter) else names


def _simulink(fields: dict[str, Any]) -> Found | None:
    """A structure with time: ``time`` and ``signals`` with ``values`` and ``label``."""
    nodes: dict[str, Any] = {"time": fields["time"]} if "time" in fields else {}
    for number, one in enumerate(_structs(fields["signals"]), start=1):
        label = one.get("label")
        nodes[label if isinstance(label, str) and label else f"signal{number}"] = one.get("values")
    return _workspace(nodes)


def _workspace(nodes: dict[str, Any]) -> Found | None:
    """Vectors and matrices of one length as a recording; single numbers become constants, other lengths a note."""
    flat = {name: _flat(node) for name, node in nodes.items()}
    arrays = {name: array for name, array in flat.items() if array is not None}
    constants = {name: float(array.ravel()[0]) for name, array in arrays.items() if array.size == 1}
    arrays = {name: array for name, array in arrays.items() if array.size > 1}
    if not arrays:
        return None
    time = next((array for name, array in arrays.items() if _TIME.fullmatch(name) and array.ndim == 1), None)
    lengths = Counter(max(array.shape) for array in arrays.values())
    rows = int(time.size) if time is not None else max(lengths, key=lambda length: (lengths[length], length))
    found = Found({}, constants=constants, metadata={n: text for n, text in nodes.items() if isinstance(text, str)})
    units = _own_units(found.metadata)
    for name, array in arrays.items():
        parts = _columns_of(name, array, rows)
        found.columns.update(parts)
        found.units.update({part: units.get(part) for part, _ in parts})
        if not parts:
            found.notes.append(f"variable {name} has {max(array.shape)} samples, not {rows}: left out")
        elif array.ndim == 2 and array.shape[0] != rows:
            found.notes.append(f"matrix {name} is {array.shape[0]} x {array.shape[1]}: its rows are taken as columns")
    return found if found.columns else None


def _own_units(metadata: dict[str, str]) -> dict[str, str]:
    """Units that erclutch writes beside its vectors."""
    try:
        units: Any = json.loads(metadata.get("erclutch_units", "{}"))
    except (ValueError, RecursionError):
        return {}
    pairs = cast("dict[str, Any]", units).items() if isinstance(units, dict) else ()
    return {name: unit for name, unit in pairs if isinstance(unit, str)}


def _flat(node: Any) -> np.ndarray[Any, Any] | None:
    """Numbers as a vector or a matrix; None for anything else, and for arrays of more dimensions."""
    if not isinstance(node, np.ndarray):
        return None
    squeezed = cast("np.ndarray[Any, Any]", node).squeeze()
    return squeezed if squeezed.dtype.kind in "biuf" and squeezed.ndim <= 2 else None


def _vector(node: Any) -> Array | None:
    array = _flat(node)
    return None if array is None or array.ndim == 2 else np.atleast_1d(array).astype(np.float64)


def _columns_of(name: str, node: Any, rows: int | None) -> list[tuple[str, Array]]:
    """A vector as one column, a matrix as name_1, name_2, ...; nothing where no side has the length ``rows``."""
    array = _flat(node)
    if array is None or array.size < 2 or (rows is not None and rows not in array.shape):
        return []
    if array.ndim == 1:
        return [(name, array.astype(np.float64))]
    upright = array if array.shape[0] == (rows or max(array.shape)) else array.T
    return [(f"{name}_{index + 1}", upright[:, index].astype(np.float64)) for index in range(upright.shape[1])]

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
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.readers.found_recordings import (
    ALL,
    JOINT,
    Found,
    RecordingNames,
    columns_of,
    joined_by_time,
    listed,
    matrix_of,
    of_vectors,
    rows_of,
    time_of,
    vector,
)

_DEEPEST = 6  # structs inside of structs
_GENERIC = re.compile(r"(?:In|Out)\d*|Value|Signal", re.I)


def choose(tree: dict[str, Any], variable: str | None) -> Found:
    """The only recording of the file, or the one that ``variable`` names.

    Single numbers beside the recordings, such as a sampling rate, hold for each of them.

    Raises:
        LogError: none, several without a choice, or no variable of that name.
    """
    found = _chosen(tree, variable)
    numbers = {name: array for name, node in tree.items() if (array := vector(node)) is not None and array.size == 1}
    beside = {name: float(array[0]) for name, array in numbers.items()}
    found.constants = {**beside, **found.constants}
    return found


def _chosen(tree: dict[str, Any], variable: str | None) -> Found:
    """The recording that is asked for; see `choose`."""
    at_top = any(_structure(name, node) is not None for name, node in tree.items()) or _workspace(tree) is not None
    within = _within(tree)
    asked = [each.strip() for each in (variable or "").split(JOINT)]
    if not at_top or any(each in within and each not in tree for each in asked):
        tree = within
    opened = _opened(tree)
    one_struct = any(_structure(name, node) is not None for name, node in tree.items())
    if variable not in tree and (variable in opened or not one_struct):
        tree = opened  # beside a struct that is a recording, cells and struct arrays are what somebody kept with it
    if variable == ALL:
        raise RecordingNames([name for name, node in tree.items() if _structure(name, node) is not None])
    if len(asked) > 1 and variable not in tree:
        chosen = {each: _structure(each, tree.get(each)) for each in asked}
        if all(chosen.values()):
            return joined_by_time({each: found for each, found in chosen.items() if found is not None}, "variable")
    if variable is not None and variable not in tree:
        problem = f"there is no variable '{variable}' (there are: {listed(tree)})"
        raise LogError(problem, remedy="Give one of these as --variable")
    if variable is not None:
        found = _structure(variable, tree[variable]) or _workspace(_opened({variable: tree[variable]}))
        if found is None:
            remedy = f"Give another as --variable ({listed(tree)})"
            raise LogError(f"variable '{variable}' holds no recording", remedy=remedy)
        return found
    recordings = {name: found for name, node in tree.items() if (found := _structure(name, node)) is not None}
    loose = _vectors({name: node for name, node in tree.items() if name not in recordings})
    if loose is not None and not recordings:
        return loose
    if len(recordings) == 1 and loose is None:
        name, found = next(iter(recordings.items()))
        found.notes.insert(0, f"recording read from variable {name}")
        return found
    if recordings:
        names = [*recordings, *(loose.columns if loose else ())]
        problem = f"the file holds several recordings: {', '.join(names)}"
        timed = sorted(
            (each for each, found in recordings.items() if time_of(found)), key=lambda each: -rows_of(recordings[each])
        )
        more = f", or join them by time: --variable {shlex.quote(JOINT.join(timed))}" if len(timed) > 1 else ""
        remedy = f"Choose one, such as --variable {shlex.quote(names[0])}, or --variable all{more}"
        raise LogError(problem, remedy=remedy)
    hint = " (objects such as timeseries cannot be read: save ts.Time and ts.Data as vectors)"
    objects = any(node is None for node in tree.values())
    problem = f"no recording in the variables {listed(tree)}{hint if objects else ''}"
    raise LogError(problem, remedy="Save a struct of vectors, or vectors of one length")


def _within(tree: dict[str, Any], depth: int = 0) -> dict[str, Any]:
    """The variables, and in place of structs that hold structs, texts and numbers what is in them: ``log.speed``."""
    within: dict[str, Any] = {}
    for name, node in tree.items():
        inner = cast("dict[str, Any]", node) if isinstance(node, dict) else dict[str, Any]()
        structs: dict[str, Any] = {f"{name}.{key}": each for key, each in inner.items() if isinstance(each, dict)}
        plain = all(
            isinstance(each, dict | str) or (isinstance(each, np.ndarray) and each.size < 2) for each in inner.values()
        )
        if structs and plain and depth < _DEEPEST and _structure(name, node) is None:
            within |= _within(structs, depth + 1)
        else:
            within[name] = node
    return within


def _opened(nodes: dict[str, Any]) -> dict[str, Any]:
    """Cells and struct arrays opened: several structs are name(1), name(2), ..., and vectors name_1, name_2, ...

    A matrix with a column for each text of a cell is opened too, and its columns are called so.
    """
    opened: dict[str, Any] = {}
    texts = [cast("list[str]", node) for node in nodes.values() if _all_of(node, str)]
    for name, node in nodes.items():
        matrix = matrix_of(node)
        labels = [
            each for each in texts if matrix is not None and len(each) in matrix.shape[1:] and len({*each}) == len(each)
        ]
        if _all_of(node, dict):
            items = cast("list[dict[str, Any]]", node)
            signals = [_signal(item, f"{name}_{place}") for place, item in enumerate(items, start=1)]
            if all(signal is not None for signal in signals):
                opened |= dict(signal for signal in signals if signal is not None)
            elif len(items) == 1:
                opened[name] = items[0]
            else:
                opened |= {f"{name}({place})": item for place, item in enumerate(items, start=1)}
        elif _all_of(node, np.ndarray) and all(vector(each) is not None for each in cast("list[Any]", node)):
            items = cast("list[Any]", node)
            fitting = [each for each in texts if len(each) == len(items) == len({*each}) and all(each)]
            usual = [f"{name}_{place}" for place in range(1, len(items) + 1)]
            opened |= dict(zip(fitting[0] if len(fitting) == 1 else usual, items, strict=True))
        elif matrix is not None and len(labels) == 1:
            opened |= {label or f"{name}_{place + 1}": matrix[:, place] for place, label in enumerate(labels[0])}
        elif not _all_of(node, str):
            opened[name] = node
    return opened


def _signal(item: dict[str, Any], usual: str) -> tuple[str, Any] | None:
    """Label and numbers of a struct that is one signal: one vector, with its name and its unit as texts."""
    vectors = [node for node in item.values() if (array := vector(node)) is not None and array.size > 1]
    if len(vectors) != 1 or any(isinstance(node, dict | list) for node in item.values()):
        return None
    texts = {key.lower(): node for key, node in item.items() if isinstance(node, str) and node.strip()}
    label = next((texts[key] for key in ("name", "label", "signal", "channel") if key in texts), usual)
    unit = next((texts[key] for key in ("unit", "units") if key in texts), "")
    return f"{label} [{unit}]" if unit else label, vectors[0]


def _all_of(node: Any, kind: type) -> bool:
    """Whether a node is a cell or a struct array of one kind, and not empty."""
    items = cast("list[Any]", node) if isinstance(node, list) else []
    return bool(items) and all(isinstance(item, kind) for item in items)


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
        return _workspace({"time": lower["time"], name.rpartition(".")[2]: lower["data"]})
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
    time = vector(axis.get("Data"))
    rows = time.size if time is not None and time.size > 1 else None
    if time is not None and rows:
        found.columns["time"], found.units["time"] = time, _text(axis.get("Unit")) or "s"
    for label, one in zip(_short_names([str(one["Name"]) for one in kept]), kept, strict=True):
        parts = columns_of(label, one["Data"], rows)
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
    array = vector(node)
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
    """Vectors of the workspace, of cells and of struct arrays in it."""
    return _vectors(_opened(nodes))


def _vectors(nodes: dict[str, Any]) -> Found | None:
    """Vectors of the workspace, with the units that erclutch writes beside its own."""
    found = of_vectors(nodes)
    if found is not None:
        found.units |= _own_units(found.metadata)
    return found


def _own_units(metadata: dict[str, str]) -> dict[str, str]:
    """Units that erclutch writes beside its vectors."""
    try:
        units: Any = json.loads(metadata.get("erclutch_units", "{}"))
    except (ValueError, RecursionError):
        return {}
    pairs = cast("dict[str, Any]", units).items() if isinstance(units, dict) else ()
    return {name: unit for name, unit in pairs if isinstance(unit, str)}

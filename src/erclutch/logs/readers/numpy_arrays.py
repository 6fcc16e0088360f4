"""Arrays of NumPy, one (.npy) or several (.npz): vectors of one length, or a matrix, are a recording.

No object in a file is made, so nothing of it is run.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import found_recordings, reader_in_child
from erclutch.logs.readers.budget import budget_of, take_zip
from erclutch.logs.readers.found_recordings import Found, listed
from erclutch.logs.readers.mat_cells import opened
from erclutch.logs.readers.told_units import take_told_units, texts_in
from erclutch.logs.readers.trials import trials_in, without_names
from erclutch.logs.readers.vectors import of_vectors
from erclutch.logs.table import Table

_ONE = b"\x93NUMPY"
_ZIP = b"PK\x03\x04"
_PICKLE = b"\x80"  # its first byte since Python 2.3
_OF_NAMES = frozenset({"name", "names", "label", "labels", "column", "columns"})
_NONE = "the file holds no vectors of numbers of one length"
_OBJECTS = "Python objects, which may run programs and are never opened"
_SAVE_NUMBERS = (
    "Save each signal as an array of numbers: numpy.savez(NEW, time=..., speed=..., torque=...)"
)


def find(path: str, variable: str | None) -> Table:
    """The child's work."""
    file = Path(path)
    budget = budget_of(file)
    with file.open("rb") as content:
        head = content.read(len(_ONE))
    is_one = head == _ONE
    if head.startswith(_PICKLE):  # numpy.load opens it too, where it is allowed to
        raise LogError(f"the file holds no arrays but {_OBJECTS}", remedy=_SAVE_NUMBERS)
    if not is_one:
        take_zip(file, budget)
    nodes: dict[str, np.ndarray[Any, Any]] = {}
    # Of arrays with names for their columns.
    tables: dict[str, dict[str, np.ndarray[Any, Any]]] = {}
    of_objects: list[str] = []
    of_others: list[str] = []
    archive: Any = nullcontext() if is_one else np.load(file, allow_pickle=False)
    with archive as loaded:
        for name in [file.stem] if is_one else loaded.files:
            try:
                array: Any = np.load(file, allow_pickle=False) if is_one else loaded[name]
            except ValueError as error:
                if "Object arrays" not in str(error):
                    raise
                of_objects.append(name)
                continue
            if isinstance(array, bytes):  # a part of the archive that is no array
                (of_objects if array.startswith(_PICKLE) else of_others).append(name)
                continue
            budget.take_cells(array.size)
            if array.dtype.names:
                tables[name] = {each: np.asarray(array[each]) for each in array.dtype.names}
                nodes |= tables[name]
            else:
                nodes[name] = np.asarray(array)
    left_out = [f"{listed(of_objects)}: {_OBJECTS}"] if of_objects else []
    left_out += [f"{listed(of_others)}: no array of NumPy"] if of_others else []

    # Tables of the same columns are recordings; single numbers beside them hold for each of these.
    names = [name for table in tables.values() for name in table]
    if len({*names}) < len(names):
        beside = {name: node for name, node in nodes.items() if name not in names}
        numbers = {name: node for name, node in beside.items() if node.size == 1}
        arrays = beside.keys() - numbers
        left_out += [f"{listed(sorted(arrays))}: arrays beside several tables"] if arrays else []
        of_tables: dict[str, Found] = {}
        for name, table in tables.items():
            recording = of_vectors({**numbers, **table})
            if recording is not None:
                recording.notes.extend(f"left out: {what}" for what in left_out)
                of_tables[name] = recording
        return found_recordings.chosen(of_tables, variable, "array", _NONE)

    texts, told = _texts_in(nodes)
    trials = trials_in(nodes, [*texts.values()])
    if trials:
        found = {name: of_vectors(columns) for name, columns in trials.items()}
        whole = {name: recording for name, recording in found.items() if recording is not None}
        return found_recordings.chosen(whole, variable, "trial", "the file holds no trials")
    # As many texts as a matrix has columns give these their names and units; one text names one vector.
    nodes = _renamed(nodes, told)
    recording = of_vectors(opened({**nodes, **texts, **told}))
    if recording is None and left_out:
        raise LogError(f"the arrays are no numbers: {'; '.join(left_out)}", remedy=_SAVE_NUMBERS)
    if recording is not None:
        recording.notes.extend(f"left out: {what}" for what in left_out)
        take_told_units(recording, texts_in({**told, **texts}))
    if recording is None and (unnamed := without_names(nodes)) is not None:
        raise unnamed
    recordings = {file.stem: recording} if recording is not None else {}
    return found_recordings.chosen(recordings, variable, "arrays", _NONE)


def _renamed(
    nodes: Mapping[str, np.ndarray[Any, Any]], told: Mapping[str, str]
) -> dict[str, np.ndarray[Any, Any]]:
    """The arrays, with the name that a text beside a vector tells: y is the force where ``y_names`` is force."""
    names: dict[str, str] = {}
    for key, text in told.items():
        vector, _, what = key.rpartition("_")
        if what in _OF_NAMES and vector in nodes and nodes[vector].ndim == 1 and text not in nodes:
            names[vector] = text
    return {names.get(name, name): node for name, node in nodes.items()}


def _texts_in(
    nodes: Mapping[str, np.ndarray[Any, Any]],
) -> tuple[dict[str, list[str]], dict[str, str]]:
    """Arrays of several texts, and of one text, by their names."""
    lists: dict[str, list[str]] = {}
    single: dict[str, str] = {}
    for name, node in nodes.items():
        if node.dtype.kind == "U" and node.size == 1:
            single[name] = str(node.item())
        elif node.dtype.kind == "U":
            lists[name] = [str(text) for text in node.ravel()]
    return lists, single


READER = LogReader(
    suffixes=(".npz", ".npy"),
    claims=lambda head: head.startswith(_ONE) or (head.startswith(_ZIP) and b".npy" in head[:300]),
    **reader_in_child.in_child("numpy_arrays"),
    tells_damage="seen in .npz, whose parts have checksums; an .npy has none",
)

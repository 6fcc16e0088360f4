"""Arrays of NumPy, one (.npy) or several (.npz): vectors of one length, or a matrix, are a recording.

No object in a file is made, so nothing of it is run.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.budget import budget_of, take_zip
from erclutch.logs.readers.found_recordings import listed
from erclutch.logs.table import Table

_ONE = b"\x93NUMPY"


def find(path: str, variable: str | None) -> Table:
    """The child's work."""
    file = Path(path)
    budget = budget_of(file)
    with file.open("rb") as content:
        is_one = content.read(len(_ONE)) == _ONE
    if not is_one:
        take_zip(file, budget)
    loaded: Any = None if is_one else np.load(file, allow_pickle=False)
    nodes: dict[str, np.ndarray[Any, Any]] = {}
    of_objects: list[str] = []
    for name in [file.stem] if is_one else loaded.files:
        try:
            array: Any = np.load(file, allow_pickle=False) if is_one else loaded[name]
        except ValueError as error:
            if "Object arrays" not in str(error):
                raise
            of_objects.append(name)
            continue
        budget.take_cells(array.size)
        if array.dtype.names:  # a table with names
            nodes |= {each: np.asarray(array[each]) for each in array.dtype.names}
        else:
            nodes[name] = np.asarray(array)
    found = found_recordings.of_vectors(nodes)
    if of_objects:
        what = f"{listed(of_objects)}: Python objects, which may run programs and are never opened"
        if found is None:
            remedy = "Save each signal as an array of numbers: numpy.savez(NEW, time=..., speed=..., torque=...)"
            raise LogError(f"the arrays are no numbers: {what}", remedy=remedy)
        found.notes.append(f"left out: {what}")
    recordings = {file.stem: found} if found is not None else {}
    return found_recordings.chosen(recordings, variable, "arrays", "the file holds no vectors of numbers of one length")


def _claims(head: bytes) -> bool:
    return head.startswith(_ONE) or (head.startswith(b"PK\x03\x04") and b".npy" in head[:300])


READER = LogReader(
    suffixes=(".npz", ".npy"),
    claims=_claims,
    **found_recordings.in_child("numpy_arrays"),
    tells_damage="seen in .npz, whose parts have checksums; an .npy has none",
)

"""Arrays of NumPy, one (.npy) or several (.npz): vectors of one length, or a matrix, are a recording.

No object in a file is made, so nothing of it is run.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.budget import budget_of, take_zip
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
    loaded: Any = np.load(file, allow_pickle=False)
    arrays = {file.stem: loaded} if is_one else {name: loaded[name] for name in loaded.files}
    nodes: dict[str, np.ndarray[Any, Any]] = {}
    for name, array in arrays.items():
        budget.take_cells(array.size)
        if array.dtype.names:  # a table with names
            nodes |= {each: np.asarray(array[each]) for each in array.dtype.names}
        else:
            nodes[name] = np.asarray(array)
    found = found_recordings.of_vectors(nodes)
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

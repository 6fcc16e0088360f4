"""HDF5 logs hold a recording in each group with vectors, or in each table; an attribute of a vector gives its unit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from erclutch.logs.labels import sample_period
from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import found_recordings, mat
from erclutch.logs.readers.budget import budget_of
from erclutch.logs.readers.found_recordings import Found
from erclutch.logs.readers.mat_tree import stored_values
from erclutch.logs.table import Table

_UNITS = ("unit", "units", "Unit", "Units")


def _texts(attributes: Any) -> dict[str, str]:
    """Attributes that are one text or number, as texts."""
    single: dict[str, Any] = {key: np.ravel(value)[0] for key, value in attributes.items() if np.size(value) == 1}
    plain = {key: v.decode("utf-8", "replace") if isinstance(v, bytes) else v for key, v in single.items()}
    return {key: str(value) for key, value in plain.items() if np.isscalar(value)}


def find(path: str, variable: str | None) -> Table:
    """The child's work. Links and data outside the file are never followed."""
    import h5py

    budget = budget_of(Path(path))
    groups: dict[str, dict[str, Any]] = {}
    units: dict[str, dict[str, str | None]] = {}
    texts: dict[str, dict[str, str]] = {}

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or item.external or item.is_virtual or item.ndim > 2:
            return
        budget.take_names()
        budget.take_cells(-(-item.size * item.dtype.itemsize // 8))  # by their shape: none of them is read yet
        group, _, label = name.rpartition("/")
        values = stored_values(item)
        fields = {field: values[field] for field in values.dtype.names or ()}
        place, own = name if fields else group or "/", _texts(item.attrs)
        groups.setdefault(place, {}).update(fields or {label: values})
        units.setdefault(place, {})[label] = next((own[key] for key in _UNITS if key in own), None)
        texts.setdefault(place, {**_texts(file.attrs), **_texts(item.parent.attrs), **(own if fields else {})})

    with h5py.File(path, "r") as file:
        file.visititems(visit)
    found: dict[str, Found] = {}
    for place, nodes in groups.items():
        recording = found_recordings.of_vectors(nodes)
        if recording is not None:
            stated = sample_period(texts[place])
            recording.period = stated[0] if stated else None
            recording.units, recording.metadata, found[place] = units[place], texts[place], recording
    return found_recordings.chosen(found, variable, "group", "no group of the file holds vectors of numbers")


_DAMAGE = "seen only in data sets that were written with checksums (fletcher32)"
READER = LogReader(
    (".h5", ".hdf5"), lambda head: head[:8] == mat.HDF5, **found_recordings.in_child("hdf5"), tells_damage=_DAMAGE
)

"""HDF5 logs hold a recording in each group with vectors, or in each table; attributes of a data set give its unit."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from erclutch.logs.labels import sample_period
from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import found_recordings, mat
from erclutch.logs.readers.found_recordings import Found
from erclutch.logs.table import Table

_UNITS = ("unit", "units", "Unit", "Units")


def _text(value: Any) -> str:
    """An attribute as text: one text or number; "" for anything else."""
    single = value.ravel()[0] if isinstance(value, np.ndarray) and value.size == 1 else value
    single = single.decode("utf-8", "replace") if isinstance(single, bytes) else single
    return str(single) if isinstance(single, (str, int, float, np.number)) else ""


def _find(path: str, variable: str | None) -> Table:
    """The child's work. Links and data outside the file are never followed."""
    import h5py

    groups: dict[str, dict[str, Any]] = {}
    units: dict[str, dict[str, str | None]] = {}
    texts: dict[str, dict[str, str]] = {}

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or item.external or item.is_virtual or item.ndim > 2:
            return
        group, _, label = name.rpartition("/")
        place = name if item.dtype.names else group or "/"
        parts: dict[str, Any] = {label: item}
        if item.dtype.names:
            rows = item[()]
            parts = {field: rows[field] for field in item.dtype.names}
        groups.setdefault(place, {}).update({key: np.asarray(part[()]) for key, part in parts.items()})
        own = next((text for key in _UNITS if key in item.attrs and (text := _text(item.attrs[key]))), None)
        units.setdefault(place, {}).update(dict.fromkeys(parts, own) if not item.dtype.names else {})
        above = {**file.attrs, **item.parent.attrs, **(item.attrs if item.dtype.names else {})}
        texts.setdefault(place, {key: _text(value) for key, value in above.items()})

    with h5py.File(path, "r") as file:
        file.visititems(visit)
    found: dict[str, Found] = {}
    for place, nodes in groups.items():
        recording = found_recordings.of_vectors(nodes)
        if recording is not None:
            recording.units, recording.metadata = units[place], texts[place]
            stated = sample_period(texts[place])
            recording.period = stated[0] if stated else None
            found[place] = recording
    return found_recordings.chosen(found, variable, "group", "no group of the file holds vectors of numbers")


_DAMAGE = "seen only in data sets that were written with checksums (fletcher32) or packed (gzip)"
_READ = found_recordings.read_in_child("erclutch.logs.readers.hdf5")
READER = LogReader((".h5", ".hdf5", ".hdf", ".nc"), lambda head: head[:8] == mat.HDF5, _READ, tells_damage=_DAMAGE)

if __name__ == "__main__":
    sys.exit(found_recordings.serve(_find))

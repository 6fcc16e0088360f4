"""Logs that ``numpy.savez`` wrote: each array is a column, its name may hold a unit in brackets, such as ``F [N]``."""

from __future__ import annotations

import io
import zipfile

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.labels import name_columns
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.table import Table

_LARGEST = 1 << 32  # bytes, unpacked
_REMEDY = "Save vectors of one length: numpy.savez(file, **{'t [s]': t, 'F [N]': F})"


def _claims(head: bytes) -> bool:
    return head.startswith(b"PK\x03\x04") and b".npy" in head[30:130]


def _read(source: LogSource) -> Table:
    try:
        size = sum(part.file_size for part in zipfile.ZipFile(io.BytesIO(source.data)).infolist())
        if size > _LARGEST:
            raise LogError(f"the arrays take {size / 1e9:.3g} GB", remedy="Split the log", where=source.name)
        with np.load(io.BytesIO(source.data), allow_pickle=False) as file:
            arrays = {label: np.asarray(file[label], np.float64) for label in file.files}
    except (ValueError, TypeError, EOFError, OSError, KeyError, NotImplementedError, zipfile.BadZipFile) as error:
        raise LogError(f"the file holds no arrays of numbers ({error})", remedy=_REMEDY, where=source.name) from error
    rows = max((array.size for array in arrays.values() if array.ndim == 1), default=0)
    kept = {label: array for label, array in arrays.items() if array.shape == (rows,)}
    left = [
        f"array {label} has the shape {array.shape}: left out" for label, array in arrays.items() if label not in kept
    ]
    names, units, renamed = name_columns(list(kept))
    columns = dict(zip(names, kept.values(), strict=True))
    notes = (*left, *renamed)
    return Table(source.name, columns, dict(zip(names, units, strict=True)), source.digest, notes=notes)


READER = LogReader((".npz",), _claims, _read, tells_damage="seen: the parts of the file have checksums")

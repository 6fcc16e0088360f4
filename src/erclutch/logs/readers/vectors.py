"""Vectors and matrices under names, as MATLAB, HDF5 and NumPy keep them, become a recording."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, cast

import numpy as np

from erclutch.logs.columns.levels_in_names import stated_in, without_field
from erclutch.logs.readers.found_recordings import TIME, Found
from erclutch.signals.array import Array

#: From so many rows of a recording on, a sample more or less is its end and no other clock.
_LONG = 100
_FEW_SAMPLES = 2


def of_vectors(nodes: Mapping[str, Any]) -> Found | None:
    """Vectors and matrices of one length as a recording; single numbers become constants, other lengths a note.

    Returns None where no node holds two numbers or more. Texts become metadata.
    """
    constants: dict[str, float] = {}
    metadata: dict[str, str] = {}
    arrays: dict[str, np.ndarray[Any, Any]] = {}
    notes: list[str] = []
    unreadable: dict[str, str] = {}  # what stands against a variable that may be a signal
    for name, node in nodes.items():
        if isinstance(node, str):
            metadata[name] = node
            continue
        array = _flat(node)
        if array is None:
            others = cast("np.ndarray[Any, Any]", node) if isinstance(node, np.ndarray) else None
            if others is not None and others.size > 1 and others.dtype.kind != "M":  # dates stay
                notes.append(f"{name} holds no vector of numbers: left out")
        elif array.size == 1:
            constants[name] = float(array.ravel()[0])
        elif array.size > 1:
            arrays[name] = array
    if not arrays:
        return None

    arrays = _with_groups_of_one_length(arrays, notes)

    # The rows of a recording: those of its time, else of most vectors.
    counts = Counter(max(array.shape) for array in arrays.values())
    rows = max(counts, key=lambda length: (counts[length], length))
    for name, array in arrays.items():
        if TIME.fullmatch(name) and array.ndim == 1:
            rows = int(array.size)
            break
    # A time that counts both of its ends has a sample more than what was logged, and a difference has one less.
    near = {length for length in counts if abs(length - rows) <= _FEW_SAMPLES}
    if rows >= _LONG and len(near) > 1:
        rows = min(near)
        cut = sorted(near - {rows}, reverse=True)
        arrays = {name: _cut(array, cut, rows) for name, array in arrays.items()}
        lengths = " and ".join(map(str, [*cut, rows]))
        notes.append(f"variables have {lengths} samples: the first {rows} of each are taken")
    columns: dict[str, Array] = {}
    for name, array in arrays.items():
        own_columns = columns_of(name, array, rows)
        columns.update(own_columns)
        if not own_columns:
            problem = f"variable {name} has {max(array.shape)} samples, not {rows}"
            notes.append(f"{problem}: left out")
            unreadable[name] = problem
        elif array.ndim == 2 and array.shape[0] != rows:
            height, width = array.shape
            notes.append(f"matrix {name} is {height} x {width}: its rows are taken as columns")
    if not columns:
        return None
    return Found(
        columns, constants=constants, metadata=metadata, notes=notes, unreadable=unreadable
    )


def _with_groups_of_one_length(
    arrays: dict[str, np.ndarray[Any, Any]], notes: list[str]
) -> dict[str, np.ndarray[Any, Any]]:
    """Vectors that come in a group for each field, the shorter groups with empty cells at their ends; others stay.

    The vectors of a group have one length, and the same names as the others but for a field: t_0A, F_0A beside t_1A,
    F_1A.
    """
    lengths: dict[str, set[int]] = {}  # of the vectors of a field
    names: dict[str, set[str]] = {}  # without the field
    for name, array in arrays.items():
        field = stated_in(name)
        if field is None or array.ndim != 1:
            return arrays
        level = f"{field.number:g} {field.unit}"
        lengths.setdefault(level, set()).add(int(array.size))
        names.setdefault(level, set()).add(without_field(name))
    first, *others = names.values()
    are_alike = bool(others) and len(first) > 1 and all(own == first for own in others)
    have_one_length = all(len(own) == 1 for own in lengths.values())
    differ = len(set[int]().union(*lengths.values())) > 1
    if not (are_alike and have_one_length and differ):
        return arrays
    notes.append(
        "the vectors of each field have a length of their own: rows behind a shorter one are empty"
    )
    longest = max(int(array.size) for array in arrays.values())
    padded: dict[str, np.ndarray[Any, Any]] = {}
    for name, array in arrays.items():
        padded[name] = np.full(longest, np.nan)
        padded[name][: array.size] = array
    return padded


def _cut(array: np.ndarray[Any, Any], cut: Sequence[int], rows: int) -> np.ndarray[Any, Any]:
    """An array whose longer side has no more samples than rows, if its length is one of those that are cut."""
    side = int(np.argmax(array.shape))
    if array.shape[side] not in cut:
        return array
    return array[:rows] if side == 0 else array[:, :rows]


def _flat(node: Any) -> np.ndarray[Any, Any] | None:
    """Numbers as a vector or a matrix; None for anything else, and for arrays of more dimensions."""
    if not isinstance(node, np.ndarray):
        return None
    squeezed = cast("np.ndarray[Any, Any]", node).squeeze()
    are_numbers = squeezed.dtype.kind in "biuf"
    return squeezed if are_numbers and squeezed.ndim <= 2 else None


def vector(node: Any) -> Array | None:
    """Numbers in one row or column as float64; None for anything else."""
    array = _flat(node)
    if array is None or array.ndim == 2:
        return None
    return np.atleast_1d(array).astype(np.float64)


def matrix_of(node: Any) -> np.ndarray[Any, Any] | None:
    """Numbers in several rows and columns; None for anything else."""
    array = _flat(node)
    return array if array is not None and array.ndim == 2 else None


def columns_of(name: str, node: Any, rows: int | None) -> list[tuple[str, Array]]:
    """A vector as one column, a matrix as name_1, name_2, ...; nothing where no side has the length ``rows``."""
    array = _flat(node)
    if array is None or array.size < 2 or (rows is not None and rows not in array.shape):
        return []
    if array.ndim == 1:
        return [(name, array.astype(np.float64))]
    is_upright = array.shape[0] == (rows or max(array.shape))
    columns = array.T if is_upright else array
    return [
        (f"{name}_{number}", column.astype(np.float64))
        for number, column in enumerate(columns, start=1)
    ]

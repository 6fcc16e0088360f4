"""MATLAB files become plain Python: dict for a struct, list for a struct array or cell, str, ndarray for numbers.

Runs in the child process only. What cannot be plain (function handles, objects such as timeseries) becomes None.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np

Node = dict[str, Any] | list[Any] | str | np.ndarray[Any, Any] | None
_DEEPEST = 12
_MOST = 200_000  # elements of cells and struct arrays: a log has hundreds


def load_v5(path: str) -> dict[str, Node]:
    """Top-level variables of a v5 file, read by SciPy."""
    from scipy.io.matlab import loadmat

    found = loadmat(path, struct_as_record=False, squeeze_me=False, chars_as_strings=True)
    return {str(name): _plain(value, 0) for name, value in found.items() if not str(name).startswith("__")}


def _plain(value: Any, depth: int) -> Node:
    """SciPy's arrays of objects and mat_struct as plain Python."""
    if depth > _DEEPEST:
        return None
    if hasattr(value, "_fieldnames"):
        return {str(name): _plain(getattr(value, name), depth + 1) for name in value._fieldnames}
    if not isinstance(value, np.ndarray):
        return None
    array = cast("np.ndarray[Any, Any]", value)
    if array.dtype.kind in "US":
        return "\n".join(str(line).rstrip() for line in array.ravel())
    if array.dtype.kind == "O":
        items = [_plain(item, depth + 1) for item in array.ravel(order="F")[:_MOST]]
        single = len(items) == 1 and isinstance(items[0], dict)
        return items[0] if single else items
    return array if array.dtype.kind in "biuf" else None


def load_v73(path: str) -> dict[str, Node]:
    """Top-level variables of a v7.3 file, read by h5py. Links to other files are never followed."""
    import h5py

    with h5py.File(path, "r") as file:
        own = (name for name in _own(h5py, file) if not str(name).startswith("#"))
        return {str(name): _value(h5py, file, file[name], 0) for name in own}


def _own(h5py: Any, group: Any) -> list[str]:
    """Members that are stored in the file itself: external and soft links could name any file or form a ring."""
    return [name for name in group if isinstance(group.get(name, getlink=True), h5py.HardLink)]


def _value(h5py: Any, file: Any, item: Any, depth: int) -> Node:
    """One HDF5 object. Groups are structs; a struct array is a group whose members are arrays of references."""
    if depth > _DEEPEST:
        return None
    if isinstance(item, h5py.Group):
        fields = {str(name): item[name] for name in _own(h5py, item)}
        arrays = all(_is_references(h5py, each) and "MATLAB_class" not in each.attrs for each in fields.values())
        if fields and arrays:
            each = {name: _followed(h5py, file, field, depth) for name, field in fields.items()}
            count = min(len(values) for values in each.values())  # none where there are too many
            return [{name: values[index] for name, values in each.items()} for index in range(count)]
        return {name: _value(h5py, file, field, depth + 1) for name, field in fields.items()}
    if not isinstance(item, h5py.Dataset) or item.external or item.is_virtual or "MATLAB_object_decode" in item.attrs:
        return None
    kind = item.attrs.get("MATLAB_class", b"")
    kind = kind.decode("latin-1") if isinstance(kind, bytes) else str(kind)
    if item.attrs.get("MATLAB_empty"):
        return "" if kind == "char" else np.zeros((0, 0))
    if _is_references(h5py, item):
        return _followed(h5py, file, item, depth)
    if item.dtype.kind not in "biuf":
        return None
    array = np.asarray(item[()]).T  # HDF5 stores the dimensions of MATLAB in reverse
    if kind == "char":
        rows = np.atleast_2d(array)[:1000, :10000]
        return "\n".join("".join(chr(int(code)) for code in row).rstrip() for row in rows)
    return array


def _is_references(h5py: Any, item: Any) -> bool:
    return isinstance(item, h5py.Dataset) and h5py.check_ref_dtype(item.dtype) is h5py.Reference


def _followed(h5py: Any, file: Any, item: Any, depth: int) -> list[Node]:
    if depth >= _DEEPEST or item.size > _MOST:
        return []
    references = np.asarray(item[()]).T.ravel(order="F")
    return [_value(h5py, file, file[reference], depth + 1) if reference else None for reference in references]

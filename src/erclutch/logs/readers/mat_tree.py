"""MATLAB files become plain Python: dict for a struct, list for a struct array or cell, str, ndarray for numbers.

Runs in the child process only. What cannot be plain (function handles, objects such as timeseries) becomes None.
"""

from __future__ import annotations

from math import prod
from pathlib import Path
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.readers.budget import Budget, budget_of

Node = dict[str, Any] | list[Any] | str | np.ndarray[Any, Any] | None
_DEEPEST = 12
_MOST = 200_000  # elements of cells and struct arrays: a log has hundreds


def load_v5(path: str) -> dict[str, Node]:
    """Top-level variables of a v5 file, read by SciPy."""
    from scipy.io.matlab import loadmat, whosmat

    budget = budget_of(Path(path))
    for _, shape, _ in whosmat(path):  # looks at the heads of the variables alone
        budget.take_names()
        budget.take_cells(prod(int(length) for length in shape))
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
        if (table := _table_in(items, array.shape)) is not None:
            return table
        single = len(items) == 1 and isinstance(items[0], dict)
        return items[0] if single else items
    return array if array.dtype.kind in "biuf" else None


def _table_in(items: list[Node], shape: tuple[int, ...]) -> dict[str, Node] | None:
    """A cell matrix with names in its first row and a number in each cell below, as a struct of vectors; else None.

    Args:
        items: its cells, column by column.
        shape: rows and columns.
    """
    if len(shape) != 2 or min(shape) < 2 or len(items) != prod(shape):
        return None
    columns = [items[at : at + shape[0]] for at in range(0, len(items), shape[0])]
    names = [column[0] for column in columns]
    if not all(isinstance(name, str) and name for name in names) or len({*map(str, names)}) < len(names):
        return None
    numbers = [[each for each in column[1:] if isinstance(each, np.ndarray) and each.size == 1] for column in columns]
    if any(len(each) < shape[0] - 1 for each in numbers):
        return None
    vectors = (np.array([float(cell.ravel()[0]) for cell in each]) for each in numbers)
    return dict(zip(map(str, names), vectors, strict=True))


def stored_values(item: Any) -> np.ndarray[Any, Any]:
    """The values of a data set of HDF5.

    Where a part was never written, or a damaged file has lost the place of it, the library reads zeros in silence.

    Raises:
        LogError: a part is not in the file.
    """
    stored = item.id.get_storage_size() > 0
    if item.chunks is not None:
        chunks = prod(-(-size // chunk) for size, chunk in zip(item.shape, item.chunks, strict=True))
        found: list[Any] = []
        item.id.chunk_iter(found.append)
        stored = sum(chunk.byte_offset > 0 for chunk in found) >= chunks  # at 0 the library looks for none
    if item.size and not stored and np.all(item.fillvalue == item.fillvalue):  # NaN is missing, as it should be
        problem = f"rows of the data set {item.name} are not in the file: they would be read as {item.fillvalue}"
        raise LogError(problem, remedy="Copy the file again, or export the rows that were written")
    return np.asarray(item[()])


def load_v73(path: str) -> dict[str, Node]:
    """Top-level variables of a v7.3 file, read by h5py. Links to other files are never followed."""
    import h5py

    with h5py.File(path, "r") as file:
        tree = _Tree(h5py, file, budget_of(Path(path)))
        own = (name for name in tree.own(file) if not str(name).startswith("#"))
        return {str(name): tree.value(file[name], 0) for name in own}


class _Tree:
    """A v7.3 file on its way to plain Python. Links and references may lead to an object often: each time counts."""

    def __init__(self, h5py: Any, file: Any, budget: Budget) -> None:
        self._h5py, self._file, self._budget = h5py, file, budget

    def own(self, group: Any) -> list[str]:
        """Members that are stored in the file itself: external and soft links could name any file or form a ring."""
        return [name for name in group if isinstance(group.get(name, getlink=True), self._h5py.HardLink)]

    def value(self, item: Any, depth: int) -> Node:
        """One HDF5 object. Groups are structs; a struct array is a group whose members are arrays of references."""
        if depth > _DEEPEST:
            return None
        if isinstance(item, self._h5py.Group):
            fields = {str(name): item[name] for name in self.own(item)}
            self._budget.take_names(len(fields))
            arrays = all(self._is_references(each) and "MATLAB_class" not in each.attrs for each in fields.values())
            if fields and arrays:
                each = {name: self._followed(field, depth) for name, field in fields.items()}
                count = min(len(values) for values in each.values())  # none where there are too many
                return [{name: values[index] for name, values in each.items()} for index in range(count)]
            return {name: self.value(field, depth + 1) for name, field in fields.items()}
        if not isinstance(item, self._h5py.Dataset) or item.external or item.is_virtual:
            return None
        if "MATLAB_object_decode" in item.attrs:
            return None
        kind = item.attrs.get("MATLAB_class", b"")
        kind = kind.decode("latin-1") if isinstance(kind, bytes) else str(kind)
        if item.attrs.get("MATLAB_empty"):
            return "" if kind == "char" else np.zeros((0, 0))
        if self._is_references(item):
            return self._followed(item, depth)
        if item.dtype.kind not in "biuf":
            return None
        self._budget.take_cells(item.size)
        array = stored_values(item).T  # HDF5 stores the dimensions of MATLAB in reverse
        if kind == "char":
            rows = np.atleast_2d(array)[:1000, :10000]
            return "\n".join("".join(chr(int(code)) for code in row).rstrip() for row in rows)
        return array

    def _is_references(self, item: Any) -> bool:
        return isinstance(item, self._h5py.Dataset) and self._h5py.check_ref_dtype(item.dtype) is self._h5py.Reference

    def _followed(self, item: Any, depth: int) -> Any:
        if depth >= _DEEPEST or item.size > _MOST:
            return []
        self._budget.take_cells(item.size)
        matrix = np.asarray(item[()]).T
        items = [self.value(self._file[each], depth + 1) if each else None for each in matrix.ravel(order="F")]
        return _table_in(items, matrix.shape) or items

"""MATLAB files become plain Python: dict for a struct, list for a struct array or cell, str, ndarray for numbers.

Runs in the child process only. What cannot be plain (function handles, objects such as timeseries) becomes None.
"""

from __future__ import annotations

from contextlib import suppress
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
    """Top-level variables of a v4 or v5 file, read by SciPy."""
    from scipy.io.matlab import loadmat, whosmat

    budget = budget_of(Path(path))
    # The heads alone are looked at. SciPy's look ends at an object, such as a table or a datetime, whose head has no
    # shape; then the limits of the child hold alone.
    with suppress(TypeError):
        for _, shape, _ in whosmat(path):
            budget.take_names()
            budget.take_cells(prod(int(length) for length in shape))

    variables = loadmat(
        path,
        struct_as_record=False,
        squeeze_me=False,
        chars_as_strings=True,
    )
    nodes: dict[str, Node] = {}
    for name, value in variables.items():
        if not name.startswith("__"):  # SciPy's own remarks on the file
            nodes[_own_name(str(name), value)] = _plain(value, 0)
    return nodes


def _own_name(name: str, value: Any) -> str:
    """The name of a variable, with its class where it is an object, which SciPy calls None."""
    if name != "None" or getattr(getattr(value, "dtype", None), "names", None) != ("s0", "s1", "s2", "arr"):
        return name
    own, _, kind, _ = value.ravel()[0].tolist() if value.size else (b"", b"", b"", None)
    texts = [text.decode("latin-1") for text in (own, kind) if isinstance(text, bytes) and text]
    return f"{texts[0]} (a {texts[1]})" if len(texts) == 2 else name


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
    if array.dtype.kind in "biuf":
        return array
    if array.dtype.kind != "O":
        return None

    cells = array.ravel(order="F")[:_MOST]
    items = [_plain(cell, depth + 1) for cell in cells]
    table = _table_in(items, array.shape)
    if table is not None:
        return table
    # MATLAB's struct is an array of one struct.
    if len(items) == 1 and isinstance(items[0], dict):
        return items[0]
    return items


def _table_in(items: list[Node], shape: tuple[int, ...]) -> dict[str, Node] | None:
    """A cell matrix with names in its first row and a number in each cell below, as a struct of vectors; else None.

    Args:
        items: its cells, column by column.
        shape: rows and columns.
    """
    if len(shape) != 2 or min(shape) < 2 or len(items) != prod(shape):
        return None
    rows = shape[0]
    vectors: dict[str, Node] = {}
    for start in range(0, len(items), rows):
        name, *cells = items[start : start + rows]
        if not isinstance(name, str) or not name or name in vectors:
            return None
        numbers: list[float] = []
        for cell in cells:
            if not isinstance(cell, np.ndarray) or cell.size != 1:
                return None
            numbers.append(float(cell.ravel()[0]))
        vectors[name] = np.array(numbers)
    return vectors


def stored_values(item: Any) -> np.ndarray[Any, Any]:
    """The values of a data set of HDF5.

    Where a part was never written, or a damaged file has lost the place of it, the library reads zeros in silence.

    Raises:
        LogError: a part is not in the file.
    """
    if item.chunks is None:
        stored = item.id.get_storage_size() > 0
    else:
        needed = 1
        for size, chunk in zip(item.shape, item.chunks, strict=True):
            needed *= -(-size // chunk)  # chunks a side, rounded up
        in_file: list[Any] = []
        item.id.chunk_iter(in_file.append)
        placed = sum(chunk.byte_offset > 0 for chunk in in_file)  # at 0 the library looks for no chunk
        stored = placed >= needed

    # Where the library fills with NaN, rows that are missing are seen as missing.
    if item.size and not stored and np.all(item.fillvalue == item.fillvalue):
        problem = f"rows of the data set {item.name} are not in the file: they would be read as {item.fillvalue}"
        raise LogError(problem, remedy="Copy the file again, or export the rows that were written")
    return np.asarray(item[()])


def load_v73(path: str) -> dict[str, Node]:
    """Top-level variables of a v7.3 file, read by h5py. Links to other files are never followed."""
    import h5py

    with h5py.File(path, "r") as file:
        tree = _Tree(h5py, file, budget_of(Path(path)))
        variables = [name for name in tree.own(file) if not name.startswith("#")]  # "#refs#" holds cells of others
        return {name: tree.value(file[name], 0) for name in variables}


class _Tree:
    """A v7.3 file on its way to plain Python. Links and references may lead to an object often: each time counts."""

    def __init__(self, h5py: Any, file: Any, budget: Budget) -> None:
        self._h5py = h5py
        self._file = file
        self._budget = budget

    def own(self, group: Any) -> list[str]:
        """Members that are stored in the file itself: external and soft links could name any file or form a ring."""
        names: list[str] = []
        for name in group:
            link = group.get(name, getlink=True)
            if isinstance(link, self._h5py.HardLink):
                names.append(str(name))
        return names

    def value(self, item: Any, depth: int) -> Node:
        """One HDF5 object."""
        if depth > _DEEPEST:
            return None
        if isinstance(item, self._h5py.Group):
            return self._struct(item, depth)
        # Values in another file are never read.
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
        if kind != "char":
            return array
        lines: list[str] = []
        for codes in np.atleast_2d(array)[:1000, :10000]:
            line = "".join(chr(int(code)) for code in codes)
            lines.append(line.rstrip())
        return "\n".join(lines)

    def _struct(self, group: Any, depth: int) -> Node:
        """A group is a struct, or a struct array where all its members are arrays of references."""
        members = {name: group[name] for name in self.own(group)}
        self._budget.take_names(len(members))
        # A cell is an array of references too, but MATLAB writes its class beside it.
        is_array = bool(members)
        for member in members.values():
            is_array = is_array and self._is_references(member) and "MATLAB_class" not in member.attrs
        if not is_array:
            return {name: self.value(member, depth + 1) for name, member in members.items()}

        columns = {name: self._followed(member, depth) for name, member in members.items()}
        count = min(len(column) for column in columns.values())  # none where there are too many
        structs: list[dict[str, Node]] = []
        for place in range(count):
            structs.append({name: column[place] for name, column in columns.items()})
        return structs

    def _is_references(self, item: Any) -> bool:
        return isinstance(item, self._h5py.Dataset) and self._h5py.check_ref_dtype(item.dtype) is self._h5py.Reference

    def _followed(self, item: Any, depth: int) -> Any:
        """What an array of references leads to, column by column, or a table where it is one."""
        if depth >= _DEEPEST or item.size > _MOST:
            return []
        self._budget.take_cells(item.size)
        references = np.asarray(item[()]).T
        items: list[Node] = []
        for reference in references.ravel(order="F"):
            items.append(self.value(self._file[reference], depth + 1) if reference else None)
        return _table_in(items, references.shape) or items

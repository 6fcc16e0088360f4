"""MATLAB files become plain Python: dict for a struct, list for a struct array or cell, str, ndarray for numbers.

Runs in the child process only. Tables, timeseries and the like are made plain by `mat_objects`; what cannot be plain
(function handles, objects of other classes) becomes None.
"""

from __future__ import annotations

from contextlib import suppress
from io import BytesIO
from math import prod
from pathlib import Path
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.readers.budget import Budget, budget_of
from erclutch.logs.readers.mat_objects import Objects, is_reference

Node = dict[str, Any] | list[Any] | str | np.ndarray[Any, Any] | None
_DEEPEST = 12
_MOST = 200_000  # elements of cells and struct arrays: a log has hundreds
_HEAD = 128  # bytes in front of the first variable of v5
_NO_PLACE = (0, int.from_bytes(b" " * 8, "little"))  # of objects, in the head of a file without any
_WORKSPACE = "__function_workspace__"  # what SciPy calls the variable without a name, which keeps the objects
_OPAQUE = ("s0", "s1", "s2", "arr")  # SciPy's fields of an object
#: So SciPy changes no shape.
_AS_STORED: Any = {
    "struct_as_record": False,
    "squeeze_me": False,
    "chars_as_strings": True,
}


def load_v5(path: str) -> dict[str, Node]:
    """Top-level variables of a v4 or v5 file, read by SciPy."""
    from scipy.io.matlab import loadmat

    budget = budget_of(Path(path))
    with Path(path).open("rb") as file:
        head = file.read(_HEAD)
    mark = head[126:128]  # two letters in the byte order of the file
    order: Any = "little" if mark == b"IM" else "big"
    place = int.from_bytes(head[116:124], order)  # of the objects
    is_in_file = place not in _NO_PLACE and place < Path(path).stat().st_size
    has_objects = mark in (b"IM", b"MI") and is_in_file
    if not has_objects:
        _take_heads(path, budget)
        variables = loadmat(path, **_AS_STORED)
        return {
            str(name): _plain(value, 0)
            for name, value in variables.items()
            if not name.startswith("__")
        }

    # Objects have no name in the head that SciPy reads: each variable is read by itself.
    nodes: dict[str, Node] = {}
    kinds: dict[str, str] = {}
    objects: Objects | None = None
    content = Path(path).read_bytes()
    behind = _HEAD
    while behind + 8 <= len(content):
        start = behind
        size = int.from_bytes(content[start + 4 : start + 8], order)
        behind = start + 8 + size
        file: Any = BytesIO(content[:116] + bytes(8) + content[124:_HEAD] + content[start:behind])
        _take_heads(file, budget)
        file.seek(0)
        loaded = loadmat(file, **_AS_STORED)
        if start == place and _WORKSPACE in loaded:
            with suppress(IndexError, ValueError, TypeError, KeyError):
                objects = _objects_in(loaded[_WORKSPACE], head, budget)
            continue
        for name, value in loaded.items():
            if not name.startswith("__"):
                own_name, kind = name_and_kind(str(name), value)
                kinds[own_name] = kind
                nodes[own_name] = _plain(value, 0)
    return _with_objects(nodes, kinds, objects)


def _take_heads(file: Any, budget: Budget) -> None:
    """Count what the heads of the variables say.

    SciPy's look ends at an object, such as a table or a datetime, whose head has no shape; then the limits of the
    child hold alone.
    """
    from scipy.io.matlab import whosmat

    with suppress(TypeError):
        for _, shape, _ in whosmat(file):
            budget.take_names()
            budget.take_cells(prod(int(length) for length in shape))


def _objects_in(workspace: Any, head: bytes, budget: Budget) -> Objects:
    """The objects of a v5 file, which lie in bytes that are laid out as a file with a short head."""
    from scipy.io.matlab import loadmat

    content = np.asarray(workspace, np.uint8).tobytes()
    order = "little" if content[2:4] == b"IM" else "big"
    # What follows the first variable is of no use.
    end_of_first = 16 + int.from_bytes(content[12:16], order)
    file: Any = BytesIO(head[:116] + bytes(8) + content[:4] + content[8:end_of_first])
    loaded = loadmat(file, **_AS_STORED)
    held: Any = loaded[_WORKSPACE].ravel()[0]
    (_, _, _, cells) = held.MCOS.ravel()[0]
    return Objects(cast("list[Any]", [_plain(cell, 0) for cell in cells.ravel()]), budget)


def _with_objects(
    nodes: dict[str, Node], kinds: dict[str, str], objects: Objects | None
) -> dict[str, Node]:
    """Variables with what their references lead to; what stays an object is called by its class too."""
    named: dict[str, Node] = {}
    for name, node in nodes.items():
        if objects:
            plain = objects.resolved(node)
        else:
            plain = None if is_reference(node) else node
        kind = kinds.get(name)
        is_left_an_object = plain is None and kind
        named[f"{name} (a {kind})" if is_left_an_object else name] = plain
    return named


def name_and_kind(name: str, value: Any) -> tuple[str, str]:
    """The name of a variable and its class, where it is an object, which SciPy calls None; else "" for the class."""
    if not _is_opaque(value):
        return name, ""
    own, _, kind, _ = value.ravel()[0].tolist()
    own_name = own.decode("latin-1") if isinstance(own, bytes) else ""
    own_kind = kind.decode("latin-1") if isinstance(kind, bytes) else ""
    return own_name or name, own_kind


def _is_opaque(value: Any) -> bool:
    """Whether a value of SciPy stands for an object of MATLAB."""
    fields = getattr(getattr(value, "dtype", None), "names", None)
    return fields == _OPAQUE and value.size > 0


def _plain(value: Any, depth: int) -> Node:
    """SciPy's arrays of objects and mat_struct as plain Python."""
    if depth > _DEEPEST:
        return None
    if hasattr(value, "_fieldnames"):
        return {str(name): _plain(getattr(value, name), depth + 1) for name in value._fieldnames}
    if not isinstance(value, np.ndarray):
        return None

    array = cast("np.ndarray[Any, Any]", value)
    if _is_opaque(array):
        reference = array.ravel()[0]["arr"]
        return reference if is_reference(reference) else None
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
    rows, _ = shape
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
        # At byte 0 the library looks for no chunk.
        placed = sum(chunk.byte_offset > 0 for chunk in in_file)
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
        # "#refs#" holds cells of others.
        variables = [name for name in tree.own(file) if not name.startswith("#")]
        nodes = {name: tree.value(file[name], 0) for name in variables}
        kinds = {name: _kind_of(file[name]) for name, node in nodes.items() if is_reference(node)}
        return _with_objects(nodes, kinds, tree.objects() if tree.holds_objects else None)


def _kind_of(item: Any) -> str:
    """The class that MATLAB wrote beside a variable."""
    kind = item.attrs.get("MATLAB_class", b"")
    return kind.decode("latin-1") if isinstance(kind, bytes) else str(kind)


class _Tree:
    """A v7.3 file on its way to plain Python. Links and references may lead to an object often: each time counts."""

    def __init__(self, h5py: Any, file: Any, budget: Budget) -> None:
        self._h5py = h5py
        self._file = file
        self._budget = budget
        self.holds_objects = False  # whether a variable that was read is one, or has one inside

    def objects(self) -> Objects | None:
        """The objects of the file; None where they are laid out in an unknown way."""
        with suppress(KeyError, IndexError, ValueError, TypeError):
            subsystem = self._file["#subsystem#"]
            if "MCOS" in self.own(subsystem):
                return Objects(self._followed(subsystem["MCOS"], 0), self._budget, self._record)
        return None

    def _record(self, number: int) -> bytes | None:
        """The bytes of a signal that Simulink streamed to the file; None where it has no such record."""
        with suppress(KeyError, ValueError):
            streams = self._file["#sigstream#"]
            if str(number) in self.own(streams) and "#data#" in self.own(streams[str(number)]):
                stream = streams[str(number)]["#data#"]
                if stream.dtype == np.uint8 and not stream.external and not stream.is_virtual:
                    self._budget.take_cells(-(-stream.size // 4))  # a number has four bytes or more
                    return stored_values(stream).tobytes()
        return None

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
            self.holds_objects = True
            if item.size >= _MOST or item.dtype.kind != "u":
                return None
            reference = np.asarray(item[()]).T
            return reference if is_reference(reference) else None

        kind = _kind_of(item)
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
            is_cell = "MATLAB_class" in member.attrs
            is_array = is_array and self._is_references(member) and not is_cell
        if not is_array:
            return {name: self.value(member, depth + 1) for name, member in members.items()}

        columns = {name: self._followed(member, depth) for name, member in members.items()}
        count = min(len(column) for column in columns.values())  # none where there are too many
        structs: list[dict[str, Node]] = []
        for place in range(count):
            structs.append({name: column[place] for name, column in columns.items()})
        return structs

    def _is_references(self, item: Any) -> bool:
        if not isinstance(item, self._h5py.Dataset):
            return False
        return self._h5py.check_ref_dtype(item.dtype) is self._h5py.Reference

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

"""Writes MATLAB files with objects, v5 and v7.3, as MATLAB lays them out: references, and a subsystem of properties."""

from __future__ import annotations

import struct
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np

MARK = 0xDD000000


@dataclass
class MatObject:
    """An object of a class; ``made`` where the class makes one value of it (timetable, string)."""

    kind: str
    properties: dict[str, Any]
    made: bool = False


@dataclass
class Subsystem:
    """The objects of a file, numbered as they are met."""

    names: list[str] = field(default_factory=list)
    classes: list[str] = field(default_factory=list)
    objects: list[tuple[int, int, int]] = field(default_factory=list)  # class, made list, own list
    made: list[list[int]] = field(default_factory=list)
    own: list[list[int]] = field(default_factory=list)
    values: list[Any] = field(default_factory=list)

    def name(self, text: str) -> int:
        if text not in self.names:
            self.names.append(text)
        return self.names.index(text) + 1

    def reference(self, value: MatObject) -> np.ndarray:
        if value.kind not in self.classes:
            self.classes.append(value.kind)
        class_of = self.classes.index(value.kind) + 1
        numbers: list[int] = []
        for name, part in value.properties.items():
            self.values.append(self.plain(part))
            numbers += [self.name(name), 1, len(self.values) - 1]
        lists = self.made if value.made else self.own
        lists.append(numbers)
        self.objects.append(
            (class_of, len(lists) if value.made else 0, 0 if value.made else len(lists))
        )
        return np.array([[MARK, 2, 1, 1, len(self.objects), class_of]], np.uint32).T

    def plain(self, value: Any) -> Any:
        """A value with references in place of objects."""
        if isinstance(value, MatObject):
            return self.reference(value)
        if isinstance(value, dict):
            return {name: self.plain(part) for name, part in value.items()}
        if isinstance(value, list):
            return [self.plain(part) for part in value]
        return value

    def head(self) -> np.ndarray:
        """The first cell: names, classes, made lists, objects, own lists."""
        spaces = [kind.rpartition(".") for kind in self.classes]
        pairs = [(self.name(space) if space else 0, self.name(own)) for space, _, own in spaces]
        classes = [0, 0, 0, 0, *(number for pair in pairs for number in (*pair, 0, 0))]
        objects = [0] * 6
        for class_of, made, own in self.objects:
            objects += [class_of, 0, 0, made, own, 0]
        parts = [classes, _lists(self.made), objects, _lists(self.own), [0, 0]]
        texts = b"".join(name.encode() + b"\0" for name in self.names)
        texts += bytes(-len(texts) % 8)
        starts = [40 + len(texts)]
        for part in parts:
            starts.append(starts[-1] + 4 * len(part))
        starts += [starts[-1]] * (8 - len(starts))
        numbers = [4, len(self.names), *starts]
        packed = b"".join(np.array(part, "<u4").tobytes() for part in parts)
        return np.frombuffer(np.array(numbers, "<u4").tobytes() + texts + packed, np.uint8)[:, None]

    def cells(self) -> list[Any]:
        count = len(self.classes) + 1
        empty = np.zeros((0, 0))
        return [
            self.head(),
            empty,
            *self.values,
            [empty] * count,
            np.zeros((count, 1)),
            [empty] * count,
        ]


def _lists(lists: list[list[int]]) -> list[int]:
    """Counts and triples, each list to an even length; the first list is empty."""
    numbers = [0, 0]
    for triples in lists:
        numbers += [len(triples) // 3, *triples]
        numbers += [0] * (len(numbers) % 2)
    return numbers


def save_v5(path: Path, variables: dict[str, Any], packed: bool = True) -> Path:
    """A file as ``save -v7`` writes it (``packed``), or ``save -v6``."""
    subsystem = Subsystem()
    parts = b""
    for name, value in variables.items():
        plain = subsystem.plain(value)
        if isinstance(value, MatObject):
            part = _opaque(name, value.kind, plain)
        else:
            part = _matrix(name, plain)
        parts += _element(15, zlib.compress(part), pad=False) if packed else part
    held = {"MCOS": _opaque("", "FileWrapper__", subsystem.cells())}
    content = b"\0\1IM" + bytes(4) + _struct("", held)
    head = b"MATLAB 5.0 MAT-file".ljust(116) + struct.pack("<Q", 128 + len(parts)) + b"\0\1IM"
    path.write_bytes(head + parts + _matrix("", np.frombuffer(content, np.uint8)[None, :]))
    return path


def _element(kind: int, data: bytes, pad: bool = True) -> bytes:
    return struct.pack("<II", kind, len(data)) + data + (bytes(-len(data) % 8) if pad else b"")


def _headed(kind: int, shape: tuple[int, ...], name: str, rest: bytes) -> bytes:
    head = _element(6, struct.pack("<II", kind, 0)) + _element(
        5, struct.pack(f"<{len(shape)}i", *shape)
    )
    return _element(14, head + _element(1, name.encode()) + rest)


def _opaque(name: str, kind: str, held: Any) -> bytes:
    head = _element(6, struct.pack("<II", 17, 0))
    texts = b"".join(_element(1, text.encode()) for text in (name, "MCOS", kind))
    return _element(14, head + texts + _matrix("", held))


def _struct(name: str, fields: dict[str, bytes]) -> bytes:
    keys = b"".join(key.encode().ljust(32, b"\0") for key in fields)
    rest = _element(5, struct.pack("<i", 32)) + _element(1, keys) + b"".join(fields.values())
    return _headed(2, (1, 1), name, rest)


def _matrix(name: str, value: Any) -> bytes:
    if isinstance(value, str):
        codes = np.frombuffer(value.encode("utf-16-le"), "<u2")
        return _headed(4, (min(1, codes.size), codes.size), name, _element(4, codes.tobytes()))
    if isinstance(value, dict):
        return _struct(name, {key: _matrix("", part) for key, part in value.items()})
    if isinstance(value, list):
        return _headed(1, (len(value), 1), name, b"".join(_matrix("", part) for part in value))
    array = np.asarray(value)
    kind, stored = {"uint8": (9, 2), "uint32": (13, 6), "uint64": (15, 13)}.get(
        array.dtype.name, (6, 9)
    )
    numbers = array if kind != 6 else array.astype("<f8")
    shape = array.shape if array.ndim > 1 else (array.size, 1)
    return _headed(kind, shape, name, _element(stored, numbers.tobytes(order="F")))


def save_v73(path: Path, variables: dict[str, Any]) -> Path:
    """A file as ``save -v7.3`` writes it."""
    subsystem = Subsystem()
    with h5py.File(path, "w", userblock_size=512) as file:
        references = file.create_group("#refs#")
        for name, value in variables.items():
            _put(file, references, name, value, subsystem)
        _put(file.create_group("#subsystem#"), references, "MCOS", subsystem.cells())
    head = b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\2IM"
    with path.open("r+b") as raw:
        raw.write(head)
    return path


def _put(
    group: Any, references: Any, name: str, value: Any, subsystem: Subsystem | None = None
) -> Any:
    if subsystem and isinstance(value, MatObject):
        item = _put(group, references, name, subsystem.reference(value))
        item.attrs["MATLAB_object_decode"] = np.int32(3)
        kind = value.kind
    elif isinstance(value, dict):
        item = group.create_group(name)
        for key, part in value.items():
            _put(item, references, key, part, subsystem)
        kind = "struct"
    elif isinstance(value, str):
        item = group.create_dataset(
            name, data=np.array([[ord(letter)] for letter in value] or [[0]], np.uint16)
        )
        item.attrs["MATLAB_int_decode"] = np.int32(2)
        kind = "char"
        if not value:
            item.attrs["MATLAB_empty"] = np.uint8(1)
    elif isinstance(value, list):
        places: list[Any] = []
        for place, part in enumerate(value):
            places.append(_put(references, references, f"{name}_{place}", part, subsystem).ref)
        item = group.create_dataset(name, (1, len(places)), h5py.ref_dtype)
        item[0, :] = places
        kind = "cell"
    else:
        array = np.asarray(value)
        array = array if array.ndim > 1 else array.reshape(-1, 1)
        item = group.create_dataset(name, data=array.T)
        kind = {"uint8": "uint8", "uint32": "uint32", "uint64": "uint64"}.get(
            array.dtype.name, "double"
        )
        if not array.size:
            item.attrs["MATLAB_empty"] = np.uint8(1)
    item.attrs["MATLAB_class"] = np.bytes_(kind)
    return item

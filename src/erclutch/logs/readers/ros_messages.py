"""Messages of ROS 1 and ROS 2 with strings, lists and messages inside become columns, as those of a joint's state.

A message is laid out by its definition and by the lengths that stand in it. Messages of one length whose lengths and
texts are the same as those of the first are laid out alike, so they are read at once. Beside a list of names, the
numbers of a list of its length are under ``name.list``, as ``elbow.effort``.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from erclutch.logs.readers.budget import LONGEST_LIST
from erclutch.logs.readers.mcap_records import DamageError
from erclutch.signals.array import Array

_MOST_FIELDS = 5000  # of a message
_DEEPEST = 8  # messages inside of messages
_MOST_LAYOUTS = 50  # of the messages of one topic
NUMBERS = {
    "bool": "u1", "byte": "i1", "char": "u1", "float32": "<f4", "float64": "<f8", "float": "<f4", "double": "<f8",
    **{f"{sign}int{bits}": f"<{sign or 'i'}{bits // 8}" for sign in ("", "u") for bits in (8, 16, 32, 64)},
}  # fmt: skip
_TEXTS = ("string", "wstring")
_STAMPS = ("time", "duration", "builtin_interfaces/Time", "builtin_interfaces/Duration")
_NEXT = re.compile(r"^=+$\s*MSG: *(\S+)", re.MULTILINE)
_FIELD = re.compile(r"([A-Za-z][\w/]*)(?:<=\d+)?(\[(?:<=)?\d*\])?\s+([A-Za-z]\w*)(?:\s+[^=\s].*)?")
_CONSTANT = re.compile(r"[A-Za-z][\w<=]*\s+[A-Za-z]\w*\s*=.*")


@dataclass(frozen=True)
class _Field:
    kind: str
    name: str
    many: str  # "" for one, "[]" for a list with its length in front, "[3]" for three


@dataclass
class _Layout:
    """Where the numbers of a message stand.

    Attributes:
        numbers: label -> place and type.
        stamps: label -> place of the seconds, whose nanoseconds follow.
        same: places and ends of lengths and names, which are the same in all messages that are laid out so.
    """

    numbers: dict[str, tuple[int, str]] = field(default_factory=dict[str, tuple[int, str]])
    stamps: dict[str, int] = field(default_factory=dict[str, int])
    same: list[tuple[int, int]] = field(default_factory=list[tuple[int, int]])

    def columns(self, messages: NDArray[np.uint8], signed: str) -> dict[str, Array]:
        """The numbers of messages by label, each of shape (n,)."""
        columns: dict[str, Array] = {}
        for label, at in self.stamps.items():
            seconds = _numbers_at(messages, at, signed)
            columns[label] = seconds + _numbers_at(messages, at + 4, "<u4") * 1e-9
        for label, (at, kind) in self.numbers.items():
            columns[label] = _numbers_at(messages, at, kind)
        return columns


def columns_of(
    definition: str,
    blocks: Sequence[NDArray[np.uint8]],
    *,
    aligned: bool,
) -> dict[str, Array]:
    """The numbers of messages by label; one that some messages lack is NaN there.

    Args:
        definition: of the message, with those of the messages in it.
        blocks: messages of one length each, of shape (n, length).
        aligned: as ROS 2 sends them (CDR): four bytes ahead, numbers at multiples of their size.

    Raises:
        DamageError: a definition or a message that is none, or a list that is too long for one of joints.
    """
    # Fields of the messages in the definition by their short names; those of the whole are called "".
    kinds: dict[str, list[_Field]] = {}
    name = ""
    text_begins = 0
    for match in _NEXT.finditer(definition):
        kinds[name] = _fields(definition[text_begins : match.start()])
        name = _short(match[1])
        text_begins = match.end()
    kinds[name] = _fields(definition[text_begins:])

    parts: list[dict[str, Array]] = []
    # Layouts of earlier messages: the length of such a message, its lengths and names, the layout.
    known: list[tuple[int, bytes, _Layout]] = []
    for block in blocks:
        begin = 0
        while begin < len(block):
            first = block[begin].tobytes()
            layout: _Layout | None = None
            for length, same, earlier in known:
                if length == len(first) and _same_in(first, earlier) == same:
                    layout = earlier
                    break
            if layout is None:
                if len(known) >= _MOST_LAYOUTS:
                    raise DamageError("its lists are of ever other lengths")
                layout = _Reader(first, kinds, aligned).layout()
                known.append((len(first), _same_in(first, layout), layout))

            # The messages that follow and are laid out as the first.
            rest = block[begin:]
            alike = np.ones(len(rest), np.bool_)
            for start, stop in layout.same:
                alike &= (rest[:, start:stop] == rest[0, start:stop]).all(axis=1)
            count = len(rest) if alike.all() else int(np.argmin(alike))
            parts.append(layout.columns(rest[:count], "<i4" if aligned else "<u4"))
            begin += count

    parts = [part for part in parts if part]
    labels = dict.fromkeys(label for part in parts for label in part)
    columns: dict[str, Array] = {}
    for label in labels:
        own: list[Array] = []
        for part in parts:
            rows = next(iter(part.values())).size
            own.append(part[label] if label in part else np.full(rows, np.nan))
        columns[label] = np.concatenate(own)
    return columns


def _same_in(message: bytes, layout: _Layout) -> bytes:
    """The lengths and names of a message, as bytes."""
    return b"".join(message[start:stop] for start, stop in layout.same)


def _numbers_at(messages: NDArray[np.uint8], at: int, kind: str) -> Array:
    """The number at one place of each message, shape (n,)."""
    size = np.dtype(kind).itemsize
    own = np.ascontiguousarray(messages[:, at : at + size])
    return own.view(kind)[:, 0].astype(np.float64)


def _short(name: str) -> str:
    """A message's name without the middle part that ROS 2 gives it: ``std_msgs/Header`` of ``std_msgs/msg/Header``."""
    return name.replace("/msg/", "/")


def _fields(text: str) -> list[_Field]:
    fields: list[_Field] = []
    for line in text.splitlines():
        line = line.partition("#")[0].strip()
        if not line or _CONSTANT.fullmatch(line):
            continue
        match = _FIELD.fullmatch(line)
        if match is None:
            raise DamageError(f"its field '{line[:60]}' is no field of a message")
        many = match[2] or ""
        fields.append(_Field(_short(match[1]), match[3], "[]" if "<" in many else many))
    return fields


class _Reader:
    """Goes through one message and notes where its numbers stand."""

    def __init__(self, message: bytes, kinds: Mapping[str, list[_Field]], aligned: bool) -> None:
        self._message = message
        self._kinds = kinds
        self._aligned = aligned
        self._begin = 4 if aligned else 0
        self._at = self._begin
        self._layout = _Layout()

    def layout(self) -> _Layout:
        """The layout of the message.

        Raises:
            DamageError: the message is not as long as its definition and its lengths say.
        """
        self._take_fields("", self._kinds[""], 0)
        left = len(self._message) - self._at
        if not 0 <= left < 4:  # some writers fill the last word
            raise DamageError("its messages are not as long as their description says")
        return self._layout

    def _take_fields(self, front: str, fields: Sequence[_Field], depth: int) -> None:
        """The fields of one message; ``front`` stands before their names."""
        if depth > _DEEPEST:
            raise DamageError("its messages lie too deep in each other")
        names: list[str] = []
        # Lists of numbers wait until the names are known: name, kind and places of each.
        waiting: list[tuple[str, str, list[int]]] = []
        for each in fields:
            if each.kind in _TEXTS and each.many:
                texts = self._take_texts(each)
                names = texts if each.name == "name" else names
            elif each.kind in _TEXTS:
                self._take_text(each.kind)
            elif each.kind in NUMBERS and each.many:
                waiting.append((each.name, NUMBERS[each.kind], self._take_numbers(each)))
            elif each.kind in NUMBERS:
                kind = NUMBERS[each.kind]
                self._note(f"{front}{each.name}", self._take(kind), kind)
            else:
                self._take_message(f"{front}{each.name}", each, depth)
        are_names = all(names) and len({*names}) == len(names)
        for name, kind, places in waiting:
            if are_names and len(names) == len(places):
                labels = [f"{of_joint}.{name}" for of_joint in names]
            else:
                labels = [f"{name}[{number}]" for number in range(len(places))]
            for label, at in zip(labels, places, strict=True):
                self._note(f"{front}{label}", at, kind)

    def _take_message(self, label: str, each: _Field, depth: int) -> None:
        """A message inside, or a list of them."""
        count = self._count(each.many) if each.many else 1
        kind = each.kind
        # ROS 1 calls it Header, and describes std_msgs/Header.
        if kind not in self._kinds and "/" not in kind:
            likely = [name for name in self._kinds if name.endswith(f"/{kind}")]
            kind = likely[0] if len(likely) == 1 else kind
        for number in range(count):
            own = f"{label}[{number}]" if each.many else label
            if kind in _STAMPS:
                self._layout.stamps[f"{own} [s]"] = self._take("<u4")
                self._take("<u4")
            elif kind in self._kinds:
                self._take_fields(f"{own}.", self._kinds[kind], depth + 1)
            else:
                raise DamageError(f"its field {own} is a {kind}, which nothing describes")

    def _take(self, kind: str) -> int:
        """The place of the next number."""
        size = np.dtype(kind).itemsize
        if self._aligned:
            self._at += -(self._at - self._begin) % size
        at = self._at
        self._at += size
        if self._at > len(self._message):
            raise DamageError("its messages are not as long as their description says")
        return at

    def _count(self, many: str) -> int:
        """How many a list has."""
        if many != "[]":
            count = int(many[1:-1])
        else:
            at = self._take("<u4")
            (count,) = struct.unpack_from("<I", self._message, at)
            self._layout.same.append((at, at + 4))
        if count > LONGEST_LIST:
            raise DamageError(f"a list of it has {count:,} items, above {LONGEST_LIST}")
        return count

    def _take_text(self, kind: str) -> str:
        at = self._take("<u4")
        (length,) = struct.unpack_from("<I", self._message, at)
        end = self._at + length * (4 if kind == "wstring" else 1)
        if end > len(self._message):
            raise DamageError("a text in its messages is longer than they are")
        text = self._message[self._at : end]
        self._layout.same.append((at, at + 4))
        self._at = end
        return text.rstrip(b"\0").decode("utf-8", "replace")

    def _take_texts(self, each: _Field) -> list[str]:
        count = self._count(each.many)
        begin = self._at
        texts = [self._take_text(each.kind) for _ in range(count)]
        self._layout.same.append((begin, self._at))  # other names are other columns
        return texts

    def _take_numbers(self, each: _Field) -> list[int]:
        count = self._count(each.many)
        kind = NUMBERS[each.kind]
        return [self._take(kind) for _ in range(count)]

    def _note(self, label: str, at: int, kind: str) -> None:
        self._layout.numbers[label] = (at, kind)
        if len(self._layout.numbers) > _MOST_FIELDS:
            raise DamageError(f"its messages have more than {_MOST_FIELDS:,} numbers")

"""Bags of ROS 1 and ROS 2 are read by rosbags: a topic is a recording, fields of messages are columns.

A message is a row. Lists beside a list of names, as the states of joints have them, are columns called so; a message
whose fields are long lists of one length is as many rows.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import found_recordings, reader_in_child
from erclutch.logs.readers.budget import LONGEST_LIST
from erclutch.logs.readers.found_recordings import JOINT, Found
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_STAMP = ""  # of a row: when the bag got its message, in ns
_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")


def find(path: str, variable: str | None) -> Table:
    """The child's work: topics whose first message holds a number are recordings, on the time of the bag."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore
    from rosbags.typesys.store import Typestore

    # In this child, before any bag is opened.
    setattr(Typestore, "register", _held_to_names(Typestore.register))  # noqa: B010
    with AnyReader([Path(path)], default_typestore=get_typestore(Stores.LATEST)) as bag:
        topics: dict[str, list[Any]] = {}
        for connection in bag.connections:
            topics.setdefault(connection.topic, []).append(connection)
        together = [name.strip() for name in (variable or "").split(JOINT)]
        if all(name in topics for name in together):
            topics = {name: topics[name] for name in together}  # the others need not be looked at

        of_numbers: dict[str, list[Any]] = {}
        unread: dict[str, LogError] = {}
        for topic, connections in topics.items():
            types = [connection.msgtype for connection in connections]
            unknown = [each for each in types if each not in bag.typestore.fielddefs]
            if unknown:  # bags of ROS 2 before Iron name the types of a robot only
                problem = f"the bag does not define its messages, of type {unknown[0]}"
                remedy = "Record it by ROS 2 Iron or later, which defines them in the bag, or export the topic as CSV"
                unread[topic] = LogError(f"topic {topic}: {problem}", remedy=remedy)
                continue
            try:
                first_rows = _rows(bag, connections, most=1)
            except LogError as error:  # a scan, a picture or a whole course in one message
                unread[topic] = LogError(f"topic {topic}: {error.problem}", remedy=error.remedy)
                continue
            if any(len(row) > 1 for row in first_rows):  # a number beside the stamp
                of_numbers[topic] = connections
        if unread and not of_numbers and variable != found_recordings.ALL:
            raise next(iter(unread.values()))
        if len(together) > 1 and [*of_numbers] == together:
            rows_of = {name: _rows(bag, connections) for name, connections in of_numbers.items()}
            times_of = {name: _times_taken(rows) for name, rows in rows_of.items()}
            return found_recordings.joined_topics(
                {name: (times_of[name], _columns(rows)) for name, rows in rows_of.items()}, {}
            )
        topic, connections = found_recordings.choose(
            of_numbers, variable, "topic", "no topic of the bag holds numbers"
        )
        rows = _rows(bag, connections)
        counted = sum(connection.msgcount for connection in connections)

    notes = [f"recording read from topic {topic}"]
    notes += [f"{error.problem}: left out" for error in unread.values()]
    times = _times_taken(rows)  # ns, shape (rows,)
    in_batches = 2 * counted < len(rows)
    if in_batches:
        notes.append(
            f"{counted} messages of several rows each: they share the time of the bag, which is left out"
        )
    elif counted != len(rows):
        notes.append(f"the bag counts {counted} messages, {len(rows)} are there")
    elapsed = (times - times[0]) * 1e-9  # s
    clock = None if in_batches else ("log_time", elapsed)
    return Found(_columns(rows), clock=clock, notes=notes).table()


def _held_to_names(register: Callable[[Any, Any], None]) -> Callable[[Any, Any], None]:
    """Message types become Python code in rosbags; so no name in the types of a bag may be more than a name."""

    def texts(node: Any) -> Iterator[str]:
        if isinstance(node, str):
            yield node
        elif isinstance(node, tuple | list):
            yield from (text for part in cast("Sequence[Any]", node) for text in texts(part))

    def checked(store: Any, types: Mapping[str, tuple[Any, Any]]) -> None:
        for name, (constants, fields) in types.items():
            without_values = [constant[:2] for constant in constants]  # kind and name of each
            for text in (name, *texts(fields), *texts(without_values)):
                if not _PLAIN.fullmatch(text):
                    problem = f"the bag defines a type with the name {text[:60]!r}"
                    raise LogError(
                        problem, remedy="Record the bag again, or export the topic as CSV"
                    )
        register(store, types)

    return checked


def _times_taken(rows: Sequence[dict[str, float]]) -> NDArray[np.int64]:
    """When the bag got the messages in ns, shape (rows,); taken out of the rows."""
    return np.array([row.pop(_STAMP) for row in rows], np.int64)


def _columns(rows: Sequence[Mapping[str, float]]) -> dict[str, Array]:
    """The numbers of rows by label, each of shape (rows,); what a row lacks is NaN."""
    labels = dict.fromkeys(label for row in rows for label in row)
    return {label: np.array([row.get(label, np.nan) for row in rows]) for label in labels}


def _rows(
    bag: Any,
    connections: list[Any],
    most: int | None = None,
) -> list[dict[str, float]]:
    """The messages of a topic, or the first of them: the time of the bag in ns under `_STAMP`, and the numbers."""
    rows: list[dict[str, float]] = []
    messages = bag.messages(connections=connections)
    for connection, stamp, data in islice(messages, most):
        message = bag.deserialize(data, connection.msgtype)
        fields = {name: getattr(message, name) for name in _fields(message)}
        lists = {name: value for name, value in fields.items() if _is_list(value)}
        lengths = {len(values) for values in lists.values()}
        if len(lists) < 2 or len(lengths) > 1 or min(lengths) <= LONGEST_LIST:
            row: dict[str, float] = {_STAMP: stamp}
            _flatten("", message, row)
            rows.append(row)
            continue

        # Lists of one length, longer than those of joints: a row a place, beside the single numbers of the message.
        beside: dict[str, float] = {_STAMP: stamp}
        for name, value in fields.items():
            if name not in lists:
                _flatten(name, value, beside)
        for place in range(min(lengths)):
            row = dict(beside)
            for name, values in lists.items():
                _flatten(name, values[place], row)
            rows.append(row)
    return rows


def _flatten(label: str, value: Any, row: dict[str, float]) -> None:
    """Numbers of a message under ``outer.inner`` and ``list[0]``; a stamp in s; texts are left out.

    Beside a list of names, the numbers of a list of its length are under ``name.list``, as ``elbow.effort``.
    """
    fields = _fields(value)
    if fields == ["sec", "nanosec"]:
        row[f"{label} [s]"] = value.sec + value.nanosec * 1e-9
    elif fields:
        # Names of joints are different texts.
        named: Any = getattr(value, "name", None)
        items = cast("list[Any]", named) if isinstance(named, list) else []
        names = [name for name in items if isinstance(name, str) and name]
        all_differ = len({*names}) == len(items)
        if not all_differ or len(items) > LONGEST_LIST:
            names = []
        front = f"{label}." if label else ""
        for name in fields:
            field = getattr(value, name)
            if names and _is_list(field) and len(field) == len(names):
                for of_joint, each in zip(names, field, strict=True):
                    _flatten(f"{front}{of_joint}.{name}", each, row)
            else:
                _flatten(f"{front}{name}", field, row)
    elif _is_list(value):
        if len(value) > LONGEST_LIST:
            problem = f"the field {label} has {len(value):,} numbers, above {LONGEST_LIST}"
            remedy = "Give a topic of single numbers, such as that of the states of the joints"
            raise LogError(problem, remedy=remedy)
        for index, each in enumerate(value):
            _flatten(f"{label}[{index}]", each, row)
    elif hasattr(value, "__float__"):
        row[label] = float(value)


def _fields(value: Any) -> list[str]:
    """Names of the fields of a message; none for any other value."""
    return [name for name in getattr(value, "__dataclass_fields__", ()) if name != "__msgtype__"]


def _is_list(value: Any) -> bool:
    return hasattr(value, "__len__") and not hasattr(value, "encode")


READER = LogReader(
    suffixes=(".db3", ".bag"),
    claims=lambda head: head.startswith(b"#ROSBAG V2.0"),
    **reader_in_child.in_child("rosbag", "rosbags"),
    tells_damage="not seen in the numbers: bags have no checksums, but damaged structure is",
    folder="metadata.yaml",
)

"""ROS 2 bags, as folder or file, are read by rosbags: a topic is a recording, fields of messages are columns."""

from __future__ import annotations

import sys
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader, claims_nothing
from erclutch.logs.readers import found_recordings
from erclutch.logs.readers.found_recordings import Found
from erclutch.logs.table import Table

_MOST = 500  # numbers of a list: a picture has more


def _flatten(label: str, value: Any, row: dict[str, float]) -> None:
    """Numbers of a message under ``outer.inner`` and ``list[0]``; a stamp in s; texts are left out."""
    fields = [name for name in getattr(value, "__dataclass_fields__", ()) if name != "__msgtype__"]
    if isinstance(value, (bool, int, float, np.number)):
        row[label] = float(value)
    elif fields == ["sec", "nanosec"]:
        row[f"{label} [s]"] = value.sec + value.nanosec * 1e-9
    elif isinstance(value, (list, tuple, np.ndarray)):
        if len(value) > _MOST:
            raise LogError(f"the field {label} has {len(value)} numbers", remedy="Choose a topic of single numbers")
        for index, each in enumerate(value):
            _flatten(f"{label}[{index}]", each, row)
    for name in fields if fields != ["sec", "nanosec"] else ():
        _flatten(f"{label}.{name}" if label else name, getattr(value, name), row)


def _rows(bag: Any, connections: list[Any], most: int | None = None) -> tuple[list[int], list[dict[str, float]]]:
    """Times in ns and numbers of the messages of a topic, or of the first of them."""
    times: list[int] = []
    rows: list[dict[str, float]] = []
    for connection, stamp, data in islice(bag.messages(connections=connections), most):
        times.append(stamp)
        rows.append({})
        _flatten("", bag.deserialize(data, connection.msgtype), rows[-1])
    return times, rows


def _find(path: str, variable: str | None) -> Table:
    """The child's work: topics whose first message holds a number are recordings, on the time of the bag."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    with AnyReader([Path(path)], default_typestore=get_typestore(Stores.LATEST)) as bag:
        topics: dict[str, list[Any]] = {}
        for connection in bag.connections:
            topics.setdefault(connection.topic, []).append(connection)
        named = {topic: topics[topic] for topic in topics if not variable or topic == variable} or topics
        found = {topic: each for topic, each in named.items() if any(_rows(bag, each, 1)[1])}
        topic, connections = found_recordings.choose(found, variable, "topic", "no topic of the bag holds numbers")
        times, rows = _rows(bag, connections)
    labels = dict.fromkeys(label for row in rows for label in row)
    columns = {label: np.array([row.get(label, np.nan) for row in rows]) for label in labels}
    clock = "log_time", (np.array(times) - times[0]) * 1e-9
    return Found(columns, clock=clock, notes=[f"recording read from topic {topic}"]).table()


_READ = found_recordings.read_in_child("erclutch.logs.readers.ros2", "rosbags")
_DAMAGE = "TBD"
READER = LogReader((".db3",), claims_nothing, _READ, tells_damage=_DAMAGE, folder="metadata.yaml")

if __name__ == "__main__":
    sys.exit(found_recordings.serve(_find))

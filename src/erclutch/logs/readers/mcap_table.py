"""MCAP logs are recordings of ``erclutch live``, or messages of numbers that ROS or Foxglove recorded.

A row a message: ``ros1``, ``cdr`` (ROS 2) and ``json``; `ros_messages` reads lists and messages inside. Units come from
the channel's metadata (``unit.NAME``) or from a label such as ``V [cm/s]``; time is the messages' log time.
"""

from __future__ import annotations

import json
import re
from dataclasses import replace
from typing import Any, NamedTuple, cast

import numpy as np
from mcap import records as kinds
from numpy.typing import NDArray

from erclutch.errors import LogError
from erclutch.logs.columns.labels import name_columns
from erclutch.logs.log_reader import LogSource
from erclutch.logs.readers import json_layout, mcap_records, ros_messages
from erclutch.logs.readers.found_recordings import JOINT, choose, joined_topics
from erclutch.logs.readers.mcap_records import Contents, DamageError, MessageRun
from erclutch.logs.table import Table
from erclutch.signals.array import Array, Mask

MAGIC = mcap_records.MAGIC
#: Key of a channel's metadata that gives the unit of a column.
UNIT_KEY = "unit."
#: Key of a live recording's channel: bits of the column ``events`` that mark a row without a good sample.
UNSAMPLED_KEY = "unsampled_events"
_NONE = "no topic of the file holds messages of numbers (ros1, ROS 2 or JSON)"
_COPY = "Copy the file again from where it was recorded"

_TYPES = ros_messages.NUMBERS
_STAMPS = ("time", "duration")
_SCHEMAS = {"ros1": "ros1msg", "cdr": "ros2msg"}  # encoding of a definition by that of its messages
_FIELD = re.compile(r"([A-Za-z][\w/]*)\s+([A-Za-z]\w*)")
_CONSTANT = re.compile(r"[A-Za-z]\w*\s+[A-Za-z]\w*\s*=.*")


class _Topic(NamedTuple):
    """The messages of one channel of numbers.

    Attributes:
        channel: as the file describes it.
        columns: numbers of the messages by label, each of shape (n,).
        times: log times in ns, shape (n,).
    """

    channel: kinds.Channel
    columns: dict[str, Array]
    times: NDArray[np.int64]

    @property
    def units(self) -> dict[str, str | None]:
        """The unit of each column by the channel's metadata; None where these say none."""
        return {label: self.channel.metadata.get(UNIT_KEY + label) for label in self.columns}


def read_mcap(source: LogSource) -> Table:
    """Read the channel of an MCAP file that holds numbers, or that of the chosen topic.

    A file that was not closed is read as far as it is whole, and a note says so.

    Raises:
        LogError: no MCAP file, damaged, nothing whole in it, no channel of numbers, or several and none chosen.
    """
    try:
        contents = mcap_records.read_contents(source.data)
    except DamageError as error:
        raise LogError(f"the MCAP file is damaged: {error}", remedy=_COPY) from error
    except MemoryError as error:
        raise LogError("the MCAP file does not fit into memory", remedy="Split the log") from error
    if contents.torn is not None and not contents.runs:
        raise LogError(
            "the MCAP file was not closed, and no message in it is whole",
            remedy="Take another recording",
        )
    notes: list[str] = []
    topics = _topics(contents, notes)
    together = [name.strip() for name in (source.variable or "").split(JOINT)]
    if len(together) > 1 and all(name in topics for name in together) and contents.torn is None:
        asked = {name: topics[name] for name in together}
        joined = joined_topics(
            {name: (topic.times, topic.columns) for name, topic in asked.items()},
            {name: topic.units for name, topic in asked.items()},
        )
        return replace(
            joined,
            name=source.name,
            digest=source.digest,
            notes=(*notes, *joined.notes),
        )

    _, topic = choose(topics, source.variable, "topic", _NONE)
    channel = topic.channel
    if contents.torn is not None:
        whole = f"read as far as it is whole, without the last {contents.torn} bytes"
        notes.append(f"the recording was not closed: {whole}")
        # Messages that the numbers of the others show to be lost between them; some writers number none.
        of_runs: list[NDArray[np.int64]] = []
        for run in contents.runs:
            own = run.array[run.array["channel"] == channel.id]
            of_runs.append(own["seq"].astype(np.int64))
        steps = np.diff(np.concatenate(of_runs))
        missing = int((steps[steps > 1] - 1).sum())
        if missing:
            are_missing = f"{missing} messages are missing by their numbers"
            notes.append(f"{are_missing}: their chunks are damaged")
        if channel.id not in contents.checked:
            to_check = "check names and units of the columns"
            notes.append(f"{to_check}: no checksum of the file covers them")
    since_first = topic.times - topic.times[0]  # ns
    names, units, renamed = name_columns(list(topic.columns), list(topic.units.values()))
    unsampled: Mask | None = None  # rows in which no good sample came, by the bits of their events
    bits = channel.metadata.get(UNSAMPLED_KEY, "")
    if bits.isdecimal() and len(bits) <= 9 and "events" in topic.columns:
        unsampled = (topic.columns["events"].astype(np.int64) & int(bits)) != 0

    # Settings of the file; where damage took ours (with the label TWIN), the copy that each channel carries.
    of_channel: dict[str, str] = {}
    for key, text in channel.metadata.items():
        if not key.startswith((UNIT_KEY, UNSAMPLED_KEY)):
            of_channel[key] = text
    copy = {"erclutch": of_channel} if "erclutch" in of_channel else {}
    settings = {**copy, **contents.metadata}
    if contents.torn is not None:
        settings = {**contents.metadata, **copy}
    return Table(
        name=source.name,
        columns=dict(zip(names, topic.columns.values(), strict=True)),
        units=dict(zip(names, units, strict=True)),
        digest=source.digest,
        clock=since_first.astype(np.float64) * 1e-9,
        clock_name="log_time",
        metadata={key: json.dumps(dict(pairs)) for key, pairs in settings.items()},
        notes=(f"recording read from topic {channel.topic}", *notes, *renamed),
        unsampled=unsampled,
    )


def _topics(contents: Contents, notes: list[str]) -> dict[str, _Topic]:
    """Each channel of numbers by its topic; what is no number is left out and said."""
    topics: dict[str, _Topic] = {}
    for number, channel in contents.channels.items():
        try:
            columns, times = _columns(contents, number, channel)
        except DamageError as error:
            notes.append(f"topic {channel.topic} left out: {error}")
            continue
        if not columns or not times.size:
            continue
        if channel.topic in topics:
            problem = f"two channels are called {channel.topic}"
            raise LogError(problem, remedy="Record one channel a topic")
        topics[channel.topic] = _Topic(channel, columns, times)
    return topics


def _columns(
    contents: Contents,
    number: int,
    channel: kinds.Channel,
) -> tuple[dict[str, Array], NDArray[np.int64]]:
    """Columns and log times of a channel; DamageError says which encoding or field is not read here."""
    parts: list[MessageRun] = []
    for run in contents.runs:
        own = run.array[run.array["channel"] == number]
        if own.size:
            parts.append(MessageRun(run.offset, own))
    if not parts:
        return {}, np.empty(0, np.int64)
    times = np.concatenate([part.array["log_time"] for part in parts]).astype(np.int64)
    encoding = channel.message_encoding
    if encoding == "json":
        return _json_columns(parts), times

    schema = contents.schemas.get(channel.schema_id)
    if schema is None or schema.encoding != _SCHEMAS.get(encoding):
        raise DamageError(f"its messages are encoded as {encoding or 'nothing'}")
    is_ros2 = encoding == "cdr"
    definition = schema.data.decode("utf-8", "replace")
    blocks = [part.data for part in parts]  # each of messages of one length
    try:
        kind = layout(definition, aligned=is_ros2)
    except DamageError:
        # Texts, lists or messages are in it, as in the states of joints.
        return ros_messages.columns_of(definition, blocks, aligned=is_ros2), times
    if any(block.shape[1] != kind.itemsize for block in blocks):
        said = f"the {kind.itemsize} bytes that its description says"
        raise DamageError(f"its messages are not {said}")
    rows = np.concatenate(blocks)
    if is_ros2 and (rows[:, 1] != 1).any():
        raise DamageError("its messages are not little-endian")
    table = np.ascontiguousarray(rows).view(kind)[:, 0]
    return {field: table[field].astype(np.float64) for field in kind.names or ()}, times


def layout(text: str, *, aligned: bool = False) -> np.dtype[Any]:
    """The bytes of a ROS message of plain numbers.

    Args:
        text: the message definition, such as ``float64 theta  # rad`` line by line.
        aligned: as ROS 2 sends it (CDR): four bytes ahead, numbers at multiples of their size.

    Raises:
        DamageError: a field that is no plain number.
    """
    names: list[str] = []
    formats: list[str] = []
    for line in text.splitlines():
        line = line.partition("#")[0].strip()
        if line.startswith("==="):
            break
        if not line or _CONSTANT.fullmatch(line):
            continue
        match = _FIELD.fullmatch(line)
        kind, name = match.groups() if match else ("", "")
        if (kind not in _TYPES and kind not in _STAMPS) or name in names:
            raise DamageError(f"its field '{line[:60]}' is no plain number")
        if kind in _STAMPS:  # a ROS 1 time is two numbers; both stay, under names of their own
            names += [f"{name}_s", f"{name}_ns"]
            formats += ["<i4", "<u4"]
        else:
            names.append(name)
            formats.append(_TYPES[kind])
    if not names:
        raise DamageError("its messages have no fields")
    if not aligned:
        return np.dtype(list(zip(names, formats, strict=True)))
    offsets: list[int] = []
    end = 4
    for form in formats:
        size = np.dtype(form).itemsize
        numbers_before = -(-(end - 4) // size)  # of this size, rounded up
        offsets.append(4 + numbers_before * size)
        end = offsets[-1] + size
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": end})


def _json_columns(parts: list[MessageRun]) -> dict[str, Array]:
    """Numbers of JSON objects; those inside other objects under ``outer.inner``. What is missing becomes NaN.

    Texts and long lists are left out.
    """
    rows: list[dict[str, float]] = []
    for part in parts:
        for message in part.data:
            try:
                body: Any = json.loads(message.tobytes())
            except (ValueError, RecursionError) as error:
                raise DamageError("a message is no JSON") from error
            row: dict[str, float] = {}
            members = cast("dict[str, Any]", body) if isinstance(body, dict) else {}
            for name, value in json_layout.cells_of(members):
                if not isinstance(value, (int, float)):
                    continue
                try:
                    row[name] = float(value)
                except OverflowError:  # an integer with hundreds of digits
                    row[name] = float("inf")
            rows.append(row)
    names = dict.fromkeys(name for row in rows for name in row)
    if len(names) > 1000:
        raise DamageError("its messages have more than 1000 different fields")
    columns: dict[str, Array] = {}
    for name in names:
        columns[name] = np.array([row.get(name, np.nan) for row in rows])
    return columns

"""Objects in MATLAB files become plain Python: tables, timetables, timeseries and what Simulink logs.

A variable that is an object holds only a reference: the mark, the shape, an object's number for each element, the
class's number. The properties lie in the file's subsystem (``FileWrapper__``): its first cell numbers names, classes
and objects, the further cells hold values, the last holds what a class sets by itself. The layout is no public one;
it was learnt from the documents of foreverallama/matio (BSD-3-Clause) and held against files that MATLAB wrote.

A table becomes a struct of vectors, a timeseries a struct of its time and its numbers, a data set of Simulink a struct
of signals: one with a single time where all signals share it. Objects of other classes become None.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import chain, pairwise, repeat
from typing import Any, cast

import numpy as np

from erclutch.logs.readers.budget import Budget
from erclutch.logs.readers.json_columns import labelled
from erclutch.logs.readers.mat_streams import (
    Records,
    is_streamed,
    signal_of_a_stream,
    unit_of_time,
)

Fields = dict[str, Any]
_MARK = 0xDD000000  # the first number of a reference
_VERSIONS = (2, 3, 4)  # of the subsystem
_CELLS_BEHIND = {2: 1, 3: 2, 4: 3}  # cells behind the values, by version
_DEEPEST = 12  # objects inside of objects
_MOST_ROWS = 1 << 28  # that are made of a start and a step
#: Seconds in a unit of a timeseries' time.
_SECONDS = {
    "nanoseconds": 1e-9,
    "microseconds": 1e-6,
    "milliseconds": 1e-3,
    "seconds": 1.0,
    "minutes": 60.0,
    "hours": 3600.0,
    "days": 86400.0,
    "weeks": 604800.0,
}
_UNNAMED = ("", "unnamed")
_TIMES = ("time_s", "time")  # what the time of a timeseries is called here


def is_reference(node: Any) -> bool:
    """Whether a node is a reference to one object or several."""
    if not isinstance(node, np.ndarray):
        return False
    array = cast("np.ndarray[Any, Any]", node)
    may_be = array.dtype == np.uint32 and array.size >= 6
    return may_be and int(array.ravel()[0]) == _MARK


class Objects:
    """The objects of one file."""

    def __init__(
        self, cells: Sequence[Any], budget: Budget, records: Records = lambda number: None
    ) -> None:
        """Objects of a subsystem.

        Args:
            cells: of the subsystem, as plain Python.
            budget: of the file; each object counts.
            records: of signals that were streamed to the file.

        Raises:
            ValueError, IndexError: the first cell is none that is known.
        """
        self._budget = budget
        self.records = records
        head = np.asarray(cells[0], np.uint8).tobytes()
        order = "<" if int.from_bytes(head[:4], "little") in _VERSIONS else ">"
        numbers = np.frombuffer(head[: len(head) // 4 * 4], f"{order}u4")
        version = int(numbers[0])
        if version not in _VERSIONS:
            raise ValueError(f"objects are saved in version {version}, not in one of {_VERSIONS}")
        # Where classes, made properties, objects and properties begin, in bytes.
        starts = [int(start) for start in numbers[2:10]]
        names = head[40 : starts[0]].split(b"\0")
        self._names = [name.decode("latin-1") for name in names if name]
        parts = [numbers[start // 4 : end // 4] for start, end in pairwise(starts[:5])]
        self._classes, made, self._objects, own = parts
        self._made = _lists_of(made)
        self._own = _lists_of(own)
        self._values = cells[2 : len(cells) - _CELLS_BEHIND[version]]
        of_classes = cells[-1]
        self._defaults: list[Any] = of_classes if isinstance(of_classes, list) else []
        self._open: list[int] = []  # objects that are being read, one inside the other
        self._read: dict[int, Any] = {}

    def resolved(self, node: Any) -> Any:
        """A node with what its references lead to."""
        if is_reference(node):
            return self._referred(node)
        if isinstance(node, dict):
            return {name: self.resolved(field) for name, field in cast("Fields", node).items()}
        if isinstance(node, list):
            return [self.resolved(item) for item in cast("list[Any]", node)]
        return node

    def _referred(self, reference: np.ndarray[Any, Any]) -> Any:
        """The object that a reference leads to, or a list of several; None where nothing of the kind is there."""
        objects: list[Any] = []
        for number in _numbers_of(reference):
            self._budget.take_names()
            if number not in self._read:
                if number in self._open or len(self._open) >= _DEEPEST:
                    return None
                self._open.append(number)
                plain = None
                with suppress(IndexError, ValueError, TypeError, KeyError):
                    plain = self._object(number)
                self._open.pop()
                self._read[number] = plain
            objects.append(self._read[number])
        return objects[0] if len(objects) == 1 else objects

    def _object(self, number: int) -> Any:
        """An object of a class that can be plain, else None."""
        class_of = int(self._objects[6 * number])
        # Names are counted from 1; 0 is none.
        space, own = (int(place) for place in self._classes[4 * class_of : 4 * class_of + 2])
        name = self._names[own - 1]
        read = _READERS.get(f"{self._names[space - 1]}.{name}" if space else name)
        return read(self, self._properties(number)) if read else None

    def _properties(self, number: int) -> Fields:
        """Properties of an object by name, with references in them as they are."""
        places = [int(place) for place in self._objects[6 * number : 6 * number + 6]]
        class_of, _, _, made, own, _ = places
        properties: Fields = {}
        if class_of < len(self._defaults):
            defaults: Any = self._defaults[class_of]
            if isinstance(defaults, dict):
                properties |= cast("Fields", defaults)
        listed = self._made[made] if made else self._own[own]
        for name, sort, place in listed:
            if sort == 1:
                properties[self._names[name - 1]] = self._values[place]
            elif sort == 2:  # the number itself
                properties[self._names[name - 1]] = np.array([float(place)])
        return properties

    def fields(self, node: Any) -> Fields:
        """Fields of a struct, or properties of the object that a node refers to; none for any other node."""
        if isinstance(node, dict):
            return cast("Fields", node)
        return self._properties(_numbers_of(node)[0]) if is_reference(node) else {}

    def text(self, node: Any) -> str:
        """A text, a string object, or the name of a unit; "" for any other node."""
        if is_reference(node):
            node = self._referred(node) or self.fields(node).get("Name")
        return node.strip() if isinstance(node, str) else ""


def _numbers_of(reference: np.ndarray[Any, Any]) -> list[int]:
    """Numbers of the objects that a reference names: behind the mark, the count of sides and the sides."""
    numbers = [int(number) for number in reference.ravel()]
    return numbers[2 + numbers[1] : -1]


def _lists_of(numbers: np.ndarray[Any, Any]) -> list[list[tuple[int, int, int]]]:
    """Lists of properties, one behind the other: a count, then name, sort and place of each, to an even length."""
    lists: list[list[tuple[int, int, int]]] = []
    start = 0
    while start < numbers.size:
        count = int(numbers[start])
        end = start + 1 + 3 * count
        if end > numbers.size:
            break
        triples = numbers[start + 1 : end].reshape(-1, 3)
        lists.append([(int(name), int(sort), int(place)) for name, sort, place in triples])
        start = end + end % 2
    return lists


def _number(node: Any, default: float = np.nan) -> float:
    """The first number of a node; the default where there is none."""
    if not isinstance(node, np.ndarray):
        return default
    array = cast("np.ndarray[Any, Any]", node)
    if not array.size or array.dtype.kind not in "biuf":
        return default
    return float(array.ravel()[0])


def _texts(objects: Objects, node: Any) -> list[str]:
    """Texts of a cell; none of any other node."""
    if not isinstance(node, list):
        return []
    return [objects.text(item) for item in cast("list[Any]", node)]


def _add_variables(
    columns: Fields, objects: Objects, data: Any, names: Sequence[str], units: Sequence[str]
) -> None:
    """Variables of a table as columns under their names and units; what holds no numbers is left to be told."""
    cells = cast("list[Any]", data) if isinstance(data, list) else []
    for name, cell, unit in zip(names, cells, chain(units, repeat("")), strict=False):
        values = objects.resolved(cell)
        if not isinstance(values, np.ndarray):
            rows = len(cast("list[Any]", values)) if isinstance(values, list) else 0
            values = np.full(max(rows, 2), None, object)
        elif is_reference(cell):
            unit = "s"  # of a duration or a date
        columns[labelled(name, unit)] = values


def _table(objects: Objects, properties: Fields) -> Fields:
    """A table: its variables."""
    props = objects.fields(properties.get("props"))
    names = _texts(objects, properties["varnames"])
    if _number(props.get("useVariableNamesOriginal"), 0.0):
        names = _texts(objects, props.get("VariableNamesOriginal")) or names
    units = _texts(objects, props.get("VariableUnits"))
    columns: Fields = {}
    _add_variables(columns, objects, properties["data"], names, units)
    return columns


def _timetable(objects: Objects, properties: Fields) -> Fields:
    """A timetable: its times in s from its first row, then its variables."""
    held = objects.fields(properties["any"])
    names = _texts(objects, held["varNames"])
    if _number(held.get("useVarNamesOrig"), 0.0):
        names = _texts(objects, held.get("varNamesOrig")) or names
    rows = int(_number(held["numRows"]))
    times = held["rowTimes"]
    if isinstance(times, dict):
        grid = cast("Fields", times)  # a rate, or a step
        if _number(grid.get("specifiedAsRate"), 0.0):
            step = 1.0 / _number(grid["sampleRate"])
        else:
            step = _number(objects.resolved(grid["stepSize"]))
        start = _number(objects.resolved(grid.get("origin")), 0.0)
        if not step > 0.0:  # a step of the calendar, such as a month
            raise ValueError("a timetable without a step in seconds")
        seconds: Any = start + step * np.arange(min(rows, _MOST_ROWS))
    else:
        seconds = objects.resolved(times)
    units = _texts(objects, held.get("varUnits"))
    columns: Fields = {"time_s": seconds}
    _add_variables(columns, objects, held["data"], names, units)
    return columns


def _datetime(objects: Objects, properties: Fields) -> np.ndarray[Any, Any]:
    """Seconds of dates from the first. The imaginary part is what a double of the milliseconds leaves out."""
    del objects
    stored = np.asarray(properties["data"], np.complex128)
    millis: np.ndarray[Any, np.dtype[np.complex128]] = stored.ravel()
    since_first = millis.real - millis.real[0]
    left_out = millis.imag - millis.imag[0]
    return (since_first + left_out) / 1000.0


def _string(objects: Objects, properties: Fields) -> str | list[str] | None:
    """Texts of a string: version, count of sides, sides, lengths; then letters of two bytes."""
    del objects
    numbers = np.asarray(properties["any"], np.uint64).ravel()
    end_of_sides = 2 + int(numbers[1])
    count = int(np.prod([int(side) for side in numbers[2:end_of_sides]]))  # texts
    end_of_lengths = end_of_sides + count
    lengths = [int(length) for length in numbers[end_of_sides:end_of_lengths]]
    letters = numbers[end_of_lengths:].tobytes()
    texts: list[str] = []
    start = 0
    for length in lengths:
        is_missing = length >= len(letters)  # a missing text has the largest length
        end = start if is_missing else start + 2 * length
        texts.append(letters[start:end].decode("utf-16-le", "replace"))
        start = end
    return texts[0] if len(texts) == 1 else texts


def _timeseries(objects: Objects, properties: Fields) -> Fields:
    """A timeseries: its time, in s where its unit is known, and its numbers under its name."""
    info = objects.fields(properties.get("TimeInfo"))
    time: np.ndarray[Any, Any] | None = None
    for stored in (info.get("Time_"), properties.get("Time_"), properties.get("Time")):
        if isinstance(stored, np.ndarray) and cast("np.ndarray[Any, Any]", stored).size:
            time = np.asarray(stored, np.float64).ravel()
            break
    if time is None:
        start = _number(info.get("Start_", info.get("Start")), 0.0)
        step = _number(info.get("Increment_", info.get("Increment")))
        length = _number(info.get("Length_", info.get("Length")))
        if not step > 0.0 or not 0 < length < _MOST_ROWS:
            raise ValueError("a timeseries without a time")
        time = start + step * np.arange(int(length))
    unit_of_time = objects.text(info.get("Units"))
    in_seconds = _SECONDS.get(unit_of_time)  # None where the unit is not known

    data = np.asarray(properties["Data_"])
    samples_lie_last = data.shape[0] != time.size and data.shape[-1] == time.size
    if samples_lie_last:
        data = data.reshape(-1, time.size).T
    elif data.ndim > 2:
        data = data.reshape(data.shape[0], -1)
    name = objects.text(properties.get("Name"))
    unit = objects.text(objects.fields(properties.get("DataInfo")).get("Units"))
    label = labelled("data" if name in _UNNAMED else name, unit)
    if in_seconds is None:
        return {"time": time, label: data}
    return {"time_s": time * in_seconds, label: data}


def _dataset(objects: Objects, properties: Fields) -> Fields:
    """Logged signals of Simulink."""
    held = objects.fields(properties.get("any")) or properties
    storage = objects.fields(held.get("Storage")) or held
    storage = objects.fields(storage.get("any")) or storage
    elements = storage["Elements"]
    signals: Fields = {}
    for place, element in enumerate(cast("list[Any]", elements), start=1):
        fields = objects.fields(element)
        values = objects.resolved(fields.get("Values", element))
        if not isinstance(values, dict):
            continue
        values = cast("Fields", values)
        if is_streamed(values):
            # Its samples lie in a stream of the file; from here on it is a timeseries like the others.
            in_seconds = _SECONDS.get(unit_of_time(values))
            try:
                signal = signal_of_a_stream(values, objects.records)
            except ValueError:
                values = {"data": np.full(2, None, object)}  # without a time, where no samples are
            else:
                time = signal.pop("time")
                with_unit = {"time": time} if in_seconds is None else {"time_s": time * in_seconds}
                values = {**with_unit, **signal}
        labels = [key for key in values if key not in _TIMES]
        labels_of_numbers = [key for key in labels if isinstance(values[key], np.ndarray)]
        own_label = labels_of_numbers[0] if len(labels_of_numbers) == 1 else ""
        own_name, bracket, unit = own_label.partition(" [")

        # Simulink sets a name in <> where a bus gave it.
        name = objects.text(fields.get("Name")) or objects.text(fields.get("PropagatedName"))
        name = name.strip("<>")
        if not name and own_name.strip("<>") != "data":
            name = own_name.strip("<>")
        if not name:
            block = objects.fields(fields.get("BlockPath"))
            paths = _texts(objects, block.get("path"))
            if paths:
                name = paths[-1].rpartition("/")[2]
        name = name or f"signal{place}"
        if name in signals:
            name = f"{name}_{place}"
        # The numbers of a timeseries may have another name than the signal; other structs stay as they are.
        if len(labels) == len(labels_of_numbers) == 1:
            label = f"{name}{bracket}{unit}"
            values = {label if key == own_label else key: node for key, node in values.items()}
        signals[name] = values

    return _together(signals)


def _together(signals: Fields) -> Fields:
    """Signals that all have the same time as one struct; a signal that could not be read is told there by its name."""
    unread: Fields = {}
    for name, part in signals.items():
        nodes = [*cast("Fields", part).values()]
        if len(nodes) == 1 and isinstance(nodes[0], np.ndarray):
            array = cast("np.ndarray[Any, Any]", nodes[0])
            if array.dtype == object:
                unread[name] = array
    signals = {name: part for name, part in signals.items() if name not in unread}
    parts = [cast("Fields", part) for part in signals.values()]
    if len(parts) == 1:
        return parts[0] | unread
    times = [np.asarray(part["time_s"]) for part in parts if "time_s" in part]
    if not parts or len(times) < len(parts):
        return signals
    if not all(np.array_equal(time, times[0]) for time in times):
        return signals
    together: Fields = {"time_s": times[0]}
    for part in parts:
        for key, node in part.items():
            if key != "time_s" and key in together:
                return signals
            together[key] = node
    return together | unread


def _output(objects: Objects, properties: Fields) -> Any:
    """What a simulation put out: its logged signals, which have times of their own, or vectors beside one time."""
    output = objects.resolved(properties.get("Data"))
    if not isinstance(output, dict):
        return output
    fields = cast("Fields", output)
    logged: Fields = {}
    has_vectors = False
    for name, node in fields.items():
        if isinstance(node, dict) and node:
            logged[name] = node
        elif isinstance(node, np.ndarray) and name != "tout":
            has_vectors = True
    if not logged or has_vectors:
        return fields
    if len(logged) == 1:
        (only,) = logged.values()
        return only
    return logged


_READERS: dict[str, Callable[[Objects, Fields], Any]] = {
    "table": _table,
    "timetable": _timetable,
    "duration": lambda _, properties: np.asarray(properties["millis"], np.float64) / 1000.0,  # s
    "datetime": _datetime,
    "string": _string,
    "timeseries": _timeseries,
    "Simulink.SimulationData.Dataset": _dataset,
    "Simulink.SimulationOutput": _output,
}

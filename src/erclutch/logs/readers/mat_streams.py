"""Signals that Simulink logged to a v7.3 file have their samples in a stream, and beside it what they are.

Simulink that logs to a file (``Simulink.SimulationData.Dataset`` in a long run, or of a target) writes each signal's
samples as raw bytes into ``#sigstream#``, record by record. The signal's element names the record, its class, its sides
and its time: a start, a step and a count (``CompressedTime``), or another record (``TimeR2``). The layout is no public
one; it was learnt from files that MATLAB wrote.
"""

from __future__ import annotations

from collections.abc import Callable
from math import prod
from typing import Any, cast

import numpy as np

Fields = dict[str, Any]
#: Gives the bytes of a record by its number; None where the file has no such record.
Records = Callable[[int], bytes | None]
_MOST_ROWS = 1 << 28
#: Little-endian types by the class that Simulink names.
_TYPES = {
    "double": "<f8",
    "single": "<f4",
    "int8": "<i1",
    "uint8": "<u1",
    "int16": "<i2",
    "uint16": "<u2",
    "int32": "<i4",
    "uint32": "<u4",
    "int64": "<i8",
    "uint64": "<u8",
    "boolean": "<u1",
    "logical": "<u1",
}
_KEYS = ("CompressedTime", "DataR2")


def is_streamed(values: Fields) -> bool:
    """Whether fields are those of a signal whose samples lie in a stream."""
    return all(key in values for key in _KEYS)


def signal_of_a_stream(values: Fields, records: Records) -> Fields:
    """Time in s (or in a unit that is not known) and samples of a signal, the samples under ``data`` and its unit.

    Args:
        values: of the signal's element.
        records: of the file.

    Raises:
        ValueError: the samples are not where the element says, or of a class that is no number.
    """
    attributes = values.get("SignalAttributes")
    attributes = cast("Fields", attributes) if isinstance(attributes, dict) else {}
    kind = _TYPES.get(str(attributes.get("ClassName")))
    if kind is None:
        raise ValueError(f"samples of class {attributes.get('ClassName')!r}")
    width = prod(int(side) for side in _numbers(attributes.get("Dimension"))) or 1
    samples = _record(values["DataR2"], records, kind)
    rows, rest = divmod(samples.size, width)
    # The times have a record of their own, or the element gives a start, a step and their count.
    if _numbers(values.get("TimeR2")).size == 1:
        times = _record(values["TimeR2"], records, "<f8")
    else:
        grid = _numbers(values["CompressedTime"])
        if grid.size != 3 or not grid[1] > 0.0 or not 0 < grid[2] < _MOST_ROWS or grid[2] != rows:
            raise ValueError("a signal without a time")
        times = grid[0] + grid[1] * np.arange(rows)
    if rest or not rows or times.size != rows:
        raise ValueError(f"{samples.size} samples of {width} numbers at {times.size} times")

    unit = _text(values.get("DataUnits"))
    label = f"data [{unit}]" if unit else "data"
    data = samples.reshape(rows, width)
    return {"time": times, label: data[:, 0] if width == 1 else data}


def unit_of_time(values: Fields) -> str:
    """The unit of a signal's time, as MATLAB calls it; "" where none is said."""
    return _text(values.get("TimeUnits"))


def _record(number: Any, records: Records, kind: str) -> np.ndarray[Any, Any]:
    """The numbers of a record."""
    places = _numbers(number)
    held = records(int(places[0])) if places.size == 1 and places[0] >= 0 else None
    if held is None or len(held) % np.dtype(kind).itemsize:
        raise ValueError(f"no record {number}")
    return np.frombuffer(held, kind)


def _numbers(node: Any) -> np.ndarray[Any, Any]:
    """Numbers of an array; none of any other node."""
    if not isinstance(node, np.ndarray):
        return np.zeros(0)
    array = cast("np.ndarray[Any, Any]", node)
    return array.ravel().astype(np.float64) if array.dtype.kind in "biuf" else np.zeros(0)


def _text(node: Any) -> str:
    """The text of a unit, which MATLAB keeps beside its class."""
    if isinstance(node, dict):
        node = cast("Fields", node).get("Value")
    return node.strip() if isinstance(node, str) else ""

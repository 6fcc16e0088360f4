"""HDF5 logs hold a recording in each group with vectors, or in each table; an attribute of a vector gives its unit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.logs.columns.names import spoken_name
from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import found_recordings, mat, reader_in_child
from erclutch.logs.readers.budget import budget_of
from erclutch.logs.readers.found_recordings import Found
from erclutch.logs.readers.header_pairs import sample_period
from erclutch.logs.readers.mat_cells import heads_of
from erclutch.logs.readers.mat_tree import stored_values
from erclutch.logs.readers.told_units import take_told_units, texts_in
from erclutch.logs.readers.trials import trials_in, without_names
from erclutch.logs.readers.vectors import of_vectors
from erclutch.logs.table import Table
from erclutch.signals.units import is_unit

_UNITS = ("unit", "units", "Unit", "Units")
_LONGEST_UNIT = 16  # letters
#: When the samples of a vector begin.
_STARTS = ("t0", "start", "start_time", "t_start", "offset", "wf_start_offset")


@dataclass
class _Place:
    """A group with vectors, or a table: the place of one recording."""

    texts: dict[str, str]
    nodes: dict[str, Any] = field(default_factory=dict[str, Any])
    units: dict[str, str | None] = field(default_factory=dict[str, "str | None"])
    notes: list[str] = field(default_factory=list[str])
    unit: str | None = None  # what the group says of its only vector
    # Numbers that the group has for a field.
    fields: dict[str, float] = field(default_factory=dict[str, float])
    # Lists of texts beside the vectors or in their attributes, by name: names of columns, or units.
    headings: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    # Attributes of the vectors, by their names.
    of_vectors: dict[str, dict[str, str]] = field(default_factory=dict[str, "dict[str, str]"])


def _texts(attributes: Any) -> dict[str, str]:
    """Attributes that are one text or number, as texts."""
    texts: dict[str, str] = {}
    for key, value in attributes.items():
        if np.size(value) != 1:
            continue
        single: Any = np.ravel(value)[0]
        if isinstance(single, bytes):
            single = single.decode("utf-8", "replace")
        if np.isscalar(single):
            texts[key] = str(single)
    return texts


def _fields(attributes: Any) -> dict[str, float]:
    """Attributes of a group that are a number and called like a field."""
    fields: dict[str, float] = {}
    for key, value in attributes.items():
        is_number = np.size(value) == 1 and np.asarray(value).dtype.kind in "iuf"
        if is_number and len(spoken_name(key).forms["field"] or "") > 1:
            fields[key] = float(np.ravel(value)[0])
    return fields


def _lists(attributes: Any) -> dict[str, list[str]]:
    """Attributes or vectors that are several texts, by name."""
    lists: dict[str, list[str]] = {}
    for key, value in attributes.items():
        if np.size(value) < 2 or np.asarray(value).dtype.kind not in "OSU":
            continue
        texts: list[str] = []
        for each in np.ravel(value).tolist():
            texts.append(each.decode("utf-8", "replace") if isinstance(each, bytes) else str(each))
        lists[key] = texts
    return lists


def _under_heads(nodes: Mapping[str, Any], headings: Mapping[str, list[str]]) -> dict[str, Any]:
    """Vectors and matrices; in place of a matrix whose columns, or rows, have names in a list of texts its vectors."""
    vectors: dict[str, Any] = {}
    for label, node in nodes.items():
        heads: list[str] | None = None
        if node.ndim == 2 and node.dtype.kind in "biuf":
            height, width = node.shape
            heads = heads_of(width, headings)
            if heads is None and width != height:
                heads = heads_of(height, headings)
                node = node if heads is None else node.T
        vectors |= {label: node} if heads is None else dict(zip(heads, node.T, strict=True))
    return vectors


def _zeros_that_check(item: Any, values: np.ndarray[Any, Any]) -> str:
    """What to say of parts of a data set whose checksum tells nothing; empty where each tells.

    The checksum of zeros is zero: a part that was set to zero together with its checksum passes. Compressed zeros have
    another one.
    """
    if not item.fletcher32 or item.compression is not None or not item.size:
        return ""
    parts = 0
    zeros = 0
    for place in item.iter_chunks():
        stored = np.ascontiguousarray(values[place]).view(np.uint8)
        parts += 1
        zeros += not stored.any()
    if zeros == 0:
        return ""
    name = item.name.rpartition("/")[2]
    return f"{name}: {zeros} of {parts} stored parts are zeros alone: no checksum tells if a damage made them so"


def _units_by_another_name(label: str, attributes: Mapping[str, str]) -> Iterator[str]:
    """What to say of a column without a unit: a name of an attribute has no checksum, and one wrong letter hides it."""
    for key, text in attributes.items():
        begins_as_a_unit = text[:1].isalpha() or text[:1] in ("°", "%")  # and not as a number does
        if begins_as_a_unit and len(text) <= _LONGEST_UNIT and is_unit(text):
            yield f"{label}: its attribute {key!r} holds {text!r}, and is not called unit: the column has no unit"


def find(path: str, variable: str | None) -> Table:
    """The child's work. Links and data outside the file are never followed."""
    import h5py

    budget = budget_of(Path(path))
    places: dict[str, _Place] = {}

    def visit(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or item.external or item.is_virtual or item.ndim > 3:
            return
        # By their shape: none of them is read yet.
        budget.take_cells(-(-item.size * item.dtype.itemsize // 8))
        values = stored_values(item)
        attributes = _texts(item.attrs)
        texts = {**_texts(file.attrs), **_texts(item.parent.attrs)}

        group, _, label = name.rpartition("/")
        own = _texts(item.parent.attrs) if group else {}
        if group and label in _UNITS and values.dtype.kind in "OSU":
            own |= _texts({label: values})
        said = next((own[key] for key in _UNITS if key in own), None)
        if values.dtype.names:  # a table: its fields are the columns
            place = places.setdefault(name, _Place({**texts, **attributes}))
            place.nodes.update({column: values[column] for column in values.dtype.names})
        else:
            place = places.setdefault(group or "/", _Place(texts))
            place.unit = place.unit or said
            place.fields |= _fields(item.parent.attrs)
            place.nodes |= _under_heads({label: values}, _lists(item.attrs))
            place.of_vectors[label] = attributes
            place.headings |= (
                _lists(item.parent.attrs) | _lists(item.attrs) | _lists({label: values})
            )
        if doubt := _zeros_that_check(item, values):
            place.notes.append(doubt)
        unit = next((attributes[key] for key in _UNITS if key in attributes), None)
        place.units[label] = unit
        if unit is None:
            place.notes += _units_by_another_name(label, attributes)

    with h5py.File(path, "r") as file:
        # Before anything is opened: thousands of small data sets take long.
        file.visit(lambda _: budget.take_names())
        file.visititems(visit)

    recordings: dict[str, Found] = {}
    for name, place in places.items():
        recordings |= _recordings_of(name, place)
    if variable is None or variable == found_recordings.ALL:
        starts: set[tuple[str | None, ...]] = set()
        for place in places.values():
            for attributes in place.of_vectors.values():
                starts.add(tuple(attributes.get(key) for key in _STARTS))
        if len(starts) == 1:
            recordings = _signals_of_one_group(recordings) or recordings
    if not recordings:
        for place in places.values():
            unnamed = without_names(place.nodes)
            if unnamed is not None:
                raise unnamed
    return found_recordings.chosen(
        recordings, variable, "group", "no group of the file holds vectors of numbers"
    )


def _recordings_of(name: str, place: _Place) -> dict[str, Found]:
    """The recording of a place, by its name; or the trials of an array of three sides."""
    period = sample_period(place.texts)
    trials = trials_in(place.nodes, [*place.headings.values()])
    recordings: dict[str, Found] = {}
    for trial, columns in trials.items():
        recording = of_vectors(columns)
        if recording is None:
            continue
        recording.period = period[0] if period else None
        recording.units = {key: place.units[key] for key in columns if key in place.units}
        recording.metadata = place.texts
        recordings[trial if name == "/" else f"{name}/{trial}"] = recording
    recording = None if trials else of_vectors(_under_heads(place.nodes, place.headings))
    if recording is None:
        return recordings
    # What is said of the only vector is said of its group.
    if period is None and len(place.of_vectors) == 1:
        (attributes,) = place.of_vectors.values()
        period = sample_period(attributes)
    recording.period = period[0] if period else None
    recording.units = place.units
    time = found_recordings.TIME
    signals = [label for label in recording.columns if not time.fullmatch(label)]
    if len(signals) == 1:
        (signal,) = signals
        recording.units[signal] = recording.units.get(signal) or place.unit
    recording.metadata = place.texts
    take_told_units(recording, texts_in({**place.texts, **place.headings, **place.of_vectors}))
    recording.constants |= place.fields
    recording.notes += place.notes
    return {name: recording}


def _signals_of_one_group(recordings: Mapping[str, Found]) -> dict[str, Found]:
    """One recording of groups that stand in one group and hold a vector without a name each: signals of one clock.

    Nothing where their lengths or periods differ, or where one holds more.
    """
    above = {name.rpartition("/")[0] for name in recordings}
    sizes = {
        column.size for recording in recordings.values() for column in recording.columns.values()
    }
    periods = {recording.period for recording in recordings.values()}
    if len(recordings) < 2 or len(above) > 1 or len(sizes) > 1 or len(periods) > 1:
        return {}
    together = Found({}, period=periods.pop())
    for name, recording in recordings.items():
        labels = [*recording.columns]
        if len(labels) != 1 or not found_recordings.NO_NAME.fullmatch(labels[0]):
            return {}
        signal = name.rpartition("/")[2]
        together.columns[signal] = recording.columns[labels[0]]
        together.units[signal] = recording.units.get(labels[0])
        together.notes += [note for note in recording.notes if note not in together.notes]
    together.notes.append(f"{len(recordings)} groups hold a signal each, of the same rows")
    return {above.pop() or "/": together}


READER = LogReader(
    suffixes=(".h5", ".hdf5"),
    claims=lambda head: head[:8] == mat.HDF5,
    **reader_in_child.in_child("hdf5"),
    tells_damage="seen only in numbers of data sets with checksums (fletcher32), not in names and units",
)

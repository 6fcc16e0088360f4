"""What a reader of another package says of itself, and what it gives, is looked at before anything is made of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from numbers import Real
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.table import Table, WordColumn
from erclutch.registry import Plugin
from erclutch.signals.array import Array

#: A reader, which `erclutch.logs.log_reader` brings here: of its type nothing is believed, so it has none.
_Reader = Any
#: See `erclutch.logs.log_reader.Windows`.
_Windows = Callable[[Any, int, int, int, int | None], Iterator[tuple[int, int, Table]]]
_NEEDED = ("claims", "read", "parts")  # functions of a reader
_FURTHER = ("windows", "extent", "recordings", "each", "takes", "joins")  # or None


def looked_at(reader: _Reader, plugin: Plugin) -> _Reader:
    """The reader with functions that look at what each of its functions gives.

    Raises:
        PluginError: a part of the reader is of a wrong type.
    """
    suffixes: Any = reader.suffixes
    if not isinstance(suffixes, tuple | list) or not _texts(cast("Sequence[Any]", suffixes)):
        raise plugin.fault(
            f"has the suffixes {reader.suffixes!r:.60}; they must be a tuple of texts"
        )
    for name in ("tells_damage", "folder"):
        if not isinstance(getattr(reader, name), str):
            raise plugin.fault(
                f"has {getattr(reader, name)!r:.60} as its {name}, it must be a text"
            )
    if "/" in reader.folder or "\0" in reader.folder or reader.folder in (".", ".."):
        raise plugin.fault(f"has the folder {reader.folder!r:.60}, it must be the name of a file")
    for name in (*_NEEDED, *_FURTHER):
        function = getattr(reader, name)
        if not callable(function) and (function is not None or name in _NEEDED):
            raise plugin.fault(f"has {function!r:.60} as its {name}, it must be a function")

    def looking(at: Callable[[Any, Plugin], Any], function: Callable[[Any], Any] | None) -> Any:
        if function is None:
            return None

        def look(given: Any) -> Any:
            return at(function(given), plugin)

        return look

    return replace(
        reader,
        read=looking(sound_table, reader.read),
        recordings=looking(sound_names, reader.recordings),
        each=looking(sound_tables, reader.each),
        windows=reader.windows and sound_windows(reader.windows, plugin),
        extent=looking(sound_extent, reader.extent),
    )


def sound_table(given: Any, plugin: Plugin) -> Table:
    """The table that a reader gave, its columns as float64, with a unit or None for each.

    Raises:
        PluginError: it is no table, or a part of it does not fit the others.
    """
    if not isinstance(given, Table):
        returned = f"returns a {type(given).__name__}"
        raise plugin.fault(f"{returned}, it must be a Table of erclutch.logs.table")
    for name in ("name", "digest", "clock_name", "damage", "path"):
        if not isinstance(getattr(given, name), str):
            raise plugin.fault(f"returns a table whose {name} is no text")
    for name in ("notes", "hollow", "row_names", "made"):
        if not isinstance(getattr(given, name), tuple | list) or not _texts(getattr(given, name)):
            raise plugin.fault(f"returns a table whose {name} are no tuple of texts")
    for name in ("columns", "units", "numbers", "constants", "metadata", "unreadable", "words"):
        part = getattr(given, name)
        if not isinstance(part, Mapping) or not _texts(list(cast("Mapping[Any, Any]", part))):
            raise plugin.fault(f"returns a table whose {name} are no mapping from texts")

    columns: dict[str, Array] = {}
    for name, values in given.columns.items():
        if np.iscomplexobj(values):
            raise plugin.fault(f"returns a column {name!r:.60} of complex numbers")
        columns[name] = np.asarray(values, np.float64)
    shapes = {values.shape for values in columns.values()}
    if len(shapes) > 1 or any(len(shape) != 1 for shape in shapes):
        listed = ", ".join(f"{name} {values.shape}" for name, values in columns.items())
        raise plugin.fault(f"returns columns that are no vectors of one length: {listed}")
    table = replace(given, columns=columns)

    _require_parts(table, plugin)
    return replace(table, units={name: table.units.get(name) for name in columns})


def _require_parts(table: Table, plugin: Plugin) -> None:
    """Refuse what does not fit the columns, or is not what `Table` says."""
    rows = table.rows
    for name, kinds in (("clock", "fiu"), ("unsampled", "b"), ("sweeps", "iu")):
        beside = getattr(table, name)
        if beside is None:
            continue
        is_vector = isinstance(beside, np.ndarray) and np.shape(cast("Any", beside)) == (rows,)
        if not is_vector or np.asarray(cast("Any", beside)).dtype.kind not in kinds:
            raise plugin.fault(f"returns a table whose {name} has not one number for {rows} rows")
    period: Any = table.sample_period
    breaks: Any = table.breaks
    first: Any = table.first_row
    words: Any = table.words
    units: Any = table.units
    right = {
        "units": all(unit is None or isinstance(unit, str) for unit in units.values()),
        "numbers": all(_is_number(place) and place >= 1 for place in table.numbers.values()),
        "sample_period": period is None or (_is_number(period) and period > 0.0),
        "constants": all(map(_is_number, table.constants.values())),
        "metadata": _texts(list(table.metadata.values())),
        "unreadable": _texts(list(table.unreadable.values())),
        "first_row": isinstance(first, int) and first >= 0,
        "row_names": len(table.row_names) in (0, rows),
        "breaks": isinstance(breaks, tuple | list)
        and all(
            isinstance(place, int) and 0 <= place <= rows for place in cast("Sequence[Any]", breaks)
        ),
        "words": all(
            isinstance(column, WordColumn)
            and _texts(column.words)
            and np.shape(column.of_row) == (rows,)
            for column in words.values()
        ),
    }
    for name, fits in right.items():
        if not fits:
            raise plugin.fault(
                f"returns a table with {name} = {getattr(table, name)!r:.60}; see Table for what fits"
            )


def sound_windows(windows: _Windows, plugin: Plugin) -> _Windows:
    """The same windows, each looked at: its table, and that it begins where the window before ended."""

    def checked(
        source: Any, rows: int, margin: int, first: int, last: int | None
    ) -> Iterator[tuple[int, int, Table]]:
        reached = first
        with plugin.working():
            each = iter(windows(source, rows, margin, first, last))
        while True:
            with plugin.working():
                given: Any = next(each, None)
            if given is None:
                return
            if not isinstance(given, tuple) or len(cast("tuple[Any, ...]", given)) != 3:
                raise plugin.fault(f"yields {given!r:.60} as a window: start, stop and table")
            start, stop, table = cast("tuple[Any, Any, Any]", given)
            if start != reached or not isinstance(stop, int) or not stop > start:
                raise plugin.fault(
                    f"yields a window from row {start!r} to {stop!r} behind {reached}"
                )
            whole = sound_table(table, plugin)
            if not whole.first_row <= start < stop <= whole.first_row + whole.rows:
                held = f"rows {whole.first_row} to {whole.first_row + whole.rows}"
                raise plugin.fault(f"yields a table of {held} for a window of {start} to {stop}")
            reached = stop
            yield start, stop, whole

    return checked


def sound_extent(given: Any, plugin: Plugin) -> tuple[int, int]:
    """Rows and columns that a reader counted.

    Raises:
        PluginError: they are no such counts.
    """
    counts = cast("Sequence[Any]", given if isinstance(given, tuple | list) else ())
    if len(counts) != 2 or not all(isinstance(count, int) and count >= 0 for count in counts):
        raise plugin.fault(f"says {given!r:.60} for the rows and columns of a file")
    return counts[0], counts[1]


def sound_names(given: Any, plugin: Plugin) -> list[str]:
    """Names of recordings that a reader found.

    Raises:
        PluginError: they are no texts, each once.
    """
    names = cast("Sequence[Any]", given if isinstance(given, tuple | list) else (None,))
    if not _texts(names) or len(set(names)) < len(names):
        raise plugin.fault(f"says {given!r:.60} for the names of recordings: texts, each once")
    return list(names)


def sound_tables(given: Any, plugin: Plugin) -> Mapping[str, Table | LogError]:
    """The tables of all recordings that a reader read at once.

    Raises:
        PluginError: an entry is neither a table nor what stands against one.
    """
    if not isinstance(given, Mapping):
        raise plugin.fault(f"returns a {type(given).__name__} for tables by name")
    tables: dict[str, Table | LogError] = {}
    for name, table in cast("Mapping[str, Any]", given).items():
        tables[name] = table if isinstance(table, LogError) else sound_table(table, plugin)
    return tables


def _texts(values: Sequence[Any]) -> bool:
    return all(isinstance(value, str) for value in values)


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and isfinite(value)

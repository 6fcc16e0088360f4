"""Reads a pandas DataFrame as it reads a file: columns by name, units in the names, the time in its index."""

from __future__ import annotations

import hashlib
import sys
from operator import itemgetter
from typing import Any

import numpy as np

from erclutch.errors import LogError, printable
from erclutch.logs.columns.labels import name_columns, split_label
from erclutch.logs.columns.word_columns import only_words, parting_columns, parting_note
from erclutch.logs.log_reader import LogReader, LogSource, claims_nothing
from erclutch.logs.readers.numbers_in_texts import numbers_in_texts
from erclutch.logs.table import Table
from erclutch.signals.array import Array


def is_frame(log: object) -> bool:
    """Whether a log in memory is a DataFrame. Without pandas there is none."""
    pandas = sys.modules.get("pandas")
    return pandas is not None and isinstance(log, pandas.DataFrame)


def read_frame(source: LogSource) -> Table:
    """The columns of numbers of a DataFrame, with units out of names such as ``V [cm/s]``.

    Times come from an index or a column of dates or durations, as seconds since its first row; a named index of
    numbers is one more column. Columns without numbers are left out, with a note.

    Raises:
        LogError: names in several levels, or no rows of numbers.
    """
    import pandas

    frame: Any = source.memory
    if frame.columns.nlevels > 1 or frame.index.nlevels > 1:
        problem = "its columns or its index have several levels"
        raise LogError(problem, remedy="Give one level, such as by frame.droplevel(0, axis=1)")

    series: list[tuple[str, Any]] = []  # by place, since two columns may have one label
    for place, label in enumerate(frame.columns):
        series.append((str(label), frame.iloc[:, place]))
    index = frame.index.to_series()
    if frame.index.name is not None and not _is_time(index):
        series.insert(0, (str(frame.index.name), index))
    timed = [(str(frame.index.name or "index"), index)] if _is_time(index) else []
    timed += [(label, values) for label, values in series if _is_time(values)]

    clock: Array | None = None
    clock_name = ""
    if timed:  # dates or durations in s since the first; NaN where there is none
        clock_name, stamps = timed[0]
        real = stamps.dropna()
        since_first = stamps - (real.iloc[0] if len(real) else stamps)
        clock = np.asarray(since_first.dt.total_seconds(), np.float64)

    of_numbers: list[tuple[int, str, Array]] = []  # place, label and numbers
    place_of: dict[str, int] = {}  # of those without numbers
    texts: dict[str, Any] = {}
    renamed: list[str] = []
    for place, (label, values) in enumerate(series):
        if timed and values is timed[0][1]:
            continue
        numbers = None if _is_time(values) else _numbers(values, pandas)
        if numbers is not None:
            of_numbers.append((place, label, numbers))
            continue
        own = printable(label)
        before = sum(each == label for each, _ in series[:place])
        if before:  # each of two columns of one name has its own cells
            name, unit = split_label(own)
            number = before + 1
            own = f"{name} ({number}) [{unit}]" if unit else f"{name} ({number})"
            renamed.append(
                f"column {place + 1} has the name {name!r} of an earlier one: renamed '{name} ({number})'"
            )
        place_of[own] = place
        if pandas.api.types.is_string_dtype(values):
            texts[own] = values.reset_index(drop=True)
    in_texts = numbers_in_texts(texts, source.decimal)
    of_numbers += [(place_of[label], label, values) for label, values in in_texts.columns.items()]
    of_numbers.sort(key=itemgetter(0))
    left = [label for label in place_of if label not in in_texts.columns]
    texts_left = {label: cells for label, cells in texts.items() if label in left}
    if not of_numbers or not len(frame):
        remedy = "Give a DataFrame with one row a sample"
        raise LogError("it has no rows of numbers", remedy=remedy)

    labels = [label for _, label, _ in of_numbers]
    columns_of_numbers = [values for _, _, values in of_numbers]
    names, units, notes = name_columns(labels)
    of_cells = dict(zip(labels, names, strict=True))
    units_of = dict(zip(names, units, strict=True))
    units_of |= {of_cells[label]: unit for label, unit in in_texts.units.items()}
    words = parting_columns(texts_left)
    only = only_words(texts_left)
    notes += renamed + in_texts.notes
    notes += [parting_note(label, parting) for label, parting in words.items()]
    if others := [label for label in left if label not in words]:
        notes.append(f"columns without numbers left out: {', '.join(others)}")
    unreadable = {label: f"column {label} holds no real numbers" for label in left}
    unreadable |= in_texts.unreadable
    digest = hashlib.sha256(repr(names).encode())
    for values in [*columns_of_numbers, *([] if clock is None else [clock])]:
        digest.update(values.tobytes())
    return Table(
        source.name,
        dict(zip(names, columns_of_numbers, strict=True)),
        units_of,
        digest.hexdigest(),
        clock=clock,
        clock_name=clock_name,
        metadata=only,
        unreadable=unreadable,
        notes=tuple(notes),
        words=words,
    )


def _is_time(values: Any) -> bool:
    return getattr(values.dtype, "kind", "") in "mM"


def _numbers(values: Any, pandas: Any) -> Array | None:
    """A column as numbers, NaN where it has none; None for a column of anything else."""
    if getattr(values.dtype, "kind", "") == "c":
        return None
    try:
        converted = pandas.to_numeric(values.astype(object), errors="raise")
        numbers = converted.to_numpy(dtype=np.float64, na_value=np.nan)
    except (TypeError, ValueError, OverflowError, ArithmeticError):
        return None
    return np.ascontiguousarray(numbers) if np.isfinite(numbers).any() else None


READER = LogReader(
    suffixes=(),  # it is no file
    claims=claims_nothing,
    read=read_frame,
    takes=is_frame,
    tells_damage="not seen: what is in memory has no checksums",
)

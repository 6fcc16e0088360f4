"""A pandas DataFrame becomes a Table, as a file does: columns by name, units in the names, the time in its index."""

from __future__ import annotations

import hashlib
import sys
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.errors import LogError, printable
from erclutch.logs.labels import name_columns
from erclutch.logs.table import Table
from erclutch.signals.array import Array

if TYPE_CHECKING:
    from pandas import DataFrame

_NAME = "DataFrame"


def table_of_frame(frame: DataFrame) -> Table:
    """The columns of numbers of a DataFrame, with units out of names such as ``V [cm/s]``.

    Times come from an index or a column of dates or durations, as seconds since its first row; a named index of
    numbers is one more column. Columns without numbers are left out, with a note.

    Raises:
        LogError: no DataFrame, names in several levels, or no rows of numbers.
    """
    pandas = sys.modules.get("pandas")
    if pandas is None or not isinstance(frame, pandas.DataFrame):
        problem = f"a log cannot be a {type(frame).__name__}"
        raise LogError(problem, remedy="Give the path of a file, or a pandas DataFrame")
    if frame.columns.nlevels > 1 or frame.index.nlevels > 1:
        problem = "its columns or its index have several levels"
        raise LogError(problem, where=_NAME, remedy="Give one level, such as by frame.droplevel(0, axis=1)")
    series: list[tuple[str, Any]] = [(str(label), frame.iloc[:, i]) for i, label in enumerate(frame.columns)]
    if frame.index.name is not None and not _is_time(frame.index.dtype):
        series.insert(0, (str(frame.index.name), frame.index.to_series()))
    timed = [(str(frame.index.name or "index"), frame.index.to_series())] if _is_time(frame.index.dtype) else []
    timed += [(label, values) for label, values in series if _is_time(values.dtype)]
    taken, left = list[tuple[str, Array]](), list[str]()
    for label, values in series:
        if timed and values is timed[0][1]:
            continue
        numbers = None if _is_time(values.dtype) else _numbers(values, pandas)
        if numbers is None:
            left.append(printable(label))
        else:
            taken.append((label, numbers))
    names, units, notes = name_columns([label for label, _ in taken])
    columns = {name: values for name, (_, values) in zip(names, taken, strict=True)}
    if not columns or not len(frame):
        raise LogError("it has no rows of numbers", where=_NAME, remedy="Give a DataFrame with one row a sample")
    if left:
        notes.append(f"columns without numbers left out: {', '.join(left)}")
    digest = hashlib.sha256(repr(names).encode())
    for values in columns.values():
        digest.update(values.tobytes())
    clock = _seconds(timed[0][1]) if timed else None
    if clock is not None:
        digest.update(clock.tobytes())
    name = timed[0][0] if timed else ""
    return Table(
        _NAME,
        columns,
        dict(zip(names, units, strict=True)),
        digest.hexdigest(),
        clock=clock,
        clock_name=name,
        notes=tuple(notes),
    )


def _is_time(dtype: Any) -> bool:
    return getattr(dtype, "kind", "") in "mM"


def _seconds(stamps: Any) -> Array:
    """Dates or durations as seconds since the first; NaN where there is none."""
    real = stamps.dropna()
    since = stamps - real.iloc[0] if len(real) else stamps - stamps
    return np.asarray(since.dt.total_seconds(), np.float64)


def _numbers(values: Any, pandas: Any) -> Array | None:
    """A column as numbers, NaN where it has none; None for a column of anything else."""
    if getattr(values.dtype, "kind", "") == "c":
        return None
    try:
        found = pandas.to_numeric(values.astype(object), errors="raise")
        numbers = found.to_numpy(dtype=np.float64, na_value=np.nan)
    except (TypeError, ValueError, OverflowError, ArithmeticError):
        return None
    return np.ascontiguousarray(numbers) if np.isfinite(numbers).any() else None

"""Columns of Arrow, as Parquet and Feather logs hold them, become a Table: numbers, dates, switches, telling words."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.columns.labels import name_columns
from erclutch.logs.columns.word_columns import only_words, parting_columns, parting_note
from erclutch.logs.log_reader import ROWS_WANTED
from erclutch.logs.readers.arrow_lists import with_lists_opened
from erclutch.logs.readers.numbers_in_texts import numbers_in_texts
from erclutch.logs.readers.switches import switched
from erclutch.logs.readers.told_units import texts_in, with_told_units
from erclutch.logs.table import Table, of_arrow
from erclutch.signals.array import Array

_UNCHECKED = "the file has no checksums: damaged numbers in it cannot be told from good ones"


def table_of_arrow(
    table: Any,
    name: str,
    digest: str,
    unchecked: bool,
    origin: int | None = None,
    decimal: str | None = None,
) -> Table:
    """The columns of numbers and the first of dates, what else there is in notes.

    Args:
        table: of the library.
        name: of the file.
        digest: of the file.
        unchecked: whether a column that was read has no checksums.
        origin: tick from which dates count; None: the first row.
        decimal: the decimal mark of numbers that are texts, where the user named it.
    """
    import pyarrow
    from pyarrow import types

    table = with_lists_opened(table)
    fields = list(table.schema)
    of_all = _units_of(_metadata(table.schema))
    own_units = [_metadata(field).get("unit") or of_all.get(field.name) for field in fields]
    names, units, renamed = name_columns([str(field.name) for field in fields], own_units)
    notes = [_UNCHECKED] if unchecked else []
    notes += renamed
    columns: dict[str, Array] = {}
    units_of: dict[str, str | None] = {}
    unit_of = dict(zip(names, units, strict=True))
    texts: dict[str, Any] = {}
    clock_name = ""
    clock: Array | None = None
    for label, unit, field, values in zip(names, units, fields, table.columns, strict=True):
        numbers = _numbers(values)
        words_in_row = values if types.is_dictionary(values.type) else None
        if is_text(values.type):
            words_in_row = values.dictionary_encode()
        if words_in_row is not None and is_text(words_in_row.type.value_type):
            cells = words_in_row.to_pandas()  # each word once
            texts[label] = cells
            ones_and_zeros = switched(label, cells)
            if ones_and_zeros is not None:
                numbers, note = ones_and_zeros
                notes.append(note)
        if numbers is not None:
            columns[label] = numbers
            units_of[label] = unit
            continue
        is_whole = len(values) and not values.null_count
        if clock is None and _tells_time(values.type) and is_whole:
            ticks = of_arrow(values.cast(pyarrow.int64()))
            per_second = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}[values.type.unit]
            since = ticks - (ticks[0] if origin is None else origin)
            clock_name = label
            clock = since.astype(np.float64) / per_second
        elif label not in texts:
            notes.append(f"column {label} holds {field.type}: left out")
    texts_left = {label: cells for label, cells in texts.items() if label not in columns}
    unreadable = {label: f"column {label} holds text" for label in texts_left}
    if origin is None:  # the cells of one window cannot tell how those of another are written
        in_texts = numbers_in_texts(texts_left, decimal)
        columns |= in_texts.columns
        columns = {label: columns[label] for label in names if label in columns}
        units_of |= {
            label: in_texts.units.get(label) or unit_of.get(label) for label in in_texts.columns
        }
        notes += in_texts.notes
        unreadable = in_texts.unreadable
        texts_left = {label: cells for label, cells in texts_left.items() if label not in columns}
    words = parting_columns(texts_left)
    only = only_words(texts_left)
    for label in texts:
        if label in columns:
            continue
        parts_the_rows = label in words
        left_out = f"column {label} holds text: left out"
        notes.append(parting_note(label, words[label]) if parts_the_rows else left_out)
    if not columns:
        raise LogError("the file has no column of numbers", remedy=ROWS_WANTED)

    metadata = _metadata(table.schema)
    for key in ("pandas", "ARROW:schema"):  # what libraries say of their own types
        metadata.pop(key, None)
    read = Table(
        name=name,
        columns=columns,
        units=units_of,
        digest=digest,
        clock=clock,
        clock_name=clock_name,
        metadata={**only, **metadata},
        unreadable=unreadable,
        notes=tuple(notes),
        words=words,
    )
    of_fields = {label: _metadata(field) for label, field in zip(names, fields, strict=True)}
    return with_told_units(read, texts_in({**metadata, **of_fields}))


def is_text(kind: Any) -> bool:
    """Whether a column of this type holds texts."""
    from pyarrow import types

    return bool(types.is_string(kind) or types.is_large_string(kind))


def _metadata(thing: Any) -> dict[str, str]:
    """Metadata of a field or a schema as texts."""
    pairs: dict[bytes, bytes] = thing.metadata or {}
    texts: dict[str, str] = {}
    for key, value in pairs.items():
        texts[key.decode("utf-8", "replace")] = value.decode("utf-8", "replace")
    return texts


def _units_of(metadata: Mapping[str, str]) -> dict[str, str]:
    """Units by the names of columns, which a whole file states as an object of JSON, or as attributes of pandas."""
    stated: dict[str, Any] = {}
    for key in ("pandas", "units", "unit"):
        try:
            said: Any = json.loads(metadata.get(key, "{}"))
        except (ValueError, RecursionError):
            continue
        if key == "pandas" and isinstance(said, dict):
            attributes: Any = cast("dict[str, Any]", said).get("attributes")
            said = (
                cast("dict[str, Any]", attributes).get("units")
                if isinstance(attributes, dict)
                else None
            )
        if isinstance(said, dict):
            stated |= cast("dict[str, Any]", said)
    return {name: unit for name, unit in stated.items() if isinstance(unit, str) and unit}


def _numbers(values: Any) -> Array | None:
    """A column as float64 (missing becomes NaN), or None if it holds no numbers."""
    import pyarrow
    from pyarrow import types

    kind = values.type
    numeric = (types.is_floating, types.is_integer, types.is_boolean, types.is_decimal)
    if not any(is_kind(kind) for is_kind in numeric):
        return None
    if types.is_boolean(kind):
        values = values.cast(pyarrow.uint8())
    values = values.cast(pyarrow.float64(), safe=False)
    if not values.null_count:
        return of_arrow(values)
    # Not fill_null, whose number imports pandas: half a second for each child.
    missing = of_arrow(values.is_null().cast(pyarrow.uint8()))
    whole = values.combine_chunks()
    numbers = np.zeros(len(whole))
    held = whole.buffers()[1]
    if held is not None:
        numbers = np.frombuffer(held, np.float64, len(whole), 8 * whole.offset)
    return np.where(missing == 1, np.nan, numbers)


def _tells_time(kind: Any) -> bool:
    from pyarrow import types

    return bool(types.is_timestamp(kind) or types.is_duration(kind))


def first_tick(table: Any) -> int | None:
    """The first row of the first date-time or duration column; None without one, or where it is missing."""
    import pyarrow

    column = next((values for values in table.columns if _tells_time(values.type)), None)
    if column is None or not len(column):
        return None
    return column.cast(pyarrow.int64())[0].as_py()

"""JSON logs: an object a line (JSON Lines), a list of objects, or lists of numbers under names, nested or not.

An object is a row: ``{"t [s]": 0.001, "field [A]": 0.5, "slip [rad/s]": 3.2, "effort [N m]": 0.11}``. A unit stands in
brackets behind the name; what is nested gets a name such as ``motor.speed``. A file with several lists of rows holds
several recordings.
"""

from __future__ import annotations

import json
import re
import shlex
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError, printable
from erclutch.logs.labels import name_columns
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import dates, json_layout
from erclutch.logs.readers.budget import Budget
from erclutch.logs.readers.found_recordings import JOINT, Found, choose, joined_by_time, names_by
from erclutch.logs.readers.json_layout import flat
from erclutch.logs.readers.text_bytes import DAMAGE
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_BEGINS = re.compile(rb'\s*(?:\{\s*"|\[\s*\{)')
_LARGEST = 10**300
_MOST = 500  # numbers in a list of a row
_NONE = "the file holds no rows of numbers"

#: A row: where it stands, and its values by their names.
_Row = tuple[str, Mapping[str, Any]]


def _claims(head: bytes) -> bool:
    return _BEGINS.match(head) is not None


def _read(source: LogSource) -> Table:
    """The recording of the file that is wanted; see the module."""
    try:
        content = source.data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise LogError(f"the file is no UTF-8 text ({error})", remedy="Save it as UTF-8", where=source.name) from error
    lines = [(number, line) for number, line in enumerate(content.splitlines(), start=1) if line.strip()]
    whole = _document(content)
    if whole is None or (len(lines) == 1 and _is_row(whole)):
        rows = [(f"line {number}", _object(line, f"{source.name}, line {number}")) for number, line in lines]
        return _table_of_rows(source, rows, ())
    recordings = dict(json_layout.recordings(whole))
    lists = {name: each for name, each in recordings.items() if isinstance(each, dict)}
    names = [each.strip() for each in (source.variable or "").split(JOINT)]
    if len(names) > 1 and source.variable not in recordings and all(each in lists for each in names):
        tables = {each: _table_of_lists(source, lists[each], ()) for each in names}
        parts = {each: Found({**table.columns}, {**table.units}) for each, table in tables.items()}
        return replace(joined_by_time(parts, "list").table(), name=source.name, digest=source.digest)
    more = f", or join them by time: --variable {shlex.quote(JOINT.join(lists))}" if len(lists) > 1 else ""
    name, found = choose(recordings, source.variable, "list", _NONE, more)
    notes = (f"recording read from {name}",) if name else ()
    if isinstance(found, list):
        rows = [(f"row {number} of {name or 'the list'}", row) for number, row in enumerate(found, start=1)]
        return _table_of_rows(source, rows, notes)
    return _table_of_lists(source, found, notes)


def _document(content: str) -> Any:
    """The file as one value of JSON; None where it is none, as a file with an object a line."""
    try:
        return json.loads(content)
    except (ValueError, RecursionError):
        return None


def _is_row(value: Any) -> bool:
    """Whether a value is one row: an object without lists in it."""
    members = flat(cast("dict[str, Any]", value), "", 0) if isinstance(value, dict) else ()
    return isinstance(value, dict) and not any(isinstance(each, list) for _, each in members)


def _object(line: str, where: str) -> Mapping[str, Any]:
    try:
        row: Any = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise LogError(f"the line is no JSON ({error})", remedy="Mend or delete the line", where=where) from error
    if not isinstance(row, dict):
        raise LogError("the line is no JSON object", remedy='Write rows such as {"t [s]": 0.1}', where=where)
    return cast("dict[str, Any]", row)


def _table_of_rows(source: LogSource, rows: Iterable[_Row], notes: tuple[str, ...]) -> Table:
    """The values of all rows by their names; what a row lacks is missing."""
    budget = Budget(len(source.data))
    cells: dict[str, dict[int, Any]] = {}
    places: list[str] = []
    for row, (place, members) in enumerate(rows):
        places.append(place)
        names = len(cells)
        for name, value in flat(members, "", 0):
            if isinstance(value, list):
                each = cast("list[Any]", value)
                if len(each) > _MOST:
                    problem = f"{name} holds {len(each)} numbers in one row, {_MOST} are the most"
                    raise LogError(problem, remedy="Log one row a sample", where=f"{source.name}, {place}")
                for index, part in enumerate(each, start=1):
                    cells.setdefault(f"{name}_{index}", {})[row] = part
            else:
                cells.setdefault(name, {})[row] = value
        budget.take_names(len(cells) - names)
    budget.take_cells(len(places) * len(cells))  # a name that one row has is a column of all rows
    columns = {name: [held.get(row) for row in range(len(places))] for name, held in cells.items()}
    short = [row for row in range(len(places)) if any(row not in held for held in cells.values())]
    if short:
        lack = f"{len(short)} of {len(places)} rows lack a name, such as row {short[0] + 1}: read as missing"
        notes = (*notes, lack)
    return _table(source, columns, places, notes)


def _table_of_lists(source: LogSource, lists: Mapping[str, list[Any]], notes: tuple[str, ...]) -> Table:
    """Lists of the length that most have as columns; lists of other lengths are left out, with a note."""
    lengths = Counter(map(len, lists.values()))
    most = max(lengths, key=lambda length: (length > 1, lengths[length], length))
    others = {
        name: f"list {name} has {len(values)} values, not {most}"
        for name, values in lists.items()
        if len(values) != most
    }
    columns = {name: values for name, values in lists.items() if len(values) == most}
    places = [f"value {place}" for place in range(1, most + 1)]
    table = _table(source, columns, places, (*notes, *(f"{other}: left out" for other in others.values())))
    # Who needs such a list is told; a single value or none beside long lists is a setting.
    signals = {name.rpartition(".")[2]: why for name, why in others.items() if len(lists[name]) > most // 2}
    return replace(table, unreadable={**table.unreadable, **signals})


def _table(source: LogSource, columns: Mapping[str, list[Any]], places: list[str], notes: tuple[str, ...]) -> Table:
    """Columns of numbers; columns of dates become the clock, columns of other texts are left out with a note."""
    import pandas as pd

    numbers: dict[str, Array] = {}
    texts: dict[str, Any] = {}
    unreadable: dict[str, str] = {}
    for (label, values), name in zip(columns.items(), _short_names(list(columns)), strict=True):
        switches = all(value is None or isinstance(value, bool) for value in values)
        kind = bool if switches else int | float
        wrong = [
            row
            for row, value in enumerate(values)
            if value is not None and (not isinstance(value, kind) or isinstance(value, bool) != switches)
        ]
        if wrong:
            shown = f"{values[wrong[0]]!r:.40}"
            unreadable[printable(name)] = f"{places[wrong[0]]}, {label} is {shown} where a number is expected"
            if all(isinstance(value, str) for value in values):
                texts[printable(name)] = pd.Series(values)
            continue
        try:
            numbers[name] = np.array([np.nan if value is None else float(value) for value in values])
        except OverflowError as error:  # an integer of hundreds of digits
            row = next(row for row, value in enumerate(values) if abs(value or 0) > _LARGEST)
            where = f"{source.name}, {places[row]}"
            raise LogError(f"{label} is too large", remedy="Mend or delete the row", where=where) from error
    clock_name, clock = dates.clock_of(texts)
    for name in (clock_name, *clock_name.split(" and ")):
        unreadable.pop(name, None)
    if not numbers and unreadable:
        name, problem = next(iter(unreadable.items()))
        raise LogError(problem, remedy="Log numbers only", where=source.name)
    names, units, renamed = name_columns(list(numbers), [None] * len(numbers))
    left = [f"column {name} holds no numbers ({problem}): left out" for name, problem in unreadable.items()]
    return Table(
        source.name,
        dict(zip(names, numbers.values(), strict=True)),
        dict(zip(names, units, strict=True)),
        source.digest,
        clock=clock,
        clock_name=clock_name,
        notes=(*notes, *left, *renamed),
        unreadable=unreadable,
    )


def _short_names(labels: list[str]) -> list[str]:
    """The last word of each name such as ``motor.speed`` where no other name ends so, else the whole name."""
    ends = [label.rpartition(".")[2] if not re.search(r"[\[(].*\.", label) else label for label in labels]
    return [end if end and ends.count(end) == 1 else label for label, end in zip(labels, ends, strict=True)]


READER = LogReader((".jsonl", ".ndjson", ".json"), _claims, _read, recordings=names_by(_read), tells_damage=DAMAGE)

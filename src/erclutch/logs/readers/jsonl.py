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
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any, cast

import numpy as np

from erclutch.errors import LogError, printable
from erclutch.files.given_files import NameTwiceError, with_different_names
from erclutch.logs.columns.labels import name_columns
from erclutch.logs.columns.word_columns import (
    names_of_rows,
    only_words,
    parting_columns,
    parting_note,
)
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import dates, json_layout
from erclutch.logs.readers.budget import Budget
from erclutch.logs.readers.found_recordings import JOINT, Found, choose, joined_by_time, names_by
from erclutch.logs.readers.json_layout import flat, rows_under_numbers
from erclutch.logs.readers.numbers_in_texts import numbers_in_texts
from erclutch.logs.readers.text_bytes import DAMAGE
from erclutch.logs.readers.told_units import texts_in, with_told_units
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_BEGINS = re.compile(rb"\s*(?:\{\s*[\"']|\[\s*\{)")
#: Words of Python in place of a value, and what JSON has for them.
_PYTHON_WORD = re.compile(r"(?<=[:,\[ ])(None|True|False|nan|-?inf)(?=\s*[,}\]])")
_IN_JSON = {
    **{"None": "null", "True": "true", "False": "false"},
    **{"nan": "NaN", "inf": "Infinity", "-inf": "-Infinity"},
}
_LARGEST = 10**300
_FEWEST_BELOW_A_HEAD = 3  # lines of a file, the head included
_NONE = "the file holds no rows of numbers"
_NAMES = "Give each signal a name of its own"

#: A row: where it stands, and its values by their names.
_Row = tuple[str, Mapping[str, Any]]


def _read(source: LogSource) -> Table:
    """The recording of the file that is wanted; see the module."""
    try:
        content = source.data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        problem = f"the file is no UTF-8 text ({error})"
        raise LogError(problem, remedy="Save it as UTF-8", where=source.name) from error

    if "'" in content and '"' not in content:  # dictionaries as Python prints them
        content = content.replace("'", '"')
        content = _PYTHON_WORD.sub(lambda word: _IN_JSON[word[1]], content)
    lines: dict[str, str] = {}  # by their place
    for number, line in enumerate(content.splitlines(), start=1):
        if line.strip():
            lines[f"line {number}"] = line
    try:
        document: Any = json.loads(content, object_pairs_hook=with_different_names)
    except NameTwiceError as error:
        raise LogError(
            f"two values of one name: {error}", remedy=_NAMES, where=source.name
        ) from error
    except (ValueError, RecursionError):
        document = None  # a file with an object a line is no single value
    fields = cast("dict[str, Any]", document) if isinstance(document, dict) else {}
    has_lists = any(isinstance(each, list) for _, each in flat(fields, "", 0))
    is_row = bool(fields) and not has_lists and rows_under_numbers(fields) is None
    if document is None or (len(lines) == 1 and is_row):
        rows = [(place, _row_in(line, f"{source.name}, {place}")) for place, line in lines.items()]
        head, rows = _head_and_rows(rows)
        table = _table_of_rows(source, rows, ())
        table = replace(table, constants={**_numbers_beside(head, "", ()), **table.constants})
        return with_told_units(table, texts_in(head))

    recordings = dict(json_layout.recordings(document))
    lists: dict[str, json_layout.Lists] = {}
    for name, recording in recordings.items():
        if isinstance(recording, dict):
            lists[name] = recording
    asked = [name.strip() for name in (source.variable or "").split(JOINT)]
    is_joint = len(asked) > 1 and source.variable not in recordings
    if is_joint and all(name in lists for name in asked):
        parts: dict[str, Found] = {}
        for name in asked:
            table = _table_of_lists(source, lists[name], ())
            parts[name] = Found({**table.columns}, {**table.units})
        joined = joined_by_time(parts, "list").table()
        return replace(joined, name=source.name, digest=source.digest)

    more = ""
    if len(lists) > 1:
        more = f", or join them by time: --variable {shlex.quote(JOINT.join(lists))}"
    name, recording = choose(recordings, source.variable, "list", _NONE, more)
    notes = (f"recording read from {name}",) if name else ()
    beside = _numbers_beside(document, name, [*recordings.keys() - {name}])
    if isinstance(recording, dict):
        table = _table_of_lists(source, recording, notes)
        shared = json_layout.shared_numbers(document)
        table = replace(table, constants={**shared, **beside, **table.constants})
        return with_told_units(table, texts_in(document))
    of_list: list[_Row] = []
    for number, row in enumerate(recording, start=1):
        of_list.append((f"row {number} of {name or 'the list'}", row))
    table = _table_of_rows(source, of_list, notes)
    table = replace(table, constants={**beside, **table.constants})
    return with_told_units(table, texts_in(document))


def _head_and_rows(rows: list[_Row]) -> tuple[Mapping[str, Any], list[_Row]]:
    """What the first line says of the others, such as ``{"v": "mm/s", "F": "kN"}``, and the others; else no head.

    A head has texts where the next row has numbers, or shares no name with the next two rows.
    """
    if len(rows) < _FEWEST_BELOW_A_HEAD:
        return {}, rows
    head, *others = (dict(json_layout.cells_of(members)) for _, members in rows[:3])
    numbers: list[set[str]] = []  # names of the numbers of each row
    for row in others:
        of_row = {name for name, value in row.items() if isinstance(value, int | float)}
        numbers.append({name for name in of_row if not isinstance(row[name], bool)})
    named = [name for name in head if name in numbers[0]]
    says_units = bool(named) and all(isinstance(head[name], str) for name in head)
    says_other_things = bool(numbers[0] & numbers[1]) and not head.keys() & others[0].keys()
    return (rows[0][1], rows[1:]) if says_units or says_other_things else ({}, rows)


def _row_in(line: str, where: str) -> Mapping[str, Any]:
    """The object that a line is."""
    try:
        row: Any = json.loads(line, object_pairs_hook=with_different_names)
    except (ValueError, RecursionError) as error:
        is_twice = isinstance(error, NameTwiceError)
        problem = (
            f"two values of one name: {error}" if is_twice else f"the line is no JSON ({error})"
        )
        remedy = _NAMES if is_twice else "Mend or delete the line"
        raise LogError(problem, remedy=remedy, where=where) from error
    if not isinstance(row, dict):
        remedy = 'Write rows such as {"t [s]": 0.1}'
        raise LogError("the line is no JSON object", remedy=remedy, where=where)
    return cast("dict[str, Any]", row)


def _numbers_beside(document: Any, name: str, others: Sequence[str]) -> dict[str, float]:
    """Single numbers of a document by the last word of their names, such as a sampling rate beside the lists.

    Args:
        document: the file.
        name: place of the recording that is read.
        others: places of the recordings that are not read; their numbers, and those beside them alone, are theirs.
    """
    if not isinstance(document, dict):
        return {}
    theirs = {*others}
    for other in others:
        object_of_other, _, _ = other.rpartition(".")
        if not f"{name}.".startswith(f"{object_of_other}."):
            theirs.add(object_of_other)
    single: dict[str, Any] = {}
    for place, value in flat(cast("dict[str, Any]", document), "", 0):
        if not isinstance(value, list):
            single[place] = value
    numbers: dict[str, float] = {}
    for place, value in json_layout.cells_of(single):
        owner, _, _ = place.rpartition(".")
        of_another = any(other and f"{owner}.".startswith(f"{other}.") for other in theirs)
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if is_number and abs(value) < _LARGEST and not of_another:
            numbers[place] = float(value)
    names = map(printable, _short_names([*numbers]))
    return dict(zip(names, numbers.values(), strict=True))


def _table_of_rows(source: LogSource, rows: Iterable[_Row], notes: tuple[str, ...]) -> Table:
    """The values of all rows by their names; what a row lacks is missing."""
    budget = Budget(len(source.data))
    cells: dict[str, dict[int, Any]] = {}  # by name and row
    places: list[str] = []
    for row, (place, members) in enumerate(rows):
        places.append(place)
        names_before = len(cells)
        for name, value in json_layout.cells_of(members):
            count = len(cast("list[Any]", value)) if isinstance(value, list) else 1
            if count > json_layout.MOST_PLACES:
                most = f"{json_layout.MOST_PLACES} are the most"
                problem = f"{name} holds {count} numbers in one row, {most}"
                where = f"{source.name}, {place}"
                raise LogError(problem, remedy="Log one row a sample", where=where)
            cells.setdefault(name, {})[row] = value
        budget.take_names(len(cells) - names_before)
    budget.take_cells(len(places) * len(cells))  # a name that one row has is a column of all rows

    columns: dict[str, list[Any]] = {}
    short: set[int] = set()  # rows that lack a name
    for name, held in cells.items():
        columns[name] = [held.get(row) for row in range(len(places))]
        short.update(row for row in range(len(places)) if row not in held)
    if short:
        lack = f"{len(short)} of {len(places)} rows lack a name, such as row {min(short) + 1}: read as missing"
        notes = (*notes, lack)
    return _table(source, columns, places, notes)


def _table_of_lists(
    source: LogSource,
    lists: Mapping[str, list[Any]],
    notes: tuple[str, ...],
) -> Table:
    """Lists of the length that most have as columns; lists of other lengths are left out, with a note."""
    counts = Counter(map(len, lists.values()))
    rows = max(counts, key=lambda length: (length > 1, counts[length], length))
    columns: dict[str, list[Any]] = {}
    left_out: list[str] = []
    unreadable: dict[str, str] = {}
    constants: dict[str, float] = {}
    for name, values in lists.items():
        if len(values) == rows:
            columns[name] = values
            continue
        if len(values) == 1 and type(values[0]) in (int, float) and abs(values[0]) < _LARGEST:
            constants[printable(name.rpartition(".")[2])] = float(values[0])
            continue
        problem = f"list {name} has {len(values)} values, not {rows}"
        left_out.append(f"{problem}: left out")
        # Who needs such a list is told; a single value or none beside long lists is a setting.
        if len(values) > rows // 2:
            unreadable[name.rpartition(".")[2]] = problem
    places = [f"value {number}" for number in range(1, rows + 1)]
    table = _table(source, columns, places, (*notes, *left_out))
    return replace(table, unreadable={**table.unreadable, **unreadable}, constants=constants)


def _table(
    source: LogSource,
    columns: Mapping[str, list[Any]],
    places: list[str],
    notes: tuple[str, ...],
) -> Table:
    """Columns of numbers; columns of dates become the clock, columns of other texts are left out with a note."""
    import pandas as pd

    numbers: dict[str, Array] = {}
    texts: dict[str, Any] = {}
    unreadable: dict[str, str] = {}
    for (label, values), name in zip(columns.items(), _short_names(list(columns)), strict=True):
        known = [(row, value) for row, value in enumerate(values) if value is not None]
        are_switches = all(isinstance(value, bool) for _, value in known)
        without_number: list[int] = []  # rows
        for row, value in known:
            if isinstance(value, bool) or not isinstance(value, int | float):
                without_number.append(row)
        if without_number and not are_switches:
            first = without_number[0]
            shown = f"{label} is {values[first]!r:.40}"
            problem = f"{places[first]}, {shown} where a number is expected"
            unreadable[printable(name)] = problem
            if all(isinstance(value, str | None) for value in values):
                texts[printable(name)] = pd.Series(values)
            continue
        filled = [np.nan if value is None else value for value in values]
        try:
            numbers[name] = np.array([float(value) for value in filled])
        except OverflowError as error:  # an integer of hundreds of digits
            row = next(row for row, value in enumerate(values) if abs(value or 0) > _LARGEST)
            where = f"{source.name}, {places[row]}"
            problem = f"{label} is too large"
            raise LogError(problem, remedy="Mend or delete the row", where=where) from error

    clock_name, clock = dates.clock_of_dates(texts)
    for name in (clock_name, *clock_name.split(" and ")):
        unreadable.pop(name, None)
    in_texts = numbers_in_texts(
        {name: texts[name] for name in texts if name in unreadable}, source.decimal
    )
    numbers |= in_texts.columns
    in_order = map(printable, _short_names(list(columns)))
    numbers = {name: numbers[name] for name in in_order if name in numbers}
    for name in in_texts.columns:
        del unreadable[name]
    if not numbers and unreadable:
        problem = next(iter(unreadable.values()))
        raise LogError(problem, remedy="Log numbers only", where=source.name)
    names, units, renamed = name_columns(list(numbers))
    of_cells = dict(zip(numbers, names, strict=True))
    units_of = dict(zip(names, units, strict=True))
    units_of |= {of_cells[name]: unit for name, unit in in_texts.units.items()}
    words = parting_columns({name: texts[name] for name in texts if name in unreadable})
    left_out: list[str] = []
    for name, problem in unreadable.items():
        no_numbers = f"column {name} holds no numbers ({problem}): left out"
        left_out.append(parting_note(name, words[name]) if name in words else no_numbers)
    return Table(
        name=source.name,
        columns=dict(zip(names, numbers.values(), strict=True)),
        units=units_of,
        digest=source.digest,
        clock=clock,
        clock_name=clock_name,
        notes=(*notes, *in_texts.notes, *left_out, *renamed),
        unreadable=unreadable,
        words=words,
        metadata=only_words(texts),
        row_names=names_of_rows(texts),
    )


def _short_names(labels: list[str]) -> list[str]:
    """The last word of each name such as ``motor.speed`` where no other name ends so, else the whole name."""
    ends: list[str] = []
    for label in labels:
        point_in_unit = re.search(r"[\[(].*\.", label)
        ends.append(label if point_in_unit else label.rpartition(".")[2])
    uses = Counter(ends)
    names: list[str] = []
    for label, end in zip(labels, ends, strict=True):
        is_unique = end != "" and uses[end] == 1
        names.append(end if is_unique else label)
    return names


READER = LogReader(
    suffixes=(".jsonl", ".ndjson", ".json"),
    claims=lambda head: _BEGINS.match(head) is not None,
    read=_read,
    recordings=names_by(_read),
    tells_damage=DAMAGE,
)

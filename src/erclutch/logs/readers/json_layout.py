"""A document of JSON holds its recordings as rows, as lists, as signals with their units, or as a table with columns.

[{"t": 0.1, "speed": 3}, ...]                       rows
{"t": [0.1, ...], "motor": {"speed": [3, ...]}}     lists under names
{"speed": {"unit": "rad/s", "values": [3, ...]}}    signals
[{"name": "speed", "unit": "rad/s", "values": [3, ...]}, ...]
{"columns": ["t", "speed"], "data": [[0.1, 3], ...]}
{"speed": {"0": 3, "1": 4, ...}, ...}               pandas: rows under their numbers
{"runs": [{"t": [0.1, ...], "speed": [3, ...]}, ...]}
{"runs": [{"current": 0.5, "rows": [{"t": 0.1, "speed": 3}, ...]}, ...]}
{"data": [[0.1, 3], ...]}                           a matrix: its columns are data_1, data_2
{"t": 0.1, "speed": {"value": 3, "unit": "rad/s"}}  a row with units
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, cast

from erclutch.logs.columns.levels_in_names import differ_by_field
from erclutch.logs.readers.found_recordings import told_apart
from erclutch.logs.readers.json_columns import (
    COLUMNS,
    NAME,
    UNIT,
    labelled,
    table_with_columns,
    text_of,
)
from erclutch.logs.readers.stated_units import column_of_unit

DEEPEST = 20  # objects inside of objects
MOST_PLACES = 500  # numbers in a list of a row
_OF_NO_PLACE = "document"  # a name by which lists beside other recordings can be chosen
_LONG = 20  # numbers in a list of a step
_LISTS_OF_A_RUN = 4  # or more: a time, a field, a motion and an effort
_MOST_SIGNALS = 1000  # of one recording
_LARGEST = 1e300
_TIME = re.compile(r"t|time|zeit|timestamps?|time_?s|t \[.*|time \[.*", re.I)
_ROW_NAME = re.compile(r"-?\d{1,19}(?:\.\d{1,19})?(?:e[+-]?\d{1,2})?")
_VALUE = ("value", "val", "v", "magnitude")

Rows = list[Any]
Lists = dict[str, list[Any]]


def recordings(document: Any) -> Iterator[tuple[str, Rows | Lists]]:
    """Lists of rows, and lists of numbers by name, each with its place in the document."""
    found = [*_recordings(document, "", 0)]
    for name, recording in found:
        yield name or (_OF_NO_PLACE if len(found) > 1 else ""), recording


def _recordings(
    value: Any,
    name: str,
    depth: int,
) -> Iterator[tuple[str, Rows | Lists]]:
    if isinstance(value, list):
        yield from _of_items(cast("list[Any]", value), name, depth)
        return
    if not isinstance(value, dict) or depth > DEEPEST:
        return
    fields = cast("dict[str, Any]", value)
    table = table_with_columns(fields) or rows_under_numbers(fields)
    if table is not None:
        yield name, table
        return

    # Units by name, as {"units": {"speed": "rad/s"}} gives them.
    units: dict[str, str] = {}
    for place, each in flat(fields, "", 0):
        if isinstance(each, str) and column_of_unit(place):
            units[column_of_unit(place)] = each

    lists: Lists = {}
    for place, each in flat(fields, "", depth):
        if not isinstance(each, list):
            continue
        items = cast("list[Any]", each)
        above, _, last = place.rpartition(".")
        first = items[0] if items else None
        # The names of a table are said with its rows.
        names_a_table = last in COLUMNS and table_with_columns(_at(fields, above)) is not None
        if isinstance(first, dict):
            if not names_a_table:
                yield from _of_items(items, place, depth + 1)
        elif isinstance(first, list):
            table = (
                table_with_columns(_at(fields, above)) if last not in (*COLUMNS, "index") else None
            )
            if table is not None:
                yield above, table
            else:
                lists |= _columns_of_matrix(items, place) or {place: items}
        elif not names_a_table:
            # The unit stands beside the list in its object, or is given by name.
            owner = _at(fields, above)
            unit = text_of(owner, UNIT)
            label = labelled(place, units.get(last))
            if above and unit is not None and _signal(owner) is not None:
                label = f"{above} [{unit}]" if unit else above
            lists[label] = items
    yield from _grouped(lists, name)


def _of_items(
    items: list[Any],
    name: str,
    depth: int,
) -> Iterator[tuple[str, Rows | Lists]]:
    """A list of objects: signals, runs with lists of their own, or rows; or a list of rows without names."""
    matrix = _columns_of_matrix(items, name or "c")
    if matrix is not None:
        yield name, matrix
    if not items or not all(isinstance(item, dict) for item in items):
        return
    objects = cast("list[dict[str, Any]]", items)

    signals = _signals(objects)
    if signals is not None:
        yield name, signals
        return
    if not all(_is_run(item) for item in objects) and not _are_steps(objects):
        yield name, items
        return
    names: list[str] = []
    for number, run in enumerate(objects, start=1):
        other_names = [key for key in run if key.lower().endswith("name")]
        names.append(text_of(run, NAME) or text_of(run, other_names) or str(number))
    for own, run in zip(told_apart(names), objects, strict=True):
        place = f"{name}.{own}" if name else own
        of_run = list(_recordings(run, "", depth + 1))
        numbers: dict[str, float] = {}  # that hold for the whole run, such as its current
        for key, value in flat(run, "", 0):
            if isinstance(value, int | float) and not isinstance(value, bool):
                numbers[key] = value
        for inner, recording in of_run:
            inner_place = place if len(of_run) == 1 or not inner else f"{place}.{inner}"
            if isinstance(recording, dict):
                lists: Lists = {key: [number] for key, number in numbers.items()}
                yield inner_place, {**lists, **recording}
                continue
            rows: Rows = []
            for row in recording:
                rows.append({**numbers, **row} if isinstance(row, dict) else row)
            yield inner_place, rows


def _are_signals(items: Sequence[Any]) -> bool:
    """Whether a list holds objects that are signals with a label each."""
    if not 1 < len(items) <= _MOST_SIGNALS or not all(isinstance(item, dict) for item in items):
        return False
    return _signals(cast("Sequence[dict[str, Any]]", items)) is not None


def shared_numbers(document: Any) -> dict[str, float]:
    """Numbers that all signals of a document have beside their names, such as a sampling interval, by their keys."""
    shared: dict[str, float] = {}
    fields = cast("dict[str, Any]", document) if isinstance(document, dict) else {"": document}
    for _, each in flat(fields, "", 0):
        if not isinstance(each, list) or not _are_signals(cast("list[Any]", each)):
            continue
        signals = cast("list[dict[str, Any]]", each)
        for key, value in signals[0].items():
            is_number = isinstance(value, int | float) and not isinstance(value, bool)
            is_shared = all(signal.get(key) == value for signal in signals)
            if is_number and is_shared and abs(value) < _LARGEST:
                shared[key] = float(value)
    return shared


def _signals(objects: Sequence[dict[str, Any]]) -> Lists | None:
    """Lists by their labels, where each of several objects is a signal with a label."""
    if len(objects) < 2:
        return None
    labels: list[str] = []
    lists: list[list[Any]] = []
    for item in objects:
        signal = _signal(item)
        if signal is None or not signal[0]:
            return None
        label, numbers = signal
        labels.append(label)
        lists.append(numbers)
    return dict(zip(told_apart(labels), lists, strict=True))


def _is_run(item: Mapping[str, Any]) -> bool:
    """Whether an object holds a list of times, of rows with a time or of signals: then it is a run, and no row."""
    for place, each in flat(item, "", 0):
        if not isinstance(each, list):
            continue
        items = cast("list[Any]", each)
        if _TIME.fullmatch(place.rpartition(".")[2]) or _are_signals(items):
            return True
        # Rows are objects, each with the same time.
        first = cast("dict[str, Any]", items[0]) if items and isinstance(items[0], dict) else {}
        times = [key for key in first if _TIME.fullmatch(key)]
        if times and all(isinstance(item, dict) and times[0] in item for item in items):
            return True
    return False


def _are_steps(objects: Sequence[dict[str, Any]]) -> bool:
    """Whether each of several objects holds several long lists of one length, which is not that of the others.

    A screwdriver so gives its angle and torque for each step of a joint; the joints of a robot are as many in each row.
    """
    lengths: list[int] = []
    for item in objects:
        counts = Counter[int]()
        for _, each in flat(item, "", 0):
            if isinstance(each, list):
                counts[len(cast("list[Any]", each))] += 1
        length, lists = max(counts.items(), key=lambda each: each[1], default=(0, 0))
        if length < _LONG or lists < _LISTS_OF_A_RUN:
            return False
        lengths.append(length)
    return len({*lengths}) > 1


def _signal(item: Mapping[str, Any]) -> tuple[str, list[Any]] | None:
    """Label and numbers of an object that is one signal: one list, and else a name, a unit and other texts."""
    lists: list[list[Any]] = []
    texts: dict[str, str] = {}
    for key, each in item.items():
        if isinstance(each, dict):
            return None
        if isinstance(each, list):
            lists.append(cast("list[Any]", each))
        if isinstance(each, str) and each.strip():
            texts[key.lower()] = each
    if len(lists) != 1 or len(lists[0]) < 2:
        return None
    numbers = lists[0]
    if any(isinstance(each, dict | list) for each in numbers):
        return None
    return labelled(text_of(texts, NAME) or "", text_of(texts, UNIT)), numbers


def rows_under_numbers(fields: Mapping[str, Any]) -> Lists | None:
    """A table as pandas writes it by itself, or with orient="index": objects of one set of keys, which number the rows.

    {"speed": {"0": 3, "1": 4, ...}, ...} has an object for each column, {"0": {"speed": 3, ...}, ...} for each row.
    """
    objects = [cast("dict[str, Any]", each) for each in fields.values() if isinstance(each, dict)]
    if len(objects) < max(len(fields), 2) or any(
        each.keys() != objects[0].keys() for each in objects
    ):
        return None
    values = [value for each in objects for value in each.values()]
    if any(isinstance(value, dict | list) for value in values):
        return None
    has_column_names_outside = len(objects) < len(objects[0])
    row_names = [*objects[0]] if has_column_names_outside else [*fields]
    if len(row_names) < _LONG or not all(map(_ROW_NAME.fullmatch, row_names)):
        return None
    table: Lists = {}
    numbers = [float(each) for each in row_names]
    if numbers != [*range(len(numbers))]:  # an index that tells more than how many rows there are
        table["index"] = numbers
    for key in fields if has_column_names_outside else objects[0]:
        column = fields[key].values() if has_column_names_outside else [row[key] for row in objects]
        table[key] = [*column]
    return table


def _columns_of_matrix(rows: Sequence[Any], name: str) -> Lists | None:
    """The columns of rows of equal length, called by their place; None for other lists.

    A matrix on its side is turned.
    """
    if not rows or not all(isinstance(row, list) for row in rows):
        return None
    widths = {len(row) for row in rows}
    width = widths.pop()
    if widths or width < 2 or len(rows) < 2:
        return None
    if any(isinstance(cell, dict | list) for cell in rows[0]):
        return None
    columns = rows
    if len(rows) >= width:
        columns = [[row[place] for row in rows] for place in range(width)]
    return {f"{name}_{number}": column for number, column in enumerate(columns, start=1)}


def _at(fields: Mapping[str, Any], place: str) -> dict[str, Any]:
    """The object at a place such as ``motor.encoder``; an empty object where there is none."""
    owner: Any = fields
    for key in place.split(".") if place else ():
        if not isinstance(owner, dict):
            return {}
        owner = cast("dict[str, Any]", owner).get(key, {})
    return cast("dict[str, Any]", owner) if isinstance(owner, dict) else {}


def _grouped(lists: Lists, name: str) -> Iterator[tuple[str, Lists]]:
    """All lists as one recording, or, where several objects have times of their own, each object as one."""
    if not any(len(values) > 1 for values in lists.values()):
        return
    if name == "" and all(isinstance(value, str) for values in lists.values() for value in values):
        return  # words of a report, beside its recordings
    groups: dict[str, Lists] = {}  # by the object that holds them
    for place, values in lists.items():
        above = re.sub(r"\s*\[.*", "", place).rpartition(".")[0]
        groups.setdefault(above, {})[place] = values
    timed: list[str] = []  # objects with a time beside other lists
    for above, group in groups.items():
        names = [place.removeprefix(f"{above}.") for place in group]
        if len(group) > 1 and any(map(_TIME.fullmatch, names)):
            timed.append(above)
    lengths = {len(values) for values in lists.values()}
    inner_names = {
        frozenset(place.removeprefix(f"{above}.") for place in groups[above]) for above in timed
    }
    # Objects with the same lists and a time each are runs, as long as each other or not: 0A, 0.5A, or many lists.
    own_names = _without_shared_front(timed)
    tell_fields = differ_by_field(own_names)
    are_alike = len(inner_names) == 1
    are_runs = are_alike and (tell_fields or len(groups[timed[0]]) >= _LISTS_OF_A_RUN)
    if len(timed) < 2 or (len(lengths) == 1 and not are_runs):
        yield name, lists
        return

    for above, own_name in zip(timed, own_names, strict=True):
        own_place = f"{name}.{above}" if name else above
        if tell_fields:
            own_place = own_name  # behind a point 0.5A might be 5A
        own: Lists = {}
        for place, values in groups[above].items():
            own[place.removeprefix(f"{above}.")] = values
        yield own_place, own
    rest: Lists = {}
    for above, group in groups.items():
        if above not in timed:
            rest |= group
    if sum(len(values) > 1 for values in rest.values()) > 1:
        yield name, rest


def _without_shared_front(places: Sequence[str]) -> list[str]:
    """Places without the objects that all of them stand in: ``data.0A`` and ``data.0.5A`` are ``0A`` and ``0.5A``."""
    keys = [place.split(".") for place in places]
    shared = 0
    for same in zip(*keys, strict=False):
        # The point behind digits may be one of a number: ``0.5A``.
        is_shared = len({*same}) == 1 and not same[0][-1:].isdigit()
        if not is_shared or any(len(key) == shared + 1 for key in keys):
            break
        shared += 1
    return [".".join(key[shared:]) for key in keys]


def flat(
    members: Mapping[str, Any],
    above: str,
    depth: int,
) -> Iterator[tuple[str, Any]]:
    """Values of an object and of the objects in it, with names such as ``motor.speed``."""
    for key, value in members.items():
        name = f"{above}.{key}" if above else key
        if isinstance(value, dict) and depth < DEEPEST:
            yield from flat(cast("dict[str, Any]", value), name, depth + 1)
        else:
            yield name, value


def cells_of(members: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """The values of a row with their names; those of a list as ``q_1``, ``q_2``, of objects in a list ``motors[0].q``.

    Beside a list of different names, as the state of joints has them, a list of its length is ``elbow.effort`` and so
    on. A list that is too long for the joints of a robot comes out whole.
    """
    fields = dict(flat(members, "", 0))
    for place, value in fields.items():
        if not isinstance(value, list):
            owner, _, last = place.rpartition(".")
            beside = [fields.get(f"{owner}.{key}") for key in UNIT] if owner else []
            unit = next((each for each in beside if isinstance(each, str)), None)
            if unit is None or last.lower() not in (*UNIT, *_VALUE):
                yield place, value
            elif last.lower() in _VALUE:  # {"speed": {"value": 3, "unit": "rad/s"}}
                yield labelled(owner, unit), value
            continue
        parts = cast("list[Any]", value)
        owner, _, last = place.rpartition(".")
        names: Any = fields.get(f"{owner}.name" if owner else "name")
        if len(parts) > MOST_PLACES:
            yield place, parts
        elif last != "name" and _are_names(names, len(parts)):
            for name, part in zip(names, parts, strict=True):
                yield f"{owner}.{name}.{last}".removeprefix("."), part
        elif parts and all(isinstance(part, dict) for part in parts):
            for number, part in enumerate(parts):
                yield from flat(cast("dict[str, Any]", part), f"{place}[{number}]", 1)
        elif last != "name" or not _are_names(parts, len(parts)):
            for number, part in enumerate(parts, start=1):
                yield f"{place}_{number}", part


def _are_names(value: Any, count: int) -> bool:
    """Whether a value is a list of so many different names."""
    if not isinstance(value, list):
        return False
    names = cast("list[Any]", value)
    if len(names) != count or not all(isinstance(name, str) and name for name in names):
        return False
    return len({*names}) == count > 0

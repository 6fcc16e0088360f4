"""A document of JSON holds its recordings as rows, as lists, as signals with their units, or as a table with columns.

[{"t": 0.1, "speed": 3}, ...]                       rows
{"t": [0.1, ...], "motor": {"speed": [3, ...]}}     lists under names
{"speed": {"unit": "rad/s", "values": [3, ...]}}    signals
[{"name": "speed", "unit": "rad/s", "values": [3, ...]}, ...]
{"columns": ["t", "speed"], "data": [[0.1, 3], ...]}
{"runs": [{"t": [0.1, ...], "speed": [3, ...]}, ...]}
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, cast

DEEPEST = 20  # objects inside of objects
_TIME = re.compile(r"t|time|zeit|timestamps?|time_?s|t \[.*|time \[.*", re.I)
_NAME, _UNIT = ("name", "label", "signal", "channel", "key", "id"), ("unit", "units")

Rows = list[Any]
Lists = dict[str, list[Any]]


def recordings(value: Any) -> Iterator[tuple[str, Rows | Lists]]:
    """Lists of rows, and lists of numbers by name, each with its place in the document."""
    yield from _recordings(value, "", 0)


def _recordings(value: Any, name: str, depth: int) -> Iterator[tuple[str, Rows | Lists]]:
    if isinstance(value, list):
        yield from _of_items(cast("list[Any]", value), name, depth)
        return
    if not isinstance(value, dict) or depth > DEEPEST:
        return
    fields = cast("dict[str, Any]", value)
    if (table := _with_columns(fields)) is not None:
        yield name, table
        return
    units = _units(fields)
    lists: Lists = {}
    for place, each in flat(fields, "", depth):
        if not isinstance(each, list):
            continue
        items = cast("list[Any]", each)
        above, _, last = place.rpartition(".")
        if items and isinstance(items[0], dict):
            if last == "columns" and _with_columns(_at(fields, above)) is not None:
                continue
            yield from _of_items(items, place, depth + 1)
        elif items and isinstance(items[0], list):
            owner = _at(fields, above)
            if last not in ("columns", "index") and (table := _with_columns(owner)) is not None:
                yield above, table
            else:
                lists[place] = items
        elif last != "columns" or _with_columns(_at(fields, above)) is None:
            lists[_label(fields, place, units)] = items
    yield from _grouped(lists, name)


def _of_items(items: list[Any], name: str, depth: int) -> Iterator[tuple[str, Rows | Lists]]:
    """A list of objects: signals, runs with lists of their own, or rows."""
    if not items or not all(isinstance(item, dict) for item in items):
        return
    objects = cast("list[dict[str, Any]]", items)
    signals = [_signal(each) for each in objects]
    if all(signal is not None and signal[0] for signal in signals) and len(objects) > 1:
        yield name, dict(signal for signal in signals if signal is not None)
    elif all(_times(each) for each in objects):
        for number, each in enumerate(objects, start=1):
            inner = list(_recordings(each, "", depth + 1))
            own = next((str(each[key]) for key in _NAME if isinstance(each.get(key), str)), str(number))
            yield from ((f"{name}.{own}" if name else own, found) for _, found in inner)
    else:
        yield name, items


def _times(item: Mapping[str, Any]) -> bool:
    """Whether an object holds a list of times: then it is a run, and no row."""
    return any(
        isinstance(each, list) and _TIME.fullmatch(place.rpartition(".")[2]) for place, each in flat(item, "", 0)
    )


def _signal(item: Mapping[str, Any]) -> tuple[str, list[Any]] | None:
    """Label and numbers of an object that is one signal: one list, and else a name, a unit and other texts."""
    lists = [cast("list[Any]", each) for each in item.values() if isinstance(each, list)]
    if len(lists) != 1 or len(lists[0]) < 2 or any(isinstance(each, dict | list) for each in lists[0]):
        return None
    if any(isinstance(each, dict) for each in item.values()):
        return None
    texts = {key.lower(): each for key, each in item.items() if isinstance(each, str) and each.strip()}
    label = next((texts[key] for key in _NAME if key in texts), "")
    unit = next((texts[key] for key in _UNIT if key in texts), "")
    return (f"{label} [{unit}]" if unit and "[" not in label else label), lists[0]


def _with_columns(fields: Mapping[str, Any]) -> Lists | None:
    """A table as pandas writes it with orient="split": names under "columns", rows as lists."""
    columns = fields.get("columns")
    if not isinstance(columns, list) or not columns:
        return None
    labels: list[str] = []
    for each in cast("list[Any]", columns):
        told: dict[str, Any] = cast("dict[str, Any]", each) if isinstance(each, dict) else {"name": each}
        label = next((told[key] for key in _NAME if isinstance(told.get(key), str)), None)
        unit = next((told[key] for key in _UNIT if isinstance(told.get(key), str) and told[key]), "")
        if label is None:
            return None
        labels.append(f"{label} [{unit}]" if unit and "[" not in label else label)
    if len({*labels}) < len(labels):
        return None
    for key, rows in fields.items():
        held = cast("list[Any]", rows) if isinstance(rows, list) else []
        whole = all(isinstance(row, list) and len(cast("list[Any]", row)) == len(labels) for row in held)
        if key not in ("columns", "index") and held and whole:
            return {label: [row[place] for row in held] for place, label in enumerate(labels)}
    return None


def _units(fields: Mapping[str, Any]) -> dict[str, str]:
    """Units that an object such as ``"units": {"speed": "rad/s"}`` gives by name."""
    return {
        place.rpartition(".")[2]: each
        for place, each in flat(fields, "", 0)
        if isinstance(each, str) and re.search(r"(?:^|\.)units?\.[^.]+$", place, re.I)
    }


def _label(fields: Mapping[str, Any], place: str, units: Mapping[str, str]) -> str:
    """The place of a list with its unit: beside the list in its object, or given by name."""
    above, _, last = place.rpartition(".")
    owner = _at(fields, above)
    if above and _signal(owner) is not None and any(isinstance(owner.get(key), str) for key in _UNIT):
        unit = next(str(owner[key]) for key in _UNIT if isinstance(owner.get(key), str))
        return f"{above} [{unit}]" if unit else above
    return f"{place} [{units[last]}]" if units.get(last) and "[" not in place else place


def _at(fields: Mapping[str, Any], place: str) -> dict[str, Any]:
    owner: Any = fields
    for key in place.split(".") if place else ():
        owner = cast("dict[str, Any]", owner).get(key, {}) if isinstance(owner, dict) else {}
    return cast("dict[str, Any]", owner) if isinstance(owner, dict) else {}


def _grouped(lists: Lists, name: str) -> Iterator[tuple[str, Lists]]:
    """All lists as one recording, or, where several objects have times of their own, each object as one."""
    if not any(len(each) > 1 for each in lists.values()):
        return
    groups: dict[str, Lists] = {}
    for place, each in lists.items():
        above = re.sub(r"\s*\[.*", "", place).rpartition(".")[0]
        groups.setdefault(above, {})[place] = each
    timed = {
        above: group
        for above, group in groups.items()
        if len(group) > 1 and any(_TIME.fullmatch(place.removeprefix(f"{above}.")) for place in group)
    }
    if len(timed) < 2 or len({len(each) for each in lists.values()}) == 1:
        yield name, lists
        return
    for above, group in timed.items():
        yield (
            f"{name}.{above}" if name else above,
            {place.removeprefix(f"{above}."): each for place, each in group.items()},
        )
    rest = {place: each for above, group in groups.items() if above not in timed for place, each in group.items()}
    if sum(len(each) > 1 for each in rest.values()) > 1:
        yield name, rest


def flat(members: Mapping[str, Any], above: str, depth: int) -> Iterator[tuple[str, Any]]:
    """Values of an object and of the objects in it, with names such as ``motor.speed``."""
    for key, value in members.items():
        name = f"{above}.{key}" if above else key
        if isinstance(value, dict) and depth < DEEPEST:
            yield from flat(cast("dict[str, Any]", value), name, depth + 1)
        else:
            yield name, value

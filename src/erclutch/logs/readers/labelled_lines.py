"""Lines such as ``t:1000, w:0.30, T:1.25 Nm`` have the name of each value before it, as microcontrollers print them.

A line may lack some of the names of the fullest line: these cells are empty.
"""

from __future__ import annotations

import csv
import io
import re
from dataclasses import replace

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import text
from erclutch.logs.readers.text_bytes import DAMAGE, decode
from erclutch.logs.table import Table

_PAIR = re.compile(
    r"[\s,;|]*(?P<name>[^\W\d][^:=,;|\t\n]{0,40}?)\s*[:=]\s*"
    r"(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|nan|inf)(?P<unit>[ ]?[A-Za-z%°µ][\w/^*°µ]*)?(?=[\s,;|]|$)"
)
_FEWEST_PAIRS = 2  # in a line: a header block has a line for each name
_FEWEST_LINES = 3  # of the same names, among the first bytes
_LEFT_OUT = 0.1  # of the lines behind the first, at most: with more it is another format


def _pairs(line: str) -> list[tuple[str, str, str]]:
    """Names, numbers and units of a line; none where anything else stands in it."""
    pairs: list[tuple[str, str, str]] = []
    at = 0
    while match := _PAIR.match(line, at):
        name = match["name"].strip()
        unit = (match["unit"] or "").strip()
        pairs.append((name, match["number"], unit))
        at = match.end()
    if not line[at:].strip(" \t,;|\r") and len(pairs) >= _FEWEST_PAIRS:
        return pairs
    return []


def _names(line: str) -> tuple[str, ...]:
    return tuple(name for name, _, _ in _pairs(line))


def _are_some_of(names: tuple[str, ...], every: tuple[str, ...]) -> bool:
    """Whether a line has names of the fullest line in its order, half of them or more: it lacks the others."""
    left = iter(every)
    return 2 * len(names) >= len(every) and all(name in left for name in names)


def _claims(head: bytes) -> bool:
    lines = head.decode("utf-8", errors="replace").splitlines()[:-1]  # the last may be cut
    named = [names for line in lines if (names := _names(line))]
    if len(named) < _FEWEST_LINES or len({*named}) > 1:
        return False
    names = named[0]
    return len({*names}) == len(names)  # no name stands twice


def _read(source: LogSource) -> Table:
    """The values as the rows of a table; lines without values are counted."""
    lines = decode(source.data).splitlines()
    named = [pairs for line in lines if (pairs := _pairs(line))]
    if not named:
        raise LogError("no line has values behind their names", remedy="Give a table of numbers with one row a sample")
    names = max((tuple(name for name, _, _ in pairs) for pairs in named), key=len)
    first_names = tuple(name for name, _, _ in named[0])
    if not _are_some_of(first_names, names):
        names = first_names
    rows: list[dict[str, str]] = []  # numbers by name
    units: dict[str, str] = {}
    for pairs in named:
        if _are_some_of(tuple(name for name, _, _ in pairs), names):
            rows.append({name: number for name, number, _ in pairs})
            for name, _, unit in pairs:
                units.setdefault(name, unit)
    first = next(place for place, line in enumerate(lines) if (own := _names(line)) and _are_some_of(own, names))
    left_out = sum(bool(line.strip()) for line in lines[first:]) - len(rows)
    if left_out > _LEFT_OUT * len(rows):
        problem = f"{left_out} lines do not hold the values {', '.join(names)}, as {len(rows)} lines do"
        raise LogError(problem, remedy="Save each kind of line in a file of its own")

    written = io.StringIO()
    table = csv.writer(written)
    table.writerow(f"{name} [{units[name]}]" if units[name] else name for name in names)
    table.writerows([row.get(name, "") for name in names] for row in rows)
    read = text.read_text(replace(source, data=written.getvalue().encode()))
    notes = ["each line has the names of its values"]
    if left_out:
        notes.append(f"lines that do not hold these values left out: {left_out}")
    lacking = sum(len(row) < len(names) for row in rows)
    if lacking:
        notes.append(f"lines that lack some of the values: {lacking}; their cells are empty")
    return replace(read, notes=(*notes, *read.notes))


READER = LogReader((), _claims, _read, tells_damage=DAMAGE)

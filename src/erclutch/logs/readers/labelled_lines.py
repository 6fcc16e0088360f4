"""Lines such as ``t:1000, w:0.30, T:1.25 Nm`` have the name of each value before it, as microcontrollers print them.

The name may stand right in front of its number: ``t1000 w0.30 T1.25``. A line may lack some of the names of the fullest
line: these cells are empty.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers.serial_monitor import STAMP
from erclutch.logs.readers.text_bytes import DAMAGE, decode
from erclutch.logs.readers.text_table import read_cells
from erclutch.logs.table import Table

_PAIR = re.compile(
    r"[\s,;|]*(?P<name>[^\W\d][^:=,;|\t\n]{0,40}?)\s*[:=]\s*"
    r"(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|nan|inf)(?P<unit>[ ]?[A-Za-z%°µ][\w/^*°µ]*)?(?=[\s,;|]|$)"
)
#: A name right in front of its number; an exponent has a sign and two digits, so that E may be a name too.
_GLUED = re.compile(
    r"[\s,;|<]*(?P<name>[^\W\d_]{1,12})(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]\d\d)?)"
    r"(?P<unit>)(?=[\s,;|>]|$|[^\W\d_]{1,12}[-+.\d])"
)
#: A time in front of a line: of a kernel or a program, ``[   12.500] I: 0.5 A``, or alone, ``12.500 I: 0.5 A``.
_IN_BRACKETS = re.compile(
    r"[ \t]{0,20}(?:\[[ ]{0,20}(?P<stamp>\d{1,15}(?:\.\d{1,9})?)[ ]?(?P<unit>s|ms|us)?\][ \t]{0,20}:?"
    r"|(?P<bare>\d{1,12}\.\d{1,9})[ \t]{1,9}(?=[^\W\d_]))"
)
#: Date and time of a program's log, and what stands between them and the values: ``- bench - INFO -``, ``INFO``.
_LOGGED = re.compile(
    r"\[?(?P<stamp>\d{4}-\d\d-\d\d[ T]\d\d:\d\d:\d\d)(?:[.,](?P<part>\d{1,9}))?\]?"
    r"(?:(?: - [\w.]{1,40}){1,3} - |[ ]{1,3}\[?(?:DEBUG|INFO|WARN|WARNING|ERROR)\]?:?[ ]{1,3}|[ :]{1,3})"
)
#: The level of a message, and behind it the time and the node where ROS prints it: ``[INFO] [1714745232.12] [bench]:``.
_LEVEL = re.compile(
    r"(?:\[(?:DEBUG|INFO|WARN|WARNING|ERROR)\]|(?:DEBUG|INFO|WARN|WARNING|ERROR)(?=[ :]))"
    r"[ ]{0,3}(?:\[(?P<stamp>\d{1,12}(?:\.\d{1,9})?)\])?[ ]{0,3}(?:\[[\w./-]{1,60}\])?:?[ ]{0,3}"
)
#: Share of the first lines that hold names and numbers, at least, where no mark stands between a name and its number.
_MOST_LINES = 0.5
_FEWEST_PAIRS = 2  # in a line: a header block has a line for each name
_FEWEST_LINES = 3  # of the same names, among the first bytes
_LEFT_OUT = 0.1  # of the lines behind the first, at most: with more it is another format


def time_of(line: str) -> tuple[tuple[str, str, str] | None, int]:
    """The name, the number and the unit of the time in front of a line, or None, and where the line's values begin."""
    stamp = STAMP.match(line)
    if stamp:
        return ("Time", stamp[1], ""), stamp.end()
    in_brackets = _IN_BRACKETS.match(line)
    if in_brackets:
        number = in_brackets["stamp"] or in_brackets["bare"]
        return ("Time", number, in_brackets["unit"] or ""), in_brackets.end()
    logged = _LOGGED.match(line)
    if logged:
        return ("Time", f"{logged['stamp']}.{logged['part'] or 0}", ""), logged.end()
    level = _LEVEL.match(line)
    if level:
        time = ("Time", level["stamp"], "s") if level["stamp"] else None
        return time, level.end()
    return None, 0


def _pairs(line: str) -> list[tuple[str, str, str]]:
    """Names, numbers and units of a line; none where anything else stands in it."""
    time, at_first = time_of(line)
    for pattern in (_PAIR, _GLUED):
        pairs: list[tuple[str, str, str]] = []
        at = at_first
        if time:
            pairs.append(time)
        while match := pattern.match(line, at):
            name = match["name"].strip()
            unit = (match["unit"] or "").strip()
            pairs.append((name, match["number"], unit))
            at = match.end()
        if not line[at:].strip(" \t,;|>\r") and len(pairs) >= _FEWEST_PAIRS:
            return pairs
    return []


def _names_of(pairs: Iterable[tuple[str, str, str]]) -> tuple[str, ...]:
    return tuple(name for name, _, _ in pairs)


def _are_some_of(names: tuple[str, ...], every: tuple[str, ...]) -> bool:
    """Whether a line has names of the fullest line in its order, half of them or more: it lacks the others."""
    left = iter(every)
    return 2 * len(names) >= len(every) and all(name in left for name in names)


def _claims(head: bytes) -> bool:
    *lines, _ = head.decode("utf-8", errors="replace").splitlines() or [""]  # the last may be cut
    named: list[tuple[str, ...]] = []
    for line in lines:
        pairs = _pairs(line)
        if pairs:
            named.append(_names_of(pairs))
    if len(named) < _FEWEST_LINES or len({*named}) > 1:
        return False
    has_marks = any(":" in line or "=" in line for line in lines)
    if not has_marks and len(named) < _MOST_LINES * sum(map(bool, map(str.strip, lines))):
        return False
    names = named[0]
    return len({*names}) == len(names)  # no name stands twice


def _read(source: LogSource) -> Table:
    """The values as the rows of a table; lines without values are counted."""
    filled = [line for line in decode(source.data).splitlines() if line.strip()]
    pairs_of = [_pairs(line) for line in filled]
    named = [_names_of(pairs) for pairs in pairs_of if pairs]
    if not named:
        raise LogError(
            "no line has values behind their names",
            remedy="Give a table of numbers with one row a sample",
        )
    names = max(named, key=len)
    if not _are_some_of(named[0], names):
        names = named[0]
    rows: list[dict[str, str]] = []  # numbers by name
    units: dict[str, str] = {}
    left_out = 0  # lines behind the first row
    for pairs in pairs_of:
        if not pairs or not _are_some_of(_names_of(pairs), names):
            left_out += bool(rows)
            continue
        rows.append({name: number for name, number, _ in pairs})
        for name, _, unit in pairs:
            units.setdefault(name, unit)
    if left_out > _LEFT_OUT * len(rows):
        problem = (
            f"{left_out} lines do not hold the values {', '.join(names)}, as {len(rows)} lines do"
        )
        raise LogError(problem, remedy="Save each kind of line in a file of its own")

    labels = [f"{name} [{units[name]}]" if units[name] else name for name in names]
    table = read_cells(source, labels, ([row.get(name, "") for name in names] for row in rows))
    notes = ["each line has the names of its values"]
    if left_out:
        notes.append(f"lines that do not hold these values left out: {left_out}")
    lacking = sum(len(row) < len(names) for row in rows)
    if lacking:
        notes.append(f"lines that lack some of the values: {lacking}; their cells are empty")
    return replace(table, notes=(*notes, *table.notes))


READER = LogReader((), _claims, _read, tells_damage=DAMAGE)

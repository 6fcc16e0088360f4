"""Exports of Anton Paar's programs: RheoCompass writes "Interval data:" before each table, Rheoplus "Meas. Pts.".

Both write tables under each other, one an interval of a test, with names, then units in brackets, then points. In
other languages than English their marks are known by their places.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace

from erclutch.errors import LogError
from erclutch.logs.readers.cells import is_numeric
from erclutch.wings.rheology.rheometer_blocks import Block, cells, delimiter_of, reader_of_blocks

_COUNT = re.compile(r"\d+(?:[.,]0*)?|")  # of a point; some copies leave it empty
_COMPASS = "Interval data:"
_PLUS = "Meas. Pts."
#: What stands before the name of a test; the last line before a table names it best.
_TESTS = ("Test:", "Result:", "Name:", "Sample:")
_INTERVALS = ("Interval and data points:", "Interval:")
_ENGLISH = re.compile("Interval and data points:|Interval data:|Meas. Pts.|Number of Intervals:")
#: In any language: a line that numbers an interval, names below it, perhaps words, and units in brackets below these.
_ANNOUNCED = re.compile(
    r"^(?P<interval>[^\t;,:：\n]{3,60}[:：])[\t;,] ?\d+(?:[\t;,] ?\d+)?[\t;, ]*\r?\n"
    r"(?P<names>[^\t;,\n]*)[\t;,][^\n]*\n(?:[\t;, ][^\n\[]*\n|\r?\n)?(?=[\t;, ]+\"?\[)",
    re.MULTILINE,
)
#: The first bytes of a file may end before the units: then the mark before the names, as RheoCompass writes it, counts.
_MARKED = re.compile(
    r"^[^\t;,:：\n]{3,60}[:：][\t;,] ?\d+[\t;,] ?\d+[\t;, ]*\r?\n[^\t;,\n]{3,60}[:：][\t;,][^\t;,\n]+[\t;,]",
    re.MULTILINE,
)
_KEY = re.compile(r"([^\t;,:：\n]{2,60}[:：])[\t;,](.*[^\W\d_].*)")

#: RheoCompass writes decimal commas, and a point in numbers with an exponent all the same.
_COMMA = re.compile(r"[+-]?\d+,\d+(?:E[+-]?\d+)?")
_POINT = re.compile(r"^([+-]?\d+)\.(\d+E[+-]?\d+)$")


def _in_english(content: str) -> str | None:
    """The content with English marks, None without any mark.

    A table stands below a project, a test and a result, or the last of them.
    """
    table = _ANNOUNCED.search(content)
    if table is None and not _ENGLISH.search(content):
        return None
    if table is None or _COMPASS in content or _PLUS in content:
        return content
    names = table["names"].strip()
    english: dict[str, str] = {}  # by the mark in the other language
    if names.endswith((":", "：")):  # as RheoCompass ends its marks
        english[table["interval"]] = _INTERVALS[0]
        english[names] = _COMPASS
    else:
        english[table["interval"]] = _INTERVALS[1]
        english[names] = _PLUS
    keys: list[str] = []
    for line in content[: table.start()].split("\n"):
        match = _KEY.fullmatch(line)
        if match is not None:
            keys.append(match.group(1))
    test, result, *_ = _TESTS
    nearest_first = (test,) if len(keys) == 1 else (result, test, "Project:")
    english |= dict(zip(reversed(keys), nearest_first, strict=False))

    lines: list[str] = []
    for line in content.split("\n"):
        mark = next((mark for mark in english if line.startswith(mark)), "")
        lines.append(english[mark] + line.removeprefix(mark) if mark else line)
    return "\n".join(lines)


def _blocks(content: str) -> list[Block] | None:
    """The table of each interval, called after its test; after its result too, where tests have one name.

    None for a plain table below a head of another instrument.
    """
    english = _in_english(content)
    if english is None:
        return None
    lines = english.splitlines()
    head = next((line for line in lines if _COMPASS in line or _PLUS in line), "")
    delimiter = delimiter_of(head)
    blocks: list[Block] = []
    heads: dict[str, str] = {}  # of the test, its result and its sample
    interval = ""
    marks = 0  # of RheoCompass, one a table
    results: list[str] = []  # test, result and sample of each block
    at = 0
    while at < len(lines):
        row = cells(lines[at], delimiter)
        at += 1
        first = row[0] if row else ""
        numbers = sum(map(is_numeric, row))
        if first in _TESTS and len(row) > 1 and row[1]:
            if first == _TESTS[0]:  # another test begins
                heads = {}
            heads = {**heads, first: row[1]}
        elif first in _INTERVALS and len(row) > 1:
            interval = row[1].removesuffix(".0")  # a sheet's number
        elif numbers > 1 and not first.endswith(":") and (not first or is_numeric(first)):
            problem = f"line {at} is a row of numbers outside of any table"
            raise LogError(problem, remedy="Correct the lines above it, or delete it")
        elif first in (_COMPASS, _PLUS):
            marks += first == _COMPASS
            # RheoCompass begins each row of a table with an empty cell, below the mark; some copies lack that cell.
            margin = 1 if first == _COMPASS else 0
            names = row[margin:]
            while names and not names[-1]:
                names.pop()
            units, at = _units_from(lines, at, delimiter, margin)
            start = at
            rows: list[list[str]] = []
            while at < len(lines):
                point = cells(lines[at], delimiter)
                if not any(point) or point[0] in (
                    *_TESTS,
                    *_INTERVALS,
                    _COMPASS,
                    _PLUS,
                    "Project:",
                ):
                    break
                rows.append(_behind(margin, point))
                at += 1
            if delimiter != "," and any(_COMMA.fullmatch(cell) for row in rows for cell in row):
                rows = [[_POINT.sub(r"\1,\2", cell) for cell in row] for row in rows]
            _require_counts(rows if first == _PLUS else (), start + 1)
            if rows:
                results.append(", ".join(dict.fromkeys(heads.values())))
                test = next(reversed(heads.values()), "")
                blocks.append(
                    Block(_called(test, interval, len(blocks)), names, units, rows, start + 1)
                )
    announced = sum(line.startswith(_INTERVALS[0]) for line in lines)
    if marks and marks < announced:
        problem = f"{announced} intervals are announced, and {marks} have a line {_COMPASS!r} above their points"
        raise LogError(problem, remedy="Correct the line above the names of each interval")
    return _told_apart(blocks, results)


def _told_apart(blocks: list[Block], results: Sequence[str]) -> list[Block]:
    """Blocks under names of their own: where results have one name, their tests stand in front."""
    if len({block.name for block in blocks}) == len(blocks):
        return blocks
    told_apart: list[Block] = []
    for block, result in zip(blocks, results, strict=True):
        of_interval = block.name.rpartition(", interval ")[2]
        told_apart.append(replace(block, name=_called(result, of_interval, 0)))
    return told_apart


def _require_counts(rows: Sequence[Sequence[str]], line: int) -> None:
    """Refuse rows below Rheoplus' names that do not begin with the numbers of their points: names would be moved."""
    for number, row in enumerate(rows, start=line):
        if not _COUNT.fullmatch(row[0]):
            problem = f"line {number} has {row[0]!r} below {_PLUS!r}, where a point has its number"
            raise LogError(problem, remedy="Correct the line of names above it")


def _units_from(
    lines: list[str],
    at: int,
    delimiter: str,
    margin: int,
) -> tuple[list[str], int]:
    """The units of a table from a line below its names on, and the line of its first row; a table may have no units."""
    while at < len(lines):
        below = cells(lines[at], delimiter)
        bracketed = any(cell.startswith("[") for cell in below)
        numeric = any(map(is_numeric, below))
        if numeric and not bracketed:
            break
        if numeric:
            raise LogError(
                f"line {at + 1} holds units and a row", remedy="Break the line before the row"
            )
        at += 1
        units = _behind(margin, below) if bracketed else []
        if units:  # else the line has words, such as "Constant component", and is passed
            while at < len(lines) and not any(cells(lines[at], delimiter)):
                at += 1
            return units, at
    return [], at


def _behind(margin: int, row: list[str]) -> list[str]:
    """A row without the empty cell below the mark, if the row has that cell."""
    return row[margin:] if margin and not row[0] else row


def _called(test: str, interval: str, before: int) -> str:
    name = test or f"test {before + 1}"
    return f"{name}, interval {interval}" if interval else name


# By a mark near the beginning, or by places in another language.
READER = reader_of_blocks(
    lambda text: any(mark.search(text) for mark in (_ANNOUNCED, _MARKED, _ENGLISH)),
    _blocks,
    "test",
)

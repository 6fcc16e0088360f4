"""A text may hold several tables under each other, each with a header of its own: each of them is a recording.

They are looked for only where the text is no single table, so that a long log is never searched.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from erclutch.errors import LogError, placed
from erclutch.logs.log_reader import LogSource
from erclutch.logs.readers.dialect import LINE_END, cells_of, is_comment, is_number
from erclutch.logs.readers.found_recordings import ALL, choose
from erclutch.logs.readers.text_bytes import decode
from erclutch.logs.table import Table

_LARGEST = 1 << 25  # bytes of a text that is searched
_FEWEST_ROWS = 2
_TEXTS, _LONGEST_PROSE = (".txt", ".log"), 1 << 16  # suffixes and bytes of what may be words about logs
_ANY_DELIMITER, _WORD = re.compile(r"[\s,;|]+"), re.compile(r"[^\W\d_]{3}")
_DELIMITERS = ("\t", ";", ",", "|", None)


def read_tables(source: LogSource, read: Callable[[LogSource], Table]) -> Table:
    """The only table of a text, or the table that is wanted of several.

    Args:
        source: of a text.
        read: a text that holds one table.

    Raises:
        LogError: no table, several without a choice, or none of that name.
    """
    if not source.variable:
        try:
            table = read(source)
        except LogError:
            if len(_tables_in(source)) < 2:
                raise
        else:
            if not table.unreadable or len(_tables_in(source)) < 2:
                return table
    tables = _tables_in(source)
    if len(tables) < 2 and source.variable != ALL:
        problem = f"the text is one recording, so it has no {source.variable!r} for --variable"
        raise LogError(problem, remedy="Leave it out, or give --variable '' where a run or mapping has it")
    found = {} if len(tables) < 2 else tables
    name, (line, text) = choose(found, source.variable, "table", "the text holds one table")
    with placed(f"{source.name}, table from line {line} on"):
        table = read(replace(source, data=text.encode("utf-8"), variable=None))
    note = f"recording read from {name}, 1 of {len(tables)} tables of the text"
    return replace(table, notes=(note, *table.notes))


def _tables_in(source: LogSource) -> dict[str, tuple[int, str]]:
    """Tables by name: the line of their header, counted from 1, and their text."""
    if len(source.data) > _LARGEST:
        return {}
    lines = LINE_END.split(decode(source.data))
    heads = _headers(lines)
    if not heads:
        return {}
    tables: dict[str, tuple[int, str]] = {}
    for number, (start, stop) in enumerate(zip(heads, [*heads[1:], len(lines)], strict=True), start=1):
        title = _title(lines, start, heads[number - 2] if number > 1 else -1)
        name = title if title and title not in tables else f"table {number}"
        # The title of the next table is no row of this one.
        last = stop - 1
        while last > start and stop < len(lines) and len([cell for cell in _cells(lines[last]) if cell]) < 2:
            last -= 1
        tables[name] = start + 1, "\n".join(lines[start : last + 1])
    return tables


def _headers(lines: list[str]) -> list[int]:
    """Lines of names above rows of numbers, if the later ones have a name of the first or stand behind a break."""
    filled = [at for at, line in enumerate(lines) if line.strip() and not is_comment(line)]
    heads: list[int] = []
    first: set[str] = set()
    before = -1
    for place, at in enumerate(filled):
        below = filled[place + 1 : place + 3 + _FEWEST_ROWS]
        names = _names(lines[at])
        if names is None or not below or (before >= 0 and place - before < _FEWEST_ROWS):
            continue
        rows = [_is_row(lines[each]) for each in below]
        units = not rows[0] and _names(lines[below[0]]) is not None
        if sum(rows[units : units + _FEWEST_ROWS]) < _FEWEST_ROWS:
            continue
        above = lines[at - 1] if at else ""
        apart = not above.strip() or len(_cells(above)) == 1 or not _is_row(above)
        if not heads or apart or first & {*names}:
            heads.append(at)
            first = first or {*names}
            before = place
    return heads


def _cells(line: str) -> list[str]:
    """Cells by the delimiter that cuts the line most; by wide gaps where there is none."""
    return max((cells_of(line, each) for each in _DELIMITERS[:-1]), key=len) if line.strip() else []


def _names(line: str) -> list[str] | None:
    cells = _cells(line)
    named = [cell for cell in cells if cell]
    numbers = any(is_number(cell, mark) for cell in named for mark in ".,")
    return None if len(named) < 2 or 2 * len(named) < len(cells) or numbers else named


def _is_row(line: str) -> bool:
    cells = [cell for cell in _cells(line) if cell]
    return len(cells) > 1 and 2 * sum(any(is_number(c, mark) for mark in ".,") for c in cells) > len(cells)


def is_prose(path: Path) -> bool:
    """Whether a small text holds words and no two rows of numbers in a row: a README beside logs.

    Any delimiter counts, spaces too, so that no log is taken for words: half of the cells of a row are numbers.
    """
    if path.suffix.lower() not in _TEXTS or path.stat().st_size > _LONGEST_PROSE:
        return False
    try:
        lines = [line for line in LINE_END.split(decode(path.read_bytes())) if line.strip()]
    except (LogError, OSError):
        return False  # whoever reads the file says what is wrong with it
    rows = [_has_numbers(line) for line in lines]
    words = any(_WORD.search(line) for line in lines)  # the e of an exponent is none
    return words and not any(first and second for first, second in pairwise(rows))


def _has_numbers(line: str) -> bool:
    cells = _ANY_DELIMITER.split(line.strip())
    return 2 * sum(is_number(cell, ".") for cell in cells) >= len(cells)


def _title(lines: list[str], head: int, before: int) -> str:
    """The line of words right above a header."""
    above = next((lines[at] for at in range(head - 1, before, -1) if lines[at].strip()), "")
    cells = [cell for cell in _cells(above) if cell]
    return cells[0].strip("#%/ ")[:60] if len(cells) == 1 and not is_number(cells[0], ".") else ""

"""A text may hold several tables under each other, each with a header of its own: each of them is a recording.

They are looked for only where the text is no single table, so that a long log is never searched.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import replace
from functools import lru_cache
from itertools import pairwise, takewhile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from erclutch.errors import LogError, placed
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.log_reader import LogSource
from erclutch.logs.readers.cells import (
    DELIMITERS,
    STATISTICS,
    cells_of,
    is_full,
    is_number,
    is_numeric,
)
from erclutch.logs.readers.dialect import lines_of
from erclutch.logs.readers.found_recordings import ALL, choose
from erclutch.logs.readers.header_pairs import header_pairs
from erclutch.logs.readers.remarks_between_rows import without_remarks
from erclutch.logs.readers.side_by_side import read_side_by_side
from erclutch.logs.readers.stated_units import with_stated_units
from erclutch.logs.readers.text_bytes import decode
from erclutch.logs.readers.text_table import read_text
from erclutch.logs.readers.titled_blocks import may_hold_titles, title_of, titled_blocks
from erclutch.logs.table import Table
from erclutch.signals import units

_LARGEST = 1 << 25  # bytes of a text that is searched
_SHORT, _KEPT = 1 << 17, 16  # bytes of a text whose table is kept; how many are
_FEWEST_ROWS = 2
_MANY_ROWS = 20  # of a table that another one sums up
_ENDS = ("largest", "smallest")  # rows of a table that gives the ends of ranges
_PROSE = (".txt", ".log")  # suffixes of what may be words about logs
_LONGEST_PROSE = 1 << 16  # bytes
_ANY_DELIMITER = re.compile(r"[\s,;|]+")
_WORD = re.compile(r"[^\W\d_]{3}")
_DECIMAL_COMMA = re.compile(r"(?<=\d),(?=\d)")
#: Words with one number that has a decimal comma: ``Test 2: current 0,5 A``.
_TITLE_WITH_A_DECIMAL_COMMA = re.compile(r"\W*[^\W\d_]{2}[^,;\t]*[ =:]\d+,\d+ ?[^\W\d_]*\s*")
_BESIDE_DECIMAL_COMMAS = ("\t", ";")  # delimiters of lines whose commas all stand between digits
_LONGEST_SETTING = 3  # cells: a name, a number and its unit
_BEGINS_WITH_A_NUMBER = re.compile(r"[-+]?[.,]?\d")


def read_tables(source: LogSource) -> Table:
    """The only table of a text, or the table that is wanted of several beside or under each other.

    Raises:
        LogError: no table, several without a choice, or none of that name.
    """
    return _read(source) if len(source.data) > _SHORT else deepcopy(_read_once(source))


# One command reads a log of a folder up to five times: is it a log, what does it hold, which field has it, what of it
# is fitted? Most of such logs are short.
@lru_cache(maxsize=_KEPT)
def _read_once(source: LogSource) -> Table:
    """The table of a short text. Its bytes, its name and what is asked of it decide about it, and nothing else."""
    return _read(source)


def _read(source: LogSource) -> Table:
    beside = read_side_by_side(source)
    if beside is not None:
        return beside
    tables: dict[str, _Part] | None = dict(_titled_in(source.data)) or None
    if not source.variable and tables is None:
        try:
            table = read_text(source)
        except LogError:
            tables = dict(_tables_in(source.data))
            below = _only_table(source, tables)
            if below is not None:
                return below
            if len(tables) < 2:
                table = _without_remarks(source)
                if table is None:
                    raise
                return table
        else:
            # A column that cannot be read may be that of a second table below.
            tables = dict(_tables_in(source.data)) if table.unreadable else {}
            if len(tables) < 2:
                return table
        whole = _under_one_header(source, tables)
        if whole is not None:
            return whole
    if tables is None:
        tables = dict(_tables_in(source.data))
    if len(tables) < 2:
        if source.variable != ALL:
            problem = f"the text is one recording, so it has no {source.variable!r} for --variable"
            raise LogError(
                problem, remedy="Leave it out, or give --variable '' where a run or mapping has it"
            )
        tables = {}

    name, (line, settings, text) = choose(
        tables, source.variable, "table", "the text holds one table"
    )
    text = "\n".join([*settings.values(), text])
    with placed(f"{source.name}, table from line {line} on"):
        table = read_text(replace(source, data=text.encode("utf-8"), variable=None))
    if tables:
        first = next(iter(tables.values()))
        above = lines_of(decode(source.data))[: first.line - 1]
        table = with_stated_units(table, header_pairs(above))
    note = f"recording read from {name}, 1 of {len(tables)} tables of the text"
    return replace(table, notes=(note, *table.notes))


def _without_remarks(source: LogSource) -> Table | None:
    """The table of a text that holds a logger's remarks among its rows; None where it does not, or is no table so."""
    without = without_remarks(decode(source.data))
    if without is None:
        return None
    text, note = without
    try:
        table = read_text(replace(source, data=text.encode("utf-8")))
    except LogError:  # the error of the file as it is says more, and of its own lines
        return None
    return replace(table, notes=(note, *table.notes))


def _only_table(source: LogSource, tables: Mapping[str, _Part]) -> Table | None:
    """The only table of several rows, below a result or two of the test with a header of their own; None for others."""
    if len(tables) != 1:
        return None
    ((line, settings, text),) = tables.values()
    before = [each.strip() for each in lines_of(decode(source.data))[: line - 1]]
    above = [each for each in before if each]
    # An empty line parts them; a row right above the names may be one of theirs.
    is_apart = bool(before) and not before[-1]
    names, *_ = lines_of(text.strip())
    if settings or not above or not is_apart or names.strip() in above:
        return None
    try:
        table = read_text(replace(source, data=text.encode("utf-8")))
    except LogError:
        return None
    note = f"{len(above)} lines above the table left out, from {above[0][:40]!r} on"
    return replace(table, notes=(note, *table.notes))


def _under_one_header(source: LogSource, tables: Mapping[str, _Part]) -> Table | None:
    """Tables of the same header as one, where the time goes on from one to the next: a logger said its names again.

    A testing machine gives the two ends of each range in a table of its own beside the long ones.
    """
    headers: set[tuple[str, ...]] = set()
    rows: list[str] = []
    if len({tuple(part.settings.values()) for part in tables.values()}) > 1:
        return None
    rows_of = {name: sum(map(_is_row, part.text.split("\n"))) for name, part in tables.items()}
    ends = [name for name, count in rows_of.items() if count == len(_ENDS)]
    if not ends or max(rows_of.values()) < _MANY_ROWS or len(tables) - len(ends) < 2:
        ends = []
    tables = {name: part for name, part in tables.items() if name not in ends}
    for part in tables.values():
        lines = [line.strip("\r") for line in part.text.split("\n") if line.strip()]
        # Below the names may stand a line of units, and below the rows what heads the next table.
        first = 1 if len(lines) < 2 or _names(lines[1]) is None else 2
        last = len(lines)
        while last > first and not _is_row(lines[last - 1]):
            last -= 1
        header = tuple(line.strip() for line in lines[:first])
        headers.add(header)
        rows += [line for line in lines[first:last] if line.strip() not in header]
    if len(headers) > 1:
        return None
    together = "\n".join([*headers.pop(), *rows])
    try:
        table = read_text(replace(source, data=together.encode("utf-8")))
    except LogError:
        return None
    label = next((name for name in table.columns if spoken_name(name).is_time), None)
    times = table.clock if label is None else table.columns[label]
    if times is None or not bool(np.all(np.diff(times) >= 0.0)):
        return None
    notes = [
        f"the names stand {len(tables)} times in the text, and the time goes on below each: one recording",
        *(f"{name} has two rows, the ends of each range: left out" for name in ends),
    ]
    return replace(table, notes=(*notes, *table.notes))


class _Part(NamedTuple):
    """A table of a text.

    Attributes:
        line: of its header, counted from 1.
        settings: lines above it that give it a number, by what they are of; each table has those of the same keys.
        text: its header and rows.
    """

    line: int
    settings: dict[str, str]
    text: str


@lru_cache(maxsize=1)
def _titled_in(data: bytes) -> Mapping[str, _Part]:
    """The tests of a text that stand under titles below one line of names; none where each has names of its own."""
    if len(data) > _LARGEST or not may_hold_titles(data):
        return {}
    lines = lines_of(decode(data))
    blocks = titled_blocks(lines, _is_row)
    heads = lines_of_names(lines) if blocks else []
    if not blocks or len(heads) > 1:
        return {}
    # What stands above the names is said of all tests, but for what each says of its own.
    own = {_setting(line) for block in blocks[1:] for line in block.above} - {""}
    titles = {block.title for block in blocks} - {""}
    shared: list[str] = []
    above = blocks[0].above
    no_titles = [line for line in above if title_of(line) not in titles]
    first_names = next((line for line in no_titles if _names(line)), None)
    place_of_names = above.index(first_names) if first_names is not None else len(above)
    for place, line in enumerate(above):
        is_of_the_first = _setting(line) in own or title_of(line) in titles
        is_of_all = not is_of_the_first if place < place_of_names else _names(line) is not None
        if is_of_all:
            shared.append(line)
    parts: dict[str, _Part] = {}
    for number, block in enumerate(blocks, start=1):
        name = block.title[:60] or f"table {number}"
        name = f"{name} ({number})" if name in parts else name
        settings = {key: line for line in block.above if (key := _setting(line))}
        parts[name] = _Part(block.line, settings, "\n".join([*shared, *block.rows]))
    of_all = set[str].intersection(*(set(part.settings) for part in parts.values()))
    for name, part in parts.items():
        kept = {key: line for key, line in part.settings.items() if key in of_all}
        parts[name] = part._replace(settings=kept)
    return parts


@lru_cache(maxsize=1)  # each table of a text is read by a call of its own
def _tables_in(data: bytes) -> Mapping[str, _Part]:
    """The tables of a text by name; none in one that is too long for a search."""
    if len(data) > _LARGEST:
        return {}
    lines = lines_of(decode(data))
    heads = lines_of_names(lines)
    tables: dict[str, _Part] = {}
    before = rows_before = -1  # lines of the header before, and of its last row
    for number, head in enumerate(heads, start=1):
        # A line of words right above the header is the title of the table.
        between = [line for line in lines[before + 1 : head] if line.strip()]
        cells = _filled_cells(between[-1]) if between else []
        are_words = len(cells) == 1 and not is_number(cells[0], ".")
        title = cells[0].strip("#%/ ")[:60] if are_words else ""
        name = title if title and title not in tables else f"table {number}"
        last = len(lines) - 1
        if number < len(heads):
            # The title and the settings of the next table are no rows of this one.
            last = heads[number] - 1
            while last > head and (len(_filled_cells(lines[last])) < 2 or _setting(lines[last])):
                last -= 1
        settings: dict[str, str] = {}
        above = takewhile(lambda line: not _is_row(line), reversed(lines[rows_before + 1 : head]))
        for line in above:
            key = _setting(line)
            if key:
                settings[key] = line
        tables[name] = _Part(head + 1, settings, "\n".join(lines[head : last + 1]))
        before = head
        rows_before = last
    # What stands above the first table alone is no setting of that table.
    parts = [*tables.values()]
    for name, part in tables.items():
        kept = {
            key: line
            for key, line in part.settings.items()
            if all(key in each.settings for each in parts)
        }
        tables[name] = part._replace(settings=kept)
    return tables


def _setting(line: str) -> str:
    """What a line gives one number of, with its name in front of the number; "" for other lines."""
    cells = _filled_cells(line)
    if not 1 <= len(cells) <= _LONGEST_SETTING or is_numeric(cells[0]):
        return ""
    for key, text in header_pairs([line.lstrip("#%/ ")]).items():
        is_sum = re.sub(r"[\W_]", "", key).lower() in STATISTICS
        if not is_sum and _BEGINS_WITH_A_NUMBER.match(text):
            return key
    return ""


def lines_of_names(lines: list[str]) -> list[int]:
    """Lines of names above rows of numbers, if the later ones have a name of the first or stand behind a break."""
    filled = [at for at, line in enumerate(lines) if is_full(line)]
    heads: list[int] = []
    names_of_first: set[str] = set()
    place_before = -_FEWEST_ROWS  # of the header before, among the filled lines
    for place, at in enumerate(filled):
        below = filled[place + 1 : place + 3 + _FEWEST_ROWS]
        names = _names(lines[at])
        names_of_a_test = _names_of_a_test(lines[at], lines[below[0]]) if below else None
        names_of_sensors = _names_of_sensors(lines[at], lines[below[0]]) if below else None
        names = names or names_of_a_test or names_of_sensors
        if names is None or not below or place - place_before < _FEWEST_ROWS:
            continue
        # Between the names and the rows may stand a line of units.
        are_rows = [_is_row(lines[each]) for each in below]
        has_units = not are_rows[0] and _names(lines[below[0]]) is not None
        rows = sum(are_rows[has_units : has_units + _FEWEST_ROWS])
        if rows < _FEWEST_ROWS:
            continue
        above = lines[at - 1] if at else ""
        apart = not above.strip() or len(_cells(above)) == 1 or not _is_row(above)
        apart = apart or names_of_a_test is not None
        if not heads or apart or names_of_first & {*names}:
            heads.append(at)
            names_of_first = names_of_first or {*names}
            place_before = place
    return heads


@lru_cache(maxsize=16)  # a line is looked at by itself, and as the line below others
def _cells(line: str) -> tuple[str, ...]:
    """Cells by the delimiter that cuts the line most; one cell where there is none."""
    if not line.strip():
        return ()
    for delimiter in _BESIDE_DECIMAL_COMMAS:
        if delimiter in line and "," in line and "," not in _DECIMAL_COMMA.sub("", line):
            return tuple(cells_of(line, delimiter))
    if _TITLE_WITH_A_DECIMAL_COMMA.fullmatch(line):
        return (line.strip(),)
    return tuple(max((cells_of(line, delimiter) for delimiter in DELIMITERS), key=len))


def _filled_cells(line: str) -> list[str]:
    return [cell for cell in _cells(line) if cell]


def _names(line: str) -> list[str] | None:
    """The names of a header line; None where the line is none."""
    cells = _cells(line)
    names = [cell for cell in cells if cell]
    if len(names) < 2 or 2 * len(names) < len(cells):
        return None
    return None if any(is_numeric(name) for name in names) else names


def _names_of_a_test(line: str, below: str) -> list[str] | None:
    """The names behind the number of a test, where a line of units stands below them; None for another line.

    A testing machine writes ``1,Time,Load`` above ``,(s),(N)``, and the rows of its first specimen below.
    """
    number, *names = _cells(line) or [""]
    no_number, *units_below = _cells(below) or [""]
    are_alike = len(names) == len(units_below) > 1 and all(names) and not no_number
    if not number.isdecimal() or not are_alike or any(map(is_numeric, [*names, *units_below])):
        return None
    return names


def _names_of_sensors(line: str, below: str) -> list[str] | None:
    """Names of which some are the serial numbers of sensors, where a line of units stands below; None for others."""
    cells = _cells(line)
    units_below = _cells(below)
    words = [cell for cell in cells if not cell.isdecimal()]
    are_names = 2 <= len(words) < len(cells) <= 2 * len(words) and all(cells)
    if not are_names or len(units_below) != len(cells) or any(map(is_numeric, words)):
        return None
    return [*cells] if all(map(units.is_unit, units_below)) else None


def _is_row(line: str) -> bool:
    cells = _filled_cells(line)
    if len(cells) < 2:  # numbers between blanks; a title has words beside them
        cells = line.split()
        return len(cells) > 1 and all(map(is_numeric, cells))
    return 2 * sum(map(is_numeric, cells)) > len(cells)


def is_prose(path: Path) -> bool:
    """Whether a small text holds words and no two rows of numbers in a row: a README beside logs.

    Any delimiter counts, spaces too, so that no log is taken for words: half of the cells of a row are numbers.
    """
    if path.suffix.lower() not in _PROSE or path.stat().st_size > _LONGEST_PROSE:
        return False
    try:
        text = decode(path.read_bytes())
    except (LogError, OSError):
        return False  # whoever reads the file says what is wrong with it
    has_words = False
    rows: list[bool] = []
    for line in lines_of(text):
        if line.strip():
            cells = _ANY_DELIMITER.split(line.strip())
            numbers = sum(is_number(cell, ".") for cell in cells)
            rows.append(2 * numbers >= len(cells))
            # The e of an exponent is no word.
            has_words = has_words or _WORD.search(line) is not None
    return has_words and not any(first and second for first, second in pairwise(rows))

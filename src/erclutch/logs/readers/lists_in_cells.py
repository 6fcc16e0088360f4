"""A table may keep a whole course in a cell, ``"[0.1, 0.2, 0.3]"``, a row for each test: each number gets a row."""

from __future__ import annotations

import csv
import io
import re

from erclutch.errors import listed

_LOOKED_AT = 1 << 16  # characters of the first lines
_BEGINS = re.compile(r"(?:^|[,;\t])\"\[[ ]{0,9}[-+.\d]", re.MULTILINE)
#: A list of numbers as Python and NumPy print it.
_LIST = re.compile(r"\s*\[[-+.\deE,;\snaif]*\]\s*")
_PARTS = re.compile(r"[,;\s]+")
_FEWEST_LISTS = 2  # columns
_FEWEST_NUMBERS = 20  # of a course: a shorter list has a number for each joint or axis
_LONGEST = 1 << 28  # characters of a cell


def with_lists_in_cells(text: str) -> tuple[str, str]:
    """The text with a row for each number of its lists, and a note; as it is and "" where no cells hold lists.

    The lists of a row are of one length, and what stands beside them in it holds for all their numbers.
    """
    if not _BEGINS.search(text[:_LOOKED_AT]):
        return text, ""
    first_line = text.partition("\n")[0]
    delimiter = max(",;\t", key=first_line.count)
    limit = csv.field_size_limit(_LONGEST)
    try:
        header, *rows = [row for row in csv.reader(io.StringIO(text), delimiter=delimiter) if row]
    except (csv.Error, ValueError):
        return text, ""
    finally:
        csv.field_size_limit(limit)
    width = len(header)
    if not rows or any(len(row) != width for row in rows):
        return text, ""
    places = [place for place in range(width) if all(_LIST.fullmatch(row[place]) for row in rows)]
    if len(places) < _FEWEST_LISTS:
        return text, ""
    written = io.StringIO()
    table = csv.writer(written, lineterminator="\n")
    table.writerow(header)
    for row in rows:
        lists: dict[int, list[str]] = {}  # numbers as texts, by the place of their cell
        for place in places:
            parts = _PARTS.split(row[place].strip().strip("[]"))
            lists[place] = [part for part in parts if part]
        lengths = {len(numbers) for numbers in lists.values()}
        if len(lengths) > 1 or min(lengths) < _FEWEST_NUMBERS:
            return text, ""
        for number in range(lengths.pop()):
            table.writerow(
                [lists[place][number] if place in lists else row[place] for place in range(width)]
            )
    names = listed([header[place] for place in places], 6)
    return written.getvalue(), f"cells of {names} hold lists: each number has a row"

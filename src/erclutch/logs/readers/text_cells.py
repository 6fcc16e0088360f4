"""Cells of a text become numbers, words of a switch, or an error that names the line; rows of odd length are told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from erclutch.errors import LogError
from erclutch.logs.columns.labels import split_label, without_copy_number
from erclutch.logs.columns.names import spoken_name
from erclutch.logs.readers.cells import BEYOND, FAULTS, cells_of, is_comment, is_number
from erclutch.logs.readers.dialect import Dialect, lines_of
from erclutch.logs.readers.numerals import ungrouped
from erclutch.logs.readers.switches import switched
from erclutch.signals.array import Array

if TYPE_CHECKING:
    import pandas as pd

#: What is said of a cell that is no number.
CORRECT = "Correct or empty that cell, or delete the line"
#: Other white space makes a row.
BLANK = " \t\r\n"
#: A hexadecimal number of 16 or 32 bits whose first bit is set.
_MAY_BE_SIGNED = r"0[xX](?:[89a-fA-F][0-9a-fA-F]{3}|[89a-fA-F][0-9a-fA-F]{7})"
#: A number, and a comment behind it.
_REMARKED = r"^([+-]?[\d.,]+(?:[eE][+-]?\d+)?)\s+((?:#|//|%|!)\s*\D.*)$"
_MOST_TORN = 0.1  # share of the cells of a column that a fault has damaged
_MOST_TORN_ROWS = 0.01  # of a text: more of them may have decimal commas
_FEWEST_ROWS = 20
_LONGEST_NUMBER = 400  # characters of a cell


class TornColumnError(LogError):
    """A few cells of a column are no numbers: `numbers` has NaN there, shape (n,)."""

    def __init__(self, problem: str, numbers: Array) -> None:
        super().__init__(problem, remedy=CORRECT)
        self.numbers = numbers


def read_cells(
    cells: pd.Series[Any],
    index: int,
    body: str,
    dialect: Dialect,
) -> tuple[Array | None, list[str]]:
    """The column as float64, None for a column of text, and a note where words became numbers.

    Args:
        cells: of the column, as pandas reads them.
        index: of the column.
        body: the rows as text.
        dialect: of the text.

    Raises:
        LogError: a text among numbers; its line is named.
        TornColumnError: such texts stand in a few rows, and each has another sign than a number has, or no digit.
    """
    import pandas as pd

    label = dialect.names[index]
    notes: list[str] = []
    if cells.dtype == object or str(cells.dtype).startswith("str"):
        words = cells.dropna().astype(str).str.strip()
        are_hexadecimal = len(words) > 0 and words.str.fullmatch(r"0[xX][0-9a-fA-F]{1,13}").all()
        # The first digit of 0xFFF0 may be a sign.
        if are_hexadecimal and not words.str.fullmatch(_MAY_BE_SIGNED).any():
            whole_numbers = np.full(len(cells), np.nan)
            whole_numbers[cells.notna().to_numpy()] = [float(int(word, 16)) for word in words]
            note = f"column {label} holds hexadecimal numbers, read as whole numbers"
            return whole_numbers, [note]
        # A meter has words for a reading beyond its range, and a logger for one that failed.
        texts = cells.astype(str).str.strip()
        for written, meant in (
            (BEYOND, "a reading beyond the range of its meter"),
            (FAULTS, "where a reading failed"),
        ):
            without = (cells.notna() & texts.str.lower().isin(written)).to_numpy()
            others = texts[cells.notna().to_numpy() & ~without]
            if without.any() and len(others) and others.str.contains(r"\d").all():
                word = texts[without].iloc[0]
                count = int(without.sum())
                notes.append(f"column {label} holds {word!r} in {count} rows, {meant}: no number")
                cells = cells.mask(without)
        # A remark may stand behind a number.
        remarked = (
            cells.notna().to_numpy() & pd.to_numeric(texts, errors="coerce").isna().to_numpy()
        )
        parts = texts[remarked].str.extract(_REMARKED)
        remarked[remarked] = parts[0].notna()
        if remarked.any():
            remark = parts[1].dropna().iloc[0][:40]
            what = f"remarks behind {int(remarked.sum())} numbers ({remark!r}): left out"
            notes.append(f"column {label} has {what}")
            cells = cells.mask(remarked, parts[0].reindex(cells.index))

    if pd.api.types.is_numeric_dtype(cells.dtype):
        if cells.dtype == bool:
            notes.append(f"column {label} holds True and False, read as 1 and 0")
        return np.ascontiguousarray(cells.to_numpy(dtype=np.float64)), notes
    filled = cells.notna().to_numpy()
    texts = cells.astype(str).str.strip()
    # Cells of thousands of digits are no numbers of a log, and take the time of their length squared.
    short = texts.where(texts.str.len() <= _LONGEST_NUMBER, "x")
    values = np.full(len(short), np.nan)
    if dialect.decimal == ".":  # most cells are written as Python writes them, and are read at once
        values = np.array(pd.to_numeric(short.where(filled), errors="coerce"), np.float64)
    others = filled & np.isnan(values)
    if others.any():
        plain = short[others].map(lambda cell: ungrouped(str(cell), dialect.decimal))
        values[others] = pd.to_numeric(plain, errors="coerce").to_numpy(dtype=np.float64)
    bad = filled & np.isnan(values)
    count = int(bad.sum())
    if not count:
        return values, notes

    if 2 * count > int(filled.sum()) and not dialect.numeric[index]:
        ones_and_zeros = switched(label, cells)
        if ones_and_zeros is None:
            return None, []
        numbers, note = ones_and_zeros
        return numbers, [note]
    row = int(np.argmax(bad))
    lines = _numbered_lines(body, dialect)
    # In damaged text, pandas may see more rows than there are lines.
    line, _ = lines[min(row, len(lines) - 1)]
    shown = str(texts.iloc[row])[:40]
    more = f" ({count} such cells)" if count > 1 else ""
    problem = f"line {line}, column {label} is '{shown}' where a number is expected{more}"
    # Digits and marks alone may be a number in another way of writing.
    no_numbers = texts[bad].str.contains(r"[^\d.,'\s+-]") | ~texts[bad].str.contains(r"\d")
    if count <= _MOST_TORN * len(cells) and bool(no_numbers.all()):
        raise TornColumnError(problem, values)
    raise LogError(problem, remedy=CORRECT)


def without_torn_rows(body: str, dialect: Dialect) -> tuple[str, list[int], str]:
    """The rows with empty cells in place of a few that have too many, which these are, and what is wrong.

    Their first cells may be those of the columns, or of none: nothing tells which cell is one too many.
    """
    width = len(dialect.names) + dialect.trailing
    lines = lines_of(body)
    rows = [place for place, line in enumerate(lines) if line.strip(BLANK)]
    torn: list[int] = []
    for row, place in enumerate(rows):
        if _is_too_long(cells_of(lines[place], dialect.delimiter), dialect):
            torn.append(row)
    are_few = len(torn) <= max(1, _MOST_TORN_ROWS * len(rows)) and len(rows) >= _FEWEST_ROWS
    if not torn or not are_few or dialect.delimiter is None:
        return body, [], ""
    problem = _said_of_width(dialect.first + 1 + rows[torn[0]], lines[rows[torn[0]]], dialect)
    more = f" ({len(torn)} such lines)" if len(torn) > 1 else ""
    for row in torn:
        lines[rows[row]] = dialect.delimiter * (width - 1)
    return "\n".join(lines), torn, problem + more


def long_rows(frame: pd.DataFrame, body: str, dialect: Dialect) -> list[str]:
    """A note on rows with more cells than columns, where these hold no number.

    Raises:
        LogError: a row in which they hold one.
    """
    width = len(dialect.names) + dialect.trailing
    further = frame.iloc[:, len(dialect.names) :]
    filled = bool(further.notna().to_numpy().any())
    if filled:
        refuse_ragged(body, dialect)
    expected = len(frame) * (width - 1)  # delimiters
    if not filled and (not dialect.delimiter or body.count(dialect.delimiter) <= expected):
        return []
    lines = _numbered_lines(body, dialect)
    long = [number for number, line in lines if len(cells_of(line, dialect.delimiter)) > width]
    if not long:
        return []
    more = f" ({len(long)} such lines)" if len(long) > 1 else ""
    return [f"line {long[0]} has more cells than there are columns{more}: left out"]


def _numbered_lines(body: str, dialect: Dialect) -> list[tuple[int, str]]:
    """The line of each row, with its number in the file, counted from 1."""
    lines = enumerate(lines_of(body), start=dialect.first + 1)
    return [(number, line) for number, line in lines if line.strip(BLANK)]


def have_ended(body: str, dialect: Dialect, rows: Sequence[int], count: int) -> bool:
    """Whether some rows are short since channels ended that stand behind times of their own.

    These are the last rows, and each holds whole pairs of a time and a value. A scope leaves out the cells of the
    slower channels, or of those that were stopped.

    Args:
        body: all rows as text.
        dialect: of the text.
        rows: those whose last column is empty.
        count: of all rows.
    """
    stems = {*map(without_copy_number, dialect.names[::2])}
    are_pairs = len(dialect.names) > 2 and len(dialect.names) % 2 == 0 and len(stems) == 1
    are_last = [*rows] == [*range(count - len(rows), count)]
    if not are_pairs or not are_last:
        return False
    name, _ = split_label(stems.pop())
    if not spoken_name(name).is_time:
        return False
    lines = _numbered_lines(body, dialect)
    widths = [len(cells_of(lines[row][1], dialect.delimiter)) for row in rows]
    return all(width % 2 == 0 for width in widths)


def refuse_ragged(
    body: str,
    dialect: Dialect,
    rows: list[int] | None = None,
    needed: int = 0,
) -> None:
    """Raise for the first row with too many cells or fewer than needed; look at the given rows only, or at all."""
    if rows == []:
        return
    lines = _numbered_lines(body, dialect)
    if rows is not None:
        lines = [lines[row] for row in rows if row < len(lines)]
    for number, line in lines:
        cells = cells_of(line, dialect.delimiter)
        if _is_too_long(cells, dialect) or len(cells) < needed:
            problem = _said_of_width(number, line, dialect)
            raise LogError(problem, remedy="Correct or delete that line")


def _is_too_long(cells: Sequence[str], dialect: Dialect) -> bool:
    """Whether a row has cells behind those of the columns, and they are no remark on it."""
    beyond = [cell for cell in cells[len(dialect.names) + dialect.trailing :] if cell]
    if not beyond or is_comment(beyond[0]):
        return False
    # Behind a last column of text, more text is another remark on the row.
    return dialect.numeric[-1] or any(is_number(cell, dialect.decimal) for cell in beyond)


def _said_of_width(number: int, line: str, dialect: Dialect) -> str:
    """What is wrong with a line that has more cells than the columns, or fewer."""
    cells = cells_of(line, dialect.delimiter)
    may_have_commas = dialect.delimiter == "," and dialect.decimal == "."
    hint = " (a decimal comma?)" if may_have_commas and _is_too_long(cells, dialect) else ""
    return f"line {number} has {len(cells)} cells where {len(dialect.names)} are expected{hint}"

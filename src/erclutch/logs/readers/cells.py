"""Cells of a line of text, and what tells a number from a word, under a delimiter and a decimal mark."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass

from erclutch.logs.readers.numerals import GROUPED

_COMMENT = ("#", "%", "//")
#: What may stand between cells, besides blanks.
DELIMITERS = ("\t", ";", ",", "|")
_SIGNED = {sign + word for sign in ("", "-", "+") for word in ("nan", "inf")}
#: What a C library of Windows writes for no number, cut to the digits that a format has.
_MARKED = ("QNAN", "QNB", "QO", "IND", "IO", "R", "INF", "J", "F")
NO_NUMBERS = tuple(f"{sign}1.#{mark}" for sign in ("", "-") for mark in _MARKED)
_LOWER = {word.lower() for word in NO_NUMBERS}
#: What a meter writes for a reading beyond its range.
BEYOND = {
    sign + word
    for sign in ("", "+", "-")
    for word in ("ol", "ovld", "ovl", "ovrng", "overload", "overrange", "eeee", "∞")
}
#: What loggers, historians of plants and spreadsheets write where a number failed.
FAULTS = frozenset(
    (
        *(
            "err",
            "err.",
            "error",
            "fail",
            "failed",
            "bad",
            "invalid",
            "missing",
            "timeout",
            "overflow",
            "novalue",
            "no value",
            "no data",
            "nodata",
        ),
        *(
            "#value!",
            "#n/a",
            "#div/0!",
            "#ref!",
            "#num!",
            "#null!",
            "#name?",
            "#wert!",
            "#nv",
            "#error",
        ),
        *(
            "over range",
            "under range",
            "underrange",
            "out of range",
            "over-range",
            "out-of-range",
            "ovf",
        ),
        *(
            "no data",
            "nodata",
            "no_data",
            "no signal",
            "not available",
            "not connected",
            "disconnected",
        ),
        *(
            "bad input",
            "bad data",
            "i/o timeout",
            "i/o timeou",
            "calc failed",
            "comm fail",
            "comm failure",
        ),
        *(
            "scan off",
            "shutdown",
            "intf shut",
            "pt created",
            "open circuit",
            "sensor error",
            "sensor fault",
        ),
        *("fehler", "ung\u00fcltig", "ungueltig", "erreur", "fallo", "errore"),
    )
)
_NO_NAMES = frozenset(word for word in FAULTS if not word.isalpha())  # error may be a column
#: What people and spreadsheets write for no value.
DASHES = ("-", "--", "---", "–", "—", "−")
WORDS = {
    *DASHES,
    *_SIGNED,
    *_LOWER,
    *BEYOND,
    *FAULTS,
    "",
    "na",
    "n/a",
    "null",
    "infinity",
    "-infinity",
}
#: Words of a line below the rows that sums them up, without blanks and points.
STATISTICS = frozenset(
    (
        "mean average avg median max maximum min minimum sum total std stdev stddev stderr "
        "standarddeviation standarderror variance var rms sd sem cv rsd sigma mean±sd "
        "coefficientofvariation mittelwert mittel mw summe standardabweichung stabw moyenne moy "
        "médiane écarttype ecarttype media promedio desviación desviaciónestándar desvest média "
        "desviopadrão desviopadrao среднее 平均 平均值 最大 最大值 最小 最小值 标准差 標準偏差 合计 合計"
    ).split()
)
#: A plain number or a number in groups, by the decimal mark: in one search, since most cells of a text are looked at.
_NUMBER = {
    ".": re.compile(rf"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eEdD][+-]?\d+)?|{GROUPED['.'].pattern}"),
    ",": re.compile(rf"[+-]?(?:\d+(?:,\d+)?|,\d+)(?:[eEdD][+-]?\d+)?|{GROUPED[','].pattern}"),
}


def is_comment(line: str) -> bool:
    """Whether the line starts with ``#``, ``%`` or ``//``."""
    return line.lstrip().startswith(_COMMENT)


def is_full(line: str) -> bool:
    """Whether the line is neither empty nor a comment."""
    stripped = line.strip()
    return stripped != "" and not stripped.startswith(_COMMENT)


def sums_up(cell: str) -> bool:
    """Whether a cell is a word such as Mean, Minimum."""
    return re.sub(r"[\s.:]", "", cell.lower()) in STATISTICS


def cells_of(line: str, delimiter: str | None) -> list[str]:
    """Cells of one line, stripped; quotes are honoured."""
    if '"' in line:
        plain = line.strip().replace("\t", " ") if delimiter is None else line
        try:
            rows = list(csv.reader([plain], delimiter=delimiter or " ", skipinitialspace=True))
            return [cell.strip() for cell in rows[0]] if rows else []
        except csv.Error:
            pass  # an unfinished quote: the plain split below shows the row as it is
    if delimiter is None:
        return line.split()
    return [cell.strip() for cell in line.split(delimiter)]


def line_of(cells: Sequence[str], delimiter: str) -> str:
    """The line of some cells; a cell that holds the delimiter stands in quotes."""
    written: list[str] = []
    for cell in cells:
        written.append('"' + cell.replace('"', "'") + '"' if delimiter in cell else cell)
    return delimiter.join(written)


def is_number(cell: str, decimal: str) -> bool:
    """Whether the cell is a finite decimal number with that decimal mark, perhaps in groups of three digits."""
    return _NUMBER[decimal].fullmatch(cell) is not None


def is_numeric(cell: str, delimiter: str | None = None) -> bool:
    """Whether the cell is a number with either decimal mark; a comma that stands between cells is no such mark."""
    return is_number(cell, ".") or (delimiter != "," and is_number(cell, ","))


@dataclass(frozen=True)
class Marks:
    """What stands between the cells of a row, and between the digits of a number."""

    delimiter: str | None
    decimal: str

    def cells(self, line: str) -> list[str]:
        """Cells of one line, stripped."""
        return cells_of(line, self.delimiter)

    def is_number(self, cell: str) -> bool:
        """Whether the cell is a finite number."""
        return is_number(cell, self.decimal)

    def is_filled_in(self, cell: str) -> bool:
        """Whether the cell is a number, or a word for none."""
        return is_number(cell, self.decimal) or cell.lower() in WORDS

"""How a text log writes its numbers is decided by all that the file holds: the decimal mark, and what groups thousands.

``1.500`` may be 1.5 or 1500. A number that can only be read one way decides for the whole file: ``0,5`` and ``1.500,5``
have a decimal comma, ``0.5`` and ``12345.678`` a decimal point. Where no number decides, plain whole numbers beside the
doubtful ones do: ``500`` beside ``1.500`` has no decimals, so ``1.500`` has none. What is left is asked about.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass

from erclutch.errors import LogError

#: Signs between groups of three digits besides point and comma: blanks of three kinds, and Swiss apostrophes.
BLANKS = " \u00a0\u202f'’"
_UNSEEN = "\u00ad\u200b\u200c\u200d\u200e\u200f\u2060\ufeff"  # at the edge of a cell
_SAMPLE = 1 << 18  # characters
# Signs that some locales and word processors write for a minus, in front of a number or of its power of ten.
_OTHER_MINUS = re.compile(
    r"(?:(?<![^\s,;|\"])|(?<=\d[eE]))[\u2212\u2012\u2013\ufe63\uff0d](?=[\d.,])"
)
_SIGN = r"[+-]?"
_POWER = r"(?:[eEdD][+-]?\d+)?"
_FIRST_GROUP = r"[1-9]\d{0,2}"
#: The one of point and comma that is not the decimal mark, by the decimal mark.
_OTHER = {".": ",", ",": "."}


_BY_BLANKS = rf"(?:[{BLANKS}]\d{{3}})+"
#: A whole number in groups of three digits, perhaps with decimals, by the decimal mark.
GROUPED = {
    ".": re.compile(rf"{_SIGN}{_FIRST_GROUP}(?:(?:,\d{{3}})+|{_BY_BLANKS})(?:\.\d*)?"),
    ",": re.compile(rf"{_SIGN}{_FIRST_GROUP}(?:(?:\.\d{{3}})+|{_BY_BLANKS})(?:,\d*)?"),
}


class TwoDecimalMarksError(LogError):
    """Some numbers of a file have a decimal point, and others a decimal comma."""


@dataclass(frozen=True)
class Numerals:
    """How numbers are written.

    Attributes:
        decimal: "." or ",".
        thousands: the other of the two where it groups digits, else "".
        reason: a number that shows it, for a note; "" where nothing is special.
    """

    decimal: str
    thousands: str = ""
    reason: str = ""


def is_grouped(cell: str, decimal: str) -> bool:
    """Whether a cell is a number in groups of three digits, for a decimal mark."""
    return GROUPED[decimal].fullmatch(cell) is not None


def ungrouped(cell: str, decimal: str) -> str:
    """A number as Python writes it: without groups, with a decimal point, with an e before the power of ten.

    Fortran writes ``1.0D+03``.
    """
    plain = cell.strip().strip(_UNSEEN)
    if is_grouped(plain, decimal):
        between_groups = BLANKS + _OTHER[decimal]
        plain = plain.translate(dict.fromkeys(map(ord, between_groups)))
    if decimal == ",":
        plain = plain.replace(",", ".")
    if re.fullmatch(rf"{_SIGN}(?:\d+(?:\.\d*)?|\.\d+)[dD][+-]?\d+", plain):
        plain = re.sub("[dD]", "e", plain)
    return plain


def grouped_by_blanks(body: str, delimiter: str | None) -> str | None:
    """The first number of a file that has blanks or apostrophes between its thousands, or None."""
    if delimiter is None or not any(blank in body for blank in BLANKS):
        return None
    return _search(f"{_SIGN}{_FIRST_GROUP}{_BY_BLANKS}", body, delimiter, " ")


def weigh(
    body: str,
    delimiter: str | None,
    sniffed: str,
    asked: str | None = None,
) -> Numerals:
    """The decimal mark of a file and what groups its thousands.

    Args:
        body: all rows, as text.
        delimiter: between the cells; None for white space.
        sniffed: the decimal mark under which the last rows read best.
        asked: the decimal mark that the user named.

    Raises:
        LogError: numbers of both kinds stand in the file, or none that tells.
    """
    marks = [mark for mark in ".," if mark in body and (mark != delimiter or '"' in body)]

    def grouped_by(mark: str) -> str:
        """The first number whose thousands the mark may group, or "". It takes as long as to read all rows."""
        if mark not in marks:
            return ""
        return _search(_groups(mark), body, delimiter, mark) or ""

    if asked is not None:
        other = _OTHER[asked]
        return Numerals(asked, other if grouped_by(other) else "")

    # A number in which a mark can only be the decimal one decides.
    deciding = {mark: _search(_decimals(mark), body, delimiter, mark) for mark in marks}
    with_point = deciding.get(".")
    with_comma = deciding.get(",")
    if with_point and with_comma:
        problem = f"{with_point} has a decimal point and {with_comma} a decimal comma"
        raise TwoDecimalMarksError(problem, remedy="Export the file with one decimal mark")
    if with_point or with_comma:
        decimal = "." if with_point else ","
        other = _OTHER[decimal]
        grouped = grouped_by(other)
        return Numerals(decimal, other if grouped else "", grouped)

    # None decides: whole numbers beside the doubtful ones may, or a format of three decimals.
    doubtful = {mark: number for mark in marks if (number := grouped_by(mark))}
    if not doubtful:
        return Numerals(sniffed)
    mark, number = next(iter(doubtful.items()))
    if len(doubtful) == 1 and (mark, delimiter) == (".", ","):
        return Numerals(
            "."
        )  # who groups thousands by points has decimal commas, and parts cells otherwise
    beside_whole_numbers = _beside_whole_numbers(body, delimiter, mark)
    if len(doubtful) == 1 and beside_whole_numbers is True:
        return Numerals(_OTHER[mark], mark, number)
    if len(doubtful) == 1 and mark == "." and delimiter != ";" and beside_whole_numbers is False:
        return Numerals(".")  # three decimals in each number, as fixed formats print them

    as_decimal = number.replace(mark, ".").rstrip("0").rstrip(".")
    as_whole = number.replace(mark, "")
    problem = f"{number} may be {as_decimal} or {as_whole}, and no number of the file tells"
    option = f"--decimal {mark}"
    options = f"{option} for {as_decimal}, --decimal {_OTHER[mark]} for {as_whole}"
    raise LogError(problem, remedy=f"Say which mark is the decimal one: {options}", option=option)


def with_decimal_points(text: str, delimiter: str | None) -> tuple[str, list[int]]:
    """A text some of whose columns have a decimal comma, with points there; and these columns, counted from 1.

    Where a column has numbers with both marks, or only numbers such as 1,500 that may be read in two ways, the text is
    as it was, and no column is named.

    Args:
        text: of the log.
        delimiter: between the cells; None for white space.
    """
    if delimiter == ",":
        return text, []
    decimals = {mark: re.compile(_decimals(mark)) for mark in ".,"}
    groups = {mark: re.compile(_groups(mark)) for mark in ".,"}
    sure: dict[int, set[str]] = {}  # the decimal marks that the numbers of a column have
    unsure: dict[int, set[str]] = {}  # and those of the numbers that tell nothing alone
    lines = text.splitlines(keepends=True)
    for line in lines:
        for column, cell in enumerate(line.strip("\r\n").split(delimiter)):
            number = cell.strip(' "')
            for mark in ".,":
                if mark not in number:
                    continue
                if decimals[mark].fullmatch(number):
                    sure.setdefault(column, set()).add(mark)
                elif groups[mark].fullmatch(number):
                    unsure.setdefault(column, set()).add(mark)
    for column, marks in unsure.items():
        if sure.get(column, set()) != marks:
            return text, []
    if any(len(marks) > 1 for marks in sure.values()):
        return text, []

    with_commas = [column for column, marks in sure.items() if marks == {","}]
    for place, line in enumerate(lines):
        row, end = _row_and_end(line)
        cells = row.split(delimiter)
        for column in with_commas:
            if column < len(cells):
                cells[column] = _with_a_point(cells[column])
        lines[place] = _between(delimiter).join(cells) + end
    return "".join(lines), sorted(column + 1 for column in with_commas)


def with_points_in_rows(text: str, delimiter: str | None) -> tuple[str, int]:
    """A text some of whose rows have decimal commas, with points there; and how many rows these are.

    Such a file was written under two languages, one after the other. A row of numbers such as 1,500, that may be read
    in two ways, has the mark of the rows around it. Where a row has both marks, the text is as it was, and no row is
    counted.

    Args:
        text: of the log.
        delimiter: between the cells; None for white space.
    """
    if delimiter == ",":
        return text, 0
    lines = text.splitlines(keepends=True)
    sure: list[set[str]] = []  # the decimal marks that the numbers of each row have
    unsure: list[set[str]] = []  # and those of the numbers that tell nothing alone
    decimals = {mark: re.compile(_decimals(mark)) for mark in ".,"}
    groups = {mark: re.compile(_groups(mark)) for mark in ".,"}
    for line in lines:
        row, _ = _row_and_end(line)
        numbers = [cell.strip(' "') for cell in row.split(delimiter)]
        sure.append({mark for mark in ".," if any(map(decimals[mark].fullmatch, numbers))})
        unsure.append({mark for mark in ".," if any(map(groups[mark].fullmatch, numbers))})
        for number in numbers:
            has_both_marks = "." in number and "," in number
            if has_both_marks and re.fullmatch(rf"{_SIGN}[\d.,]+", number):
                return text, 0

    before = _carried(sure)
    behind = _carried(sure[::-1])[::-1]
    count = 0
    for place, line in enumerate(lines):
        marks = sure[place] | unsure[place]
        if not marks:
            continue
        around = {before[place], behind[place]} - {""}
        is_between_two = not sure[place] and len(around) > 1
        if len(marks) > 1 or is_between_two or not marks <= (sure[place] or around):
            return text, 0
        if marks == {","}:
            row, end = _row_and_end(line)
            points = map(_with_a_point, row.split(delimiter))
            lines[place] = _between(delimiter).join(points) + end
            count += 1
    return "".join(lines), count


def _carried(marks: Sequence[set[str]]) -> list[str]:
    """For each row the mark of the last row before that has one alone; "" where none has."""
    carried: list[str] = []
    last = ""
    for own in marks:
        last = next(iter(own)) if len(own) == 1 else last
        carried.append(last)
    return carried


def _row_and_end(line: str) -> tuple[str, str]:
    """A line without its end, and that end."""
    row = line.rstrip("\r\n")
    return row, line[len(row) :]


def _between(delimiter: str | None) -> str:
    """What is written between two cells that were read by a delimiter, or by white space."""
    return " " if delimiter is None else delimiter


def _with_a_point(cell: str) -> str:
    """A number with a decimal comma as one with a decimal point, without points between its thousands; or the cell."""
    whole = rf"(?:\d*|{_FIRST_GROUP}(?:\.\d{{3}})+)"
    if not re.fullmatch(rf"{_SIGN}{whole},\d+{_POWER}", cell.strip(' "')):
        return cell
    return cell.replace(".", "").replace(",", ".")


def _decimals(mark: str) -> str:
    """Numbers in which the mark can only be the decimal one."""
    m = re.escape(mark)
    other = re.escape(_OTHER[mark])
    behind_groups = rf"{_FIRST_GROUP}(?:{other}\d{{3}})+{m}\d+"
    not_three = rf"\d{{1,3}}{m}(?:\d{{1,2}}|\d{{4,}})"
    leading = rf"(?:0\d*|\d{{4,}}|){m}\d+"
    powered = rf"\d+{m}\d+[eEdD][+-]?\d+"
    return rf"{_SIGN}(?:{behind_groups}|{powered}|(?:{not_three}|{leading}){_POWER})"


def _groups(mark: str) -> str:
    """Numbers in which the mark may group thousands."""
    m = re.escape(mark)
    return rf"{_SIGN}{_FIRST_GROUP}(?:{m}\d{{3}})+"


def _search(pattern: str, body: str, delimiter: str | None, mark: str) -> str | None:
    """The first cell that a pattern fills; a mark that is the delimiter too stands in quoted cells alone."""
    cell = rf'(?<=")(?:{pattern})(?=")'
    if mark != delimiter:
        # Without quotes, a cell stands between delimiters and ends of lines.
        edge = r"\s" if delimiter is None else rf"\r\n{re.escape(delimiter)}"
        blank = ""
        if delimiter is not None:
            blank = " *" if delimiter == "\t" else "[ \t]*"
        cell += rf"|(?:(?<=[{edge}])|^){blank}(?:{pattern}){blank}(?=[{edge}]|$)"
    match = re.search(cell, body, re.MULTILINE)
    return None if match is None else match.group().strip()


def _beside_whole_numbers(body: str, delimiter: str | None, mark: str) -> bool | None:
    """Whether the columns of the doubtful numbers hold plain whole numbers too; None where these tell nothing.

    Printed to six significant digits, 177.7780 is 177.778 and 100.0000 is 100: a format that leaves zeros at the end
    out makes whole numbers too, which have no more digits than stand before the mark of the others.
    """
    rows: list[list[str]] = []
    for line in body[:_SAMPLE].splitlines():
        if line.strip():
            rows.append([cell.strip(' "') for cell in line.split(delimiter)])
    grouped = re.compile(_groups(mark))
    width = max(map(len, rows), default=0)
    are_beside: bool | None = False
    for column in range(width):
        cells = [row[column].lstrip("+-") for row in rows if len(row) > column]
        plain = [cell for cell in cells if re.fullmatch(r"\d{1,3}", cell)]
        doubtful = [cell for cell in cells if grouped.fullmatch(cell)]
        if not plain or not doubtful:
            continue
        before_mark = {len(cell.partition(mark)[0]) for cell in doubtful}
        is_larger = max(map(len, plain)) > min(before_mark)
        ends_in_zero = any(cell.endswith("0") or cell.count(mark) > 1 for cell in doubtful)
        if is_larger or ends_in_zero or len(before_mark) > 1:
            return True
        are_beside = None
    return are_beside


def with_plain_minus(text: str) -> tuple[str, str]:
    """The text with a hyphen for each other sign that stands before a number as its minus, and a note; "" for none."""
    plain, count = _OTHER_MINUS.subn("-", text)
    note = f"{count} numbers have a minus that is no hyphen: read as negative"
    return plain, note if count else ""


def with_plain_digits(text: str) -> tuple[str, str]:
    """The text with 0 to 9 and a point for the digits and the decimal mark of other scripts, and a note; "" for none.

    Arabic and Persian numbers have marks of their own between decimals and between thousands; wide letters of Japanese
    and Chinese have wide digits and a wide point.
    """
    if not any(sign > "\x7f" and sign.isdecimal() for sign in {*text[:_SAMPLE]}):
        return text, ""
    plain: dict[int, str] = {}
    for sign in {*text}:
        if sign > "\x7f" and sign.isdecimal():
            plain[ord(sign)] = str(unicodedata.decimal(sign))
    of_script = "".join(map(chr, plain))
    text = re.sub(f"(?<=[{of_script}])\u066c(?=[{of_script}])", "", text)
    text = re.sub(f"(?<=[{of_script}])[\u066b\uff0e](?=[{of_script}])", ".", text)
    text = re.sub(f"[\u2212\uff0d](?=[{of_script}])", "-", text)
    return text.translate(plain), "digits of another script are read as 0 to 9"

"""Bytes of a text log become characters: gzip is undone, and the encoding is told from the first bytes."""

from __future__ import annotations

import gzip
import io
import re
import unicodedata
import zlib
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from erclutch.errors import LogError
from erclutch.logs.readers import first_bytes
from erclutch.logs.readers.budget import Budget
from erclutch.logs.readers.dialect import SAMPLE

_NAMES_END = 1 << 15  # characters that hold all lines above the rows
#: A cell in quotes with a line end, between two delimiters or ends of a line: a name over its unit.
_BROKEN_NAME = re.compile(r'(?<![^\t;,|\r\n])"([^"\r\n]{1,60})[\r\n]+([^"]{1,60})"(?![^\t;,|\r\n])')
_BROKEN = re.compile(r"[\r\n]*([+-]?\d[\d.]*(?:[eE][+-]?\d+)?)[\r\n]+")

_BLOCK = 1 << 20
_HEAD = 1 << 14  # characters in which the rows of a text show how they end
_FEWEST_ROWS = 3
_GZIP_COUNTS_TO = 1 << 32  # bytes of a text
# Letters of the names and units of signals.
_CHINESE = (
    "时间秒毫分位移毫米速度加转角扭矩力载荷电流电压温度阻尼"
    "活塞线圈机制动采样序号数据通道功率频率试验测量设备开始"
)
_JAPANESE = (
    "時間秒位置変速度回転数角加荷重力電流圧温トルクストーローラセンサ試験測定番号モタータ摩擦"
    "せん断ずりズリ応粘磁束密料名周波"
)
_KOREAN = "시간초전류압속도토크힘변위치각회하중모멘트온마찰력데이터측정번호"
#: Letters that are no accents of a Latin word, since they stand side by side.
_RUSSIAN = re.compile(r"[А-яЁё]{3,}")
#: Bytes beyond ASCII inside of a word of small Latin letters, and letters that words of Central Europe have there.
_INSIDE = re.compile(rb"(?<=[a-z])[\x80-\xff]+(?=[a-z])")
_POLISH = "ąćęłńóśźżĄĆĘŁŃÓŚŹŻ"
_CENTRAL = frozenset(_POLISH + "áčďéěíňřšťúůýžőűöüôľĺŕÁČĎÉĚÍŇŘŠŤÚŮÝŽŐŰÖÜ")
#: Japanese letters of half the width side by side: alone they are signs of Latin texts, such as µ and °.
_NARROW = re.compile(r"[\uff66-\uff9f]{3,}")
#: Bytes that no text holds, besides zero.
CONTROL = bytes(set(range(32)) - set(b"\t\n\r\f\v\x1a"))
#: Where Japanese begins in mail and in old instruments, and where it ends.
_ESCAPES = (b"\x1b$B", b"\x1b$@", b"\x1b(J")
_HIDDEN = re.compile(
    r"[^\S \t\r\n]|[\x00-\x08\x0e-\x1b\x7f-\x9f\xad\u200b-\u200f\u202a-\u202e\u2060-\u2069\ufeff]"
)
#: Zeros that end a word of a program at the end of its line; behind a digit a number may be cut off.
_ENDS_OF_WORDS = re.compile(rb"(?<=[A-Za-z])\0{1,8}(?=\r?\n)")
_FEW_ZEROS = 0.01  # share of the bytes
DAMAGE = "not seen: a text has no checksum (packed as .gz it has one)"


def decode(data: bytes) -> str:
    """Text of a log file: gzip undone, UTF-8 or UTF-16 (with or without mark), by `_eastern` or `_central`, or Latin-1.

    Raises:
        LogError: the bytes are no text.
    """
    if data[:2] == b"\x1f\x8b":
        budget = Budget(len(data))
        unpacked = bytearray()
        with damage_named(), gzip.GzipFile(fileobj=io.BytesIO(data)) as file:
            while block := file.read(_BLOCK):
                budget.take_text(len(block))
                unpacked += block
        data = bytes(unpacked)
    if 0 < data.count(0) < _FEW_ZEROS * len(data):  # UTF-16 has many
        data = _ENDS_OF_WORDS.sub(b"", data)
    encoding = _encoding_of(data)
    try:
        return data.decode(encoding)
    except UnicodeDecodeError:
        if encoding != "utf-8-sig":
            raise _not_text(data) from None
        return data.decode(_eastern(data) or _central(data) or "latin-1")


def _eastern(data: bytes) -> str:
    """The encoding in which text that is no UTF-8 reads as words of measuring; "" for none.

    Chinese, Japanese and Korean words are told by their letters, Russian words by letters side by side.
    """
    best = 0  # letters
    best_encoding = ""
    for encoding, letters in (
        ("gb18030", _CHINESE),
        ("shift_jis", _JAPANESE),
        ("euc_jp", _JAPANESE),
        ("cp949", _KOREAN),
    ):
        try:
            text = data.decode(encoding)
        except (UnicodeDecodeError, LookupError):
            continue  # some builds of Python come without the tables of these encodings
        if letters is _JAPANESE and _NARROW.search(text):
            text = unicodedata.normalize("NFKC", text)
        known = sum(text.count(letter) for letter in letters)
        foreign = sum(letter > "\x7f" for letter in text)
        if known > best and 2 * known > foreign:
            best = known
            best_encoding = encoding
    if best_encoding:
        return best_encoding
    with suppress(UnicodeDecodeError):
        text = data.decode("cp1251")
        in_words = sum(map(len, _RUSSIAN.findall(text)))
        if 2 * in_words > sum(letter > "\x7f" for letter in text):
            return "cp1251"
    return ""


def _central(data: bytes) -> str:
    """The encoding in which signs inside of Latin words are letters, as in Polish ones; "" where Latin-1 has letters.

    ``Obci¹¿enie`` is Obciążenie; the point of N·m is one in all of them.
    """
    inside = b"".join(_INSIDE.findall(data))
    latin = inside.decode("latin-1")
    best = 0  # Polish letters
    best_encoding = ""
    for encoding in ("cp1250", "iso8859_2"):
        try:
            data.decode(encoding)
        except UnicodeDecodeError:
            continue  # a sign elsewhere is none of this encoding
        letters = inside.decode(encoding)
        others: list[str] = []  # letters that are others in Latin-1
        were_signs = False
        for letter, sign in zip(letters, latin, strict=True):
            if letter != sign:
                others.append(letter)
                were_signs |= not sign.isalpha()
        polish = sum(letter in _POLISH for letter in others)
        if were_signs and _CENTRAL.issuperset(others) and polish > best:
            best = polish
            best_encoding = encoding
    return best_encoding


def _encoding_of(data: bytes) -> str:
    """UTF-16 where every other byte is zero or a mark says so, Japanese of 7 bits by its escapes, else UTF-8.

    Raises:
        LogError: the bytes are no text.
    """
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return "utf-16"
    even = data[0:2000:2]
    odd = data[1:2000:2]
    if len(data) > 3 and odd.count(0) > 0.8 * len(odd) and data[0]:
        return "utf-16-le"
    if len(data) > 3 and even.count(0) > 0.8 * len(even) and data[1]:
        return "utf-16-be"
    head = data[:65536]
    if head.isascii() and any(escape in head for escape in _ESCAPES):
        return "iso2022_jp"
    controls = len(head) - len(head.translate(None, CONTROL))
    if b"\0" in data or controls > 0.01 * len(head):
        raise _not_text(data)
    return "utf-8-sig"


def _not_text(data: bytes) -> LogError:
    name, remedy = first_bytes.named(data)
    return LogError(f"the file holds {name}, not text", remedy=remedy)


@contextmanager
def damage_named() -> Generator[None]:
    """Name damaged gzip data in one line.

    Raises:
        LogError: in place of what the unpacking raised.
    """
    try:
        yield
    except (gzip.BadGzipFile, EOFError, zlib.error) as error:
        problem = f"the gzip data is damaged ({error})"
        raise LogError(problem, remedy="Copy the file again") from error


@contextmanager
def opened(path: Path) -> Generator[io.TextIOWrapper]:
    """A text log as a stream of characters, gzip undone.

    Raises:
        LogError: the bytes are no text; gzip data is damaged, wherever in the stream that shows.
    """
    with path.open("rb") as file:
        packed = file.read(2) == b"\x1f\x8b"
    open_bytes: Callable[[Path], Any] = gzip.open if packed else (lambda log: log.open("rb"))
    with damage_named():
        with open_bytes(path) as stream:
            encoding = _encoding_of(stream.read(SAMPLE))
        with io.TextIOWrapper(open_bytes(path), encoding, "replace") as text:
            yield text


def text_size(path: Path) -> int:
    """Bytes of a text log, as its gzip says."""
    size = path.stat().st_size
    with path.open("rb") as file:
        if file.read(2) != b"\x1f\x8b":
            return size
        file.seek(-4, 2)
        size_in_gzip = int.from_bytes(file.read(4), "little")  # without multiples of 4 GiB
    missing = max(size - size_in_gzip, 0)  # a text is larger than its gzip
    return size_in_gzip + -(-missing // _GZIP_COUNTS_TO) * _GZIP_COUNTS_TO


def without_row_marks(text: str) -> str:
    """A text without the semicolon at the end of each row, as in a matrix of MATLAB whose cells stand between commas.

    A semicolon that stands within a row too is what cells stand between, and a lone comma may be a decimal mark.
    """
    *whole_lines, _ = text[:_HEAD].splitlines() or [""]
    rows = [line for line in whole_lines if re.match(r"[-+.]?\d", line)]
    if len(rows) < _FEWEST_ROWS:
        return text
    for row in rows:
        ends_in_mark = row.count(";") == 1 and row.rstrip().endswith(";")
        other_marks = max(row.count(","), row.count("\t"))
        if not ends_in_mark or other_marks < 2:
            return text
    bare, marks = re.subn(r";[ \t]*(?=\r?\n|\r|\Z)", "", text)
    return bare if marks == text.count(";") else text


def unbroken(text: str) -> tuple[str, int]:
    """The text without line ends inside of quoted numbers, and how many such cells there were.

    Instruments end their answers in a line end, and a writer of CSV then quotes the number with it.
    """
    parts = text.split('"')
    if len(parts) % 2 == 0:
        return text, 0  # a quote without its partner: nothing is inside for sure
    broken = 0  # cells
    for inside in range(1, len(parts), 2):
        number = _BROKEN.fullmatch(parts[inside])
        if number:
            parts[inside] = number.group(1)
            broken += 1
    return ('"'.join(parts), broken) if broken else (text, 0)


def with_whole_names(text: str) -> str:
    """The text with a blank in place of a line end inside of a name in quotes, as spreadsheets write them."""
    head = text[:_NAMES_END]
    while _BROKEN_NAME.search(head):  # a name of three lines has two line ends
        head = _BROKEN_NAME.sub(r'"\1 \2"', head)
    return head + text[_NAMES_END:]


def hidden_character(text: str) -> re.Match[str] | None:
    """The first character that no one sees: at the edge of a cell it counts for nothing."""
    data = text.encode("utf-8", "replace")
    if text.isascii() and len(data) == len(data.translate(None, CONTROL + b"\f\v\x1a\x7f")):
        return None
    return _HIDDEN.search(text)


class ToldBytes(io.BytesIO):
    """Bytes that tell how many of them were read."""

    def __init__(self, data: bytes, told: Callable[[int, int], None]) -> None:
        super().__init__(data)
        self._told = told
        self._total = len(data)
        self.interrupted = False

    def read(self, size: int | None = -1, /) -> bytes:
        """As of any bytes."""
        data = super().read(size)
        try:
            self._told(self.tell(), self._total)
        except KeyboardInterrupt:
            self.interrupted = True  # pandas makes an error of its own of it
            raise
        return data

    def read1(self, size: int | None = -1, /) -> bytes:
        """As of any bytes."""
        return self.read(size)

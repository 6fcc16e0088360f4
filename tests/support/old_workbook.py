"""A workbook of Excel 97 (.xls) is written byte by byte: no package of ours writes such files."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

_SECTOR = 512  # bytes
_END, _FAT, _FREE = 0xFFFFFFFE, 0xFFFFFFFD, 0xFFFFFFFF  # marks of the table of sectors


def write_old_workbook(path: Path, sheet: str, rows: Sequence[Sequence[str | float]]) -> Path:
    """A workbook of one sheet with texts and numbers."""
    stream = _workbook(sheet, rows)
    stream += bytes(max(4096 - len(stream), 0))  # a shorter stream stands in another place
    stream += bytes(-len(stream) % _SECTOR)
    sectors = len(stream) // _SECTOR
    assert sectors < 126, "one sector tells the places of 126 others"

    # Sector 0 holds the table of sectors, sector 1 the folder, the rest the stream.
    table = [_FAT, _END, *range(3, sectors + 2), _END]
    table += [_FREE] * (_SECTOR // 4 - len(table))
    folder = (
        _entry("Root Entry", 5, 1, _END, 0)
        + _entry("Workbook", 2, _FREE, 2, len(stream))
        + bytes(256)
    )
    head = struct.pack(
        "<8s16s5H6x", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", bytes(16), 0x3E, 3, 0xFFFE, 9, 6
    )
    head += struct.pack("<9I", 0, 1, 1, 0, 4096, _END, 0, _END, 0)
    head += struct.pack("<I", 0) + struct.pack("<108I", *[_FREE] * 108)
    path.write_bytes(head + struct.pack("<128I", *table) + folder + stream)
    return path


def _entry(name: str, kind: int, child: int, start: int, size: int) -> bytes:
    letters = name.encode("utf-16-le") + b"\0\0"
    entry = letters.ljust(64, b"\0") + struct.pack(
        "<HBB3I", len(letters), kind, 1, _FREE, _FREE, child
    )
    return entry + bytes(36) + struct.pack("<IQ", start, size)


def _record(number: int, body: bytes) -> bytes:
    return struct.pack("<HH", number, len(body)) + body


def _workbook(sheet: str, rows: Sequence[Sequence[str | float]]) -> bytes:
    begin = struct.pack("<4H2I", 0x0600, 5, 0x0DBB, 1996, 0, 6)
    name = sheet.encode("latin-1")
    globals_ = _record(0x809, begin)
    place = (
        len(globals_) + 4 + 8 + len(name) + 4
    )  # of the sheet: behind its record and the end of this part
    globals_ += _record(0x85, struct.pack("<IBBBB", place, 0, 0, len(name), 0) + name) + _record(
        0x0A, b""
    )

    cells = _record(0x809, struct.pack("<4H2I", 0x0600, 0x10, 0x0DBB, 1996, 0, 6))
    cells += _record(0x200, struct.pack("<IIHHH", 0, len(rows), 0, max(map(len, rows)), 0))
    for number, row in enumerate(rows):
        for column, value in enumerate(row):
            where = struct.pack("<3H", number, column, 0)
            if isinstance(value, str):
                text = value.encode("latin-1")
                cells += _record(0x204, where + struct.pack("<HB", len(text), 0) + text)
            else:
                cells += _record(0x203, where + struct.pack("<d", value))
    return globals_ + cells + _record(0x0A, b"")

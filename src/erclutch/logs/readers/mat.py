"""MATLAB logs of v4, v5 (save -v6, -v7) and v7.3 (HDF5) are opened in a child process: this module, run with -m."""

from __future__ import annotations

import re
from pathlib import Path
from struct import Struct

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import reader_in_child
from erclutch.logs.table import Table

HDF5 = b"\x89HDF\r\n\x1a\n"
_HEAD = Struct("<5i")  # of a matrix in v4
_NAME = re.compile(rb"[A-Za-z]\w{0,62}\0")  # a zero byte is its end
_LAST_PRECISION = 5  # double, single, and whole numbers of three kinds


def version(head: bytes) -> str | None:
    """Version, "4", "5" or "7.3", or None, from the first 520 bytes of a file.

    v5 has 0x0100 and the letters MI (in its byte order) at byte 124; v7.3 is HDF5 behind a block of 512 bytes. v4,
    which Simulink and real-time targets still write, begins with the head of its first matrix.
    """
    if head[512:520] == HDF5:
        return "7.3"
    if head[124:128] in (b"\x00\x01IM", b"\x01\x00MI"):
        return "5"
    if len(head) < _HEAD.size:
        return None

    # Five whole numbers in either byte order are kind, rows, columns, 0 or 1, and the length of a name, which follows.
    for order, machine in (("<", 0), (">", 1)):
        kind, rows, columns, imaginary, length = Struct(f"{order}5i").unpack_from(head)
        thousands, below = divmod(kind, 1000)
        precision, of_text = divmod(below, 10)
        name = head[_HEAD.size : _HEAD.size + max(length, 0)]
        sound = thousands == machine and 0 <= precision <= _LAST_PRECISION and of_text in (0, 1, 2)
        if sound and rows > 0 and columns > 0 and imaginary in (0, 1) and _NAME.fullmatch(name):
            return "4"
    return None


def find(path: str, variable: str | None) -> Table:
    """The child's work: file -> tree -> recording."""
    from erclutch.logs.readers import mat_layout, mat_tree

    with Path(path).open("rb") as file:
        kind = version(file.read(520))
    if kind is None:
        problem = "this is neither a MATLAB v4 or v5 nor a v7.3 file (wrong first bytes)"
        raise LogError(problem, remedy="Save it with save -v7, or export it as CSV")
    tree = mat_tree.load_v73(path) if kind == "7.3" else mat_tree.load_v5(path)
    return mat_layout.choose(tree, variable).table()


_DAMAGE = "seen where variables are compressed (save -v7); save -v6 and -v7.3 write no checksums"
READER = LogReader(
    (".mat",),
    lambda head: version(head) is not None,
    **reader_in_child.in_child("mat"),
    tells_damage=_DAMAGE,
)

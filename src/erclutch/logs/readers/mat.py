"""MATLAB logs of v5 (save -v6, -v7) and v7.3 (HDF5) are opened in a child process only: this module, run with -m."""

from __future__ import annotations

from pathlib import Path

from erclutch.errors import LogError
from erclutch.logs.log_reader import LogReader
from erclutch.logs.readers import found_recordings
from erclutch.logs.table import Table

HDF5 = b"\x89HDF\r\n\x1a\n"


def version(head: bytes) -> str | None:
    """Version, "5" or "7.3", or None, from the first 520 bytes of a file.

    v5 has 0x0100 and the letters MI (in its byte order) at byte 124; v7.3 is HDF5 behind a block of 512 bytes.
    """
    if head[512:520] == HDF5:
        return "7.3"
    if (head[124:126], head[126:128]) in ((b"\x00\x01", b"IM"), (b"\x01\x00", b"MI")):
        return "5"
    return None


def find(path: str, variable: str | None) -> Table:
    """The child's work: file -> tree -> recording."""
    from erclutch.logs.readers import mat_layout, mat_tree

    with Path(path).open("rb") as file:
        kind = version(file.read(520))
    if kind is None:
        problem = "this is neither a MATLAB v5 nor a v7.3 file (wrong first bytes)"
        raise LogError(problem, remedy="Save it with save -v7, or export it as CSV")
    tree = mat_tree.load_v5(path) if kind == "5" else mat_tree.load_v73(path)
    return mat_layout.choose(tree, variable).table()


def _claims(head: bytes) -> bool:
    return version(head) is not None


_DAMAGE = "seen where variables are compressed (save -v7); save -v6 and -v7.3 write no checksums"
READER = LogReader((".mat",), _claims, **found_recordings.in_child("mat"), tells_damage=_DAMAGE)

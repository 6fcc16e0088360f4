"""A report is never written over a file that is not a report."""

from __future__ import annotations

from pathlib import Path

from erclutch.errors import RunError
from erclutch.files import is_plain_file, refuse_ending, takes_files
from erclutch.files.places import is_there, release, reserve

_OURS = (b'<meta name="generator" content="erclutch">', b"/Creator (erclutch)")
_LOOK = 1_000


def may_write_report(
    path: Path,
    force: bool = False,
    endings: tuple[str, ...] = (".html", ".pdf"),
) -> None:
    """Say before any work whether a report may be written to a path; the name is then reserved.

    Raises:
        RunError: the name has another ending, the folder is missing or cannot be written, or a file is there that is no
            report of ours.
    """
    if not path.parent.is_dir():
        raise RunError(
            "its folder does not exist", where=str(path), remedy=f"Make {path.parent} first"
        )
    if not takes_files(path.parent):
        raise RunError(
            "its folder cannot be written",
            where=str(path),
            remedy="Give --out a file in another folder",
        )
    if path.is_dir():
        raise RunError("this is a folder", where=str(path), remedy="Give --out the name of a file")
    if not is_there(path):
        refuse_ending(path, endings)
    may_replace = is_plain_file if force else _is_report
    reserve(path, may_replace)
    if is_there(path) and not may_replace(path):
        release(path)
        raise RunError(
            "exists and is not a report",
            where=str(path),
            remedy="Give --out another name, or --force",
        )


def _is_report(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            head = file.read(_LOOK)
            near_the_end = max(0, path.stat().st_size - 4 * _LOOK)
            file.seek(near_the_end)
            tail = file.read()
            return any(mark in head or mark in tail for mark in _OURS)
    except OSError:
        return False

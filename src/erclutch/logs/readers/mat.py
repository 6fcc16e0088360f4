"""MATLAB logs of v5 (save -v6, -v7) and v7.3 (HDF5) are opened in a child process only.

This module is both sides. `read_mat` checks the magic bytes and starts the child. Run as a module, it is the child.
"""

from __future__ import annotations

import sys
from typing import Any

from erclutch.errors import LogError
from erclutch.logs.labels import name_columns
from erclutch.logs.log_reader import LogReader, LogSource
from erclutch.logs.readers import child_process
from erclutch.logs.table import Table
from erclutch.signals.array import Array

_LIST = "*"  # no variable is called so: the child lists the recordings
_HDF5 = b"\x89HDF\r\n\x1a\n"


def version(head: bytes) -> str | None:
    """Version, "5" or "7.3", or None, from the first 520 bytes of a file.

    v5 has 0x0100 and the letters MI (in its byte order) at byte 124; v7.3 is HDF5 behind a block of 512 bytes.
    """
    if _HDF5 in (head[:8], head[512:520]):
        return "7.3"
    if (head[124:126], head[126:128]) in ((b"\x00\x01", b"IM"), (b"\x01\x00", b"MI")):
        return "5"
    return None


def read_mat(source: LogSource) -> Table:
    """Read one recording of a MATLAB file.

    Raises:
        LogError: no MATLAB file, a damaged one, no recording in it, or several and none chosen.
    """
    kind = version(source.data[:520])
    if kind is None:
        problem = "this is neither a MATLAB v5 nor a v7.3 file (wrong first bytes)"
        raise LogError(problem, remedy="Save it with save -v7, or export it as CSV")
    arguments = kind, source.variable or ""
    arrays, texts = child_process.run("erclutch.logs.readers.mat", source.path.resolve(), *arguments)
    names, units, renamed = name_columns(
        [str(label) for label in texts["labels"]], [str(u) if u else None for u in texts["units"]]
    )
    return Table(
        name=source.name,
        columns=dict(zip(names, arrays, strict=True)),
        units=dict(zip(names, units, strict=True)),
        digest=source.digest,
        sample_period=texts["period"],
        constants={str(key): float(value) for key, value in texts["constants"].items()},
        metadata={str(key): str(value) for key, value in texts["metadata"].items()},
        notes=(*(str(note) for note in texts["notes"]), *renamed),
    )


def recordings_of_mat(source: LogSource) -> list[str]:
    """Names of the recordings of a MATLAB file.

    Raises:
        LogError: a damaged file.
    """
    kind = version(source.data[:520]) or "5"
    _, texts = child_process.run("erclutch.logs.readers.mat", source.path.resolve(), kind, _LIST)
    return [str(name) for name in texts["recordings"]]


def _read(path: str, kind: str, variable: str) -> tuple[list[Array], dict[str, Any]]:
    """The child's work: file -> tree -> recording."""
    from erclutch.logs.readers import mat_layout, mat_tree

    tree = mat_tree.load_v5(path) if kind == "5" else mat_tree.load_v73(path)
    if variable == _LIST:
        return [], {"recordings": mat_layout.recordings(tree)}
    found = mat_layout.choose(tree, variable or None)
    return list(found.columns.values()), {
        "labels": list(found.columns),
        "units": [found.units.get(label) for label in found.columns],
        "period": found.period,
        "constants": found.constants,
        "metadata": found.metadata,
        "notes": found.notes,
    }


def _claims(head: bytes) -> bool:
    return version(head) is not None


READER = LogReader((".mat",), _claims, read_mat, recordings=recordings_of_mat)

if __name__ == "__main__":
    sys.exit(child_process.serve(_read))

"""Logs are written as Parquet, CSV or MATLAB, with units and their origin inside, whole or not at all."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from erclutch.errors import RunError, placed
from erclutch.files import LOG_ENDINGS, refuse_ending, takes_files, unwritable, whole_file
from erclutch.files.spreadsheet_cells import shown_as_words
from erclutch.signals.array import Array

LabelledColumns = Sequence[tuple[str, str]]
#: Label of a log whose effort is a model's.
PREDICTED = "PREDICTED"

_BYTES_A_NUMBER = {".parquet": 9.0, ".csv": 14.0, ".mat": 9.0}


def write_log(
    path: str | Path,
    columns: LabelledColumns,
    chunks: Iterable[Array],
    about: Mapping[str, Any],
    *,
    rows: int,
    progress: Callable[[float], None] | None = None,
) -> Path:
    """Write a log that `erclutch.read` opens.

    Args:
        path: ends in .parquet, .csv or .mat.
        columns: name and unit of each column.
        chunks: stretches of rows, each of shape (n, columns).
        about: label and settings, kept inside the file as JSON.
        rows: how many rows there will be.
        progress: called with the share that is written.

    Raises:
        RunError: another ending, a folder that is missing or cannot be written, or too little space.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    with placed(str(path)):
        refuse_ending(path, LOG_ENDINGS)
        if not path.parent.is_dir():
            raise RunError("its folder does not exist", remedy=f"Make {path.parent} first")
        if not takes_files(path.parent):
            raise RunError("its folder cannot be written", remedy="Give another place")
        needed = rows * len(columns) * _BYTES_A_NUMBER[suffix]
        free = shutil.disk_usage(path.parent).free
        if needed > free:
            problem = f"about {needed / 1e6:.2g} MB are needed and {free / 1e6:.2g} MB are free"
            raise RunError(problem, remedy="Give a folder on a disk with room, or a shorter log")

    def counted() -> Iterable[Array]:
        """The chunks, and a word on each that is written."""
        done = 0
        for chunk in chunks:
            yield chunk
            done += chunk.shape[0]
            if progress is not None:
                progress(done / rows)

    with whole_file(path, partial(unwritable, problem="the log cannot be written")) as unfinished:
        _WRITERS[suffix](unfinished, columns, counted(), about)
    return path


def is_prediction(path: Path) -> bool:
    """Whether `write_log` wrote the file, and its effort is a model's."""
    from erclutch.logs.log_file import read_table
    from erclutch.logs.log_reader import LogSource
    from erclutch.logs.readers.parquet import windows_in_child

    suffix = path.suffix.lower()
    if suffix not in _WRITERS or not path.is_file():
        return False
    try:
        if suffix == ".csv":
            with path.open("rb") as file:
                head = file.read(len(PREDICTED) + 3).decode()
            return head.removeprefix("# ").removesuffix(":") == PREDICTED
        if suffix == ".parquet":
            _, _, first_row = next(windows_in_child(LogSource(path, b"", ""), 1, 0, 0, 1))
            return first_row.origin == PREDICTED
        return read_table(path).origin == PREDICTED  # in a child, within a budget
    except Exception:  # the libraries raise anything on files of others
        return False


def _parquet(
    path: Path,
    columns: LabelledColumns,
    chunks: Iterable[Array],
    about: Mapping[str, Any],
) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    fields = [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, unit in columns]
    schema = pa.schema(fields, metadata={"erclutch": json.dumps(about)})
    options: dict[str, Any] = {
        "write_page_checksum": True,
        "compression": "zstd",
        "use_byte_stream_split": True,
        "use_dictionary": False,
    }
    arrow: Any = pa  # of which the stubs know a part
    # The open file and not its name: Arrow takes no name that is not UTF-8.
    with path.open("wb") as file, pq.ParquetWriter(file, schema, **options) as writer:
        for chunk in _gathered(chunks, 60_000):
            # From their bytes: pa.array imports pandas first, which takes longer than to write 100 s of a log.
            arrays: list[Any] = []
            for column in range(len(columns)):
                values = np.ascontiguousarray(chunk[:, column], np.float64)
                buffer = arrow.py_buffer(values)
                arrays.append(arrow.Array.from_buffers(pa.float64(), len(chunk), [None, buffer]))
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))


def _gathered(chunks: Iterable[Array], size: int) -> Iterable[Array]:
    """Chunks joined to at least ``size`` rows."""
    waiting: list[Array] = []
    for chunk in chunks:
        waiting.append(chunk)
        if sum(len(part) for part in waiting) >= size:
            yield np.concatenate(waiting)
            waiting = []
    if waiting:
        yield np.concatenate(waiting)


def _csv(
    path: Path,
    columns: LabelledColumns,
    chunks: Iterable[Array],
    about: Mapping[str, Any],
) -> None:
    with path.open("w", encoding="utf-8", newline="\n") as file:
        file.write(f"# {about.get('label', 'erclutch')}: {json.dumps(about)}\n")
        labels = [f"{name} [{unit}]" if unit else name for name, unit in columns]
        file.write(",".join(map(shown_as_words, labels)) + "\n")
        for chunk in chunks:
            # Nine digits, and of a time as many as tell its rows apart: seconds since 1970 need sixteen.
            forms: list[str] = []
            for place, (name, _) in enumerate(columns):
                largest = float(np.abs(chunk[:, place]).max(initial=0.0))
                forms.append("%.16g" if name == "time" and largest >= 1e5 else "%.9g")
            np.savetxt(file, chunk, delimiter=",", fmt=forms)


def _mat(
    path: Path,
    columns: LabelledColumns,
    chunks: Iterable[Array],
    about: Mapping[str, Any],
) -> None:
    from scipy.io import savemat

    rows = np.concatenate(list(chunks))
    body: dict[str, Any] = {}
    for place, (name, _) in enumerate(columns):
        body[name] = rows[:, place : place + 1]
    texts = {"erclutch_about": json.dumps(about), "erclutch_units": json.dumps(dict(columns))}
    savemat(path, {**body, **texts}, do_compression=True, appendmat=False)


_WRITERS = {".parquet": _parquet, ".csv": _csv, ".mat": _mat}

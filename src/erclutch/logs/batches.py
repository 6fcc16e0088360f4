"""A long log stretch by stretch: each goes through the same choice of columns, units and checks as a whole one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ErclutchError, SettingError, ShortLogError
from erclutch.logs.assemble import DeviceName, Invalid, assemble_rows
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.parquet import parquet_windows
from erclutch.logs.table import Table
from erclutch.signals import Recording

#: Rows that a batch carries on either side: for filters of speeds, and for gaps at its edge.
MARGIN = 4096
_FEWEST = 10_000


@dataclass(frozen=True)
class Batch:
    """A stretch of a log, with rows on either side for whatever needs neighbours.

    Attributes:
        recording: the stretch and its margins.
        rows: which row of the file each of its rows is, counted from 0, shape (n,).
        start, stop: the rows of the file that it stands for; the others are margins.
    """

    recording: Recording
    rows: NDArray[np.int64]
    start: int
    stop: int


def parquet_batches(
    file: Path, digest: str, chosen: ColumnMap, device: DeviceName, invalid: Invalid, rows: int
) -> Iterator[Batch]:
    """The batches of a Parquet file; see `erclutch.logs.read_batches`."""
    _refuse(chosen, rows, file.name)
    period: float | None = None
    short: ShortLogError | None = None
    some = False
    for start, stop, table in parquet_windows(file, rows, MARGIN):
        try:
            recording, kept = assemble_rows(
                replace(table, digest=digest, sample_period=period), chosen, device=device, invalid=invalid
            )
        except ShortLogError as error:
            if invalid == "error":
                raise
            short = error  # all rows of the stretch are dropped: others may be left
            continue
        except ErclutchError as error:
            raise _placed(error, table, start, stop) from error
        if period is None and recording.uniform:
            period = recording.period  # one period for all stretches, wherever their stamps agree with it
        some = True
        yield Batch(_later(recording, chosen, table.first_row), kept + table.first_row, start, stop)
    if short is not None and not some:
        raise short


def _refuse(chosen: ColumnMap, rows: int, where: str) -> None:
    if rows < _FEWEST:
        raise SettingError(f"batches of {rows} rows", remedy=f"Give at least {_FEWEST}")
    stepped = [key for key, text in chosen.constants.items() if "," in text]
    if stepped:
        raise SettingError(
            f"{stepped[0]} has one number a segment, and segments are only known once the log is read",
            remedy="Give one number, or a column",
            where=where,
        )


def _placed(error: ErclutchError, table: Table, start: int, stop: int) -> ErclutchError:
    """The error with the rows of the file that it is about; those of the first stretch speak for themselves."""
    if not start:
        return error
    return type(error)(error.problem, remedy=error.remedy, where=f"{table.name}, data rows {start + 1} to {stop}")


def _later(recording: Recording, chosen: ColumnMap, first: int) -> Recording:
    """Time goes on from stretch to stretch where it is counted from the rate."""
    if chosen.rate is None or not first:
        return recording
    return replace(recording, time=recording.time + first / chosen.rate)

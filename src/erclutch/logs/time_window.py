"""A window in time is taken out of a recording."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from erclutch.errors import SettingError
from erclutch.logs.batches import Batch
from erclutch.logs.clock.timing import MINIMUM_ROWS
from erclutch.signals.recording import Recording


def within(
    log: Recording,
    begin: float | None = None,
    end: float | None = None,
    skip: float | None = None,
) -> Recording:
    """The rows of a recording with ``begin <= time <= end``, in s on its own clock; itself where all are None.

    Args:
        log: the recording.
        begin: first time that is taken.
        end: last time that is taken.
        skip: so much of the start is left out, in s since the first row; the later of both starts counts.

    Raises:
        SettingError: a negative skip, or fewer than 10 rows are left.
    """
    if begin is None and end is None and skip is None:
        return log
    first = float(log.time[0])
    last = float(log.time[-1])
    start = _start(log, begin, skip)
    stop = last if end is None else end
    kept = _kept(log, start, stop)
    rows = sum(after - row for row, after in kept)
    _require(rows, log.name, (start, stop), (first, last))
    note = f"taken from {start:.6g} s to {stop:.6g} s: {rows:,} of {log.rows:,} rows"
    return replace(log.only(kept), notes=(*log.notes, note))


def batches_within(
    batches: Iterable[Batch],
    begin: float | None = None,
    end: float | None = None,
    skip: float | None = None,
) -> Iterator[Batch]:
    """The same of a log that is read batch by batch; of a batch outside the window no row counts.

    Raises:
        SettingError: see `within`; the number of rows is known at the end.
    """
    first: float | None = None
    last = start = stop = 0.0
    rows = 0
    name = ""
    for batch in batches:
        log = batch.recording
        if first is None:
            first = float(log.time[0])
            name = log.name
            start = _start(log, begin, skip)
            stop = np.inf if end is None else end
            log = replace(log, notes=(*log.notes, f"taken from {start:.6g} s to {stop:.6g} s"))
        last = float(log.time[-1])
        kept = _kept(log, start, stop)
        if kept:
            places = np.concatenate([batch.rows[row:after] for row, after in kept])
            without_margins = (places >= batch.start) & (places < batch.stop)
            rows += int(np.count_nonzero(without_margins))
            yield replace(batch, recording=log.only(kept), rows=places)
        else:
            yield replace(batch, recording=log, rows=np.full_like(batch.rows, -1))
    if first is not None:
        _require(rows, name, (start, stop), (first, last))


def _start(log: Recording, begin: float | None, skip: float | None) -> float:
    if skip is not None and skip < 0:
        raise SettingError(
            f"--skip {skip:g} s", where=log.name, remedy="Give the time to leave out, 0 or more"
        )
    first = float(log.time[0])
    return max(first if begin is None else begin, first + (skip or 0.0))


def _kept(log: Recording, start: float, stop: float) -> list[tuple[int, int]]:
    """The segments of a recording that lie in a window, or their parts; inside a segment the time rises."""
    slack = 1e-6 * log.period  # a time that was typed is not the stamp to the last bit
    kept: list[tuple[int, int]] = []
    for row, after in log.segments:
        time = log.time[row:after]
        low = int(np.searchsorted(time, start - slack, side="left"))
        high = int(np.searchsorted(time, stop + slack, side="right"))
        if low < high:
            kept.append((row + low, row + high))
    return kept


def _require(
    rows: int,
    name: str,
    window: tuple[float, float],
    whole: tuple[float, float],
) -> None:
    if rows < MINIMUM_ROWS:
        (start, stop), (first, last) = window, whole
        until = f" and up to {stop:g} s" if stop < last else ""
        problem = f"{rows} rows lie from {start:g} s on{until}, {MINIMUM_ROWS} are needed"
        remedy = f"The log goes from {first:.6g} s to {last:.6g} s: widen --from, --until or --skip"
        raise SettingError(problem, where=name, remedy=remedy)

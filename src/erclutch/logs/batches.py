"""A long log is read stretch by stretch: each gets the same choice of columns, units and checks as a whole log."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ErclutchError, SettingError, ShortLogError
from erclutch.logs.applied import apply_rows
from erclutch.logs.dataset import Dataset, dataset_of, only_segments
from erclutch.logs.log_reader import Windows
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import Invalid, Plan
from erclutch.logs.planning import plan_of
from erclutch.signals.clock import Clock, within
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import Recording
from erclutch.signals.speed import Derivative, reach

#: Rows that a batch carries on either side: for filters of speeds, and for gaps at its edge.
MARGIN = 4096
_FEWEST = 10_000
_PLACE = "\0row"


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


def windowed_batches(
    windows: Windows,
    file: Path,
    digest: str,
    chosen: ColumnMap,
    device: DeviceName | None,
    invalid: Invalid | None,
    rows: int,
) -> Iterator[Batch]:
    """The batches of a file whose reader has windows; see `erclutch.logs.read_batches`."""
    _refuse(chosen, rows)
    plan: Plan | None = None
    period: float | None = None
    short: ShortLogError | None = None
    some = False
    for start, stop, table in windows(file, rows, MARGIN):
        table = replace(table, digest=digest, sample_period=period, path=str(file))
        try:
            plan = plan_of(table, chosen, device=device, invalid=invalid) if plan is None else plan
            recording, kept = apply_rows(plan, table)
        except ShortLogError as error:
            if (invalid or chosen.invalid) != "drop":
                raise
            short = error  # all rows of the stretch are dropped: others may be left
            continue
        except ErclutchError as error:
            if start:  # errors of the first stretch speak for themselves
                error.where = f"{table.name}, data rows {start + 1} to {stop}"
            raise
        if period is None and recording.uniform:
            period = recording.period  # one period for all stretches, wherever their stamps agree with it
        some = True
        if chosen.rate is not None and table.first_row:  # time goes on where it is counted from the rate
            recording = replace(recording, time=recording.time + table.first_row / chosen.rate)
        yield Batch(recording, kept + table.first_row, start, stop)
    if short is not None and not some:
        raise short


def _refuse(chosen: ColumnMap, rows: int) -> None:
    if rows < _FEWEST:
        raise SettingError(f"batches of {rows} rows", remedy=f"Give at least {_FEWEST}")
    stepped = [key for key, text in chosen.constants.items() if "," in text]
    if stepped:
        raise SettingError(
            f"{stepped[0]} has one number a segment, and segments are only known once the log is read",
            remedy="Give one number, or a column",
        )


def datasets(
    batches: Iterator[Batch], device: DeviceName, derivative: Derivative
) -> Iterator[tuple[Batch, Dataset | None]]:
    """Rows of each batch without its margins, speeds differentiated across its edges; None where none are left.

    Raises:
        MappingError, SettingError: see `erclutch.build_dataset`; a filter that looks further back than a margin.
    """
    for batch in batches:
        recording = _cored(batch)
        if recording is None:
            yield batch, None
            continue
        speeds = any(name in recording.signals for name in ("position", "theta", "alpha"))
        if batch.start and speeds and reach(derivative, recording.period) > MARGIN:
            raise SettingError(
                f"{derivative.name} at {derivative.cutoff:g} Hz remembers more than {MARGIN} rows",
                remedy="Give a higher --cutoff, or another --derivative",
                where=recording.name,
            )
        data = dataset_of(recording, device, derivative)
        places = data.extras[_PLACE]
        data = replace(data, extras={name: values for name, values in data.extras.items() if name != _PLACE})
        a, b = np.searchsorted(places, [batch.start, batch.stop]).tolist()
        spans = data.clock.spans
        clock = Clock(data.clock.time[a:b], within(spans, a, b), any(s.start < a < s.stop for s in spans))
        yield batch, replace(data.picked(slice(a, b)), clock=clock)


def _cored(batch: Batch) -> Recording | None:
    """The recording with each row's place in the file, without segments that lie in a margin alone."""
    log, inside = batch.recording, (batch.rows >= batch.start) & (batch.rows < batch.stop)
    cored = [(a, b) for a, b in log.segments if inside[a:b].any() and b - a > 1]
    placed = replace(log, extras={**log.extras, _PLACE: batch.rows.astype(np.float64)})
    return only_segments(placed, cored) if cored else None

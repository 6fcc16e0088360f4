"""A long log is read stretch by stretch: each gets the same choice of columns, units and checks as a whole log."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ErclutchError, LogError, SettingError, ShortLogError
from erclutch.logs.applied import apply_rows
from erclutch.logs.dataset import Dataset, dataset_of, device_of, joined
from erclutch.logs.log_file import tidied
from erclutch.logs.log_reader import LogSource, Windows
from erclutch.logs.mapping import ColumnMap
from erclutch.logs.plan import Invalid, Plan
from erclutch.logs.planning.whole_plan import plan_of
from erclutch.signals.clock import Clock, Span, within
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


def one_batch(recording: Recording) -> Batch:
    """A log that was read whole."""
    return Batch(recording, np.arange(recording.rows), 0, recording.rows)


@dataclass(frozen=True)
class RowRange:
    """Rows of a file that are read; the defaults are all.

    Attributes:
        first, stop: rows of the file, [first, stop); None is its end.
        period: sampling period in s that the rows before them have; None where nothing is known of these.
    """

    first: int = 0
    stop: int | None = None
    period: float | None = None


WHOLE_FILE = RowRange()


def windowed_batches(
    windows: Windows,
    source: LogSource,
    chosen: ColumnMap,
    device: DeviceName | None,
    invalid: Invalid | None,
    rows: int,
    part: RowRange = WHOLE_FILE,
) -> Iterator[Batch]:
    """The batches of a file whose reader has windows; see `erclutch.logs.read_batches`."""
    if rows < _FEWEST:
        raise SettingError(f"batches of {rows} rows", remedy=f"Give at least {_FEWEST}")
    stepped = [key for key, text in chosen.constants.items() if "," in text]
    if stepped:
        one_each = f"{stepped[0]} has one number a segment"
        problem = f"{one_each}, and segments are only known once the log is read"
        raise SettingError(problem, remedy="Give one number, or a column")

    # The file's first rows say what its columns are, whichever rows are read.
    plan: Plan | None = None
    of_a_block: dict[str, Any] = {"device": device, "invalid": invalid, "whole": False}
    if part.first:
        _, _, beginning = next(windows(source, rows, MARGIN, 0, None))
        plan = plan_of(replace(beginning, path=str(source.path)), chosen, **of_a_block)
    period = part.period
    short: ShortLogError | None = None
    some = False
    for start, stop, table in windows(source, rows, MARGIN, part.first, part.stop):
        if tidied(table) is not table:
            problem = "its rows must be put right before they are read on, and a log in blocks is read as it is"
            remedy = "Give a larger --memory, so that it is read whole, or a column for each signal"
            raise LogError(problem, where=table.name, remedy=remedy)
        table = replace(
            table,
            digest=source.digest,
            sample_period=period,
            path=str(source.path),
        )
        try:
            if plan is None:
                plan = plan_of(table, chosen, **of_a_block)
                plan.require_sureness()
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
        # One period for all stretches, wherever their stamps agree with it.
        if period is None and recording.uniform:
            period = recording.period
        some = True
        # Time goes on where it is counted from the rate.
        if chosen.rate is not None and table.first_row:
            recording = replace(recording, time=recording.time + table.first_row / chosen.rate)
        yield Batch(recording, kept + table.first_row, start, stop)
    if short is not None and not some:
        raise short


@dataclass(frozen=True)
class RowBlock:
    """Usable rows of a batch, without its margins.

    Attributes:
        name: of the log, with the rows of the file that the block stands for behind its start.
        data: the rows; speeds are differentiated across the edges. ``clock.joins`` says whether they go on from the
            block before.
        file_rows: which row of the file each of them is, counted from 0, shape (n,).
        recording: what the batch says of the log.
    """

    name: str
    data: Dataset
    file_rows: NDArray[np.int64]
    recording: Recording


def blocks_of(
    batches: Iterable[Batch],
    device: DeviceName | None,
    derivative: Derivative,
) -> Iterator[RowBlock]:
    """Usable rows of each batch that has any, speeds differentiated across its edges.

    Raises:
        MappingError, SettingError: see `erclutch.build_dataset`; a filter that looks further back than a margin.
    """
    for batch in batches:
        # Segments that lie in a margin alone are left out.
        log = batch.recording
        inside = (batch.rows >= batch.start) & (batch.rows < batch.stop)
        segments: list[tuple[int, int]] = []
        for start, stop in log.segments:
            if stop - start > 1 and inside[start:stop].any():
                segments.append((start, stop))
        if not segments:
            continue
        place_in_file = batch.rows.astype(np.float64)
        recording = replace(log, extras={**log.extras, _PLACE: place_in_file}).only(segments)

        has_speeds = any(name in recording.signals for name in ("position", "theta", "alpha"))
        if batch.start and has_speeds and reach(derivative, recording.period) > MARGIN:
            filtered = f"{derivative.name} at {derivative.cutoff:g} Hz"
            raise SettingError(
                f"{filtered} remembers more than {MARGIN} rows",
                remedy="Give a higher --cutoff, or another --derivative",
                where=recording.name,
            )
        data = dataset_of(recording, device or device_of(recording), derivative)
        extras = dict(data.extras)
        places = extras.pop(_PLACE)
        data = replace(data, extras=extras)
        first, last = np.searchsorted(places, [batch.start, batch.stop]).tolist()
        if first == last:
            continue
        behind = f", data rows {batch.start + 1} to {batch.stop}" if batch.start else ""
        file_rows = places[first:last].astype(np.int64)
        rows = neighbours(data, first, last)
        yield RowBlock(recording.name + behind, rows, file_rows, batch.recording)


def neighbours(data: Dataset, start: int, stop: int) -> Dataset:
    """Neighbouring rows [start, stop), lone ones too, with their clock; it says whether they go on from rows before."""
    spans = data.clock.spans
    joins = data.clock.joins
    if start > 0:
        joins = any(span.start < start < span.stop for span in spans)
    clock = Clock(data.clock.time[start:stop], within(spans, start, stop), joins)
    return replace(data.picked(slice(start, stop)), clock=clock)


def copied(data: Dataset) -> Dataset:
    """The same rows in arrays of their own: rows that were cut out of a block keep all of its rows in memory."""
    alone = data.picked(np.arange(data.rows))
    return replace(alone, clock=replace(data.clock, time=alone.clock.time))


def chained(parts: Sequence[Dataset]) -> Dataset:
    """Rows of one log that follow each other; a span that goes on over a border is one span."""
    whole = joined(parts)
    begins = {0}
    for part in parts[:-1]:
        begins.add(max(begins) + part.rows)
    goes_on: set[int] = set()  # rows in which a span goes on over a border
    for begin, part in zip(sorted(begins), parts, strict=True):
        if begin and part.clock.joins:
            goes_on.add(begin)
    spans: list[Span] = []
    for span in whole.clock.spans:
        if span.start in goes_on:
            before = spans.pop()
            period = span.period if before.period is not None else None
            spans.append(Span(before.start, span.stop, period))
        else:
            spans.append(span)
    first = parts[0]
    clock = Clock(whole.clock.time, tuple(spans), first.clock.joins)
    one_log = {
        "sources": first.sources,
        "origins": first.origins,
        "source_rows": ((0, whole.rows),),
    }
    return replace(whole, clock=clock, **one_log)

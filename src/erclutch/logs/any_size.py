"""Logs of any size become rows in memory: all rows of logs that fit, whole stretches of logs that do not.

    rows = read_rows(["day1.parquet", "day2.parquet"], Reading())
    result = erclutch.compare(rows.data)

Logs that do not fit are read once, block by block; `erclutch.runs.every_row` then scores the rows that were not kept.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from erclutch.errors import ErclutchError, LogError, MappingError, UnloggedFieldError, require
from erclutch.logs.batches import Batch, RowBlock, blocks_of, chained, neighbours, one_batch
from erclutch.logs.dataset import (
    Dataset,
    build_dataset,
    joined,
    refuse_twin,
    refuse_unlogged_fields,
    require_units,
)
from erclutch.logs.field_between_logs import require_no_plan, with_paths
from erclutch.logs.names_of_logs import names_apart
from erclutch.logs.read_logs import extent_of
from erclutch.logs.reading import Reading
from erclutch.logs.stretch_choice import STRETCH, Stretch, StretchChoice, cut
from erclutch.signals.device import DeviceName
from erclutch.signals.recording import Recording

#: Of a fit with all models, in bytes. The same on each machine, so that a log has the same rows and figures everywhere.
MEMORY = 1_500_000_000
#: Bytes that a fit with all models takes for each byte of its rows, at most; and without any row.
_FOR_EACH_BYTE, _WITHOUT_ROWS = 62, 450_000_000
_BYTES = 8  # of a number
_TASK = 4_000_000  # rows of the file after which the next gap may begin a task of its own

#: Called with what is being done, the rows of all logs that were read so far, and about how many there are.
ReadProgress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Cut:
    """A gap of a log, from which its rows can be read without those before.

    Attributes:
        file_row: row of the file behind the gap.
        place: its place among the usable rows of the log.
    """

    file_row: int
    place: int


@dataclass(frozen=True)
class LogInBlocks:
    """What is known of a log that was read block by block; a `Recording` says the same of a log in memory.

    Attributes:
        path: of the file.
        number: which recording of a file that cannot be read in blocks, counted from 0; None for all other files.
        name, digest, origin, mapping, notes: see `Recording`.
        rows: usable rows.
        segments: gapless stretches of usable rows, [start, stop).
        period, uniform: see `Recording`.
        cuts: where the rows may be divided into tasks; the first is the start.
    """

    path: Path
    number: int | None
    name: str
    digest: str
    origin: str
    mapping: tuple[str, str] | None
    notes: tuple[str, ...]
    rows: int
    segments: tuple[tuple[int, int], ...]
    period: float
    uniform: bool
    cuts: tuple[Cut, ...]

    @property
    def duration(self) -> float:
        """Recorded time in s, gaps left out."""
        return self.rows * self.period


@dataclass(frozen=True)
class RowsOfLogs:
    """Rows to fit models to, and the logs that they are of.

    Attributes:
        data: the rows that are kept, in the order of the logs.
        recordings: logs that were read whole; all of their rows are kept.
        in_blocks: logs that were read block by block, of which stretches are kept; one of both is empty.
        numbers: which of these, counted from 0, rows are kept of: one for each of the data's sources.
        places: of each kept row among the usable rows of its log, shape (n,).
    """

    data: Dataset
    recordings: tuple[Recording, ...] = ()
    in_blocks: tuple[LogInBlocks, ...] = ()
    places: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    numbers: tuple[int, ...] = ()

    @property
    def logs(self) -> Sequence[Recording | LogInBlocks]:
        """The logs of which rows are kept, one for each of the data's sources."""
        return self.recordings or [self.in_blocks[number] for number in self.numbers]

    @property
    def left_out(self) -> int:
        """Usable rows that are not kept."""
        return sum(log.rows for log in self.in_blocks) - self.places.size


def read_rows(
    paths: Sequence[str | Path],
    how: Reading,
    device: DeviceName | None = None,
    *,
    memory: float = MEMORY,
    progress: ReadProgress = lambda what, rows, total: None,
) -> RowsOfLogs:
    """Read logs of one device; all rows where a fit to all of them needs no more than so much memory.

    Args:
        paths: the logs.
        how: columns, units, filters.
        device: how signals become elements; None: as the first log says, see `erclutch.build_dataset`.
        memory: in bytes, of a fit with all models.
        progress: called as logs beyond memory are read.

    Raises:
        LogError, MappingError: a log cannot be read or understood, in any of its rows.
        SettingError: less memory than a fit needs; a rate for a log that is read in blocks.
    """
    require(2 * _WITHOUT_ROWS / 1e9, unit=" GB", memory=memory / 1e9)
    files = [Path(path) for path in paths]
    names = dict(zip(files, names_apart(files), strict=True))
    whole: dict[Path, list[Recording]] = {}
    rows = 0
    values = 0
    for path in files:
        extent = None
        with suppress(ErclutchError):  # reading it says the same with more words
            extent = None if how.variable else extent_of(path)
        if extent is None:
            logs = how.read(path, device, name=names[path])
            whole[path] = logs
            rows_of_file = sum(log.rows for log in logs)
            columns = 1 + max(len(log.signals) for log in logs)
        else:
            rows_of_file, columns = extent
        rows = rows + rows_of_file
        values = values + rows_of_file * columns
    bytes_of_values = _FOR_EACH_BYTE * _BYTES * max(values, 1)
    most = int(rows * (memory - _WITHOUT_ROWS) / bytes_of_values)
    if rows <= most or not values:
        recordings: list[Recording] = []
        for path in files:
            recordings += whole.get(path) or how.read(path, device, name=names[path])
        try:
            data = build_dataset(recordings, device=device, derivative=how.derivative)
            require_no_plan(data.notes, files)
        except UnloggedFieldError as error:
            raise with_paths(error, files) from None  # it may be the same error
        return RowsOfLogs(data, tuple(recordings))
    reader = _BlockReader(device, how, StretchChoice(rows, most), rows, progress)
    for path in files:
        if path not in whole:
            reader.read(path, names[path], None, how.batches(path, device))
        for number, recording in enumerate(whole.pop(path, ())):
            reader.read(path, recording.name, number, [one_batch(recording)])
    try:
        read = reader.rows()
        require_no_plan(read.data.notes, files)
        return read
    except UnloggedFieldError as error:
        raise with_paths(error, files) from None  # it may be the same error


class _BlockReader:
    """Reads logs block by block, one after another, and shows their stretches to a choice."""

    def __init__(
        self,
        device: DeviceName | None,
        how: Reading,
        choice: StretchChoice,
        total: int,
        progress: ReadProgress,
    ) -> None:
        self._device: DeviceName | None = device
        self._how, self._choice = how, choice
        self._total, self._progress = total, progress
        self._logs: list[LogInBlocks] = []
        self._digests: dict[str, str] = {}
        self._like: Dataset | None = None

    def read(self, path: Path, name: str, number: int | None, batches: Iterable[Batch]) -> None:
        """Read one log to its end, under this name: the file, or one of its recordings."""
        log, before = len(self._logs), sum(log.rows for log in self._logs)
        recording: Recording | None = None  # of the first block
        segments: list[tuple[int, int]] = []
        cuts = [Cut(0, 0)]
        periods: list[float] = []
        place = 0  # usable rows so far
        for block in blocks_of(batches, self._device, self._how.derivative):
            recording = recording or block.recording
            self._device = self._device or block.data.device
            self._require_alike(block)
            data = block.data
            for k, span in enumerate(data.clock.spans):
                if k == 0 and data.clock.joins and segments:
                    segments[-1] = segments[-1][0], place + span.stop
                    continue
                segments.append((place + span.start, place + span.stop))
                file_row = int(block.file_rows[span.start])
                if number is None and self._how.divisible and file_row - cuts[-1].file_row > _TASK:
                    cuts.append(Cut(file_row, place + span.start))
            for stretch in cut(log, place, data):
                self._choice.show(stretch)
            place += data.rows
            periods.append(block.recording.period)
            self._progress(f"reading {name}", before + place, self._total)
        if recording is None:
            raise LogError(
                "no row is left", where=path.name, remedy="Give a log with finite values"
            )
        refuse_twin(name, recording.digest, self._digests)
        period = float(np.median(periods))
        self._logs.append(
            LogInBlocks(
                path=path,
                number=number,
                name=name,
                digest=recording.digest,
                origin=recording.origin,
                mapping=recording.mapping,
                notes=recording.notes,
                rows=place,
                segments=tuple(segments),
                period=period,
                uniform=recording.uniform,
                cuts=tuple(cuts),
            )
        )

    def rows(self) -> RowsOfLogs:
        """The stretches that were chosen, as one data set."""
        numbers: list[int] = []
        parts: list[Dataset] = []
        places: list[NDArray[np.int64]] = []
        for number, stretches in itertools.groupby(
            self._choice.kept, key=lambda stretch: stretch.log
        ):
            data, own = _of_one_log(list(stretches))
            numbers.append(number)
            parts.append(replace(data, sources=(self._logs[number].name,)))
            places.append(own)
        refuse_unlogged_fields(parts)
        data = joined(parts)
        total = sum(log.rows for log in self._logs)
        note = (
            f"{data.rows:,} of {total:,} rows are fitted, in whole stretches: most of them even in time, some where "
            "field, slip or acceleration are rare"
        )
        return RowsOfLogs(
            data=replace(data, notes=(*data.notes, note)),
            in_blocks=tuple(self._logs),
            numbers=tuple(numbers),
            places=np.concatenate(places),
        )

    def _require_alike(self, block: RowBlock) -> None:
        like = self._like = self._like or block.data.picked(slice(0))
        require_units(block.data, like, block.name)
        if list(block.data.extras) != list(like.extras):
            there, before = (
                ", ".join(names) or "none" for names in (block.data.extras, like.extras)
            )
            problem = f"further inputs differ: {there} here, {before} before"
            raise MappingError(problem, where=block.name, remedy="Give --input for each")


def _of_one_log(stretches: Sequence[Stretch]) -> tuple[Dataset, NDArray[np.int64]]:
    """Stretches of a log as one data set, and the place of each of its rows.

    Left out are rows before the first motion of stretches that follow each other, and of the last stretch what lies
    behind a gap, where it is short: a few rows say nothing of a motion.
    """
    parts: list[Dataset] = []
    places: list[NDArray[np.int64]] = []
    for k, stretch in enumerate(stretches):
        follows = k > 0 and stretches[k - 1].stop == stretch.first
        followed = k + 1 < len(stretches) and stretches[k + 1].first == stretch.stop
        begin = 0 if follows else stretch.lead
        last = stretch.data.clock.spans[-1]
        cut_short = not followed and last.start > begin and last.stop - last.start < STRETCH // 8
        data = neighbours(stretch.data, begin, last.start if cut_short else stretch.data.rows)
        parts.append(data if follows else replace(data, clock=replace(data.clock, joins=False)))
        places.append(np.arange(stretch.first + begin, stretch.first + begin + data.rows))
    data = chained(parts)
    place = np.concatenate(places)
    neighboured = np.zeros(data.rows, np.bool_)
    for span in data.clock.spans:
        neighboured[span.start : span.stop] = span.stop - span.start > 1
    return data.take(neighboured), place[neighboured]
